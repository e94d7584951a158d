"""For scripts that any Python may start: the project's modules on the path, and the way into the environment that has the rest.

Needs nothing but Python, since nothing but Python is sure to be there.
"""

import os
import sys

SCRIPT = os.path.realpath(sys.argv[0])
LIB = os.path.dirname(os.path.realpath(__file__))
ROOT = os.path.dirname(os.path.dirname(LIB))
BENCHMARKS = os.path.join(ROOT, "benchmarks")
sys.path[:0] = [os.path.join(ROOT, "py"), ROOT]


def reenter(error, before=lambda: None):
    """Start the script with the present arguments again, in the environment; say why in one line if this is the environment.

    Parameters
    ----------
    error : ImportError
        What was missing.
    before : function
        Called if it is started again.
    """
    if os.environ.get("YADE_RCR_WAY"):
        sys.exit(f"{os.path.basename(SCRIPT)}: {error}")
    before()
    os.execv(os.path.join(LIB, "run"), ["run", "python3", SCRIPT, *sys.argv[1:]])
