"""ξ-networks by cumulative sums agree with loops over contacts and cutoffs."""

import numpy as np
import pytest
from rcr.xi_networks import XiNetworks

from common import refused
from synthetic import random_network

CUTOFFS = (0.0, 0.1, 0.5, 1.0, 1.7, 4.0, 50.0, np.inf)  # no force is above 50


def by_loops(network, xi):
    """(a_c, a_ln, a_lt, a_fn, a_ft, q/p, share) of S(ξ) by loops over contacts."""
    contacts, axes = network.contacts, network.stress_axes()
    rows = list(zip(contacts["normal"], contacts["force"], contacts["branch"]))
    mean = sum(f @ n for n, f, _ in rows) / len(rows)
    part, whole = ({name: np.zeros((2, 2)) for name in ("n", "ln", "l", "fn", "f", "s")}
                   for _ in range(2))
    inside = 0
    for n, f, b in rows:
        nn = np.outer(n, n)
        tensors = dict(n=nn, ln=(b @ n) * nn, l=np.outer(n, b), fn=(f @ n) * nn, f=np.outer(n, f),
                       s=np.outer(f, b))
        for name, tensor in tensors.items():
            whole[name] += tensor
            if f @ n <= xi * mean:
                part[name] += tensor
        inside += f @ n <= xi * mean

    def deviator(name):
        turned = axes.T @ part[name] @ axes
        return (turned[0, 0] - turned[1, 1]) / np.trace(whole[name])

    a_c, ln, l, fn, f = (2 * deviator(name) for name in ("n", "ln", "l", "fn", "f"))
    return a_c, ln - a_c, l - ln, fn - a_c, f - fn, deviator("s"), inside / len(rows)


def measures(partial, xi):
    """(a_c, a_ln, a_lt, a_fn, a_ft, q/p, share) at a cutoff or at many."""
    return (*partial.anisotropies(xi), partial.shear_stress_ratio(xi), partial.fraction(xi))


@pytest.mark.parametrize("xi", CUTOFFS)
def test_equals_the_loop_over_contacts(xi):
    """X(ξ) by its definition, contact by contact; κ q(ξ)/p = half-sum + X(ξ)."""
    test = random_network(1000)
    partial = test.xi_networks()
    measured = measures(partial, xi)
    assert measured == pytest.approx(by_loops(test, xi), abs=1e-12)
    direct = *test.anisotropies(xi), test.shear_stress_ratio(xi), np.trace(test.fabric(xi))
    assert direct == pytest.approx(measured, abs=1e-12)
    n, _, branch, force = test.local_components()
    theta = np.arctan2(n[:, 1], n[:, 0]) - test.stress_angle()
    phi, lam = ((v[:, 0] + 1j * v[:, 1]) / v[:, 0].mean() - 1 for v in (force, branch))
    inside = force[:, 0] <= xi * force[:, 0].mean()
    crossed = (phi * lam * np.exp(2j * theta))[inside].sum().real / len(n)
    assert partial.cross_products(xi) == pytest.approx(crossed, abs=1e-12)
    factor = (force * branch).sum(axis=1).mean() / (force[:, 0].mean() * branch[:, 0].mean())
    total = 0.5 * sum(partial.anisotropies(xi)) + partial.cross_products(xi)
    assert factor * partial.shear_stress_ratio(xi) == pytest.approx(total, abs=1e-12)


def test_all_cutoffs_at_once():
    partial = random_network(1000).xi_networks()
    together = np.array(measures(partial, np.array(CUTOFFS)))
    assert np.array_equal(together, np.array([measures(partial, xi) for xi in CUTOFFS]).T)
    # nothing at ξ = 0, all at ∞
    assert not together[:, 0].any() and together[-1, -1] == 1


def test_equal_forces_are_cut_together_and_no_contacts_are_refused():
    of_equal = lambda count: XiNetworks(np.arange(count), *np.ones((2, count), complex),
                                        np.ones(count))
    assert of_equal(3).count(np.array([0.999, 1.0])).tolist() == [0, 3]
    refused("no contacts", of_equal, 0)


@pytest.mark.parametrize("count", range(2, 60))
def test_forces_equal_to_the_mean_are_weak(count):
    force = np.full(count, 0.1)
    partial = XiNetworks(np.arange(count), np.ones(count, complex), force.astype(complex),
                         force / force.mean())
    assert partial.count(1.0) == count
