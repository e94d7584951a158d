"""Pairs that YADE's collider has excluded meet after a change that allows them."""

import math

import numpy as np
import pytest
import yade.utils
import rcr
from yade import O
from yade.minieigenHP import Matrix3, Quaternion
from scenes import (build, calls, engines, exchange, insert, material, set_state, snapshot, solver,
                    springy, steps, weightless)

LOWER, UPPER = 1, 2  # discs of the radius 0.1 m; the upper one falls onto the lower one


def once(function, step):
    """A PyRunner that calls a function of this module at this step."""
    return calls(function, step, firstIterRun=step, nDo=1)


def stack(mask=2):
    """A floor and two discs, which do not meet; the boxes of all overlap."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough), rcr.disc((0, 0.1), 0.1, rough), tolerance=1e-4)
    O.bodies[0].mask = 3
    if mask:
        add_upper(mask)
    O.engines[1].verletDist = 0.4


def add_upper(mask):
    O.bodies.append(rcr.disc((0, 0.35), 0.1, material(0.5), mask=mask))


def refuse_a_step():
    solver().observe = [99]
    with pytest.raises(ValueError, match="observe"):
        O.step()
    solver().observe = []


def new_solver():
    exchange(rcr.ContactDynamics(tolerance=1e-4, arrays=solver().arrays))


def mask_before(then):
    stack()
    yield 2
    O.bodies[UPPER].mask = 1
    then()


def mask_of_a_new_body_after_a_refused_step():
    stack(mask=None)
    yield 2
    add_upper(mask=2)
    refuse_a_step()
    O.bodies[UPPER].mask = 1


def mask_of_the_collider():
    stack(mask=1)
    O.engines[1].avoidSelfInteractionMask = 1
    yield 50
    O.engines[1].avoidSelfInteractionMask = 0


def unbounded():
    stack(mask=1)
    O.bodies[UPPER].bounded = False
    yield 50
    O.bodies[UPPER].bounded = True


def clumps(**options):
    """Two discs of a clump on a floor, and another clump; dissolves the first."""
    rough = springy()
    build(rcr.wall("y", 0, 1, material=rough), **options)
    pair = [[rcr.disc((x, y), 0.1, rough) for y in (0.1, 0.3)] for x in (0, 2)]
    clump, _ = [rcr.clump(discs)[0] for discs in pair]
    yield 50
    O.bodies.erase(clump)


def erase():
    O.bodies.erase(3)


def new_collider():
    exchange(engines()[1])


def collider_after_an_erasure():
    """Within a run, in which no check of the scene precedes the new collider."""
    stack()
    O.bodies[LOWER].mask = O.bodies[UPPER].mask = 1
    O.engines[1].verletDist = 0.01
    O.bodies.append(rcr.disc((1, 0.1), 0.1, material(0.5)))
    set_state(UPPER, pos=(0, 0.6, 0))
    insert(5, once(erase, 20), once(new_collider, 60))
    yield 0


@pytest.mark.parametrize("scene", [
    lambda: mask_before(refuse_a_step), mask_of_a_new_body_after_a_refused_step,
    lambda: mask_before(new_solver), mask_of_the_collider, unbounded,
    lambda: clumps(tolerance=1e-4), collider_after_an_erasure,
], ids=["refused step", "new body", "new solver", "avoidSelfInteractionMask", "bounded", "clump",
        "new collider"])  # fmt: skip
def test_pairs_meet_after_a_change(scene):
    """In arrays and by YADE's engines alike."""
    ends = []
    for arrays in (True, False):
        change = scene()
        count = next(change)
        solver().arrays = arrays
        steps(count)
        next(change, None)
        O.run(600, True)
        heights = [O.bodies[disc].state.pos[1] for disc in (LOWER, UPPER)]
        assert heights == pytest.approx([0.1, 0.3], abs=1e-3)
        ends.append(snapshot())
    assert np.array_equal(*ends)


OVERLAP = 0.002  # of a disc and a changed obstacle [m]


def above(obstacle, **options):
    """A disc below an obstacle, which overlaps it after a change of shape or direction."""
    disc = rcr.disc((0.6, 0.6), 0.1, material(0.5))
    weightless(disc, obstacle, tolerance=1e-4, **options)
    return O.bodies[1]


def turned():
    segment = above(rcr.segment((0.4 - OVERLAP, 0.8), (1 - OVERLAP, 0.8)), cell=4.0)
    yield
    segment.state.ori = Quaternion((0, 0, 1), math.pi / 2)


def turned_in_a_sheared_cell():
    change = turned()
    next(change)
    O.cell.hSize = Matrix3(4, 1, 0, 0, 4, 0, 0, 0, 4)
    yield
    next(change, None)


def becomes_a_wall():
    wall = above(yade.utils.wall((0, 0.7 - OVERLAP, 5), 2, sense=-1))  # normal to the plane
    yield
    wall.shape.axis = 1


def longer_box():
    box = above(yade.utils.box((0.6, 1, 0), (0.1, 0.1, 0.1), fixed=True, material=material(0.5)))
    yield
    box.shape.extents = (0.1, 0.3 + OVERLAP, 0.1)


@pytest.mark.parametrize("speed", [0, 1e-4])
@pytest.mark.parametrize("scene", [turned, turned_in_a_sheared_cell, becomes_a_wall, longer_box])
def test_a_changed_obstacle_displaces_a_disc_that_it_overlaps(scene, speed):
    change = scene()
    next(change)
    O.bodies[0].state.vel = (-speed, 0, 0)
    steps(10)
    next(change, None)
    before = O.bodies[0].state.pos
    steps(2)
    assert O.interactions.has(0, 1, True)
    O.run(1000, True)
    assert (O.bodies[0].state.pos - before).norm() == pytest.approx(OVERLAP, abs=1.5e-4)


def test_springs_between_members_of_a_dissolved_clump():
    change = clumps(law="smooth", damping=0.3)
    O.dt = 1e-4
    steps(next(change))
    next(change, None)
    O.run(4000, True)
    heights = [O.bodies[disc].state.pos[1] for disc in (LOWER, UPPER)]
    assert heights == pytest.approx([0.1, 0.3], abs=5e-3)


def above_a_floor(make):
    """An obstacle that falls beside discs at rest."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough),
          *(rcr.disc((0.3 * k, 0.1), 0.1, rough) for k in range(8)), tolerance=1e-4)
    O.bodies.append(make(rough))
    set_state(9, mass=5)
    release()


def loose_box():
    above_a_floor(lambda rough: yade.utils.box((-2, 0.3, 0), (0.5, 0.05, 0.1), fixed=True,
                                               material=rough))


def loose_segment():
    above_a_floor(lambda rough: rcr.segment((-2.5, 0.3), (-1.5, 0.3), material=rough))


def release():
    set_state(9, blockedDOFs="xzXYZ")


def released_box():
    loose_box()
    set_state(9, blockedDOFs="xyzXYZ")
    insert(5, once(release, 50))


def discs_below_rods(act, mask=1, **options):
    """No functor handles these pairs; in a run, a change lets them meet."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough),
          *(rcr.disc((0.3 * k, 0.1), 0.1, rough, **options) for k in range(8)),
          *(rcr.particle((0.3 * k, 0.6), 0.1, 0.3, 0, rough, mask=mask, **options)
            for k in range(8)),
          tolerance=1e-4)
    O.bodies[0].mask = 3
    geometry = O.engines[2].geomDispatcher
    geometry.functors = [f for f in geometry.functors
                         if not isinstance(f, rcr.Ig2_Sphere_Rcr_RcrGeom)]
    insert(5, once(act, 50))


def unite():
    for body in O.bodies:
        body.mask = 3


@pytest.mark.parametrize("arrays", [True, False])
@pytest.mark.parametrize("scene, shapes, last, lowest", [
    (loose_box, "Wall and Box", 223, 0.05), (released_box, "Wall and Box", 274, 0.05),
    (loose_segment, "Wall and Facet", 247, 0.0),
    (lambda: discs_below_rods(unite, mask=2), "Sphere and Rcr", 51, 0.5),
    (lambda: discs_below_rods(release, fixed=True), "Sphere and Rcr", 400, 0.2),
], ids=["loose Box", "released Box", "loose segment", "mask", "released rod"])
def test_pairs_without_ig2_are_refused_before_they_overlap(scene, shapes, last, lowest, arrays):
    """At the latest in this step, and above this height [m]."""
    scene()
    solver().arrays = arrays
    with pytest.raises(RuntimeError, match=f"no Ig2 functor .* handles {shapes} .* pass through"):
        O.run(400, True)
    assert O.iter <= last and O.bodies[9].state.pos[1] > lowest
