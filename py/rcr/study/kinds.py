"""Kinds of grains: shape, rolling friction and elongation of a biaxial test."""

import math
import typing

from rcr.study.protocol import SHAPE_NAMES, SHAPES


class Kind(typing.NamedTuple):
    """Grains of a test. Kinds are the rows of an analysis, in the order of these numbers."""

    rank: int  # of the shape in `protocol.SHAPES`
    rolling_friction: float  # between grains [-]
    eta: float  # elongation [-]

    @classmethod
    def of(cls, attributes, eta):
        """Return the kind of the grains of a network with these attributes."""
        rank = list(SHAPES).index(attributes.get("shape", "rcr"))
        return cls(rank, float(attributes.get("rolling_friction", 0)), eta)

    @property
    def shape(self):
        """Name in `protocol.SHAPES`."""
        return list(SHAPES)[self.rank]

    @property
    def sides(self):
        """Number of sides of a regular polygon, else 0."""
        return round(math.pi / math.acos(1 - self.eta)) if self.shape == "regular" else 0

    @property
    def name(self):
        """Text for sentences."""
        rolling = f"µ_r = {self.rolling_friction:g}"
        if self.shape == "rcr":
            elongation = f"η = {self.eta:g}"
            return f"{elongation}, {rolling}" if self.rolling_friction else elongation
        if self.sides:
            return f"{self.sides} sides"
        return f"{SHAPE_NAMES[self.shape]} η = {self.eta:g}"


def group_by_kind(runs):
    """Return {`Kind`: its runs}, rising."""
    groups = {kind: [] for kind in sorted({run.kind for run in runs})}
    for run in runs:
        groups[run.kind].append(run)
    return groups
