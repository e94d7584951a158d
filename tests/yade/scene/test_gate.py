"""Faulty scenes are rejected before anything moves, under both laws where possible."""

import math
import time
import warnings

import numpy as np
import pytest
import rcr
from scenes import (assert_refused, build, gaps, grain_on_floor, insert, material, python, snapshot,
                    solver, stadium, steps)
from yade import O, utils
from yade.minieigenHP import Quaternion, Vector3
from yade.wrapper import (
    Bo1_Wall_Aabb, ElastMat, ForceEngine, ForceResetter, GlobalStiffnessTimeStepper, GravityEngine,
    Ig2_Sphere_Sphere_ScGeom, InsertionSortCollider, Law2_ScGeom_FrictPhys_CundallStrack,
    NewtonIntegrator, PyRunner, ServoPIDController, StepDisplacer, TranslationEngine,
)  # fmt: skip

NAN = math.nan


def rigid(**options):
    return grain_on_floor(0.2, **options)


def smooth():
    return grain_on_floor(0.2, dt=1e-5, law="smooth")


LAWS = pytest.mark.parametrize("scene", [rigid, smooth])


def without(kind):
    O.engines = [e for e in O.engines if not isinstance(e, kind)]


def add_stock_spheres():
    loop = O.engines[2]
    loop.geomDispatcher.functors = [*loop.geomDispatcher.functors, Ig2_Sphere_Sphere_ScGeom()]
    loop.lawDispatcher.functors = [*loop.lawDispatcher.functors,
                                   Law2_ScGeom_FrictPhys_CundallStrack()]


def add(make, *arguments, **options):
    """Append a body of the floor's material."""
    O.bodies.append(make(*arguments, material=O.bodies[1].material, **options))


def insert_late(engine):
    """Insert an engine before the integrator, under the rigid law behind ContactDynamics."""
    insert(-1, engine)


UNSEEN = "stands after ContactDynamics, which would not see its load; put it before"
RIGID = {  # under the rigid law: name of the error, change of the scene, words of the message
    "no solver": (
        lambda: without(rcr.ContactDynamics),
        r"O.engines holds no ContactDynamics, .*put ContactDynamics\(\) between the "
        r"InteractionLoop and the NewtonIntegrator"),
    "dead solver": (lambda: setattr(solver(), "dead", True),
                    "O.engines holds no ContactDynamics that is not dead"),
    "two solvers": (lambda: insert(3, rcr.ContactDynamics()),
                    "O.engines holds 2 of ContactDynamics; expected one"),
    "late force": (lambda: insert_late(ForceEngine(force=(500, 0, 0), ids=[1])), UNSEEN),
    "late stress": (lambda: insert_late(rcr.WallStress(wall=0, start=0, end=0)), UNSEEN),
    "late displacer": (lambda: insert_late(StepDisplacer(ids=[0], mov=(1e-3, 0, 0))),
                       "the StepDisplacer " + UNSEEN),
    "early servo": (
        lambda: insert(1, ServoPIDController(axis=(0, 1, 0), maxVelocity=0.1, ids=[0], target=1)),
        "would read forces without those of contacts; put it after the NewtonIntegrator"),
    "stepper": (lambda: insert(0, GlobalStiffnessTimeStepper()),
                "the GlobalStiffnessTimeStepper would set O.dt from stiffnesses"),
    "gravity": (lambda: setattr(O.engines[-1], "gravity", (0, 0, -9.81)),
                r"pulls out of the plane of the grains, which is x and y; set gravity=\(0, -9.81, "
                r"0\)"),
    "spheres": (add_stock_spheres, "Ig2_Sphere_Sphere_ScGeom makes contacts that ContactDynamics "
                "does not solve; take Ig2_Sphere_Sphere_RcrGeom instead"),
    "friction": (lambda: setattr(O.bodies[1].material, "frictionAngle", math.pi / 2),
                 "has the friction angle 1.57.*; expected radians from 0 to below π/2"),
    "degrees": (lambda: setattr(O.bodies[1].material, "frictionAngle", 26),
                "friction angle 26; expected radians"),
    "orientation": (lambda: setattr(O.bodies[1].state, "ori", Quaternion(NAN, NAN, NAN, NAN)),
                    "#1 has an orientation that is not finite"),
    **{f"plane {z}": (lambda z=z: add(rcr.disc, (0, 0.5, z), 0.1),
                      f"#2 lies at z = {z}, other grains at z = 0") for z in (3, 0.3)},
}


@pytest.mark.parametrize("change, match", RIGID.values(), ids=RIGID)
def test_errors_under_the_rigid_law(change, match):
    rigid()
    change()
    assert_refused(match)


OUT = (r"body #1 has the velocity \(.*\) and the angular velocity \(.*\), which lead out of "
       r"the plane; expected b.state.vel\[2\]")
BOTH = {
    "two integrators": (lambda: insert(9, NewtonIntegrator(damping=0)),
                        "O.engines holds 2 of NewtonIntegrator; expected one"),
    "no collider": (lambda: without(InsertionSortCollider), "O.engines holds no collider"),
    "no resetter": (lambda: without(ForceResetter), "O.engines holds no ForceResetter"),
    "no integrator": (lambda: without(NewtonIntegrator), "O.engines holds no NewtonIntegrator"),
    "no bounds": (
        lambda: setattr(O.engines[1].boundDispatcher, "functors", [Bo1_Wall_Aabb()]),
        r"the collider has no Bo1_Rcr_Aabb, so body #1 would meet nothing; put Bo1_Rcr_Aabb\(\) "
        r"into its list"),
    "velocity": (lambda: setattr(O.bodies[1].state, "vel", (0, 0, 0.01)), OUT),
    "roll": (lambda: setattr(O.bodies[1].state, "angVel", (3, 0, 0)), OUT),
    "pitch": (lambda: setattr(O.bodies[1].state, "angVel", (0, 1e-3, 0)), OUT),
    "no friction": (lambda: setattr(O.bodies[1], "material", ElastMat(density=1000)),
                    "#1 has the material ElastMat, which has no friction; give it a FrictMat"),
    "box": (lambda: add(utils.box, (0, 0, 5), (1, 1, 1), fixed=True),
            "#2 is a Box at z = 5 that does not reach the plane z = 0"),
    "facet": (lambda: add(utils.facet, [(0, -1, 1), (1, -1, 1), (0, -1, 2)]),
              "#2 is a Facet that does not cut the plane z = 0"),
}


@LAWS
@pytest.mark.parametrize("change, match", BOTH.values(), ids=BOTH)
def test_errors_under_both_laws(scene, change, match):
    scene()
    change()
    assert_refused(match)


# --- engines --------------------------------------------------------------------------------------

def test_load_before_the_solver_is_seen():
    rigid(before=[ForceEngine(force=(0, -500, 0), ids=[1])])
    steps(20)
    assert O.bodies[1].state.pos[1] == pytest.approx(0.1, abs=1e-9)


PUSHES = [lambda: ForceEngine(force=(500, 0, 0), ids=[1]),
          lambda: GravityEngine(gravity=(0, -1, 0))]


@LAWS
@pytest.mark.parametrize("load", PUSHES, ids=["ForceEngine", "GravityEngine"])
def test_a_load_that_nothing_feels(scene, load):
    """The next ForceResetter deletes its force before a step uses it."""
    scene()
    O.engines = [*O.engines, load()]
    assert_refused("stands after the NewtonIntegrator, so its forces would be taken away before "
                   "they move anything; put it between the two")
    scene()
    O.engines = [load(), *O.engines]
    assert_refused("stands before the ForceResetter, so its forces would be taken away")


@LAWS
def test_a_motion_may_be_prescribed_after_the_integrator(scene):
    scene()
    O.engines = [*O.engines, TranslationEngine(ids=[0], translationAxis=(1, 0, 0), velocity=0.1)]
    steps(2)
    assert O.bodies[0].state.pos[0] == pytest.approx(0.1 * O.dt)


@LAWS
def test_a_displacer_gives_no_forces(scene):
    """A displacer applies no force, so it is accepted."""
    scene()
    O.engines = [*O.engines, StepDisplacer(ids=[0], mov=(1e-3, 0, 0))]
    steps(2)
    assert O.bodies[0].state.pos[0] == pytest.approx(2e-3)


def test_forces_after_the_solver_cause_a_warning(capfd):
    """A PyRunner after ContactDynamics presses a grain in; only the overlap shows it."""
    rigid()
    insert_late(PyRunner(command="O.forces.addF(1, (0, -1e5, 0))", iterPeriod=1))
    steps(100)
    told = capfd.readouterr().err
    assert "and grows, although all steps converged." in told
    assert "forces added after ContactDynamics" in told
    assert "Deepest in this step: bodies #0 and #1." in told


@LAWS
def test_engines_with_wrong_attributes_are_rejected_at_the_start(scene):
    scene(before=[rcr.WallStress(wall=1, start=0, end=0)]) if scene is rigid else scene()
    if scene is smooth:
        insert_late(rcr.WallStress(wall=1, start=0, end=0))
    assert_refused("WallStress.wall = 1 is not the id of a body with the shape Wall")
    O.engines = [e for e in O.engines if not isinstance(e, rcr.WallStress)]
    O.dt = 0
    with pytest.raises(ValueError, match="O.dt = 0; expected a finite time step > 0"):
        O.run(1, True)


def test_the_steppers_first_step():
    """Without contacts YADE's stepper takes the wave speed of spheres, or 1 s without any."""
    smooth()
    O.bodies[1].state.pos = Vector3(0, 0.2, 0)
    stepper = GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.4)
    insert(0, stepper)
    assert_refused(r"GlobalStiffnessTimeStepper.defaultDt = -1 would set O.dt = 1 s while no Rcrs "
                   r"touch; set defaultDt = 0.5 \* rcr.critical_time_step\(\)")
    stepper.defaultDt = 0.5 * rcr.critical_time_step()
    steps(5)
    assert O.dt == stepper.defaultDt


@LAWS
def test_time_step_forgotten(scene):
    scene()
    O.dt = 1e-8
    with pytest.warns(UserWarning, match="O.dt = 1e-8 s is YADE's default; set it"):
        O.step()


def test_material_that_loses_its_friction_in_a_run():
    """YADE alone ends the process in its parallel loop."""
    result = python("""
from scenes import *
from yade.wrapper import ElastMat, PyRunner
grain_on_floor(0.2, height=0.15)
change = "O.bodies[1].material = ElastMat(density=1000)"
O.engines = [*O.engines, PyRunner(iterPeriod=1, command=change)]
try:
    O.run(500, True)
    O.step()
except (ValueError, RuntimeError) as error:
    print("told:", error)
""")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "give it a FrictMat" in result.stdout, result.stdout + result.stderr


# --- bodies ---------------------------------------------------------------------------------------

def test_ball_among_rcrs():
    rigid()
    O.bodies.append(utils.sphere((0, 1, 0), 0.1, material=O.bodies[1].material))
    O.bodies[2].state.blockedDOFs = "zXY"
    with pytest.warns(UserWarning, match="#2 is a Sphere with the mass of a ball, .*make it by "
                      "rcr.disc"):
        O.step()


# --- numbers of a step ----------------------------------------------------------------------------

@pytest.mark.parametrize("dt", [1, 30, 1000])
def test_step_that_ends_in_an_overlap_has_not_converged(dt):
    rough = material()
    build(stadium(0.2, 0.1, (0, 0), material=rough, velocity=(1.0 / dt, 0),
                  angular_velocity=5.0 / dt),
          stadium(0.2, 0.1, (1.0, 0.1), angle=1.0, material=rough), dt=dt, gravity=(0, 0, 0))
    converged = True
    for _ in range(3):
        O.step()
        # gaps are those at the beginning of the step
        assert min(gaps(), default=0) > -0.02 * 0.6 or not converged
        converged = solver().converged
    assert O.bodies[1].state.vel.norm() > 0, "they missed"


def test_an_exception_leaves_no_trace():
    """A rejected step, corrected and made, gives the bits of a run without the fault."""
    def run(fault):
        rigid()
        state = O.bodies[1].state
        state.vel = (3.0, -2.0, 0)
        steps(5)
        if fault:
            inertia, state.inertia = tuple(state.inertia), (1, 1, 0)
            assert_refused("moment of inertia 0")
            state.inertia = inertia
        steps(20)
        return snapshot()

    assert np.array_equal(run(False), run(True))


def test_missed_steps_are_counted_and_the_counts_are_saved(tmp_path):
    rough = material()
    pile = [stadium(0, 0.1, (0.01 * k, 0.1 + 0.2 * k), material=rough) for k in range(6)]
    build(rcr.wall("y", 0, material=rough), *pile, tolerance=1e-13, maxIterations=1, solver="nlgs")

    def missed(count):
        """Number of the next steps that miss the tolerance."""
        return sum(not (O.step() or solver().converged) for _ in range(count))

    first = missed(20)
    counts = lambda: (solver().missedSteps, solver().yieldedSteps, solver().deepestOverlap)
    saved = counts()
    assert saved[:2] == (first, 0) and first > 0
    O.save(str(tmp_path / "pile.yade"))
    O.load(str(tmp_path / "pile.yade"))
    assert counts() == saved
    second = missed(5)
    assert solver().missedSteps == first + second and second > 0


# --- pairs that may meet --------------------------------------------------------------------------

def with_functors(*names):
    """Engines whose loop has these functors only."""
    O.engines[2].geomDispatcher.functors = [getattr(rcr, name)() for name in names]


@LAWS
def test_a_missing_ig2_is_reported_before_the_pair_meets(scene):
    """The disc is far above all other bodies."""
    scene()
    O.bodies.append(rcr.disc((0, 9), 0.1, material=O.bodies[1].material))
    with_functors("Ig2_Rcr_Rcr_RcrGeom", "Ig2_Wall_Rcr_RcrGeom")
    assert_refused(
        r"handles (?=.*Sphere)(?=.*Wall)(?=.*Rcr)(\w+ and \w+ \(bodies #[0-2], #[0-2]\), ){2}so "
        r"they would pass through each other. "
        r"Add (?=.*Ig2_Wall_Sphere_RcrGeom\(\))(?=.*Ig2_Sphere_Rcr_RcrGeom\(\)).* to its first list"
    )


@LAWS
def test_pairs_that_cannot_meet_want_no_ig2(scene):
    """A grain without partner, fixed bodies, other masks and members of a clump do not meet."""
    scene()
    with_functors("Ig2_Wall_Rcr_RcrGeom")
    O.step()
    rough = O.bodies[1].material
    O.bodies.append(rcr.disc((3, -1), 0.1, material=rough, mask=2))
    O.bodies.append(utils.box((5, 0, 0), (0.1, 0.1, 0.1), material=rough, fixed=True, mask=2))
    with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Box_Sphere_RcrGeom")
    O.step()
    O.bodies.append(rcr.disc((4, -1), 0.1, material=rough, mask=2, fixed=True))
    assert_refused(r"no Ig2 functor .* handles Sphere and Sphere \(bodies #[24], #[24]\)")


def test_members_of_one_clump_want_no_ig2():
    rough = material()
    build(rcr.wall("y", 0, material=rough))
    rcr.clump([stadium(0.2, 0.1, (0, 0.3), material=rough),
               rcr.disc((0.1, 0.4), 0.1, material=rough)])
    with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Wall_Sphere_RcrGeom")
    O.step()
    rcr.clump([stadium(0.2, 0.1, (2, 0.3), material=rough),
               rcr.disc((2.1, 0.4), 0.1, material=rough)])
    assert_refused(
        r"Add (?=.*Ig2_Rcr_Rcr_RcrGeom)(?=.*Ig2_Sphere_Rcr_RcrGeom)(?=.*Ig2_Sphere_Sphere_RcrGeom)")


def advised():
    """Warnings of the next step."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        O.step()
    return [str(w.message) for w in caught]


@LAWS
def test_initial_overlaps_warn_once(scene):
    scene()
    rough = O.bodies[1].material
    O.bodies.append([stadium(0.2, 0.1, (0.3, 0.15), angle=1.0, material=rough),
                     stadium(0.2, 0.1, (0, 0.26), material=rough)])
    (told,) = advised()
    assert "bodies #1 and #2 overlap by 0." in told
    assert "of R₁ + R₂, before their first step, and 3 more pairs less deeply." in told
    assert ("take back at most 1e-4 R" in told) == (scene is rigid)
    assert ("Springs begin with the force of it" in told) == (scene is smooth)
    assert advised() == []
    O.bodies.append(stadium(0.2, 0.1, (3, 0.08), material=rough))
    (told,) = advised()
    assert ("bodies #0 and #4 overlap by 0.02 m, 0.0333 of R₁ + R₂, before their first "
            "step. ") in told


@LAWS
def test_grains_behind_a_wall_warn(scene):
    scene()
    rough = O.bodies[1].material
    O.bodies.append([rcr.wall("x", -1, -1, material=rough),
                     stadium(0.2, 0.1, (3, 1), material=rough)])
    (told,) = advised()
    assert ("body #1 and 1 more lie behind a wall, body #2, which acts towards -x only "
            "(sense=-1): such a grain goes through it. Set sense=1, or 0") in told


def test_overlaps_of_images_warn():
    places = (1.95, 1.0), (2.1, 3.0), (0.5, 0.5)
    build(*(rcr.disc(at, 0.1, material=material()) for at in places), cell=2, gravity=(0, 0, 0))
    (told,) = advised()
    assert "bodies #0 and #1 overlap by 0.05 m, 0.25 of R₁ + R₂, before their first step. " in told


def test_a_scene_without_overlaps_is_not_warned_of():
    rigid()
    rough = O.bodies[1].material
    rcr.clump([stadium(0.2, 0.1, (2, 0.5), material=rough),
               stadium(0.2, 0.1, (2, 0.5), angle=1.5, material=rough)])
    O.bodies.append([stadium(0.2, 0.1, (0, 0.3), material=rough),
                     stadium(0.2, 0.1, (5, 0.1), material=rough, mask=2),
                     stadium(0.2, 0.1, (5, 0.1), material=rough, mask=4)])
    assert advised() == []


def test_a_time_step_beyond_the_critical_one_warns():
    smooth()
    O.dt = 0.9 * rcr.critical_time_step()
    assert advised() == []
    O.dt = 1.1 * rcr.critical_time_step()
    (told,) = advised()
    assert ("where springs of this stiffness become unstable; set O.dt = 0.5 * "
            "rcr.critical_time_step()") in told
    assert advised() == []
    O.dt = 2
    O.engines = [GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.1, defaultDt=1e-6),
                 *O.engines]
    assert advised() == []


def test_new_contacts_do_not_visit_all_bodies():
    """The time of a first step, which finds all contacts, grows with their number only."""
    rough = material()

    def first_step(side):
        """Processor time of the first step of side² discs in contact [s]."""
        build(*[rcr.disc((0.2 * i, 0.2 * j), 0.1, material=rough) for i in range(side)
                for j in range(side)], gravity=(0, 0, 0), tolerance=1e-2, maxIterations=2)
        before = time.process_time()
        O.step()
        assert O.interactions.countReal() > 1.9 * side * (side - 1)
        return time.process_time() - before

    # The least of three times excludes other load. Nine times the contacts take 9 times as long; a
    # visit of all bodies for each takes 81 times as long.
    few, many = (min(first_step(side) for _ in range(3)) for side in (15, 45))
    assert many < 27 * few


def test_a_contact_dynamics_set_dead_is_reported():
    """ContactDynamics checks the scene, so its absence needs another check."""
    rigid()
    steps(2)
    solver().dead = True
    with pytest.raises(ValueError, match="no ContactDynamics that is not dead"):
        steps(3)


@pytest.mark.parametrize("law", ["rigid", "smooth"])
@pytest.mark.parametrize("name, value", [("gravity", (0, NAN, 0)), ("gravity", (math.inf, 0, 0)),
                                         ("damping", NAN)])
def test_motion_that_is_not_finite_is_refused_by_its_name(law, name, value):
    build(stadium(0.3, 0.1, (0, 1), material=material()), law=law)
    setattr(O.engines[-1], name, value)
    with pytest.raises(ValueError, match=f"NewtonIntegrator.{name} = "):
        O.step()
