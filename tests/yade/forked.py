"""Runs scripts in a fork of this process, which has YADE already, or in a new process."""

import multiprocessing
import os
import runpy
import sys
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


def run(capfd, script, *arguments):
    """Exit code, stdout and stderr of one of SCRIPTS that ends before it makes threads."""

    def child():
        sys.argv = [os.path.join(SCRIPTS, script), *map(str, arguments)]
        sys.path.insert(0, os.path.dirname(sys.argv[0]))
        runpy.run_path(sys.argv[0], run_name="__main__")

    process = multiprocessing.get_context("fork").Process(target=child, daemon=True)
    process.start()
    process.join(SECONDS)
    out, err = capfd.readouterr()
    return types.SimpleNamespace(returncode=process.exitcode, stdout=out, stderr=err)


def command(script, *arguments, before=""):
    """Command line of a new process that imports YADE, executes `before`, and runs the script."""
    return [sys.executable, "-c", YADE.format(before), os.path.join(SCRIPTS, script),
            *map(str, arguments)]


def yade_script(script, *arguments, before="", **settings):
    """`ended` of `command`."""
    return ended(*command(script, *arguments, before=before), **settings)


def program(folder, *command, name="yade", code=0):
    return ended(name, *command, cwd=folder, code=code)
