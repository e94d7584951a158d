"""Frames and networks of any scene: bodies, obstacles, contacts, cells, clumps, names, files."""

import math
import os
import stat
import warnings

import numpy as np
import pytest
import rcr
import yade.config
import yade.utils
from rcr._yade.counterparts import COUNTERPARTS
from rcr.frame import KINDS, Frame
from rcr.network import OBSTACLE, OTHER
from scenes import (G, LAWS, box, build, calls, heap, insert, material, plane, pressed_box, python,
                    refused, set_state, shrinking_cell, springy, stadium, steps, wait_until,
                    weightless)
from yade import O
from yade import wrapper as w
from yade.minieigenHP import Matrix3


def test_every_kind_of_body(tmp_path):
    """One of each, without contacts, in a frame, a picture and a table."""
    rough = material()
    ids = dict(zip(("rcr", "fixed", "wall", "box", "facet", "flat", "beside", "sphere"), build(
        rcr.particle((0, 0), 1.0, 0.75, 0.3, rough),
        rcr.particle((6, 0), 0.5, 0.4, material=rough, fixed=True),
        rcr.wall("y", -2, material=rough), box((3, -1), (1.0, 0.2), 0.5, rough),
        yade.utils.facet([(-3, 0, -1), (-3, 0, 1), (-2, 1, 1)], material=rough),
        yade.utils.wall(5, 2),
        yade.utils.facet([(0, 0, 1), (1, 0, 1), (0, 1, 2)], material=rough),
        yade.utils.sphere((-1, 3, 0), 0.3, material=rough),
    )))  # fmt: skip
    ids["clump"], ids["members"] = O.bodies.appendClumped(
        [rcr.particle((x, 5), 0.4, 0.5, angle, rough) for x, angle in ((0, 0), (0.2, math.pi / 2))])
    set_state(ids["rcr"], vel=(3, 4, 0), angVel=(0, 0, -2))
    frame = Frame.of()
    rows = frame.rows(np.array([ids["rcr"], ids["fixed"], ids["sphere"], *ids["members"],
                                ids["wall"], ids["clump"]]))
    assert (rows[:5] >= 0).all() and (rows[5:] == -1).all() and len(frame.grains["id"]) == 5
    assert [KINDS[k] for k in frame.kinds()[rows[:5]]] == ["rcr", "fixed", "disc", "clumped",
                                                           "clumped"]
    first = {name: column[rows[0]] for name, column in frame.grains.items()}
    assert first["angle"] == pytest.approx(0.3)
    assert (first["half_length"], first["cap_radius"]) == (0.75, 0.25)
    assert list(first["velocity"]) == [3, 4, -2] and list(first["position"]) == [0, 0]
    assert first["mass"] == pytest.approx(1000 * frame.areas()[rows[0]])
    assert frame.grains["cap_radius"][rows[2]] == 0.3 and frame.grains["half_length"][rows[2]] == 0
    assert set(frame.grains["clump"][rows[3:5]]) == {ids["clump"]}
    assert list(frame.walls["id"]) == [ids["wall"]]  # a facet parallel to the plane is left out
    (first, kind1, corners), (second, kind2, ends) = sorted(frame.outlines)  # no facet beside z = 0
    assert (first, kind1, second, kind2) == (ids["box"], "box", ids["facet"], "facet")
    c, s = math.cos(0.5), math.sin(0.5)
    assert corners[0] == pytest.approx(np.array([3 + c - 0.2 * s, -1 + s + 0.2 * c]))
    assert np.sort(ends, axis=0) == pytest.approx(np.array([[-3, 0], [-2.5, 0.5]]))
    path = rcr.snapshot(tmp_path / "zoo.png", color="type", contacts="force")
    assert os.path.getsize(path) > 5000
    old = os.umask(0o022)
    count = rcr.measure.write_table(tmp_path / "grains.txt")
    os.umask(old)
    table = np.genfromtxt(tmp_path / "grains.txt", names=True)
    assert table["id"][0] == ids["rcr"] and table["angle"][0] == pytest.approx(0.3, abs=1e-15)
    assert table["half_length"][0] == 0.75 and count == 5
    assert stat.S_IMODE(os.stat(tmp_path / "grains.txt").st_mode) == 0o644


def test_lever_arms_are_those_of_the_forces():
    """A fast disc hits a resting one: arms end at the centres of the impact, 0.05 R earlier."""
    one, _ = weightless(*(rcr.particle((x, 0), 1, 0, material=material(0), velocity=(v, 0))
                          for x, v in ((0, 10), (2.0, 0))), dt=1e-2, restitution=0)
    O.step()
    frame = Frame.of()
    contacts, arms = frame.contacts, frame.arms()
    sign = 1 if contacts["body1"][0] == one else -1
    assert O.bodies[one].state.pos[0] == pytest.approx(0.05)
    assert arms[0, 0] == pytest.approx([sign, 0])
    assert arms[1, 0] == pytest.approx([-sign, 0])
    assert contacts["force"][0] @ contacts["normal"][0] > 0


def test_a_network_is_a_selection_of_the_table():
    """Contacts with a free grain, which is body 1; obstacles and fixed grains are body 2."""
    heap()
    steps(600)
    frame, network = Frame.of(), rcr.contact_network(volume=1)
    free = frame.free_ends()
    bearing = np.flatnonzero(free[0] & (frame.normal_force() > 0))
    assert (free[0] | ~free[1]).all() and len(bearing) == len(network.contacts["type"]) > 10
    assert np.array_equal(frame.contacts["type"] == OBSTACLE, ~free[1]) and not free[1].all()
    rows = {(c["body1"], tuple(c["position"])): c for c in map(
        lambda k: {name: column[k] for name, column in frame.contacts.items()}, bearing)}
    for k in range(len(bearing)):
        c = {name: column[k] for name, column in network.contacts.items()}
        found = rows[c["body1"], tuple(c["position"])]
        for name in ("type", "points", "normal", "force", "friction", "point_moments", "branch"):
            fixed = name == "branch" and c["body2"] < 0
            assert fixed or np.array_equal(found[name], c[name], equal_nan=True), name
        assert c["body2"] in (found["body2"], OTHER - found["body2"])
    single = network.particles["clump"] < 0  # the area of a clump rounds differently elsewhere
    stress = frame.grain_stresses()[~frame.grains["fixed"]][single]
    rounding = 1e-12 * abs(stress).max()
    assert network.grain_stresses()[single] == pytest.approx(stress, abs=rounding)


def test_contact_points_lie_in_the_plane_of_the_grains():
    m = material()
    build(rcr.wall("y", 0, 1, material=m), *(rcr.disc((0, y, 3), 0.1, m) for y in (0.1, 0.3)))
    steps(5)
    assert [i.geom.contactPoint[2] for i in O.interactions] == [3, 3]


def test_contacts_across_the_edge_of_a_cell():
    """Two discs touch across the edge: arms are a radius long, not a period."""
    weightless(*(rcr.particle((3, y), 0.5, 0, material=material()) for y in (0.499, 7.5)), cell=2,
               law="smooth", dt=1e-7)
    O.cell.hSize = ((10, 0, 0), (0, 8, 0), (0, 0, 10))
    O.step()
    frame = Frame.of()
    arm1, arm2 = frame.arms()[:, 0]
    assert np.abs(arm1) == pytest.approx([0, 0.5], abs=1e-3)  # they overlap by 1e-3
    assert arm2 == pytest.approx(-arm1, abs=2e-3)
    assert frame.cell == pytest.approx(np.array([[10, 0], [0, 8]]))


def test_extent_and_porosity():
    build(rcr.particle((0, 0), 1, 0.5, math.pi / 2, material()),
          rcr.particle((4, 0), 1, 0, material=material()))
    low, high = rcr.measure.extent()
    assert low == pytest.approx([-0.5, -1]) and high == pytest.approx([5, 1])
    solid = math.pi * 0.25 + 1 + math.pi
    assert rcr.measure.porosity() == pytest.approx(1 - solid / 11)
    assert rcr.measure.porosity(volume=100) == pytest.approx(1 - solid / 100)
    for volume, more in ((0, ""), (1e-9, r" \[m²\], which holds grains of 4.92")):
        refused(f"volume = {volume:g}; expected the area of the region{more}", rcr.measure.porosity,
                volume=volume)
    O.reset()
    refused("nothing to measure", rcr.measure.porosity)
    # a cross of two stadiums, a clump: the sum of both less the square that they share
    O.bodies.appendClumped([rcr.particle((0.3, 2), 1, 0.8, 0.4 + angle, material())
                            for angle in (0, math.pi / 2)])
    own = math.pi * 0.2**2 + 4 * 0.2 * 0.8
    assert rcr.measure.areas()[1].sum() == pytest.approx(2 * own - 0.4**2, rel=2e-5)  # 2000 lines


NETWORK = "rcr.contact_network(volume=…)."
SPHERES_ONLY = {
    "utils.porosity()": "rcr.measure.porosity", "porosity()": "rcr.measure.porosity",
    "utils.aabbExtrema()": "rcr.measure.extent",
    "utils.bodyStressTensors()": "rcr.measure.stress_tensors",
    "export.text('/dev/null')": "rcr.measure.write_table",
    "export.textExt('/dev/null')": "rcr.measure.write_table",
    "export.VTKExporter('/dev/null')": "rcr.export.vtk",
    "utils.fabricTensor()": NETWORK + "fabric()", "getStress(1)": NETWORK + "stress()",
    "utils.avgNumInteractions()": NETWORK + "coordination()",
    "utils.getSpheresMass()": NETWORK + "particles['mass']",
    "utils.PWaveTimeStep()": "rcr.critical_time_step", "growParticles(1)": "rcr.particle",
}  # fmt: skip
if "VTK" in yade.config.features:
    SPHERES_ONLY["VTKRecorder()"] = "rcr.export.VtkSeries"


def test_functions_for_spheres_only_warn():
    done = python(f"""
from yade import *
from yade import utils, export
from yade.utils import *
import rcr, warnings
def tell():
    for call in {list(SPHERES_ONLY)}:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            eval(call)
        print("told", *(str(w.message) for w in told if "rcr" in str(w.message)))
O.bodies.append([utils.sphere((0, 0, 0), 1), utils.sphere((3, 0, 0), 1)])
tell()
O.bodies.append([rcr.particle((0, 5), 1, 0.5), rcr.wall("y", -9)])
tell()
""")
    told = [line.strip() for line in done.stdout.splitlines() if line.startswith("told")]
    silent = ["told"] * len(SPHERES_ONLY)
    assert told[: len(silent)] == silent and len(told) == 2 * len(silent)
    assert not [(wanted, line) for wanted, line in zip(SPHERES_ONLY.values(), told[len(silent) :])
                if wanted not in line]


def warnings_of_stress(volume, walls=None):
    """Warnings of getStress, and its largest relative difference from the network's stress."""
    network = rcr.contact_network(walls, volume=volume)
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        theirs = -np.array(yade.utils.getStress(volume))[:2, :2]
    ours = network.stress()
    assert np.trace(ours) > 0 and len(network.contacts["force"]) > 5
    return [str(warning.message) for warning in shown], np.abs(theirs - ours).max() / np.trace(ours)


def test_get_stress_warns_only_where_it_is_wrong():
    """getStress is right in a cell of free grains and wrong in a box of walls."""
    shrinking_cell()
    O.cell.velGrad = plane(-0.04, 0.005, 0, -0.04)
    steps(100)
    told, error = warnings_of_stress(abs(np.linalg.det(np.array(O.cell.hSize)[:2, :2])))
    assert told == [] and error < 2e-3  # bodies have moved since: 8e-4
    h = O.cell.hSize
    O.cell.hSize = Matrix3(h[0, 0], h[0, 1], 0, h[1, 0], h[1, 1], 0, 0, 0, 2)
    with pytest.warns(UserWarning, match="getStress without a volume divides by the depth of the "
                      "cell"):
        yade.utils.getStress()
    pressed_box()
    steps(200)
    told, error = warnings_of_stress(1.0, (0, 1, 2, 3))
    assert len(told) == 1 and "getStress is wrong for contacts with obstacles" in told[0]
    assert error > 0.05


@pytest.mark.parametrize("hint", COUNTERPARTS)
def test_counterparts_are_there(hint):
    """The code in a warning runs on a box under pressure; a function's name exists."""
    pressed_box()
    steps(200)
    value = eval(hint.split(" (")[0].replace("…", "0.8"),
                 dict(rcr=rcr, ContactDynamics=rcr.ContactDynamics))
    if "(" in hint.split(" (")[0]:
        assert np.isfinite(value).all() and np.any(value)


def test_import_of_all_names_shadows_none_of_yade():
    done = python("""
from yade import *
from yade import plot, export, utils
from yade.utils import *
before = dict(globals())
import rcr
from rcr import *
without_warning = lambda value: getattr(value, "__wrapped__", value)
print("changed", *(name for name in before if name != "before"
                   and without_warning(globals()[name]) is not before[name]))
print("wall", wall is utils.wall, callable(rcr.wall), Rcr is rcr.Rcr, particle is rcr.particle)
""")
    assert done.stdout.splitlines()[-2:] == ["changed", "wall True True True True"]


def test_info_describes_the_build():
    told = rcr.info()
    assert told["rcr"] == rcr.__version__ and told["YADE"] == yade.config.version
    assert told["lanes"] in (1, 4, 16)
    assert told["threads"] == O.numThreads
    lines = str(told).splitlines()
    assert len(lines) == len(told) and all(line.startswith(name) for line, name in zip(lines, told))
    drawn = "Gl1_Rcr" in dir(rcr)
    assert ("Gl1_Rcr" in told["3D view"]) == drawn and ("left out" in told["3D view"]) != drawn


def test_series_from_a_pyrunner_survives_save_and_load(tmp_path):
    pytest.importorskip("meshio")
    out = tmp_path / "out"
    pressed_box()
    command = f"import rcr; rcr.export.VtkSeries({str(out)!r}).save()"
    O.engines = [*O.engines, yade.wrapper.PyRunner(command=command, iterPeriod=10)]
    steps(25)
    O.save(str(tmp_path / "scene.yade"), quiet=True)
    steps(20)
    O.reset()
    O.load(str(tmp_path / "scene.yade"), quiet=True)
    steps(30)
    moments = rcr.export.VtkSeries(out).moments()
    times = sorted({time for time, _ in moments})
    assert np.diff(times) == pytest.approx(10 * O.dt) and len(times) >= 5
    assert len(moments) == 3 * len(times)
    assert all((out / file).exists() for _, file in moments)
    O.tags["id"] += "-of-another-run"
    rcr.export.VtkSeries(out).save()
    assert {time for time, _ in rcr.export.VtkSeries(out).moments()} == {O.time}


# --- networks of any scene

@pytest.fixture(scope="module")
def resting():
    ids = heap()
    steps(2500)
    while O.engines[-2].unbalancedForce > 1e-9 and O.iter < 6000:
        steps(100)
    network = rcr.contact_network(volume=0.25)
    ids["center"] = np.array(O.bodies[ids["clump"]].state.pos)[:2]
    weight = G * sum(O.bodies[k].state.mass for k in (*ids["grains"], ids["clump"]))
    frictions = {frozenset((i.id1, i.id2)): i.phys.tangensOfFrictionAngle for i in O.interactions}
    return ids, network, Frame.of(), weight, frictions


def test_obstacles_carry_the_weight(resting):
    """Of the grains, up to the remaining motion; no four walls are needed, and discs are grains."""
    ids, network, _, weight, frictions = resting
    assert sorted(network.particles["id"]) == sorted([*ids["grains"], *ids["members"]])
    at_obstacles = network.contacts["body2"] < 0
    assert set(OTHER - network.contacts["body2"][at_obstacles]) == set(ids["obstacles"])
    assert (network.contacts["type"][at_obstacles] == OBSTACLE).all()
    assert (network.contacts["type"][~at_obstacles] < OBSTACLE).all()
    assert np.isin(network.contacts["body1"], network.particles["id"]).all()
    assert np.trace(network.fabric()) == pytest.approx(1) and network.coordination() > 2
    assert len(network.anisotropies()) == 5
    c = network.contacts
    assert c["force"][at_obstacles].sum(axis=0) == pytest.approx([0, -weight], abs=2e-3 * weight)
    for one, two, friction in zip(c["body1"], c["body2"], c["friction"]):
        assert friction == frictions[frozenset((one, two if two >= 0 else OTHER - two))]
    assert len(set(c["friction"])) == 2  # smaller of the pair: tan 0.5 or tan 0.1
    assert network.friction_mobilization().max() <= 1 + 1e-6  # tolerance of the solver


def test_a_network_has_the_stresses_and_forces_of_its_scene(resting, tmp_path):
    """Σ A σ = V σ, with clumps too; a frame of the saved network is that of the scene."""
    _, network, scene, *_ = resting
    network.save(tmp_path / "network.h5")
    saved, free = Frame.of(tmp_path / "network.h5"), ~scene.grains["fixed"]
    mean = np.einsum("n,nab->ab", saved.areas(), network.grain_stresses()) / 0.25
    assert mean == pytest.approx(network.stress(), rel=1e-9)  # rounding of sums
    assert np.array_equal(saved.grain_stresses(), network.grain_stresses())
    assert saved.grain_stresses() == pytest.approx(scene.grain_stresses()[free], rel=1e-9, abs=1e-9)
    assert saved.per_grain(saved.normal_force()) == pytest.approx(
        scene.per_grain(scene.normal_force())[free])
    assert (network.grain_coordination() == scene.per_grain(scene.normal_force() > 0)[free]).all()

    def mobilization(frame, chosen):
        """Mobilized friction of the chosen contacts, in the order of their bodies."""
        pairs = np.sort([frame.contacts[name][chosen] for name in ("body1", "body2")], axis=0)
        return frame.mobilization()[chosen][np.lexsort(pairs)]

    bearing = scene.free_ends().all(axis=0) & (scene.normal_force() > 0)
    of_network = mobilization(saved, saved.between_particles)
    assert of_network == pytest.approx(mobilization(scene, bearing))
    kinds = lambda frame: np.bincount(frame.contacts["type"][frame.normal_force() > 0])
    assert np.array_equal(kinds(scene)[:3], kinds(saved)[:3])  # of contacts between free grains
    assert scene.mobilization().max() <= 1 + 1e-6  # the law's limit, to the tolerance of the solver


@pytest.mark.parametrize("change, says", [
    (lambda: setattr(O, "dt", 2 * O.dt), "O.dt is 0.002, but was 0.001 in the last step"),
    (lambda: set_state(vel=(0, -1, 0)), "the velocity of .*#1 differs from that in the last step"),
    (lambda: set_state(0, vel=(0, 1, 0)),
     "the velocity of .*#0 differs from that in the last step"),
    (lambda: set_state(pos=(0, 0.5, 0)), "the place of .*#1 differs from that in the last step"),
    (lambda: (O.resetTime(), set_state(vel=(0, 2, 0))), "the velocity of .*#1 differs"),
])
def test_stresses_need_the_state_after_the_step(change, says):
    """O.dt and velocities give the positions at which the forces of the last step acted."""
    build(rcr.wall("y", 0), rcr.disc((0, 0.1), 0.1, material()))
    O.run(3, True)
    calls = rcr.contact_network, rcr.measure.stress_tensors, rcr.Profile(cells=(1, 1)).compute
    for call in calls:
        call()
    change()
    for call in calls:
        refused(says, call)
    assert rcr.measure.extent() is not None
    O.step()
    for call in calls:
        call()


@LAWS
@pytest.mark.parametrize("then", [O.pause, O.wait, lambda: refused("O.dt", refused_run)])
def test_a_change_before_a_pause_is_seen(law, then):
    m = springy(young=1e9)
    build(rcr.disc((0, 0), 0.1, m), law=law, dt=1e-5, gravity=(0, 0, 0))
    O.run(20, True)
    set_state(0, vel=(1000, 0, 0))
    then()
    refused("the velocity of body #0 differs", rcr.contact_network, volume=1)


def refused_run():
    before, O.dt = O.dt, 0
    try:
        O.run(1, True)
    finally:
        O.dt = before


@LAWS
@pytest.mark.parametrize("how", ["plain", "after an insertion", "after a reload"])
@pytest.mark.parametrize("change, says", [
    (lambda: setattr(O, "dt", 2 * O.dt), "O.dt is .*, but was .* in the last step"),
    (lambda: set_state(2, vel=(0, 50, 0)), "the velocity of body #2 differs from that"),
    (lambda: set_state(2, angVel=(0, 0, 500)), "the velocity of body #2 differs from that"),
])
def test_a_change_is_seen_under_any_law(law, how, change, says, tmp_path):
    m = springy(young=1e9)
    build(rcr.wall("y", 0, material=m), *(rcr.disc((x, 0.1), 0.1, m) for x in (0, 1)), law=law,
          dt=1e-3 if law == "rigid" else 1e-5)
    O.run(20, True)
    rcr.contact_network(volume=1)
    if how == "after an insertion":
        O.bodies.append(rcr.disc((5, 5), 0.1, material(), velocity=(9, 9)))
    if how == "after a reload":
        path = str(tmp_path / "pair.yade")
        O.save(path, quiet=True)
        O.reset()
        O.load(path, quiet=True)
    branch = rcr.contact_network(volume=1).contacts["branch"]
    assert branch == pytest.approx(np.array([(0, -0.1)] * 2), abs=1e-4)
    change()
    refused(says, rcr.contact_network, volume=1)
    O.step()
    rcr.contact_network(volume=1)


SEEN = []


def look():
    """Append the branch vector of the first contact, or the message of a refusal."""
    try:
        branch = rcr.contact_network(volume=1).contacts["branch"]
        SEEN.extend(tuple(vector) for vector in branch)
    except ValueError as error:
        SEEN.append(str(error))


@pytest.mark.parametrize("place", ["before the integrator", "after the integrator"])
def test_an_engine_before_the_integrator_gets_no_network(place):
    """Two discs collide; before NewtonIntegrator they have neither moved nor changed velocity."""
    weightless(*(rcr.disc((x, 0), 0.1, material(0), velocity=(v, 0))
                 for x, v in ((0, 1), (0.201, -1))))
    engine = calls(look, 1, initRun=True)
    if place == "before the integrator":
        insert(-1, engine)
    else:
        O.engines = [*O.engines, engine]
    SEEN.clear()
    O.run(1, True)
    (seen,) = SEEN
    if place == "before the integrator":
        assert "the velocity of body #0 differs" in seen and "after NewtonIntegrator" in seen
    else:
        assert seen == pytest.approx((0.201, 0), abs=1e-12)


def moments_of_points():
    """Σ f⊗r over the contact points of each body in O.bodies, (bodies, 2, 2) [N] [Love, Weber]."""
    moments = np.zeros((len(O.bodies), 2, 2))
    centers = np.array([b.state.pos - O.dt * b.state.vel for b in O.bodies])[:, :2]
    for i in O.interactions:
        points = ((i.phys.force1, i.geom.normal1, i.geom.position1),
                  (i.phys.force2, i.geom.normal2, i.geom.position2))
        for force, normal, position in points[: i.geom.points]:
            turn = np.array([[normal[0], -normal[1]], [normal[1], normal[0]]])
            shift = np.array(O.cell.hSize * i.cellDist)[:2] if O.periodic else 0
            for body, sign, image in ((i.id1, 1, 0), (i.id2, -1, shift)):
                arm = np.array(position) - centers[body] - image
                moments[body] += sign * np.outer(turn @ force, arm)
    return moments


def bricks(law):
    """Three rough rods lie side on side on a floor; a force presses the uppermost one askew."""
    rough, r = springy(), 0.1
    rods = [stadium(0.1, r, (0.01 * k, r + 1.9999 * r * k), material=rough) for k in range(3)]
    build(rcr.wall("y", 0, 1, material=rough), *rods, law=law, dt=1e-5)
    O.forces.setPermF(3, (60, -200, 0))
    O.run(100, True)


def bricks_in_a_cell(law):
    """Five rods that stick fill the height of a sheared periodic cell; one of them turns."""
    rough = springy(friction=10)
    rods = [stadium(0.1, 0.1, (0.01 * k, 0.1999 * k), material=rough) for k in range(5)]
    weightless(*rods, cell=0.9995, law=law, dt=1e-5)
    O.cell.velGrad = plane(0, 0.5, 0, 0)
    set_state(2, angVel=(0, 0, 0.1))
    O.run(100, True)


@pytest.mark.parametrize("scene, law", [(bricks, "rigid"), (bricks, "smooth"),
                                        (bricks_in_a_cell, "smooth")])
def test_the_stress_of_a_grain_is_a_sum_over_contact_points(scene, law, tmp_path):
    """Friction at both ends of a side adds to σ of the grain, also across a cell's edge."""
    scene(law)
    assert sum(i.phys.points == 2 and min(i.phys.force1[0], i.phys.force2[0]) > 0
               for i in O.interactions) > 2
    ids, found = rcr.measure.stress_tensors()
    exact = moments_of_points()
    areas = rcr.measure.areas()[1]
    assert found * areas[:, None, None] == pytest.approx(exact[ids], rel=1e-6, abs=1e-6)
    network = rcr.contact_network(volume=1.0)
    network.save(tmp_path / "network.h5")
    again = rcr.Network.load(tmp_path / "network.h5")
    assert again.grain_stresses() == pytest.approx(found, rel=1e-9, abs=1e-9)
    profile = rcr.Profile((1, 1)).compute(network)
    for total in (network.stress(), again.stress(), profile.stress[0, 0] * profile.cell_area):
        assert total == pytest.approx(exact[ids].sum(axis=0), rel=1e-6, abs=1e-6)


def test_a_clump_counts_as_one(resting):
    """The stress of a clump is symmetric up to its acceleration; arms start at its own centre."""
    ids, network, *_ = resting
    row, other = (list(network.particles["id"]).index(member) for member in ids["members"])
    stress = network.grain_stresses()
    assert np.array_equal(stress[row], stress[other])
    assert network.grain_coordination()[row] == network.grain_coordination()[other] >= 2
    assert stress[row][0, 1] == pytest.approx(stress[row][1, 0], abs=1e-2 * np.trace(stress[row]))
    assert network.particles["center"][row] == pytest.approx(ids["center"], abs=1e-5)  # of a step
    assert network.particles["clump"][row] == ids["clump"]


NO_BOX = "left, bottom, right and top Wall of a box"
ORDER = "are at x = .*; expected the order left, bottom, right, top"


def test_scenes_without_a_free_grain_walls_that_are_no_box_and_volumes_out_of_range():
    build(rcr.wall("x", 0), rcr.wall("y", 0), rcr.wall("x", 1), rcr.wall("y", 2),
          rcr.particle((0.2, 0.5), 0.1, 0.5, fixed=True, material=material()))
    refused("no free Rcr, Sphere or RoundedPolygon", rcr.contact_network)
    O.bodies.append(rcr.particle((0.5, 0.5), 0.1, 0.5, material=material()))
    for walls in (0, 1), (0, 1, 2, 99), (1, 0, 3, 2), "box", (0, 1, 2, 4):
        refused(NO_BOX, rcr.contact_network, walls)
    for walls in (2, 1, 0, 3), (0, 3, 2, 1), (2, 3, 0, 1):
        refused(ORDER, rcr.contact_network, walls)
    for volume in (0, -1, math.nan, "large"):
        refused("volume = .*; expected the area of the region", rcr.contact_network, volume=volume)
    assert len(rcr.contact_network().contacts["force"]) == 0


def test_periodic_cell_needs_no_walls():
    shrinking_cell()
    network = rcr.contact_network()
    volume = network.attributes["volume"]
    assert volume == pytest.approx(np.linalg.det(np.array(O.cell.hSize)[:2, :2]))
    assert len(network.contacts["force"]) > 10
    assert np.hypot(*network.contacts["branch"].T).max() < 0.2  # of touching grains, no period
    stress = network.stress()
    total = np.einsum("n,nab->ab", rcr.measure.areas()[1], network.grain_stresses())
    assert total / volume == pytest.approx(stress, rel=1e-9)
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
    one, two = np.hypot(*network.contacts["force"].T)
    assert network.stress()[0, 0] == pytest.approx((one * 0.995 + two * 1.99) / 8)  # f × branch


def test_sides_that_press_at_one_end_are_a_cap_on_a_side():
    """A tilted rod touches at one end. Its other end is within the alert distance."""
    rough, a, r, tilt = material(0.5), 0.09, 0.01, 0.001
    lower = stadium(a, r, (0, r), material=rough)
    upper = stadium(a, r, (0, 3 * r + a * math.sin(tilt)), tilt, material=rough)
    build(rcr.wall("y", 0, material=rough), lower, upper, dt=1e-4)
    O.step()
    geom, phys = O.interactions[1, 2].geom, O.interactions[1, 2].phys
    assert geom.type == 2 and geom.points == 2 and phys.force1[0] * phys.force2[0] == 0
    contacts = rcr.contact_network().contacts
    pair = (contacts["body1"] == 1) & (contacts["body2"] == 2)
    assert contacts["type"][pair] == [1] and contacts["points"][pair] == [1]


def test_a_scene_is_not_read_during_a_step(tmp_path):
    """A script would read two states; an engine of the run reads one."""
    heap()
    found = []
    yade.read = lambda: found.append(len(rcr.contact_network().contacts["body1"]))
    O.engines += [w.PyRunner(command="import yade; yade.read()", iterPeriod=10)]
    reads = (rcr.contact_network, Frame.of, rcr.Profile().compute, rcr.measure.stress_tensors,
             lambda: rcr.snapshot(tmp_path / "a.png", contacts="force"))
    O.run()
    try:
        for read in reads:
            refused(r"pause the run \(O.pause\(\)\), or call this from a PyRunner", read,
                    error=RuntimeError)
        wait_until(lambda: len(found) > 1)
    finally:
        O.pause()
        del yade.read
    for read in reads:
        read()
    assert found and not O.running


@pytest.mark.parametrize("speed", [0, 1, -1])
def test_a_profile_holds_all_contacts_of_a_moving_scene(speed):
    """Contacts are at the time of their forces, up to v dt outside the box of the grains."""
    m = material()
    build(rcr.wall("y", 0, 1, speed, m),
          *(rcr.disc((0, 0.01 + 0.02 * k), 0.01, m) for k in range(3)), dt=3e-3)
    for body in O.bodies:
        body.state.vel = (0, speed, 0)
    O.run(50, True)
    profile = rcr.Profile((1, 3)).compute()
    total = profile.stress.sum(axis=(0, 1)) * profile.cell_area
    assert total == pytest.approx(rcr.contact_network(volume=1).stress(), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("law", ["rigid", "smooth"])
def test_networks_contain_tension_and_adhesion(law, tmp_path):
    """A disc hangs from a fixed one, and bears another."""
    m = springy()
    build(rcr.disc((0, 0), 0.1, m, fixed=True), rcr.disc((0, -0.2), 0.1, m),
          rcr.disc((0, -0.4), 0.1, m), law=law, dt=1e-3 if law == "rigid" else 1e-5)
    weight = O.bodies[1].state.mass * G
    pull = 3 * weight
    if law == "rigid":
        O.engines[2].physDispatcher.functors[0].adhesion = pull
        O.engines[2].physDispatcher.functors[0].rollingFriction = 0.1
    else:
        O.engines[2].lawDispatcher.functors[0].adhesion = pull
        for k in (1, 2):  # springs bear the pull only where they overlap
            O.bodies[k].state.pos = (0, -(0.2 - 1e-5) * k, 0)
    O.step()
    network = rcr.contact_network(volume=1)
    assert (network.contacts["adhesion"] == pull).all() and len(network.contacts["body1"]) == 2
    if law == "rigid":
        assert network.normal_force() == pytest.approx([-2 * weight, -weight], rel=1e-6)
        # branches of 0.1 m to the fixed disc and 0.2 m
        assert network.stress()[1, 1] == pytest.approx(-0.4 * weight, rel=1e-6)
    path = tmp_path / "network.h5"
    network.save(path)
    again = rcr.Network.load(path)
    for name, values in network.contacts.items():
        np.testing.assert_array_equal(again.contacts[name], values)


def test_networks_contain_rolling_moments(tmp_path):
    m = material(0.5)
    build(rcr.wall("y", 0, material=m), rcr.disc((0, 0.1), 0.1, m), gravity=(1, -10, 0))
    O.engines[2].physDispatcher.functors[0].rollingFriction = 0.5
    O.step()
    network = rcr.contact_network(volume=1)
    (moment,) = network.contacts["rolling_moment"]
    (i,) = O.interactions
    assert abs(moment) == abs(i.phys.rollingMoment) > 0
    # it balances the moment of friction about the centre of the disc
    force, position = network.contacts["force"][0], network.contacts["position"][0]
    arm = position - network.particles["position"][0]
    assert moment == pytest.approx(-(arm[0] * force[1] - arm[1] * force[0]), rel=1e-6)
    network.save(tmp_path / "network.h5")
    assert rcr.Network.load(tmp_path / "network.h5").contacts["rolling_moment"][0] == moment


def test_a_loaded_scene_has_a_network(tmp_path):
    """An engine that has just been loaded belongs to the scene of before, which is freed."""
    path = str(tmp_path / "scene.yade.gz")
    m = material()
    build(rcr.wall("y", 0, material=m), rcr.disc((0, 0.1), 0.1, m))
    O.run(3, True)
    O.save(path, quiet=True)
    for _ in range(10):
        O.load(path, quiet=True)
        kept = [np.full(size, -1) for size in range(64, 400) for _ in range(8)]
        assert len(rcr.contact_network(volume=1).contacts["body1"]) == 1
        assert O.engines[3].observations() == [] and len(kept) == 8 * 336
