"""ξ-networks: partial tensors for all force cutoffs, from sorted forces and sums. Needs NumPy.

θ is the angle from the axis of σ₁ to the normal n of a contact, and t is n turned by +90°. A
contact with the branch vector ℓ_n n + ℓ_t t and the force f_n n + f_t t adds to the deviators
X₁₁ − X₂₂ of the tensors:

    n⊗n: cos 2θ        n⊗t: −sin 2θ        f⊗ℓ: Re [(f_n + i f_t)(ℓ_n + i ℓ_t) e^{2iθ}]

Each deviator is the real part of a complex weight times e^{2iθ}. An average
⟨f_t⟩(θ) = a sin 2θ contributes −a. The paper's figures have t at −90°, where it contributes +a.
The anisotropies here are those of the tensors, for which the half-sum holds.
"""

import typing

import numpy as np

from rcr._data import checks
from rcr._data.plain import plain

ROUNDING = 1e-12  # of a force over the mean force, relative


class Anisotropies(typing.NamedTuple):
    """Anisotropies of a ξ-network, of the shape of ξ [-], positive along σ₁."""

    a_c: np.ndarray  # of the contact normals
    a_ln: np.ndarray  # of the normal branch components
    a_lt: np.ndarray  # of the tangential ones
    a_fn: np.ndarray  # of the normal forces
    a_ft: np.ndarray  # of the tangential ones


def cutoffs(xi):
    """Return cutoffs of f_n/⟨f_n⟩, of the shape of ξ; a ValueError for a negative one or NaN.

    They exceed ξ by `ROUNDING`, so that forces equal to ξ ⟨f_n⟩ count.
    """
    xi = checks.reals("xi", xi)
    if not (xi >= 0).all():
        raise ValueError(f"xi = {xi}; expected cutoffs ≥ 0")
    with np.errstate(over="ignore"):  # the largest numbers become ∞
        return xi * (1 + ROUNDING)


class XiNetworks:
    """Partial sums over the contacts with f_n ≤ ξ ⟨f_n⟩.

    C contacts are sorted once. Each ξ then takes O(log C). A ValueError reports no contact, or
    arrays that differ in length.

    Parameters
    ----------
    theta : (C,) float array
        Angle from the axis of σ₁ to the normal [rad].
    branch, force : (C,) complex arrays
        ℓ_n + i ℓ_t and f_n + i f_t, in any unit.
    scaled_force : (C,) float array
        f_n/⟨f_n⟩ [-], to which ξ refers.
    """

    def __init__(self, theta, branch, force, scaled_force):
        if len(theta) == 0:
            raise ValueError("no contacts: a ξ-network needs at least one contact")
        lengths = [len(array) for array in (theta, branch, force, scaled_force)]
        if len(set(lengths)) > 1:
            raise ValueError(f"theta, branch, force and scaled_force hold {lengths} numbers; "
                             "expected one length")
        order = np.argsort(scaled_force, kind="stable")
        self._scaled_force = scaled_force[order]
        weights = [np.ones_like(branch), branch.real, branch, force.real, force, force * branch]
        deviators = (np.array(weights) * np.exp(2j * theta)).real[:, order]
        sums = np.cumsum(deviators, axis=1)
        self._sums = np.concatenate([np.zeros((6, 1)), sums], axis=1)
        pressure = (force * branch.conj()).real.sum()
        branches, forces = 2 * [branch.real.sum()], 2 * [force.real.sum()]
        self._traces = np.array([len(theta), *branches, *forces, pressure])

    def count(self, xi=np.inf):
        """Return the number of contacts N(ξ), of the shape of ξ."""
        return plain(np.searchsorted(self._scaled_force, cutoffs(xi), side="right"))

    def fraction(self, xi=np.inf):
        """Return N(ξ)/N = tr F(ξ) [-], of the shape of ξ."""
        return self.count(xi) / len(self._scaled_force)

    def _deviators(self, xi):
        """Return (X₁₁ − X₂₂)(ξ)/tr X(∞), (6, …) [-].

        X is n⊗n, ℓ_n n⊗n, ℓ⊗n, f_n n⊗n, f⊗n and f⊗ℓ.
        """
        return (self._sums[:, self.count(xi)].T / self._traces).T

    def anisotropies(self, xi=np.inf):
        """Return the `Anisotropies` of the shape of ξ [-], positive along σ₁.

        Source: the paper's equations harmonique and Aniso_values_xi.
        """
        a_c, ln, branch, fn, force, _ = 2 * self._deviators(xi)
        return plain(Anisotropies(a_c, ln - a_c, branch - ln, fn - a_c, force - fn))

    def shear_stress_ratio(self, xi=np.inf):
        """Return q(ξ)/p of the shape of ξ [-; eq. sigma_xi], with p of the whole network."""
        return plain(self._deviators(xi)[5])

    def pressure_factor(self):
        """Return κ = Σ f·ℓ/(C ⟨f_n⟩⟨ℓ_n⟩) [-].

        κ differs from 1 by the correlation of force and branch vector, which the half-sum neglects.
        """
        count, _, branch, _, force, pressure = self._traces
        return plain(pressure * count / (force * branch))

    def cross_products(self, xi=np.inf):
        """Return the products X(ξ) that the half-sum neglects, of the shape of ξ [-].

        With f = ⟨f_n⟩(1 + φ) and ℓ = ⟨ℓ_n⟩(1 + λ), where φ and λ are complex,

            X(ξ) = (1/C) Re Σ_{S(ξ)} φ λ e^{2iθ}
            κ q(ξ)/p = ½ (a_c + a_ln + a_lt + a_fn + a_ft) + X(ξ)

        The second equation is exact [eqs. isig2_xi and q_p_aniso2_xi].
        """
        contact, _, branch, _, force, stress = self._deviators(xi)
        return plain(self.pressure_factor() * stress - force - branch + contact)
