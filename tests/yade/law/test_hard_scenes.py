"""Hard scenes keep their bounds at default settings and are stable at ten times the time step.

docs/measurements/hard-scenes.md describes the scenes. S20 is test_same_bits.py.
"""

import pytest
from benchmarks import hard_scenes
from benchmarks.hard_scenes import COARSE, SCENES
from common import warns

SLOW = ("s01_grain_on_pile", "s03_cold_box", "s04_together", "s10_shuffled", "s19_pyramid",
        "s19_disc_pyramid", "s19_tall_stack", "s04_mass_ratio", "s29_house")
SHORTENED = dict(s18_creep=10.0, s19_tall_stack=3.0, s27_square_stack=3.0)  # seconds of simulated time
# Known failures; the page has their figures. Update both when a test of these fails.
FAILS = {"s19_disc_pyramid": "rest and collapse both satisfy the laws, and ours collapses"}
# Scenes that drift at ten times the time step, as the page explains.
DRIFTS = "s06_overlap_heals", "s08_joints", "s11_painleve", "s19_disc_pyramid"


def parameters(fails):
    marks = {name: [pytest.mark.slow] if name in SLOW else [] for name in sorted(SCENES)}
    for name, reason in fails.items():
        marks[name].append(pytest.mark.xfail(reason=reason, strict=True))
    return [pytest.param(name, marks=of) for name, of in marks.items()]


def run(name, **how):
    shortened = dict(seconds=SHORTENED[name]) if name in SHORTENED else {}
    with warns("bodies #1 and #2 overlap", when=name.startswith("s06_")):
        return hard_scenes.run(name, **how, **shortened)


@pytest.mark.parametrize("name", parameters(FAILS))
def test_scene_keeps_its_bound(name):
    result, scene = run(name), SCENES[name]
    assert result.measured <= scene.BOUND, f"{scene.PREDICATE}: {result}"
    assert result.stable, f"energy out of nothing, or tunnelling: {result}"


@pytest.mark.parametrize("name", parameters(fails={}))
def test_scene_is_stable_at_ten_time_steps(name):
    result, scene = run(name, dt=COARSE), SCENES[name]
    assert result.stable, f"energy out of nothing, or tunnelling: {result}"
    assert (result.measured <= scene.BOUND) != (name in DRIFTS), f"{scene.PREDICATE}: {result}"
