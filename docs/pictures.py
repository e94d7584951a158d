#!/usr/bin/env python3
"""Pictures of the pages, in docs/pictures: one of each example, that of the README's scene, and YADE's 3D view. Run it where YADE is.

scripts/lib/run python3 docs/pictures.py [NAME …]
"""

import pathlib
import re
import subprocess
import sys
import tempfile

from PIL import Image
from screen import virtual_screen

DOCS = pathlib.Path(__file__).resolve().parent
ROOT = DOCS.parent
WIDE, HIGH = 900, 600  # pixels at most


def keep(picture, name):
    with Image.open(picture) as image:
        image = image.convert("RGB")
        image.thumbnail((WIDE, HIGH))
        image.quantize(128).save(DOCS / "pictures" / f"{name}.png", optimize=True)


def main():
    wanted = sys.argv[1:] or ["scene", "view", *sorted(path.stem for path in (ROOT / "examples").glob("*.py"))]
    for name in wanted:
        with tempfile.TemporaryDirectory() as folder:
            if name == "view":
                with virtual_screen(folder) as environment:
                    subprocess.run(["yade", str(DOCS / "view.py")], cwd=folder, check=True, env=environment, stdin=subprocess.DEVNULL)
            elif name == "scene":
                script = pathlib.Path(folder) / "scene.py"
                script.write_text(re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1])
                subprocess.run(["yade", "-n", "-x", str(script)], cwd=folder, check=True)
            elif name == "batch":
                subprocess.run(["yade-batch", "-j", "4", "--log", f"{folder}/@.log", str(ROOT / "examples" / "batch.table"), str(ROOT / "examples" / "batch.py")], cwd=folder, check=True)
            else:
                subprocess.run(["yade", "-n", "-x", str(ROOT / "examples" / f"{name}.py"), "--out", folder], cwd=folder, check=True)
            made = sorted(pathlib.Path(folder).rglob("*.png"))
            keep(next((path for path in made if path.stem == name), made[0]), name)


if __name__ == "__main__":
    main()
