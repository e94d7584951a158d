"""Force chains of a contact network. Needs NumPy.

Rule of Peters, Muthuswamy, Wibowo and Tordesillas, Phys. Rev. E 72, 041307 (2005): a chain joins
grains whose largest principal stress σ₁ exceeds the mean, through contacts whose branch vector is
within an angle of the axes of σ₁ of both grains. A chain has at least three grains. The mean is
that of the grains with a contact. A clump counts as one grain.
"""

import typing

import numpy as np

from rcr._data import checks
from rcr._data.network_columns import rows

LEAST_GRAINS = 3  # of a chain


class ForceChains(typing.NamedTuple):
    """Force chains of a network."""

    chain: np.ndarray  # index of the chain of each grain, −1 outside; (N,) int
    contacts: np.ndarray  # mask of the contacts within chains; (C,) bool
    grains: np.ndarray  # number of grains or clumps of each chain, largest first; (K,) int
    share: float  # of the grains or clumps with a contact that belong to a chain [-]


def force_chains(network, angle=45.0):
    """Return the `ForceChains` of a network.

    `angle` is the largest angle between a branch vector and the axis of σ₁ of either grain [°]. A
    ValueError reports an angle that is not within 0 to 90, or a network without contacts between
    grains.
    """
    angle = checks.number("angle", angle, "an angle of 0 to 90 [°]", lambda v: 0 <= v <= 90)
    if not network.between_particles.any():
        raise ValueError("the network has no contact between grains")
    body, (one, two) = _bodies(network)
    size = body.max() + 1
    sigma, axis = _largest_stress(network, body, size)
    bearing = np.zeros(size, bool)
    bearing[body[network.grain_coordination() > 0]] = True
    stressed = bearing & (sigma > sigma[bearing].mean())
    branch = network.contacts["branch"]
    branch = branch / np.linalg.norm(branch, axis=1, keepdims=True)
    linked = network.between_particles & (one != two) & stressed[one] & stressed[two]
    for end in one, two:
        cosine = np.abs(np.einsum("ca,ca->c", branch, axis[end]))
        linked &= cosine >= np.cos(np.radians(angle)) - 1e-12
    label = _components(one[linked], two[linked], size)
    count = np.bincount(label, minlength=size)
    chains = np.flatnonzero(count >= LEAST_GRAINS)
    chains = chains[np.argsort(-count[chains], kind="stable")]
    index = np.full(size, -1)
    index[chains] = np.arange(len(chains))
    chain = index[label]
    return ForceChains(chain[body], linked & (chain[one] >= 0), count[chains],
                       float((chain >= 0).sum() / bearing.sum()))


def _bodies(network):
    """Return the body of each grain, a clump being one, and both bodies of contacts, (2, C).

    Bodies are numbered from 0. Obstacles have the number of body 1.
    """
    ids, clump = network.particles["id"], network.particles["clump"]
    _, body = np.unique(np.where(clump >= 0, clump, ids), return_inverse=True)
    first = body[rows(ids, network.contacts["body1"])]
    second = body[rows(ids, network.contacts["body2"])]
    return body, (first, np.where(network.between_particles, second, first))


def _largest_stress(network, body, size):
    """Return σ₁ [Pa] and its axis of each body, (size,) and (size, 2)."""
    stress = np.zeros((size, 2, 2))
    stress[body] = network.grain_stresses()
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
