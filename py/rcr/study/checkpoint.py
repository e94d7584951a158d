"""Files of a biaxial test: its history, and checkpoints that continue to the same bits."""

import contextlib
import gzip
import json
import os

from yade.wrapper import Omega

from rcr import _files as files
from rcr.study.protocol import check_parameters

O = Omega()

CHECKPOINT = "checkpoint.yade.gz"
HISTORY_COLUMNS = (
    "step", "time", "strain", "sin_phi", "stress_x", "stress_y", "packing_fraction", "points",
    "iterations", "residual", "unconverged_steps", "yielded_steps",
)  # fmt: skip


def save(test, folder):
    """Write history.csv and a checkpoint: scene, parameters and history in one file."""
    state = dict(parameters=test.parameters, progress=test.progress, rows=test.rows)
    O.tags["biaxial"] = json.dumps(state, separators=(",", ":"))
    files.write(os.path.join(folder, "history.csv"), files.table(HISTORY_COLUMNS, test.rows))
    with _memory_file() as (handle, name):
        O.save(name, quiet=True)  # in memory: YADE does not end when it compresses to a full disk
        scene = handle.read()
    content = gzip.compress(scene, compresslevel=3, mtime=0)
    files.write(os.path.join(folder, CHECKPOINT), content)


def load(folder):
    """Load the scene of a folder's checkpoint; return parameters, progress and rows."""
    path = os.path.join(folder, CHECKPOINT)
    if not os.path.exists(path):
        raise FileNotFoundError(2, "is missing: nothing to resume; run without --resume", path)
    with files.reading(path, "a checkpoint of a biaxial test"), _memory_file() as (handle, name):
        with gzip.open(path) as file:
            handle.write(file.read())  # the check sum detects every flipped bit
            handle.flush()
        O.load(name, quiet=True)
        state = json.loads(O.tags["biaxial"])
        return check_parameters(**state["parameters"]), state["progress"], state["rows"]


@contextlib.contextmanager
def _memory_file():
    """Open a file in memory; yield it and its path, which YADE needs."""
    with open(os.memfd_create("scene"), "w+b") as handle:
        yield handle, f"/proc/self/fd/{handle.fileno()}"
