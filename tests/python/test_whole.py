"""Files appear whole or not at all, readable by whom the user's umask lets; what does without h5py does."""

import os
import stat
import subprocess
import sys

import numpy as np
import pytest
from rcr.files import whole

from synthetic import packing


def mode(path):
    return stat.S_IMODE(os.stat(path).st_mode)


@pytest.mark.parametrize("mask, wanted", [(0o022, 0o644), (0o027, 0o640)])
def test_networks_have_the_permissions_of_any_file(tmp_path, mask, wanted):
    """F26: they were written with mode 0600."""
    before = os.umask(mask)
    try:
        packing(0.5).save(tmp_path / "network.h5")
    finally:
        os.umask(before)
    assert mode(tmp_path / "network.h5") == wanted


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_failed_write_leaves_the_old_file_alone(tmp_path, error):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(error), whole(path) as partial:
        with open(partial, "w") as file:
            file.write("half")
        raise error
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["file.txt"]


def test_relative_paths(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with whole("file.txt") as partial, open(partial, "w") as file:
        file.write("new")
    assert (tmp_path / "file.txt").read_text() == "new" and os.listdir(tmp_path) == ["file.txt"]


def test_solve_does_without_h5py(tmp_path):
    """F26: `import rcr` needed h5py even to solve a problem from .npz."""
    one = dict(a=[0], b=[1], n=[[0, 1]], ra=[[0, 0]], rb=[[0, 0]], bn=[0.0], mu=[0.5], p0=[[0, 0]])
    np.savez(tmp_path / "p.npz", im=[0, 1], iI=[0, 1], vfree=[[0, 0, 0], [0, -2, 0]], meta=[1, 1, 2], **one)
    code = f"""
import sys
sys.modules["h5py"] = None  # as if it were not installed
import rcr
print(*rcr.solve({str(tmp_path / "p.npz")!r}).reaction[0])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert [float(v) for v in done.stdout.split()] == pytest.approx([2, 0], abs=1e-3)
