"""Criteria of statements on strength, compaction, forces and friction (O1 to O9)."""

import numpy as np

from rcr.papers.azema_radjai_2011 import PAPER
from rcr.statistics import pearson
from rcr.study.criteria import (
    SIGMAS, NotTested, at_both_ends, at_every_eta, format_errors, is_within, list_by_eta,
    require_finite, row_of, rows_of, slope_of, trend)

claim = PAPER.claim

# --- strength and compaction ------------------------------------------------------------------


@claim("O1", "sin φ = 0.30 + 0.30 η at the critical state", "within 0.02 or two errors at every η")
def _(v):
    away = v["sin_phi"] - PAPER.strength(v["eta"])
    return is_within(away, 0.02, v["sin_phi_error"]), v["sin_phi"], v["sin_phi_error"]


@claim("O2", "P(θ) is isotropic after compaction",
       "|a_c| below 0.05, or below three standard deviations for the same number of random "
       "directions")
def _(v):
    a_c, error = require_finite(v["a_c"], "no isotropic.h5"), v["a_c_error"]
    return a_c <= np.maximum(0.05, 3 * error), a_c, error


@claim("O2", "frictionless packings are isostatic: Z = 4 for discs, Z_c = 6 for long particles "
       "(each ss twice)", "within 5 %, η = 0 and η ≥ 0.3")
def _(v):
    rows = [*rows_of(v, 0, 0, 0), *rows_of(v, 0.3, 1, 0)]
    if not rows or not np.isfinite(v["coordination_number_twice"]).all():
        raise NotTested("no isotropic state of these elongations")
    measured, expected = v["coordination_number_twice"][rows], np.where(v["eta"][rows] == 0, 4, 6)
    return at_every_eta(v["eta"][rows], np.abs(measured / expected - 1) <= 0.05, measured)


@claim("O2", "packing fraction after compaction has its peak near η = 0.4",
       "largest at an η in [0.3, 0.5]")
def _(v):
    for low, high in ((0, 0.2), (0.3, 0.5), (0.6, 1)):
        rows_of(v, low, high)
    fraction = require_finite(v["packing_fraction"], "no isotropic.h5")
    densest = v["eta"][np.argmax(fraction)]
    return 0.3 - 1e-9 <= densest <= 0.5 + 1e-9, list_by_eta(v["eta"], fraction, 3), ""


# --- forces and friction ----------------------------------------------------------------------


claim("O3", "α_n falls with η", "slope negative beyond two errors")(
    lambda v: trend(v, "alpha_n", -1))
claim("O3", "β_n from 0.1 (η = 0) to −0.4 (η = 0.7)", "both within 0.1 or two errors")(
    lambda v: at_both_ends(v, "beta_n", 0.1, -0.4, 0.1))
claim("O3", "share of weak contacts from 60 % (η = 0) to 70 % (η = 0.7)",
      "both within 0.03 or two errors")(lambda v: at_both_ends(v, "weak_fraction", 0.6, 0.7, 0.03))


def _saturates(v, name):
    falls, _, error = trend(v, name, -1, 0, 0.4)
    first, middle, last = require_finite(
        np.array([v[name][row_of(v, eta)] for eta in (0, 0.4, 0.7)]))
    saturates = abs(last - middle) < 0.5 * abs(middle - first)
    value = f"{first:.3g} → {middle:.3g} → {last:.3g} (η = 0, 0.4, 0.7)"
    return falls and saturates, value, error


SATURATES = ("slope up to η = 0.4 negative beyond two errors; beyond, a change less than half as "
             "large")
claim("O4", "α_t falls with η and saturates beyond 0.4", SATURATES)(
    lambda v: _saturates(v, "alpha_t"))
claim("O4", "β_t falls with η and saturates beyond 0.4", SATURATES)(
    lambda v: _saturates(v, "beta_t"))
claim("O5", "I_M from 0.4 (η = 0) to 0.6 (η = 0.7)", "both within 0.05 or two errors")(
    lambda v: at_both_ends(v, "friction_mobilization", 0.4, 0.6, 0.05))


@claim("O6 O5 O3", "mobilised contacts (I_m > 0.99) belong mostly to the weak network",
       "the share of weak contacts is larger among mobilised contacts than among all, at every η")
def _(_, v, forces):
    share = require_finite(v["mobilized_weak_share"], "no mobilised contact at some η")
    return share > forces["weak_fraction"], share, v["mobilized_weak_share_error"]


def _force_levels(v):
    """Return mean I_mf of the weak bins, f_n in [0.1, 1], and the strong ones, [1, 4]; (2, η)."""
    levels = [(v["f_n"] > 0.1) & (v["f_n"] < 1), (v["f_n"] > 1) & (v["f_n"] < 4)]
    used = [np.isfinite(v["i_mf"]) & level for level in levels]
    count = require_finite(np.where(np.array(used).any(axis=2), np.sum(used, axis=2), np.nan))
    return np.array([np.where(level, v["i_mf"], 0).sum(axis=1) for level in used]) / count


@claim("O7", "I_mf falls with f_n",
       "I_mf of strong bins below that of weak bins, at every η (difference given)")
def _(v):
    weak, strong = _force_levels(v)
    return strong < weak, strong - weak


@claim("O7", "I_mf rises with η at every force",
       "slope with η positive beyond two errors, for weak and for strong bins")
def _(v):
    slopes, errors = np.transpose([slope_of(v["eta"], level) for level in _force_levels(v)])
    value = "slope {:.2g} (weak), {:.2g} (strong)".format(*slopes)
    return (slopes > SIGMAS * errors).all(), value, format_errors(errors)


@claim("O8", "discs: P(I_m) falls nearly linearly",
       "straight line through all bins: slope negative, r² ≥ 0.8", etas=0)
def _(v):
    i_m, pdf = v["i_m"], v["pdf"]
    r2, inner_r2 = (require_finite(pearson(i_m[:end], pdf[:end])) ** 2 for end in (None, -1))
    (slope, error), (inner, _) = slope_of(i_m, pdf), slope_of(i_m[:-1], pdf[:-1])
    without = f"without the last bin (P = {pdf[-1]:.2f}): slope {inner:.2f}, r² {inner_r2:.2f}"
    value = f"slope {slope:.2f}, r² {r2:.2f}; {without}"
    return slope < 0 and r2 >= 0.8, value, f"slope {error:.1g}"


@claim("O8", "long particles: a bin of contacts close to I_m = 1 stands out",
       "P of the last bin exceeds twice the mean of the others, at the largest η (0.5 or more)",
       etas=(0.5, 1))
def _(v):
    last, others = v["pdf"][-1, -1], v["pdf"][-1, :-1].mean()
    value = f"{last:.2f} against {others:.2f} (η = {v['eta'][-1]:g})"
    return last > 2 * others, value, format_errors(v["pdf_error"][-1, -1])


@claim("O9", "chains of particles with side-side contacts, of like orientation",
       "judged by eye")
def _(v):
    raise NotTested("nobody has judged the map")
