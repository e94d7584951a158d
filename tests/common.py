"""Parts of tests: refusals, warnings, processes, waiting, stand-ins for other programs."""

import contextlib
import inspect
import json
import subprocess
import sys
import time

import numpy as np
import pytest


def refused(says, call, *arguments, error=ValueError, **options):
    """The message of the error that this call raises; it matches the pattern `says`."""
    with pytest.raises(error, match=says) as raised:
        call(*arguments, **options)
    return str(raised.value)


def warns(match, when=True):
    """Block that gives a UserWarning with this pattern; if not `when`, it gives none."""
    return pytest.warns(UserWarning, match=match) if when else contextlib.nullcontext()


def ended(*command, code=0, **settings):
    """CompletedProcess of a command, which must return this code; None allows any code."""
    settings = dict(capture_output=True, text=True, timeout=600) | settings
    done = subprocess.run(list(map(str, command)), **settings)
    assert code in (None, done.returncode), f"{done.stdout}{done.stderr}"
    return done


def python(code, /, *arguments, **settings):
    """`ended` of Python code."""
    return ended(sys.executable, "-c", code, *arguments, **settings)


def complaint(done, beside="\0"):
    """The one line on stderr of a process that failed, beside those that contain `beside`."""
    lines = [line for line in done.stderr.splitlines() if beside not in line]
    assert done.returncode > 0 and len(lines) == 1 and done.stdout == "", done.stderr + done.stdout
    return lines[0]


def wait_until(condition, limit=60):
    """Returns once the condition holds; fails after `limit` seconds, which only a hang takes."""
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.005)


def answer(path, **outcome):
    """A program that prints a line, and the outcome as JSON."""
    path.write_text(f"#!/bin/sh\necho a line of its own\necho '{json.dumps(outcome)}'\n")
    path.chmod(0o755)
    return path


def numpy_scalars(value, name=""):
    """Names of the parts of a result that print as np.float64(…), within containers and objects."""
    if isinstance(value, np.generic) or isinstance(value, np.ndarray) and value.ndim == 0:
        return [f"{name} = {value!r}"]
    if isinstance(value, dict):
        parts = [*value.items(), *((f"key {key}", key) for key in value)]
    elif isinstance(value, (list, tuple)):
        parts = zip(getattr(value, "_fields", range(len(value))), value)
    elif type(value).__module__.startswith("rcr") and hasattr(value, "__dict__"):
        parts = vars(value).items()
    else:
        parts = ()
    return [found for key, part in parts for found in numpy_scalars(part, f"{name}.{key}")]


def public_results(item, without=(), **arguments):
    """{name: public attribute, or result of the public method} of an object, except `without`.

    `arguments` are those of methods that need some, by name.
    """
    names = [name for name, _ in inspect.getmembers(type(item)) if not name.startswith("_")]
    found = {name: getattr(item, name) for name in names if name not in without}
    return {name: value(*arguments.get(name, ())) if callable(value) else value
            for name, value in found.items()}
