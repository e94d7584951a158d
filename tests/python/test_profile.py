"""Fields on a grid sum to those of grains and contacts, on any grid and in sheared cells."""

import numpy as np
import pytest
import rcr
from hypothesis import given, settings
from hypothesis import strategies as st
from rcr.frame import Frame
from rcr.network import Network

from common import refused
from synthetic import particles

BOX = (0, 0), (10, 6)


def scene(seed, count=30, cell=None):
    """A network of random grains in a box of 10 × 6; contacts anywhere, any pushing forces."""
    rng = np.random.default_rng(seed)
    size = np.array([10.0, 6.0])
    eta = rng.uniform(0, 0.8, count)
    radius = rng.uniform(0.2, 0.5, count)
    grains = particles(count) | dict(
        position=rng.uniform(0.5, size - 0.5, (count, 2)), angle=rng.uniform(0, 3, count), R=radius,
        cap_radius=(1 - eta) * radius, half_length=eta * radius, mass=rng.uniform(1, 2, count),
        velocity=rng.normal(0, 1, (count, 3)))
    one = rng.integers(0, count, 3 * count)
    two = (one + rng.integers(1, count, 3 * count)) % count
    x, y = (grains["position"][two] - grains["position"][one]).T
    angle = np.arctan2(y, x) + rng.uniform(-1, 1, 3 * count)  # from body 1 to body 2
    n = np.column_stack([np.cos(angle), np.sin(angle)])
    t = np.column_stack([-n[:, 1], n[:, 0]])
    wall = rng.random(3 * count) < 0.2
    position = grains["position"][one] + radius[one, None] * n
    branch = np.where(wall[:, None], position, grains["position"][two]) - grains["position"][one]
    force = rng.exponential(1, (3 * count, 1)) * (n + rng.uniform(-0.3, 0.3, (3 * count, 1)) * t)
    contacts = dict(body1=one, body2=np.where(wall, -7, two), type=np.where(wall, 3, 0), normal=n,
                    branch=branch, force=force, position=position, points=np.ones(3 * count, int))
    attributes = dict(volume=60.0)
    if cell is not None:
        attributes |= dict(cell=cell, cell_velocity=np.array([[0, 0.5], [0, 0]]) @ cell)
    return Network(grains, contacts, attributes)


grids = st.tuples(st.integers(1, 9), st.integers(1, 9))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), cells=grids)
def test_sums_over_the_grid_are_those_of_the_scene(seed, cells):
    """Rounding of sums of 1e4 samples."""
    network = scene(seed)
    profile = rcr.Profile(cells, limits=((-5, -5), (15, 11))).compute(network)
    area = profile.cell_area
    total = lambda field: area * field.sum(axis=(0, 1))
    p = network.particles
    assert total(profile.stress) == pytest.approx(60 * network.stress(), rel=1e-9, abs=1e-9)
    assert total(profile.solid_fraction) == pytest.approx(Frame.of(network).areas().sum())
    momentum = p["mass"] @ p["velocity"][:, :2]
    assert profile._sum("momentum").sum(axis=(0, 1)) == pytest.approx(momentum, abs=1e-9)
    inner = network.contacts["normal"][network.between_particles]
    assert profile._sum("fabric").sum(axis=(0, 1)) == pytest.approx(inner.T @ inner, abs=1e-9)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 1000), cells=grids,
       turns=st.tuples(st.integers(-3, 3), st.integers(-3, 3)))
def test_images_in_a_periodic_cell_are_one(seed, cells, turns):
    """A scene moved by whole periods at their velocity has the same fields, but at edges."""
    cell = np.array([[10.0, 2.5], [0, 6.0]])
    network = scene(seed, cell=cell)
    profile = rcr.Profile(cells).compute(network)
    assert (profile.limits == [[0, 0], [10, 6]]).all()
    stress = 60 * profile.stress.mean(axis=(0, 1))
    assert stress == pytest.approx(60 * network.stress(), rel=1e-9, abs=1e-9)
    assert profile.solid_fraction.mean() * 60 == pytest.approx(Frame.of(network).areas().sum())
    shift, faster = cell @ turns, network.attributes["cell_velocity"] @ turns
    grains, contacts = network.particles, network.contacts
    grains = grains | dict(position=grains["position"] + shift,
                           velocity=grains["velocity"] + [*faster, 0])
    del grains["center"]
    contacts = contacts | dict(position=contacts["position"] + shift)
    again = rcr.Profile(cells).compute(Network(grains, contacts, network.attributes))
    assert again.solid_fraction == pytest.approx(profile.solid_fraction, abs=0.05)
    for field in (lambda grid: grid._sum("momentum"), lambda grid: grid.stress):
        total = field(profile).sum(axis=(0, 1))
        assert field(again).sum(axis=(0, 1)) == pytest.approx(total, abs=1e-8)


def test_a_contact_at_the_edge_of_the_periodic_cell_counts():
    """Its place −1e-17 + 10 is rounded to 10, the upper end of the last cells."""
    network = scene(1, cell=np.diag([10.0, 6.0]))
    network.contacts["position"][0] = -1e-17
    profile = rcr.Profile((3, 4)).compute(network)
    assert profile._sum("contacts").sum() == network.between_particles.sum()


def test_limits_anywhere_in_a_periodic_cell():
    """A grid that is moved by half a cell of the fields holds the same cells, moved too."""
    network = scene(3, cell=np.array([[10.0, 2.5], [0, 6.0]]))
    whole = rcr.Profile((4, 2)).compute(network)
    moved = rcr.Profile((4, 2), ((-5, 0), (5, 6))).compute(network)
    for field in ("solid_fraction", "velocity", "stress", "coordination"):
        there = np.roll(getattr(whole, field), 2, axis=0)
        assert getattr(moved, field) == pytest.approx(there, abs=1e-9), field
    up = rcr.Profile((1, 2), ((0, -3), (10, 3))).compute(network)
    layers = rcr.Profile((1, 2)).compute(network)
    for field in ("solid_fraction", "stress"):
        there = np.roll(getattr(layers, field), 1, axis=1)
        assert getattr(up, field) == pytest.approx(there, abs=1e-9), field
    shear = np.roll(layers.velocity, 1, axis=1) - [[[3.0, 0], [0, 0]]]  # 0.5/s below the cell
    assert up.velocity == pytest.approx(shear, abs=1e-9)


def test_limits_beyond_a_periodic_cell_are_refused():
    """Those given, and those of a first frame whose cell was larger."""
    large, small = (scene(4, cell=np.diag([10.0, height])) for height in (6.0, 5.5))
    words = "limits span 10 × 6 m, the periodic cell 10 × 5.5 m; expected limits within a cell"
    profile = rcr.Profile((2, 2)).compute(large)
    before = profile.solid_fraction
    refused(words, profile.compute, small, reset=False)
    np.testing.assert_array_equal(profile.solid_fraction, before)  # unchanged
    assert profile.compute(small).limits[1, 1] == 5.5
    refused(words, rcr.Profile((2, 2), BOX).compute, small)


def test_layers_are_means_of_a_map_and_moments_are_averaged():
    network = scene(1)
    layers, map_ = (rcr.Profile(cells, BOX).compute(network) for cells in ((1, 6), (5, 6)))
    assert layers.pressure[0] == pytest.approx(map_.pressure.mean(axis=0))
    assert layers.solid_fraction[0] == pytest.approx(map_.solid_fraction.mean(axis=0))
    assert layers.centers[1] == pytest.approx(np.arange(6) + 0.5) and len(map_.edges[0]) == 6
    one, two = network, scene(2)  # averages over moments
    mean = rcr.Profile((3, 3), BOX).compute(one).compute(two, reset=False)
    apart = [rcr.Profile((3, 3), BOX).compute(network) for network in (one, two)]
    assert mean.stress == pytest.approx(0.5 * (apart[0].stress + apart[1].stress))
    assert mean.compute(two).stress == pytest.approx(apart[1].stress)


def test_a_turning_grain_and_a_grain_in_two_cells():
    """A disc (R = 1) on the border of two cells turns at 1/s: halves move by ±4/(3π)."""
    disc = particles(1) | dict(velocity=np.array([[0.0, 0, 1]]))
    empty = dict(body1=[], body2=[], type=[], normal=np.empty((0, 2)), branch=np.empty((0, 2)),
                 force=np.empty((0, 2)), position=np.empty((0, 2)), points=[])
    profile = rcr.Profile((2, 1), ((-1, -1), (1, 1))).compute(Network(disc, empty, {}))
    assert profile.solid_fraction[:, 0] == pytest.approx(np.pi / 4)
    # 60 samples
    assert profile.velocity[:, 0, 1] == pytest.approx([-4 / (3 * np.pi), 4 / (3 * np.pi)], rel=0.02)
    assert np.isnan(profile.fabric).all() and (profile.stress == 0).all()
    assert (profile.coordination == 0).all()


def test_plots_return_their_axes_and_draw_layers():
    """Along x for layers over y, along y for layers over x."""
    rows, columns, map_ = (rcr.Profile(cells, BOX).compute(scene(1))
                           for cells in ((1, 4), (4, 1), (4, 4)))
    for profile, quantity, drawn, values in (
            (rows, "velocity_x", lambda line: line.get_xdata(), rows.velocity[0, :, 0]),
            (columns, "pressure", lambda line: line.get_ydata(), columns.pressure[:, 0]),
            (map_, "shear_stress", None, None), (map_, "coordination", None, None)):
        ax = profile.plot(quantity=quantity)
        if drawn:
            (line,) = ax.get_lines()
            assert drawn(line) == pytest.approx(values)
        assert profile.plot(ax, quantity) is ax


def test_repr_of_a_profile():
    profile = rcr.Profile(cells=(1, 4), limits=((0, -1), (2, 1)))
    assert repr(profile) == "<Profile: 1 × 4 cells, nothing computed yet>"
    limits = "1 × 4 cells from (0, -1) to (2, 1) m"
    assert repr(profile.compute(scene(1))) == f"<Profile: {limits}, 1 moment>"
    assert repr(profile.compute(scene(2), reset=False)) == f"<Profile: {limits}, mean of 2 moments>"


def test_what_is_refused():
    refused(r"call compute\(\) first", lambda: rcr.Profile().stress, error=AttributeError)
    for cells in ((0, 3), (1.5, 2), (1,), 10):
        refused("cells", rcr.Profile, cells)
    refused("lower left and the upper right", rcr.Profile, (2, 2), ((1, 1), (0, 0)))
    grid = rcr.Profile(cells=(2, 2), limits=BOX).compute(scene(1))
    refused("quantity = 'heat'; expected one of", grid.plot, quantity="heat")
    before = grid.solid_fraction
    turned = scene(2, cell=np.array([[10.0, 0], [1.0, 6]]))
    refused("expected one along x", rcr.Profile().compute, turned)
    refused("first edge of the periodic cell", grid.compute, turned, reset=False)
    np.testing.assert_array_equal(grid.solid_fraction, before)  # unchanged


def test_a_lattice_at_the_lower_limit_is_counted_whole():
    """Rounding places some images just below the limit."""
    m, side = 7, 0.7
    radius = side / 2 / m
    at = lambda i, j: j % m * m + i % m
    position = np.array([(2 * radius * i, 0.3 + 2 * radius * j) for j in range(m)
                         for i in range(m)]) + [0.3, 0]
    one = np.repeat(np.arange(m * m), 2)
    two = np.array([other for j in range(m) for i in range(m)
                    for other in (at(i + 1, j), at(i, j + 1))])
    n, each = np.tile(np.eye(2), (m * m, 1)), np.ones(m * m)
    grains = particles(m * m) | dict(position=position, R=radius * each, cap_radius=radius * each,
                                     half_length=0 * each)
    contacts = dict(body1=one, body2=two, type=0 * one, points=0 * one + 1, normal=n,
                    branch=2 * radius * n, force=n, position=position[one] + radius * n)
    network = Network(grains, contacts, dict(cell=np.eye(2) * side, volume=side**2))
    for left in 0, 0.1:
        limits = (left, left), (left + side, left + side)
        profile = rcr.Profile((1, 4), limits).compute(network)
        assert profile.stress.mean(axis=(0, 1)) == pytest.approx(network.stress())
