"""Estrada, Azéma, Radjaï and Taboada 2011: discs with rolling friction against regular polygons.

The text beyond the abstract was not available. The relation between sides and rolling friction is
derived here from the argument of the abstract. Statements on the number of sides are from the
abstract of Azéma, Estrada and Radjaï, *Nonlinear effects of particle shape angularity in sheared
granular media* (2012); that on two regimes is from the abstract of Estrada, Taboada and Radjaï,
Phys. Rev. E 78 (2008) 021301. Tolerances are ours.
"""

import numpy as np

from rcr.observables.shapes import rows_of_shape
from rcr.study.criteria import (
    SIGMAS, NotTested, format_largest, is_within, known, require_finite, slope_of)
from rcr.study.paper import Paper


def equivalent_rolling_friction(sides):
    """Return µ_r = n (1 − cos π/n)/(4 π) of a disc that dissipates as much as a polygon [-].

    A polygon of n sides and radius R rolls over flat sides under a force f: its centre rises by
    R (1 − cos π/n) at each corner, and an inelastic impact takes this work. A disc with the moment
    µ_r (R₁ + R₂) f = 2 µ_r R f loses 2 µ_r R f · 2π/n in the same turn.
    """
    sides = np.asarray(sides, float)
    return sides * (1 - np.cos(np.pi / sides)) / (4 * np.pi)


def rolling_friction(value):
    """Return µ_r of discs and the equivalent one of polygons, (kinds,) [-]."""
    sides = np.asarray(value["sides"])
    equivalent = equivalent_rolling_friction(np.maximum(sides, 3))
    return np.where(sides > 0, equivalent, value["rolling_friction"])


STATEMENTS = dict(
    S1="polygons have the shear strength and the packing fraction of discs with the rolling "
       "friction that dissipates as much; both saturate",
    S5="they have the anisotropies of these discs; triangles to pentagons have a small anisotropy "
       "of contacts and a large one of tangential forces",
    S6="they have the distribution of forces of these discs")

PAPER = Paper(
    about="The results are set against the abstract of Estrada, Azéma, Radjaï and Taboada, "
          "<a href='https://arxiv.org/abs/1105.4418'><i>Identification of rolling resistance as a "
          "shape parameter in sheared granular media</i></a>. A polygon of n sides is set against "
          "discs with µ_r = n (1 − cos π/n)/(4 π), which is derived here.",
    statements=STATEMENTS, maps={}, compares=True, abscissa=rolling_friction,
    abscissa_label=r"$\mu_r$",
    first=[("S1", "Shear strength and packing fraction; polygons at the rolling friction of discs "
            "that dissipate as much."),
           ("map", "Contact forces at η = {:g}: black above the mean, red up to it; the thicker "
            "the larger."),
           ("S5", "Anisotropies of contact normals, branch vectors and forces."),
           ("S6", "How often a normal force of a given size occurs; the mean is 1.")])
claim = PAPER.claim


def of_discs(v, name, at):
    """Return values and errors of discs at rolling frictions `at`, interpolated."""
    rows = [k for k in rows_of_shape(v, "rcr") if v["eta"][k] == 0]
    if len(rows) < 3:
        raise NotTested(f"expected discs with three rolling frictions, there are {len(rows)}")
    x, y = v["rolling_friction"][rows], require_finite(v[name][rows])
    if at.min() < x[0] - 1e-9 or at.max() > x[-1] + 1e-9:
        raise NotTested(f"µ_r from {at.min():.3g} to {at.max():.3g} is expected, discs have "
                        f"{x[0]:g} to {x[-1]:g}")
    return np.interp(at, x, y), np.interp(at, x, known(v[f"{name}_error"][rows]))


def polygons(v, name, least=1):
    """Return sides, falling, values and errors of polygons."""
    rows = rows_of_shape(v, "regular")
    if len(rows) < least:
        raise NotTested(f"expected {least} numbers of sides, there are {len(rows)}")
    return v["sides"][rows], require_finite(v[name][rows]), known(v[f"{name}_error"][rows])


def _same(v, name, tolerance):
    """Test whether polygons have the value of discs with the equivalent rolling friction."""
    sides, value, error = polygons(v, name)
    discs, error_of_discs = of_discs(v, name, equivalent_rolling_friction(sides))
    error = np.hypot(error, error_of_discs)
    listed = ", ".join(f"{a:.3g} and {b:.3g} ({n} sides)" for a, b, n in zip(value, discs, sides))
    return is_within(value - discs, tolerance, error).all(), listed, format_largest(error)


for key, name, text, tolerance in (
        ("S1", "sin_phi", "the same shear strength", 0.03),
        ("S1", "packing_fraction", "the same packing fraction", 0.01),
        ("S5", "a_c", "the same anisotropy of contacts", 0.05),
        ("S5", "a_fn", "the same anisotropy of normal forces", 0.05),
        ("S5", "a_ft", "the same anisotropy of tangential forces", 0.03),
        ("S6", "alpha_n", "the same exponent of strong forces", 0.15),
        ("S6", "beta_n", "the same exponent of weak forces", 0.1),
        ("S6", "weak_fraction", "the same share of weak contacts", 0.02)):
    claim(key, f"polygons and discs with the equivalent µ_r have {text}",
          f"within {tolerance:g} or two errors at every number of sides (polygons and discs)")(
        lambda v, name=name, tolerance=tolerance: _same(v, name, tolerance))


@claim("S1", "shear strength and packing fraction identify the same µ_r",
       "µ_r of discs with the sin φ* and with the packing fraction of the polygons within a factor "
       "of two, at every number of sides up to which both vary")
def _(v):
    found = []
    for name in ("sin_phi", "packing_fraction"):
        rows = [k for k in rows_of_shape(v, "rcr") if v["eta"][k] == 0]
        if len(rows) < 4:
            raise NotTested("expected discs with four rolling frictions")
        x, y = v["rolling_friction"][rows], v[name][rows]
        sides, value, _ = polygons(v, name)
        sign = np.sign(y[-1] - y[0])
        rising = np.maximum.accumulate(sign * y)
        inside = (sign * value > rising[0]) & (sign * value < rising[-1])
        found.append(np.where(inside, np.interp(sign * value, rising, x), np.nan))
    both = np.isfinite(found).all(axis=0)
    if not both.any():
        raise NotTested("no polygon lies between the discs in both")
    one, two = np.array(found)[:, both]
    listed = ", ".join(f"{a:.3f} and {b:.3f} ({n} sides)" for a, b, n in zip(one, two, sides[both]))
    return (np.abs(np.log2(one / two)) <= 1).all(), listed, ""


@claim("S1", "the strength of polygons rises as they lose sides, and saturates below six",
       "slope over the sides' µ_r positive beyond two errors from six sides on; triangles to "
       "hexagons within 0.02 of their mean or two errors")
def _(v):
    sides, value, error = polygons(v, "sin_phi", 4)
    few, many = sides <= 6, sides >= 6
    if few.sum() < 2:
        raise NotTested("expected two polygons of six sides or fewer")
    slope, of_slope = slope_of(equivalent_rolling_friction(sides[many]), value[many])
    away = value[few] - value[few].mean()
    listed = ", ".join(f"{y:.3f} ({n} sides)" for y, n in zip(value, sides))
    saturates = is_within(away, 0.02, error[few]).all()
    return slope > SIGMAS * of_slope and saturates, listed, format_largest(error)


@claim("S1", "the packing fraction of polygons falls towards a constant as they lose sides",
       "lower at the fewest sides than at the most, and change from six sides on less than half as "
       "large as before")
def _(v):
    sides, value, error = polygons(v, "packing_fraction", 4)
    if sides[-1] >= 6 or sides[0] <= 6:
        raise NotTested("expected polygons with fewer and with more than six sides")
    six = np.interp(6, sides[::-1], value[::-1])
    listed = ", ".join(f"{y:.3f} ({n} sides)" for y, n in zip(value, sides))
    falls = value[-1] < value[0] and abs(six - value[-1]) < 0.5 * abs(value[0] - six)
    return falls, listed, format_largest(error)


@claim("S5", "below six sides the anisotropies of contacts and normal forces fall, that of "
       "tangential forces rises",
       "a_c and a_fn of the fewest sides below their largest values, a_ft of the fewest sides the "
       "largest of all")
def _(v):
    values = {name: polygons(v, name, 4)[1] for name in ("a_c", "a_fn", "a_ft")}
    if v["sides"][v["sides"] > 0].min() >= 6:
        raise NotTested("expected polygons with fewer than six sides")
    drops = [values[name].max() - values[name][-1] for name in ("a_c", "a_fn")]
    grows = values["a_ft"].argmax() == len(values["a_ft"]) - 1
    value = f"a_c falls by {drops[0]:.3f}, a_fn by {drops[1]:.3f}; a_ft {values['a_ft'][-1]:.3f}"
    return min(drops) > 0 and grows, value, ""


@claim("S1", "two regimes: the strength of discs rises with µ_r, then saturates",
       "change of sin φ* beyond half the largest µ_r less than half of that before")
def _(v):
    largest = v["rolling_friction"].max()
    ends = np.array([0, largest / 2, largest])
    (low, middle, high), error = of_discs(v, "sin_phi", ends)
    value = f"{low:.3f} → {middle:.3f} → {high:.3f} (µ_r = 0, {ends[1]:g}, {largest:g})"
    return middle > low and abs(high - middle) < 0.5 * (middle - low), value, format_largest(error)
