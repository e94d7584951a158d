"""Readers load a damaged file, or reject it by one ValueError of one line that names it.

Loaded data are still a valid problem, network or history: finite numbers that fit.
RCR_DAMAGE=20 takes twenty times as many variants.
"""

import os
import signal

import h5py
import numpy as np
import pytest
from rcr import problems, solve
from rcr._data import files
from rcr.network import Network
from rcr.study.runs import Run

import synthetic
from common import refused
from damage import damaged, damaged_text
from problem_files import write

TIMES = int(os.environ.get("RCR_DAMAGE", 1))
total = [0, 0]  # numbers of files read and refused


@pytest.fixture(scope="module", autouse=True)
def told(request):
    """Print these counts at the end, for scripts/check."""
    yield
    if TIMES == 1:
        return
    with request.config.pluginmanager.get_plugin("capturemanager").global_and_fixture_disabled():
        print(f"\ndamaged files: {total[0]} read, {total[1]} refused")


def survey(path, variants, read):
    count = [0, 0]
    for content in variants:
        path.write_bytes(content)
        signal.alarm(60)
        try:
            read(path)
            count[0] += 1
        except ValueError as error:
            assert str(path) in str(error) and "\n" not in str(error), str(error)
            assert len(str(error)) < 1000 + len(str(path)), str(error)
            count[1] += 1
    signal.alarm(0)
    total[:] = np.add(total, count).tolist()
    return count


@pytest.fixture
def saved(tmp_path):
    network, path = synthetic.packing(0.5, particles_=30, contacts=60), tmp_path / "network-0.1.h5"
    network.save(path)
    return path, network


def read_problem(path):
    problem = problems.load(path)
    assert np.isfinite(problem.friction).all() and (problem.friction >= 0).all()
    assert np.isfinite(problem.impulse).all()


def test_npz_problems(step, tmp_path):
    path = tmp_path / "x.npz"
    for save in (np.savez, np.savez_compressed):
        save(path, **step[0])
        read, refused = survey(path, damaged(path.read_bytes(), 200 * TIMES), read_problem)
        # Arrays have check sums; damage remains in names, dates and arrays that no reader needs.
        assert refused > 4 * read


@pytest.mark.parametrize("name", ["columns.h5", "rows.h5", "triplets.h5", "dense.dat",
                                  "blocks.dat", "columns.dat", "triplets.dat"])
def test_problems_of_others(step, tmp_path, name):
    path = write(tmp_path / name, step)
    variants = (damaged_text(path.read_text(), 60 * TIMES) if path.suffix == ".dat"
                else damaged(path.read_bytes(), 150 * TIMES))
    assert survey(path, variants, read_problem)[1] > (30 if path.suffix == ".dat" else 50)


@pytest.mark.parametrize("header", [
    "2 3 1 6 6 -5 3 3", "2 3 0 6 6 1e999", "2 1e9 0 2e9 2e9", "2 3 1 6 6 9 1e9 1e9", "inf", "nan 3",
    "2 -1 0 -2 -2", "2 3 1 6 6 9 3 3 -6 4 6",
])
def test_siconos_sizes_beyond_the_file(tmp_path, header):
    path = tmp_path / "x.dat"
    path.write_text(header.replace(" ", "\n"))
    refused("x.dat: ", problems.load, path)


def test_networks(saved):
    """Files of rcr are refused, or hold the original data: then only the seal was damaged."""
    path, network = saved

    def read_same(path):
        again = Network.load(path)
        for group in "particles", "contacts":
            one, other = getattr(network, group), getattr(again, group)
            assert all(np.array_equal(one[name], other[name]) for name in one)
        assert again.attributes["strain"] == network.attributes["strain"]

    read, refused = survey(path, damaged(path.read_bytes(), 300 * TIMES), read_same)
    assert read < 0.2 * refused  # zeros over zeros change nothing


def test_networks_that_others_have_written(saved):
    """Without a seal HDF5 and the meaning of columns show errors; the rest reads as a network."""
    path, _ = saved
    with h5py.File(path, "r+") as file:  # a change on purpose, which removes the seal
        del file.attrs["version"]  # HDF5 may search its damaged heap of words forever
        file.attrs["strain"] = 0.25
        file["contacts/type"][0] = 2
    assert files.SEAL not in path.read_bytes()
    assert Network.load(path).attributes["strain"] == 0.25

    def read(path):
        again = Network.load(path)
        assert "volume" not in again.attributes or again.stress().shape == (2, 2)
        assert all(np.isfinite(column).all() for column in again.contacts.values())

    assert survey(path, damaged(path.read_bytes(), 200 * TIMES), read)[1] > 30


def test_histories_records_and_summaries(tmp_path):
    folder = synthetic.write_run(tmp_path / "run", 0.5, particles_=30, contacts=60)
    (folder / "run.json").write_text(
        '{"program": "biaxial.py", "run": "x", "parameters": {"eta": 0.5}}')
    (folder / "summary.json").write_text('{"eta": 0.5, "missed_fraction": 0.1}')
    Run.read(folder)
    for name, most in (("history.csv", 40), ("run.json", 20), ("summary.json", 20)):
        text, read = (folder / name).read_text(), lambda path: Run.read(path.parent)
        assert survey(folder / name, damaged_text(text, most * TIMES), read)[1] > 10
        (folder / name).write_text(text)


@pytest.mark.parametrize("strange", ["folder", "none", "fifo"])
@pytest.mark.parametrize("name", ["x.npz", "x.h5", "x.dat"])
def test_no_files(tmp_path, name, strange):
    path = tmp_path / name
    if strange == "folder":
        path.mkdir()
    if strange == "fifo":
        os.mkfifo(path)
    for read in (problems.load, Network.load, solve):
        assert name in refused("", read, path, error=OSError)


@pytest.mark.parametrize("path", [None, 3, "", b"", 1.5, ["x.npz"], "a\0.npz"])
def test_no_paths(path):
    for read in (problems.load, solve, Network.load):
        refused("expected", read, path)
