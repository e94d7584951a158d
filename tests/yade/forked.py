"""Runs scripts in a fork of a process that has imported YADE, or in a new process."""

import multiprocessing
import os
import pathlib
import runpy
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


# The process that forks has no threads, which a fork would lose.
SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(["yade", "rcr.study.biaxial", "benchmarks.chart", "forked"])


def run(script, *arguments):
    """Exit code, stdout and stderr of one of SCRIPTS that ends before it makes threads."""
    with tempfile.TemporaryDirectory() as folder:
        outputs = [pathlib.Path(folder, name) for name in ("stdout", "stderr")]
        process = SERVER.Process(target=_child, daemon=True, args=(outputs, script, *arguments))
        process.start()
        process.join(SECONDS)
        out, err = (path.read_text() for path in outputs)
    return types.SimpleNamespace(returncode=process.exitcode, stdout=out, stderr=err)


def _child(outputs, script, *arguments):
    for number, path in enumerate(outputs, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    sys.argv = [os.path.join(SCRIPTS, script), *map(str, arguments)]
    sys.path.insert(0, os.path.dirname(sys.argv[0]))
    runpy.run_path(sys.argv[0], run_name="__main__")


def command(script, *arguments, before=""):
    """Command line of a new process that imports YADE, executes `before`, and runs the script."""
    return [sys.executable, "-c", YADE.format(before), os.path.join(SCRIPTS, script),
            *map(str, arguments)]


def yade_script(script, *arguments, before="", **settings):
    """`ended` of `command`."""
    return ended(*command(script, *arguments, before=before), **settings)


def program(folder, *command, name="yade", code=0):
    return ended(name, *command, cwd=folder, code=code)
