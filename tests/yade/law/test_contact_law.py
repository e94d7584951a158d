"""Adhesion and rolling resistance against closed forms, in energy, arrays and files."""

import math

import numpy as np
import pytest
import rcr
from scenes import (G, assert_refused, assert_reload_changes_nothing, build, contact_forces,
                    heap, material, open_box, set_state, snapshot, solver, springs, steps, weightless)
from yade import O
from yade.wrapper import MatchMaker

R, MU = 0.1, 0.8
TIGHT = dict(solver="auto", tolerance=1e-12)


def law(**coefficients):
    """Sets coefficients of the Ip2 functor of the scene to one number each."""
    for name, value in coefficients.items():
        setattr(O.engines[2].physDispatcher.functors[0], name, MatchMaker(algo="val", val=value))


def disc_on_incline(angle, rolling_friction, **options):
    """A disc on a floor, with gravity turned by `angle` [rad]; its id."""
    m = material(MU)
    _, disc = build(rcr.wall("y", 0, sense=1, material=m), rcr.disc((0, R), R, material=m),
                    gravity=(G * math.sin(angle), -G * math.cos(angle), 0), **options or TIGHT)
    law(rollingFriction=rolling_friction)
    return disc


@pytest.mark.parametrize("options", [TIGHT, dict(TIGHT, solver="nlgs"), dict(TIGHT, arrays=False)])
@pytest.mark.parametrize("rolling_friction", [0.05, 0.3])
def test_a_disc_rolls_down_an_incline(rolling_friction, options):
    """a = (2/3) g (sin α − µ_r cos α) for tan α > µ_r."""
    angle = 0.35
    disc = disc_on_incline(angle, rolling_friction, **options)
    steps(200)
    expected = 2 / 3 * G * (math.sin(angle) - rolling_friction * math.cos(angle))
    s = O.bodies[disc].state
    assert s.vel[0] / O.time == pytest.approx(expected, rel=1e-6)
    assert -s.angVel[2] * R == pytest.approx(s.vel[0], rel=1e-9)
    (contact,) = O.interactions
    bound = rolling_friction * R * contact.phys.force1[0]
    assert abs(contact.phys.rollingMoment) == pytest.approx(bound, rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.999999])
def test_a_disc_rests_on_an_incline(share):
    """It rests for tan α ≤ µ_r, and its moment is W R sin α."""
    rolling_friction = 0.3
    angle = math.atan(share * rolling_friction)
    disc = disc_on_incline(angle, rolling_friction)
    steps(200)
    s = O.bodies[disc].state
    assert s.vel.norm() < 1e-9 and abs(s.pos[0]) < 1e-9
    (contact,) = O.interactions
    assert abs(contact.phys.rollingMoment) == pytest.approx(s.mass * G * R * math.sin(angle))


def test_rolling_and_a_broken_contact_close_the_energy():
    disc = disc_on_incline(0.35, 0.1)
    O.trackEnergy = True
    O.step()
    start = O.energy.total()
    steps(500)
    kinetic = 0.5 * O.bodies[disc].state.mass * O.bodies[disc].state.vel.squaredNorm()
    assert O.energy["plastDissip"] > 0.1 * kinetic
    assert O.energy.total() == pytest.approx(start, abs=0.01 * kinetic)


def hanging(count, pull, **options):
    """A fixed disc and `count` discs below it, each touching the one above; their ids."""
    m = material(MU)
    discs = [rcr.disc((0, -2 * R * k), R, material=m, fixed=k == 0) for k in range(count + 1)]
    ids = build(*discs, **options or TIGHT)
    law(adhesion=pull)
    return ids


def weight(disc):
    return O.bodies[disc].state.mass * G


@pytest.mark.parametrize("count", [1, 10, 40])
def test_a_chain_hangs_by_adhesion(count):
    """Each contact bears the weight of the discs below it."""
    ids = hanging(count, 0.0)
    below = weight(ids[1]) * np.arange(count, 0, -1)
    law(adhesion=(1 + 1e-9) * below[0])
    steps(20)
    forces = [O.interactions[k, k + 1].phys.force1[0] for k in range(count)]
    np.testing.assert_allclose(forces, -below, rtol=1e-9)
    assert max(O.bodies[k].state.vel.norm() for k in ids) < 1e-9
    assert solver().missedSteps == 0


@pytest.mark.parametrize("share", [0.5, 1 - 1e-9])
def test_a_disc_falls_off_a_weaker_contact(share):
    """f = −f_a while it opens: the acceleration is g − f_a/m; after the slop, it falls freely."""
    ids = hanging(1, 0.0)
    pull = share * weight(ids[1])
    law(adhesion=pull)
    O.step()
    (contact,) = O.interactions
    assert contact.phys.force1[0] == pytest.approx(-pull, rel=1e-9)
    fall = O.bodies[ids[1]].state.vel[1] / O.dt
    assert fall == pytest.approx(-G * (1 - share), rel=1e-6, abs=1e-12)
    if share < 0.9:
        steps(300)
        before = O.bodies[ids[1]].state.vel[1]
        O.step()
        assert O.bodies[ids[1]].state.vel[1] - before == pytest.approx(-G * O.dt)


@pytest.mark.parametrize("normal", [0.0, 3.0])
def test_friction_bears_the_pull_too(normal):
    """A disc without rotation slides on a floor: |f_t| = µ (f_n + f_a)."""
    m, pull = material(MU), 5.0
    disc = rcr.disc((0, R), R, material=m)
    disc.state.blockedDOFs = "zXYZ"
    _, k = weightless(rcr.wall("y", 0, sense=1, material=m), disc, **TIGHT)
    law(adhesion=pull)
    set_state(k, vel=(1, 0, 0))
    O.forces.setPermF(k, (0, -normal, 0))
    O.step()
    (contact,) = O.interactions
    assert contact.phys.force1[0] == pytest.approx(normal, abs=1e-9)
    assert abs(contact.phys.force1[1]) == pytest.approx(MU * (normal + pull), rel=1e-9)


def test_adhesion_closes_the_energy():
    """Rods that stick after an impact: kinetic energy goes into impact and friction alone."""
    rng, m = np.random.default_rng(5), material(0.5)
    grains = [rcr.particle((0.22 * (k % 4), 0.22 * (k // 4)), R, 0.4, rng.uniform(0, 3), m,
                           velocity=(rng.normal(), rng.normal())) for k in range(16)]
    weightless(*grains, solver="auto", tolerance=1e-10, accuracy=1e-4)
    law(adhesion=20.0, rollingFriction=0.1)
    O.trackEnergy = True
    O.step()
    start, total = O.energy["kinetic"], O.energy.total()
    steps(400)
    assert O.energy["kinetic"] < 0.9 * start
    assert O.energy.total() == pytest.approx(total, abs=0.01 * start)
    pulls = [i for i in O.interactions if i.phys.points and i.phys.force1[0] < 0]
    assert pulls and all(i.phys.force1[0] >= -20 * (1 + 1e-9) for i in pulls)


def test_steps_of_a_bouncing_heap_converge():
    """30 grains with rolling resistance: sweeps alone miss a fifth of these steps."""
    rng, m = np.random.default_rng(1), material(0.4)
    build(*open_box(1.1, m), *(rcr.particle(
        (0.15 + 0.2 * (k % 5), 0.12 + 0.22 * (k // 5)), rng.uniform(0.06, 0.09),
        rng.uniform(0, 0.6), rng.uniform(0, 3), m) for k in range(30)),
        restitution=0.5, tolerance=1e-4)
    law(rollingFriction=0.05)
    steps(1000)
    assert solver().missedSteps <= 10


@pytest.mark.parametrize("arrays", [True, False])
def test_coefficients_survive_a_file(tmp_path, arrays):
    heap()
    solver().arrays = arrays
    law(adhesion=0.5, rollingFriction=0.2)
    O.interactions.clear()
    steps(500)
    assert any(i.phys.rollingMoment for i in O.interactions)

    def run():
        steps(30)
        moments = [i.phys.rollingMoment for i in O.interactions]
        return snapshot().tolist(), contact_forces(), sorted(moments)

    assert_reload_changes_nothing(tmp_path / "scene.xml.gz", run)


def test_a_saved_problem_has_pulls_and_rolling_resistance(tmp_path):
    heap()
    solver().tolerance = 1e-10
    law(adhesion=0.5, rollingFriction=0.2)
    O.interactions.clear()
    steps(500)
    solver().save(str(tmp_path / "step.npz"))
    problem = rcr.problems.load(tmp_path / "step.npz")
    assert problem.pull.max() == pytest.approx(0.5 * O.dt)
    assert problem.rolling_friction.max() == 0.2
    assert (problem.rolling_length[problem.rolling_friction > 0] > 0).all()
    solution = rcr.solve(problem, tolerance=1e-10, warm=True)
    assert solution.converged
    forces = sorted(x for i in O.interactions for x in (i.phys.force1[0], i.phys.force2[0]) if x)
    largest = max(map(abs, forces))
    found = sorted(solution.reaction[solution.reaction[:, 0] != 0, 0] / O.dt)
    assert found == pytest.approx(forces, abs=1e-5 * largest)
    moments = max(abs(i.phys.rollingMoment) for i in O.interactions)
    turning = abs(solution.rolling * problem.rolling_length).max() / O.dt
    assert turning == pytest.approx(moments, rel=1e-4)
    other = tmp_path / "other.npz"
    rcr.problems.save(other, problem)
    assert (rcr.problems.load(other).rolling_impulse == problem.rolling_impulse).all()
    with pytest.raises(ValueError, match="neither adhesion nor rolling friction"):
        solver().save(str(tmp_path / "step.h5"))


def test_arrays_and_engines_give_the_same_bits():
    def run(arrays):
        rng, m = np.random.default_rng(7), material(0.5)
        grains = [rcr.particle((0.25 * (k % 5), 0.15 + 0.25 * (k // 5)), R, rng.uniform(0, 0.6),
                               rng.uniform(0, 3), m) for k in range(25)]
        build(rcr.wall("y", 0, sense=1, material=m), *grains, solver="auto", tolerance=1e-6,
              arrays=arrays)
        law(adhesion=2.0, rollingFriction=0.2)
        O.run(300, True)
        O.run(300, True)
        return snapshot().tolist(), contact_forces(), sorted(
            i.phys.rollingMoment for i in O.interactions)

    assert run(True) == run(False)


@pytest.mark.parametrize("coefficients, match", [
    (dict(adhesion=-1.0), "adhesion -1; expected a finite number"),
    (dict(rollingFriction=math.nan), "rolling friction nan; expected"),
])
def test_wrong_coefficients_are_refused(coefficients, match):
    disc_on_incline(0.1, 0.0)
    law(**coefficients)
    assert_refused(match)


def test_springs_hang_by_adhesion():
    """δ = (f_a − W)/k_n at rest, and springs refuse a negative pull."""
    m = material(MU)
    _, disc = springs(rcr.disc((0, 0), R, material=m, fixed=True),
                      rcr.disc((0, -2 * R * 0.9999), R, material=m), local_damping=0.3)
    pull = 1.5 * weight(disc)
    functor = O.engines[2].lawDispatcher.functors[0]
    functor.adhesion = pull
    O.run(20000, True)
    (contact,) = O.interactions
    assert contact.phys.force1[0] == pytest.approx(-weight(disc), rel=1e-3)
    overlap = -contact.geom.gap[0]
    assert overlap == pytest.approx((pull - weight(disc)) / contact.phys.kn, rel=1e-3)
    with pytest.raises(ValueError, match="adhesion = -1; expected"):
        functor.adhesion = -1


def test_springs_with_adhesion_keep_their_energy():
    m = material(0.0)
    _, disc = springs(rcr.disc((0, 0), R, material=m, fixed=True),
                      rcr.disc((0, -2 * R * 0.999), R, material=m), gravity=(0, 0, 0))
    O.engines[2].lawDispatcher.functors[0].adhesion = 150.0
    O.trackEnergy = True
    steps(2)
    total, stored = O.energy.total(), abs(O.energy["elastPotential"])
    O.run(5000, True)
    assert O.energy.total() == pytest.approx(total, abs=0.01 * stored)
    assert any(i.phys.points for i in O.interactions)
