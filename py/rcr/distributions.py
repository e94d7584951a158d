"""Distributions of contact forces and of contact directions. Needs NumPy.

They take arrays of contacts, of one network or of several pooled ones. `rcr.Network` and
`rcr.force_network` use them. All results have names and unpack as tuples.
"""

import typing

import numpy as np

from rcr import statistics
from rcr._data import checks
from rcr._data.plain import plain

LEAST_FORCE = 1e-4  # lower end of the bins of forces over their mean; rounding hides smaller forces
POWER_RANGE = 0.01  # least force of the fit of β over the mean; the tolerance hides smaller forces
MOST_ANGLES = 36  # bins of a polar distribution, at most
CONTACTS_PER_ANGLE = 50  # least mean number of contacts in these bins: a scatter of 14 %


class ForcePdf(typing.NamedTuple("ForcePdf", [("force", np.ndarray), ("pdf", np.ndarray)])):
    """Probability density of f/⟨f⟩; it unpacks as (force, pdf).

    Attributes
    ----------
    force, pdf : (bins,) float arrays
        Centres of the bins f/⟨f⟩ and densities [-].
    edges : (bins + 1,) float array
        Edges of the bins [-]; Σ pdf Δf is the fraction of contacts within them.
    """

    def __new__(cls, force, pdf, edges=None):
        made = super().__new__(cls, force, pdf)
        made.edges = edges
        return made


class Exponents(typing.NamedTuple):
    """Exponents of P(f) ∝ e^{−α f/⟨f⟩} above the mean and ∝ (f/⟨f⟩)^β below it [-].

    The errors are standard errors of the fits. A result of too few forces is NaN.
    """

    alpha: float
    alpha_error: float
    beta: float
    beta_error: float


class PolarDistributions(typing.NamedTuple):
    """Functions of the direction θ of normals, from x, of period π; (bins,) each.

    P(θ) has the integral 1 over [0, π]. The other functions are means of the contacts of a bin,
    NaN for fewer than `statistics.LEAST` of them. Tangents are normals turned by +90°.
    """

    theta: np.ndarray  # centres of the bins [rad]
    pdf: np.ndarray  # P(θ) [1/rad]
    branch_n: np.ndarray  # ⟨ℓ_n⟩(θ)/⟨ℓ_n⟩ [-]
    branch_t: np.ndarray  # ⟨ℓ_t⟩(θ)/⟨ℓ_n⟩ [-]
    force_n: np.ndarray  # ⟨f_n⟩(θ)/⟨f_n⟩ [-]
    force_t: np.ndarray  # ⟨f_t⟩(θ)/⟨f_n⟩ [-]


def over_mean(force):
    """Return f/⟨f⟩, or zeros if all forces are 0."""
    mean = force.mean()
    return force / mean if mean > 0 else force


def force_pdf(force, bins=50):
    """Return the `ForcePdf` of forces over their mean, (C,).

    `bins` is a number of logarithmic bins from the smallest force, or from `LEAST_FORCE`, to the
    largest one, or their edges (k,), which rise from a number ≥ 0.
    """
    if np.ndim(bins):
        edges = checks.array("bins", bins, (None,))
        expected = "at least two edges of bins of f/⟨f⟩, which rise from a number ≥ 0"
        if len(edges) < 2 or edges[0] < 0 or not (np.diff(edges) > 0).all():
            raise checks.error("bins", edges.tolist(), expected)
    else:
        bins = checks.integer("bins", bins, "at least 1, or edges", lambda v: 1 <= v <= 10**6)
        low, high = max(force.min(), LEAST_FORCE), force.max()
        edges = np.geomspace(min(low, high), high * (1 + 1e-12), bins + 1)
    centres = np.sqrt(edges[1:] * edges[:-1])
    centres = np.where(edges[:-1] > 0, centres, statistics.centres(edges))
    return ForcePdf(centres, statistics.density(force, edges), edges)


def exponents(force, low=POWER_RANGE):
    """Return the `Exponents` of forces over their mean, (C,), by maximum likelihood.

    α is fitted to the forces above the mean, β to those from `low` of it up to it.
    """
    rate, power = statistics.exponential_rate(force), statistics.power_exponent(force, low)
    return plain(Exponents(*rate, *power))


def angular_bins(contacts):
    """Return the number of bins of [0, π]: 36, or fewer for few contacts, at least 6.

    It is even, so that bins are centred symmetrically about the axes x and y.
    """
    return int(np.clip(contacts // CONTACTS_PER_ANGLE // 2 * 2, 6, MOST_ANGLES))


def polar(angle, branch, force, bins=None):
    """Return the `PolarDistributions` of contacts.

    `angle` (C,) is the direction of the normals [rad]; `branch` and `force` (C, 2) are components
    along normal and tangent, in any unit. `bins` is a number of bins, by default `angular_bins`.
    """
    if bins is None:
        bins = angular_bins(len(angle))
    bins = checks.integer("bins", bins, "at least 1 bin of [0, π]", lambda v: 1 <= v <= 10**4)
    edges, angle = np.linspace(0, np.pi, bins + 1), angle % np.pi
    scaled = [vector[:, k] / vector[:, 0].mean() for vector in (branch, force) for k in (0, 1)]
    means = [statistics.bin_means(angle, values, edges) for values in scaled]
    return PolarDistributions(
        statistics.centres(edges), statistics.density(angle, edges), *means)
