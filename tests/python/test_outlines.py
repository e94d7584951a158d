"""Outlines, areas, unions, pictures and files of rounded polygons, without YADE."""

import h5py
import meshio
import numpy as np
import pytest
import rcr
from matplotlib.collections import PolyCollection
from rcr import _kernel, geometry, outlines
from rcr.frame import Frame
from rcr.network import Network
from rcr.outlines import Outline

from common import refused
from damage import put, replace
from synthetic import network, random_network


def regular(sides, radius=0.0):
    """A regular polygon of the circumscribed radius 1."""
    turn = 2 * np.pi / sides * np.arange(sides)
    return Outline((1 - radius) * np.column_stack([np.cos(turn), np.sin(turn)]), radius)


def random_shape(rng):
    """3 to 8 corners on a circle, about the centroid, with or without rounding."""
    gaps = rng.uniform(0.5, 2, rng.integers(3, 9))
    turn = np.cumsum(gaps / gaps.sum() * 2 * np.pi)
    corners, radius = np.column_stack([np.cos(turn), np.sin(turn)]), rng.choice([0, 0.1, 0.5])
    _, centroid, _ = _kernel.polygon_moments(corners, radius)
    R = np.hypot(*(corners - centroid).T).max() + radius
    return Outline((corners - centroid) / R, radius / R)


def mixed(count, seed=1, kinds=10):
    """Discs, Rcrs and polygons in each other, and their shapes."""
    rng = np.random.default_rng(seed)
    shapes = [random_shape(rng) for _ in range(kinds)]
    shape, R = rng.integers(-1, kinds, count), rng.uniform(0.5, 2, count)
    eta = np.where(rng.uniform(size=count) < 0.5, 0, rng.uniform(0, 0.9, count))
    inscribed = np.array([one.inscribed for one in shapes])[shape]
    cap = R * np.where(shape >= 0, inscribed, 1 - eta)
    return dict(position=rng.uniform(-1, 1, (count, 2)), angle=rng.uniform(0, 7, count),
                half_length=R - cap, cap_radius=cap, shape=shape), shapes


def row(grains, k):
    return {name: column[k] for name, column in grains.items()}


def inside(points, grains, shapes):
    """Mask (N, n) of points on the left of all sides of the drawn outlines."""
    masks = []
    for k, outline in enumerate(geometry.polygons(grains, shapes, points=60)):
        along = np.roll(outline, -1, axis=0) - outline
        length = np.hypot(*along.T)
        along, start = along[length > 1e-9], outline[length > 1e-9]
        arm = points[:, None] - start
        masks.append((along[:, 0] * arm[..., 1] - along[:, 1] * arm[..., 0] >= 0).all(axis=1))
    return np.array(masks)


def test_areas_and_moments_are_those_of_the_kernel():
    grains, shapes = mixed(60)
    areas = geometry.areas(grains, shapes)
    for k, shape in enumerate(grains["shape"]):
        a, r = grains["half_length"][k], grains["cap_radius"][k]
        area, moment = _kernel.area(a, r), _kernel.polar_moment(a, r)
        if shape >= 0:
            one = shapes[shape]
            area, _, moment = _kernel.polygon_moments((a + r) * one.corners, (a + r) * one.radius)
        found, center, polar = geometry.union(row(grains, [k]), shapes)
        assert areas[k] == pytest.approx(area, rel=1e-12)
        assert found == pytest.approx(area, rel=1e-9) and polar == pytest.approx(moment, rel=1e-9)
        assert center == pytest.approx(grains["position"][k], abs=1e-9)


@pytest.mark.parametrize("count", [2, 3, 8])
def test_unions_are_those_of_points(count):
    """10⁴ random points, half of them covered, give areas with a deviation of 1 %."""
    rng = np.random.default_rng(count)
    for seed in range(3):
        grains, shapes = mixed(count, seed)
        low, high = geometry.bounds(grains, shapes)
        points = rng.uniform(low, high, (10_000, 2))
        covered = points[inside(points, grains, shapes).any(axis=0)]
        area, center, polar = geometry.union(grains, shapes)
        expected = len(covered) / len(points) * np.prod(high - low)
        assert area == pytest.approx(expected, rel=0.04)
        assert center == pytest.approx(covered.mean(axis=0), abs=0.05)
        second = ((covered - center) ** 2).sum(axis=1).mean() * area
        assert polar == pytest.approx(second, rel=0.08)


def test_two_squares_share_a_square():
    shapes, cap = [regular(4)], np.sqrt(0.5)
    grains = dict(position=np.array([[0, 0], [1, 1]]) * np.sqrt(0.5), angle=np.full(2, np.pi / 4),
                  half_length=np.full(2, 1 - cap), cap_radius=np.full(2, cap),
                  shape=np.zeros(2, int))
    area, center, _ = geometry.union(grains, shapes)
    assert area == pytest.approx(2 + 2 - 0.5, rel=1e-12)  # sides √2, shifted by half a side
    assert center == pytest.approx(np.full(2, np.sqrt(0.5) / 2), abs=1e-12)


def test_outlines_lie_at_the_rounding_radius_and_have_the_areas():
    grains, shapes = mixed(60)
    found = geometry.polygons(grains, shapes, points=200)
    low, high = geometry.boxes(grains, shapes)
    for k, outline in enumerate(found):
        x, y = outline.T
        area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
        assert area == pytest.approx(geometry.areas(row(grains, [k]), shapes)[0], rel=1e-4)
        assert np.array([outline.min(axis=0), outline.max(axis=0)]) == pytest.approx(
            np.array([low[k], high[k]]), abs=1e-3)
        shape, R = grains["shape"][k], grains["half_length"][k] + grains["cap_radius"][k]
        if shape < 0:
            continue
        z = (outline - grains["position"][k]) @ [1, 1j] / np.exp(1j * grains["angle"][k]) / R
        away = outlines.distances(z, shapes[shape].core)
        assert away == pytest.approx(np.full(len(z), shapes[shape].radius), abs=1e-12)
        assert abs(z).max() == pytest.approx(1, abs=1e-4)


def test_a_sharp_corner_is_one_point():
    assert [len(regular(5, r).points(11)) for r in (0, 0.1)] == [5, 5 * 5]  # 4 pieces per 72°


def test_samples_cover_each_grain_evenly():
    """Weights add up to 1. Points lie within the grain; their moments are those of the grain."""
    grains, shapes = mixed(40)
    points, weight = geometry.samples(grains, 40, shapes)
    assert weight.sum(axis=1) == pytest.approx(1)
    R = grains["half_length"] + grains["cap_radius"]
    centre = np.einsum("nk,nka->na", weight, points)
    assert np.hypot(*centre.T) == pytest.approx(np.zeros(40), abs=0.01 * R.max())
    for k in range(40):
        of_grain = inside(grains["position"][k] + points[k], row(grains, [k]), shapes)[0]
        assert weight[k][~of_grain].sum() < 0.01
        area, _, polar = geometry.union(row(grains, [k]), shapes)
        second = weight[k] @ (points[k] ** 2).sum(axis=1)
        assert second == pytest.approx(polar / area, rel=0.03)


def test_lever_arms_of_normals():
    """Half the length of a side for a regular polygon, and 0 for a disc."""
    assert regular(4).normal_arm == pytest.approx(np.sqrt(0.5))
    assert regular(4, 0.2).normal_arm == pytest.approx(0.8 * np.sqrt(0.5))
    assert Outline(np.array([[-0.7, 0], [0.7, 0]]), 0.3).normal_arm == pytest.approx(0.7)
    assert Outline(np.zeros((1, 2)), 1.0).normal_arm == 0


# ---- networks and their files

SHAPES = [regular(4), regular(6, 0.2)]


def polygon_network():
    """A square, an Rcr and a rounded hexagon of R = 2."""
    inscribed = np.array([SHAPES[0].inscribed, 0.6, 2 * SHAPES[1].inscribed])
    plain = network(np.array([0, 1.0]), np.ones((2, 2)), np.ones((2, 2)), grains=3,
                    body2=np.array([1, 2]))
    lengths = dict(R=np.array([1.0, 1, 2]), cap_radius=inscribed, shape=np.array([0, -1, 1]),
                   half_length=[1, 1, 2] - inscribed, angle=np.array([0.3, 1, 2]),
                   position=np.array([[0.0, 0], [2, 0], [5, 1]]))
    return Network(plain.particles | lengths, plain.contacts, plain.attributes, SHAPES)


def test_polygons_return_from_a_file(tmp_path):
    test = polygon_network()
    test.save(tmp_path / "network-0.h5")
    again = Network.load(tmp_path / "network-0.h5")
    for name, column in test.particles.items():
        assert np.array_equal(again.particles[name], column), name
    for one, two in zip(test.shapes, again.shapes):
        assert np.array_equal(one.corners, two.corners) and one.radius == two.radius
    assert len(again.shapes) == 2 and np.array_equal(again.areas(), test.areas())
    hexagon = _kernel.polygon_moments(2 * SHAPES[1].corners, 0.4)[0]
    assert again.areas() == pytest.approx([2, np.pi * 0.6**2 + 4 * 0.4 * 0.6, hexagon])
    assert list(again.kinds()) == [4, 0, 4] and np.array_equal(again.extent(), test.extent())


def test_files_without_polygons_have_no_shapes(tmp_path):
    path = tmp_path / "network-0.h5"
    random_network().save(path)
    with h5py.File(path) as file:
        assert set(file) == {"particles", "contacts"} and "shape" not in file["particles"]
    again = Network.load(path)
    assert (again.particles["shape"] == -1).all() and again.shapes == []


@pytest.mark.parametrize("name, change, says", [
    ("particles/shape", put(0, 2), r"shape\[0\] = 2; expected −1, or a row of the 2 shapes"),
    ("particles/shape", put(0, 1), r"cap_radius\[0\] = 0.70.*; expected the inscribed radius"),
    ("particles/shape", put(1, -2), r"particles/shape\[1\] = -2; expected −1, or a row"),
    ("shapes/count", put(0, 5), r"corners has 10 rows; expected 11, the sum of shapes/count"),
    ("shapes/count", put(0, 0), r"shapes/count\[0\] = 0; expected 1 to 64 corners"),
    ("shapes/count", put(0, 99), r"shapes/count\[0\] = 99; expected 1 to 64 corners"),
    ("shapes/count", None, "group 'shapes' lacks count"),
    ("shapes/radius", put(1, -0.1), r"shapes\[1\].radius = -0.1; expected a rounding radius"),
    ("shapes/radius", put(1, 0.3), r"shapes\[1\] reaches 1.1 from its centre"),
    ("shapes/radius", lambda c: c[:1], r"shapes/count has shape \(2,\); expected \(1,\)"),
    ("shapes/corners", put((0, 0), np.nan), r"shapes\[0\].corners\[0, 0\] = nan"),
    ("shapes/corners", lambda c: c[::-1], r"shapes\[0\].corners is not a convex polygon"),
    ("shapes/corners", put(1, [-0.1, -0.1]), r"shapes\[0\].corners is not a convex polygon"),
])
def test_shapes_without_meaning_are_refused(tmp_path, name, change, says):
    path = tmp_path / "network-0.h5"
    polygon_network().save(path)
    with h5py.File(path, "r+") as file:
        replace(name, change)(file) if change else file.pop(name)
    error = refused(says, Network.load, path)
    assert str(path) in error and "\n" not in error


def test_a_network_checks_its_shapes():
    test = polygon_network()
    shape = lambda corners, radius: Network(test.particles, test.contacts, {}, [(corners, radius)])
    refused(r"shapes\[0\].corners has 2 rows; .* three or more without rounding",
            shape, [(1, 0), (-1, 0)], 0)
    refused(r"shapes\[0\].corners has shape \(3,\)", shape, [1, 2, 3], 0)
    refused("lies -.* within its sides", shape, [(0.8, 0), (1, 0), (0.9, 0.1)], 0)


def test_pictures_show_the_outlines():
    test = polygon_network()
    (drawn,) = (c for c in rcr.plot.packing(test).collections if isinstance(c, PolyCollection))
    outline = [path.vertices[:-1] for path in drawn.get_paths()]
    corners = SHAPES[0].corners @ [1, 1j] * np.exp(0.3j)
    assert outline[0] @ [1, 1j] == pytest.approx(corners)
    assert len(outline) == 3 and len(outline[2]) > 6


def test_corners_are_named_where_all_grains_are_polygons():
    test = polygon_network()
    hexagons = Network(test.particles | dict(
        shape=np.ones(3, int), cap_radius=test.particles["R"] * SHAPES[1].inscribed,
        half_length=test.particles["R"] * (1 - SHAPES[1].inscribed)), test.contacts, {}, SHAPES)
    for of, kinds, end in ((test, {"rcr", "polygon"}, "cap"), (hexagons, {"polygon"}, "corner")):
        figure = rcr.plot.packing(of, color="type", contacts="type").figure
        names = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
        assert set(names) == kinds | {f"{end}-{end}", f"{end}-side", "side-side", "obstacle"}


def test_paraview_gets_the_outlines(tmp_path):
    test = polygon_network()
    (grains, *_) = rcr.export.vtk(tmp_path / "scene.vtm", test)
    mesh = meshio.read(grains)
    areas, ids = [], []
    for block, rows in zip(mesh.cells, mesh.cell_data["id"]):
        x, y = np.moveaxis(mesh.points[block.data][..., :2], -1, 0)
        areas.extend(0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
        ids.extend(rows)
    assert sorted(ids) == [0, 1, 2]
    assert np.array(areas)[np.argsort(ids)] == pytest.approx(test.areas(), rel=0.02)


def test_profiles_hold_the_whole_area():
    test = polygon_network()
    profile = rcr.Profile(cells=(3, 4)).compute(test)
    assert profile.solid_fraction.sum() * profile.cell_area == pytest.approx(test.areas().sum())
    assert rcr.measure.extent(test) == pytest.approx(np.array(
        geometry.bounds(test.particles, SHAPES)))
