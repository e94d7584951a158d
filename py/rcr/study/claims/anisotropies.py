"""Statements of the paper on anisotropies and shear stress (O14 to O18)."""

import numpy as np

from rcr.study.claims.criteria import (
    SIGMAS, at_every_eta, at_xi, claim, format_errors, format_largest, is_monotonic, is_within,
    known, minimum, require_finite, row_of, rows_of, trend,
)  # fmt: skip


@claim("O14", "at η = 0.5 P(θ, ξ) has the axis of σ₁ for every ξ",
       "axis of its Fourier fit within 10° or two errors of θσ for each ξ shown")
def _(v):
    row = row_of(v, 0.5)
    away = np.degrees(require_finite(v["off_axis"][row]))
    error = np.degrees(v["off_axis_error"][row])
    cutoffs = [*(f"{xi:g}" for xi in v["xi"][:-1]), "∞"]
    listed = ", ".join(f"{a:.1f}° (ξ = {xi})" for a, xi in zip(away, cutoffs))
    return is_within(away, 10, error).all(), listed, f"{format_largest(error)}°"


@claim("O14", "at η = 0.5 its anisotropy grows with ξ",
       "amplitude of each ξ shown not below that of the one before by two errors")
def _(v):
    row = row_of(v, 0.5)
    amplitude, error = require_finite(v["amplitude"][row]), known(v["amplitude_error"][row])
    rises = np.diff(amplitude) > -SIGMAS * np.hypot(error[1:], error[:-1])
    agrees = rises.all() and amplitude[-1] > amplitude[0]
    return agrees, ", ".join(f"{a:.2f}" for a in amplitude), format_largest(error)


@claim("O15", "discs: a_c(ξ) negative with its extremum at ξ ≈ 1, then positive",
       "lowest at ξ in [0.7, 1.3] and below 0 by two errors; positive at the end")
def _(v):
    row = row_of(v, 0)
    xi, lowest, error = minimum(v, "a_c", row)
    end = v["a_c"][row, -1]
    agrees = 0.7 <= xi <= 1.3 and lowest < -SIGMAS * error and end > 0
    return agrees, f"{lowest:.3f} at ξ = {xi:.2f}, {end:.3f} at the end", format_errors(error)


@claim("O15", "η > 0: a_c(ξ) positive for every ξ",
       "not below 0 by two errors at any ξ ≥ 0.2, for every η > 0 (lowest value given)")
def _(v):
    rows = rows_of(v, 0.01, 1)
    value, error = (v[name][rows][:, v["xi"] >= 0.2] for name in ("a_c", "a_c_error"))
    agrees = (value >= -SIGMAS * known(error)).all(axis=1)
    return at_every_eta(v["eta"][rows], agrees, value.min(axis=1), error)


@claim("O15", "a_c = 0.3 at ξ = 1 for long particles", "within 0.05 or two errors at every η ≥ 0.5")
def _(v):
    rows = rows_of(v, 0.5, 1)
    value, error = at_xi(v, "a_c", 1, rows)
    return at_every_eta(v["eta"][rows], is_within(value - 0.3, 0.05, error), value, error)


@claim("O16", "a_ln positive for η ≤ 0.1, negative above",
       "sign of a_ln(∞), within two errors, at every η")
def _(v):
    value, error = v["a_ln"][:, -1], known(v["a_ln_error"][:, -1])
    expected = np.where(v["eta"] <= 0.1 + 1e-9, 1, -1)
    return at_every_eta(v["eta"], expected * value > -SIGMAS * error, value, error)


@claim("O16", "where negative, a_ln has its peak for ξ in [1, 2]",
       "lowest at ξ in [0.9, 2.1] for every η ≥ 0.2 (ξ given; 6 ends the search)")
def _(v):
    rows = rows_of(v, 0.2, 1)
    xi = np.array([minimum(v, "a_ln", row)[0] for row in rows])
    return at_every_eta(v["eta"][rows], (xi >= 0.9) & (xi <= 2.1), xi)


@claim("O16", "a_lt < 0 and monotonic in ξ",
       "a_lt(∞) < 0; steps back below 10 % of its range or two errors, for every η > 0")
def _(v):
    rows = rows_of(v, 0.01, 1)
    smooth, _ = is_monotonic(v, "a_lt", -1, rows)
    value = v["a_lt"][rows, -1]
    return at_every_eta(v["eta"][rows], smooth & (value < 0), value, v["a_lt_error"][rows, -1])


@claim("O16 O15", "|a_lt| > |a_ln|, both weak compared with a_c",
       "at ξ = ∞ for every η ≥ 0.2: |a_ln| < |a_lt| < a_c/2 (|a_lt|/|a_ln| given)")
def _(v, contacts):
    rows = rows_of(v, 0.2, 1)
    a_ln, a_lt = (np.abs(v[name][rows, -1]) for name in ("a_ln", "a_lt"))
    ratio = np.divide(a_lt, a_ln, out=np.full_like(a_lt, np.nan), where=a_ln > 0)
    agrees = (a_ln < a_lt) & (a_lt < 0.5 * contacts["a_c"][rows, -1])
    return at_every_eta(v["eta"][rows], agrees, ratio)


@claim("O17", "discs: a_fn(ξ) positive",
       "not below 0 by two errors at any ξ ≥ 0.2 (lowest value given)")
def _(v):
    row, seen = row_of(v, 0), v["xi"] >= 0.2
    value, error = v["a_fn"][row, seen], known(v["a_fn_error"][row, seen])
    return (value >= -SIGMAS * error).all(), f"{value.min():.3f}", format_largest(error)


@claim("O17", "η > 0: a_fn(ξ) negative for ξ < 1 with its extremum at ξ = 1",
       "lowest at ξ in [0.9, 1.1] and below 0 by two errors, for every η > 0 (ξ given)")
def _(v):
    rows = rows_of(v, 0.01, 1)
    xi, lowest, error = np.array([minimum(v, "a_fn", row) for row in rows]).T
    return at_every_eta(v["eta"][rows], (xi > 0.89) & (xi < 1.11) & (lowest < -SIGMAS * error), xi)


@claim("O17", "η > 0: a_fn becomes positive beyond ξ ≈ 2",
       "last change of sign at ξ in [1.5, 3] for every η > 0 (ξ given)")
def _(v):
    rows = rows_of(v, 0.01, 1)
    negative = [np.flatnonzero(v["a_fn"][row] < 0) for row in rows]
    xi = np.array([v["xi"][k[-1]] if len(k) else 0 for k in negative])
    return at_every_eta(v["eta"][rows], (xi >= 1.5) & (xi <= 3), xi)


@claim("O17", "a_ft rises with ξ",
       "steps back below 10 % of its range or two errors, at every η (largest given)")
def _(v):
    smooth, back = is_monotonic(v, "a_ft", +1, range(len(v["eta"])))
    return at_every_eta(v["eta"], smooth, back)


@claim("O17", "a_ft rises with η", "slope of a_ft(∞) positive beyond two errors")
def _(v):
    return trend(v | dict(whole=v["a_ft"][:, -1]), "whole", +1)


@claim("O18", "discs: q(ξ)/p is 0 for ξ < 1",
       "|q(ξ)/p| below 0.02 or two errors for every ξ ≤ 1 (largest given)")
def _(v):
    row, weak = row_of(v, 0), v["xi"] <= 1 + 1e-9
    value, error = np.abs(v["q_over_p"][row, weak]), v["q_over_p_error"][row, weak]
    return is_within(value, 0.02, error).all(), f"{value.max():.3f}", format_largest(error)


@claim("O18", "q/p of the weak network below 0.1",
       "q(1)/p below 0.1 or two errors above it, at every η")
def _(v):
    value, error = at_xi(v, "q_over_p", 1)
    return at_every_eta(v["eta"], value - SIGMAS * error < 0.1, value, error)


@claim("O18", "half-sum of the anisotropies fits q(ξ)/p at every ξ",
       "difference below 10 % of q(∞)/p at every ξ and η (largest share given)")
def _(v):
    share = np.abs(v["closure"]).max(axis=1) / np.abs(v["q_over_p"][:, -1])
    return at_every_eta(v["eta"], share <= 0.1, share)
