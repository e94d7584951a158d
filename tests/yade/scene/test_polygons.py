"""Rounded polygons in scenes: bodies, rest, toppling, stacks, and the same bits as an Rcr."""

import math

import numpy as np
import pytest
import rcr
from scenes import (FLOORS, G, assert_reload_changes_nothing, build, gaps, kinetic, material,
                    solver, springy, steps, tilted, velocity, weightless)
from yade import O

SQUARE = [(1, 1), (-1, 1), (-1, -1), (1, -1)]


def square(center, side=0.2, **options):
    return rcr.polygon(center, 0.5 * side * np.array(SQUARE), **options)


# ---- bodies

def test_mass_and_inertia_of_known_shapes():
    m = material(density=2000)
    body = square((1, 2), material=m)
    assert body.state.mass == pytest.approx(2000 * 0.04)
    assert body.state.inertia[2] == pytest.approx(body.state.mass * 0.04 / 6)
    assert tuple(body.state.pos) == (1, 2, 0) and body.state.blockedDOFs == "zXY"
    R, n = 0.3, 7
    area = 0.5 * n * R**2 * math.sin(2 * math.pi / n)
    moment = area * R**2 / 6 * (2 + math.cos(2 * math.pi / n))
    body = rcr.regular_polygon((0, 0), R, n, material=m)
    assert body.state.mass == pytest.approx(2000 * area)
    assert body.state.inertia[2] == pytest.approx(2000 * moment)
    twin, disc = rcr.polygon((0, 0), [(0, 0)], 0.1, material=m), rcr.disc((0, 0), 0.1, material=m)
    assert twin.state.mass == pytest.approx(disc.state.mass)
    assert twin.state.inertia[2] == pytest.approx(disc.state.inertia[2])


def radii(body):
    """Circumscribed and inscribed radius about the centre of mass."""
    corners = np.array(body.shape.vertices)
    side = np.roll(corners, -1, axis=0) - corners
    inward = abs(corners[:, 0] * side[:, 1] - corners[:, 1] * side[:, 0]) / np.hypot(*side.T)
    return np.hypot(*corners.T).max() + body.shape.radius, inward.min() + body.shape.radius


@pytest.mark.parametrize("make, etas", [
    (rcr.truncated_triangle, [1 - math.sqrt(0.75), 0.3, 0.5]),
    (rcr.elongated_hexagon, [1 - math.sqrt(0.75), 0.3, 0.7]),
], ids=["truncated triangle", "elongated hexagon"])
def test_eta_is_that_of_both_radii(make, etas):
    for eta in etas:
        outer, inner = radii(make((0, 0), 0.2, eta))
        assert outer == pytest.approx(0.2) and (outer - inner) / outer == pytest.approx(eta)


def test_corners_may_have_any_origin_and_order():
    corners = np.array([(3, 1), (5, 1), (4, 4)])
    one, two = (rcr.polygon((1, 1), c, 0.1).shape for c in (corners, corners[::-1] - 7))
    assert np.allclose(sorted(map(tuple, one.vertices)), sorted(map(tuple, two.vertices)))
    assert np.allclose(np.mean(one.vertices, axis=0), 0, atol=0.05)  # the rounding moves it a little


def test_regular_polygon_is_rounded_within_r():
    outer, inner = radii(rcr.regular_polygon((0, 0), 0.2, 5, radius=0.05))
    assert outer == pytest.approx(0.2)
    assert inner == pytest.approx(0.05 + 0.15 * math.cos(math.pi / 5))


def test_from_outline_tells_its_error():
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    corners, error = rcr.from_outline(circle, vertices=8)
    assert len(corners) == 8 and 0.076 < error < 0.09  # 1 − cos 22.5° = 0.076 if evenly spaced
    corners, error = rcr.from_outline([*SQUARE, (0, 0), (0.5, 1)], vertices=8)
    assert len(corners) == 4 and error == 0
    rcr.polygon((0, 0), corners)
    _, error = rcr.from_outline([(0, 0), (2, 0), (5, 1), (3, 1)], vertices=3)
    assert error == 2  # of (0, 0), beyond the end of a side


@pytest.mark.parametrize("offset", [1, 30, 1e4])
def test_corners_have_any_origin(offset):
    """The digits of the offset cancel, those of the shape remain."""
    near, far = (rcr.polygon((0, 0), 0.01 * (np.array(SQUARE) + shift))
                 for shift in (0, (100 * offset, 70 * offset)))
    assert far.state.inertia[2] == pytest.approx(near.state.inertia[2], rel=1e-12 * max(1, offset))


def test_a_thin_oblique_polygon_has_a_velocity_in_a_profile():
    O.reset()
    O.bodies.append(rcr.polygon((0, 0), [(0, 0), (5, 4), (6, 5)], material=material()))
    O.bodies.append(rcr.disc((0, 20), 1, material=material()))
    profile = rcr.Profile(cells=(1, 1)).compute()
    assert np.isfinite(profile.solid_fraction).all() and (profile.velocity == 0).all()


@pytest.mark.parametrize("call, message", [
    (lambda: rcr.polygon((0, 0), [(0, 0), (1, 0), (2, 0), (1, 1)]), "vertex 1 .* not a convex"),
    (lambda: rcr.polygon((0, 0), SQUARE, radius=-1), "radius = -1"),
    (lambda: rcr.polygon((0, 0), [(0, 0), (1, 0)]), "expected a radius > 0 or three vertices"),
    (lambda: rcr.polygon((0, 0), [1, 2, 3]), r"vertices has shape \(3,\)"),
    (lambda: rcr.regular_polygon((0, 0), 1, 2), "sides = 2; expected a number of sides from 3"),
    (lambda: rcr.regular_polygon((0, 0), 1, 5, radius=1), "radius = 1; expected a rounding"),
    (lambda: rcr.truncated_triangle((0, 0), 1, 0.1), "eta = 0.1"),
    (lambda: rcr.truncated_triangle((0, 0), 1, 0.3, radius=0.1), "radius = 0.1; expected 0: this"),
    (lambda: rcr.elongated_hexagon((0, 0), 1, 0.3, radius=0.1), "radius = 0.1; expected 0: this"),
    (lambda: rcr.elongated_hexagon((0, 0), 1, 1), "eta = 1"),
    (lambda: rcr.from_outline([(0, 0), (1, 1), (2, 2)]), "not on one line"),
    (lambda: rcr.from_outline([(0, 0), (1, 0), (0.5, 1e-10)]), "not on one line"),
    (lambda: rcr.RoundedPolygon(vertices=[(0, 0), (1, 0), (0, 1)]), "centroid at"),
])  # fmt: skip
def test_refused(call, message):
    with pytest.raises((ValueError, RuntimeError), match=message):
        call()


# ---- contacts

@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("law, height, dt, count, low, high",
                         [("rigid", 0.25, 1e-3, 600, 0.1 - 1e-5, 0.1 + 1e-5),
                          ("smooth", 0.1, 2e-5, 5000, 0.09, 0.1001)], ids=["rigid", "smooth"])
def test_a_square_comes_to_rest_on_every_floor(floor, law, height, dt, count, low, high):
    m = springy()
    _, top = build(FLOORS[floor](m), square((0.02, height), material=m), dt=dt, law=law)
    steps(count)
    assert low < O.bodies[top].state.pos[1] < high
    assert law == "smooth" or np.abs(velocity(top)).max() < 1e-8


@pytest.mark.parametrize("other", ["Rcr", "Sphere", "RoundedPolygon"])
def test_grains_of_all_kinds_meet(other):
    """Two grains collide centrally, e = 0: both go on with their common velocity."""
    m = material(0)
    make = dict(Rcr=lambda at: rcr.particle(at, 0.1, 0.5, angle=math.pi / 2, material=m),
                Sphere=lambda at: rcr.disc(at, 0.1, material=m),
                RoundedPolygon=lambda at: rcr.regular_polygon(at, 0.1, 6, material=m))[other]
    for order in (1, -1):
        bodies = [square((-0.3, 0), material=m, velocity=(1, 0)), make((0.1, 0))]
        ids = weightless(*bodies[::order])
        if order < 0:
            ids = ids[::-1]
        steps(400)
        masses = [O.bodies[k].state.mass for k in ids]
        expected = masses[0] / sum(masses)
        assert velocity(ids[0])[0] == pytest.approx(expected, rel=1e-9)
        assert velocity(ids[1])[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("sides", [3, 4, 5, 8])
def test_a_regular_polygon_topples_beyond_half_its_central_angle(sides):
    """On a rough slope it rests up to the slope π/n, where its centre is above the lower corner."""
    m, R = material(10), 0.1
    inner = R * math.cos(math.pi / sides)
    for share, rolls in ((0.98, False), (1.02, True)):
        _, k = build(rcr.wall("y", 0, material=m),
                     rcr.regular_polygon((0, inner), R, sides, angle=-math.pi / 2 - math.pi / sides,
                                         material=m),
                     gravity=tilted(share * math.pi / sides), dt=1e-3)
        steps(1500)
        assert (abs(O.bodies[k].state.pos[0]) > R) == rolls
        assert rolls or abs(velocity(k)).max() < 1e-9


def test_a_block_slides_with_the_acceleration_of_its_slope():
    m, alpha, time = material(0.3), 0.5, 0.5
    _, k = build(rcr.wall("y", 0, material=m), square((0, 0.1), material=m), gravity=tilted(alpha))
    steps(int(time / O.dt))
    expected = G * (math.sin(alpha) - 0.3 * math.cos(alpha)) * time
    assert velocity(k)[0] == pytest.approx(expected, rel=1e-9)
    assert abs(velocity(k)[1:]).max() < 1e-9


def test_a_stack_of_squares_rests():
    m = material(0.5)
    build(rcr.wall("y", 0, material=m),
          *[square((0.01 * (-1)**k, 0.1 + 0.2 * k), material=m) for k in range(20)],
          tolerance=1e-10)
    start = np.array([b.state.pos for b in O.bodies])
    steps(2000)
    moved = np.array([b.state.pos for b in O.bodies]) - start
    assert abs(moved).max() < 1e-4 * 0.2
    assert kinetic() < 1e-12


def test_two_vertices_are_an_rcr_to_the_bit():
    def run(make):
        rng = np.random.default_rng(2)
        m = material(0.4)
        build(*[rcr.wall(axis, at, material=m) for axis, at in (("x", 0), ("x", 1), ("y", 0))],
              *[make((0.15 + 0.23 * (k % 4), 0.2 + 0.25 * (k // 4)), rng.uniform(0, 3), m)
                for k in range(16)], tolerance=1e-6)
        steps(400)
        return np.array([[*b.state.pos, *b.state.vel, *b.state.angVel] for b in O.bodies])

    a, r = 0.06, 0.04
    rcrs = run(lambda at, angle, m: rcr.particle(at, a + r, a / (a + r), angle, material=m))

    def polygon(at, angle, m):
        body = rcr.particle(at, a + r, a / (a + r), angle, material=m)
        half = body.shape.halfLength
        body.shape = rcr.RoundedPolygon(vertices=[(-half, 0), (half, 0)],
                                        radius=body.shape.capRadius)
        return body

    np.testing.assert_array_equal(run(polygon), rcrs)


def heap(count=30, law="rigid", dt=1e-3):
    rng = np.random.default_rng(4)
    m = springy(0.4)
    grains = [rcr.regular_polygon((0.15 + 0.22 * (k % 4), 0.2 + 0.22 * (k // 4)), 0.1,
                                  int(rng.integers(3, 9)), radius=rng.choice([0, 0.01]),
                                  angle=rng.uniform(0, 3), material=m) for k in range(count)]
    build(*[rcr.wall(axis, at, material=m) for axis, at in (("x", 0), ("x", 1), ("y", 0))],
          *grains, dt=dt, law=law, **(dict(tolerance=1e-4) if law == "rigid" else {}))


def test_a_heap_settles_without_overlap():
    heap()
    steps(4500)  # one grain balances on a corner for 2000 steps
    assert kinetic() < 1e-8 and min(gaps()) > -2e-4 * 0.2
    assert solver().missedSteps == 0


def test_arrays_and_a_reload_keep_the_bits(tmp_path):
    def run(arrays):
        heap()
        solver().arrays = arrays
        O.run(300, True)
        return np.array([[*b.state.pos, *b.state.ori, *b.state.vel] for b in O.bodies])

    by_engines = run(False)
    np.testing.assert_array_equal(run(True), by_engines)
    assert solver().model["array_steps"] > 200

    def go_on():
        O.run(100, True)
        return np.array([b.state.pos for b in O.bodies]).tolist()

    assert_reload_changes_nothing(tmp_path / "scene.xml.bz2", go_on)


def test_a_scene_without_the_functor_says_so():
    build(rcr.wall("y", 0), square((0, 0.1)))
    loop = O.engines[2]
    loop.geomDispatcher.functors = [
        f for f in loop.geomDispatcher.functors if "RoundedPolygon" not in type(f).__name__]
    with pytest.raises(ValueError, match="Ig2_Wall_RoundedPolygon_RcrGeom"):
        steps(1)


def test_a_corner_on_a_facet_does_not_pass():
    m = material(0.5)
    _, k = build(rcr.segment((-1, 0), (1, 0), material=m),
                 rcr.regular_polygon((0, 0.3), 0.1, 3, angle=-math.pi / 2, material=m))
    steps(1000)
    assert O.bodies[k].state.pos[1] > 0.04
