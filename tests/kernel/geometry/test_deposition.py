"""Geometric deposition: every disc rests in the lowest free place, on two of discs, floor and walls."""

import itertools

import numpy as np
import pytest

from rcr import _kernel

TOUCH = 1e-8  # of a radius; the kernel takes 1e-9 for touching


def random_radii(count, seed):
    return 1 / (1 - 0.5 * np.random.default_rng(seed).random(count))


def lowest_place(radius, centres, radii, width):
    """By trying every pair of circles on which the centre may lie, and floor and walls."""
    reach = radii + radius
    places = [(radius, radius), (width - radius, radius)]
    for (x, y), r in zip(centres, reach):
        places += [(wall, y + np.sqrt(r**2 - (wall - x) ** 2)) for wall in (radius, width - radius) if abs(wall - x) < r]
        if abs(y - radius) < r:
            places += [(x + side * np.sqrt(r**2 - (y - radius) ** 2), radius) for side in (-1, 1)]
    for (a, ra), (b, rb) in itertools.combinations(zip(centres, reach), 2):
        d = np.hypot(*(b - a))
        if abs(ra - rb) < d < ra + rb:
            along = (d**2 + ra**2 - rb**2) / (2 * d)
            unit, up = (b - a) / d, np.sqrt(ra**2 - along**2)
            places += [tuple(a + along * unit + side * up * np.array([-unit[1], unit[0]])) for side in (-1, 1)]
    free = [
        p
        for p in places
        if p[1] >= radius * (1 - TOUCH)
        and radius * (1 - TOUCH) <= p[0] <= width - radius * (1 - TOUCH)
        and (not len(centres) or (np.hypot(*(centres - p).T) >= reach - TOUCH * radius).all())
    ]
    return min(y for _, y in free)


@pytest.mark.parametrize("seed", range(4))
def test_every_disc_takes_the_lowest_free_place(seed):
    radii, width = random_radii(60, seed), 14.0
    centres = _kernel.deposit(radii, width)
    for k, radius in enumerate(radii):
        lowest = lowest_place(radius, centres[:k], radii[:k], width)
        assert centres[k, 1] == pytest.approx(lowest, abs=1e-6 * radius), f"disc {k}, seed {seed}"


def test_discs_touch_two_and_overlap_nothing():
    radii, width = random_radii(3000, 1), 120.0
    centres = _kernel.deposit(radii, width)
    gap = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1)) - radii[:, None] - radii[None]
    np.fill_diagonal(gap, np.inf)
    assert gap.min() > -TOUCH
    walls = np.column_stack([centres[:, 0] - radii, width - centres[:, 0] - radii, centres[:, 1] - radii])
    assert walls.min() > -TOUCH
    below = np.tril(gap < TOUCH).sum(axis=1) + (walls < TOUCH).sum(axis=1)  # of the discs that were there before
    assert below.min() >= 1 and np.median(below) == 2  # the first discs of the floor row touch it and a wall, or it alone
    fraction = np.pi * (radii**2).sum() / (width * (centres[:, 1] + radii).max())
    assert 0.78 < fraction < 0.86  # a random close packing of discs, its rough surface included


def test_one_disc_as_wide_as_the_box_stacks():
    np.testing.assert_allclose(_kernel.deposit(np.ones(3), 2.0), [(1, 1), (1, 3), (1, 5)], atol=1e-12)


@pytest.mark.parametrize("radii, width", [([1.0], 1.9), ([1.0, -1.0], 9), ([np.nan], 9), ([1.0], np.inf)])
def test_what_does_not_fit_is_refused(radii, width):
    with pytest.raises(ValueError, match=r"radii\[.\] = .* in a box of width .*; wanted 0 < 2 radius <= width"):
        _kernel.deposit(np.array(radii), width)
