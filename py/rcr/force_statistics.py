"""Distributions and correlations of the contact forces of a network: part of `rcr.Network`.

They count the contacts between grains. Needs NumPy.
"""

import numpy as np

from rcr import distributions
from rcr._data import checks
from rcr.ensemble import Ensemble
from rcr.force_chains import force_chains
from rcr.xi_networks import cutoffs


class ForceStatistics:
    """Base class of `rcr.Network` with the statistics of its forces between grains."""

    def _pooled(self):
        return Ensemble([self], any_scene=True)

    def force_pdf(self, bins=50, component="normal"):
        """Return the `ForcePdf` of contacts between grains; it unpacks as (f/⟨f⟩, pdf).

        `bins` is a number of logarithmic bins, or their edges. Forces are f_n/⟨f_n⟩, or
        |f_t|/⟨|f_t|⟩ with `component` "tangential". See `rcr.distributions.force_pdf`.
        """
        return distributions.force_pdf(self._scaled_forces(component), bins)

    def exponents(self, component="normal"):
        """Return the `Exponents` (alpha, alpha_error, beta, beta_error) of P(f_n) or P(|f_t|).

        See `rcr.distributions.exponents`.
        """
        return distributions.exponents(self._scaled_forces(component))

    def _scaled_forces(self, component):
        """Return f_n/⟨f_n⟩ or |f_t|/⟨|f_t|⟩ of each contact between grains, (C,) [-]."""
        checks.choice("component", component, ("normal", "tangential"))
        pooled = self._pooled()
        if component == "normal":
            return pooled.fn
        if not pooled.ft.any():
            raise ValueError("no contact between grains has a tangential force")
        return distributions.over_mean(np.abs(pooled.ft))

    def xi_networks(self):
        """Return the `rcr.xi_networks.XiNetworks` of the contacts between grains."""
        return self._pooled().xi_networks

    def weak_share(self, xi=1.0):
        """Return the share of contacts between grains with f_n ≤ ξ ⟨f_n⟩, of the shape of ξ [-]."""
        return self.xi_networks().fraction(xi)

    def polar_distributions(self, xi=np.inf, bins=None):
        """Return P(θ) and the means of branch vectors and forces by direction, of the ξ-network.

        They are `PolarDistributions` of the contacts between grains; means are over those of the
        ξ-network. `bins` is the number of bins of [0, π]. A ValueError reports a ξ-network without
        contacts.
        """
        if np.ndim(xi):
            raise checks.error("xi", xi, "one cutoff")
        e = self._pooled()
        pick = e.fn <= cutoffs(xi)
        if not pick.any():
            raise checks.error("xi", xi, "a cutoff above the smallest f_n/⟨f_n⟩")
        branch, force = (np.column_stack(pair)[pick] for pair in ((e.ln, e.lt), (e.fn, e.ft)))
        return distributions.polar(e.angle[pick], branch, force, bins)

    def c_f_l(self):
        """Return Pearson's coefficient of force and branch length between grains [-].

        It is NaN if all forces or all lengths are equal.
        """
        return self._pooled().correlations()["c_f_l"]

    def c_f_lr(self):
        """Return Pearson's coefficient of force and reduced branch length ℓ/(R₁ + R₂) [-].

        It is NaN for discs, whose reduced lengths are 1 up to overlaps.
        """
        return self._pooled().correlations()["c_f_lr"]

    def force_chains(self, angle=45.0):
        """Return the `rcr.force_chains.ForceChains`; `angle` bounds the bend of a chain [°]."""
        return force_chains(self, angle)
