"""ξ-networks by cumulative sums agree with loops over contacts and cutoffs."""

import numpy as np
import pytest
from rcr.xi_networks import XiNetworks

from synthetic import random_network

CUTOFFS = (0.0, 0.1, 0.5, 1.0, 1.7, 4.0, np.inf)


def by_loops(network, xi):
    """(a_c, a_ln, a_lt, a_fn, a_ft, q/p, share) of S(ξ) by loops over contacts."""
    contacts, axes = network.contacts, network.stress_axes()
    rows = [(n, f, b, float(f @ n)) for n, f, b in zip(contacts["normal"], contacts["force"],
                                                       contacts["branch"])]
    mean = sum(row[3] for row in rows) / len(rows)
    zero = np.zeros((2, 2))
    part, whole = ({name: zero.copy() for name in ("n", "ln", "l", "fn", "f", "s")}
                   for _ in range(2))
    inside = 0
    for n, f, b, fn in rows:
        nn = np.outer(n, n)
        tensors = dict(n=nn, ln=(b @ n) * nn, l=np.outer(n, b), fn=fn * nn, f=np.outer(n, f),
                       s=np.outer(f, b))
        for name, tensor in tensors.items():
            whole[name] += tensor
            if fn <= xi * mean:
                part[name] += tensor
        inside += fn <= xi * mean

    def deviator(name):
        return (axes[:, 0] @ part[name] @ axes[:, 0] - axes[:, 1] @ part[name]
                @ axes[:, 1]) / np.trace(whole[name])

    a_c, ln, l, fn, f = (2 * deviator(name) for name in ("n", "ln", "l", "fn", "f"))
    return a_c, ln - a_c, l - ln, fn - a_c, f - fn, deviator("s"), inside / len(rows)


@pytest.mark.parametrize("xi", CUTOFFS)
def test_equals_the_loop_over_contacts(xi):
    test = random_network(1000)
    partial = test.xi_networks()
    measured = (*partial.anisotropies(xi), partial.shear_stress_ratio(xi), partial.fraction(xi))
    assert measured == pytest.approx(by_loops(test, xi), abs=1e-12)
    assert (*test.anisotropies(xi), test.shear_stress_ratio(xi),
            np.trace(test.fabric(xi))) == pytest.approx(measured, abs=1e-12)


@pytest.mark.parametrize("xi", CUTOFFS)
def test_half_sum_plus_cross_products_is_exact(xi):
    """X(ξ) by its definition, contact by contact; κ q(ξ)/p = half-sum + X(ξ)."""
    test = random_network(1000)
    n, _, branch, force = test.local_components()
    theta = np.arctan2(n[:, 1], n[:, 0]) - test.stress_angle()
    phi, lam = ((v[:, 0] + 1j * v[:, 1]) / v[:, 0].mean() - 1 for v in (force, branch))
    inside = force[:, 0] <= xi * force[:, 0].mean()
    partial = test.xi_networks()
    assert partial.cross_products(xi) == pytest.approx((phi * lam * np.exp(2j * theta))[inside].sum(
        ).real / len(n), abs=1e-12)
    factor = np.einsum("ck,ck->", force, branch) / (len(n) * force[:, 0].mean()
                                                    * branch[:, 0].mean())
    half_sum = 0.5 * sum(partial.anisotropies(xi))
    assert factor * partial.shear_stress_ratio(xi) == pytest.approx(half_sum
        + partial.cross_products(xi), abs=1e-12)


def test_all_cutoffs_at_once():
    partial = random_network(1000).xi_networks()
    cutoffs = np.array(CUTOFFS)
    together = np.array([*partial.anisotropies(cutoffs), partial.shear_stress_ratio(cutoffs),
                         partial.fraction(cutoffs)])
    alone = np.array([[*partial.anisotropies(xi), partial.shear_stress_ratio(xi),
                       partial.fraction(xi)] for xi in CUTOFFS]).T
    assert np.array_equal(together, alone)
    # nothing at ξ = 0, all at ∞
    assert together[:, 0] == pytest.approx(np.zeros(7), abs=0) and together[-1, -1] == 1


def test_equal_forces_are_cut_together():
    theta, ones = np.array([0.0, 1.0, 2.0]), np.ones(3, complex)
    partial = XiNetworks(theta, ones, ones, np.array([1.0, 1.0, 1.0]))
    assert partial.count(np.array([0.999, 1.0])).tolist() == [0, 3]


def test_no_contacts_are_refused():
    with pytest.raises(ValueError, match="no contacts"):
        XiNetworks(np.zeros(0), np.zeros(0, complex), np.zeros(0, complex), np.zeros(0))
