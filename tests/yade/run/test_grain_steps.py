"""Steps in NumPy arrays, without YADE, against closed forms and YADE's bits."""

import math

import numpy as np
import pytest
import rcr
from rcr import _kernel
from scenes import G, build, material
from yade import O

R, DENSITY = 0.1, 1000.0


def discs(position, **options):
    count = len(position)
    mass = DENSITY * math.pi * R**2
    return _kernel.GrainSteps(position, np.full(count, R),
                              np.tile([1 / mass, 1 / mass, 2 / (mass * R**2)], (count, 1)),
                              **options)


def test_a_column_rests():
    """Each contact bears the weight above; nothing moves."""
    position = [(0, R + 2 * R * k) for k in range(10)]
    grains = discs(position, walls=[("y", 0, 1)], gravity=(0, -G), friction=0.5)
    for _ in range(100):
        result = grains.step(1e-3)
        assert result["converged"] and result["error_estimate"] <= 0.01
    contacts = grains.contacts()
    above = DENSITY * math.pi * R**2 * G * np.arange(10, 0, -1)
    lower = contacts["bodies"].min(1) % 10  # the wall, 10, lies below disc 0
    order = np.argsort(np.where(contacts["bodies"].max(1) == 10, -1, lower))
    np.testing.assert_allclose(contacts["force"][order, 0], above, rtol=1e-2)
    np.testing.assert_allclose(grains.position, position, atol=1e-6)


def test_steps_have_the_bits_of_yade():
    """Rods and discs that fall on a wall, with restitution."""
    rng, m, count = np.random.default_rng(3), material(0.4), 30
    at = np.array([(0.35 * (k % 6), 0.2 + 0.35 * (k // 6)) for k in range(count)])
    angle, half = rng.uniform(0, 3, count), np.where(np.arange(count) % 2, 0.05, 0.0)
    bodies = [rcr.disc(p, R, material=m) if a == 0
              else rcr.particle(p, R + a, a / (R + a), t, m) for p, a, t in zip(at, half, angle)]
    ids = build(*bodies, rcr.wall("y", 0, sense=1, material=m), solver="auto", tolerance=1e-4,
                restitution=0.3, threads=1)
    s = [O.bodies[k].state for k in ids[:count]]
    shape = [O.bodies[k].shape for k in ids[:count]]
    cap = [getattr(one, "capRadius", R) for one in shape]
    grains = _kernel.GrainSteps(
        [(one.pos[0], one.pos[1]) for one in s], cap,
        [(1 / one.mass, 1 / one.mass, 1 / one.inertia[2]) for one in s],
        half_length=[getattr(one, "halfLength", 0) for one in shape],
        angle=[2 * math.atan2(one.ori[2], one.ori[3]) for one in s], walls=[("y", 0, 1)],
        gravity=(0, -G), friction=m.frictionAngle and math.tan(m.frictionAngle), restitution=0.3)
    for _ in range(300):
        O.step()
        grains.step(O.dt)
    yade = np.array([(one.pos[0], one.pos[1]) for one in s])
    assert np.abs(yade - at).max() > R
    np.testing.assert_allclose(grains.position, yade, rtol=0, atol=1e-9)


def test_rolling_and_adhesion():
    angle = 0.35
    down = discs([(0, R)], walls=[("y", 0, 1)], friction=0.8, rolling_friction=0.1,
                 gravity=(G * math.sin(angle), -G * math.cos(angle)), tolerance=1e-12)
    for _ in range(50):
        down.step(1e-3)
    expected = 2 / 3 * G * (math.sin(angle) - 0.1 * math.cos(angle))
    assert down.velocity[0, 0] == pytest.approx(50e-3 * expected, rel=1e-6)
    bound = 0.1 * R * down.contacts()["force"][0, 0]
    assert abs(down.contacts()["rolling_moment"][0]) == pytest.approx(bound)
    weight = DENSITY * math.pi * R**2 * G
    hung = discs([(0, -R)], walls=[("y", 0, -1)], adhesion=1.01 * weight, gravity=(0, -G))
    hung.step(1e-3)
    assert hung.contacts()["force"][0, 0] == pytest.approx(-weight)


@pytest.mark.parametrize("changes, match", [
    (dict(walls=[("z", 0, 1)]), "expected \\('x' or 'y'"),
    (dict(half_length=[-1.0]), "expected radius > 0 and half_length ≥ 0"),
    (dict(velocity=[[0, 0]]), "velocity"),
    (dict(solver="fast"), "fast"),
    (dict(restitution=2), "expected 0 to 1"),
    (dict(friction=-1), "friction"),
    (dict(position=[(0, math.nan)]), r"grain 0: position \(0, nan\)"),
    (dict(position=[(0, 0), (math.inf, 0)]), r"grain 1: position \(inf, 0\)"),
    (dict(angle=[math.nan]), "angle nan"),
    (dict(velocity=[(0, 0, math.nan)]), r"velocity \(0, 0, nan\)"),
    (dict(walls=[("y", math.nan, 1)]), r"a wall \(y, nan, 1\)"),
])
def test_wrong_input_is_refused(changes, match):
    with pytest.raises(ValueError, match=match):
        discs(**dict(position=[(0, R)]) | changes)


def test_extreme_numbers_do_not_crash():
    """Paths of 1e197 m have no place in the grid of the neighbour search."""
    grains = discs([(0, R), (1, R)], velocity=[(1e200, 0, 0), (0, 0, 0)], walls=[("y", 0, 1)])
    for _ in range(3):
        try:
            grains.step(1e-3)
        except ValueError as error:
            assert "velocity" in str(error)
            break
