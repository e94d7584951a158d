"""Puts the project on the path of a script, and starts the script again where its packages are.

Any Python may start a script, so this file needs Python alone.
"""

import importlib
import os
import sys

LIB = os.path.dirname(os.path.realpath(__file__))
ROOT = os.path.dirname(os.path.dirname(LIB))
SCRIPT = os.path.realpath(sys.argv[0])
sys.path[:0] = [os.path.join(ROOT, "py"), ROOT]


def run(module):
    """Call `main` of a benchmark; if an import fails, start in the environment.

    A server outside then runs the programs of other libraries, see benchmarks/outside.py.
    """
    try:
        main = importlib.import_module(module).main
        from rcr import script
    except ImportError as error:
        from benchmarks import outside

        reenter(error, outside.stay)
    script.run(main)


def reenter(error, before=lambda: None):
    """Start the script with its arguments again, in the environment with YADE and the packages.

    In that environment already, end with the `error` of the import in one line.
    """
    if os.environ.get("YADE_RCR_WAY"):
        sys.exit(f"{os.path.basename(SCRIPT)}: {error}")
    before()
    os.execv(os.path.join(LIB, "run"), ["run", "python3", SCRIPT, *sys.argv[1:]])
