"""Steps in arrays equal steps of engines while engines and scripts act on bodies.

Engines move fast obstacles or load grains; PyRunners change engines, velocities and masks.
"""

import numpy as np
import pytest
import rcr
from scenes import box, build, insert, material, solver
from test_arrays import SOLVER, after, grains, run_each, same, walls
from yade import O
from yade.minieigenHP import Vector3
from yade.wrapper import (ForceEngine, ForceResetter, HarmonicMotionEngine, LinearDragEngine,
                          RotationEngine, TorqueEngine)

STEPS = 600


def pit(seed):
    """40 grains above a floor between walls."""
    build(*grains(40, 6, seed), *walls(0.9), dt=1e-3, **SOLVER)


def shaken_wall(seed):
    pit(seed)
    insert(0, HarmonicMotionEngine(A=(0, 0.02, 0), f=(0, 8, 0), fi=(0, 0, 0), ids=[42]))


def with_box(seed, center, half):
    """Grains above a box between walls."""
    obstacle = box(center, half, 0, material(0.5))
    build(*grains(48, 12, seed), *walls(1.6), obstacle, dt=1e-3, **SOLVER)
    for k in range(48):
        O.bodies[k].state.pos += Vector3(0, 2 * center[1], 0)


def shaken_box(seed):
    with_box(seed, (0.8, 0.02), (0.4, 0.02))
    insert(0, HarmonicMotionEngine(A=(0.02, 0, 0), f=(10, 0, 0), fi=(0, 0, 0), ids=[51]))


def shaken_box_after_the_loop(seed):
    shaken_box(seed)
    O.engines = [*O.engines[1:4], O.engines[0], *O.engines[4:]]


def two_shaken_grains(seed):
    """Within a step, one driven grain becomes faster and another one slower."""
    rng = np.random.default_rng(seed)
    driven = [rcr.particle((x, 0.75), 0.06, 0.5, material=material(0.5), fixed=True)
              for x in (0.2, 0.5)]
    build(*grains(25, 5, seed), *walls(0.7), *driven, dt=2e-3, **SOLVER)
    motions = rng.uniform((0.02, 10, 0), (0.1, 150, 6), (2, 3))
    insert(3, *(HarmonicMotionEngine(A=(a, a, 0), f=(f, f, 0), fi=(0, phase, 0), ids=[28 + k])
                for k, (a, f, phase) in enumerate(motions)))


def torque_on_grains(seed):
    pit(seed)
    insert(1, TorqueEngine(ids=[3, 11, 20], moment=(0, 0, 40)))


def stirrer(seed):
    with_box(seed, (0.8, 0.45), (0.2, 0.02))
    insert(0, RotationEngine(ids=[51], rotateAroundZero=True, rotationAxis=(0, 0, 1),
                             zeroPoint=(0.8, 0.45, 0), angularVelocity=6))


def drag_on_fast_grains(seed):
    pit(seed)
    fast = list(range(0, 40, 5))
    for k in fast:
        O.bodies[k].state.vel = Vector3(8, 4, 0)
    insert(1, LinearDragEngine(ids=fast, nu=0.02))


def kick():
    for k in range(O.iter % 3, 40, 7):
        O.bodies[k].state.vel = Vector3(6 * np.cos(k), 5, 0)


def kicked_before_the_collider(seed):
    pit(seed)
    insert(0, run_each(70, "kick", __name__))


def change_masks():
    for k in range(0, 40, 4):
        O.bodies[k].mask = 1 if O.bodies[k].mask == 2 else 2


def masks_that_change(seed):
    pit(seed)
    for b in O.bodies:
        b.mask = 3 if b.id >= 40 else 1 + b.id % 2
    O.engines = [*O.engines, run_each(150, "change_masks", __name__, firstIterRun=50)]


SCENES = [shaken_wall, shaken_box, shaken_box_after_the_loop, torque_on_grains, stirrer,
          drag_on_fast_grains, kicked_before_the_collider, masks_that_change, two_shaken_grains]


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.__name__)
def test_same_bits_as_the_engines(scene, seed):
    expected, _ = after(lambda: scene(seed), False)
    found, model = after(lambda: scene(seed), True)
    assert model["arrays"] > 0.3 * STEPS
    assert same(found, expected)


def add_force():
    first = next(k for k, engine in enumerate(O.engines) if isinstance(engine, ForceResetter))
    insert(first + 1, ForceEngine(ids=[1], force=(20, 0, 0)))


@pytest.mark.parametrize("arrays", [False, True])
@pytest.mark.parametrize("place", [0, 3, 5])
def test_engines_set_during_a_run_act(arrays, place):
    """A PyRunner that inserts an engine; YADE applies the new list at the next step."""
    build(rcr.disc((0, 0), 0.05, material(0.5)), rcr.disc((1, 0), 0.05, material(0.5)), dt=1e-3,
          gravity=(0, 0, 0), **SOLVER)
    solver().arrays = arrays
    insert(place, run_each(1000, "add_force", __name__, firstIterRun=100, nDo=1))
    O.run(300, True)
    moved = O.bodies[1].state.pos[0] - 1
    acceleration = 20 / O.bodies[1].state.mass
    steps = O.bodies[1].state.vel[0] / (acceleration * O.dt)
    assert 198 <= round(steps) <= 201
    assert moved == pytest.approx(acceleration * O.dt**2 * steps * (steps + 1) / 2)
