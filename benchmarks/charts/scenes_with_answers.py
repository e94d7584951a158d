"""Rows, columns, slots, carts and bricks of N bodies, whose momentum or force is known.

Each function builds a scene of touching bodies under a law of `hard_scenes.stage`. It returns a
function that gives the relative error after one step [-]. Restitution is 0.
"""

import rcr
from yade.wrapper import Omega

from benchmarks.hard_scenes.stage import DENSITY, DT, G, R, build, flat, material, stadium

O = Omega()
SPEED = 0.1  # of the wall that strikes a row [m/s]
COAST = 1.0  # of a cart [m/s]
CART = 1e4  # mass of a cart over that of a rod [-]
CLEARANCE = 0.005  # between bricks and a wall [R]


def row(law, count):
    """A wall strikes a row of discs on a smooth floor. All discs then move with the wall."""
    smooth = material(friction=0)
    discs = [stadium(0, R, (R + 2 * R * k, R), material=smooth) for k in range(count)]
    _, _, *ids = build(law, DT, rcr.wall("x", 0, +1, velocity=SPEED, material=smooth),
                       rcr.wall("y", 0, +1, material=smooth), *discs)
    return lambda: abs(sum(O.bodies[i].state.vel[0] for i in ids) / (count * SPEED) - 1)


def _tower(law, bodies, rough, *obstacles):
    """Bodies on a floor, which bears their weight."""
    floor, *_ = build(law, DT, rcr.wall("y", 0, +1, material=rough), *obstacles, *bodies)
    weight = G * sum(body.state.mass for body in bodies)
    return lambda: abs(O.forces.f(floor)[1] / weight + 1)


def _discs(count, rough):
    return [stadium(0, R, (R, R + 2 * R * k), material=rough) for k in range(count)]


def column(law, count):
    """Discs stand one upon another. The floor bears their weight."""
    rough = material()
    return _tower(law, _discs(count, rough), rough)


def slot(law, count):
    """The column between two smooth walls, which touch it."""
    smooth = material(friction=0)
    return _tower(law, _discs(count, smooth), smooth, rcr.wall("x", 0, +1, material=smooth),
                  rcr.wall("x", 2 * R, -1, material=smooth))


def cart(law, count):
    """Rods lie on a heavy cart that coasts on a smooth floor. The cart bears their weight."""
    rough, smooth, half = material(), material(friction=0), 9 * R
    rods = [flat((0, 2 * R + R * (k + 0.5)), rough) for k in range(count)]
    light = stadium(half, R, (0, R), material=rough)
    density = CART * DENSITY * rods[0].state.mass / light.state.mass
    load = stadium(half, R, (0, R), material=material(density=density))
    _, first, *ids = build(law, DT, rcr.wall("y", 0, +1, material=smooth), load, *rods)
    for i in (first, *ids):
        O.bodies[i].state.vel = (COAST, 0, 0)
    weight = G * sum(rod.state.mass for rod in rods)
    force = lambda: O.interactions[first, ids[0]].phys.normalForce[1]
    return lambda: abs(abs(force()) / weight - 1)


def bricks(law, count):
    """A stack of flat rods beside a wall, which it does not touch. The floor bears its weight."""
    rough = material()
    return _tower(law, [flat((0, R * (k + 0.5)), rough) for k in range(count)], rough,
                  rcr.wall("x", -(1 + CLEARANCE) * R, +1, material=rough))


SCENES = {function.__name__: function for function in (row, column, slot, cart, bricks)}
