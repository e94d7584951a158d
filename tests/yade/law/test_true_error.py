"""Scenes with known forces and velocities whose errors vary slowly from contact to contact.

A solver that stops on the residual alone calls such errors converged. Every test takes the default
settings of ContactDynamics, and every step must be right to 1 %.
"""

import math

import pytest
import rcr
from scenes import G, build, material, set_state, solver, walls, warns
from yade import O
from yade import wrapper as w
from yade.minieigenHP import Vector3

R = 0.01
DEFAULT = dict(solver="auto")
ACCURACY = 0.01  # ContactDynamics.accuracy


def row(count, friction=0.0):
    """Touching discs on y = 0, from x = 0."""
    m = material(friction)
    return [rcr.disc((R + 2 * R * k, R), R, material=m) for k in range(count)]


def flat_rods(count, height=0.0, x=0.0, **options):
    """A stack of lying rods, η = 0.5, µ = 0.5."""
    m = material(0.5)
    return [rcr.particle((x, height + R * (k + 0.5)), R, 0.5, material=m, **options)
            for k in range(count)]


def each_step(count, check):
    for _ in range(count):
        O.step()
        check()
    assert solver().missedSteps == 0 and solver().errorEstimate <= ACCURACY


@pytest.mark.parametrize("gravity", [0.0, G])
@pytest.mark.parametrize("count", [20, 100, 1000])
def test_a_struck_row_gets_the_speed_of_the_wall(count, gravity):
    """e = 0, µ = 0: all discs move at v, with the momentum N m v."""
    v, smooth = 0.1, material(0.0)
    _, _, *discs = build(rcr.wall("x", 0, sense=1, velocity=v, material=smooth),
                         rcr.wall("y", 0, sense=1, material=smooth), *row(count),
                         gravity=(0, -gravity, 0), **DEFAULT)

    def check():
        speeds = [O.bodies[k].state.vel[0] / v for k in discs]
        assert sum(speeds) / count == pytest.approx(1, abs=ACCURACY)
        assert min(speeds) > 1 - ACCURACY and max(speeds) < 1 + ACCURACY

    each_step(20 if count < 1000 else 3, check)


@pytest.mark.parametrize("count", [150, 300, 1000])
def test_a_pressed_row_hands_on_its_load(count):
    smooth = material(0.0)
    left, _, lid, *_ = build(*walls(smooth, x=[0]), *walls(smooth, y=[0]),
                             rcr.mobile_wall("x", 2 * R * count, mass=1, sense=-1, material=smooth),
                             *row(count), **DEFAULT)
    load = 10.0
    O.forces.setPermF(lid, (-load, 0, 0))
    each_step(30 if count < 1000 else 5,
              lambda: pytest.approx(load, rel=ACCURACY) == -O.forces.f(left)[0] or pytest.fail(
                  f"step {O.iter}: the wall bears {-O.forces.f(left)[0]} of {load} N/m"))


def cart_with_rods(speed, mass_ratio, idle=()):
    """20 rods on a cart that coasts on a smooth floor; the cart, the rods, their weight."""
    smooth, rough, count = material(0.0), material(0.5), 20
    cart = rcr.particle((0, R), 10 * R, 0.9, material=rough, velocity=(speed, 0))
    rods = flat_rods(count, 2 * R, velocity=(speed, 0))
    factor = mass_ratio * rods[0].state.mass / cart.state.mass
    cart.state.mass *= factor
    cart.state.inertia *= factor
    with warns("has the mass"):
        ids = build(rcr.wall("y", 0, sense=1, material=smooth), cart, *rods, *idle, **DEFAULT)
        O.step()
    return ids[1], ids[2:2 + count], count * rods[0].state.mass * G


def force_between(one, other):
    return abs(O.interactions[one, other].phys.normalForce[1])


@pytest.mark.parametrize("speed", [0.0, 1.0, 10.0])
@pytest.mark.parametrize("mass_ratio", [1e3, 1e4, 1e6])
def test_rods_rest_on_a_coasting_cart(speed, mass_ratio):
    """Galilei: the speed does not matter, and neither does the mass of the cart."""
    cart, rods, weight = cart_with_rods(speed, mass_ratio)
    each_step(100, lambda: pytest.approx(weight, rel=ACCURACY) == force_between(cart, rods[0])
              or pytest.fail(f"step {O.iter}: {force_between(cart, rods[0])} of {weight} N/m"))
    sunk = 2 * R + 19.5 * R - O.bodies[rods[-1]].state.pos[1]
    assert sunk < 1e-3 * R * O.time


@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside a wall"])
@pytest.mark.parametrize("count", [500, 1000])
def test_a_stack_of_rods_stands(count, beside):
    """The wall is 0.5 % R away and never touched."""
    rough = material(0.5)
    floor, *rest = build(*walls(rough, y=[0]), *walls(rough, x=[-1.005 * R] if beside else []),
                         *flat_rods(count), **DEFAULT)
    weight = count * O.bodies[rest[-1]].state.mass * G
    each_step(40 if count < 1000 else 5,
              lambda: pytest.approx(weight, rel=ACCURACY) == -O.forces.f(floor)[1]
              or pytest.fail(f"step {O.iter}: {-O.forces.f(floor)[1]} of {weight} N/m"))
    assert R * (count - 0.5) - O.bodies[rest[-1]].state.pos[1] < 1e-3 * R * O.time


@pytest.mark.parametrize("count", [160, 300, 1000])
def test_a_column_in_a_slot_stands(count):
    smooth = material(0.0)
    floor, *rest = build(*walls(smooth, y=[0]), *walls(smooth, x=[0, 2 * R]),
                         *(rcr.disc((R, R + 2 * R * k), R, material=smooth) for k in range(count)),
                         **DEFAULT)
    weight = count * O.bodies[rest[-1]].state.mass * G
    each_step(30 if count < 1000 else 5, lambda: pytest.approx(weight, rel=ACCURACY)
              == -O.forces.f(floor)[1] or pytest.fail(f"{-O.forces.f(floor)[1]} of {weight} N/m"))
    assert (2 * count - 1) * R - O.bodies[rest[-1]].state.pos[1] < 1e-3 * R * O.time


@pytest.mark.parametrize("count", [400, 1000])
def test_a_row_in_a_cell_bears_its_stress(count):
    """`CellStress(100, NaN)`: the stretching cell is part of the exact iterations."""
    O.reset()
    O.periodic, O.dt = True, 1e-3
    O.cell.setBox(2 * R * count, 5 * R, 0.2)
    smooth = material(0.0)
    O.bodies.append([rcr.disc((2 * R * (k + 0.5), R), R, material=smooth) for k in range(count)])
    engine = rcr.ContactDynamics()
    O.engines = [
        w.ForceResetter(), w.InsertionSortCollider([w.Bo1_Sphere_Aabb()], verletDist=1e-3),
        w.InteractionLoop([rcr.Ig2_Sphere_Sphere_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                          [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        rcr.CellStress(stress=(100, math.nan)), engine, w.NewtonIntegrator(damping=0)]
    for _ in range(10):
        O.step()
        found = rcr.contact_network().stress()[0, 0]
        assert found == pytest.approx(100, rel=ACCURACY), O.iter
    assert engine.missedSteps == engine.yieldedSteps == 0


def test_a_struck_row_has_a_solution_for_plain_sweeps():
    """They are too slow for a row, and say only that they have not converged."""
    smooth = material(0.0)
    build(rcr.wall("x", 0, sense=1, velocity=0.1, material=smooth),
          rcr.wall("y", 0, sense=1, material=smooth), *row(100), solver="nlgs")
    O.run(20, True)
    assert solver().missedSteps > 0 and solver().yieldedSteps == 0


@pytest.mark.parametrize("ratio", [1.5, 2, 3, 5])
def test_a_lever_lifts_without_yielding(ratio):
    """A driven disc turns a hinged bar at v. A disc of 64 bar masses on its long arm rises at
    `ratio` v: no bound of impulses may call that infeasible.
    """
    smooth, v, arm, r, big = material(0.0), 0.01, 0.09, 0.005, 0.02
    bar = rcr.particle((0, 0), 0.1, 0.95, material=smooth)
    bar.state.blockedDOFs = "xyzXY"
    drive = rcr.disc((-arm / ratio, -r - bar.shape.capRadius), r, material=smooth, fixed=True)
    drive.state.vel = Vector3(0, v, 0)
    load = rcr.disc((-arm, bar.shape.capRadius + big), big, material=smooth)
    load.state.mass, load.state.inertia = 100 * load.state.mass, 100 * load.state.inertia
    build(bar, drive, load, dt=1e-4, gravity=(0, 0, 0), **DEFAULT)
    with warns("has the mass"):
        O.step()
    assert O.bodies[2].state.vel[1] == pytest.approx(ratio * v, rel=ACCURACY)
    assert solver().missedSteps == 0


# ---- what must change no force by more than 1 %


@pytest.mark.parametrize("change", ["boost", "idle wall", "fast slider", "heavy body"])
def test_neighbours_and_frames_do_not_matter(change):
    """A row of 60 rods between a wall and a lid: the force on the wall is the load."""
    count, load, speed = 60, 10.0, 10.0 if change == "boost" else 0.0
    rough, smooth = material(0.5), material(0.0)
    rods = [rcr.particle((R * (k + 0.5), 0), R, 0.5, angle=math.pi / 2, material=rough,
                         velocity=(speed, 0)) for k in range(count)]
    wall = rcr.wall("x", 0, sense=1, material=rough)
    wall.state.vel = Vector3(speed, 0, 0)
    lid = rcr.mobile_wall("x", R * count, mass=1, sense=-1, material=rough)
    lid.state.vel = Vector3(speed, 0, 0)
    others = {
        "boost": [],
        "idle wall": [rcr.wall("y", -1.005 * R, sense=1, material=rough)],
        # slides along the sides of a rod that stands on the row, without friction
        "fast slider": [rcr.disc((R * count / 2, 2 * R), R, material=smooth)],
        "heavy body": [rcr.disc((R * count / 2, 1e3 * R), R, material=smooth)],
    }[change]
    ids = build(wall, lid, *rods, *others, gravity=(0, 0, 0), **DEFAULT)
    O.forces.setPermF(ids[1], (-load, 0, 0))
    if change == "fast slider":
        set_state(ids[-1], vel=Vector3(1, 0, 0))
    if change == "heavy body":  # the lid itself has a million masses of a rod
        set_state(ids[1], mass=1e6 * O.bodies[ids[2]].state.mass)

    def check():
        force = -O.forces.f(ids[0])[0]
        # a lid of that mass is pressed as the others: nothing moves
        assert force == pytest.approx(load, rel=ACCURACY), (O.iter, force)

    each_step(20, check)
