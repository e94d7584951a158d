"""Statements of the paper on contact types and branch vectors (O10 to O13)."""

import numpy as np

from rcr.study.claims.criteria import (
    SIGMAS, NotTested, at_every_eta, claim, format_errors, format_largest, is_within, known,
    require_finite, row_of, rows_of, slope_of, trend,
)  # fmt: skip


def _mode(v, row, place):
    """Return position and height of the largest density near a place, and whether it is a mode.

    A mode exceeds, by more than its error, the lowest density on each side between it and the
    middle to the next mode.
    """
    eta, l_r, pdf = v["eta"][row], v["l_r"], v["pdf"][row]
    near = np.flatnonzero(np.abs(l_r - place) <= max(0.04, 0.2 * eta) / 2 + 1e-9)
    k = near[np.argmax(pdf[near])]
    error = np.nan_to_num(v["pdf_error"][row, k])
    left = (l_r > place - eta / 2) & (l_r < l_r[k])
    right = (l_r < place + eta / 2) & (l_r > l_r[k])
    inside = [side & (l_r > 1 - eta) for side in (left, right)]
    stands_out = all(pdf[k] - pdf[side].min() > error for side in inside if side.any())
    return l_r[k], pdf[k], stands_out


def _modes(v, where, sign):
    rows = rows_of(v, 0.2, 1, 3)
    modes = [_mode(v, row, where(v["eta"][row])) for row in rows]
    heights = np.array([mode[1] for mode in modes])
    agrees = all(mode[2] for mode in modes)
    if sign:
        slope, error = slope_of(v["eta"][rows], heights)
        agrees &= sign * slope > SIGMAS * error
    listed = ", ".join(f"{at:.2f} ({height:.2f})" for at, height, _ in modes)
    etas = ", ".join(f"{eta:g}" for eta in v["eta"][rows])
    error = f"height {format_largest(v['pdf_error'][rows])}"
    return agrees, f"at ℓ_r (height): {listed} for η = {etas}", error


@claim("O10", "P(ℓ_r) has a mode at 1 − η that grows with η",
       "a local maximum there at every η ≥ 0.2, rising beyond two errors")
def _(v):
    return _modes(v, lambda eta: 1 - eta, +1)


@claim("O10", "P(ℓ_r) has a mode near 1 − η/2 that shrinks with η",
       "a local maximum there at every η ≥ 0.2, falling beyond two errors")
def _(v):
    return _modes(v, lambda eta: 1 - eta / 2, -1)


@claim("O10", "P(ℓ_r) has a mode near 1", "a local maximum there at every η ≥ 0.2")
def _(v):
    return _modes(v, lambda eta: 1, 0)


@claim("O11", "the share of side-side contacts grows with η", "slope positive beyond two errors")
def _(v):
    return trend(v, "fraction_ss", +1)


def _sign_up_to_0_3(eta):
    """Return 1 up to η = 0.3 and −1 above, where elongations on both sides are known."""
    sign = np.where(eta <= 0.3 + 1e-9, 1, -1)
    if len(set(sign)) < 2:
        raise NotTested("expected elongations below and above 0.3")
    return sign


def _sign_change(v, name):
    rows = np.flatnonzero(np.isfinite(v[name]))
    value, error = v[name][rows], v[f"{name}_error"][rows]
    agrees = _sign_up_to_0_3(v["eta"][rows]) * value > -SIGMAS * known(error)
    return at_every_eta(v["eta"][rows], agrees, value, error)


@claim("O12", "C(f, ℓ_r) is positive for η ≤ 0.3, negative above",
       "its sign, within two errors, at every η (discs have no ℓ_r)")
def _(v):
    return _sign_change(v, "c_f_lr")


@claim("O12", "C(f, ℓ) is positive for η ≤ 0.3, negative above",
       "its sign, within two errors, at every η (discs have no ℓ_r)")
def _(v):
    return _sign_change(v, "c_f_l")


@claim("O12", "down to −0.22", "smaller of the two at η = 0.7 within 0.05 or two errors of −0.22")
def _(v):
    row = row_of(v, 0.7)
    value, error = min((v[name][row], v[f"{name}_error"][row]) for name in ("c_f_lr", "c_f_l"))
    require_finite(value)
    return is_within(value + 0.22, 0.05, error), f"{value:.3f}", format_errors(error)


@claim("O13", "force above the mean for side-side contacts, well below it for aligned cap-cap ones",
       "first class of ℓ_r above 1, last below 0.8, at every η ≥ 0.4")
def _(v):
    rows = rows_of(v, 0.4, 1)
    classes = [v["f_l_r"][row][np.isfinite(v["f_l_r"][row])] for row in rows]
    if not all(map(len, classes)):
        raise NotTested("too few contacts")
    ends = np.array([means[[0, -1]] for means in classes])
    value = ", ".join(
        f"{first:.2f} and {last:.2f} ({v['eta'][row]:g})" for row, (first, last) in zip(rows, ends))
    return ((ends[:, 0] > 1) & (ends[:, 1] < 0.8)).all(), value, ""


@claim("O13", "mean force rises with ℓ for η ≤ 0.3 and falls above",
       "sign of the slope over the classes of ℓ, at every η")
def _(v):
    sign = _sign_up_to_0_3(v["eta"])
    slopes, errors = np.array([slope_of(v["l"], means) for means in v["f_l"]]).T
    return at_every_eta(v["eta"], sign * slopes > 0, slopes, errors)
