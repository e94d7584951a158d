"""Progress of a running biaxial test: a small file in its folder, which scripts/campaign reads.

Needs Python alone.
"""

import contextlib
import os
import pathlib
import sys

CHECKPOINT = "checkpoint.yade.gz"  # from which a stopped test continues
FILE = ".progress"


def write(folder, seconds, strain=0.0, share=0.0):
    """Write wall time, strain and share of the shear's steps; both are 0 during the compaction.

    A full disk is no error, since the progress is no result.
    """
    path = pathlib.Path(folder, FILE)
    with contextlib.suppress(OSError):  # unlike files.write, it does not wait for the disk
        path.with_suffix(".new").write_text(f"{seconds:.1f} {strain:.6f} {share:.6f}\n")
        path.with_suffix(".new").replace(path)


def read(folder):
    """Return wall time [s], strain and share of the steps, or None if the test does not run."""
    try:
        return tuple(map(float, pathlib.Path(folder, FILE).read_text().split()))
    except FileNotFoundError:
        return None


def remove(folder):
    """Remove the file at the end of the test."""
    pathlib.Path(folder, FILE).unlink(missing_ok=True)


def columns():
    """Return the width of a bar of tqdm on stderr: None, or 80 if the terminal does not know its own.

    Such a terminal, as that of `script` in a job, has the width 0, for which tqdm ignores the
    format of the bar.
    """
    return 80 if sys.stderr.isatty() and os.get_terminal_size(sys.stderr.fileno())[0] == 0 else None
