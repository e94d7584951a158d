"""Springs of polygons: forces of blocks at rest, rebound, energy."""

import math

import numpy as np
import pytest
import rcr
from scenes import (FLOORS, G, KN, KS, build, material, point_forces, prescribe, steps, tilted,
                    velocity)
from yade import O

SQUARE = 0.1 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


def build_springs(*bodies, dt=1e-4, damping=0.0, **options):
    """`build` under springs KN and KS; the critical time step of these bodies is about 2e-3 s."""
    ids = build(*bodies, law="smooth", dt=dt, damping=damping, **options)
    prescribe("kn", KN)
    prescribe("ks", KS)
    return ids


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("alpha", [0, 0.3])
def test_block_at_rest_on_a_slope(floor, alpha):
    """Its two points carry W (cos α ± sin α)/2 and together W sin α along the slope."""
    m = material(0.5)
    ground, k = build_springs(FLOORS[floor](m), rcr.polygon((0, 0.1), SQUARE, material=m),
                              gravity=tilted(alpha), damping=0.5)
    steps(4000)
    weight = G * O.bodies[k].state.mass
    forces = point_forces(ground, k)
    assert abs(velocity(k)).max() < 1e-7
    share = np.array([math.cos(alpha) - math.sin(alpha), math.cos(alpha) + math.sin(alpha)]) / 2
    assert sorted(forces[:, 0]) == pytest.approx(weight * share, rel=1e-3)  # it leans by 1e-4
    assert abs(forces[:, 1].sum()) == pytest.approx(weight * math.sin(alpha), rel=1e-6, abs=1e-6)
    gap = O.interactions[ground, k].geom.gap
    assert sorted(-KN * g for g in gap) == pytest.approx(sorted(forces[:, 0]), rel=1e-6)


def test_stack_of_blocks_at_rest():
    m = material(0.5)
    blocks = [rcr.polygon((0.02 * (-1) ** k, 0.1 + 0.2 * k), SQUARE, material=m) for k in range(4)]
    ids = build_springs(rcr.wall("y", 0, material=m), *blocks, damping=0.5)
    steps(10000)
    weight = G * O.bodies[1].state.mass
    for below, above in zip(ids, ids[1:]):
        load = point_forces(below, above)[:, 0].sum()
        assert load == pytest.approx((len(ids) - above) * weight, rel=1e-3)  # it still vibrates


def energies(count):
    """Largest change of the total energy in so many steps [J/m]."""
    O.trackEnergy = True
    O.step()
    start, off = O.energy.total(), 0.0
    for _ in range(count):
        O.step()
        off = max(off, abs(O.energy.total() - start))
    return off


@pytest.mark.parametrize("radius", [0, 0.02])
@pytest.mark.parametrize("sides", [3, 4])
def test_a_polygon_that_bounces_on_a_floor_keeps_its_energy(sides, radius):
    """The leapfrog shifts velocities by half a step: dt ω of the energy, ω² = 3 k_n/m."""
    m, dt, height = material(0.4), 4e-5, 0.3
    _, k = build_springs(rcr.wall("y", 0, material=m), rcr.regular_polygon(
        (0, height), 0.1, sides, radius, angle=0.3, material=m, angular_velocity=3), dt=dt)
    mass = O.bodies[k].state.mass
    assert energies(8000) < dt * math.sqrt(3 * KN / mass) * mass * G * height
    assert O.bodies[k].state.pos[1] > 0  # free fall would end 0.2 m below the floor


@pytest.mark.parametrize("radius", [0, 0.02])
def test_polygons_that_collide_keep_their_energy(radius):
    """1 % of the work of gravity, as RCRs in test_energy.py."""
    m, rng = material(0.3), np.random.default_rng(3)
    grains = [rcr.regular_polygon((0.22 * i, 0.12 + 0.24 * j), 0.1, 3 + (i + j) % 4, radius,
                                  angle=rng.uniform(0, 3), material=m)
              for i in range(3) for j in range(4)]
    build_springs(rcr.wall("y", 0, material=m), *grains, dt=2e-5, damping=0.2)
    height = lambda: sum(b.state.mass * G * b.state.pos[1] for b in grains)
    before = height()
    off = energies(13000)
    assert off < 0.01 * (before - height())
