"""Faulty scenes of polygons are refused or warned of, as those of Rcrs are."""

import math
import warnings

import numpy as np
import pytest
import rcr
from scenes import (assert_refused, build, insert, refused, set_state, springy, steps, warns,
                    without)
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Quaternion

SQUARE = 0.1 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
OWN = "rcr.polygon.center, vertices, radius. makes a body from any corners"


def square(at=(0, 0.1), **options):
    return rcr.polygon(at, SQUARE, material=O.materials[0], **options)


def resting(law="rigid"):
    """A square (1) at rest on a wall (0)."""
    build(law=law, dt=1e-3 if law == "rigid" else 1e-5)
    O.materials.append(springy())
    O.bodies.append([rcr.wall("y", 0, material=O.materials[0]), square()])


def keep(functors):
    """Take the functors of polygons away."""
    functors.functors = [f for f in functors.functors if "Polygon" not in type(f).__name__]


def free(body):
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)


def no_law():
    without(rcr.ContactDynamics)
    loop = O.engines[2]
    loop.geomDispatcher.functors = loop.lawDispatcher.functors = []
    loop.physDispatcher.functors = [w.Ip2_FrictMat_FrictMat_FrictPhys()]


def shape(**values):
    """Change attributes of the square's shape, which refuses them; the step refuses it again."""
    for name, value in values.items():
        try:
            setattr(O.bodies[1].shape, name, value)
        except ValueError:
            pass


SHAPES = [  # attributes, words of the error
    (dict(radius=-1), "radius = -1; expected a finite length ≥ 0"),
    (dict(radius=math.nan), "radius = -?nan; expected a finite length ≥ 0"),
    (dict(radius=math.inf), "radius = inf; expected a finite length ≥ 0"),
    (dict(vertices=[(0, 0)]), "radius = 0 with 1 vertices; expected a radius > 0 or three vert"),
    (dict(vertices=SQUARE[::-1].tolist()), "vertex 0 .* is not a convex corner; .* counter-clock"),
    (dict(vertices=(SQUARE + [1, 0]).tolist()), r"centroid at \(1, 0\); expected \(0, 0\), the ce"),
    (dict(vertices=[(math.nan, 0), *SQUARE[1:].tolist()]), r"vertex 0 .*nan.*finite coordinates"),
    (dict(vertices=[(math.inf, 0), *SQUARE[1:].tolist()]), r"vertex 0 .*inf.*finite coordinates"),
    (dict(vertices=[*SQUARE.tolist(), (0.1, 0)]), "vertex 4 .* not a convex corner.*on a side"),
]


@pytest.mark.parametrize("values, match", SHAPES)
def test_shapes_that_are_refused(values, match):
    resting()
    body = O.bodies[1]
    given = dict(vertices=SQUARE.tolist(), radius=0) | values
    refused(f"RoundedPolygon.*{match}.*{OWN}", rcr.RoundedPolygon, **given)
    steps(1)
    for name, value in values.items():
        refused(match, setattr, body.shape, name, value)
    # a script that goes on nevertheless
    assert_refused(f"body #1 is a RoundedPolygon.*{match}")


def test_a_shape_that_becomes_valid_again_goes_on():
    resting()
    steps(1)
    shape(radius=-1)
    assert_refused("body #1 is a RoundedPolygon.*radius = -1")
    O.bodies[1].shape.radius = 0
    steps(1)


FAULTS = {
    "no vertices": (
        lambda: O.bodies.append(w.Body(shape=rcr.RoundedPolygon(), material=O.materials[0])),
        "body #2 is a RoundedPolygon without vertices; make it by rcr.polygon"),
    "vertices removed": (
        lambda: shape(vertices=[]), "body #1 is a RoundedPolygon without vertices; make it by"),
    "tilted": (lambda: set_state(1, ori=Quaternion((1, 0, 0), 0.1)),
               "#1 is tilted out of the plane"),
    "z": (lambda: O.bodies.append(square((0, 1, 0.5))),
          "#2 lies at z = 0.5, other grains at z = 0"),
    "position": (lambda: set_state(1, pos=(math.nan, 0, 0)), "#1 has the position .nan"),
    "velocity": (lambda: set_state(1, angVel=(0, 0, math.inf)), "#1 has the angular velocity"),
    "degrees of freedom": (lambda: set_state(1, blockedDOFs=""), "#1 is free to leave the plane"),
    "mass": (lambda: set_state(1, mass=0), "#1 is free but has the mass 0"),
    "Bo1": (lambda: keep(O.engines[1].boundDispatcher),
            "has no Bo1_RoundedPolygon_Aabb, so body #1 would meet nothing; put Bo1_Rounded"),
    "Ig2": (lambda: keep(O.engines[2].geomDispatcher),
            "handles Wall and RoundedPolygon .* Add Ig2_Wall_RoundedPolygon_RcrGeom.. to"),
    "law": (no_law, "the InteractionLoop has no law for contacts of rcr; put Law2_RcrGeom_CdPhys"),
    "clump of YADE": (lambda: O.bodies.appendClumped([square((3, 1)), square((3.15, 1))]),
                      "free to leave the plane.* rcr.clump"),
    "free facet": (lambda: free(rcr.segment((1, 0.1), (1.2, 0.1), material=O.materials[0])),
                   "#2 is free but has the mass 0; give it a mass > 0"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults(fault):
    change, match = FAULTS[fault]
    resting()
    change()
    assert_refused(match)


def test_a_free_box_that_reaches_an_obstacle_says_how_to_make_a_grain():
    resting()
    free(utils.box((1, 0.1, 0), (0.1, 0.1, 0.5), material=O.materials[0]))
    refused("handles Wall and Box .bodies #0, #2., so they would pass through each other. "
            "Obstacles meet grains only.*rcr.polygon", steps, 3)


def test_a_stepper_that_would_set_a_second_is_refused():
    resting("smooth")
    insert(0, w.GlobalStiffnessTimeStepper())
    assert_refused("defaultDt = .* would set O.dt = 1 s while no grains touch")


@pytest.mark.parametrize("law", ["rigid", "smooth"])
@pytest.mark.parametrize("change, match", [
    (lambda: set_state(1, mass=1),
     "body #1, a RoundedPolygon, has the mass 1, and density × area is 40 kg .* rcr.polygon"),
    (lambda: O.bodies.append(square((0, 0.25))), "bodies #1 and #2 overlap by 0.05 m, 0.177 of R"),
    (lambda: set_state(1, pos=(0, 0.05, 0)), "bodies #0 and #1 overlap by 0.05 m"),
], ids=["mass", "overlap", "overlap of a wall"])
def test_warnings(law, change, match):
    resting(law)
    change()
    with warns(match):
        O.step()


@pytest.mark.parametrize("law", ["rigid", "smooth"])
def test_a_scene_of_polygons_gives_no_warning(law):
    resting(law)
    O.bodies.append([square((0, 0.3)), rcr.disc((0.5, 0.1), 0.1, O.materials[0])])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        steps(2)


@pytest.mark.parametrize("arrays", [True, False])
def test_a_shape_that_changes_during_a_run_acts_at_once(arrays):
    """A square on the floor becomes half as large: it falls by half of its height, and rests."""
    resting()
    O.engines[3].arrays = arrays
    O.run(20, True)
    O.bodies[1].shape.vertices = (0.5 * SQUARE).tolist()
    O.run(400, True)
    assert O.bodies[1].state.pos[1] == pytest.approx(0.05, abs=1e-5)
    assert O.bodies[1].state.vel.norm() < 1e-9
