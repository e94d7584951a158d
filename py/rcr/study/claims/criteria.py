"""Parts of the criteria by which statements of the paper are tested. Needs NumPy.

A criterion is a function of the values {name: array} of an observable. It returns whether the
statement agrees, the measured value and its error as texts, or raises `NotTested`.
"""

import numpy as np

SIGMAS = 2  # standard errors that a deviation may have by chance
CLAIMS = []  # (observables, statement, criterion, function), in the order of registration


class NotTested(Exception):
    """Raised where the data do not suffice; the message is the reason."""


def claim(observables, statement, criterion):
    """Return a decorator that registers a criterion as a row of the table.

    The row belongs to the first of `observables`. The criterion takes the values of each.
    """

    def register(test):
        CLAIMS.append((observables.split(), statement, criterion, test))
        return test

    return register


# --- selection --------------------------------------------------------------------------------


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


def at_xi(v, name, xi, rows=slice(None)):
    """Return values and errors at a cutoff ξ."""
    k = int(np.argmin(np.abs(v["xi"] - xi)))
    return v[name][rows, k], known(v[f"{name}_error"][rows, k])


def minimum(v, name, row):
    """Return ξ, value and error of the lowest point of a function of ξ ≤ 6."""
    keep = v["xi"] <= 6
    k = int(np.argmin(v[name][row, keep]))
    return v["xi"][k], v[name][row, k], known(v[f"{name}_error"][row, k])


def require_finite(values, reason="too few contacts"):
    """Return the values; raise NotTested with a reason if one is NaN."""
    if not np.isfinite(values).all():
        raise NotTested(reason)
    return values


def known(error):
    """Return the errors, with 0 for unknown ones: then the tolerance alone counts."""
    return np.nan_to_num(error)


def is_within(deviation, tolerance, error):
    """Test whether deviations are within a tolerance or two errors, whichever is wider."""
    return np.abs(deviation) <= np.maximum(tolerance, SIGMAS * known(error))


# --- trends -----------------------------------------------------------------------------------


def slope_of(x, y):
    """Return the slope of a straight line, and its standard error from the scatter about it."""
    keep = np.isfinite(y)
    x, y = np.asarray(x)[keep], np.asarray(y)[keep]
    if len(x) < 3:
        raise NotTested(f"expected at least three values for a trend, there are {len(x)}")
    dx = x - x.mean()
    slope = dx @ y / (dx @ dx)
    rest = y - y.mean() - slope * dx
    return slope, np.sqrt(rest @ rest / (len(x) - 2) / (dx @ dx))


def trend(v, name, sign, low=0, high=1):
    """Test whether a value rises (sign +1) or falls (−1) with η."""
    rows = rows_of(v, low, high, 3)
    slope, error = slope_of(v["eta"][rows], v[name][rows])
    first, last = require_finite(v[name][rows[[0, -1]]])
    low, high = v["eta"][rows[[0, -1]]]
    value = f"{first:.3g} → {last:.3g} (η = {low:g} → {high:g})"
    return sign * slope > SIGMAS * error, value, f"slope {slope:.2g} ± {error:.1g}"


def is_monotonic(v, name, sign, rows):
    """Test whether a function of ξ rises (sign +1) or falls (−1) for 0.2 ≤ ξ ≤ 6.

    Its largest step back must be below two errors or 10 % of its range.

    Returns
    -------
    (rows,) bool array, (rows,) float array
        The verdicts and the largest steps back.
    """
    keep = (v["xi"] >= 0.2) & (v["xi"] <= 6)
    back, allowed = [], []
    for row in rows:
        curve = sign * v[name][row, keep]
        back.append(np.max(np.maximum.accumulate(curve) - curve))
        error = known(v[f"{name}_error"][row, keep]).max()
        allowed.append(max(0.1 * np.ptp(curve), SIGMAS * error))
    return np.array(back) <= np.array(allowed), np.array(back)


# --- verdicts ---------------------------------------------------------------------------------


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
    """Return errors as a text, with ? for unknown ones."""
    return ", ".join("?" if np.isnan(e) else f"{e:.1g}" for e in np.atleast_1d(error))


def format_largest(errors):
    """Return the largest of the known errors as a text."""
    return f"≤ {known(errors).max():.1g}"
