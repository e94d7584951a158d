#!/usr/bin/env python3
"""The pages as a site: reference from the doc strings, then Sphinx, where a warning is an error.

Run it where YADE is:  scripts/lib/run python3 docs/build.py
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
    parser.add_argument("--out", default=DOCS.parent / "build" / "site", metavar="DIR", help="folder of the site (default %(default)s)")
    options = parser.parse_args()
    lacking = [package for module, package in NEEDED.items() if not importlib.util.find_spec(module)]
    if lacking:
        sys.exit(f"build.py: {' and '.join(lacking)} not installed; on Debian: apt-get install {' '.join(lacking)} furo")
    for command in ([DOCS / "tables.py", "--check"], [DOCS / "reference.py"]):
        if subprocess.run([sys.executable, *map(str, command)]).returncode:
            sys.exit(f"build.py: {command[0].name} failed")
    site = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", f"{options.out}/.doctrees", str(DOCS), f"{options.out}"]
    if subprocess.run(site).returncode:
        sys.exit("build.py: Sphinx has warnings, see above")
    print(f"{options.out}/index.html")


if __name__ == "__main__":
    main()
