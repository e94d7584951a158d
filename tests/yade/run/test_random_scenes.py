"""The first random scenes of `scripts/check scenes` and `scripts/check runs`."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "endurance"))
import run_fuzzer  # noqa: E402
import scene_fuzzer  # noqa: E402


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("first", range(0, 100, 10))
def test_each_runs_within_bounds_or_is_refused(first):
    outcomes = {seed: scene_fuzzer.outcome(seed, 40) for seed in range(first, first + 10)}
    wrong = {seed: what for seed, what in outcomes.items() if what not in ("ran", "refused")}
    assert not wrong


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("first", range(0, 40, 10))
def test_steps_in_arrays_and_of_engines_give_the_same_bits(first):
    """The first scenes of tests/endurance/run_fuzzer.py."""
    found = {seed: run_fuzzer.difference(run_fuzzer.draw(seed))
             for seed in range(first, first + 10)}
    assert {what for what, _ in found.values()} == {"same"}, found
    assert sum(steps for _, steps in found.values()) > 500


def test_a_contact_that_a_step_loses_and_finds_again_keeps_its_friction():
    """It slid without friction in arrays."""
    scene = run_fuzzer.draw(807)
    assert run_fuzzer.difference({**scene, "runs": [22]})[0] == "same"
