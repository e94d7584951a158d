"""Runs programs of other libraries, which may be installed outside the environment.

Before a script starts again in the environment, `stay` starts this file as a server outside. `run`
then sends commands to the server. In a script that was not restarted, `run` executes them directly.
Needs Python alone.
"""

import json
import os
import subprocess
import sys
import time

_PIPES = "YADE_RCR_OUTSIDE"
_DESCRIPTORS = 20, 21  # the shell scripts of the environment use lower ones
_ends = None
CANNOT_START = 126, 127  # exit codes: program missing or not executable; libraries missing


def stay():
    """Start the server; this process keeps its pipes through `exec`."""
    process = subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE)
    for end, descriptor in zip((process.stdout, process.stdin), _DESCRIPTORS):
        os.dup2(end.fileno(), descriptor, inheritable=True)
    os.environ[_PIPES] = "{},{}".format(*_DESCRIPTORS)


def pipes():
    """Descriptors of the pipes to the server."""
    return tuple(map(int, os.environ[_PIPES].split(",")))


def run(arguments, try_here=False):
    """Output of a command, executed outside the environment; its paths must be absolute.

    With `try_here`, it is executed here first, and outside if it does not start: its libraries may
    be in either place. A RuntimeError has the last line of its standard error.
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
        reading, writing = pipes()
        _ends = os.fdopen(reading), os.fdopen(writing, "w")
    name = f"{os.getpid()}-{time.monotonic_ns()}"
    print(name, json.dumps(arguments), file=_ends[1], flush=True)
    for line in _ends[0]:
        if line.startswith(name + " "):  # others answer processes that a time limit has ended
            return json.loads(line.removeprefix(name))
    return dict(code=1, error="the server outside has ended; run the script again", output="")


def _execute(arguments):
    try:
        done = subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    except OSError as error:
        return dict(code=CANNOT_START[0], output="", error=error.strerror)
    return dict(code=done.returncode, output=done.stdout, error=done.stderr)


if __name__ == "__main__":
    for line in sys.stdin:
        name, command = line.split(" ", 1)
        print(name, json.dumps(_execute(json.loads(command))), flush=True)
