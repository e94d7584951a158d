"""Scenes of polygons, S27 to S32: stacks, arches, walls, corners and thin plates."""

import math

import numpy as np
import rcr

from . import masonry
from .stage import (D, R, X, deepest, farthest, hard_scene, material, on_floor,
                    overlap_of_spinning, positions, stadium, state)

SPAN = 20 * R  # radius of the centre line of arches
STEEP = 100.0  # friction coefficient with which no joint slides


@hard_scene("stack of 20 squares", "largest displacement at the end, in diameters")
def s27_square_stack(make, clock, seconds=100.0):
    """S27. Squares with sharp corners, each shifted by a tenth of its side."""
    rough = material()
    squares = [rcr.polygon((X + 0.05 * R * (-1) ** k, R * (2 * k + 1)), masonry.rectangle(D, D),
                           material=rough) for k in range(20)]
    return farthest(on_floor(make, rough, *squares), clock, seconds) / D


def couplet(make, thickness):
    """A semicircular arch of 30 voussoirs on a floor; `thickness` is over the mean radius."""
    rough = material(STEEP)
    stones = masonry.arch(30, SPAN, thickness * SPAN)
    return on_floor(make, rough, *masonry.bodies(stones, material=rough))


@hard_scene("Couplet's arch of 0.112 of its radius", "largest displacement in 2 s, in diameters")
def s28_couplet_stands(make, clock):
    """S28. A semicircular arch that cannot slide stands from t = 0.1075 of its mean radius on
    (Milankovitch 1907). With 30 voussoirs the limit is 0.1074, by a linear program.
    """
    return farthest(couplet(make, 0.112), clock, 2.0) / D


@hard_scene("Couplet's arch of 0.103 of its radius",
            "height of the crown after 2 s, over the first", 0.5, "it falls to the ground")
def s28_couplet_falls(make, clock):
    """S28. Below the limit, five hinges make the arch a mechanism."""
    ids = couplet(make, 0.103)
    crown = ids[len(ids) // 2]
    height = positions([crown])[0, 1]
    clock.pass_(2.0)
    return positions([crown])[0, 1] / height


@hard_scene("house of bricks")
def s29_house(make, clock):
    """S29. Ten courses in running bond with a window, its lintel, and a gable of two slabs.

    The slabs lean on each other and on the wall; friction holds their thrust.
    """
    rough = material(0.7)
    return on_floor(make, rough, *masonry.bodies(masonry.house(R), material=rough))


@hard_scene("sharp corners on sharp corners", "deepest overlap in 2 s, over the inscribed radius",
            0.01, "geometric error of 1e-3 diameters, over the inscribed radius of a square")
def s30_corners(make, clock):
    """S30. Squares that stand on a corner fall on corners of fixed ones, exactly or beside them."""
    rough = material()
    offsets = 0, 1e-16, -1e-12, 1e-9, -1e-6, 1e-3, -0.1
    squares = []
    for k, offset in enumerate(offsets):
        for y, options in ((0, dict(fixed=True)), (2.5 * R, {})):
            x = 10 * R * k + (offset * R if y else 0)
            squares.append(rcr.regular_polygon((x, y), R, 4, material=rough, **options))
    ids = on_floor(make, material(), *squares)
    state(0).pos = (0, -3 * R, 0)  # the floor
    overlap = clock.largest(2.0, deepest)
    return overlap if positions(ids[1::2])[:, 1].min() > -3 * R else math.inf


@hard_scene("fast small polygons on a thin plate", "share of them behind the plate", 0,
            "none may pass")
def s31_thin_plate(make, clock):
    """S31. Spinning triangles cross ten thicknesses of a plate in a step."""
    rough, rng, thin = material(), np.random.default_rng(31), R / 100
    small, speed = R / 20, 1.0 / 1e-3 * R / 10
    plate = rcr.polygon((0, 0), masonry.rectangle(40 * R, thin), material=rough, fixed=True)
    triangles = [
        rcr.regular_polygon((R * (k - 15), rng.uniform(R, 3 * R)), small, 3,
                            angle=rng.uniform(0, 3), material=rough, velocity=(0, -speed),
                            angular_velocity=rng.uniform(-1, 1) * 1e3) for k in range(30)]
    ids = make(plate, *triangles, gravity=(0, 0, 0))[1:]
    clock.pass_(0.1)
    return (positions(ids)[:, 1] < 0).mean()


@hard_scene("fast spin of a triangle", "deepest overlap, over the smaller inscribed radius", 0.5,
            "at 1 the contact reaches a centre, beyond it the force reverses")
def s32_spinning_triangle(make, clock):
    """S32. A triangle turns by 0.1 rad a step between a disc and the walls of a narrow box."""
    rough = material()
    triangle = rcr.regular_polygon((0.1 * R, 0), R, 3, angle=0.3, material=rough)
    disc = stadium(0, 0.1 * R, (0, 0.9 * R), material=rough)
    return overlap_of_spinning(make, clock, rough, triangle, disc)
