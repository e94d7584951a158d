"""Parts that all scripts share: options that are checked where they are given, a stop that loses nothing, and an end in one line."""

import argparse
import contextlib
import math
import os
import signal
import sys
import threading

from rcr import _files as files

STOPPED = 130  # exit code after Ctrl-C, as a shell has it


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, the usage only when asked."""

    def error(self, message):
        if message.startswith("argument "):
            message = message.removeprefix("argument ").replace(": ", " ", 1)
        self.exit(2, f"{self.prog}: {message}\n")


def number(wanted="a finite number", fits=lambda v: True, kind=float):
    """Type of an option: a finite number in its range; the error says what is `wanted`."""

    def parse(text):
        try:
            value = kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text[:60]!r}: wanted {wanted}") from None
        if not -(2**63) <= value < 2**63 or not math.isfinite(value) or not fits(value):
            raise argparse.ArgumentTypeError(f"{str(value)[:60]}: wanted {wanted}")
        return value

    return parse


def integer(wanted="a whole number below 2^63", fits=lambda v: True):
    """The same of a whole number of 64 bits."""
    return number(wanted, fits, int)


def at_least(least, most=2**31 - 1):
    """Whole number from `least` on; of 32 bits, as the kernels count."""
    return integer(f"at least {least}" + ("" if most == 2**31 - 1 else f" and at most {most}"), lambda v: least <= v <= most)


THREADS = at_least(1, 1024)  # more than any machine that is served has processors


def folder(text):
    """Type of an option: a folder that is there or can be made."""
    path = _path(text)
    parent = os.path.abspath(path)
    while not os.path.lexists(parent):
        parent = os.path.dirname(parent)
    if not os.path.isdir(parent):
        raise argparse.ArgumentTypeError(f"{text}: {parent} is no folder; wanted a folder for the results")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise argparse.ArgumentTypeError(f"{text}: the folder {parent} cannot be written; choose another")
    return path


def new_file(text):
    """Type of an option: a file that can be written, in a folder that is there."""
    path = _path(text)
    try:
        files.check_writable(path)
    except OSError as error:
        raise argparse.ArgumentTypeError(files.one_line(error)) from None
    return path


def add_results(parser, what, required=True):
    """The options --out, a folder, and --overwrite, as `rcr._results.claim_folder` wants them."""
    parser.add_argument("--out", type=folder, required=required, metavar="DIR", help=f"folder of the {what}, made if missing")
    parser.add_argument("--overwrite", action="store_true", help=f"remove {what} of other options that are there")


def add_window(parser):
    """The options --from-strain and --to-strain: which snapshots of a test are of its critical state, as `rcr.study.runs.Run.read` wants them."""
    strain = number("a strain 0 ≤ E < 1", lambda v: 0 <= v < 1)
    parser.add_argument("--from-strain", type=strain, metavar="E", help="start of the critical state (default: half of where it ends)")
    parser.add_argument("--to-strain", type=strain, metavar="E", help="its end (default: each test's last strain)")


def options(doc, **more):
    """Options --out DIR and --quick of an example, from the doc string of its script; the folder is made.

    Parameters
    ----------
    doc : str
        Its first line is the description that --help prints.
    **more : dict
        Further options by their names: what ``add_argument`` takes.

    Returns
    -------
    argparse.Namespace
        ``out``, by default a folder of the script's name in the current one, ``quick``, and the others.
    """
    name = os.path.basename(sys.argv[0])
    parser = Parser(prog=name, description=doc.strip().splitlines()[0])
    parser.add_argument("--out", type=folder, default=os.path.splitext(name)[0], metavar="DIR", help="folder of pictures and data (default %(default)s)")
    parser.add_argument("--quick", action="store_true", help="a small scene, in a few seconds")
    for option, keywords in more.items():
        parser.add_argument("--" + option.replace("_", "-"), **keywords)
    given = parser.parse_args()
    os.makedirs(given.out, exist_ok=True)
    return given


def _path(text):
    try:
        return files.path_of("the path", text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: wanted a path") from None


class Stop:
    """Whether the user has asked for the end, by Ctrl-C or SIGTERM, while `stoppable` is on."""

    asked = False


@contextlib.contextmanager
def stoppable():
    """Block in which a first Ctrl-C or SIGTERM only sets `asked` of what it yields; a second one ends the block where it is. Other threads than the
    main one hear of neither."""
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def ask(number, frame):
        if stop.asked:
            raise KeyboardInterrupt
        stop.asked = True

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Stopped(Exception):
    """The script ends because the user asked for it; the message says how to go on."""


def run(main):
    """Call `main` and end the process with its exit code (None: 0), after one line on stderr where it did not come to its end.

    YADE's own end forgets the code, and an end of Python with YADE imported may: both are left out, except that YADE's program
    goes on after a script without errors, to its prompt where one is wanted.
    """
    name = os.path.basename(sys.argv[0])
    try:
        code, message = main() or 0, ""
    except SystemExit as end:  # of argparse, or with a line of ours
        code, message = (end.code or 0, "") if isinstance(end.code, (int, type(None))) else (1, f"{name}: {end.code}")
    except (KeyboardInterrupt, Stopped) as error:
        code, message = STOPPED, f"{name}: {error if str(error) else 'stopped'}"
    except MemoryError:
        code, message = 1, f"{name}: the memory does not suffice; choose something smaller"
    except (ValueError, RuntimeError, OSError) as error:
        code, message = 1, f"{name}: {files.one_line(error)}"
    if message:
        print(message, file=sys.stderr)
    _end(code)


def _end(code):
    yade = sys.modules.get("yade")
    if code == 0 and getattr(getattr(yade, "runtime", None), "opts", None) is not None:
        return
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # a pipe that nobody reads any more
            stream.flush()
    os._exit(code) if yade else sys.exit(code)
