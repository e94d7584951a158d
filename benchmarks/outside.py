"""A way out of the environment: peers are installed where the environment is not, so their programs run outside of it.

A script that is about to start itself again in the environment leaves this file running outside by `stay`; `run` then has
commands executed there. Where a script needs no re-entry, `run` executes them itself. Needs nothing but Python.
"""

import json
import os
import subprocess
import sys

_PIPES = "YADE_RCR_OUTSIDE"
_DESCRIPTORS = 20, 21  # the environment's shell scripts use the lower ones
_ends = None
CANNOT_START = 126, 127  # not there or not executable; its libraries are not there


def stay():
    """Execute here what `run` asks for later in this process, whatever program it has become by then."""
    process = subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    for end, descriptor in zip((process.stdout, process.stdin), _DESCRIPTORS):
        os.dup2(end.fileno(), descriptor, inheritable=True)
    os.environ[_PIPES] = "{},{}".format(*_DESCRIPTORS)


def run(arguments, try_here=False):
    """Output of a command, executed outside of the environment.

    Parameters
    ----------
    arguments : list of str
        The command; paths of files must be absolute.
    try_here : bool
        Execute it here, and outside only where it cannot be started here: a program may have been linked with the
        libraries of either.

    Raises
    ------
    RuntimeError
        If it cannot be started or fails, with the last line of its standard error.
    """
    outside = _PIPES in os.environ
    answer = _execute(arguments) if try_here or not outside else _ask(arguments)
    if try_here and outside and answer["code"] in CANNOT_START:
        answer = _ask(arguments)
    if answer["code"]:
        lines = answer["error"].strip().splitlines() or [f"exit code {answer['code']}"]
        raise RuntimeError(f"{arguments[0]}: {lines[-1]}")
    return answer["output"]


def _ask(arguments):
    global _ends
    if _ends is None:
        reading, writing = map(int, os.environ[_PIPES].split(","))
        _ends = os.fdopen(reading), os.fdopen(writing, "w")
    _ends[1].write(json.dumps(arguments) + "\n")
    _ends[1].flush()
    return json.loads(_ends[0].readline() or '{"code": 1, "error": "nobody answers outside of the environment", "output": ""}')


def _execute(arguments):
    try:
        done = subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    except OSError as error:
        return dict(code=CANNOT_START[0], output="", error=error.strerror)
    return dict(code=done.returncode, output=done.stdout, error=done.stderr)


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(_execute(json.loads(line))), flush=True)
