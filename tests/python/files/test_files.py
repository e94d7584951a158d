"""Files are written atomically with the user's permissions; readers name damaged ones."""

import os
import pathlib
import sys

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcr._data import files
from rcr._data.files import atomic_path
from rcr.network import Network

import synthetic
from common import ended, python, refused

KILLS = pathlib.Path(__file__).parents[2] / "endurance" / "kills.py"


@pytest.mark.parametrize("name", ["ä.txt", "ü" * 127], ids=["short", "longest"])
def test_writes_bytes_and_text(tmp_path, name):
    """Files have the mode of any new file. The temporary name is not longer than names may be."""
    path = tmp_path / name
    files.write(path, "µ = 0.5\n")
    assert path.read_text(encoding="utf-8") == "µ = 0.5\n"
    files.write(path, b"\0\1")
    assert path.read_bytes() == b"\0\1" and [p.name for p in tmp_path.iterdir()] == [name]
    mask = os.umask(0)
    os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~mask
    (tmp_path / "link").symlink_to("behind")
    files.write(tmp_path / "link", "x")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "behind").read_text() == "x"


@pytest.mark.parametrize(
    "path, error",
    [("folder", IsADirectoryError), ("none/file", FileNotFoundError), ("file/below", OSError),
     ("pipe", OSError), ("x" * 300, OSError)],
)
def test_an_unwritable_path_is_reported_at_the_start(tmp_path, path, error):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(error) as raised:
        files.write(tmp_path / path, "x")
    assert str(tmp_path) in files.one_line(raised.value) and sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("path", [0, None, "", "a\0b", 1.5])
def test_no_path(path):
    refused("expected a path", files.write, path, "x")


def test_a_full_disk_loses_nothing(tmp_path):
    """A limit on file sizes acts on a writer like a full disk."""
    path = tmp_path / "kept"
    files.write(path, b"old")
    code = """
import resource, sys
from rcr._data import files
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
files.write(sys.argv[1], bytes(10**6))
"""
    assert str(path) in python(code, path, code=1).stderr.splitlines()[-1]
    assert path.read_bytes() == b"old" and [p.name for p in tmp_path.iterdir()] == ["kept"]


def test_two_writers_at_once_and_kills():
    """Files are whole and of one writer; a kill leaves one part, which the next write removes."""
    assert "25 times two SIGKILLs" in ended(sys.executable, "-W", "error", KILLS, "writes", 25).stdout


def test_hdf5_and_tables_in_memory(tmp_path):
    image = files.hdf5(lambda file: file.create_dataset("x", data=np.arange(10)))
    (tmp_path / "x.h5").write_bytes(image)
    with h5py.File(tmp_path / "x.h5") as file:
        assert file["x"][()].tolist() == list(range(10))
    assert files.table(["a", "b"], [dict(a=1, c=2), dict(b="x,y")]) == 'a,b\n1,\n,"x,y"\n'


def test_an_hdf5_file_is_read_before_its_writer_releases_the_lock(tmp_path):
    """The lock of `atomic_path` outlives the rename for a moment."""
    path = tmp_path / "network-0.1.h5"
    synthetic.random_network(10).save(path)
    with files.locked(path):
        assert len(Network.load(path).contacts["body1"]) == 10


@given(st.text(max_size=50))
def test_errors_are_one_line(text):
    assert "\n" not in files.one_line(ValueError(text)) and files.one_line(ValueError(text))


@pytest.mark.parametrize("error", [KeyError("x"), EOFError(), RuntimeError("a\nb"), TypeError("t"),
                                   MemoryError(), IndexError(1), OSError("truncated"),
                                   ValueError("v\nw")])
def test_every_error_of_a_reader_names_the_file(tmp_path, error):
    path = tmp_path / "x"
    path.touch()
    with pytest.raises(ValueError) as raised, files.reading(path, "a table"):
        raise error
    assert str(raised.value).startswith(f"{path}: ") and "\n" not in str(raised.value)


def test_missing_files_and_folders_are_os_errors(tmp_path):
    for path in (tmp_path, tmp_path / "none"):
        with pytest.raises(OSError), files.reading(path, "a table"):
            pass
    (tmp_path / "x").touch()
    with pytest.raises(KeyboardInterrupt), files.reading(tmp_path / "x", "a table"):
        raise KeyboardInterrupt  # no error of the file


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_failed_write_leaves_the_old_file_alone(tmp_path, error, monkeypatch):
    """A later one replaces it, here by a relative path."""
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(error), atomic_path(path) as partial:
        with open(partial, "w") as file:
            file.write("half")
        raise error
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["file.txt"]
    monkeypatch.chdir(tmp_path)
    with atomic_path("file.txt") as partial, open(partial, "w") as file:
        file.write("new")
    assert path.read_text() == "new" and os.listdir(tmp_path) == ["file.txt"]


def test_solve_does_without_h5py(tmp_path):
    one = dict(a=[0], b=[1], n=[[0, 1]], ra=[[0, 0]], rb=[[0, 0]], bn=[0.0], mu=[0.5], p0=[[0, 0]])
    np.savez(tmp_path / "p.npz", im=[0, 1], iI=[0, 1], vfree=[[0, 0, 0], [0, -2, 0]],
             meta=[1, 1, 2], **one)
    code = f"""
import sys
sys.modules["h5py"] = None  # as if it were not installed
import rcr
print(*rcr.solve({str(tmp_path / "p.npz")!r}).reaction[0])
"""
    assert [float(v) for v in python(code).stdout.split()] == pytest.approx([2, 0], abs=1e-3)
