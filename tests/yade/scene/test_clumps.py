"""Clumps of Rcrs and discs: contacts act on the whole clump."""

import math

import numpy as np
import pytest
import rcr
from scenes import (G, LAWS, assert_reload_changes_nothing, build, insert, material, set_state,
                    solver, springy, stadium, steps, velocity, walls, weightless)
from yade import O
from yade.wrapper import ForceEngine, PyRunner


def two_discs(center, angle, m, R=0.1, **options):
    half = np.array([math.cos(angle), math.sin(angle)]) * R
    return rcr.clump([rcr.disc(tuple(np.array(center) + sign * half), R, material=m)
                      for sign in (-1, 1)], **options)


def glued(grain, angle, count, **options):
    """A clump of discs along the core of a grain at this angle; returns its id."""
    a, r, (x, y, _) = grain.shape.halfLength, grain.shape.capRadius, grain.state.pos
    return rcr.clump([rcr.disc((x + s * math.cos(angle), y + s * math.sin(angle)), r,
                               material=grain.material) for s in np.linspace(-a, a, count)],
                     **options)[0]


def test_mass_and_inertia():
    """Overlaps count once: discs along the core of an Rcr approach its values from below."""
    build()
    clump, members = two_discs((1, 2), 0.3, material(density=2000))
    s, disc = O.bodies[clump].state, 2000 * math.pi * 0.01
    assert (s.pos[0], s.pos[1]) == pytest.approx((1, 2), abs=1e-9)
    assert s.mass == pytest.approx(2 * disc, rel=1e-9)
    assert s.inertia[2] == pytest.approx(2 * (disc * 0.01 / 2 + disc * 0.01), rel=1e-9)
    assert len(members) == 2 and all(O.bodies[i].isClumpMember for i in members)
    grain = rcr.particle((0, 0), 0.3, 0.6, angle=0.4, material=material())
    s = O.bodies[glued(grain, 0.4, 60)].state
    assert s.mass == pytest.approx(grain.state.mass, rel=1e-3)
    assert s.inertia[2] == pytest.approx(grain.state.inertia[2], rel=2e-3)


def test_means_of_velocities_weigh_a_clump_by_its_mass():
    weightless()
    rods = [stadium(0.08, 0.02, (0, 0), angle, material=material()) for angle in (0, math.pi / 2)]
    clump, _ = rcr.clump(rods, mass=100)
    set_state(clump, vel=(1, 0, 0))
    disc = O.bodies.append(rcr.disc((0.3, 0), 0.1, material()))
    O.step()
    profile = rcr.Profile(cells=(1, 1), limits=((-1, -1), (1, 1))).compute()
    share = 100 / (100 + O.bodies[disc].state.mass)
    assert profile.velocity[0, 0, 0] == pytest.approx(share, rel=1e-6)


def test_falls_freely():
    build()
    clump, (one, two) = two_discs((0, 0), 0.3, material())
    s = O.bodies[clump].state
    s.angVel = (0, 0, 2)
    steps(100)
    assert s.vel[1] == pytest.approx(-G * 0.1, rel=1e-12)
    assert ((O.bodies[one].state.pos + O.bodies[two].state.pos) / 2 - s.pos).norm() < 1e-12


@LAWS
def test_an_upright_pair_topples_over_its_lower_disc(law):
    """Tilted, without slip: while the lower disc rolls, ½ m v² + ½ I ω² = m g (h₀ − h)."""
    m, tilt = springy(friction=1.2, young=1e8), 0.2
    center = (0.1 * math.sin(tilt), 0.1 + 0.1 * math.cos(tilt))
    build(rcr.wall("y", 0, material=m), dt=1e-4 if law == "rigid" else 2e-5, law=law)
    clump, members = two_discs(center, math.pi / 2 - tilt, m)
    s = O.bodies[clump].state
    height = s.pos[1]
    steps(int(0.25 / O.dt))
    fallen = s.mass * G * (height - s.pos[1])
    moving = 0.5 * s.mass * s.vel.squaredNorm() + 0.5 * s.inertia[2] * s.angVel[2] ** 2
    assert height - s.pos[1] > 0.002 and moving == pytest.approx(fallen, rel=0.02)
    lower, slip = O.bodies[members[0]].state, 5e-3 if law == "rigid" else 2e-2  # of a shear spring
    assert lower.pos[1] == pytest.approx(0.1, abs=2e-4)
    assert lower.vel[0] == pytest.approx(-0.1 * s.angVel[2], abs=slip)


def test_glued_into_an_rcr_falls_as_the_rcr():
    """Discs every R'/10 along the core, with the grain's mass and moment, move as the grain."""
    def fall(start, put):
        """Final place and angle of the long axis; a clump starts at the angle 0."""
        m = material(friction=0.5)
        grain = rcr.particle((0, 0.35), 0.3, 0.5, angle=1.0, material=m)
        build(rcr.wall("y", 0, material=m), dt=2e-4)
        s = O.bodies[put(grain)].state
        steps(2500)
        angle = 2 * math.atan2(s.ori[2], s.ori[3]) + start
        return s.pos[0], s.pos[1], math.remainder(angle, math.pi)

    clump = fall(1.0, lambda grain: glued(grain, 1.0, 22, mass=grain.state.mass,
                                          inertia=grain.state.inertia[2]))
    assert clump == pytest.approx(fall(0, lambda grain: O.bodies.append(grain)), abs=0.01)


def test_forces_on_members_are_loads_of_the_clump():
    m = material()
    weightless(rcr.wall("y", 0, material=m))
    clump, members = two_discs((0, 0.1), 0, m)
    insert(3, ForceEngine(force=(0, -100, 0), ids=members))
    steps(50)
    assert sum(i.phys.normalForce[1] for i in O.interactions) == pytest.approx(200, rel=1e-6)
    assert O.bodies[clump].state.pos[1] == pytest.approx(0.1, abs=1e-6)
    assert np.abs(velocity(clump)).max() < 1e-9


def test_a_pile_of_clumps_rests_and_reloads_to_the_same_bits(tmp_path):
    m = material()
    build(*walls(m, x=(-1, 1), y=[0]))
    rng = np.random.default_rng(1)
    for k in range(20):
        at = np.array([-0.6 + 0.4 * (k % 4), 0.2 + 0.4 * (k // 4)])
        if k % 2:
            two_discs(at, rng.uniform(0, 3), m, R=0.07)
        else:
            rcr.clump([rcr.particle(tuple(at), 0.14, 0.7, angle=rng.uniform(0, 3), material=m)
                       for _ in range(2)])
    steps(2500)
    assert max(b.state.vel.norm() for b in O.bodies if b.isClump) < 5e-3
    assert_reload_changes_nothing(tmp_path / "pile.yade", lambda: (
        steps(10), [tuple(b.state.pos) for b in O.bodies]))


@pytest.mark.parametrize("seed", [15, 19, 43, 62])
def test_fast_crosses_do_not_pass_through_each_other(seed):
    """Sixteen crosses in a box, v dt ≈ 1.5 R and turns up to 0.5 rad a step."""
    m, rng = material(0.5), np.random.default_rng(seed)
    build(*walls(m, x=(-0.6, 0.6), y=(0, 1.2)), dt=5e-3, tolerance=1e-4)
    for k in range(16):
        at = (-0.42 + 0.28 * (k % 4), 0.18 + 0.28 * (k // 4))
        turn = rng.uniform(0, 3)
        clump, _ = rcr.clump([rcr.particle(at, 0.1, 0.7, angle=turn + side, material=m)
                              for side in (0, math.pi / 2)])
        set_state(clump, vel=(*rng.uniform(-30, 30, 2), 0), angVel=(0, 0, rng.uniform(-100, 100)))
    O.run(40, True)
    assert solver().deepestOverlap < 0.005


@LAWS
@pytest.mark.parametrize("place", ["between runs", "in a step"])
def test_touching_grains_may_be_joined_in_a_run(law, place):
    """Their contact ends; the floor bears the clump."""
    m = springy()
    floor, *discs = build(rcr.wall("y", 0, material=m), *(rcr.disc((0.1999 * k, 0.1), 0.1, m)
                                                          for k in range(2)),
                          law=law, dt=1e-3 if law == "rigid" else 1e-5)
    O.run(10, True)
    assert O.interactions[discs].isReal
    if place == "between runs":
        join()
    else:
        insert(3, PyRunner(command="import test_clumps; test_clumps.join()", iterPeriod=1, nDo=1,
                           initRun=True))
    O.run(10, True)
    assert [(i.id1, i.id2) for i in O.interactions if i.isReal] == [(floor, k) for k in discs]
    assert len(rcr.contact_network(volume=1).contacts["body1"]) == 2
    if law == "rigid":
        assert O.forces.f(floor)[1] == pytest.approx(-O.bodies[3].state.mass * G, rel=1e-6)


def join():
    """Join the discs 1 and 2 as O.bodies.clump does, whose axes may leave the plane."""
    one, two = (O.bodies[k].state for k in (1, 2))
    x, y, _ = (one.pos + two.pos) / 2
    inertia = 2 * (one.inertia[2] + one.mass * 0.1**2)
    rcr._plugin.planar_clump([1, 2], x, y, 2 * one.mass, inertia)


@pytest.mark.parametrize("angle", [0, 0.7, math.pi / 2])
def test_area_of_two_discs_less_their_lens(angle):
    build()
    R, distance = 0.1, 0.12
    at = distance * math.cos(angle), distance * math.sin(angle)
    clump, _ = rcr.clump([rcr.disc((0, 0), R, material=material(density=1)),
                          rcr.disc(at, R, material=material(density=1))])
    half = distance / 2
    lens = 2 * R**2 * math.acos(half / R) - 2 * half * math.sqrt(R**2 - half**2)
    assert O.bodies[clump].state.mass == pytest.approx(2 * math.pi * R**2 - lens, rel=1e-9)


@pytest.mark.parametrize("distance", [0.2, 2.0, 20.0])
@pytest.mark.parametrize("angle", [0, 0.4, math.pi / 2])
def test_area_of_thin_rods_far_apart(distance, angle):
    """Between upright rods of 1e-5 of their distance, the section is empty."""
    build()
    rods = [rcr.particle((x * math.cos(angle), x * math.sin(angle)), 0.01, 0.999,
                         angle=angle + math.pi / 2, material=material()) for x in (0, distance)]
    own = sum(rod.state.mass for rod in rods)
    clump, _ = rcr.clump(rods)
    assert O.bodies[clump].state.mass == pytest.approx(own, rel=1e-9)
    assert O.bodies[clump].state.inertia[2] == pytest.approx(own * distance**2 / 4, rel=1e-2)
    assert rcr.measure.areas()[1].sum() == pytest.approx(own / 1000, rel=1e-3)


@pytest.mark.parametrize("far", [1e4, 1e6])
def test_a_clump_far_from_the_origin_has_its_mass_and_inertia(far):
    def made(x):
        build()
        clump, _ = two_discs((x, -2 * x), 0.3, material(0.5), R=0.01)
        return O.bodies[clump].state.mass, O.bodies[clump].state.inertia[2]

    assert made(0.01 * far) == pytest.approx(made(0), rel=1e-9)
