"""Faulty scenes are refused with what was given, expected and to do, before anything moves.

O.step() raises the engine's ValueError. O.run(wait=True) raises a RuntimeError with the same words,
since YADE runs it in a thread. A run in the background stops at the error and logs it.
"""

import math
import os
import signal
import threading

import numpy as np
import pytest
import rcr
from scenes import (LAWS, assert_refused, build, calls, grain_on_floor, insert, material, plane,
                    prescribe, python, refused, resting, set_state, snapshot, solver, springy,
                    stadium, steps, wait_until, warns, without)
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Quaternion, Vector3

NAN, INF = math.nan, math.inf


def grain(center=(0, 0), R=0.1, eta=0.5, **options):
    return rcr.particle(center, R, eta, **options)


def add(make, *arguments, **options):
    return O.bodies[O.bodies.append(make(*arguments, material=O.bodies[0].material, **options))]


CALLS = [  # function, words of its ValueError
    *((lambda R=R: grain(R=R), "R = .*; expected a finite radius of the circumscribed circle > 0")
      for R in (0, -0.1, NAN, INF, "0.1", None)),
    *((lambda eta=eta: grain(eta=eta), "eta = .*; expected an elongation 0 ≤ eta < 1")
      for eta in (-0.1, 1, 1.5, NAN)),
    (lambda: grain((0, NAN)), r"center\[1\] = nan; expected a finite coordinate"),
    (lambda: grain(angle=INF), "angle = inf; expected a finite angle"),
    (lambda: grain(material=material(density=0)),
     "material.density = 0.0; expected a finite density > 0"),
    *((lambda given=given: grain(material=given), "material = .*; expected a FrictMat")
      for given in (None, 7, -3, 2**40, "nope", True)),
    *((lambda color=color: grain(color=color), "color")
      for color in ("red", (NAN, 0, 0), (1, 0), (2, 0, 0), [])),
    *((lambda mask=mask: grain(mask=mask), "mask = .*; expected a mask of 32 bits")
      for mask in (1.5, "a", 2**40, None)),
    (lambda: grain(R=1e-320), "density × area = 0.0; expected a finite mass > 0"),
    *((lambda given={name: value}: rcr.Rcr(**{"capRadius": 0.1, "halfLength": 0.2, **given}),
       f"Rcr.{name} = .*; expected a finite length .* rcr.particle")
      for name, value in (("capRadius", 0), ("capRadius", -1), ("capRadius", INF),
                          ("halfLength", -1), ("halfLength", NAN))),
    *((lambda axis=axis: rcr.wall(axis, 0), rf"axis = {axis!r}; expected 'x' or 'y' \(or 0 or 1\)")
      for axis in ("z", 2, -1, 0.5, True, None)),
    *((lambda sense=sense: rcr.wall("y", 0, sense=sense), "sense = .*; expected [+]1, −1, or 0")
      for sense in (5, -2, 0.5, "left", np.array([1, 0]))),
    (lambda: rcr.wall("x", NAN), "position = nan; expected a finite coordinate"),
    (lambda: rcr.wall("y", 0, material=3.5), "material = 3.5; expected a FrictMat"),
    (lambda: rcr.mobile_wall("x", 0, mass=0), "mass = 0; expected a finite mass > 0"),
    *((lambda ends=ends: rcr.segment(*ends), "expected")
      for ends in (((0, 0), (0, 0)), ((0, 0, 0), (1, 0, 1)), ((0, 0), (NAN, 0)))),
    (lambda: rcr.segment((0, 0), (NAN, 1)), r"end\[0\] = nan"),
    *((lambda members=members: rcr.clump(members), "at least one body")
      for members in ([], ["grain"])),
    (lambda: rcr.clump([grain()] * 2), "members holds a body twice"),
    (lambda: rcr.clump([grain(), O.bodies[0]]), "members holds body #0 of a scene"),
    *((lambda options=options: rcr.clump([grain(), rcr.disc((0.2, 0), 0.1, **options)]),
       r"members\[1\] is fixed or moves")
      for options in (dict(fixed=True), dict(velocity=(1, 0)), dict(angular_velocity=1.0))),
    *((lambda damping=damping: rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=damping),
       "CundallStrack.damping = .*; expected a fraction of the critical damping")
      for damping in (-0.1, NAN, INF)),
    *((lambda points=points: rcr.critical_time_step(points), "points = .*; expected a finite number")
      for points in (0, -1, NAN, INF, "a", None)),
    (lambda: rcr.Profile(cells=(10**9, 1)), "cells = .*; expected at most 10000000 cells"),
    *((lambda walls=walls: rcr.contact_network(walls=walls), r"walls(\[\d\])? = .*; expected the ids")
      for walls in ((1.9, 2, 3, 4), "abcd", (NAN, 1, 2, 3), 5, (1, [2, 3], 3, 4))),
    (lambda: rcr.plot.packing(limits=((1, 1), (0, 0))), "limits = .* in this order"),
    *((lambda given={name: 1.0}: rcr.contact_network(**given, seed=3),
       rf"contact_network\({name}=…\): the scene gives it; choose another name")
      for name in ("time", "stress")),
    (lambda: rcr.critical_time_step(),
     "O.engines holds no Law2_RcrGeom_FrictPhys_CundallStrack"),
    (lambda: (without(w.NewtonIntegrator), rcr.half_step_start()),
     "0 NewtonIntegrators that are not dead; expected one"),
    (lambda: (setattr(O, "dt", 0), rcr.half_step_start()), "O.dt = 0.0; expected"),
]


@pytest.mark.parametrize("call, match", CALLS)
def test_calls_that_are_refused(call, match):
    build(stadium(0.2, 0.1, (0, 1), material=material()))
    refused(match, call)
    assert len(O.bodies) == 1


def test_time_steps_of_no_grain_and_negative_ones():
    build(law="smooth")
    refused("no Rcr, Sphere or RoundedPolygon is free", rcr.critical_time_step)
    refused("No TimeStepper", setattr, O, "dt", -1e-3, error=RuntimeError)


@pytest.mark.parametrize("name, number", [("x", 0), ("y", 1)])
def test_axis_of_a_wall_by_its_number(name, number):
    """Numbers as in YADE's own walls."""
    assert rcr.wall(number, 0.5, velocity=2).state.vel == rcr.wall(name, 0.5, velocity=2).state.vel
    one, two = (rcr.mobile_wall(axis, 0, mass=1) for axis in (name, np.int64(number)))
    assert one.shape.axis == two.shape.axis == number
    assert one.state.blockedDOFs == two.state.blockedDOFs


# --- faults of a scene: a change, and words of the message

def add_stock_spheres():
    loop = O.engines[2]
    loop.geomDispatcher.functors = [*loop.geomDispatcher.functors, w.Ig2_Sphere_Sphere_ScGeom()]
    loop.lawDispatcher.functors = [*loop.lawDispatcher.functors,
                                   w.Law2_ScGeom_FrictPhys_CundallStrack()]


def add_shape_without_radius():
    body = w.Body(shape=rcr.Rcr(), material=material())
    body.state.blockedDOFs = "xyzXYZ"
    O.bodies.append(body)


def observe_member():
    _, members = rcr.clump([grain((3, 3)), grain((3, 3), angle=1)])
    solver().observe = members[:1]


def with_functors(*names):
    O.engines[2].geomDispatcher.functors = [getattr(rcr, name)() for name in names]


def press(name, stiffness):
    """A stiffness of the contact that forms as the grain is pressed into the wall."""
    set_state(pos=(0, 0.0999, 0))
    prescribe(name, stiffness)


def reorder(*places):
    """Take these engines: 3 is ContactDynamics, 4 the integrator."""
    O.engines = [O.engines[k] for k in places]
    O.engines[1].verletDist = 0  # otherwise the collider misses the integrator first


SETTINGS = [
    ("solver", "magic", "magic.*nlgs.*nesterov.*exact.*auto"),
    ("tolerance", -1e-4, "tolerance = -0.0001"),
    ("tolerance", NAN, "tolerance = -?nan"),
    ("tolerance", INF, "tolerance = inf; expected a finite residual"),
    ("meanForceChange", INF, "meanForceChange = inf: give a finite change"),
    ("maxIterations", 0, "maxIterations = 0"),
    ("maxIterations", -5, "maxIterations = -5"),
    ("correction", -0.1, "correction = -0.1.*; expected a fraction of the overlap, 0 to 1"),
    ("correction", 1.1, "correction = 1.1.*; expected a fraction of the overlap, 0 to 1"),
    ("correction", NAN, "correction = nan"),
    *(("yieldCompliance", value, f"ContactDynamics.yieldCompliance = {value:g}; expected a finite "
       f"factor ≥ 0, 1 by default") for value in (NAN, INF, -1.0)),
    ("threads", 2000, "ContactDynamics.threads = 2000; expected at most 1024 threads"),
    ("observeEvery", -1, "ContactDynamics.observeEvery = -1; expected a number of steps"),
    ("trackMeanStretch", True,
     "ContactDynamics.trackMeanStretch = True; expected overdamped = True"),
    ("dead", True, "O.engines holds no ContactDynamics that is not dead"),
]
FLOW = "ContactDynamics.flow is not zero; expected finite entries, and overdamped = True"
UNSEEN = "stands after ContactDynamics, which would not see its load; put it before"
LOST = "so its forces would be taken away"
OUT = (r"body #1 has the velocity \(.*\) and the angular velocity \(.*\), which lead out of "
       r"the plane; expected b.state.vel\[2\]")
UNFIT = "contact of bodies #0 and #1 has the friction coefficient .*; expected a friction angle "

RIGID = [  # under the rigid law
    *((lambda name=name, value=value: setattr(solver(), name, value), match)
      for name, value, match in SETTINGS),
    *((lambda overdamped=overdamped, rate=rate: (
        setattr(solver(), "overdamped", overdamped),
        setattr(solver(), "flow", plane(rate, 0, 0, 0))), FLOW)
      for overdamped, rate in ((False, 0.1), (True, NAN), (True, INF))),
    # engines
    (lambda: (steps(2), setattr(solver(), "dead", True)), "no ContactDynamics that is not dead"),
    (lambda: without(rcr.ContactDynamics), r"O.engines holds no ContactDynamics, .*put "
     r"ContactDynamics\(\) between the InteractionLoop and the NewtonIntegrator"),
    (lambda: insert(3, rcr.ContactDynamics()), "holds 2 of ContactDynamics; expected one"),
    (lambda: insert(-1, w.ForceEngine(force=(500, 0, 0), ids=[1])), UNSEEN),
    (lambda: insert(-1, rcr.WallStress(wall=0, start=0, end=0)), UNSEEN),
    (lambda: insert(-1, w.StepDisplacer(ids=[0], mov=(1e-3, 0, 0))), "the StepDisplacer " + UNSEEN),
    (lambda: insert(1, w.ServoPIDController(axis=(0, 1, 0), maxVelocity=0.1, ids=[0], target=1)),
     "would read forces without those of contacts; put it after the NewtonIntegrator"),
    (lambda: insert(3, w.ForceRecorder(ids=[0], file="/dev/null")),
     "the ForceRecorder stands before ContactDynamics, so it would record forces without those of"),
    (lambda: insert(3, w.TorqueRecorder(ids=[0], file="/dev/null")), "the TorqueRecorder stands"),
    (lambda: insert(3, w.TimeAverager(ids=[1])), "the TimeAverager stands before ContactDynamics"),
    (lambda: insert(3, w.UniaxialStrainer(posIds=[1], negIds=[0])),
     "the UniaxialStrainer stands before the NewtonIntegrator, so it would read forces"),
    (lambda: insert(3, w.CombinedKinematicEngine(ids=[0], comb=[
        w.ServoPIDController(axis=(0, 1, 0), maxVelocity=0.1, ids=[0], target=1)])),
     "the CombinedKinematicEngine stands before the NewtonIntegrator, so it would read forces"),
    *((lambda recorder=recorder: insert(9, recorder(
        ids=rcr.clump([grain((1, 2)), grain((1.05, 2))])[1], file="/dev/null")),
       "records body #2, a clump member .* Record body #4")
      for recorder in (w.ForceRecorder, w.TorqueRecorder)),
    (lambda: insert(-1, w.VESupportEngine(bIds=[1])), "the VESupportEngine " + UNSEEN),
    (lambda: insert(0, w.GlobalStiffnessTimeStepper()),
     "the GlobalStiffnessTimeStepper would set O.dt from stiffnesses"),
    (lambda: setattr(O.engines[-1], "gravity", (0, 0, -9.81)), r"pulls out of the plane of the "
     r"grains, which is x and y; set gravity=\(0, -9.81, 0\)"),
    (lambda: setattr(O.engines[-1], "dead", True), "O.engines holds no NewtonIntegrator"),
    (lambda: setattr(O.engines[-1], "damping", 0.2), "NewtonIntegrator.damping = 0.2.* would damp "
     "the contact forces; set damping=0"),
    (lambda: reorder(0, 1, 3, 4), "O.engines holds no InteractionLoop"),
    (lambda: reorder(0, 1, 3, 2, 4), "stands before the InteractionLoop"),
    # functors
    (add_stock_spheres, "Ig2_Sphere_Sphere_ScGeom makes contacts that ContactDynamics does not "
     "solve; take Ig2_Sphere_Sphere_RcrGeom instead"),
    (lambda: (add(utils.facet, [(-1, 0.25, -1), (1, 0.25, -1), (0, 0.25, 1)]),
              with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Rcr_Rcr_RcrGeom")),
     "no Ig2 functor .* handles .*(Facet|Rcr) and (Rcr|Facet) .*Add Ig2_Facet_Rcr_RcrGeom"),
    *((lambda e=e: prescribe("restitution", e),
       "contact of bodies #0 and #1 has the restitution .*; expected 0 to 1")
      for e in (-0.1, 1.1, NAN)),
    *((lambda angle=angle: prescribe("frictAngle", angle), UNFIT + "from 0 to below π/2")
      for angle in (-0.1, 1.6, NAN, 3.2, 20)),
    # bodies
    (lambda: setattr(O.bodies[1].material, "frictionAngle", math.pi / 2),
     "has the friction angle 1.57.*; expected radians from 0 to below π/2"),
    (lambda: setattr(O.bodies[1].material, "frictionAngle", 26),
     "friction angle 26; expected radians"),
    (lambda: set_state(mass=0), "#1 is free but has the mass 0; give it a mass > 0"),
    (lambda: set_state(mass=NAN), "#1 is free but has the mass nan"),
    (lambda: set_state(inertia=(1, 1, 0)),
     "#1 is free to turn but has the moment of inertia 0 about z"),
    (lambda: set_state(blockedDOFs="XY"), "#1 is free to leave the plane .blockedDOFs = 'XY'.; "
     "expected z, X and Y blocked"),
    (lambda: set_state(blockedDOFs=""), "#1 is free to leave the plane"),
    (lambda: set_state(ori=Quaternion((1, 0, 0), 0.1)), "#1 is tilted out of the plane"),
    (lambda: set_state(ori=Quaternion(NAN, NAN, NAN, NAN)),
     "#1 has an orientation of the norm nan; expected 1"),
    (lambda: set_state(pos=(NAN, 0, 0)), "#1 .*position.*nan"),
    (lambda: set_state(pos=(0, INF, 0)), "#1 .*position.*inf"),
    (lambda: set_state(vel=(NAN, 0, 0)), "#1 .*velocity.*nan"),
    (lambda: set_state(angVel=(0, 0, NAN)), "#1 .*velocity.*nan"),
    *((lambda z=z: add(rcr.disc, (0, 0.5, z), 0.1), f"#2 lies at z = {z}, other grains at z = 0")
      for z in (3, 0.3)),
    (add_shape_without_radius, "#2 has the cap radius -?nan; expected a length > 0"),
    *((lambda radius=radius: setattr(add(rcr.disc, (3, 1), 0.1).shape, "radius", radius),
       "#2 has the cap radius .*; expected a length > 0.*radius of a disc")
      for radius in (0, -0.1, NAN)),
    *((lambda half=half: add(utils.box, (0, -1, 0), half, fixed=True),
       r"#2 is a Box with the extents \(.*\), so nothing would meet it")
      for half in ((INF, 1, 1), (1, NAN, 1), (1, -1, 1))),
    (lambda: setattr(O.bodies[0], "dynamic", True),
     "#0 is free but has the mass 0; give it a mass > 0"),
    (lambda: insert(3, w.ForceEngine(force=(NAN, 0, 0), ids=[1])), "#1 .*(force|torque).*nan"),
    (lambda: O.forces.setPermF(1, (0, NAN, 0)), "#1 .*(force|torque).*nan"),
    (lambda: O.forces.setPermT(1, (0, 0, NAN)), "#1 .*(force|torque).*nan"),
    (lambda: O.bodies.appendClumped([grain((1, 1)), grain((1, 1.1))]),
     "is (tilted out of the plane|free to leave the plane).*rcr.clump"),
    (observe_member, r"observe holds (\d), a member of clump \d; its contacts act on the clump"),
]
BOTH = [  # under both laws
    (lambda: insert(9, w.NewtonIntegrator(damping=0)),
     "O.engines holds 2 of NewtonIntegrator; expected one"),
    (lambda: without(w.InsertionSortCollider), "O.engines holds no collider"),
    (lambda: without(w.ForceResetter), "O.engines holds no ForceResetter"),
    (lambda: without(w.NewtonIntegrator), "O.engines holds no NewtonIntegrator"),
    (lambda: setattr(O.engines[1].boundDispatcher, "functors", [w.Bo1_Wall_Aabb()]),
     r"the collider has no Bo1_Rcr_Aabb, so body #1 would meet nothing; put Bo1_Rcr_Aabb\(\) into "
     r"its list"),
    *((lambda name=name, value=value: setattr(O.engines[-1], name, value),
       f"NewtonIntegrator.{name} = ")
      for name, value in (("gravity", (0, NAN, 0)), ("gravity", (INF, 0, 0)), ("damping", NAN))),
    *((lambda dt=dt: setattr(O, "dt", dt), "O.dt = .*; expected a finite time step > 0")
      for dt in (0, NAN, INF)),
    *((lambda load=load: insert(9, load()), f"stands after the NewtonIntegrator, {LOST} before "
       "they move anything; put it between the two")
      for load in (lambda: w.ForceEngine(ids=[1]), w.GravityEngine)),
    *((lambda load=load: insert(0, load()), f"stands before the ForceResetter, {LOST}")
      for load in (lambda: w.ForceEngine(ids=[1]), w.GravityEngine)),
    (lambda: insert(3, rcr.WallStress(wall=1, start=0, end=0)),
     "WallStress.wall = 1 is not the id of a body with the shape Wall"),
    (lambda: setattr(O.bodies[0].shape, "sense", 2), "#0 is a Wall with sense = 2; expected .1"),
    (lambda: set_state(vel=(0, 0, 0.01)), OUT),
    (lambda: set_state(angVel=(3, 0, 0)), OUT),
    (lambda: set_state(angVel=(0, 1e-3, 0)), OUT),
    (lambda: setattr(O.bodies[1], "material", w.ElastMat(density=1000)),
     "#1 has the material ElastMat, which has no friction; give it a FrictMat"),
    (lambda: add(utils.box, (0, 0, 5), (1, 1, 1), fixed=True),
     "#2 is a Box at z = 5 that does not reach the plane z = 0"),
    (lambda: add(utils.facet, [(0, -1, 1), (1, -1, 1), (0, -1, 2)]),
     "#2 is a Facet that does not cut the plane z = 0"),
    (lambda: insert(3, w.ParallelEngine([w.ForceEngine(force=(0, -500, 0), ids=[1])])),
     "holds a ParallelEngine, whose engines cannot be checked"),
    (lambda: (add(rcr.disc, (0, 9), 0.1),  # far above all other bodies
              with_functors("Ig2_Rcr_Rcr_RcrGeom", "Ig2_Wall_Rcr_RcrGeom")),
     r"handles (?=.*Sphere)(?=.*Wall)(?=.*Rcr)(\w+ and \w+ \(bodies #[0-2], #[0-2]\), ){2}so they "
     r"would pass through each other. Add (?=.*Ig2_Wall_Sphere_RcrGeom\(\))"
     r"(?=.*Ig2_Sphere_Rcr_RcrGeom\(\)).* to its first list"),
]
FAULTS = [*(("rigid", *row) for row in RIGID + BOTH), *(("smooth", *row) for row in BOTH)]


LATE = [  # faults that show in the course of a step
    *(("rigid", lambda value=value: setattr(O.engines[2].physDispatcher.functors[0], "restitution",
                                            value),
       "has the restitution nan; .*a MatchMaker needs algo='val', or a match for each pair")
      for value in (w.MatchMaker(algo="avg"), w.MatchMaker(matches=((7, 8, 0.5),)))),
    ("rigid", lambda: reorder(0, 1, 2, 4, 3), "stands after the NewtonIntegrator"),
    ("rigid",
     lambda: insert(3, w.RotationEngine(ids=[0], rotationAxis=(0, 0, 1), angularVelocity=1)),
     "#0 is a Wall with the angular velocity .*use a Box or rcr.segment"),
    ("smooth", lambda: press("kn", -1.0),
     "bodies #0 and #1 has kn = -1; expected a stiffness > 0: set FrictMat.young"),
    ("smooth", lambda: press("kn", NAN), "kn = -?nan"),
    ("smooth", lambda: press("ks", -1.0), "ks = -1; expected a stiffness ≥ 0"),
]


@pytest.mark.parametrize("law, fault, match", FAULTS + LATE)
def test_faults(law, fault, match):
    resting(law)
    fault()
    assert_refused(match, moved=(law, fault, match) in LATE)


@pytest.mark.skipif(not hasattr(w, "VTKRecorder"), reason="not in every YADE")
def test_a_vtk_recorder_before_the_solver_is_refused():
    resting()
    with warns("VTKRecorder is written for spheres"):
        insert(3, w.VTKRecorder())
    assert_refused("the VTKRecorder stands before ContactDynamics")


@pytest.mark.parametrize("obstacle", [
    lambda: rcr.wall("x", -5),
    lambda: rcr.segment((-5, 0), (-4, 1)),
    lambda: utils.box((-5, 0, 0), (0.1, 0.1, 0.1), fixed=True),
], ids=["wall", "segment", "box"])
@pytest.mark.parametrize("state, match", [
    (dict(pos=(0, NAN, 0)), "position .*nan"),
    (dict(vel=(NAN, 0, 0)), "velocity .*nan"),
    (dict(angVel=(0, 0, INF)), "angular velocity .*inf"),
    (dict(ori=Quaternion(NAN, 0, 0, 0)), "orientation"),
], ids=["position", "velocity", "spin", "orientation"])
def test_obstacle_that_becomes_faulty_in_a_run(obstacle, state, match):
    resting()
    O.bodies.append(obstacle())
    O.run(30, True)
    set_state(2, **state)
    assert_refused(f"#2 has .*{match}")


@LAWS
@pytest.mark.parametrize("engine", [
    lambda: w.TranslationEngine(ids=[0], translationAxis=(1, 0, 0), velocity=2e-3 / O.dt),
    lambda: w.StepDisplacer(ids=[0], mov=(1e-3, 0, 0)),
    lambda: w.CombinedKinematicEngine(ids=[0], comb=[
        w.TranslationEngine(translationAxis=(1, 0, 0), velocity=1e-3 / O.dt)] * 2),
], ids=["motion", "displacer", "combined"])
def test_engines_without_forces_may_follow_the_integrator(law, engine):
    resting(law)
    insert(9, engine())
    steps(2)
    assert O.bodies[0].state.pos[0] == pytest.approx(2e-3)
    if law == "rigid":  # the solver sees a load before it
        insert(3, w.ForceEngine(force=(0, -500, 0), ids=[1]))
        steps(20)
        assert O.bodies[1].state.pos[1] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("polygon", [False, True])
def test_the_steppers_first_step(polygon):
    """Without contacts YADE's stepper takes the wave speed of spheres, or 1 s without any."""
    resting("smooth")
    if polygon:
        build(rcr.regular_polygon((0, 0.2), 0.1, 5, material=material()), law="smooth")
    else:
        set_state(pos=Vector3(0, 0.2, 0))
    stepper = w.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.4)
    insert(0, stepper)
    assert_refused(r"GlobalStiffnessTimeStepper.defaultDt = -1 would set O.dt = 1 s while no grains "
                   r"touch; set defaultDt = 0.5 \* rcr.critical_time_step\(\)")
    stepper.defaultDt = 0.5 * rcr.critical_time_step()
    steps(5)
    assert O.dt == stepper.defaultDt


# --- pairs that may meet

@LAWS
def test_pairs_that_cannot_meet_want_no_ig2(law):
    """A grain without partner, fixed bodies, other masks and members of a clump do not meet."""
    resting(law)
    with_functors("Ig2_Wall_Rcr_RcrGeom")
    O.step()
    add(rcr.disc, (3, -1), 0.1, mask=2)
    add(utils.box, (5, 0, 0), (0.1, 0.1, 0.1), fixed=True, mask=2)
    with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Box_Sphere_RcrGeom")
    O.step()
    add(rcr.disc, (4, -1), 0.1, mask=2, fixed=True)
    assert_refused(r"no Ig2 functor .* handles Sphere and Sphere \(bodies #[24], #[24]\)")


def test_members_of_one_clump_want_no_ig2():
    build(rcr.wall("y", 0, material=material()))
    for x in 0, 2:
        rough = O.bodies[0].material
        rcr.clump([stadium(0.2, 0.1, (x, 0.3), material=rough),
                   rcr.disc((x + 0.1, 0.4), 0.1, material=rough)])
        if x == 0:
            with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Wall_Sphere_RcrGeom")
            O.step()
    assert_refused(
        r"Add (?=.*Ig2_Rcr_Rcr_RcrGeom)(?=.*Ig2_Sphere_Rcr_RcrGeom)(?=.*Ig2_Sphere_Sphere_RcrGeom)")


# --- processes that YADE alone ends

@pytest.mark.parametrize("height, fault, match", [
    *((height, fault, match) for height in (0.1, 5) for fault, match in (
        ("O.engines[2].lawDispatcher.functors = []", "no Law2_RcrGeom_CdPhys_SignoriniCoulomb"),
        ("O.engines[2].physDispatcher.functors = []", "no Ip2_FrictMat_FrictMat_CdPhys"),
        ("O.engines[2].physDispatcher.functors = [w.Ip2_FrictMat_FrictMat_FrictPhys()]",
         "no Ip2_FrictMat_FrictMat_CdPhys"))),
    (0.15, "insert(5, PyRunner(iterPeriod=1, command='O.bodies[1].material = "
     "ElastMat(density=1000)')); O.run(500, True)", "give it a FrictMat"),
])  # fmt: skip
def test_faults_by_which_yade_alone_ends_the_process(height, fault, match):
    """exit(1) without a law, and exceptions without physics or in the parallel loop."""
    result = python(f"""
from scenes import *
from yade.wrapper import ElastMat, PyRunner
grain_on_floor(0.2, height={height})
try:
    {fault}
    O.step()
except (ValueError, RuntimeError) as error:
    print(error)
""")
    assert match in result.stdout, result.stdout + result.stderr


def test_discs_without_a_law_are_refused():
    """YADE ends the process at the first contact."""
    build(rcr.disc((0, 0), 0.1), rcr.disc((0, 1), 0.1), law="smooth")
    O.engines[2].lawDispatcher.functors = []
    assert_refused("no law for contacts of rcr; put Law2_RcrGeom_CdPhys_SignoriniCoulomb")


def test_plugin_of_another_version():
    result = python("""
import yade, yade.config
yade.config.version = "1999.1"
try:
    import rcr
except ImportError as error:
    print(error)
assert "Rcr" not in yade.system.childClasses("Shape")
""")
    for words in ("rcr was built for YADE 20",
                  "but YADE 1999.1 is running. Start scripts/yade-rcr to rebuild it"):
        assert words in result.stdout, result.stderr


# --- how errors arrive

@pytest.mark.parametrize("dt, wait", [(1e-5, True), (1e-4, False)])
def test_a_run_stops_at_the_error(dt, wait):
    """It comes with a contact, after √(2h/g) = 0.32 s; YADE's wait() misses earlier ones."""
    grain_on_floor(0, height=0.6, dt=dt, restitution=2)
    if wait:
        refused("contact of bodies #0 and #1 has the restitution 2; expected 0 to 1", O.run,
                100_000, wait=True, error=RuntimeError)
    else:
        O.run(100_000)
        wait_until(lambda: not O.running)
    assert 0.25 < O.iter * dt < 0.35


def test_a_run_that_fails_raises_every_time():
    """YADE's run thread loses its exception if it ends before the session waits."""
    resting()
    set_state(mass=0)
    refused("#1 is free but has the mass 0", O.run, 1000)
    assert not O.running and O.iter == 0
    for _ in range(30):
        build(grain((0, 1)), before=[w.ForceEngine(force=(NAN, 0, 0), ids=[0])])
        refused("body #0 has the force", O.run, 5, True, error=RuntimeError)
        with pytest.raises(RuntimeError, match="body #0 has the force"):
            O.run(5)  # raises here if the thread has ended
            O.wait()


@pytest.mark.parametrize("fault", [dict(mass=0), dict(inertia=(1, 1, 0))], ids=str)
def test_an_exception_leaves_no_trace(fault):
    """A refused step, corrected and made, gives the bits of a run without the fault."""
    def run(fault):
        resting()
        state = O.bodies[1].state
        state.vel = (3.0, -2.0, 0)
        steps(5)
        if fault:
            right = dict(mass=state.mass, inertia=tuple(state.inertia))
            set_state(**fault)
            assert_refused("mass 0|moment of inertia 0")
            set_state(**right)
        steps(20)
        return snapshot()

    assert np.array_equal(run({}), run(fault))


@pytest.mark.parametrize("law, height, run", [
    ("rigid", 0.0999, O.step), ("smooth", 0.0999, O.step),
    ("rigid", 0.15, lambda: O.run(400, True)),
], ids=["rigid", "smooth", "a contact that forms in arrays"])
@pytest.mark.parametrize("name", ["CohFrictMat", "InelastCohFrictMat", "MortarMat"])
def test_cohesive_materials_are_refused(law, height, run, name):
    cohesive = getattr(w, name)(density=1000, young=1e7, poisson=0.5, frictionAngle=0.4)
    build(rcr.wall("y", 0, 1, material=cohesive), rcr.disc((0, height), 0.1, cohesive), law=law)
    refused(f"has the material {name} .* give it a FrictMat", run,
            error=ValueError if run == O.step else RuntimeError)


@pytest.mark.parametrize("again", [False, True])
def test_contacts_that_outlive_their_bodies_are_refused(again):
    grain_on_floor(0)
    steps(3)
    O.bodies.clear()
    if again:
        rough = material(0.5)
        O.bodies.append([rcr.wall("y", 0, material=rough), rcr.disc((0, 0.1), 0.1, rough)])
    refused(r"call O.interactions.clear\(\) after O.bodies.clear\(\)", O.step)


def test_an_erasure_of_pairs_that_the_collider_has_listed_is_refused():
    grain_on_floor(0)
    steps(3)
    refused(r"eraseNonReal\(\) the collider would miss contacts", O.interactions.eraseNonReal)


def test_a_scene_that_becomes_faulty_is_refused_at_its_next_contact():
    """One error; the scene continues after the fault is mended."""
    disc = grain_on_floor(0, height=0.3, tolerance=1e-4)
    solver().arrays = False
    insert(4, w.PyRunner(command="O.bodies[1].mat.frictionAngle = 2", iterPeriod=20, nDo=2))
    with pytest.raises(RuntimeError, match="rcr: body #.* has the friction angle 2"):
        O.run(400, True)
    O.wait()
    fallen = O.bodies[disc].state.pos[1]
    assert 0.1 < fallen < 0.12
    O.bodies[disc].mat.frictionAngle = 0.4
    O.run(50, True)
    assert O.bodies[disc].state.pos[1] == pytest.approx(0.1, abs=1e-3)


def lift():
    O.bodies[2].state.pos += Vector3(0, 0, 5)


@pytest.mark.parametrize("arrays", [True, False])
@pytest.mark.parametrize("obstacle, match", [
    (lambda: rcr.segment((1, 0), (1, 1)), "#2 is a Facet that does not cut the plane"),
    (lambda: utils.box((1, 0, 0), (0.1, 0.1, 0.1), fixed=True), "#2 is a Box at z = 5"),
], ids=["segment", "box"])
def test_an_obstacle_that_leaves_the_plane_in_a_run_is_refused(obstacle, match, arrays):
    """The grain falls onto the floor after the obstacle has left."""
    grain_on_floor(0, height=0.3, tolerance=1e-4)
    O.bodies.append([obstacle(), *(rcr.disc((2 + 0.3 * k, 0.3), 0.1) for k in range(5))])
    solver().arrays = arrays
    insert(4, calls(lift, 20, nDo=2))
    with pytest.raises(RuntimeError, match=match):
        O.run(400, True)
    assert O.iter < 50 and O.bodies[1].state.pos[1] > 0.2


@LAWS
@pytest.mark.parametrize("gap", [-1e-4, 5e-3], ids=["touching", "listed"])
def test_contacts_of_other_functors_are_refused(law, gap):
    """Listed pairs are given to the new functors; contacts of YADE's law must be cleared."""
    m = springy()
    build(rcr.disc((0, 0), 0.1, m, fixed=True), rcr.disc((0, 0.2 + gap), 0.1, m), law=law)
    own, O.dt = O.engines, 1e-5
    loop = w.InteractionLoop([w.Ig2_Sphere_Sphere_ScGeom()], [w.Ip2_FrictMat_FrictMat_FrictPhys()],
                             [w.Law2_ScGeom_FrictPhys_CundallStrack()])
    O.engines = [own[0], own[1], loop, own[-1]]
    O.run(20, True)
    O.engines = own
    if gap < 0:
        refused(r"has the geometry ScGeom .* call O.interactions.clear\(\)", O.run, 2, True)
        O.interactions.clear()
    O.run(20, True)
    assert all(isinstance(i.geom, rcr.RcrGeom) for i in O.interactions if i.isReal)


@pytest.mark.parametrize("arrays", [True, False])
def test_a_functor_that_was_missing_can_be_added(arrays):
    m = material(0.5)
    build(rcr.wall("y", 0, 1, material=m), rcr.disc((0, 0.1), 0.1, m, fixed=True),
          rcr.particle((0, 0.36), 0.1, 0.3, material=m, fixed=True))
    solver().arrays = arrays
    O.engines[1].verletDist = 0.2
    with_functors("Ig2_Wall_Rcr_RcrGeom", "Ig2_Wall_Sphere_RcrGeom", "Ig2_Rcr_Rcr_RcrGeom")
    insert(5, w.PyRunner(command="O.bodies[2].state.blockedDOFs = 'zXY'", iterPeriod=1,
                         firstIterRun=20, nDo=1))
    refused("Add Ig2_Sphere_Rcr_RcrGeom", O.run, 400, True, error=RuntimeError)
    loop = O.engines[2].geomDispatcher
    loop.functors = [*loop.functors, rcr.Ig2_Sphere_Rcr_RcrGeom()]
    O.run(300, True)
    assert O.bodies[2].state.pos[1] > 0.26


@pytest.mark.parametrize("arrays", [True, False])
def test_shapes_that_rcr_does_not_have_are_no_holes(arrays):
    m = material(0.5)
    corners = [(-0.2, -0.01, -0.2), (0.2, -0.01, -0.2), (0, -0.01, 0.4), (0, 0.01, 0)]
    obstacle = w.Body(shape=w.Tetra(v=corners), material=m)
    obstacle.state.blockedDOFs = "xyzXYZ"
    build(*(rcr.disc((0.03 * k, 0.15), 0.01, m, velocity=(0, -3)) for k in range(6)), obstacle)
    solver().arrays = arrays
    O.engines[1].boundDispatcher.functors = [*O.engines[1].boundDispatcher.functors,
                                             w.Bo1_Tetra_Aabb()]
    refused("handles Sphere and Tetra", O.run, 300, True, error=RuntimeError)


def test_an_orientation_of_another_norm_is_refused():
    resting()
    O.bodies[1].state.ori = Quaternion(0.5, 0, 0, 0.5)
    refused("body #1 has an orientation of the norm 0.7", O.step)
    O.bodies[1].state.ori = Quaternion(0.7071, 0, 0, 0.7071)
    with warns("bodies #0 and #1 overlap"):  # the grain stands upright
        O.step()


@LAWS
def test_a_collider_that_loses_its_verlet_distance_is_refused(law):
    resting(law)
    O.run(20, True)
    O.engines[1].verletDist = 0
    refused("put a new InsertionSortCollider into O.engines", O.run, 20, True)


def test_a_material_is_refused_before_its_body_moves():
    cohesive = w.CohFrictMat(density=1000, young=1e7, poisson=0.5, frictionAngle=0.4)
    build(rcr.wall("y", 0, 1, material=cohesive), rcr.disc((0, 0.0999), 0.1, cohesive))
    for _ in range(3):
        refused("has the material CohFrictMat", O.step)
        assert O.iter == 0 and O.bodies[1].state.pos[1] == 0.0999


def test_springs_allow_a_box_that_turns():
    plate = utils.box((0, 0.3, 0), (0.02, 0.02, 0.5), material=springy())
    build(rcr.disc((3, 0.1), 0.1, springy()), plate, law="smooth", dt=1e-5)
    set_state(1, blockedDOFs="zXY")
    O.run(5, True)
    assert rcr.critical_time_step() > 0


def test_a_time_averager_reads_the_weight_of_a_grain_at_rest():
    resting()
    averager = w.TimeAverager(ids=[1])
    O.run(50, True)
    insert(9, averager)
    averager.initialization()
    O.run(50, True)
    assert averager.getForce(1)[1] == pytest.approx(9.81 * O.bodies[1].state.mass)


def replace_the_disc():
    O.bodies.erase(1)
    O.bodies.insertAtId(grain((0, 0.3), material=O.bodies[0].material), 1)


@pytest.mark.parametrize("arrays", [False, True])
def test_a_body_that_replaces_another_is_checked(arrays):
    """A PyRunner puts a rod in the place of a disc; the collider has no Bo1 functor for rods."""
    m = material()
    build(rcr.wall("y", 0, 1, material=m), rcr.disc((0, 0.1), 0.1, m), rcr.disc((1, 0.1), 0.1, m))
    solver().arrays = arrays
    bounds = O.engines[1].boundDispatcher
    bounds.functors = [f for f in bounds.functors if not isinstance(f, rcr.Bo1_Rcr_Aabb)]
    insert(9, calls(replace_the_disc, 20, firstIterRun=20, nDo=1))
    refused("no Bo1_Rcr_Aabb, so body #1 would meet nothing", O.run, 500, True,
            error=RuntimeError)
    assert O.bodies[1].state.pos[1] > 0.29


def test_numbers_of_numpy_are_numbers():
    build()
    rough = O.materials.append(material())
    floor = O.bodies.append(rcr.wall("y", 0, sense=np.int64(1), material=np.int64(rough)))
    body = grain((0, 0.1), material=np.int8(rough), mask=np.int64(3), color=np.array([1, 0, 0]))
    O.bodies.append(body)
    engine = solver()
    engine.maxIterations, engine.tolerance = np.int64(77), np.float32(0.5)
    for observed in (np.array([floor]), [np.int64(floor)], (np.int32(floor),)):
        engine.observe = observed
        assert list(engine.observe) == [floor]
    assert (body.mask, engine.maxIterations, engine.tolerance) == (3, 77, 0.5)
    made = rcr.ContactDynamics(threads=np.int64(2), observe=np.array([3, 4]))
    assert made.threads == 2 and list(made.observe) == [3, 4]


@pytest.mark.parametrize("change, name", [
    (lambda: O.interactions.clear(), "O.interactions.clear"),
    (lambda: O.bodies.erase(1), "O.bodies.erase"),
    (lambda: O.bodies.clear(), "O.bodies.clear"),
    (lambda: add(rcr.particle, (3, 0.1), 0.1, 0.5), "O.bodies.append"),
    (lambda: setattr(O, "engines", list(O.engines)), "O.engines = …"),
])
def test_a_console_changes_no_lists_while_the_scene_runs(change, name):
    """The run loops over bodies, contacts and engines, and would read what is gone."""
    build(*(grain((0.3 * k, 0.1), material=material()) for k in range(3)))
    O.run()
    try:
        refused(f"{name} while the scene runs .* O.pause", change, error=RuntimeError)
    finally:
        O.pause()
    change()
    if len(O.bodies):
        O.run(3, True)


def test_a_run_may_be_paused_removed_or_left_at_once():
    """On one processor its thread begins late, and read the memory of a removed run."""
    result = python("""
import os
import yade
import rcr
from scenes import build, material
from yade import O

os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
for _ in range(200):
    build(rcr.particle((0, 0.1), 0.1, 0.5, material=material()))
    O.run()
    O.pause()
O.run()  # the script ends before the run
""")
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("wait", ["O.wait()", "O.run(3, True)"])
def test_an_engine_does_not_wait_for_its_own_run(wait):
    build(grain((0, 0.1), material=material()))
    insert(0, w.PyRunner(command=wait, iterPeriod=1))
    refused("an engine waits for the end of the run", O.run, 5, True, error=RuntimeError)


def test_a_negative_id_is_not_erased():
    """YADE reads the body before the first one."""
    build(grain((0, 0.1), material=material()))
    refused(r"erase\(-1\): expected the id of a body", lambda: O.bodies.erase(-1), error=IndexError)
    assert len(O.bodies) == 1


def test_ctrl_c_ends_a_wait():
    build(grain((0, 0.1), material=material()))
    O.run(10**7)
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    refused("", O.wait, error=KeyboardInterrupt)
    assert not O.running and O.iter < 10**7
