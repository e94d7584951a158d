"""Masonry: corners of voussoirs and bricks, and their bodies."""

import math

import numpy as np
import rcr


def rectangle(width, height):
    """Corners about the centre, (4, 2) [m]."""
    return 0.5 * np.array([(width, height), (-width, height), (-width, -height), (width, -height)])


def brick(left, bottom, width, height):
    return rectangle(width, height) + [left + width / 2, bottom + height / 2]


def arch(count, R, thickness, half=math.pi / 2):
    """Voussoirs of a circular arch from right to left, (count, 4, 2) [m].

    R is the radius of the centre line about the origin; the arch spans angles up to `half` from the
    vertical. Joints are radial and as long as the thickness.
    """
    joints = np.linspace(half, -half, count + 1)
    radial = np.column_stack([np.sin(joints), np.cos(joints)])
    inner, outer = (R - thickness / 2) * radial, (R + thickness / 2) * radial
    return np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1)


def house(R):
    """Corners of the stones of a house 24 R wide, about x = 0.

    Ten courses of bricks of 4 R by 2 R in running bond, a window under a lintel, and a gable of two
    slabs with level seats and a plumb joint.
    """
    half, length, height, courses = 12 * R, 4 * R, 2 * R, 10
    window, lintel = range(4, 8), 8  # courses
    stones = []
    for course in range(courses):
        inner = np.arange(-half + length / (1 + course % 2), half, length)
        joints = [-half, *inner[inner < half - 1e-9 * R], half]
        opening = 4 * R if course in window else 6 * R if course == lintel else 0
        for left, right in zip(joints[:-1], joints[1:]):
            pieces = (left, min(right, -opening)), (max(left, opening), right)
            for start, end in pieces if opening else [(left, right)]:
                if end - start > 1e-9 * R:
                    stones.append(brick(start, course * height, end - start, height))
    stones.append(brick(-6 * R, lintel * height, 12 * R, height))
    slab = np.array([(0, half), (-half, 0), (R - half, 0), (0, half - R)]) + [0, courses * height]
    return [*stones, slab, slab * [-1, 1]]


def area_and_centroid(corners):
    """Area [m²] and centroid [m] of a polygon."""
    x, y = np.asarray(corners).T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    part = x * y2 - x2 * y
    area = 0.5 * part.sum()
    return area, np.array([((x + x2) * part).sum(), ((y + y2) * part).sum()]) / (6 * area)


def bodies(stones, **options):
    """A body for each polygon, at its place."""
    return [rcr.polygon(area_and_centroid(stone)[1], stone, **options) for stone in stones]
