"""Structures of polygons with known forces: arches, wedges, corners. Per unit depth."""

import math

import numpy as np
import pytest
import rcr
from benchmarks.hard_scenes import masonry
from scenes import G, build, kinetic, material, solver, steps, velocity, weightless
from scipy.optimize import linprog
from yade import O

ROUGH = 100.0  # friction coefficient with which no joint slides
SOLVED = dict(tolerance=1e-10, accuracy=1e-6)
R = 1.0  # radius of the centre lines [m]
slightly = pytest.mark.parametrize("factor", [0.99, 1.01], ids=["below", "above"])


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


# ---- arches

def hinged(stone, joint):
    """The voussoir with a joint that touches at its middle only: its corners turn back."""
    first, turn = {"right": (0, 0.01), "left": (2, -0.01)}[joint]
    ends = stone[first:first + 2]
    c, s = math.cos(turn), math.sin(turn)
    back = ends @ np.array([[c, s], [-s, c]])
    return np.array([*stone[:first], back[0], ends.mean(axis=0), back[1], *stone[first + 2:]])


def test_thrust_of_an_arch_with_three_hinges():
    """Moments of each half about its lower hinge give the force at the crown."""
    half, t, beta = 7, 0.2, math.pi / 3
    stones = list(masonry.arch(2 * half + 2, R, t, beta * (half + 1) / half))
    for k, joint in ((1, "right"), (half, "left"), (-2, "left")):
        stones[k] = hinged(stones[k], joint)
    m = material(ROUGH)
    bodies = masonry.bodies(stones, material=m)
    for abutment in bodies[0], bodies[-1]:
        abutment.state.blockedDOFs = "xyzXYZ"
    crown, right, left = [np.array([s * R, c * R]) for s, c in (
        (0, 1), (math.sin(beta), math.cos(beta)), (-math.sin(beta), math.cos(beta)))]
    load = lambda b: (np.array(b.state.pos)[:2], np.array([0, -G * b.state.mass]))
    moments = [sum(cross(at - hinge, weight) for at, weight in map(load, some))
               for hinge, some in ((right, bodies[1:half + 1]), (left, bodies[half + 1:-1]))]
    arms = [crown - right, -(crown - left)]  # of the force at the crown on the right half
    matrix = np.array([[-arm[1], arm[0]] for arm in arms])
    force = np.linalg.solve(matrix, -np.array(moments))
    assert force[0] > 0  # the left half pushes to the right
    ids = build(*bodies, **SOLVED)
    steps(5)
    assert max(abs(velocity(k)).max() for k in ids) < 1e-9
    for end, some, sign in ((ids[0], bodies[1:half + 1], 1), (ids[-1], bodies[half + 1:-1], -1)):
        expected = sign * force + sum(load(b)[1] for b in some)
        assert np.array(O.forces.f(end))[:2] == pytest.approx(expected, rel=1e-7)


def thrusts(stones, weights):
    """Least and largest thrust of an arch whose joints cannot slide; None if it falls.

    By a linear program. Unknowns are forces (normal, tangential) at both ends of each joint.
    """
    count = len(stones)
    joints = [*stones[:, :2], stones[-1][[3, 2]]]  # (inner, outer)
    a, b = np.zeros((3 * count, 4 * (count + 1))), np.zeros(3 * count)
    centers = [masonry.area_and_centroid(stone)[1] for stone in stones]
    for k, ends in enumerate(joints):
        radial = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        normal = np.array([-radial[1], radial[0]])  # to the stone on the left
        for e, end in enumerate(ends):
            for stone, sign in ((k, 1), (k - 1, -1)):
                for i, d in enumerate((normal, radial)) if 0 <= stone < count else ():
                    column = 4 * k + 2 * e + i
                    a[3 * stone:3 * stone + 2, column] = sign * d
                    a[3 * stone + 2, column] = sign * cross(end - centers[stone], d)
    b[1::3] = weights
    thrust = np.zeros(a.shape[1])
    thrust[[1, 3]] = -1  # the floor pushes the right foot towards −x
    found = [linprog(sign * thrust, A_eq=a, b_eq=b, bounds=[(0, None), (None, None)]
                     * (2 * count + 2)) for sign in (1, -1)]
    return None if found[0].status else [abs(f.fun) for f in found]


def semicircle(thickness, count=30):
    """A semicircular arch on two floors; returns their ids and those of the stones."""
    m = material(ROUGH)
    stones = masonry.arch(count, R, thickness * R)
    floors = [rcr.polygon((side * R, -0.1), masonry.rectangle(0.5, 0.2), material=m, fixed=True)
              for side in (1, -1)]
    ids = build(*floors, *masonry.bodies(stones, material=m), **SOLVED)
    return stones, ids[:2], ids[2:]


def test_thrust_of_an_arch_just_above_its_least_thickness():
    """There the line of thrust has no choice left."""
    stones, floors, ids = semicircle(0.1076)
    least, most = thrusts(stones, [G * O.bodies[k].state.mass for k in ids])
    assert most / least < 1.01
    steps(20)
    pushes = [abs(O.forces.f(k)[0]) for k in floors]
    assert min(pushes) > 0.995 * least and max(pushes) < 1.005 * most
    assert pushes[0] == pytest.approx(pushes[1], rel=1e-6)


@pytest.mark.parametrize("thickness, falls", [(0.112, False), (0.103, True)])
def test_couplet_arch(thickness, falls):
    """It stands if some line of thrust lies within it; 0.1075 for many voussoirs (Milankovitch)."""
    stones, _, ids = semicircle(thickness)
    weights = [G * O.bodies[k].state.mass for k in ids]
    assert (thrusts(stones, weights) is None) == falls
    steps(500)
    crown = O.bodies[ids[15]].state
    assert -crown.displ()[1] > 0.01 * R if falls else crown.displ().norm() < 1e-6 * R


# ---- wedges and corners

def wedge(alpha, friction, load, push):
    """A wedge of the half angle α between two blocks without friction on floor and wall.

    The load [N/m] presses the wedge down, the push [N/m] the right block towards the wedge. Returns
    ids of the wall and the wedge.
    """
    slope = math.tan(alpha)
    smooth, rough = material(0), material(friction)
    face = lambda y: (slope * (2 + y), y)
    low, high = face(-0.5), face(0.5)
    stone = np.array([low, high, (-high[0], high[1]), (-low[0], low[1])])
    block = np.array([face(-1), (1.5, -1), (1.5, 1), face(1)])
    bodies = masonry.bodies([stone, block, block * [-1, 1]], material=rough)
    wall, floor, k, right, _ = weightless(
        rcr.wall("x", -1.5, 1, material=smooth), rcr.wall("y", -1, 1, material=smooth), *bodies,
        **SOLVED)
    O.forces.setPermF(k, (0, -load, 0))
    O.forces.setPermF(right, (-push, 0, 0))
    return wall, k


@pytest.mark.parametrize("alpha", [0.2, 0.4])
@slightly
@pytest.mark.parametrize("way", ["in", "out"])
def test_wedge_between_two_blocks(alpha, factor, way):
    """It sinks for H < F/(2 tan(α + φ)), and leaves for H > F/(2 tan(α − φ))."""
    phi, load = 0.5 * alpha, 1000.0
    limit = load / (2 * math.tan(alpha + phi if way == "in" else alpha - phi))
    wall, k = wedge(alpha, math.tan(phi), load, factor * limit)
    steps(5)
    speed = velocity(k)[1] * (-1 if way == "in" else 1)
    assert speed > 1e-6 if (factor < 1) == (way == "in") else abs(speed) < 1e-11
    if not speed > 1e-6:
        assert -O.forces.f(wall)[0] == pytest.approx(factor * limit, rel=1e-9)


def test_wedge_without_friction():
    """H = F/(2 tan α): any other force moves it."""
    alpha, load = 0.3, 1000.0
    for factor, direction in ((0.999, -1), (1, 0), (1.001, 1)):
        wall, k = wedge(alpha, 0, load, factor * load / (2 * math.tan(alpha)))
        steps(5)
        v = velocity(k)[1]
        assert abs(v) < 1e-11 if direction == 0 else v * direction > 1e-7


@pytest.mark.parametrize("offset", [0, 1e-300, 1e-17, -1e-12, 1e-9])
@pytest.mark.parametrize("radius", [0, 0.01])
def test_corners_meet_head_on(offset, radius):
    """Two squares of masses m and 3 m, e = 0: rounded ones go on with v/4. Sharp corners that
    coincide have the normal of one of their sides; momentum and energy still hold.
    """
    one, two = material(0), material(0, density=3000)
    square = lambda x, y, m, **options: rcr.regular_polygon((x, y), 0.1, 4, radius, material=m,
                                                            **options)
    ids = weightless(square(-0.15, offset, one, velocity=(1, 0)), square(0.1, 0, two))
    steps(200)
    v, masses = np.array([velocity(k) for k in ids]), [O.bodies[k].state.mass for k in ids]
    assert masses @ v[:, :2] == pytest.approx([masses[0], 0], abs=1e-9)
    assert kinetic() <= 0.5 * masses[0] * (1 + 1e-9)
    assert solver().deepestOverlap < 1e-3  # they turn by 0.005 rad a step
    if radius:
        assert v == pytest.approx(np.array([[0.25, 0, 0]] * 2), abs=1e-6)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("offset", [0, 1e-12, 1e-6, 1e-3])
def test_corners_balance_or_slide_past_each_other_without_gain(offset, order):
    """A square that stands on a corner falls on the corner of a fixed one."""
    m = material(0.2)
    bodies = [rcr.regular_polygon((0, 0), 0.1, 4, material=m, fixed=True),
              rcr.regular_polygon((offset, 0.21), 0.1, 4, material=m)]
    ids = build(*bodies[::order], tolerance=1e-8)
    top = O.bodies[ids[::order][1]].state
    for _ in range(600):
        O.step()
        energy = 0.5 * (top.mass * top.vel.squaredNorm() + top.inertia[2] * top.angVel[2] ** 2)
        assert energy <= 1.01 * top.mass * G * (0.2105 - top.pos[1])
        assert top.pos.norm() > 0.141 * 0.999  # of flush sides
