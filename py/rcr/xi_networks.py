"""ξ-networks: partial tensors of all force cutoffs at once, from contacts sorted by force and cumulative sums. Needs NumPy.

A contact with its normal at the angle θ from the axis of σ₁, branch vector ℓ_n n + ℓ_t t and force f_n n + f_t t, t being n turned by
+90°, adds to the deviators X₁₁ − X₂₂ of the paper's tensors

    n⊗n: cos 2θ        n⊗t: −sin 2θ        f⊗ℓ: Re [(f_n + i f_t)(ℓ_n + i ℓ_t) e^{2iθ}]

so that each deviator is the real part of a complex weight times e^{2iθ}. The minus sign is that of the turn: an average
⟨f_t⟩(θ) = a sin 2θ adds −a with t at +90°, and a with t at −90°, the sense in which the paper's figures have it positive. The
anisotropies here are those of the tensors, for which the half-sum holds.
"""

import numpy as np

from rcr import _checks as checks


def cutoffs(xi):
    """ξ as a float array of its shape; ValueError if one is no number, NaN or negative."""
    xi = checks.reals("xi", xi)
    if not (xi >= 0).all():
        raise ValueError(f"xi = {xi}; wanted cutoffs ≥ 0")
    return xi


class XiNetworks:
    """Partial sums over the contacts with f_n ≤ ξ ⟨f_n⟩, for any ξ in O(log C) after one sort of C contacts.

    Parameters
    ----------
    theta : (C,) float array
        Angle of the normal from the axis of σ₁ [rad].
    branch, force : (C,) complex arrays
        ℓ_n + i ℓ_t and f_n + i f_t, in any unit.
    scaled_force : (C,) float array
        What ξ cuts on: f_n/⟨f_n⟩ [-].

    Raises
    ------
    ValueError
        If there is no contact or the arrays differ in length.
    """

    def __init__(self, theta, branch, force, scaled_force):
        if len(theta) == 0:
            raise ValueError("no contacts: a ξ-network needs at least one contact between particles")
        if not len(theta) == len(branch) == len(force) == len(scaled_force):
            raise ValueError(f"theta, branch, force and scaled_force hold {len(theta)}, {len(branch)}, {len(force)} and {len(scaled_force)}; wanted one length")
        order = np.argsort(scaled_force, kind="stable")
        self._scaled_force = scaled_force[order]
        weights = np.array([np.ones_like(branch), branch.real, branch, force.real, force, force * branch])
        deviators = (weights * np.exp(2j * theta)).real[:, order]
        self._sums = np.concatenate([np.zeros((6, 1)), np.cumsum(deviators, axis=1)], axis=1)
        pressure = (force * branch.conj()).real.sum()
        self._traces = np.array([len(theta), *2 * [branch.real.sum()], *2 * [force.real.sum()], pressure])

    def count(self, xi=np.inf):
        """Number of contacts N(ξ), of the shape of ξ."""
        return np.searchsorted(self._scaled_force, cutoffs(xi), side="right")

    def share(self, xi=np.inf):
        """N(ξ)/N = tr F(ξ) [-], of the shape of ξ."""
        return self.count(xi) / len(self._scaled_force)

    def _deviators(self, xi):
        """(X₁₁ − X₂₂)(ξ)/tr X(∞) of n⊗n, ℓ_n n⊗n, ℓ⊗n, f_n n⊗n, f⊗n and f⊗ℓ; (6, …) [-]."""
        return (self._sums[:, self.count(xi)].T / self._traces).T

    def anisotropies(self, xi=np.inf):
        """(a_c, a_ln, a_lt, a_fn, a_ft) of the shape of ξ [-], positive along σ₁ [paper, eqs. harmonique, Aniso_values_xi]."""
        a_c, ln, branch, fn, force, _ = 2 * self._deviators(xi)
        return a_c, ln - a_c, branch - ln, fn - a_c, force - fn

    def shear_stress_ratio(self, xi=np.inf):
        """q(ξ)/p, p of the whole network [-; paper, eq. sigma_xi], of the shape of ξ."""
        return self._deviators(xi)[5]

    def pressure_factor(self):
        """κ = Σ f·ℓ/(C ⟨f_n⟩⟨ℓ_n⟩) [-]: 1 but for the correlation of force and branch vector, which the half-sum neglects."""
        count, _, branch, _, force, pressure = self._traces
        return pressure * count / (force * branch)

    def cross_products(self, xi=np.inf):
        """Products that the half-sum neglects besides, of the shape of ξ [-].

        With f = ⟨f_n⟩(1 + φ) and ℓ = ⟨ℓ_n⟩(1 + λ), φ and λ complex, it is X(ξ) = (1/C) Re Σ_{S(ξ)} φ λ e^{2iθ}, and exactly
        κ q(ξ)/p = ½ (a_c + a_ln + a_lt + a_fn + a_ft) + X(ξ)  [paper, eqs. isig2_xi and q_p_aniso2_xi].
        """
        contact, _, branch, _, force, stress = self._deviators(xi)
        return self.pressure_factor() * stress - force - branch + contact
