"""Exact solutions of small problems, and the first random scenes of tests/endurance/truth.py."""

import collections

import exact_solution
import loaded_scenes
import numpy as np
import pytest
import truth
from loaded_scenes import DT, G, R, grain, mass_and_inertia, wall

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")
CLOSE = 1e-7  # rounding over the least eigenvalue of a column of 300 with mass ratios of 1e4
# Scenes of all families, of which some are boosted, have heavy bodies, friction or restitution.
SEEDS = 2, 3, 8, 9, 14, 17, 21, 24, 25, 30, 33, 36, 37, 38, 42, 43, 44, 46, 49, 51, 53, 61
BRICKS = 7, 15, 31, 79, 111, 127  # courses of bricks, polygons in YADE
MASSES = 124  # seed of a frictionless packing
SEEDS_IN_YADE = 2, 3, 9, 14, 17, 24, 30, 33, 36, 38, 43, 44, 46, 51


def scene(grains, walls, friction=0.0, gravity=G, along=0):
    return dict(grains=grains, walls=walls, friction=friction, gravity=gravity, along=along)


def solved(*given, **options):
    """The problem of a scene of one island, and the island."""
    problem, _ = loaded_scenes.problem(scene(*given, **options))
    island, = exact_solution.islands(problem)
    return problem, island


def velocities(problem, island):
    p = np.zeros(problem["impulse"].shape)
    p[island.points] = island.impulse
    impulse = exact_solution.jacobian(problem).T @ p.ravel()
    return problem["free_velocity"] + problem["inverse_mass"] * impulse.reshape(-1, 3)


@pytest.mark.parametrize("count", [1, 30, 300])
def test_a_column_hands_on_its_weight(count):
    column = [grain(0, R * (2 * k + 1), mass=10.0 ** (k % 5)) for k in range(count)]
    problem, island = solved(column, [wall(1, 0, 1)])
    load = np.cumsum([mass_and_inertia(g)[0] for g in column[::-1]])[::-1] * G * DT
    below = np.where(problem["bodies"][:, 1] == count, 0, problem["bodies"][:, 1])
    assert exact_solution.unique(problem, island, island.impulse) == ("pairs", "points", "velocities")
    assert island.slim
    assert island.impulse[:, 0] == pytest.approx(load[below], rel=CLOSE)
    assert abs(velocities(problem, island)).max() < CLOSE * G * DT


def test_a_struck_row_moves_with_the_wall():
    speed, count = 0.1, 300
    row = [grain(R * (2 * k + 1), 0) for k in range(count)]
    problem, island = solved(row, [wall(0, 0, 1, v=speed)], gravity=0.0)
    assert velocities(problem, island)[:count, 0] == pytest.approx(speed, rel=CLOSE)


@pytest.mark.parametrize("speed", [1e-4, -1e-4, 10.0, -10.0])
def test_a_disc_on_a_floor_sticks_or_slides(speed):
    """A disc rolls from the speed v at 2/3 v, or loses µ g dt."""
    friction = 0.3
    problem, island = solved([grain(0, R, v=(speed, 0))], [wall(1, 0, 1, friction)], friction)
    v = velocities(problem, island)[0]
    if abs(speed) / 3 < friction * G * DT:
        assert v == pytest.approx([2 / 3 * speed, 0, -2 / 3 * speed / R], rel=CLOSE, abs=1e-15)
    else:
        lost = np.sign(speed) * friction * G * DT
        assert v == pytest.approx([speed - lost, 0, -2 * lost / R], rel=CLOSE, abs=1e-15)


def test_points_of_a_rod_share_friction_at_will():
    rods = [grain(0, R * (k + 0.5), R, 0.5) for k in range(5)]
    problem, island = solved(rods, [wall(1, 0, 1, 0.5)], 0.5)
    assert exact_solution.unique(problem, island, island.impulse) == ("pairs", "velocities")


def test_a_box_that_is_too_tight_has_several_forces():
    """A row between two walls: any force that presses all of it is a solution."""
    row = [grain(R * (2 * k + 1), R, v=(0, -1)) for k in range(5)]
    problem, island = solved(row, [wall(1, 0, 1), wall(0, 0, 1), wall(0, 10 * R, -1)])
    assert exact_solution.unique(problem, island, island.impulse) == ("velocities",)


def outcomes(check, seeds):
    """Sentences on wrong scenes by seed, and counts of all."""
    counts = collections.Counter()
    wrong = {seed: check(loaded_scenes.draw(seed), counts) for seed in seeds}
    return {seed: sentence for seed, sentence in wrong.items() if sentence}, counts


def test_converged_problems_are_right():
    wrong, counts = outcomes(truth.in_numpy, SEEDS)
    assert not wrong and counts["islands compared"] > 2 * len(SEEDS), (wrong, counts)


def test_converged_steps_of_scenes_are_right():
    wrong, counts = outcomes(truth.in_yade, SEEDS_IN_YADE)
    assert not wrong and counts["islands compared"] > 2 * len(SEEDS_IN_YADE), (wrong, counts)


def test_converged_courses_of_bricks_are_right():
    for check in truth.in_numpy, truth.in_yade:
        wrong, counts = outcomes(check, BRICKS)
        assert not wrong and counts["islands compared"] >= len(BRICKS), (wrong, counts)


def test_heavy_and_light_discs_of_a_packing_are_right():
    """Masses from 1e-3 to 70: the norms of the estimate hardly see the light discs."""
    wrong, counts = outcomes(truth.in_yade, [MASSES])
    assert not wrong and counts["islands compared"] >= 2, (wrong, counts)


def test_the_residual_alone_calls_wrong_problems_converged(monkeypatch):
    monkeypatch.setattr(truth, "SETTINGS", truth.SETTINGS | dict(accuracy=np.inf))
    wrong, _ = outcomes(truth.in_numpy, SEEDS)
    assert len(wrong) >= 3, wrong
