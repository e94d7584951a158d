"""Networks of any scene: grains, obstacles, friction, volume, periodic cells, clumps."""

import math

import numpy as np
import pytest
import rcr
import yade.utils
from rcr.frame import Frame
from rcr.network import OTHER, WALL, Network
from scenes import G, build, heap, material, shrinking_cell, steps
from yade import O, wrapper as w


@pytest.fixture(scope="module")
def resting():
    ids = heap()
    steps(2500)
    while O.engines[-2].unbalancedForce > 1e-9 and O.iter < 6000:
        steps(100)
    network = rcr.contact_network(volume=0.25)
    ids["center"] = np.array(O.bodies[ids["clump"]].state.pos)[:2]
    frame = Frame.of()
    weight = G * (sum(O.bodies[k].state.mass for k in ids["grains"])
                  + O.bodies[ids["clump"]].state.mass)
    frictions = {frozenset((i.id1, i.id2)): i.phys.tangensOfFrictionAngle for i in O.interactions}
    return ids, network, frame, weight, frictions


def test_obstacles_are_no_grains(resting):
    """Wall, box, facet, fixed grain are obstacles; discs are grains; no four walls needed."""
    ids, network, *_ = resting
    assert sorted(network.particles["id"]) == sorted([*ids["grains"], *ids["members"]])
    at_obstacles = network.contacts["body2"] < 0
    assert set(OTHER - network.contacts["body2"][at_obstacles]) == set(ids["obstacles"])
    assert (network.contacts["type"][at_obstacles] == WALL).all()
    assert (network.contacts["type"][~at_obstacles] < WALL).all()
    assert np.isin(network.contacts["body1"], network.particles["id"]).all()
    assert np.trace(network.fabric()) == pytest.approx(1) and network.coordination() > 2
    assert len(network.anisotropies()) == 5


def test_friction_is_that_of_the_contact(resting):
    _, network, _, _, frictions = resting
    c = network.contacts
    for one, two, friction in zip(c["body1"], c["body2"], c["friction"]):
        assert friction == frictions[frozenset((one, two if two >= 0 else OTHER - two))]
    assert len(set(c["friction"])) == 2  # smaller of the pair: tan 0.5 or tan 0.1
    assert network.friction_mobilization().max() <= 1 + 1e-6  # tolerance of the solver


def test_obstacles_carry_the_weight(resting):
    """The force on the obstacles is the weight of the grains, up to the remaining motion."""
    _, network, _, weight, _ = resting
    force = network.contacts["force"][network.contacts["body2"] < 0].sum(axis=0)
    assert force == pytest.approx([0, -weight], abs=2e-3 * weight)


def test_stresses_of_grains_and_of_the_scene(resting):
    """Σ A σ = V σ, with clumps too; grain stresses of network and scene agree."""
    _, network, frame, *_ = resting
    areas, stresses = Frame.of_network(network).areas(), network.grain_stresses()
    mean = np.einsum("n,nab->ab", areas, stresses) / 0.25
    assert mean == pytest.approx(network.stress(), rel=1e-9)  # rounding of sums
    free = ~frame.grains["fixed"]
    assert stresses == pytest.approx(frame.stress_tensors()[free], rel=1e-9, abs=1e-9)
    assert (network.grain_coordination() == frame.per_grain(frame.normal_force() > 0)[free]).all()


def test_a_clump_counts_as_one(resting):
    """The stress of a clump is symmetric up to its acceleration; arms start at its own centre."""
    ids, network, *_ = resting
    row, other = (list(network.particles["id"]).index(member) for member in ids["members"])
    stress = network.grain_stresses()
    assert np.array_equal(stress[row], stress[other])
    assert network.grain_coordination()[row] == network.grain_coordination()[other] >= 2
    assert stress[row][0, 1] == pytest.approx(stress[row][1, 0], abs=1e-2 * np.trace(stress[row]))
    # within a step
    assert network.particles["center"][row] == pytest.approx(ids["center"], abs=1e-5)
    assert network.particles["clump"][row] == ids["clump"]


def test_volume_is_asked_for_where_it_is_needed(resting, tmp_path):
    _, network, *_ = resting
    attributes = {name: value for name, value in network.attributes.items() if name != "volume"}
    bare = Network(network.particles, network.contacts, attributes)
    with pytest.raises(ValueError, match=r"no volume.*contact_network\(volume=…\)"):
        bare.stress()
    assert bare.sin_phi() == pytest.approx(network.sin_phi())
    assert bare.stress_angle() == network.stress_angle()
    bare.save(tmp_path / "bare.h5")
    again = Network.load(tmp_path / "bare.h5")
    assert "stress" not in again.attributes
    assert np.array_equal(again.contacts["friction"], network.contacts["friction"])
    assert np.array_equal(again.grain_stresses(), network.grain_stresses())


NO_BOX = "left, bottom, right and top Wall of a box"
ORDER = "are at x = .*; expected the order left, bottom, right, top"


@pytest.mark.parametrize("walls, match", [
    *((walls, NO_BOX) for walls in ((0, 1), (0, 1, 2, 99), (1, 0, 3, 2), "box", (0, 1, 2, 4))),
    *((walls, ORDER) for walls in ((2, 1, 0, 3), (0, 3, 2, 1), (2, 3, 0, 1))),
])  # fmt: skip
def test_walls_that_are_no_box(walls, match):
    build(rcr.wall("x", 0), rcr.wall("y", 0), rcr.wall("x", 1), rcr.wall("y", 2),
          rcr.particle((0.5, 0.5), 0.1, 0.5, material=material()))
    with pytest.raises(ValueError, match=match):
        rcr.contact_network(walls)


def test_scenes_without_a_free_grain_and_volumes_out_of_range():
    build(rcr.wall("y", 0), rcr.particle((0.5, 0.5), 0.1, 0.5, fixed=True, material=material()))
    with pytest.raises(ValueError, match="no free Rcr and no free Sphere"):
        rcr.contact_network()
    O.bodies.append(rcr.particle((2, 0.5), 0.1, 0.5, material=material()))
    for volume in (0, -1, math.nan, "large"):
        with pytest.raises(ValueError, match="volume = .*; expected the area of the region"):
            rcr.contact_network(volume=volume)
    assert len(rcr.contact_network().contacts["force"]) == 0


def test_periodic_cell_needs_no_walls():
    """The volume is that of the cell, the stress YADE's, whose branch vectors are a step later."""
    shrinking_cell()
    network = rcr.contact_network()
    volume = network.attributes["volume"]
    assert volume == pytest.approx(np.linalg.det(np.array(O.cell.hSize)[:2, :2]))
    assert len(network.contacts["force"]) > 10
    # branch of two touching grains, without a period
    assert np.hypot(*network.contacts["branch"].T).max() < 0.2
    stress = network.stress()
    total = np.einsum("n,nab->ab", rcr.measure.areas()[1], network.grain_stresses())
    assert total / volume == pytest.approx(stress, rel=1e-9)
    theirs = -np.array(yade.utils.getStress(volume))[:2, :2]
    assert stress == pytest.approx(0.5 * (theirs + theirs.T), abs=0.02 * np.trace(stress))
    assert sum(i.phys.normalForce.norm() > 0 and tuple(i.cellDist) != (0, 0, 0)
               for i in O.interactions) > 3


def test_networks_of_spheres_under_a_law_of_yade():
    m = material(math.tan(0.4))
    m.young = 1e6
    O.bodies.append([yade.utils.sphere((x, 0, 0), 1, material=m, fixed=x == 0)
                     for x in (0, 1.99, 3.98)])
    O.engines = [w.ForceResetter(), w.InsertionSortCollider([w.Bo1_Sphere_Aabb()]),
                 w.InteractionLoop([w.Ig2_Sphere_Sphere_ScGeom()],
                                   [w.Ip2_FrictMat_FrictMat_FrictPhys()],
                                   [w.Law2_ScGeom_FrictPhys_CundallStrack()]),
                 w.NewtonIntegrator()]  # fmt: skip
    O.dt = 1e-6
    O.step()
    frame = Frame.of()
    assert frame.normal_force() == pytest.approx([i.phys.normalForce.norm()
                                                  for i in O.interactions])
    assert frame.contacts["friction"] == pytest.approx(math.tan(0.4))
    assert list(frame.kinds()) == [3, 1, 1]
    network = rcr.contact_network(volume=8)
    assert list(network.contacts["body1"]) == [1, 1]
    assert list(network.contacts["body2"]) == [OTHER - 0, 2]
    assert network.contacts["normal"] == pytest.approx(np.array([[-1, 0], [1, 0]]))
    assert network.contacts["friction"] == pytest.approx(math.tan(0.4))
    force = np.hypot(*network.contacts["force"].T)
    # through the contact, and from centre to centre
    assert network.stress()[0, 0] == pytest.approx((force[0] * 0.995 + force[1] * 1.99) / 8)
