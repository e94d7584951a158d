"""Criteria of statements on branch vectors, contact types and ξ-networks (O10 to O18)."""

import numpy as np

from rcr.papers.azema_radjai_2011 import PAPER
from rcr.study.criteria import (
    SIGMAS, NotTested, at_every_eta, at_xi, format_errors, format_largest, is_monotonic,
    is_within, known, last_negative, minimum, require_finite, slope_of, trend)

claim = PAPER.claim

LONG = (0.01, 1)  # range of η of grains that are not discs

# --- branch vectors and contact types ---------------------------------------------------------


def _mode(l_r, eta, pdf, errors, place):
    """Return position and height of the largest density near a place, and whether it is a mode.

    A mode exceeds, by more than its error, the lowest density on each side between it and the
    middle to the next mode.
    """
    near = np.flatnonzero(np.abs(l_r - place) <= max(0.04, 0.2 * eta) / 2 + 1e-9)
    k = near[np.argmax(pdf[near])]
    left = (l_r > place - eta / 2) & (l_r < l_r[k])
    right = (l_r < place + eta / 2) & (l_r > l_r[k])
    inside = [side & (l_r > 1 - eta) for side in (left, right)]
    error = known(errors[k])
    return l_r[k], pdf[k], all(pdf[k] - pdf[side].min() > error for side in inside if side.any())


def _modes(v, places, sign):
    columns = zip(v["eta"], v["pdf"], v["pdf_error"], places)
    at, heights, stand_out = np.transpose([_mode(v["l_r"], *column) for column in columns])
    agrees = stand_out.all()
    if sign:
        slope, error = slope_of(v["eta"], heights)
        agrees &= sign * slope > SIGMAS * error
    listed = ", ".join(f"{x:.2f} ({height:.2f})" for x, height in zip(at, heights))
    etas = ", ".join(f"{eta:g}" for eta in v["eta"])
    error = f"height {format_largest(v['pdf_error'])}"
    return agrees, f"at ℓ_r (height): {listed} for η = {etas}", error


MODES = dict(etas=(0.2, 1), least=3)
claim("O10", "P(ℓ_r) has a mode at 1 − η that grows with η",
      "a maximum there at every η ≥ 0.2; slope of its height positive beyond two errors", **MODES)(
    lambda v: _modes(v, 1 - v["eta"], +1))
claim("O10", "P(ℓ_r) has a mode near 1 − η/2 that shrinks with η",
      "a maximum there at every η ≥ 0.2; slope of its height negative beyond two errors", **MODES)(
    lambda v: _modes(v, 1 - v["eta"] / 2, -1))
claim("O10", "P(ℓ_r) has a mode near 1", "a local maximum there at every η ≥ 0.2", **MODES)(
    lambda v: _modes(v, np.ones_like(v["eta"]), 0))
claim("O11", "the share of side-side contacts grows with η", "slope positive beyond two errors")(
    lambda v: trend(v, "fraction_ss", +1))


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


SIGN = "at no η the wrong sign by more than two errors"
claim("O12", "C(f, ℓ_r) is positive for η ≤ 0.3, negative above", f"{SIGN} (ℓ_r of discs is 1)")(
    lambda v: _sign_change(v, "c_f_lr"))
claim("O12", "C(f, ℓ) is positive for η ≤ 0.3, negative above", SIGN)(
    lambda v: _sign_change(v, "c_f_l"))


@claim("O12", "C falls to −0.22",
       "smaller of C(f, ℓ_r), C(f, ℓ) at η = 0.7 within 0.05 or two errors", etas=0.7)
def _(v):
    c, error = min((v[name], v[f"{name}_error"]) for name in ("c_f_lr", "c_f_l"))
    return is_within(require_finite(c) + 0.22, 0.05, error), f"{c:.3f}", format_errors(error)


@claim("O13", "force above the mean for side-side contacts, well below it for aligned cap-cap ones",
       "f/⟨f⟩ above 1 in the lowest bin of ℓ_r, below 0.8 in the highest, at η ≥ 0.4",
       etas=(0.4, 1))
def _(v):
    bins = [means[np.isfinite(means)] for means in v["f_l_r"]]
    if not all(map(len, bins)):
        raise NotTested("too few contacts")
    first, last = np.transpose([means[[0, -1]] for means in bins])
    columns = zip(v["eta"], first, last)
    value = ", ".join(f"{one:.2f} and {two:.2f} ({eta:g})" for eta, one, two in columns)
    return ((first > 1) & (last < 0.8)).all(), value, ""


@claim("O13", "mean force rises with ℓ for η ≤ 0.3 and falls above",
       "sign of the slope over the bins of ℓ, at every η")
def _(v):
    sign = _sign_up_to_0_3(v["eta"])
    slopes, errors = np.transpose([slope_of(v["l"], means) for means in v["f_l"]])
    return sign * slopes > 0, slopes, errors


# --- anisotropies and shear stress ------------------------------------------------------------


@claim("O14", "at η = 0.5 P(θ, ξ) has the axis of σ₁ for every ξ",
       "axis of its Fourier fit within 10° or two errors of θσ for each ξ shown", etas=0.5)
def _(v):
    away, error = np.degrees(require_finite(v["off_axis"])), np.degrees(v["off_axis_error"])
    cutoffs = [*(f"{xi:g}" for xi in v["xi"][:-1]), "∞"]
    listed = ", ".join(f"{a:.1f}° (ξ = {xi})" for a, xi in zip(away, cutoffs))
    return is_within(away, 10, error).all(), listed, format_largest(error, "°")


@claim("O14", "at η = 0.5 its anisotropy grows with ξ",
       "the last exceeds the first; none is below the previous one by over two errors", etas=0.5)
def _(v):
    amplitude, error = require_finite(v["amplitude"]), v["amplitude_error"]
    rises = np.diff(amplitude) > -SIGMAS * known(np.hypot(error[1:], error[:-1]))
    agrees = rises.all() and amplitude[-1] > amplitude[0]
    return agrees, ", ".join(f"{a:.2f}" for a in amplitude), format_largest(error)


@claim("O15", "discs: a_c(ξ) negative with its extremum at ξ ≈ 1, then positive",
       "lowest at ξ in [0.7, 1.3] and below 0 by two errors; positive at the end", etas=0)
def _(v):
    (xi, lowest, error), end = minimum(v, "a_c"), v["a_c"][-1]
    agrees = 0.7 <= xi <= 1.3 and lowest < -SIGMAS * known(error) and end > 0
    return agrees, f"{lowest:.3f} at ξ = {xi:.2f}, {end:.3f} at the end", format_errors(error)


@claim("O15", "η > 0: a_c(ξ) positive for every ξ",
       "above 0, or below it by less than two errors, at every ξ ≥ 0.2 and η > 0 "
       "(lowest value given)", LONG)
def _(v):
    value, error = (v[name][:, v["xi"] >= 0.2] for name in ("a_c", "a_c_error"))
    return (value >= -SIGMAS * known(error)).all(axis=1), value.min(axis=1), error


@claim("O15", "a_c = 0.3 at ξ = 1 for long particles", "within 0.05 or two errors at every η ≥ 0.5",
       etas=(0.5, 1))
def _(v):
    value, error = at_xi(v, "a_c")
    return is_within(value - 0.3, 0.05, error), value, error


@claim("O16", "a_ln positive for η ≤ 0.1, negative above",
       "a_ln(∞) at no η of the wrong sign by more than two errors")
def _(v):
    value, error = v["a_ln"][:, -1], v["a_ln_error"][:, -1]
    agrees = np.where(v["eta"] <= 0.1 + 1e-9, 1, -1) * value > -SIGMAS * known(error)
    return agrees, value, error


@claim("O16", "where negative, a_ln has its minimum for ξ in [1, 2]",
       "lowest at a ξ in [0.9, 2.1] for every η ≥ 0.2 (ξ given; searched up to 6)", etas=(0.2, 1))
def _(v):
    xi, _, _ = minimum(v, "a_ln")
    return (xi >= 0.9) & (xi <= 2.1), xi


@claim("O16", "a_lt < 0 and monotonic in ξ",
       "a_lt(∞) < 0; no rise with ξ beyond 10 % of its range or two errors, for η > 0", LONG)
def _(v):
    smooth, _ = is_monotonic(v, "a_lt", -1)
    value = v["a_lt"][:, -1]
    return smooth & (value < 0), value, v["a_lt_error"][:, -1]


@claim("O16 O15", "|a_lt| > |a_ln|, both weak compared with a_c",
       "at ξ = ∞ for every η ≥ 0.2: |a_ln| < |a_lt| < a_c/2 (|a_lt|/|a_ln| given)", etas=(0.2, 1))
def _(v, contacts):
    a_ln, a_lt = (np.abs(v[name][:, -1]) for name in ("a_ln", "a_lt"))
    ratio = np.divide(a_lt, a_ln, out=np.full_like(a_lt, np.nan), where=a_ln > 0)
    return (a_ln < a_lt) & (a_lt < 0.5 * contacts["a_c"][:, -1]), ratio


@claim("O17", "discs: a_fn(ξ) positive",
       "above 0, or below it by less than two errors, at every ξ ≥ 0.2 (lowest given)", etas=0)
def _(v):
    value, error = (v[name][v["xi"] >= 0.2] for name in ("a_fn", "a_fn_error"))
    agrees = (value >= -SIGMAS * known(error)).all()
    return agrees, f"{value.min():.3f}", format_largest(error)


@claim("O17", "η > 0: a_fn(ξ) negative for ξ < 1 with its extremum at ξ = 1",
       "lowest at ξ in [0.9, 1.1] and below 0 by two errors, for every η > 0 (ξ given)", LONG)
def _(v):
    xi, lowest, error = minimum(v, "a_fn")
    return (xi > 0.89) & (xi < 1.11) & (lowest < -SIGMAS * known(error)), xi


@claim("O17", "η > 0: a_fn becomes positive beyond ξ ≈ 2",
       "last change of sign at ξ in [1.5, 3] for every η > 0 (ξ given)", LONG)
def _(v):
    xi = last_negative(v["xi"], v["a_fn"])
    return (xi >= 1.5) & (xi <= 3), xi


claim("O17", "a_ft rises with ξ",
      "no fall with ξ beyond 10 % of its range or two errors, at every η (largest fall given)")(
    lambda v: is_monotonic(v, "a_ft", +1))
claim("O17", "a_ft rises with η", "slope of a_ft(∞) positive beyond two errors")(
    lambda v: trend(v | dict(whole=v["a_ft"][:, -1]), "whole", +1))


@claim("O18", "discs: q(ξ)/p is 0 for ξ < 1",
       "|q(ξ)/p| below 0.02 or two errors for every ξ ≤ 1 (largest given)", etas=0)
def _(v):
    value, error = (v[name][v["xi"] <= 1 + 1e-9] for name in ("q_over_p", "q_over_p_error"))
    agrees = is_within(value, 0.02, error).all()
    return agrees, f"{np.abs(value).max():.3f}", format_largest(error)


@claim("O18", "q/p of the weak network below 0.1",
       "q(1)/p below 0.1, or above it by less than two errors, at every η")
def _(v):
    value, error = at_xi(v, "q_over_p")
    return value - SIGMAS * known(error) < 0.1, value, error


@claim("O18", "half-sum of the anisotropies fits q(ξ)/p at every ξ",
       "difference below 10 % of q(∞)/p at every ξ and η (largest share given)")
def _(v):
    share = np.abs(v["closure"]).max(axis=1) / np.abs(v["q_over_p"][:, -1])
    return share <= 0.1, share
