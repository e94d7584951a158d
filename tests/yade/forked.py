"""Runs scripts in a fork of this process, which has YADE already, or in a new process."""

import os
import runpy
import signal
import sys
import tempfile
import types

from common import ended

SECONDS = 600  # only a hang takes them
SCRIPTS = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "scripts"))
YADE = """
import os, runpy, sys, yade
{}
sys.argv = sys.argv[1:]
sys.path.insert(0, os.path.dirname(sys.argv[0]))
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def run(script, *arguments):
    """Exit code, stdout and stderr of one of SCRIPTS that ends before it makes threads."""
    script = os.path.join(SCRIPTS, script)
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if child == 0:
            signal.alarm(SECONDS)
            os.dup2(output.fileno(), 1)
            os.dup2(errors.fileno(), 2)
            sys.stdout, sys.stderr = (open(number, "w", closefd=False) for number in (1, 2))
            sys.argv, sys.path = [script, *map(str, arguments)], [os.path.dirname(script),
                *sys.path]
            code = 99  # an exception of the script
            try:
                runpy.run_path(script, run_name="__main__")
                code = 0
            except BaseException:
                sys.excepthook(*sys.exc_info())
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        texts = []
        for stream in (output, errors):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
        return types.SimpleNamespace(returncode=code, stdout=texts[0], stderr=texts[1])


def command(script, *arguments, before=""):
    """Command line of a new process that imports YADE, executes `before`, and runs the script."""
    return [sys.executable, "-c", YADE.format(before), os.path.join(SCRIPTS, script),
            *map(str, arguments)]


def yade_script(script, *arguments, before="", **settings):
    """`ended` of `command`."""
    return ended(*command(script, *arguments, before=before), **settings)


def program(folder, *command, name="yade", code=0):
    return ended(name, *command, cwd=folder, code=code)
