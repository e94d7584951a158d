#!/usr/bin/env python3
"""Pictures of the pages, in docs/pictures: one of each example, and that of the README's scene. Run it where YADE is.

scripts/lib/run python3 docs/pictures.py [NAME …]
"""

import pathlib
import re
import subprocess
import sys
import tempfile

from PIL import Image

DOCS = pathlib.Path(__file__).resolve().parent
ROOT = DOCS.parent
WIDE, HIGH = 900, 600  # pixels at most


def keep(picture, name):
    with Image.open(picture) as image:
        image = image.convert("RGB")
        image.thumbnail((WIDE, HIGH))
        image.quantize(128).save(DOCS / "pictures" / f"{name}.png", optimize=True)


def main():
    wanted = sys.argv[1:] or ["scene", *sorted(path.stem for path in (ROOT / "examples").glob("*.py"))]
    for name in wanted:
        with tempfile.TemporaryDirectory() as folder:
            script, options = ROOT / "examples" / f"{name}.py", ["--out", folder]
            if name == "scene":
                script, options = pathlib.Path(folder) / "scene.py", []
                script.write_text(re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1])
            subprocess.run(["yade", "-n", "-x", str(script), *options], cwd=folder, check=True)
            made = sorted(pathlib.Path(folder).glob("*.png"))
            keep(next((path for path in made if path.stem == name), made[0]), name)


if __name__ == "__main__":
    main()
