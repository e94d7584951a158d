"""CEGEO 2012: trimers, rounded-cap rectangles, truncated triangles and elongated hexagons.

Values and trends come from the text, since the data of the figures are not available. The text
gives neither rate nor errors, so the tolerances of "nearly" and "slightly" are ours.
"""

import numpy as np

from rcr.observables.shapes import rows_of_shape
from rcr.study.criteria import (
    SIGMAS, NotTested, format_errors, format_largest, is_within, known, require_finite, slope_of)
from rcr.study.paper import Paper
from rcr.study.protocol import REGULAR_HEXAGON, SHAPE_NAMES

STATEMENTS = dict(
    S1="sin φ* grows with η at the same rate for all shapes; trimers and rounded-cap rectangles "
       "nearly coincide, truncated triangles and elongated hexagons lie slightly above",
    S2="the packing fraction after the compaction has a peak over η considerably above discs; "
       "discs have Z = 4, other shapes Z_c = 6 contact points (sides twice) and Z < 5",
    S3="in the shear Z is 3 to 4 and Z_c 4 to 5; the shares of double and triple contacts of "
       "trimers and of side-side contacts of other shapes grow with η",
    S4="the friction mobilisation M(η)/M(0) − 1 grows with η for all shapes")

PAPER = Paper(
    about="The results are set against CEGEO, <a href='https://arxiv.org/abs/1208.0499'><i>"
          "Particle shape dependence in 2D granular media</i></a>, who sheared packings of 5000 "
          "grains of four shapes with radii up to three times the smallest.",
    statements=STATEMENTS, maps={}, compares=True,
    first=[("S1", "Shear strength and packing fraction of the sheared packings."),
           ("map", "Contact forces at η = {:g}: black above the mean, red up to it; the thicker "
            "the larger."),
           ("S2", "Packing fraction and contact points after the compaction.")])
claim = PAPER.claim

SHAPES = "trimer", "rcr", "truncated", "hexagon"  # A, B, C, D of the paper
ROUND, ANGULAR = SHAPES[:2], SHAPES[2:]
PEAKS = "truncated", "trimer", "hexagon", "rcr"  # by the packing fraction at the peak, rising
FITS = dict(trimer=(1.29, 1.20), rcr=(1.17, 0.20), truncated=(1.30, 1.23), hexagon=(1.14, 0.23))


def curves(v, name, least=3):
    """Return {shape: (η, values, errors)} of the shapes with at least so many elongations."""
    rows = {shape: rows_of_shape(v, shape) for shape in SHAPES if shape in v["shape"]}
    found = {shape: (v["eta"][k], require_finite(v[name][k], "no isotropic.h5"),
                     known(v.get(f"{name}_error", np.full(len(v["eta"]), np.nan))[k]))
             for shape, k in rows.items() if len(k) >= least}
    if not found:
        raise NotTested(f"expected {least} elongations of a shape")
    return found


def _rises(v, name):
    slopes = {s: slope_of(eta, values) for s, (eta, values, _) in curves(v, name).items()}
    agrees = all(slope > SIGMAS * error for slope, error in slopes.values())
    value = ", ".join(f"{slope:.2f} ({SHAPE_NAMES[s]})" for s, (slope, _) in slopes.items())
    return agrees, f"slope {value}", format_errors([error for _, error in slopes.values()])


RISES = "slope positive beyond two errors, for every shape with three elongations"
claim("S1", "sin φ* grows with η", RISES)(lambda v: _rises(v, "sin_phi"))


@claim("S1", "sin φ* grows at the same rate for all shapes",
       "slopes within 25 % of their mean, or two errors")
def _(v):
    found = curves(v, "sin_phi")
    if len(found) < 2:
        raise NotTested("expected two shapes with three elongations")
    slopes, errors = np.transpose([slope_of(eta, y) for eta, y, _ in found.values()])
    mean = slopes.mean()
    value = ", ".join(f"{s:.2f} ({SHAPE_NAMES[n]})" for n, s in zip(found, slopes))
    return is_within(slopes - mean, 0.25 * abs(mean), errors).all(), value, format_errors(errors)


def _differences(v, pair, others):
    """Return η, differences of sin φ* between the means of two groups of shapes, and errors."""
    found = curves(v, "sin_phi", 1)
    if missing := [s for s in (*pair, *others) if s not in found]:
        raise NotTested(f"no {SHAPE_NAMES[missing[0]]}")
    groups = [[found[s] for s in group] for group in (pair, others)]
    etas = [eta for eta in groups[0][0][0] if eta >= REGULAR_HEXAGON - 1e-9 or others[0] in ROUND]
    near = [eta for eta in etas if eta > 0 and all(
        np.abs(one[0] - eta).min() < 0.02 for group in groups for one in group)]
    if not near:
        raise NotTested("the shapes have no common elongation")
    at = np.array([[[(one[1][k], one[2][k]) for one in group
                     for k in [np.argmin(np.abs(one[0] - eta))]] for group in groups]
                   for eta in near], dtype=float)
    values, errors = at[..., 0].mean(axis=2), np.sqrt((at[..., 1] ** 2).mean(axis=2).sum(axis=1))
    return np.array(near), values[:, 1] - values[:, 0], errors


def _coincide(v, one, two):
    eta, away, error = _differences(v, (one,), (two,))
    value = ", ".join(f"{d:+.3f} ({e:.2g})" for d, e in zip(away, eta))
    return is_within(away, 0.03, error).all(), value, format_largest(error)


claim("S1", "trimers and rounded-cap rectangles nearly coincide",
      "sin φ* within 0.03 or two errors at every common η > 0")(lambda v: _coincide(v, *ROUND))
claim("S1", "truncated triangles and elongated hexagons nearly coincide",
      "sin φ* within 0.03 or two errors at every common η")(lambda v: _coincide(v, *ANGULAR))


@claim("S1", "angular shapes lie slightly above round ones",
       "mean difference of sin φ* over the common η from 0 to 0.08")
def _(v):
    eta, above, error = _differences(v, ROUND, ANGULAR)
    mean = above.mean()
    value = ", ".join(f"{d:+.3f} ({e:.2g})" for d, e in zip(above, eta))
    return 0 < mean < 0.08, f"mean {mean:+.3f}: {value}", format_largest(error)


@claim("S1", "sin φ has a peak before it relaxes to a constant",
       "the largest sin φ, averaged over 0.01 of strain, exceeds the mean by more than two errors")
def _(v):
    over = require_finite(v["sin_phi_peak"], "no history") - v["sin_phi"]
    return (over > SIGMAS * known(v["sin_phi_error"])).all(), f"by {over.min():.3f} or more", ""


@claim("S2", "the packing fraction has its peak between the ends of η, considerably above discs",
       "each shape with four elongations or more: largest inside, by 0.01 above the first value")
def _(v):
    found = curves(v, "packing_fraction", 4)
    tops = {s: int(np.argmax(y)) for s, (_, y, _) in found.items()}
    agrees = all(0 < k < len(found[s][0]) - 1 and found[s][1][k] > found[s][1][0] + 0.01
                 for s, k in tops.items())
    value = ", ".join(f"{found[s][1][k]:.3f} at η = {found[s][0][k]:.2g} ({SHAPE_NAMES[s]})"
                      for s, k in tops.items())
    return agrees, value, format_largest(v["packing_fraction_error"])


@claim("S2", "the peaks rise in the order " + ", ".join(SHAPE_NAMES[s] for s in PEAKS),
       "in this order, of all four shapes")
def _(v):
    found = curves(v, "packing_fraction", 4)
    if missing := [SHAPE_NAMES[s] for s in PEAKS if s not in found]:
        raise NotTested(f"expected four elongations of {', '.join(missing)}")
    tops = [found[s][1].max() for s in PEAKS]
    return bool(np.all(np.diff(tops) > 0)), ", ".join(f"{top:.4f}" for top in tops), ""


def self_filling(shape, eta):
    """Return ν(η), the share of the circumscribed circle that a grain fills, (N,) [eq. 4]."""
    inner = 1 - eta
    if shape == "rcr":
        return inner**2 + 4 * eta * inner / np.pi
    if shape == "trimer":
        s = eta * (2 - eta) / (1 + eta)
        turn = np.arctan2(inner * np.sqrt(0.75), inner / 2 - s)
        return 3 * ((1 - s) ** 2 * turn + s * (1 - s) * np.sin(turn)) / np.pi
    if shape == "hexagon":
        return 2 * inner * (2 - inner / np.sqrt(3)) / np.pi
    half = np.arccos(inner)  # from the normal of a long side to its corners
    return 1.5 * (np.sin(2 * half) + np.sin(2 * np.pi / 3 - 2 * half)) / np.pi


def fit(shape, eta, fraction):
    """Return α, β and the largest residual of the packing fraction fitted by eqs. (6) and (7).

    h = α x − β x² with x = η − η₀ reproduces the axes of the paper's figure 8; its eq. (7) has +β.
    ν is over ν(η₀), so that both sides of eq. (6) agree at the first elongation η₀.
    """
    x, filling = eta - eta[0], self_filling(shape, eta) / self_filling(shape, eta[0])
    h = (1 - filling * fraction[0] / fraction) / fraction[0]
    (alpha, beta), *_ = np.linalg.lstsq(np.column_stack([x, -(x**2)])[1:], h[1:], rcond=None)
    model = filling * fraction[0] / (1 - (alpha * x - beta * x**2) * fraction[0])
    return alpha, beta, np.abs(model - fraction).max()


@claim("S2", "ρ = ν ρ₀/(1 − h ρ₀) with h = α (η − η₀) − β (η − η₀)² fits the packing fraction",
       "residuals up to 0.005 at every shape with four elongations (α, β; the paper's in brackets)")
def _(v):
    found = curves(v, "packing_fraction", 4)
    fits = {s: fit(s, eta, y) for s, (eta, y, _) in found.items()}
    value = "; ".join(f"{SHAPE_NAMES[s]} {a:.2f}, {b:.2f} ({FITS[s][0]:g}, {FITS[s][1]:g}), "
                      f"residual {away:.4f}" for s, (a, b, away) in fits.items())
    return all(away <= 0.005 for *_, away in fits.values()), value, ""


@claim("S2", "frictionless packings: Z = Z_c = 4 for discs, Z_c = 6 for other shapes",
       "Z_c within 5 % at every row with η = 0 or η ≥ 0.1")
def _(v):
    measured = require_finite(v["contact_points"], "no isotropic.h5")
    rows = np.flatnonzero((v["eta"] == 0) | (v["eta"] >= 0.1))
    away = measured[rows] / np.where(v["eta"][rows] == 0, 4, 6) - 1
    value = f"Z_c {measured[rows].min():.2f} to {measured[rows].max():.2f}"
    return (np.abs(away) <= 0.05).all(), value, format_largest(v["contact_points_error"][rows])


@claim("S2", "frictionless packings: Z < 5 for all shapes", "at every row")
def _(v):
    Z = require_finite(v["neighbors"], "no isotropic.h5")
    return (Z < 5).all(), f"Z {Z.min():.2f} to {Z.max():.2f}", format_largest(v["neighbors_error"])


@claim("S3", "in the shear Z is 3 to 4 and Z_c 4 to 5", "within 0.1 at every row with η > 0")
def _(v):
    rows = v["eta"] > 0
    if not rows.any():
        raise NotTested("there are discs only")
    Z, points = v["neighbors"][rows], v["contact_points"][rows]
    agrees = (np.abs(Z - 3.5) <= 0.6) & (np.abs(points - 4.5) <= 0.6)
    value = f"Z {Z.min():.2f} to {Z.max():.2f}, Z_c {points.min():.2f} to {points.max():.2f}"
    return agrees.all(), value, format_largest(v["contact_points_error"][rows])


claim("S3", "the share of multiple contacts (trimers) and of side-side contacts grows with η",
      RISES)(lambda v: _rises(v, "multiple_fraction"))
claim("S4", "the friction mobilisation grows with η", RISES)(
    lambda v: _rises(v, "friction_mobilization"))
