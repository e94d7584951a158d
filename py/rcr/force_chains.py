"""Force chains of a contact network. Needs NumPy.

Rule of Peters, Muthuswamy, Wibowo and Tordesillas, Phys. Rev. E 72, 041307 (2005): a chain joins
grains whose largest principal stress σ₁ exceeds the mean, through contacts whose branch vector is
within an angle of the axes of σ₁ of both grains. A chain has at least three grains. The mean is
that of the grains with a contact. A clump counts as one grain.
"""

import typing

import numpy as np

from rcr._data import checks

LEAST_GRAINS = 3  # of a chain


class ForceChains(typing.NamedTuple):
    """Force chains of a network."""

    chain: np.ndarray  # index of the chain of each grain, −1 outside; (N,) int
    contacts: np.ndarray  # mask of the contacts within chains; (C,) bool
    grains: np.ndarray  # number of grains or clumps of each chain, largest first; (K,) int
    share: float  # of the grains or clumps with a contact that belong to a chain [-]


def force_chains(frame, angle=45.0):
    """Return the `ForceChains` of a `rcr.table.Table`; `Network.force_chains` calls it.

    `angle` is the largest angle between a branch vector and the axis of σ₁ of either grain [°].
    Contacts without a force and those with fixed grains do not count. A ValueError reports an angle
    that is not within 0 to 90.
    """
    angle = checks.number("angle", angle, "an angle of 0 to 90 [°]", lambda v: 0 <= v <= 90)
    linked = frame.free_ends().all(axis=0) & (frame.normal_force() > 0)
    if not linked.any():
        return ForceChains(np.full(len(frame.grains["id"]), -1), linked, np.empty(0, int), 0.0)
    body, (one, two) = _bodies(frame)
    sigma, axis = _largest_stress(frame, body)
    size = len(sigma)
    bearing = np.zeros(size, bool)
    bearing[body[frame.per_grain(frame.normal_force() > 0) > 0]] = True
    stressed = bearing & (sigma > sigma[bearing].mean())
    linked &= (one != two) & stressed[one] & stressed[two]
    branch = frame.contacts["branch"]
    for end in one, two:
        along = np.abs(np.einsum("ca,ca->c", branch, axis[end]))
        linked &= along >= (np.cos(np.radians(angle)) - 1e-12) * np.hypot(*branch.T)
    label = _components(one[linked], two[linked], size)
    count = np.bincount(label, minlength=size)
    chains = np.flatnonzero(count >= LEAST_GRAINS)
    chains = chains[np.argsort(-count[chains], kind="stable")]
    index = np.full(size, -1)
    index[chains] = np.arange(len(chains))
    chain = index[label]
    return ForceChains(chain[body], linked & (chain[one] >= 0), count[chains],
                       float((chain >= 0).sum() / bearing.sum()))


def _bodies(frame):
    """Return the body of each grain, a clump being one, and both bodies of contacts, (2, C).

    Bodies are numbered from 0. Obstacles have any number.
    """
    ids, clump = frame.grains["id"], frame.grains["clump"]
    _, body = np.unique(np.where(clump >= 0, clump, ids), return_inverse=True)
    return body, [body[frame.rows(frame.contacts[name])] for name in ("body1", "body2")]


def _largest_stress(frame, body):
    """Return σ₁ [Pa] and its axis of each body, (bodies,) and (bodies, 2)."""
    stress = np.zeros((body.max() + 1, 2, 2))
    stress[body] = frame.grain_stresses()
    values, axes = np.linalg.eigh(0.5 * (stress + stress.transpose(0, 2, 1)))
    return values[:, 1], axes[:, :, 1]


def _components(one, two, size):
    """Return the smallest number of the connected component of each body, (size,) int."""
    label = np.arange(size)
    while True:
        low = np.minimum(label[one], label[two])
        new = label.copy()
        np.minimum.at(new, one, low)
        np.minimum.at(new, two, low)
        new = new[new]
        if np.array_equal(new, label):
            return label
        label = new
