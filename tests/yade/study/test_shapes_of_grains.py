"""The biaxial test with other shapes, sizes and rolling friction: grains, contacts, checkpoints."""

import math

import numpy as np
import pytest
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE
from rcr.study import grains
from rcr.study.biaxial import Biaxial
from rcr.study.compaction import random_radii
from rcr.study.protocol import PROTOCOL, check_parameters
from rcr.study.runs import Run
from yade import O

CASES = {
    "trimer": dict(shape="trimer", eta=0.3),
    "rolling": dict(eta=0, rolling_friction=0.1, size_span=3),
    "pentagon": dict(shape="regular", sides=5),
}


def union_of_trimer(R, eta):
    """Area and polar moment of a trimer, by arcs about its centre, and radius of its discs.

    An arc of radius r about (s, 0) from −α to α has ½ ∮ (x dy − y dx) = r² α + s r sin α.
    """
    s = R * eta * (2 - eta) / (1 + eta)
    r, inner = R - s, R * (1 - eta)
    a = math.atan2(inner * math.sqrt(0.75), inner / 2 - s)
    area = 3 * (r**2 * a + s * r * math.sin(a))
    square = s**2 + r**2
    polar = 3 / 4 * (2 * square * r**2 * a + 2 * math.sin(a) * s * r * (square + 2 * r**2)
                     + 2 * s**2 * r**2 * (a + math.sin(a) * math.cos(a)))
    return area, polar, r


@pytest.mark.parametrize("eta", [0.05, 0.3, 0.5])
def test_a_trimer_has_mass_and_inertia_of_the_union_of_its_discs(eta):
    test = Biaxial.prepare(shape="trimer", eta=eta, particles=20)
    density, total = PROTOCOL.density, 0
    for k, R in zip(test.grains, grains.circumscribed_radii(test.grains)):
        area, polar, r = union_of_trimer(R, eta)
        state = O.bodies[k].state
        assert state.mass == pytest.approx(density * area, rel=1e-10)  # coordinates are rounded
        assert state.inertia[2] == pytest.approx(density * polar, rel=1e-10)
        members = [O.bodies[m] for m in O.bodies[k].shape.members]
        one, two, _ = (np.array(m.state.pos - state.pos)[:2] for m in members)
        assert [m.shape.radius for m in members] == pytest.approx([r] * 3)
        # outlines of two discs intersect on the inscribed circle
        middle = (one + two) / 2
        reach = math.sqrt(r**2 - np.sum((one - middle) ** 2))
        assert np.linalg.norm(middle) + reach == pytest.approx((1 - eta) * R)
        total += area
    assert test.area == pytest.approx(total, rel=1e-10)
    assert len(O.bodies) == 20 * 4 + 4


def test_trimers_of_eta_0_are_discs():
    test = Biaxial.prepare(shape="trimer", eta=0, particles=10)
    assert len(O.bodies) == 14
    masses = [O.bodies[k].state.mass for k in test.grains]
    radii = grains.circumscribed_radii(test.grains)
    assert masses == pytest.approx(PROTOCOL.density * math.pi * radii**2)


def test_circles_do_not_depend_on_the_shape():
    """Each grain is inscribed in the circle of the disc with the same seed."""
    found = []
    for parameters in (dict(eta=0), dict(shape="trimer", eta=0.4), dict(eta=0.4)):
        test = Biaxial.prepare(particles=30, size_span=3, seed=5, **parameters)
        places = [O.bodies[k].state.pos for k in test.grains]
        radii = grains.circumscribed_radii(test.grains)
        found.append(np.column_stack([np.array(places)[:, :2], radii]))
    for other in found[1:]:
        assert other == pytest.approx(found[0], abs=1e-12)


def test_sizes_are_uniform_in_volume_fraction():
    """The area of the grains with radii up to R rises linearly with R."""
    radii = np.sort(random_radii(100_000, np.random.default_rng(1), 3))
    low = PROTOCOL.smallest_radius
    assert low <= radii[0] and radii[-1] <= 3 * low
    share = np.cumsum(radii**2) / np.sum(radii**2)
    assert np.abs(share - (radii - low) / (2 * low)).max() < 0.01


@pytest.fixture(params=CASES)
def compacted(request):
    test = Biaxial.prepare(particles=60, **CASES[request.param])
    test.compact()
    return test


def shape_of(test):
    """Positions of the members of each clump relative to its centre."""
    return np.array([[np.linalg.norm(O.bodies[m].state.pos - O.bodies[k].state.pos)
                      for m in O.bodies[k].shape.members]
                     for k in test.grains if O.bodies[k].isClump])


def test_compaction_leaves_a_balanced_packing_of_whole_grains(compacted):
    test = compacted
    first = test.isotropic
    assert np.diag(first.stress()) == pytest.approx(PROTOCOL.confining_stress, rel=0.05)
    assert 0.7 < test.packing_fraction < 0.95
    if test.parameters["shape"] == "trimer":
        assert np.ptp(shape_of(test) / grains.circumscribed_radii(test.grains)[:, None]) < 1e-9
        assert len(np.unique(first.particles["clump"])) == 60


def state(test):
    bodies = [O.bodies[k].state for k in (*test.grains, *test.walls)]
    return np.array([(*s.pos, *s.ori, *s.vel, *s.angVel) for s in bodies])


def test_checkpoint_continues_to_the_same_bits(compacted, tmp_path):
    test = compacted
    test.save(tmp_path)
    test.shear(6)
    straight, summary = state(test), test.summary()
    again = Biaxial.load(tmp_path)
    assert again.parameters == test.parameters
    again.shear(3)
    again.save(tmp_path)
    again = Biaxial.load(tmp_path)
    again.shear(3)
    assert np.array_equal(state(again), straight)
    names = "shape", "sides", "size_span", "rolling_friction", "eta"
    assert [summary[name] for name in names] == [test.parameters[name] for name in names]
    attributes = again.network().attributes
    kept = {name: summary[name] for name in names if summary[name] is not None}
    assert {name: attributes[name] for name in kept} == kept
    assert ("sides" in attributes) == (test.parameters["shape"] == "regular")


def test_rolling_friction_acts_between_grains_in_the_shear():
    test = Biaxial.prepare(particles=60, **CASES["rolling"])
    test.compact()
    test.shear(8)
    rolling = {True: set(), False: set()}
    moments = []
    for i in O.interactions:
        if i.isReal:
            between = max(i.id1, i.id2) < test.left
            rolling[between].add(i.phys.rollingFriction)
            moments.append(abs(i.phys.rollingMoment) if between else 0)
    assert rolling == {True: {0.1}, False: {0.0}} and max(moments) > 0


def test_networks_of_polygons_name_contacts_by_corners_and_sides(tmp_path):
    """Where sides of two pentagons touch, their directions differ by π/5 modulo 2π/5."""
    test = Biaxial.prepare(particles=60, **CASES["pentagon"])
    test.compact()
    for name in "isotropic.h5", "network-0.0100.h5":
        test.isotropic.save(tmp_path / name)
    (network,) = Run.read(tmp_path).networks
    contacts = network.contacts
    inner = network.between_particles
    one, two = (network.particles["angle"][network.rows(contacts[body][inner])]
                for body in ("body1", "body2"))
    period = 2 * math.pi / 5
    away = np.abs((one - two) % period - period / 2)
    kind = contacts["type"][inner]
    assert set(kind) <= {CAP_CAP, CAP_SIDE, SIDE_SIDE} and (kind == SIDE_SIDE).sum() > 20
    assert away[kind == SIDE_SIDE].max() < 0.01 < away[kind != SIDE_SIDE].mean()
    assert (contacts["points"][inner][kind == SIDE_SIDE] == 2).all()
    assert Run.read(tmp_path).kind.name == "5 sides"


def test_a_trimer_counts_as_one_grain_of_a_run(tmp_path):
    test = Biaxial.prepare(particles=60, **CASES["trimer"])
    test.compact()
    test.isotropic.save(tmp_path / "network-0.0100.h5")
    run = Run.read(tmp_path)
    assert run.size == 60 and len(run.networks[0].particles["id"]) == 180
    assert run.kind.name == "trimer η = 0.3"


def test_polygons_have_the_eta_of_their_sides():
    parameters = check_parameters(shape="regular", sides=5)
    assert parameters["eta"] == 1 - math.cos(math.pi / 5)
    assert check_parameters(**parameters) == parameters
    assert 0.05 > check_parameters(shape="regular", sides=12)["eta"] > 0.03


@pytest.mark.parametrize("parameters", [
    dict(shape="regular", sides=5), dict(shape="truncated", eta=0.5), dict(shape="hexagon", eta=0.4),
], ids=["regular", "truncated", "hexagon"])  # fmt: skip
def test_polygons_are_inscribed_in_the_circles(parameters):
    test = Biaxial.prepare(particles=12, **parameters)
    radii, eta = grains.circumscribed_radii(test.grains), test.parameters["eta"]
    for k, R in zip(test.grains, radii):
        corners = np.array(O.bodies[k].shape.vertices)
        side = np.roll(corners, -1, axis=0) - corners
        distance = np.abs(corners[:, 0] * side[:, 1] - corners[:, 1] * side[:, 0])
        assert (distance / np.hypot(*side.T)).min() == pytest.approx((1 - eta) * R)
    Biaxial.prepare(particles=12, eta=0)
    assert radii == pytest.approx(grains.circumscribed_radii(range(12)), abs=1e-12)
