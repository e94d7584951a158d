"""Scenes at rest, S3 to S5, S15, S18 and S19: nothing may move."""

import math

import rcr
from yade import O

from .stage import (D, DENSITY, G, R, X, dense_row, farthest, flat, flat_row, hard_scene, material,
                    on_floor, open_box, positions, push, rows, stadium, tilted)


def stack(count, rough):
    return [flat((X, flat_row(k)), rough) for k in range(count)]


def pyramid(height):
    """Centres of a pyramid of twenty rows; `height` is that of a row."""
    return [(R * row + D * k, height(row)) for row in range(20) for k in range(20 - row)]


@hard_scene("cold dense box under a heavy lid", "displacement of the lid in 1 s, in diameters")
def s03_cold_box(make, clock):
    """S3. The first step must find all forces of 95 RCRs; an error lets the lid sink."""
    rough, count = material(), 10  # bricks of 2R by R, each on the ends of two
    bricks = [flat(center, rough) for center in rows(count, count, flat_row)]
    mass = sum(b.state.mass for b in bricks)
    lid = rcr.mobile_wall("y", R * count, mass, sense=-1, material=rough)
    lid = make(*open_box(count * D, rough), lid, *bricks)[3:4]
    start = positions(lid)
    clock.pass_(1.0)
    return abs(positions(lid) - start).max() / D


def columns():
    return [flat((3 * R * k, flat_row(storey)), material(density=DENSITY * 10 ** (k * storey)))
            for k in range(7) for storey in range(2)]


def tower(x):
    return [flat((x, flat_row(k)), material(density=DENSITY * 10**k)) for k in range(7)]


@hard_scene("heavy on light, mass ratios 1 to 10⁶")
def s04_mass_ratio(make, clock):
    """S4. Columns of two RCRs. Gauss–Seidel needs about as many sweeps as the mass ratio."""
    return on_floor(make, material(), *columns())


@hard_scene("tower of seven, each ten times as heavy as the one below")
def s04_tower(make, clock):
    """S4. The lowest carries 10⁶ times its weight; errors beside large forces move light bodies."""
    return on_floor(make, material(), *tower(X))


@hard_scene("all mass ratios in one scene")
def s04_together(make, clock):
    """S4. One stop criterion serves all: heavy neighbours hide errors in the tower."""
    return on_floor(make, material(), *columns(), *tower(-1.0))


@hard_scene("stack whose upper half is removed",
            "largest displacement of the rest in 1 s, in diameters")
def s05_top_removed(make, clock):
    """S5. The warm start has twice the correct forces; a solver that keeps them throws the rest."""
    rough = material()
    ids = on_floor(make, rough, *stack(10, rough))
    clock.pass_(0.5)
    for i in ids[5:]:
        O.bodies.erase(i)
    clock.restart()
    return farthest(ids[:5], clock, 1.0) / D


@hard_scene("body on more contacts than it needs")
def s15_many_supports(make, clock):
    """S15. A long RCR on seven discs. Forces are not unique, but their sum is its weight."""
    rough = material()
    pegs = [stadium(0, R / 10, (0.25 * R * k, -R / 10), material=rough, fixed=True)
            for k in range(-3, 4)]
    return make(*pegs, stadium(0.9 * R, 0.1 * R, (0, 0.1 * R), material=rough))[-1:]


@hard_scene("slope below the friction angle", "displacement at the end, in diameters")
def s18_creep(make, clock, seconds=1000.0):
    """S18. It creeps if friction slips in every step or a correction moves it along the slope."""
    rough = material(0.5)
    ids = on_floor(make, rough, flat((0, R / 2), rough), gravity=tilted(math.atan(0.95 * 0.5)))
    return farthest(ids, clock, seconds) / D


@hard_scene("flat arch of nine")
def s19_arch(make, clock):
    """S19. A flat arch: nine upright RCRs between a wall and a press hang by friction alone.

        2 µ N ≥ W        friction at the two ends carries the weight
        W L/8 ≤ N a      the line of thrust stays in the row of length L and height 2a

    The press gives 1.3 times the larger N. Mass ratios and cold starts let the row sag.
    """
    rough, count, mu = material(0.5), 9, 0.5
    a, r = 0.8 * R, 0.2 * R
    stones = [stadium(a, r, (r * (1 + 2 * k), 0), math.pi / 2, material=rough)
              for k in range(count)]
    weight = G * sum(s.state.mass for s in stones)
    press = rcr.mobile_wall("x", 2 * r * count, stones[0].state.mass, sense=-1, material=rough)
    ids = make(rcr.wall("x", 0, material=rough), press, *stones)
    push(ids[1], (-1.3 * max(weight / (2 * mu), weight * 2 * r * count / 8 / a), 0))
    return ids[2:]


@hard_scene("house of cards")
def s19_card_house(make, clock):
    """S19. Two tents, a card across their tops, and a tent on it: η = 0.95, µ = 1."""
    rough, a, cap, lean = material(1.0), 0.95 * R, 0.05 * R, math.radians(70)
    reach, height = a * math.cos(lean) + cap, a * math.sin(lean)

    def tent(x, floor):
        """Two cards that lean on each other; their caps touch at the top, 2 r apart."""
        return [stadium(a, cap, (x - side * reach, floor + cap + height), side * lean,
                        material=rough) for side in (1, -1)]

    width, top = 2 * reach, 2 * (height + cap)
    roof = stadium(1.2 * width, cap, (0, top + cap), material=rough)
    return on_floor(make, rough, *tent(-width, 0), *tent(width, 0), roof, *tent(0, top + 2 * cap))


@hard_scene("pyramid of 210 discs")
def s19_disc_pyramid(make, clock):
    """S19. Twenty discs at the base, on a rough floor, µ = 0.7.

    Three discs need µ > tan(π/12) = 0.27 (tests/yade/law/test_closed_forms.py). A base of ten needs
    0.5 to 0.6, by a linear program; below that the pyramid collapses.
    """
    rough = material(0.7)
    return on_floor(make, rough, *[stadium(0, R, c, material=rough) for c in pyramid(dense_row)])


@hard_scene("pyramid of 210 RCRs")
def s19_pyramid(make, clock):
    """S19. A pyramid of 210 flat RCRs (η = 0.5), each on the ends of two, µ = 0.5."""
    rough = material()
    return on_floor(make, rough, *[flat(c, rough) for c in pyramid(flat_row)])


@hard_scene("stack of 100", "largest displacement at the end, in diameters")
def s19_tall_stack(make, clock, seconds=100.0):
    rough = material()
    return farthest(on_floor(make, rough, *stack(100, rough)), clock, seconds) / D
