"""Errors of users: a message says what was given, expected and to do, and nothing moves.

O.step() raises the engine's ValueError. O.run(wait=True) raises a RuntimeError with the same words,
since YADE runs it in a thread. A run in the background stops at the error and logs it.
"""

import math

import numpy as np
import pytest
import rcr
import yade.utils
from scenes import (assert_refused, build, grain_on_floor, insert, material, python, solver,
                    stadium, steps, wait_until)
from yade import O
from yade.minieigenHP import Quaternion
from yade.wrapper import Body, ForceEngine, MatchMaker, RotationEngine

NAN, INF = math.nan, math.inf


def resting(**options):
    """A grain at rest on a wall (0), and a second one above it."""
    grain_on_floor(0.2, **options)
    O.bodies.append(stadium(0.2, 0.1, (0, 0.3), material=O.bodies[1].material))
    return O.bodies[1]


# --- calls ----------------------------------------------------------------------------------------

def grain(center=(0, 0), R=0.1, eta=0.5, **options):
    return rcr.particle(center, R, eta, **options)


CALLS = [  # function, words of its ValueError
    *((lambda R=R: grain(R=R), "R = .*; expected a finite radius of the circumscribed circle > 0")
      for R in (0, -0.1, NAN, INF, "0.1", None)),
    *((lambda eta=eta: grain(eta=eta), "eta = .*; expected an elongation 0 ≤ eta < 1")
      for eta in (-0.1, 1, 1.5, NAN)),
    (lambda: grain((0, NAN)), r"center\[1\] = nan; expected a finite coordinate"),
    (lambda: grain(angle=INF), "angle = inf; expected a finite angle"),
    (lambda: grain(material=material(density=0)),
     "material.density = 0.0; expected a finite density > 0"),
    (lambda: grain(material=None), "material = None; expected a FrictMat"),
    *((lambda given={name: value}: rcr.Rcr(**{"capRadius": 0.1, "halfLength": 0.2, **given}),
       f"Rcr.{name} = .*; expected a finite length .* rcr.particle")
      for name, value in (("capRadius", 0), ("capRadius", -1), ("capRadius", INF),
                          ("halfLength", -1), ("halfLength", NAN))),
    *((lambda axis=axis: rcr.wall(axis, 0), rf"axis = {axis!r}; expected 'x' or 'y' \(or 0 or 1\)")
      for axis in ("z", 2, -1, 0.5, True, None)),
    *((lambda sense=sense: rcr.wall("y", 0, sense=sense), "sense = .*; expected [+]1, −1, or 0")
      for sense in (5, -2, 0.5, "left")),
    (lambda: rcr.wall("x", NAN), "position = nan; expected a finite coordinate"),
    (lambda: rcr.wall("y", 0, material=3.5), "material = 3.5; expected a FrictMat"),
    (lambda: rcr.mobile_wall("x", 0, mass=0), "mass = 0; expected a finite mass > 0"),
    *((lambda ends=ends: rcr.segment(*ends), "expected")
      for ends in (((0, 0), (0, 0)), ((0, 0, 0), (1, 0, 1)), ((0, 0), (NAN, 0)))),
    (lambda: rcr.segment((0, 0), (NAN, 1)), r"end\[0\] = nan"),
    *((lambda members=members: rcr.clump(members), "at least one body")
      for members in ([], ["grain"])),
    (lambda: rcr.clump([grain()] * 2), "members holds a body twice"),
    *((lambda damping=damping: rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=damping),
       "CundallStrack.damping = .*; expected a fraction of the critical damping")
      for damping in (-0.1, NAN, INF)),
    (lambda: rcr.plot.packing(limits=((1, 1), (0, 0))), "limits = .* in this order"),
    (lambda: rcr.contact_network(time=1.0, seed=3),
     r"contact_network\(time=…\): the scene gives it"),
]


@pytest.mark.parametrize("call, match", CALLS)
def test_calls_that_are_refused(call, match):
    build(stadium(0.2, 0.1, (0, 1), material=material()))
    with pytest.raises(ValueError, match=match):
        call()
    assert len(O.bodies) == 1


def test_shape_without_a_radius():
    resting()
    body = Body(shape=rcr.Rcr(), material=material())
    body.state.blockedDOFs = "xyzXYZ"
    O.bodies.append(body)
    assert_refused("#3 has the cap radius -?nan; expected a length > 0")


@pytest.mark.parametrize("half", [(INF, 1, 1), (1, NAN, 1), (1, -1, 1)], ids=str)
def test_extents_of_a_box(half):
    """Grains would fall through it."""
    rough = material()
    build(yade.utils.box((0, -1, 0), half, fixed=True, material=rough),
          stadium(0.2, 0.1, (0, 0.1), material=rough))
    assert_refused(r"#0 is a Box with the extents \(.*\), so nothing would meet it")


@pytest.mark.parametrize("radius", [0, -0.1, NAN])
def test_radius_of_a_disc(radius):
    resting()
    O.bodies.append(rcr.disc((3, 1), 0.1, material=material()))
    O.bodies[3].shape.radius = radius
    assert_refused("#3 has the cap radius .*; expected a length > 0.*radius of a disc")


@pytest.mark.parametrize("name, number", [("x", 0), ("y", 1)])
def test_axis_of_a_wall_by_its_number(name, number):
    """Numbers as in YADE's own walls."""
    assert rcr.wall(number, 0.5, velocity=2).state.vel == rcr.wall(name, 0.5, velocity=2).state.vel
    one, two = (rcr.mobile_wall(axis, 0, mass=1) for axis in (name, np.int64(number)))
    assert one.shape.axis == two.shape.axis == number
    assert one.state.blockedDOFs == two.state.blockedDOFs


# --- bodies ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("name, value, match", [
    ("mass", 0, "#1 is free but has the mass 0; give it a mass > 0"),
    ("mass", NAN, "#1 is free but has the mass nan"),
    ("inertia", (1, 1, 0), "#1 is free to turn but has the moment of inertia 0 about z"),
    ("blockedDOFs", "XY", "#1 is free to leave the plane .blockedDOFs = 'XY'.; expected z, X and Y "
     "blocked"),
    ("blockedDOFs", "", "#1 is free to leave the plane"),
    ("ori", Quaternion((1, 0, 0), 0.1), "#1 is tilted out of the plane"),
    ("pos", (NAN, 0, 0), "#1 .*position.*nan"),
    ("pos", (0, INF, 0), "#1 .*position.*inf"),
    ("vel", (NAN, 0, 0), "#1 .*velocity.*nan"),
    ("angVel", (0, 0, NAN), "#1 .*velocity.*nan"),
])  # fmt: skip
def test_state_of_a_body(name, value, match):
    setattr(resting().state, name, value)
    assert_refused(match)


@pytest.mark.parametrize("obstacle", [
    lambda: rcr.wall("x", -5),
    lambda: rcr.segment((-5, 0), (-4, 1)),
    lambda: yade.utils.box((-5, 0, 0), (0.1, 0.1, 0.1), fixed=True),
], ids=["wall", "segment", "box"])
@pytest.mark.parametrize("change, match", [
    (lambda b: setattr(b.state, "pos", (0, NAN, 0)), "position .*nan"),
    (lambda b: setattr(b.state, "vel", (NAN, 0, 0)), "velocity .*nan"),
    (lambda b: setattr(b.state, "angVel", (0, 0, INF)), "angular velocity .*inf"),
    (lambda b: setattr(b.state, "ori", Quaternion(NAN, 0, 0, 0)), "orientation"),
], ids=["position", "velocity", "spin", "orientation"])
def test_obstacle(obstacle, change, match):
    """A wall at NaN ended the process."""
    resting()
    body = O.bodies[O.bodies.append(obstacle())]
    O.run(30, True)
    change(body)
    assert_refused(f"#{body.id} has .*{match}")


def test_wall_that_turns():
    """Its points would have velocities, but it would stay where it is."""
    resting(before=[RotationEngine(ids=[0], rotationAxis=(0, 0, 1), angularVelocity=0.1)])
    assert_refused("#0 is a Wall with the angular velocity .*use a Box or rcr.segment", moved=True)


def test_wall_made_dynamic():
    resting()
    O.bodies[0].dynamic = True
    assert_refused("#0 is free but has the mass 0; give it a mass > 0")


@pytest.mark.parametrize("before", ["ForceEngine", "permanent force", "permanent torque"])
def test_nan_force_of_another_engine(before):
    resting(before=[ForceEngine(force=(NAN, 0, 0), ids=[1])] if before == "ForceEngine" else [])
    if before == "permanent force":
        O.forces.setPermF(1, (0, NAN, 0))
    if before == "permanent torque":
        O.forces.setPermT(1, (0, 0, NAN))
    assert_refused("#1 .*(force|torque).*nan")


def test_clump_that_is_turned_out_of_the_plane():
    resting()
    O.bodies.appendClumped([stadium(0.1, 0.1, (1, 1), material=material()),
                            stadium(0.1, 0.1, (1, 1.1), material=material())])
    assert_refused("is (tilted out of the plane|free to leave the plane).*rcr.clump")


# --- engines --------------------------------------------------------------------------------------

@pytest.mark.parametrize("order, match", [
    ([0, 1, 2, 3], "O.engines holds no NewtonIntegrator"),
    ([0, 1, 3, 4], "O.engines holds no InteractionLoop"),
    ([0, 1, 3, 2, 4], "stands before the InteractionLoop"),
    ([0, 1, 2, 4, 3], "stands after the NewtonIntegrator"),
])  # fmt: skip
def test_order_of_engines(order, match):
    """Indices of the engines of `resting`: 3 is ContactDynamics, 4 the integrator."""
    resting()
    old = list(O.engines)
    O.engines = [old[k] for k in order]
    O.engines[1].verletDist = 0  # otherwise the collider misses the integrator first
    assert_refused(match, moved=order[-2:] == [4, 3])  # by the integrator


@pytest.mark.parametrize("name, value, match", [
    ("dead", True, "O.engines holds no NewtonIntegrator"),
    ("damping", 0.2, "NewtonIntegrator.damping = 0.2.* would damp the contact forces; set "
     "damping=0"),
])  # fmt: skip
def test_integrator(name, value, match):
    resting()
    setattr(O.engines[-1], name, value)
    assert_refused(match)


@pytest.mark.parametrize("dt", [0, NAN, INF])
def test_time_step(dt):
    resting()
    O.dt = dt
    assert_refused("O.dt = .*; expected a finite time step > 0")


def test_negative_time_step_is_refused_by_yade():
    resting()
    with pytest.raises(RuntimeError, match="No TimeStepper"):
        O.dt = -1e-3


@pytest.mark.parametrize("name, value, match", [
    ("solver", "magic", "magic.*nlgs.*nesterov.*exact.*auto"),
    ("tolerance", -1e-4, "tolerance = -0.0001"),
    ("tolerance", NAN, "tolerance = -?nan"),
    ("tolerance", INF, "tolerance = inf; expected a finite residual"),
    ("meanForceChange", INF, "meanForceChange = inf: give a finite change"),
    ("minIterations", 10**9, "minIterations = 1000000000.*at most maxIterations = "),
    ("maxIterations", 0, "maxIterations = 0"),
    ("maxIterations", -5, "maxIterations = -5"),
    ("correction", -0.1, "correction = -0.1.*; expected a fraction of the overlap, 0 to 1"),
    ("correction", 1.1, "correction = 1.1.*; expected a fraction of the overlap, 0 to 1"),
    ("correction", NAN, "correction = nan"),
    *(("yieldCompliance", value, f"ContactDynamics.yieldCompliance = {value:g}; expected a finite "
       f"factor ≥ 0, 1 by default") for value in (NAN, INF, -1.0)),
])  # fmt: skip
def test_settings(name, value, match):
    """The message has the given value, not its product with a factor of the scene."""
    resting()
    setattr(solver(), name, value)
    assert_refused(match)


@pytest.mark.parametrize("e", [-0.1, 1.1, NAN])
def test_restitution(e):
    resting(restitution=e)
    assert_refused("contact of bodies #0 and #1 has the restitution .*; expected 0 to 1")


@pytest.mark.parametrize("angle", [-0.1, 1.6, NAN])
def test_friction(angle):
    resting()
    O.engines[2].physDispatcher.functors[0].frictAngle = MatchMaker(algo="val", val=angle)
    assert_refused("contact of bodies #0 and #1 has the friction coefficient .*; expected a "
                   "friction angle from 0 to below π/2")


# --- functors -------------------------------------------------------------------------------------

def test_functor_for_a_facet_forgotten():
    resting()
    O.bodies.append(yade.utils.facet([(-1, 0.25, -1), (1, 0.25, -1), (0, 0.25, 1)],
                                     material=material()))
    O.engines[2].geomDispatcher.functors = [rcr.Ig2_Wall_Rcr_RcrGeom(), rcr.Ig2_Rcr_Rcr_RcrGeom()]
    assert_refused("no Ig2 functor of the InteractionLoop handles .*(Facet|Rcr) and (Rcr|Facet) "
                   ".*Add Ig2_Facet_Rcr_RcrGeom")


@pytest.mark.parametrize("height", [0.1, 5], ids=["in contact", "no contact yet"])
@pytest.mark.parametrize("functors, match", [
    ("lawDispatcher.functors = []", "no Law2_RcrGeom_CdPhys_SignoriniCoulomb"),
    ("physDispatcher.functors = []", "no Ip2_FrictMat_FrictMat_CdPhys"),
    ("physDispatcher.functors = [Ip2_FrictMat_FrictMat_FrictPhys()]",
     "no Ip2_FrictMat_FrictMat_CdPhys"),
])  # fmt: skip
def test_missing_functor_of_the_contact(functors, match, height):
    """YADE alone ends the process: exit(1) without a law, an exception without physics."""
    result = python(f"""
from scenes import *
grain_on_floor(0.2, height={height})
O.engines[2].{functors}
try:
    O.step()
except ValueError as error:
    print(error)
""")
    assert result.returncode == 0 and match in result.stdout, result.stdout + result.stderr


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


# --- how errors arrive ----------------------------------------------------------------------------

def test_run_and_wait_raises():
    """YADE's wait() misses an early error; this one comes after 30 000 steps with a contact."""
    grain_on_floor(0, height=0.6, dt=1e-5, restitution=2)
    with pytest.raises(RuntimeError, match="contact of bodies #0 and #1 has the restitution 2; "
                       "expected 0 to 1"):
        O.run(100_000, wait=True)
    assert 25_000 < O.iter < 35_000  # √(2h/g) / dt = 32 000


def test_background_run_is_refused_before_it_begins():
    body = resting()
    body.state.mass = 0
    with pytest.raises(ValueError, match="#1 is free but has the mass 0"):
        O.run(1000)
    assert not O.running and O.iter == 0


def test_background_run_stops_at_the_error():
    grain_on_floor(0, height=0.6, dt=1e-4, restitution=2)
    O.run(100_000)
    wait_until(lambda: not O.running)
    assert 2500 < O.iter < 3500  # √(2h/g) / dt = 3200


def test_a_stress_on_a_wall_that_is_held_is_refused():
    """A held wall does not move under a stress."""
    m = material()
    build(rcr.wall("x", -1, material=m), rcr.wall("x", 1, material=m),
          rcr.wall("y", 3, sense=-1, material=m), stadium(0.2, 0.1, (0, 1), material=m))
    insert(3, rcr.WallStress(wall=2, start=0, end=1, stress=-10))
    assert_refused("WallStress.wall = 2 is held along y, so that no stress moves it; take "
                   "rcr.mobile_wall")
    O.engines[3].dead = True
    O.step()


def test_a_scene_continues_once_the_error_is_corrected():
    body = resting()
    mass, body.state.mass = body.state.mass, 0
    assert_refused("#1 is free but has the mass 0")
    body.state.mass = mass
    steps(10)
    assert body.state.pos[1] == pytest.approx(0.1, abs=1e-12)  # rounding
