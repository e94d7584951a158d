#!/usr/bin/env python3
"""Build the site of the pages by Sphinx, with the reference; warnings are errors.

Run it with YADE:  scripts/lib/run python3 docs/build.py
"""

import argparse
import importlib.util
import pathlib
import subprocess
import sys

DOCS = pathlib.Path(__file__).resolve().parent
NEEDED = dict(sphinx="python3-sphinx", myst_parser="python3-myst-parser")


def main():
    parser = argparse.ArgumentParser(prog="build.py", description=__doc__.splitlines()[0])
    parser.add_argument("--out", default=DOCS.parent / "build" / "site", metavar="DIR",
                        help="folder of the site (default %(default)s)")
    options = parser.parse_args()
    lacking = [name for module, name in NEEDED.items() if not importlib.util.find_spec(module)]
    if lacking:
        sys.exit(f"build.py: {' and '.join(lacking)} missing; "
                 f"on Debian: apt-get install {' '.join(lacking)} furo")
    generate = DOCS / "generate"
    for command in ([generate / "tables.py", "--check"], [generate / "reference.py"]):
        if subprocess.run([sys.executable, *map(str, command)]).returncode:
            sys.exit(f"build.py: {command[0].name} failed")
    site = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html",
            "-d", f"{options.out}/.doctrees", str(DOCS), f"{options.out}"]
    if subprocess.run(site).returncode:
        sys.exit("build.py: Sphinx prints warnings, see above")
    print(f"{options.out}/index.html")


if __name__ == "__main__":
    main()
