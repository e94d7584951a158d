"""Distributions of forces and directions, correlations and force chains of `rcr.Network`."""

import pickle

import numpy as np
import pytest
from rcr.force_chains import force_chains
from rcr.frame import Frame
from rcr.network import Network

from common import refused
from synthetic import TAU, anisotropic, network, random_network


def test_force_pdf_has_edges_and_unpacks():
    """Σ pdf Δf is the share of forces within the bins, here all of them."""
    found = random_network(5000).force_pdf(bins=20)
    f, pdf = found
    assert f is found.force and pdf is found.pdf and len(found.edges) == 21
    assert (found.edges[:-1] < f).all() and (f < found.edges[1:]).all()
    assert np.sum(pdf * np.diff(found.edges)) == pytest.approx(1, abs=1e-3)  # forces below 1e-4
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.edges, found.edges) and np.array_equal(again.pdf, pdf)


def of_forces(*normal, tangential=0.0):
    normal = np.array(normal, float)
    force = np.column_stack([normal, np.broadcast_to(tangential, normal.shape)])
    return network(np.zeros(len(normal)), np.ones((len(normal), 2)), force)


def test_force_pdf_of_given_bins():
    """Forces 1, 1, 2, 4 over their mean of 2: 0.5, 0.5, 1, 2. The bin from 3 on is empty."""
    found = of_forces(1, 1, 2, 4).force_pdf([0, 1, 3, 5])
    assert found.pdf == pytest.approx([2 / 4, 2 / 4 / 2, 0])
    assert found.force == pytest.approx([0.5, np.sqrt(3), np.sqrt(15)])  # no logarithm of 0
    sheared = of_forces(1, 1, 1, 1, tangential=[-1, 1, -2, 4])
    assert sheared.force_pdf([0, 1, 3], "tangential").pdf == pytest.approx([0.5, 0.25])
    for bad in [1.0], [1, 1], [-1, 1], [0, np.inf], [[0, 1]], ["a", "b"]:
        refused("bins", sheared.force_pdf, bad)
    refused("component = 'shear'; expected one of normal, tangential", sheared.force_pdf, 50,
            "shear")
    refused("no contact between grains has a tangential force", of_forces(1, 2).exponents,
            "tangential")


def test_exponents_of_known_densities():
    """e^{−f} above the mean has α = 1; (β + 1) f^β on (0, 1), here for β = 1, has β."""
    rng = np.random.default_rng(1)
    above = of_forces(*rng.exponential(1, 20_000)).exponents()
    assert above.alpha == pytest.approx(1, abs=4 * above.alpha_error)
    assert above.alpha_error == pytest.approx(1 / np.sqrt(20_000 / np.e), rel=0.05)
    below = np.sqrt(rng.uniform(0, 1, 10_000))
    strong = np.full(10_000, 2 - below.mean())  # so that the mean is 1
    found = of_forces(*below, *strong).exponents()
    assert found.beta == pytest.approx(1, abs=4 * found.beta_error) and found.beta_error < 0.05
    assert np.isnan(of_forces(1, 1).exponents()).all()


def test_weak_share_counts_forces_up_to_the_cutoff():
    assert of_forces(1, 1, 2, 4).weak_share() == 0.75
    assert of_forces(1, 1, 2, 4).weak_share([0.4, 0.5, 2]) == pytest.approx([0, 0.5, 1])
    assert of_forces(0.1, 0.1, 0.1).weak_share() == 1  # whose mean is 0.10000000000000002


def test_polar_distributions_of_known_anisotropies():
    """P(θ) ∝ 1 + a_c cos 2(θ − θσ), ℓ and f likewise, θσ = π/2; 36 bins of 2800 contacts."""
    found = anisotropic(100_000, 0.2, 0.05, 0.02, 0.15, 0.1).polar_distributions()
    cos, sin = np.cos(2 * found.theta - np.pi), np.sin(2 * found.theta - np.pi)
    assert len(found.theta) == 36 and np.sum(found.pdf) * np.pi / 36 == pytest.approx(1)
    assert found.pdf * np.pi == pytest.approx(1 + 0.2 * cos, abs=4 / np.sqrt(2200))
    scale = (1 + 0.5 * 0.2 * 0.05, 1 + 0.5 * 0.2 * 0.15)  # means of ℓ_n and f_n
    for name, expected in dict(branch_n=(1 + 0.05 * cos) / scale[0], branch_t=0.02 * sin / scale[0],
                               force_n=(1 + 0.15 * cos) / scale[1],
                               force_t=0.1 * sin / scale[1]).items():
        # the means are those of the bins, which smooth the cosine by 0.1 %
        assert getattr(found, name) == pytest.approx(expected, abs=0.004), name


def test_polar_distributions_of_few_contacts_have_wide_bins():
    count = lambda contacts, **o: len(random_network(contacts).polar_distributions(**o).theta)
    assert [count(n) for n in (10, 700, 10_000)] == [6, 14, 36] and count(10, bins=3) == 3
    weak = random_network(2000).polar_distributions(xi=0.5)  # 787 of 2000 forces
    assert len(weak.theta) < 36 and np.sum(weak.pdf) * np.pi / len(weak.theta) == pytest.approx(1)
    refused("xi = 0; expected a cutoff above the smallest", of_forces(1, 2).polar_distributions, 0)
    refused("one cutoff", of_forces(1, 2).polar_distributions, [1, 2])
    refused("bins = 0", of_forces(1, 2).polar_distributions, bins=0)


def test_correlations_of_force_and_length():
    """Forces 1 … 4 on lengths 2, 4, 6, 8 of grains with R₁ + R₂ = 2, 4, 6, 16: C = 1 and −0.77."""
    made = network(np.zeros(4), np.outer([2, 4, 6, 8], [1, 0]), np.outer([1, 2, 3, 4], [1, 0]),
                   grains=8, body1=np.arange(0, 8, 2), body2=np.arange(1, 8, 2))
    radius = np.repeat([1.0, 2, 3, 8], 2)
    grains = made.particles | dict(R=radius, cap_radius=0.5 * radius, half_length=0.5 * radius)
    long = Network(grains, made.contacts, made.attributes)
    assert long.c_f_l() == pytest.approx(1)
    assert long.c_f_lr() == pytest.approx(-np.sqrt(3 / 5))
    assert np.isnan(made.c_f_lr())  # of discs


def test_anisotropies_have_names():
    found = random_network().anisotropies([1, np.inf])
    assert found._fields == ("a_c", "a_ln", "a_lt", "a_fn", "a_ft")
    assert found.a_fn is found[3]


def rows_of_discs(*rows):
    """Rows of discs of radius 1 along x, 4 apart; each row has the forces between neighbours."""
    place, one, force = [], [], []
    for k, forces in enumerate(rows):
        first = len(place)
        place += [(2.0 * i, 4.0 * k) for i in range(len(forces) + 1)]
        one += range(first, first + len(forces))
        force += forces
    one, place, force = np.array(one), np.array(place), np.array(force, float)
    made = network(np.zeros(len(one)), np.outer(np.full(len(one), 2.0), [1, 0]),
                   np.outer(force, [1, 0]), grains=len(place), body1=one, body2=one + 1,
                   position=place[one] + [1, 0])
    return Network(made.particles | dict(position=place, center=place), made.contacts, {})


def test_chains_are_rows_of_stressed_grains():
    """σ₁ of a disc is the sum of its forces over π: 20/π in a row of 10, 10/π at its ends.

    The mean is 11.5/π, so that the ends and the row of forces 1 are left out.
    """
    test = rows_of_discs([10] * 6, [1] * 6, [10] * 4, [10] * 2)
    chains = test.force_chains()
    assert list(chains.grains) == [5, 3]  # the last row has one grain above the mean
    assert list(chains.chain) == [-1, *[0] * 5, -1, *[-1] * 7, -1, *[1] * 3, -1, -1, -1, -1]
    assert list(np.flatnonzero(chains.contacts)) == [1, 2, 3, 4, 13, 14]
    assert chains.share == pytest.approx(8 / 22)


def test_chains_do_not_bend_beyond_the_angle():
    """Contacts at 30° to the axis of σ₁ join at 45° and part at 20°.

    σ₁ has the mean 9.4/π, below the 10/π at the ends of the row of seven discs.
    """
    test = rows_of_discs([10] * 6, [1] * 6)
    turn = np.array([[np.cos(TAU / 12), -np.sin(TAU / 12)], [np.sin(TAU / 12), np.cos(TAU / 12)]])
    bent, stress = Frame.of(test), test.grain_stresses()
    bent.contacts["branch"] = bent.contacts["branch"] @ turn.T
    bent.grain_stresses = lambda: stress
    assert list(force_chains(bent, 45).grains) == [7] and not len(force_chains(bent, 20).grains)
    for angle in -1, 91, np.nan, None:
        refused("angle", test.force_chains, angle)


def test_a_clump_is_one_grain_of_a_chain():
    """Grains 2 and 3 are one clump: the row of seven stressed grains has six bodies."""
    test = rows_of_discs([10] * 6, [1] * 6)
    clump = np.where(np.isin(test.particles["id"], (2, 3)), 99, -1)
    inside = ~np.isin(test.contacts["body1"], 2)  # no contact within the clump
    contacts = {name: column[inside] for name, column in test.contacts.items()}
    center = test.particles["position"].copy()
    center[[2, 3]] = center[[2, 3]].mean(axis=0)
    grains = test.particles | dict(clump=clump, center=center)
    chains = Network(grains, contacts, {}).force_chains()
    assert list(chains.grains) == [6] and list(chains.chain[:7]) == [0] * 7


def test_grains_without_contacts_have_no_chain():
    test = rows_of_discs([1, 1])
    none = {name: column[:0] for name, column in test.contacts.items()}
    chains = Network(test.particles, none, {}).force_chains()
    assert list(chains.chain) == [-1, -1, -1] and chains.share == 0 and not len(chains.grains)


def test_the_ratio_of_stresses_leaves_walls_out_and_sin_phi_does_not():
    """Two contacts between grains and one at a wall: 0.2 against 0.6.

    Along x: f ℓ = 3·2 between grains and 10 at the wall; along y 4.
    """
    made = network(np.array([0, np.pi / 2, 0]), np.array([[2.0, 0], [4, 0], [1, 0]]),
                   np.array([[3.0, 0], [1, 0], [10, 0]]), body2=np.array([1, 1, -1]),
                   type=np.array([0, 0, 3]))
    assert made.sin_phi() == pytest.approx((16 - 4) / 20)
    assert made.shear_stress_ratio() == pytest.approx((6 - 4) / 10)
    assert np.trace(made.stress()) * 10 == pytest.approx(20)
    for method in Network.sin_phi, Network.shear_stress_ratio:
        assert "obstacles" in method.__doc__
