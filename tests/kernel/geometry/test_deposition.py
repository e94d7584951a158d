"""Geometric deposition: every disc takes the lowest free position on two supports."""

import itertools

import numpy as np
import pytest
from common import refused
from rcr import _kernel

TOUCH = 1e-8  # tolerance of touching, over a radius; 1e-9 in the kernel


def random_radii(count, seed):
    return 1 / (1 - 0.5 * np.random.default_rng(seed).random(count))


def lowest_position(radius, centres, radii, width, sealed=0):
    """Height of the lowest free position, from all pairs of discs, floor and walls."""
    reach = radii + radius
    positions = [(radius, radius), (width - radius, radius)]
    for (x, y), r in zip(centres, reach):
        for wall in (radius, width - radius):
            if abs(wall - x) < r:
                positions.append((wall, y + np.sqrt(r**2 - (wall - x) ** 2)))
        if abs(y - radius) < r:
            along = np.sqrt(r**2 - (y - radius) ** 2)
            positions += [(x + side * along, radius) for side in (-1, 1)]
    for (a, ra), (b, rb) in itertools.combinations(zip(centres, reach), 2):
        d = np.hypot(*(b - a))
        if abs(ra - rb) < d < ra + rb:
            along = (d**2 + ra**2 - rb**2) / (2 * d)
            unit, up = (b - a) / d, np.sqrt(ra**2 - along**2)
            across = up * np.array([-unit[1], unit[0]])
            positions += [tuple(a + along * unit + side * across) for side in (-1, 1)]
    least = radius * (1 - TOUCH)

    def is_free(p):
        in_box = p[1] >= max(least, sealed) and least <= p[0] <= width - least
        return in_box and (np.hypot(*(centres - p).T) >= reach - TOUCH * radius).all()

    return min(p[1] for p in positions if is_free(p))


@pytest.mark.parametrize("seed", range(4))
def test_every_disc_takes_the_lowest_free_position(seed):
    radii, width = random_radii(60, seed), 14.0
    centres = _kernel.deposit(radii, width)
    for k, radius in enumerate(radii):
        lowest = lowest_position(radius, centres[:k], radii[:k], width)
        assert centres[k, 1] == pytest.approx(lowest, abs=1e-6 * radius), f"disc {k}, seed {seed}"


@pytest.mark.parametrize("span, seed", [(1, 0), (2, 1), (5, 2)])
def test_places_below_a_complete_layer_are_closed(span, seed):
    """A layer has 100 discs in a narrow box."""
    radii, width = 1 + (span - 1) * np.random.default_rng(seed).random(230), 6.0 * span
    centres = _kernel.deposit(radii, width)
    for k in range(101, len(radii), 3):
        whole = k // 100 * 100
        sealed = centres[whole - 100:whole, 1].min()
        near = np.arange(k)[centres[:k, 1] + radii[:k] + span > sealed]
        lowest = lowest_position(radii[k], centres[near], radii[near], width, sealed)
        assert centres[k, 1] == pytest.approx(lowest, abs=1e-6 * radii[k]), f"disc {k}"


def test_discs_touch_two_and_overlap_nothing():
    radii, width = random_radii(3000, 1), 120.0
    centres = _kernel.deposit(radii, width)
    distance = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))
    gap = distance - radii[:, None] - radii[None]
    np.fill_diagonal(gap, np.inf)
    assert gap.min() > -TOUCH
    x, y = centres.T
    walls = np.column_stack([x - radii, width - x - radii, y - radii])
    assert walls.min() > -TOUCH
    supports = np.tril(gap < TOUCH).sum(axis=1) + (walls < TOUCH).sum(axis=1)  # earlier discs
    assert (supports == 2).all()
    fraction = np.pi * (radii**2).sum() / (width * (centres[:, 1] + radii).max())
    assert 0.78 < fraction < 0.86  # random close packing with a rough surface
    stack = _kernel.deposit(np.ones(3), 2.0)  # each as wide as the box
    np.testing.assert_allclose(stack, [(1, 1), (1, 3), (1, 5)], atol=1e-12)


@pytest.mark.parametrize(
    "radii, width", [([1.0], 1.9), ([1.0, -1.0], 9), ([np.nan], 9), ([1.0], np.inf)])
def test_invalid_radii_are_rejected(radii, width):
    message = r"radii\[.\] = .* in a box of width .*; expected 0 < 2 radius <= width"
    refused(message, _kernel.deposit, np.array(radii), width)
