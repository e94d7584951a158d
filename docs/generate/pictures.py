#!/usr/bin/env python3
"""Make the pictures in docs/pictures: of each example, scene and grain of the README, 3D view.

scripts/lib/run python3 docs/generate/pictures.py [NAME …]
"""

import pathlib
import re
import subprocess
import sys
import tempfile

import grain
from PIL import Image
from screen import virtual_screen

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SIZE = 900, 600  # largest width and height [pixels]


def keep(picture, name):
    """Store a picture, small and with 128 colours."""
    with Image.open(picture) as image:
        image = image.convert("RGB")
        image.thumbnail(SIZE)
        image.quantize(128).save(ROOT / "docs" / "pictures" / f"{name}.png", optimize=True)


def make(name, folder):
    """Run the program of a picture in a folder."""
    run = lambda *command, **settings: subprocess.run(command, cwd=folder, check=True, **settings)
    examples = ROOT / "examples"
    if name == "view":
        with virtual_screen(folder) as environment:
            run("yade", str(HERE / "view.py"), env=environment, stdin=subprocess.DEVNULL)
    elif name == "scene":
        script = pathlib.Path(folder) / "scene.py"
        page = (ROOT / "README.md").read_text()
        script.write_text(re.search(r"```python\n(.*?)```", page, re.S)[1])
        run("yade", "-n", "-x", str(script))
    elif name == "grain":
        grain.draw(folder)
    elif name == "batch":
        files = str(examples / "batch.table"), str(examples / "batch.py")
        run("yade-batch", "-j", "4", "--log", f"{folder}/@.log", *files)
    else:
        run("yade", "-n", "-x", str(examples / f"{name}.py"), "--out", folder)


def main():
    examples = sorted(path.stem for path in (ROOT / "examples").glob("*.py"))
    for name in sys.argv[1:] or ["scene", "grain", "view", *examples]:
        with tempfile.TemporaryDirectory() as folder:
            make(name, folder)
            made = sorted(pathlib.Path(folder).rglob("*.png"))
            keep(next((path for path in made if path.stem == name), made[0]), name)


if __name__ == "__main__":
    main()
