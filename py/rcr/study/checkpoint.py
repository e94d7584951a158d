"""Files of a biaxial test: its history, and checkpoints that continue to the same bits."""

import contextlib
import gzip
import io
import json
import math
import os
import pathlib
import re
import shutil

from yade.wrapper import Omega

from rcr._data import files
from rcr.study.progress import CHECKPOINT
from rcr.study.protocol import PROTOCOL, check_parameters
from rcr.study.records import HISTORY_COLUMNS

O = Omega()

STATES = "state-*.yade.gz"  # checkpoints to which a test returns if it jams; * is the strain
KEPT_STATES = 2
NETWORKS = "network-*.h5"


def save(test, folder, state=False):
    """Write history.csv and a checkpoint, also as one of the last states if `state` is set."""
    test.progress["wall_seconds"] = test.wall_seconds
    data = dict(protocol=PROTOCOL.identity, parameters=test.parameters, progress=test.progress,
                rows=test.rows)
    O.tags["biaxial"] = json.dumps(data, separators=(",", ":"))
    files.write(os.path.join(folder, "history.csv"), files.table(HISTORY_COLUMNS, test.rows))
    with _memory_file() as (handle, name):
        O.save(name, quiet=True)  # in memory: YADE does not end when it compresses to a full disk
        content = _compressed(handle)
    if state:
        files.write(os.path.join(folder, name_at(STATES, test.strain)), content)
    files.write(os.path.join(folder, CHECKPOINT), content)
    if state:
        for path in states(folder)[:-KEPT_STATES]:
            path.unlink()


def name_at(pattern, strain):
    """Return the name of a file of `STATES` or `NETWORKS` at a strain."""
    return pattern.replace("*", f"{strain:.4f}")


def states(folder, last=math.inf):
    """Return the paths of the states in a folder up to the strain `last`, in their order."""
    paths = sorted(pathlib.Path(folder).glob(STATES))
    return [path for path in paths if not _is_later(path, last)]


def remove_later(folder, strain):
    """Remove the states and networks of an abandoned part of the shear, beyond a strain."""
    for pattern in (STATES, NETWORKS):
        for path in pathlib.Path(folder).glob(pattern):
            if _is_later(path, strain):
                path.unlink()


def _is_later(path, strain):
    """Return whether the strain in a file name is later than a strain."""
    digits = re.search(r"-(\d\.\d+)\.", path.name)[1]
    return float(digits) > strain + 0.5e-4  # rounded to four digits


def load(path):
    """Load the scene of a checkpoint; return parameters, progress and rows."""
    if not os.path.exists(path):
        raise FileNotFoundError(2, "is missing: nothing to resume; run without --resume", path)
    with files.reading(path, "a checkpoint of a biaxial test"), _memory_file() as (handle, name):
        with gzip.open(path) as file:
            shutil.copyfileobj(file, handle)  # the check sum detects every flipped bit
            handle.flush()
        try:
            O.load(name, quiet=True)
        except (MemoryError, RuntimeError) as error:  # its attributes are not those of this version
            raise ValueError("not a scene of this version of yade-rcr and YADE; resume it with the "
                             "one in run.json, or start again with --overwrite") from error
        state = json.loads(O.tags["biaxial"])
        parameters = check_parameters(**state["parameters"])
    if state.get("protocol") != PROTOCOL.identity:
        raise ValueError(f"{path}: a checkpoint of other constants than those of "
                         "rcr.study.protocol; start again with --overwrite")
    return parameters, state["progress"], state["rows"]


def _compressed(file):
    """Return the rest of a file, compressed by parts, which take less memory."""
    content = io.BytesIO()
    with gzip.GzipFile("", "wb", compresslevel=3, fileobj=content, mtime=0) as compressed:
        shutil.copyfileobj(file, compressed)
    return content.getvalue()


@contextlib.contextmanager
def _memory_file():
    """Open a file in memory; yield it and its path, which YADE needs."""
    with open(os.memfd_create("scene"), "w+b") as handle:
        yield handle, f"/proc/self/fd/{handle.fileno()}"
