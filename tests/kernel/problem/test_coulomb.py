"""Contact problem of one point: one case per branch, then the laws on random blocks.

    u = W p + g,  0 ≤ u_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rcr import _kernel

numbers = st.floats(-10, 10, allow_subnormal=False)
frictions = st.one_of(st.just(0.0), st.floats(1e-3, 3))


def assert_laws(W, g, mu, p):
    """Check the laws above; the message contains a call that replays the case."""
    W, g, p = np.asarray(W, float), np.asarray(g, float), np.asarray(p, float)
    u = W @ p + g
    speed = np.abs(g).sum() + (np.abs(W) @ np.abs(p)).sum()
    # rounding of W p + g, and of the Schur complement
    small_u = 1e-11 * speed * np.linalg.cond(W) ** 0.5
    small_p = 1e-13 * np.abs(p).sum()
    arguments = f"{W[0, 0]!r}, {W[0, 1]!r}, {W[1, 1]!r}, {g[0]!r}, {g[1]!r}, {mu!r}"
    replay = f"solve_coulomb({arguments}) = {p}, u = {u}"
    assert p[0] >= 0 and u[0] >= -small_u, replay
    assert p[0] == 0 or abs(u[0]) <= small_u, replay
    assert abs(p[1]) <= mu * p[0] + small_p, replay
    if abs(u[1]) > small_u:
        assert p[1] == pytest.approx(-mu * p[0] * np.sign(u[1]), abs=small_p), replay


def solve(W, g, mu):
    return np.array(_kernel.solve_coulomb(W[0][0], W[0][1], W[1][1], g[0], g[1], mu))


@pytest.mark.parametrize("W, g, mu, expected", [
    pytest.param([[2, 0], [0, 4]], (1, 3), 0.5, (0, 0), id="open"),
    pytest.param([[2, 0], [0, 4]], (0, 3), 0.5, (0, 0), id="touching, g_n = 0"),
    pytest.param([[2, 0], [0, 4]], (-1, 3), 0, (0.5, 0), id="frictionless"),
    pytest.param([[2, 0], [0, 4]], (-1, 0), 0.5, (0.5, 0), id="no slip"),
    pytest.param([[2, 0], [0, 4]], (-1, 0.8), 0.5, (0.5, -0.2), id="stick"),
    pytest.param([[2, 0], [0, 4]], (-1, 8), 0.5, (0.5, -0.25), id="slide, slip > 0"),
    pytest.param([[2, 0], [0, 4]], (-1, -8), 0.5, (0.5, 0.25), id="slide, slip < 0"),
    pytest.param([[2, 1], [1, 4]], (-1, 8), 0.5, (2 / 3, -1 / 3), id="slide, coupled, slip > 0"),
    pytest.param([[2, 1], [1, 4]], (-1, -8), 0.5, (0.4, 0.2), id="slide, coupled, slip < 0"),
    pytest.param([[2, 0], [0, 0]], (-1, 3), 0.5, (0.5, -0.25), id="w_tt = 0, slide"),
    pytest.param([[2, 0], [0, 0]], (-1, 0), 0.5, (0.5, 0), id="w_tt = 0, at rest"),
])
def test_one_case_per_branch(W, g, mu, expected):
    assert solve(W, g, mu) == pytest.approx(np.array(expected), rel=1e-15)
    assert_laws(W, g, mu, expected)


@settings(max_examples=400, deadline=None)
@given(a=st.tuples(numbers, numbers), b=st.tuples(numbers, numbers), g=st.tuples(numbers, numbers),
       mu=frictions)
def test_laws_hold_for_any_positive_definite_block(a, b, g, mu):
    """W = A Aᵀ + 0.01 I covers weak coupling and the Painlevé case; all have a solution."""
    A = np.array([a, b])
    W = A @ A.T + 0.01 * np.eye(2)
    assert_laws(W, g, mu, solve(W, g, mu))


@pytest.mark.parametrize("slip", [1e-3, 1.0, 100.0])
def test_painleve_sticks(slip):
    """For w_nn ≤ µ w_nt stick holds: p_n = (|g_n| + w_nt |p_t|)/w_nn ≥ |p_t|/µ. The tangential
    shock increases p_n: an impact without collision.
    """
    W, mu, g = np.array([[1.0, 1.5], [1.5, 3.0]]), 0.8, np.array([-1e-3, slip])
    p = solve(W, g, mu)
    assert W @ p + g == pytest.approx(0, abs=1e-12 * slip)  # rounding of W p + g
    assert p[0] > 1e-3 / W[0, 0]
    assert_laws(W, g, mu, p)
    p = solve([[1.0, 2.0], [2.0, 4.0]], (-1.0, 3.0 * slip), mu)  # rank 1: without a solution
    assert np.isfinite(p).all() and p[0] >= 0 and abs(p[1]) <= 0.8 * p[0] * (1 + 1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_a_body_with_one_way_to_move_bears_no_rounding_error(seed):
    """W = j jᵀ of a wall or a hinged body: w_tt − w_nt²/w_nn is a rounding error; the point slides."""
    rng = np.random.default_rng(seed)
    for _ in range(500):
        angle, mu, g = rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 1.2), rng.normal(0, 1, 2)
        j = np.array([np.cos(angle), np.sin(angle)])
        W = np.outer(j, j)
        p = solve(W, g, mu)
        assert abs(p[1]) <= mu * p[0] * (1 + 1e-12)
        case = f"angle {angle}, mu {mu}, g {g}: p = {p}"
        assert (W @ p + g)[0] == pytest.approx(max(g[0], 0), abs=1e-9), case


@settings(max_examples=400, deadline=None)
@given(n=numbers, t=numbers, mu=frictions)
def test_projection_is_the_nearest_point_of_the_cone(n, t, mu):
    """q = P_K(p) ⟺ q ∈ K, (p − q)·q = 0 and (p − q)·r ≤ 0 for the rays r = (1, ±µ) that span K."""
    p = np.array([n, t])
    q = np.array(_kernel.project_cone(n, t, mu))
    small = 1e-14 * (1 + mu) * (1 + p @ p)  # rounding of a product
    replay = f"project_cone({n!r}, {t!r}, {mu!r}) = {q}"
    assert abs(q[1]) <= mu * q[0] + small, replay
    assert abs((p - q) @ q) <= small, replay
    for side in (-mu, mu):
        assert (p - q) @ (1, side) <= small, replay


# ---- passive restitution

@pytest.mark.parametrize("seed", range(3))
def test_factor_is_the_largest_that_adds_no_energy(seed):
    """Full restitution can add energy if w_nt reverses the slip, never without friction."""
    for e in 0.0, 0.5, 1.0:
        p = _kernel.solve_coulomb(1, 0, 1, -1 - e, 0.3, 0)
        assert _kernel.passive_restitution_factor(1, 0, 1, p, (-1, 0.3), (e, 0.3), -e, 0) == 1
    rng = np.random.default_rng(seed)
    gains = 0
    for _ in range(300):
        A = rng.normal(size=(2, 2))
        W, mu = A @ A.T + 0.1 * np.eye(2), rng.uniform(0, 1)
        before = np.array([-1.0, rng.normal(0, 1)])
        w = W[0, 0], W[0, 1], W[1, 1]
        # impulse, and twice the added energy p · (u + u⁻), for the restitution `factor`
        impulse = lambda factor: solve(W, (before[0] - factor, before[1]), mu)
        gain = lambda factor: impulse(factor) @ (2 * before + W @ impulse(factor))
        p = impulse(1)
        factor = _kernel.passive_restitution_factor(*w, p, before, before + W @ p, -1.0, mu)
        replay = f"passive_restitution_factor({w}, {p}, {before}, µ = {mu}) = {factor}"
        scale = np.hypot(*p) * np.hypot(*before)
        if gain(1) <= 1e-3 * scale:
            assert factor == 1, replay
            continue
        gains += 1
        assert 0 <= factor < 1, replay
        assert gain(factor) <= 1e-12 * scale and gain(factor + 1e-6) > 0, replay
    assert gains > 3, "no case adds energy"
