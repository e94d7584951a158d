"""Parts of the criteria by which statements of the paper are tested. Needs NumPy.

A criterion is a function of the values {name: array} of an observable. It returns whether the
statement agrees, the measured value and its error: texts, or arrays with a row for each elongation.
It raises `NotTested` where the data do not suffice.
"""

import numpy as np

from rcr.statistics import common_slope

SIGMAS = 2  # standard errors that a deviation may have by chance


class NotTested(Exception):
    """Raised where the data do not suffice; the message is the reason."""


def row_of(v, eta):
    """Return the index of an elongation."""
    index = int(np.argmin(np.abs(v["eta"] - eta)))
    if abs(v["eta"][index] - eta) > 0.02:
        raise NotTested(f"no run of η = {eta:g}")
    return index


def rows_of(v, low, high, least=1):
    """Return the indices of the elongations within [low, high], at least `least`."""
    rows = np.flatnonzero((v["eta"] >= low - 1e-9) & (v["eta"] <= high + 1e-9))
    if len(rows) < least:
        plural = "s" * (least > 1)
        raise NotTested(
            f"expected {least} elongation{plural} in [{low:g}, {high:g}], there are {len(rows)}")
    return rows


def at_xi(v, name, xi=1):
    """Return values and errors at the cutoff nearest to ξ."""
    k = int(np.argmin(np.abs(v["xi"] - xi)))
    return v[name][:, k], v[f"{name}_error"][:, k]


def minimum(v, name):
    """Return ξ, value and error of the lowest point of each function of ξ ≤ 6."""
    k = np.argmin(v[name][..., v["xi"] <= 6], axis=-1)
    place = (*np.indices(k.shape, sparse=True), k)
    return v["xi"][k], v[name][place], v[f"{name}_error"][place]


def last_negative(xi, values):
    """Return the last ξ at which each function of ξ, (…, len(xi)), is negative; 0 if none."""
    return np.max(np.where(values < 0, xi, 0), axis=-1)


def require_finite(values, reason="too few contacts"):
    """Return the values; raise NotTested with a reason if one is NaN."""
    if not np.isfinite(values).all():
        raise NotTested(reason)
    return values


def is_steady(change, error):
    """Return whether a change over the averaged strains is at most `SIGMAS` of its errors."""
    return abs(change) <= SIGMAS * error


def known(error):
    """Return the errors, with 0 for unknown ones: then the tolerance alone counts."""
    return np.nan_to_num(error)


def is_within(deviation, tolerance, error):
    """Test whether deviations are within a tolerance or two errors, whichever is wider."""
    return np.abs(deviation) <= np.maximum(tolerance, SIGMAS * known(error))


def slope_of(x, y):
    """Return the slope of a straight line, and its standard error from the scatter about it."""
    keep = np.isfinite(y)
    if keep.sum() < 3:
        raise NotTested(f"expected at least three values for a trend, there are {keep.sum()}")
    return common_slope([(x[keep], y[keep])])


def trend(v, name, sign, low=0, high=1):
    """Test whether a value rises (sign +1) or falls (−1) with η."""
    rows = rows_of(v, low, high, 3)
    slope, error = slope_of(v["eta"][rows], v[name][rows])
    first, last = require_finite(v[name][rows[[0, -1]]])
    low, high = v["eta"][rows[[0, -1]]]
    value = f"{first:.3g} → {last:.3g} (η = {low:g} → {high:g})"
    return sign * slope > SIGMAS * error, value, f"slope {slope:.2g} ± {format_errors(error)}"


def is_monotonic(v, name, sign):
    """Test whether functions of ξ rise (sign +1) or fall (−1) for 0.2 ≤ ξ ≤ 6.

    The largest step back must be below two errors or 10 % of the range. Returns the verdicts and
    the largest steps back, (η,) each.
    """
    keep = (v["xi"] >= 0.2) & (v["xi"] <= 6)
    curves, errors = sign * v[name][:, keep], known(v[f"{name}_error"][:, keep])
    back = np.max(np.maximum.accumulate(curves, axis=1) - curves, axis=1)
    allowed = np.maximum(0.1 * np.ptp(curves, axis=1), SIGMAS * errors.max(axis=1))
    return back <= allowed, back


def at_both_ends(v, name, low, high, tolerance):
    """Test the values at η = 0 and 0.7 against those of the paper."""
    rows = [row_of(v, 0), row_of(v, 0.7)]
    value, error = require_finite(v[name][rows]), v[f"{name}_error"][rows]
    agrees = is_within(value - (low, high), tolerance, error).all()
    return agrees, f"{value[0]:.3g} → {value[1]:.3g}", format_errors(error)


def at_every_eta(etas, agrees, values, errors=None):
    """Combine verdicts on several elongations; list the value of each, with η in brackets."""
    off = ", ".join(f"{eta:g}" for eta, agreed in zip(etas, agrees) if not agreed)
    value = list_by_eta(etas, require_finite(values)) + (f"; off at η = {off}" if off else "")
    return not off, value, "" if errors is None else format_largest(errors)


def list_by_eta(etas, values, digits=2):
    """Return values as a text, with η in brackets."""
    return ", ".join(f"{value:.{digits}f} ({eta:g})" for value, eta in zip(values, etas))


def format_errors(error):
    """Return errors as a text."""
    return ", ".join("unknown" if np.isnan(e) else f"{e:.1g}" for e in np.atleast_1d(error))


def format_largest(errors, unit=""):
    """Return the largest error as a text, and whether some or all are unknown."""
    errors = np.asarray(errors, float)
    finite = errors[np.isfinite(errors)]
    if not len(finite):
        return "unknown"
    return f"≤ {finite.max():.1g}{unit}" + (", some unknown" if len(finite) < errors.size else "")
