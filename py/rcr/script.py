"""Parts of command-line scripts: checked options, clean stops, exit codes.

`options` and `run` serve user scripts; the other functions serve those of this project.
"""

import argparse
import contextlib
import math
import os
import pathlib
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

from rcr._data import files
from rcr._data.files import atomic_path

__all__ = ["Interrupted", "Parser", "Stop", "Stopped", "at_least", "atomic_path", "folder",
           "integer", "interruptible", "new_file", "number", "options", "run", "stoppable"]
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP  # Ctrl-C, a kill, a closed terminal
REPEAT = 0.5  # longest time between one signal to a process and to its group [s]


class _Help(argparse.ArgumentDefaultsHelpFormatter, argparse.RawDescriptionHelpFormatter):
    """Help that shows the default of an option, unless it is None or False or the text has it."""

    def _get_help_string(self, action):
        if action.default is None or action.default is False or "(default" in action.help:
            return action.help
        return super()._get_help_string(action)


class Parser(argparse.ArgumentParser):
    """An ArgumentParser without abbreviations, with one-line errors and defaults in the help."""

    def __init__(self, **keywords):
        super().__init__(allow_abbrev=False, formatter_class=_Help, **keywords)

    def error(self, message):
        if message.startswith("argument "):
            message = message.removeprefix("argument ").replace(": ", " ", 1)
        self.exit(2, f"{self.prog}: {message}\n")


def number(expected="a finite number", valid=lambda v: True, kind=float):
    """Return an option type: a finite number, float or int, for which `valid` holds."""

    def parse(text):
        try:
            value = kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text[:60]!r}: expected {expected}") from None
        if not -(2**63) <= value < 2**63 or not valid(value):
            raise argparse.ArgumentTypeError(f"{str(value)[:60]}: expected {expected}")
        return value

    return parse


strain = number("a strain 0 ≤ E < 1", lambda v: 0 <= v < 1)  # an option type


def integer(expected="a whole number below 2^63", valid=lambda v: True):
    """Return an option type: a whole number of 64 bits for which `valid` holds."""
    return number(expected, valid, int)


def at_least(least, most=2**31 - 1):
    """Return an option type: a whole number from `least` to `most`."""
    limit = f" and at most {most}" if most < 2**31 - 1 else ""
    return integer(f"at least {least}{limit}", lambda v: least <= v <= most)


THREADS = at_least(1, 1024)


def folder(text):
    """Option type: a folder that exists or can be made."""
    parent = os.path.abspath(path := _path(text))
    while not os.path.lexists(parent):
        parent = os.path.dirname(parent)
    if not os.path.isdir(parent):
        raise argparse.ArgumentTypeError(
            f"{text}: {parent} is not a folder; expected a folder for the results")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise argparse.ArgumentTypeError(
            f"{text}: the folder {parent} cannot be written; choose another")
    return path


def new_file(text):
    """Option type: a file that can be written, in an existing folder."""
    try:
        files.check_writable(path := _path(text))
    except OSError as error:
        raise argparse.ArgumentTypeError(files.one_line(error)) from None
    return path


def _path(text):
    try:
        return files.path_of("the path", text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a path") from None


def add_results(parser, what):
    """Add the options --out and --overwrite, which `rcr._data.run_folder.claim_folder` takes."""
    out = f"folder of the {what}, made if missing"
    parser.add_argument("--out", type=folder, required=True, metavar="DIR", help=out)
    overwrite = f"replace {what} that were made with other options"
    parser.add_argument("--overwrite", action="store_true", help=overwrite)


def options(doc, **more):
    """Parse the options --out DIR and --quick of an example, make the folder, return the options.

    ``out``, a pathlib.Path, is by default ``out/NAME`` for the script ``NAME.py``. The first line
    of the script's docstring `doc` is the description in --help. `more` holds further options by
    name, as dicts of keywords of ``add_argument``.
    """
    name = os.path.basename(sys.argv[0])
    parser = Parser(prog=name, description=doc.strip().splitlines()[0])
    default = os.path.join("out", os.path.splitext(name)[0])
    parser.add_argument("--out", type=folder, default=default, metavar="DIR",
                        help="folder of pictures and data")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a small scene that takes seconds")
    for option, keywords in more.items():
        parser.add_argument("--" + option.replace("_", "-"), **keywords)
    given = parser.parse_args()
    given.out = pathlib.Path(given.out)
    given.out.mkdir(parents=True, exist_ok=True)
    return given


class Stop:
    """`asked` is True after a first signal, `number` is that of the signal; see `stoppable`."""

    asked = False
    number = None


class Stopped(Exception):
    """The user has stopped the script by a signal. The message says how to continue."""

    def __init__(self, message, number=signal.SIGINT):
        super().__init__(message)
        self.number = number


class Interrupted(KeyboardInterrupt):
    """The user has ended the script by the signal `number`."""

    def __init__(self, number):
        super().__init__()
        self.number = number


@contextlib.contextmanager
def stoppable():
    """Block that yields a `Stop`: a first signal sets its `asked`, a second one raises.

    The signals are Ctrl-C, SIGTERM and SIGHUP. The second one raises `Interrupted`. Signals reach
    the main thread alone. In other threads the block has no effect.
    """
    stop = Stop()

    def ask(number):
        if stop.asked:
            raise Interrupted(number)
        stop.asked, stop.number = True, number

    with _handled(ask):
        yield stop


@contextlib.contextmanager
def _handled(handle):
    """Block in which `handle(number)` gets the signals of the main thread."""
    main = threading.current_thread() is threading.main_thread()
    handler, before = signal_handler(handle), {}
    for number in SIGNALS if main else ():
        ignored = signal.getsignal(number) == signal.SIG_IGN
        if not (ignored and number == signal.SIGHUP):  # nohup
            before[number] = signal.signal(number, handler)
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def signal_handler(handle):
    """Return a handler that calls `handle(number)`, except for a repeated signal.

    `timeout`, SLURM and terminals send a signal to a process and to its group. A signal within
    REPEAT seconds of another one counts as its repetition.
    """

    def handler(number, frame):
        global _last_signal
        now = time.monotonic()
        if now - _last_signal > REPEAT:
            _last_signal = now
            handle(number)

    return handler


_last_signal = -math.inf  # time of the last one that was handled


def interruptible(call, *arguments):
    """Return `call(*arguments)`. A signal ends the script also while the call is in compiled code.

    Python handles signals between two steps of the main thread, so another thread makes the call.
    """
    return ThreadPoolExecutor(1).submit(call, *arguments).result()


def _interrupt(number):
    raise Interrupted(number)


def run(main):
    """Call `main`, print an error on one line and end the process with the exit code.

    `main` returns the code (None: 0). After Ctrl-C, SIGTERM or SIGHUP, the code is 128 plus the
    number of the signal, as in a shell. The function avoids YADE's own exit, which loses the code.
    Within the program `yade` it returns after success, so that a session can continue.
    """
    code, message = 1, ""
    try:
        with _handled(_interrupt):
            code = main() or 0
    except SystemExit as end:
        if isinstance(end.code, (int, type(None))):  # argparse has printed its message
            code = end.code or 0
        else:
            message = end.code
    except (KeyboardInterrupt, Stopped) as error:
        code, message = 128 + getattr(error, "number", signal.SIGINT), str(error) or "stopped"
    except MemoryError:
        message = "the memory does not suffice; choose a smaller problem"
    except (ValueError, RuntimeError, OSError) as error:
        message = files.one_line(error)
    yade = sys.modules.get("yade")
    if code == 0 and getattr(getattr(yade, "runtime", None), "opts", None) is not None:
        return
    if session := sys.modules.get("rcr._yade.session"):
        session.end()
    if message:
        print(f"{os.path.basename(sys.argv[0])}: {message}", file=sys.stderr)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # a closed pipe
            stream.flush()
    # After a signal, a thread of compiled code may still run.
    os._exit(code) if yade or code > 128 else sys.exit(code)
