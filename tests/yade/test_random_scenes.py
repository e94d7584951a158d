"""Scenes drawn at random: the first of those of tests/endurance/scene_fuzzer.py, which `scripts/check scenes` goes on with."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "endurance"))
import scene_fuzzer  # noqa: E402


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("first", range(0, 100, 10))
def test_each_runs_within_bounds_or_is_refused(first):
    outcomes = {seed: scene_fuzzer.outcome(seed, 40) for seed in range(first, first + 10)}
    assert set(outcomes.values()) <= {"ran", "refused"}, {seed: what for seed, what in outcomes.items() if what not in ("ran", "refused")}
