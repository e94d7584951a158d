"""Pairs that YADE's collider has excluded meet after a change that allows them."""

import numpy as np
import pytest
import yade.utils
import rcr
from yade import O
from yade import wrapper as w
from scenes import build, engines, insert, material, set_state, snapshot, solver, springy, steps

LOWER, UPPER = 1, 2  # discs of the radius 0.1 m; the upper one falls onto the lower one


def stack(mask=2):
    """A floor and two discs, which do not meet; the boxes of all overlap."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough), rcr.disc((0, 0.1), 0.1, rough),
          rcr.disc((0, 0.35), 0.1, rough, mask=mask), tolerance=1e-4)
    O.bodies[0].mask = 3
    O.engines[1].verletDist = 0.4


def mask_before_a_refused_step():
    stack()
    yield 2
    O.bodies[UPPER].mask = 1
    solver().observe = [99]
    with pytest.raises(ValueError, match="observe"):
        O.step()
    solver().observe = []


def mask_before_a_new_solver():
    stack()
    yield 2
    O.bodies[UPPER].mask = 1
    O.engines = [rcr.ContactDynamics(tolerance=1e-4, arrays=e.arrays)
                 if isinstance(e, rcr.ContactDynamics) else e for e in O.engines]


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


def exchange():
    new = engines()[1]
    O.engines = [new if isinstance(e, w.InsertionSortCollider) else e for e in O.engines]


def collider_after_an_erasure():
    """Within a run, in which no check of the scene precedes the new collider."""
    stack()
    O.bodies[LOWER].mask = O.bodies[UPPER].mask = 1
    O.engines[1].verletDist = 0.01
    O.bodies.append(rcr.disc((1, 0.1), 0.1, material(0.5)))
    set_state(UPPER, pos=(0, 0.6, 0))
    command = "import {} as test; test.{}()".format
    insert(5, *(w.PyRunner(command=command(__name__, act), iterPeriod=at, firstIterRun=at, nDo=1)
                for act, at in (("erase", 20), ("exchange", 60))))
    yield 0


@pytest.mark.parametrize("scene", [
    mask_before_a_refused_step, mask_before_a_new_solver, mask_of_the_collider, unbounded,
    lambda: clumps(tolerance=1e-4), collider_after_an_erasure,
], ids=["refused step", "new solver", "avoidSelfInteractionMask", "bounded", "clump",
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


def test_springs_between_members_of_a_dissolved_clump():
    change = clumps(law="smooth", damping=0.3)
    O.dt = 1e-4
    steps(next(change))
    next(change, None)
    O.run(4000, True)
    heights = [O.bodies[disc].state.pos[1] for disc in (LOWER, UPPER)]
    assert heights == pytest.approx([0.1, 0.3], abs=5e-3)


def loose_box():
    """A free Box above the floor."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough),
          *(rcr.disc((0.3 * k, 0.1), 0.1, rough) for k in range(8)), tolerance=1e-4)
    O.bodies.append(yade.utils.box((-2, 0.3, 0), (0.5, 0.05, 0.1), fixed=True, material=rough))
    set_state(9, mass=5)
    release()


def release():
    set_state(9, blockedDOFs="xzXYZ")


def released_box():
    loose_box()
    set_state(9, blockedDOFs="xyzXYZ")
    command = f"import {__name__} as test; test.release()"
    insert(5, w.PyRunner(command=command, iterPeriod=50, firstIterRun=50, nDo=1))


def discs_below_rods():
    """Without Ig2_Sphere_Rcr_RcrGeom; a run gives both one mask."""
    rough = material(0.5)
    build(rcr.wall("y", 0, 1, material=rough),
          *(rcr.disc((0.3 * k, 0.1), 0.1, rough) for k in range(8)),
          *(rcr.particle((0.3 * k, 0.6), 0.1, 0.3, 0, rough, mask=2) for k in range(8)),
          tolerance=1e-4)
    O.bodies[0].mask = 3
    geometry = O.engines[2].geomDispatcher
    geometry.functors = [f for f in geometry.functors
                         if not isinstance(f, rcr.Ig2_Sphere_Rcr_RcrGeom)]
    command = f"import {__name__} as test; test.unite()"
    insert(5, w.PyRunner(command=command, iterPeriod=50, firstIterRun=50, nDo=1))


def unite():
    for body in O.bodies:
        body.mask = 3


@pytest.mark.parametrize("arrays", [True, False])
@pytest.mark.parametrize("scene, shapes", [
    (loose_box, "Wall and Box"), (released_box, "Wall and Box"), (discs_below_rods, "Sphere and Rcr"),
])  # fmt: skip
def test_pairs_without_ig2_are_refused_before_they_overlap(scene, shapes, arrays):
    scene()
    solver().arrays = arrays
    with pytest.raises(ValueError, match=f"no Ig2 functor .* handles {shapes} .* pass through"):
        O.run(400, True)
    heights = [b.state.pos[1] for b in O.bodies]
    assert heights[9] > (0.05 if "Wall" in shapes else 0.2)
