"""Polygons in frames, networks, clumps, time steps, warnings and pictures of a scene."""

import math
import warnings

import h5py
import numpy as np
import pytest
import rcr
import yade.utils
from matplotlib.image import imread
from rcr.frame import KINDS, Frame
from scenes import (G, build, kinetic, material, springs, springy, steps, velocity,
                    weightless)
from yade import O

SQUARE = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


def square(center, side=0.2, **options):
    return rcr.polygon(center, 0.5 * side * SQUARE, **options)


def pour(count=40, law="rigid", **options):
    """Polygons of three kinds, Rcrs and discs at rest in a box."""
    rng, m = np.random.default_rng(2), springy(0.4)
    make = [lambda at, R, angle: rcr.regular_polygon(at, R, 5, angle=angle, material=m),
            lambda at, R, angle: rcr.regular_polygon(at, R, 4, 0.3 * R, angle, material=m),
            lambda at, R, angle: rcr.truncated_triangle(at, R, 0.4, angle, material=m),
            lambda at, R, angle: rcr.particle(at, R, 0.5, angle, m),
            lambda at, R, angle: rcr.disc(at, R, m)]
    grains = [make[k % 5]((0.12 + 0.21 * (k % 5), 0.12 + 0.21 * (k // 5)),
                          rng.uniform(0.05, 0.1), rng.uniform(0, 6)) for k in range(count)]
    walls = [rcr.wall(axis, at, material=m) for axis, at in (("x", 0), ("x", 1.1), ("y", 0))]
    return build(*walls, *grains, law=law, tolerance=1e-5, **options)[3:]


def corners_of(body):
    """Corners of the core in the plane, complex."""
    ori = body.state.ori
    turned = np.array(body.shape.vertices) @ [1, 1j] * np.exp(2j * math.atan2(ori[2], ori[3]))
    x, y, _ = body.state.pos
    return turned + complex(x, y)


# ---- frames

def test_frames_have_the_outlines_of_the_bodies():
    ids = pour()
    O.step()
    frame = Frame.of()
    grains, shapes = frame.grains, frame.shapes
    assert len(shapes) == 3 and list(grains["id"]) == ids  # of 24 polygons of any size
    for k, body in enumerate(O.bodies[i] for i in ids):
        shape = grains["shape"][k]
        assert (shape >= 0) == isinstance(body.shape, rcr.RoundedPolygon)
        if shape < 0:
            continue
        R, cap = grains["R"][k], grains["cap_radius"][k]
        place = np.exp(1j * grains["angle"][k]) * R * shapes[shape].core
        assert place + grains["position"][k] @ [1, 1j] == pytest.approx(corners_of(body), abs=1e-12)
        assert R * shapes[shape].radius == pytest.approx(body.shape.radius)
        assert cap == pytest.approx(R * shapes[shape].inscribed)
    eta = 1 - grains["cap_radius"] / grains["R"]
    expected = [1 - math.cos(math.pi / 5), 0.7 * (1 - math.sqrt(0.5)), 0.4, 0.5, 0]
    assert eta == pytest.approx(np.tile(expected, 8))
    assert [KINDS[k] for k in frame.kinds()] == ["polygon", "polygon", "polygon", "rcr", "disc"] * 8
    mass = np.array([O.bodies[k].state.mass for k in ids])
    assert frame.areas() * 1000 == pytest.approx(mass, rel=1e-9)


def test_polygons_of_one_and_two_corners_have_the_lengths_of_their_twins():
    m = material()
    a, r = 0.06, 0.04
    line = rcr.polygon((0, 0), [(-a, 0), (a, 0)], r, material=m)
    weightless(line, rcr.particle((1, 0), a + r, a / (a + r), material=m),
               rcr.polygon((2, 0), [(0, 0)], r, material=m), rcr.disc((3, 0), r, m))
    grains = Frame.of().grains
    for one, two in ((0, 1), (2, 3)):
        for name in ("half_length", "cap_radius", "R", "mass"):
            assert grains[name][one] == pytest.approx(grains[name][two], rel=1e-14), name
    assert list(grains["shape"]) == [0, -1, 1, -1]


def test_measures_of_a_square():
    weightless(square((1, 2), 0.4, angle=0.3, material=material()))
    assert rcr.measure.areas()[1] == pytest.approx([0.16])
    half = 0.2 * (math.cos(0.3) + math.sin(0.3))
    extent = np.array([[1 - half, 2 - half], [1 + half, 2 + half]])
    assert rcr.measure.extent() == pytest.approx(extent)
    assert rcr.measure.porosity(volume=1) == pytest.approx(0.84)
    profile = rcr.Profile(cells=(1, 1), limits=((0, 0), (3, 3))).compute()
    assert profile.solid_fraction[0, 0] == pytest.approx(0.16 / 9)


# ---- networks

def test_a_network_of_polygons_returns_from_its_file(tmp_path):
    pour()
    steps(1500)
    network = rcr.contact_network(volume=1.1)
    network.save(tmp_path / "pile.h5")
    again = rcr.Network.load(tmp_path / "pile.h5")
    assert {1, 2, 3} <= set(again.contacts["type"])
    assert np.array_equal(again.stress(), network.stress())
    assert np.array_equal(again.grain_stresses(), network.grain_stresses())
    for one, two in zip(again.shapes, Frame.of().shapes):
        assert np.array_equal(one.corners, two.corners) and one.radius == two.radius
    with h5py.File(tmp_path / "pile.h5") as file:
        assert file["shapes/count"][:].tolist() == [5, 4, 6]
    picture = rcr.snapshot(tmp_path / "pile.png", again, contacts="type", color="type")
    assert imread(picture)[..., :3].std() > 0.05


def test_bodies_of_a_network_are_those_of_the_scene():
    """As on the page of network files."""
    ids = pour()
    O.step()
    network, p = rcr.contact_network(volume=1.1), Frame.of().grains
    for k, body in enumerate(O.bodies[i] for i in ids):
        if (shape := network.particles["shape"][k]) < 0:
            continue
        outline, R = network.shapes[shape], p["R"][k]
        twin = rcr.polygon(p["position"][k], R * outline.corners, R * outline.radius, p["angle"][k],
                           material=body.material)
        assert corners_of(twin) == pytest.approx(corners_of(body), abs=1e-12)
        assert twin.shape.radius == pytest.approx(body.shape.radius)
        assert twin.state.mass == pytest.approx(body.state.mass)
        assert twin.state.inertia[2] == pytest.approx(body.state.inertia[2])


def test_a_weight_on_a_corner_and_on_sides():
    """A square has two points at the floor on its side, one on its corner; both bear its weight."""
    m = material(0.5)
    for angle, points in ((0, 2), (math.pi / 4, 1)):
        height = 0.1 if points == 2 else 0.1 * math.sqrt(2)
        build(rcr.wall("y", 0, material=m), square((0, height), angle=angle, material=m), dt=1e-4)
        steps(20)
        contacts = rcr.contact_network().contacts
        assert list(contacts["points"]) == [points] and list(contacts["type"]) == [3]
        assert contacts["force"][0] == pytest.approx([0, -40 * G], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("angle, type_", [(0, 2), (math.pi / 4, 1)])
def test_types_of_contacts(angle, type_):
    """A square upon a fixed or free one: side-side or corner-side."""
    m = material(0.5)
    top = 0.3 if type_ == 2 else 0.2 + 0.1 * math.sqrt(2)
    build(rcr.wall("y", 0, material=m), square((0, 0.1), material=m),
          square((0, top), angle=angle, material=m), dt=1e-4)
    steps(20)
    contacts = rcr.contact_network().contacts
    assert list(contacts["type"][contacts["body2"] >= 0]) == [type_]


# ---- clumps

def test_a_clump_of_squares_has_the_moments_of_its_union():
    """An L of two squares that share half a square; then a plus of two bars of any material."""
    build()
    m = material(density=2000)
    clump, members = rcr.clump([square((0, 0), material=m), square((0.1, 0), material=m)])
    s = O.bodies[clump].state
    assert s.mass == pytest.approx(2000 * 0.3 * 0.2, rel=1e-12)
    assert (s.pos[0], s.pos[1]) == pytest.approx((0.05, 0), abs=1e-12)
    assert s.inertia[2] == pytest.approx(s.mass * (0.3**2 + 0.2**2) / 12, rel=1e-12)
    bar = lambda angle: rcr.polygon((1, 0), SQUARE * [0.3, 0.1], angle=angle, material=m)
    plus, _ = rcr.clump([bar(0), bar(math.pi / 2)])
    assert O.bodies[plus].state.mass == pytest.approx(2000 * (2 * 0.12 - 0.04), rel=1e-9)
    mixed, _ = rcr.clump([rcr.disc((3, 0), 0.1, m), square((3.2, 0), material=m)])
    assert O.bodies[mixed].state.mass == pytest.approx(2000 * (math.pi * 0.01 + 0.04), rel=1e-9)
    frame = Frame.of()
    assert frame.areas().sum() * 2000 == pytest.approx(
        sum(O.bodies[k].state.mass for k in (clump, plus, mixed)), rel=1e-9)
    assert len(members) == 2 and set(frame.kinds()) == {KINDS.index("clumped")}


def test_a_clump_of_squares_rests():
    m = material(0.5)
    build(rcr.wall("y", 0, material=m))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clump, _ = rcr.clump([square((0, 0.1), material=m), square((0.1, 0.1), material=m),
                              square((0, 0.3), material=m)])
        steps(300)
    assert abs(velocity(clump)).max() < 1e-9 and kinetic() < 1e-12
    assert O.bodies[clump].state.pos[1] == pytest.approx(
        (0.06 * 0.1 + 0.04 * 0.3) / 0.1, abs=1e-6)


# ---- springs

@pytest.mark.parametrize("make, R, arm, reach, points", [
    (lambda m: O.bodies.append(square((0, 0.1), material=m)),
     0.1 * math.sqrt(2), 0.1, 0.1 * math.sqrt(2), 6),
    (lambda m: O.bodies.append(rcr.regular_polygon((0, 0.1), 0.1, 6, 0.02, material=m)),
     0.1, 0.04, 0.1, 6),
    (lambda m: rcr.clump([square((x, 0.1), material=m) for x in (0, 0.2)])[0],
     0.1 * math.sqrt(2), 0.2, 0.1 + 0.1 * math.sqrt(2), 12),
], ids=["square", "hexagon", "clump"])
def test_the_critical_time_step_has_the_arms_of_the_corners(make, R, arm, reach, points):
    """ω² = 2 z k max(1/m, a²/I), without damping; k_n = E R and k_s = k_n/2."""
    build(law="smooth", damping=0)
    s, kn = O.bodies[make(springy())].state, 1e7 * R
    normal = math.sqrt(2 * points * kn * max(1 / s.mass, arm**2 / s.inertia[2]))
    shear = math.sqrt(points * kn * max(1 / s.mass, reach**2 / s.inertia[2]))
    assert rcr.critical_time_step() == pytest.approx(2 / max(normal, shear), rel=1e-9)


def test_a_square_between_lids_is_stable_below_the_critical_step():
    """Four points with springs on a square between two lids: a tilt neither grows nor jumps."""
    m = springy()
    for share, stable in ((0.95, True), (4, False)):
        _, _, k = springs(rcr.wall("y", 0, material=m), rcr.wall("y", 0.2 - 1e-5, material=m),
                          square((0, 0.1), material=m), gravity=(0, 0, 0), damping=0)
        O.bodies[k].state.angVel = (0, 0, 1e-4)
        O.dt = share * rcr.critical_time_step()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the time step
            steps(400)
        assert (abs(O.bodies[k].state.angVel[2]) < 1e-3) == stable


# ---- warnings and pictures

@pytest.mark.parametrize("make, text", [
    (lambda m: [square((0, 0), material=m)], "the polygons of"),
    (lambda m: [square((0, 0), material=m), rcr.particle((1, 0), 0.1, 0.5, material=m)],
     "the Rcrs and polygons of"),
    (lambda m: [rcr.disc((0, 0), 0.1, m)], None)])
def test_functions_for_spheres_warn_of_polygons(make, text):
    weightless(*make(material()))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        yade.utils.porosity(1)
    told = [str(one.message) for one in told if "rcr.measure.porosity" in str(one.message)]
    assert len(told) == (text is not None) and all(text in one for one in told)


def test_a_picture_covers_the_area_of_the_polygons(tmp_path):
    """Coloured pixels over all pixels; lines of the outlines cover less than 4 %."""
    m = material()
    weightless(rcr.regular_polygon((0, 0), 0.1, 3, angle=0.2, material=m),
               rcr.regular_polygon((0.3, 0), 0.1, 6, radius=0.03, material=m))
    limits, area = ((-0.15, -0.15), (0.45, 0.15)), rcr.measure.areas()[1].sum()
    path = rcr.snapshot(tmp_path / "two.png", color="#00ff00", limits=limits, legend=False)
    picture = imread(path)[..., :3]
    green = (picture[..., 1] > picture[..., 0] + 0.2).mean()
    assert green == pytest.approx(area / (0.6 * 0.3), rel=0.06)
