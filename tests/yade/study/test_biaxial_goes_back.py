"""A biaxial test that jams repeats a part of the shear with a smaller time step."""

import json
import re

import forked
import numpy as np
import pytest
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from run_contents import contents, different

KILLED = 9  # exit code
FAILING = """
from rcr.study.biaxial import Biaxial

failures, shear = dict({failures}), Biaxial.shear

def failing(test, *until):
    shear(test, *until)
    for strain in [s for s in failures if test.strain > s and failures[s] > 0]:
        failures[strain] -= 1
        raise RuntimeError("jam of the test")
    if test.progress["divisor"] > 1 and test.strain > {end}:
        os._exit({killed})

Biaxial.shear = failing
"""


def run(out, *arguments, failures=(), end=1, code=0):
    """Run biaxial.py; it fails a number of times beyond a strain, and is killed beyond `end`."""
    failing = FAILING.format(failures=list(failures), end=end, killed=KILLED)
    small = ["--particles", "20", "--strain", "0.04", "--networks", "4", "--iterations", "300"]
    return forked.yade_script("biaxial.py", *small, *arguments, "--out", out, before=failing,
                              code=code)


def assert_saved(out):
    """The folder has the networks of one path, and the last two states."""
    assert len(list(out.glob("network-*"))) == 4 and len(list(out.glob("state-*"))) == 2


def test_a_jam_repeats_a_part_with_a_smaller_time_step(tmp_path):
    done = run(tmp_path / "out", failures=[(0.025, 2)])
    assert done.stderr.count("the shear restarts from a strain of 0.0100") == 2
    assert "with 1/2 of the time step, since it stopped at 0.0" in done.stderr
    assert "with 1/3 of the time step" in done.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["repeated_parts"] == 1
    rows = np.genfromtxt(tmp_path / "out" / "history.csv", delimiter=",", names=True)
    strains = rows["strain"]
    assert (np.diff(strains) > 0).all() and strains[-1] == pytest.approx(0.04, abs=1e-3)
    lengths = np.diff(rows["time"]) / np.diff(rows["step"])
    stopped = max(map(float, re.findall(r"stopped at ([\d.]+)", done.stderr)))
    boundary = min(strain for strain in (0.03, 0.04) if strain > stopped - 5e-4)
    smaller = (strains[1:] > 0.01) & (strains[1:] <= boundary)
    assert_saved(tmp_path / "out")
    assert np.allclose(lengths, np.where(smaller, 1 / 3, 1) * lengths[0], rtol=1e-3)


def test_files_of_the_abandoned_part_are_removed(tmp_path):
    """With three steps a record, a smaller time step saves networks at other strains."""
    run(tmp_path / "out", "--time-step", "0.3", failures=[(0.025, 1)])
    assert_saved(tmp_path / "out")


def test_the_error_remains_if_the_smallest_time_step_fails_too(tmp_path):
    done = run(tmp_path / "out", failures=[(0.005, 100)], code=1)
    assert done.stderr.count("the shear restarts from a strain of 0.0000") == (
        PROTOCOL.most_divisor - 1)
    assert done.stderr.splitlines()[-1] == "biaxial.py: jam of the test"


def test_a_repeated_part_continues_to_the_same_bits_after_a_kill(tmp_path):
    failures = [(0.025, 1)]
    run(tmp_path / "straight", failures=failures)
    run(tmp_path / "out", failures=failures, end=0.015, code=KILLED)
    run(tmp_path / "out", "--resume")
    assert not different(contents(tmp_path / "out"), contents(tmp_path / "straight"))


def test_the_time_of_an_abandoned_part_counts(tmp_path):
    run(tmp_path / "out")
    test = Biaxial.load(tmp_path / "out")
    test.start -= 1e6
    test.parameters["threads"] = test.solver.threads = 2
    test.go_back(tmp_path / "out")
    assert test.parameters["threads"] == test.solver.threads == 2
    assert test.strain < 0.035 and test.wall_seconds > 1e6


def test_the_wall_time_counts_all_sessions(tmp_path):
    """It contains what is no step, such as the files of a test."""
    test = Biaxial.prepare(eta=0.5, particles=40)
    test.start -= 1e6
    for begun in range(1, 3):
        test.save(tmp_path)
        test = Biaxial.load(tmp_path)
        test.start -= 1e6
        assert 0 < test.wall_seconds - (begun + 1) * 1e6 < 60


@pytest.mark.slow
@pytest.mark.parametrize("eta", [0, 0.4, 0.7])
def test_small_packings_finish(eta, tmp_path):
    """100 grains up to a strain of 0.5: columns of grains lock between the platens.

    A lock lasts a strain of 0.01 to 0.02. Whether a packing has one is chance: the time step, the
    iterations and the seed change it. The share of such records is therefore that of ten packings.
    """
    records = left_out = 0
    for seed in range(1, 11):
        out = tmp_path / f"seed-{seed}"
        run(out, "--particles", 100, "--eta", eta, "--seed", seed, "--strain", 0.5,
            "--networks", 10, "--iterations", PROTOCOL.small_iterations)
        summary = json.loads((out / "summary.json").read_text())
        assert summary["strain"] == pytest.approx(0.5, abs=1e-3), seed
        assert 0.6 < summary["packing_fraction_final"] < 0.9, seed
        assert summary["max_overlap"] < 0.05, seed
        records, left_out = records + summary["records"], left_out + summary["records_left_out"]
    assert left_out < 0.03 * records
