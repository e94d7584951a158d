"""rcr in a YADE session: classes, order of engines, saved scenes that continue to the same bits."""

import math

import numpy as np
import pytest
import rcr
import yade
import yade.utils
from scenes import (G, LAWS, build, contact_forces, engines, grain_on_floor, insert, material, pile,
                    pressed_box, python, refused, resting, set_state, shrinking_cell, snapshot,
                    solver, springs, springy, stadium, steps, tilted, velocity, weightless)
from yade import O
from yade.wrapper import MatchMaker, PyRunner

OURS = {
    "Shape": {"Rcr", "RoundedPolygon"},
    "BoundFunctor": {"Bo1_Rcr_Aabb", "Bo1_Disc_Aabb", "Bo1_RoundedPolygon_Aabb"},
    "IGeom": {"RcrGeom"},
    "IGeomFunctor": {f"Ig2_{other}_{grain}_RcrGeom" for grain in ("Rcr", "Sphere", "RoundedPolygon")
                     for other in ("Wall", "Box", "Facet", "Sphere")}
    | {"Ig2_Planar_RcrGeom", "Ig2_Rcr_Rcr_RcrGeom", "Ig2_Rcr_RoundedPolygon_RcrGeom",
       "Ig2_RoundedPolygon_RoundedPolygon_RcrGeom"},
    "IPhys": {"CapillaryCdPhys", "CdPhys", "RcrFrictPhys"},
    "IPhysFunctor": {"Ip2_FrictMat_FrictMat_CdPhys"},
    "LawFunctor": {"Law2_RcrGeom_CdPhys_Capillary", "Law2_RcrGeom_CdPhys_SignoriniCoulomb",
                   "Law2_RcrGeom_FrictPhys_CundallStrack"},
    "GlobalEngine": {"CellStress", "ContactDynamics", "WallStress"},
}
if hasattr(rcr, "Gl1_Rcr"):  # built with OpenGL
    OURS |= {"GlShapeFunctor": {"Gl1_Rcr", "Gl1_RoundedPolygon"}, "GlIGeomFunctor": {"Gl1_RcrGeom"},
             "GlIPhysFunctor": {"Gl1_CdPhys", "Gl1_RcrFrictPhys"}}
NAMES = set().union(*OURS.values())


def test_import_prints_nothing_and_adds_only_our_classes():
    """Whole streams are compared, since C++ prints too."""
    plain, loaded = (python("import yade.wrapper, sys; before = set(dir(yade.wrapper))\n" + code)
                     for code in ("", "import rcr; sys.__stdout__.flush(); print('added', "
                                  "*set(dir(yade.wrapper)) - before)"))
    assert loaded.stderr == plain.stderr
    said, added = loaded.stdout.split("added")
    assert said == plain.stdout and set(added.split()) == NAMES


@pytest.mark.parametrize("base, ours", OURS.items())
def test_classes_are_known_to_yade_and_documented(base, ours):
    assert ours <= set(yade.system.childClasses(base))
    assert not [name for name in ours if len(getattr(rcr, name).__doc__) <= 60]


def test_names_of_a_session_say_so_without_yade():
    without = python("import rcr; print(*rcr.__all__)").stdout.split()
    names = sorted({*rcr.__all__, "wall", *NAMES}.difference(without))
    assert {"particle", "Rcr"} < set(names)
    *told, unknown = python(f"""
import rcr
for name in {names + ["partikel"]}:
    try:
        getattr(rcr, name)
    except AttributeError as error:
        print(error)
""").stdout.splitlines()
    assert not [name for name, line in zip(names, told, strict=True)
                if not line.startswith(f"rcr.{name} needs a YADE session: ")]
    assert unknown == "module 'rcr' has no attribute 'partikel'"


def box_of_springs():
    pressed_box(springs, 0, share=0.3, damping=0.2)
    steps(1300)


@pytest.mark.parametrize("scene", [pile, pressed_box, box_of_springs])
@pytest.mark.parametrize("suffix", ["yade", "xml.bz2"])
def test_a_saved_scene_continues_to_the_same_bits(scene, suffix, tmp_path):
    """Springs to rounding: a reload changes the order in which YADE adds their forces."""
    scene()
    steps(200)
    path = str(tmp_path / f"scene.{suffix}")
    O.save(path, quiet=True)
    saved, warm = snapshot(), contact_forces()
    assert len(warm) > 15 and all(np.any([force[k] for force in warm.values()]) for k in (1, 2))
    steps(200)
    uninterrupted, last = snapshot(), contact_forces()

    O.reset()
    O.load(path, quiet=True)
    assert contact_forces() == warm
    assert np.array_equal(snapshot()[:, :13], saved[:, :13])  # YADE does not save forces on bodies
    steps(200)
    if scene is box_of_springs:
        assert snapshot()[:, :13] == pytest.approx(uninterrupted[:, :13], abs=1e-12)
        return
    difference = np.abs(snapshot() - uninterrupted).max(axis=0)
    assert np.array_equal(snapshot(), uninterrupted), f"largest difference a column: {difference}"
    assert contact_forces() == last


def test_threads_change_no_bit():
    code = """
from scenes import *
pile()
steps(100)
print(snapshot().tobytes().hex())
"""
    one, two = (python(code, OMP_NUM_THREADS=threads).stdout.split()[-1] for threads in "12")
    assert one == two and len(one) > 1000


def soften(angle):
    for body in O.bodies:
        body.material.frictionAngle = angle


def exchange(angle):
    for body in O.bodies:
        body.mat = material(math.tan(angle))


@pytest.mark.parametrize("change, acts", [
    (soften, False), (exchange, False), (yade.utils.setContactFriction, True),
    (lambda angle: setattr(O.interactions[0, 1].phys, "tangensOfFrictionAngle", math.tan(angle)),
     True),
    (lambda angle: (soften(angle), O.interactions.clear()), True),
], ids=["soften", "exchange", "setContactFriction", "each contact", "made anew"])  # fmt: skip
def test_friction_that_changes_in_a_run(change, acts):
    """A contact keeps the friction of its formation (docs/law.md); a slider on a slope shows it."""
    alpha = math.atan(0.3)
    slider = grain_on_floor(0.4, gravity=tilted(alpha))
    steps(5)
    assert velocity(slider)[0] == pytest.approx(0, abs=1e-12)  # rounding
    change(math.atan(0.1))
    O.step()
    expected = G * (math.sin(alpha) - 0.1 * math.cos(alpha)) if acts else 0
    assert velocity(slider)[0] / O.dt == pytest.approx(expected, rel=1e-10, abs=1e-9)


def test_friction_of_two_materials():
    """The smaller angle counts, as in YADE, unless a MatchMaker differs."""
    for maker, expected in ((None, 0.2), (dict(algo="val", val=math.atan(0.9)), 0.9),
                            (dict(algo="max"), 0.6)):
        build(rcr.wall("y", 0, material=material(0.2)),
              stadium(0.4, 0.1, (0, 0.1), material=material(0.6)))
        if maker:
            O.engines[2].physDispatcher.functors[0].frictAngle = MatchMaker(**maker)
        O.step()
        friction = O.interactions[0, 1].phys.tangensOfFrictionAngle
        assert friction == pytest.approx(expected, rel=1e-14)  # tan(atan(µ))


@LAWS
def test_engines_that_are_new_after_an_erase_see_the_bodies(law):
    """After an erase YADE's collider receives later bodies only; a new collider must find all."""
    grain = springy()
    floor, first, second = build(rcr.wall("y", 0, sense=1, material=grain),
                                 *(rcr.particle((x, 0.05), 0.1, 0.5, material=grain)
                                   for x in (0, 1)))
    steps(5)
    O.bodies.erase(first)
    steps(5)
    O.interactions.clear()
    O.engines = engines() if law == "rigid" else engines(law=law, damping=0.3)
    O.dt = O.dt if law == "rigid" else 1e-4
    O.run(1000, True)
    assert O.interactions.has(floor, second) and abs(O.bodies[second].state.pos[1] - 0.05) < 1e-3


@pytest.mark.parametrize("rigid", [True, False])
def test_a_pause_in_mid_step_ends_the_run(rigid):
    """O.pause in a PyRunner must not wait for the end of the run that calls it."""
    done = python(f"""
from scenes import *
from yade.wrapper import PyRunner
build(stadium(0.2, 0.1, (0, 1)))
command = "if O.iter == 5: O.pause(); print('went on', flush=True)"
O.engines = [*(O.engines if {rigid} else []), PyRunner(command=command, iterPeriod=1)]
O.run(20, True)
assert O.iter == 6, O.iter
O.run(20, True)
assert O.iter == 26, O.iter
rcr.advance(4) if {rigid} else O.run(4, True)
O.reset()
print("ended", flush=True)
""")
    assert done.stdout.endswith("went on\nended\n"), done.stdout[-500:] + done.stderr[-2000:]


@pytest.mark.parametrize("clumped", [False, True])
@pytest.mark.parametrize("settled", [2, 3, 4])
def test_a_velocity_set_between_steps_meets_far_contacts(settled, clumped):
    """YADE's collider holds the earlier speed; the grain stops at a wall three radii away."""
    R, smooth = 0.1, material(0)
    build(rcr.wall("x", 0, material=smooth), rcr.wall("y", 0, material=smooth), dt=5e-3,
          restitution=0)
    discs = [rcr.particle((3.129 * R, R + 2 * k * R), R, 0, material=smooth) for k in range(2)]
    hit = rcr.clump(discs)[0] if clumped else O.bodies.append(discs[0])
    steps(settled)
    O.bodies[hit].state.vel = (-60, 0, 0)
    O.step()
    assert O.bodies[hit].state.pos[0] == pytest.approx(R, abs=1e-6)


@pytest.mark.parametrize("lid", ["wall", "box"])
@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("one_by_one", [True, False], ids=["single steps", "a run"])
def test_a_fast_lid_meets_a_disc_that_rests(lid, free, one_by_one):
    """YADE's box of the lid reaches by verletDist; the lid moves further in a step."""
    smooth, deepest = material(0), []
    for start in np.linspace(0.045, 0.049, 14):
        body = (rcr.wall("y", start - 0.005, sense=-1, material=smooth) if lid == "wall" else
                yade.utils.box((0, start, 0), (0.1, 0.005, 0.01), fixed=True, material=smooth))
        weightless(rcr.disc((0, 0), 0.015, material=smooth), body)
        set_state(1, mass=1.0, blockedDOFs="xzXYZ" if free else "xyzXYZ", vel=(0, -4, 0))
        O.engines[1].verletDist = 0.001
        steps(12) if one_by_one else O.run(12, True)
        deepest.append(solver().deepestOverlap)
    assert max(deepest) < 1e-3


def test_a_time_step_that_changes_before_the_integrator_is_refused():
    """Impulses of one time step must not move bodies by another."""
    for take in (steps, lambda n: O.run(n, True)):
        resting()
        insert(4, PyRunner(command="O.dt *= 2", iterPeriod=1, firstIterRun=3, nDo=1))
        refused("O.dt changed after ContactDynamics", take, 6, error=(ValueError, RuntimeError))
        assert O.iter == 4
        insert(6, PyRunner(command="O.dt *= 2", iterPeriod=1, nDo=2))
        take(6)


def test_a_cell_that_changes_its_motion_before_the_integrator_is_refused():
    """Images must move as in the solution."""
    shrinking_cell()
    runner = PyRunner(command="O.cell.velGrad *= 2", iterPeriod=1, nDo=1)
    insert(4, runner)
    refused("O.cell.velGrad changed after ContactDynamics", steps, 3)
    O.engines = [e for e in O.engines if e is not runner]
    for place in 0, 3, 5:
        insert(place, PyRunner(command="O.cell.velGrad *= -1", iterPeriod=1, nDo=3))
    steps(5)


def test_a_misspelt_attribute_is_refused():
    """YADE accepts it without effect."""
    for thing, name, near in ((rcr.ContactDynamics(), "tolerence", "tolerance"),
                              (rcr.Law2_RcrGeom_FrictPhys_CundallStrack(), "damp", "damping"),
                              (rcr.particle((0, 0), 0.1, 0.5).shape, "cap_radius", "capRadius")):
        refused(f"has no attribute '{name}'; expected '{near}'", setattr, thing, name, 1,
                error=AttributeError)
        setattr(thing, near, 0.01)
        assert getattr(thing, near) == 0.01


@LAWS
def test_a_scene_with_a_body_of_an_earlier_scene_can_be_loaded(law, tmp_path):
    """Its material had a place in the O.materials of that scene."""
    O.materials.append([yade.wrapper.FrictMat(), yade.wrapper.FrictMat(density=2000)])
    earlier = rcr.disc((0, 0.02), 0.01, material=1)
    build(rcr.wall("y", 0), earlier, law=law, dt=1e-5)
    O.step()
    path = str(tmp_path / "scene.yade")
    O.save(path)
    O.load(path, quiet=True)
    O.step()
    assert O.bodies[1].material.density == 2000 and O.iter == 2
