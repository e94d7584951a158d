"""Discs, boxes and facets together, under both laws."""

import math

import numpy as np
import pytest
import rcr
from rcr.frame import Frame
from scenes import (FLOORS, G, build, gaps, iterations, material, solver, springy, steps, velocity,
                    warns, weightless)
from yade import O, utils

GRAINS = {"Sphere": lambda at, m: rcr.disc(at, 0.1, material=m),
          "Rcr": lambda at, m: rcr.particle(at, 0.1, 0, material=m)}


def test_disc_has_mass_and_inertia_of_a_disc():
    disc, twin = (make((1, 2), material(density=2000)) for make in GRAINS.values())
    assert disc.state.mass == pytest.approx(2000 * math.pi * 0.01, rel=1e-15)
    assert disc.state.inertia[2] == pytest.approx(disc.state.mass * 0.01 / 2, rel=1e-15)
    assert (disc.state.mass, *disc.state.inertia) == pytest.approx(
        (twin.state.mass, *twin.state.inertia), rel=1e-14)
    assert disc.state.blockedDOFs == twin.state.blockedDOFs


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("grain", GRAINS)
@pytest.mark.parametrize("law, height, dt, count, low, high",
                         [("rigid", 0.25, 1e-3, 600, 0.1 - 1e-5, 0.1 + 1e-5),
                          ("smooth", 0.1, 2e-5, 5000, 0.09, 0.1001)], ids=["rigid", "smooth"])
def test_a_grain_comes_to_rest_on_every_floor(floor, grain, law, height, dt, count, low, high):
    m = springy()
    _, top = build(FLOORS[floor](m), GRAINS[grain]((0.02, height), m), dt=dt, law=law)
    steps(count)
    assert low < O.bodies[top].state.pos[1] < high
    assert law == "smooth" or np.abs(velocity(top)).max() < 1e-8


@pytest.mark.parametrize("floor", FLOORS)
def test_spheres_and_rcrs_of_one_size_do_the_same(floor):
    places = [(0.21 * i + 0.03 * j, 0.15 + 0.22 * j) for i in range(3) for j in range(3)]

    def run(kinds):
        m = material()
        ids = build(FLOORS[floor](m), *[GRAINS[kind](at, m) for at, kind in zip(places, kinds)])
        steps(60)
        return np.array([[*O.bodies[i].state.pos, *velocity(i)] for i in ids[1:]])

    rcrs, spheres, mixed = run(["Rcr"] * 9), run(["Sphere"] * 9), run(["Rcr", "Sphere"] * 5)
    assert spheres == pytest.approx(rcrs, abs=1e-9) and mixed == pytest.approx(rcrs, abs=1e-9)


def test_a_disc_rolls_over_a_joint_of_facets_not_under_it():
    m = material()
    floor = [utils.facet(corners, material=m) for x in (-2, -1, 0, 1)
             for corners in ([(x, 0, -1), (x + 1, 0, -1), (x, 0, 1)],
                             [(x + 1, 0, 1), (x + 1, 0, -1), (x, 0, 1)])]
    *_, disc = build(*floor, rcr.disc((-1.5, 0.1), 0.1, material=m, velocity=(1, 0),
                                      angular_velocity=-10))
    steps(2000)
    x, y, _ = O.bodies[disc].state.pos
    assert x == pytest.approx(0.5, abs=2e-3) and y == pytest.approx(0.1, abs=1e-4)


def test_facet_turned_as_a_slope():
    """A slope of 45° without friction: a = g sin 45°."""
    slope = utils.facet([(-3, 3, -1), (3, -3, -1), (0, 0, 1)], material=material(0))
    at = 0.1 * math.sqrt(0.5)
    _, grain = build(slope, rcr.disc((at, at), 0.1, material=material(0)))
    steps(200)
    assert O.bodies[grain].state.vel[0] == pytest.approx(G / 2 * 0.2, rel=1e-6)


def test_fast_free_discs_and_spinning_boxes_do_not_tunnel():
    """The functor of stock spheres is replaced by one that looks ahead."""
    _, disc = build(FLOORS["Box"](material()), rcr.disc((0, 5), 0.1, velocity=(0, -400)))
    steps(40)
    assert O.bodies[disc].state.pos[1] > 0.09
    functors = [type(f).__name__ for f in O.engines[1].boundDispatcher.functors]
    assert functors.count("Bo1_Disc_Aabb") == 1
    box = utils.box((0, 0, 0), (1, 0.1, 1), material=material(), fixed=True)
    box.state.angVel = (0, 0, 20)
    _, disc = weightless(box, rcr.disc((0.8, 0.5), 0.1), dt=5e-3)
    steps(40)
    assert O.bodies[disc].state.vel.norm() > 5


@pytest.mark.parametrize("start, end", [((0, 0), (1, 0)), ((-0.3, 0.25, 0.5), (-0.05, 0, 0.5)),
                                        ((2, 1), (2, -1))])
def test_a_segment_goes_from_end_to_end(start, end):
    """A plain facet covers a part of its edge only."""
    O.reset()
    z = start[2] if len(start) > 2 else 0
    O.bodies.append([rcr.segment(start, end, material=material()),
                     rcr.disc((9, 9, z), 0.1, material=material())])
    ((_, _, ends),) = Frame.of(None).outlines
    assert sorted(map(tuple, np.round(ends, 12))) == sorted([start[:2], end[:2]])


@pytest.mark.parametrize("speed", [0.1, 0.3, 0.6])
def test_a_rod_that_slides_off_a_box_stays_on_its_corner(speed):
    """A far end of the rod must not replace the corner, which would sink in to the axis."""
    R = 0.01
    floor = utils.box((-0.1, -0.005, 0), (0.1, 0.005, 0.02), material=material(0.5), fixed=True)
    build(floor, rcr.particle((0.0092, 0.00301), R, 0.7, material=material(0.5),
                              velocity=(-speed, 0)), tolerance=1e-4)
    for _ in range(60):
        O.step()
        assert min(gaps(), default=0) > -0.02 * R


@pytest.mark.parametrize("height, start, count, first, alone", [
    pytest.param(1.1, (1.15, 0), 8, 1, 7, id="slides loaded, by 1 % of ρ and half a slop a step"),
    pytest.param(1.12, (1.5, -2.5), 3, 0, 1, id="arrives obliquely across 0.02 R"),
])
def test_a_disc_on_a_curved_path_needs_one_solve_a_step(height, start, count, first, alone):
    """A disc of R = 0.1 on a fixed one of R = 1, without friction: it stays within the slop."""
    _, disc = build(rcr.disc((0, 0), 1, fixed=True, material=material(0)),
                    rcr.disc((0, height), 0.1, velocity=start, material=material(0)), dt=1e-2)
    assert iterations(count)[first : first + alone] == [1] * alone
    assert abs(np.linalg.norm(O.bodies[disc].state.pos) - 1.1) < 1.1e-4
    assert O.forces.f(disc)[1] > 0 if height == 1.1 else velocity(disc)[1] > -0.2


@pytest.mark.parametrize("restitution", [0.01, 0.5, 1])
@pytest.mark.parametrize("step", [0.03, 0.1])
@pytest.mark.parametrize("obstacle, eta", [("disc", 0), ("corner", 0), ("end", 0), ("corner", 0.7)])
def test_a_near_miss_is_no_bounce(obstacle, eta, step, restitution):
    """It passes at 1e-3 R, moving `step` R a step across the plane of the contact."""
    R = 0.01
    m = material(0)
    for phase in (0, 0.37):
        fixed = dict(
            disc=lambda: rcr.disc((0, -R), R, fixed=True, material=m),
            corner=lambda: utils.box((R, -R, 0), (R, R, 1), fixed=True, material=m),
            end=lambda: rcr.segment((0, 0), (2 * R, 0), material=m),
        )[obstacle]()
        grain = rcr.particle(((-3 - phase * step) * R, (1.001 - eta) * R), R, eta, velocity=(1, 0),
                             material=m)
        _, grain = weightless(fixed, grain, dt=step * R, restitution=restitution)
        steps(round(6 / step))
        np.testing.assert_allclose(velocity(grain) * [1, 1, R], [1, 0, 0], rtol=0, atol=1e-3)


@pytest.mark.parametrize("eta, dt", [(0.8, 1e-4), (0.9, 1e-4), (0.9, 3e-4)])
def test_a_rod_glides_over_the_joints_of_a_floor(eta, dt):
    """Ten joints of segments in a line: the thin cap crosses the next end's plane only."""
    m = material(0)
    floor = [rcr.segment((0.02 * k - 0.03, 0), (0.02 * k - 0.01, 0), material=m) for k in range(14)]
    *_, rod = build(*floor, rcr.particle((0, 0.01 * (1 - eta)), 0.01, eta, velocity=(1, 0),
                                         material=m), dt=dt)
    O.engines[1].verletDist = 2e-3
    steps(round(0.2 / dt))
    assert O.bodies[rod].state.vel[0] == pytest.approx(1, abs=1.5e-3)


@pytest.mark.parametrize("make", [
    lambda m: utils.box((0, -0.001, 0), (0.05, 0.001, 0.1), fixed=True, material=m),
    lambda m: utils.box((0, -0.5, 0), (0.05, 0.5, 0.1), fixed=True, material=m),
    lambda m: rcr.segment((-0.05, 0), (0.05, 0), m),
], ids=["thin box", "box", "segment"])
def test_a_rod_bounces_flat_off_a_short_obstacle(make):
    """It reaches beyond both ends. Corners of the far face of a box are no contact points."""
    rough = material(0.3)
    weightless(make(rough), rcr.particle((0, 0.0205), 0.2, 0.9, material=rough, velocity=(0, -1)),
               restitution=0.5, tolerance=1e-10)
    O.step()
    assert velocity(1) == pytest.approx([0, 0.5, 0], abs=1e-9)


@pytest.mark.parametrize("arrays", [False, True])
def test_a_grain_far_behind_a_one_sided_wall_falls_freely(arrays):
    rough = material(0.3)
    build(rcr.wall("y", 0, 1, material=rough), rcr.disc((3, 0.1), 0.1, rough),
          rcr.particle((0, -5), 0.2, 0.8, material=rough, velocity=(0, -30)), tolerance=1e-10)
    solver().arrays = arrays
    with warns("body #2 lies behind a wall"):
        O.run(300, True)
    assert velocity(2)[1] == pytest.approx(-30 - 0.3 * G)
    assert solver().missedSteps == 0
