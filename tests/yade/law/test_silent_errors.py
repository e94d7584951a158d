"""Scenes in which velocities once exploded, or rods passed through walls, without a message."""

import math

import numpy as np
import pytest
import rcr
from scenes import build, material, set_state, solver, steps, walls
from yade import O


@pytest.mark.parametrize("blocked", ["xyzXY", "yzXY", "yzXYZ", "xyzXYZ"])
@pytest.mark.parametrize("seed", range(8))
def test_partly_blocked_drives_do_not_explode(blocked, seed):
    """A grain with some blocked degrees of freedom is driven at 3 m/s into eight others."""
    rng = np.random.default_rng(seed)
    rough = material(0.5)
    grains = [rcr.particle((0.022 * (k % 3), 0.022 * (k // 3)), rng.uniform(0.007, 0.01),
                           rng.uniform(0, 0.7), rng.uniform(0, math.pi), rough) for k in range(9)]
    build(*grains, *walls(rough, x=(-0.012, 0.056), y=[-0.012]), dt=5e-4, tolerance=1e-4)
    set_state(6, blockedDOFs=blocked, vel=(3 * math.cos(seed) if "x" in blocked else 0, -3, 0))
    fastest = 0
    try:
        for _ in range(300):
            O.step()
            fastest = max(fastest, *(b.state.vel.norm() for b in O.bodies if b.state.mass > 0))
    except RuntimeError as error:
        assert "jam" in str(error) or "not converged" in str(error)
    assert fastest < 3 * (3 * math.sqrt(2) + 3)


@pytest.mark.parametrize("sense", [0, 1])
@pytest.mark.parametrize("radii", [1, 2, 3, 4])
def test_rods_do_not_pass_through_walls_unnoticed(radii, sense):
    """Fast rods at a wall end on their side of it, or the step counts as not converged."""
    rng = np.random.default_rng(radii)
    r, dt = 0.01, 1e-3
    passed = 0
    for _ in range(40):
        start = (rng.uniform(0.5, 1.5) * radii * r + r, 0)
        rod = rcr.particle(start, r, 0.9, rng.uniform(0, math.pi), material(0.3))
        build(rod, rcr.wall("x", 0, sense, material=material(0.3)), dt=dt, gravity=(0, 0, 0))
        set_state(0, vel=(-radii * r / dt, rng.uniform(-1, 1) * r / dt, 0),
                  angVel=(0, 0, rng.uniform(-1, 1) / dt))
        steps(4)
        if rod.state.pos[0] < 0:
            passed += 1
            assert solver().missedSteps > 0
    assert passed <= 2


def test_python_reads_everything_during_a_run():
    """Results, settings and observations are locked, so any thread may access them."""
    rough = material(0.5)
    grains = [rcr.particle((0.025 * (k % 6), 0.03 * (k // 6)), 0.01, 0.5, k, rough)
              for k in range(30)]
    build(*grains, rcr.wall("y", -0.02, +1, material=rough), dt=1e-4)
    engine = solver()
    engine.observe, engine.observeEvery = [30], 10
    O.run()
    reads = 0
    while reads < 100 or O.iter < 4000:
        assert O.running
        engine.solver = ("auto", "nesterov")[reads % 2]
        assert engine.solver in ("auto", "nesterov") and engine.model["bodies"] <= 31
        seconds, entries = engine.seconds, engine.observations()
        assert all(value > -1e-3 for value in seconds.values())
        assert all(entry["steps"] == 10 and set(entry["forces"]) == {30} for entry in entries)
        engine.observed()
        reads += 1
    O.pause()
    O.wait()
