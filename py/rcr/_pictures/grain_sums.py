"""Sums over the contacts of each grain, for `Frame` and `Network`. Needs NumPy.

`grains` and `contacts` are dicts of arrays with the columns of `Frame`. Members of a clump share
one sum, because a clump moves as one body.
"""

import numpy as np

from rcr._pictures import outlines as _outlines

STRIPS = 2000  # vertical strips of a clump; the relative error of its area is about 1e-5


def rows(known, ids):
    """Return the row of each id in the array `known`, −1 for an unknown id."""
    if not len(known):
        return np.full(np.shape(ids), -1)
    order = np.argsort(known)
    at = order[np.minimum(np.searchsorted(known, ids, sorter=order), len(known) - 1)]
    return np.where(known[at] == ids, at, -1)


def areas(grains):
    """Return the area of each grain, (N,) [m²]; see `Frame.areas`."""
    own, clump = _outlines.areas(grains), grains["clump"]
    for number in np.unique(clump[clump >= 0]):
        members = clump == number
        clumped = {name: column[members] for name, column in grains.items()}
        union, _, _ = _outlines.union(clumped, STRIPS)
        own[members] *= union / own[members].sum()
    return own


def contact_sums(grains, contacts, values):
    """Return the sum of the contacts' values (C,) over the contacts of each grain, (N,)."""
    total = np.zeros(len(grains["id"]))
    for body in ("body1", "body2"):
        at = rows(grains["id"], contacts[body])
        np.add.at(total, at[at >= 0], values[at >= 0])
    return _clump_sums(grains["clump"], total)


def stress_tensors(grains, contacts):
    """Return the stress of each grain, (N, 2, 2) [Pa]; see `Frame.stress_tensors`."""
    sums = np.zeros((len(grains["id"]), 2, 2))
    for body, arm, sign in (("body1", "arm1", 1), ("body2", "arm2", -1)):
        at = rows(grains["id"], contacts[body])
        moments = sign * np.einsum("ca,cb->cab", contacts["force"], contacts[arm])
        np.add.at(sums, at[at >= 0], moments[at >= 0])
    clump = grains["clump"]
    return _clump_sums(clump, sums) / _clump_sums(clump, areas(grains))[:, None, None]


def _clump_sums(clump, values):
    """Replace the values (N, …) of a clump's members by their sum."""
    member = clump >= 0
    if not member.any():
        return values
    _, group = np.unique(clump[member], return_inverse=True)
    sums = np.zeros((group.max() + 1, *values.shape[1:]))
    np.add.at(sums, group, values[member])
    values = values.copy()
    values[member] = sums[group]
    return values
