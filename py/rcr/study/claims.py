"""Paper against measured: each statement of the text as a criterion on the data, each with its verdict. Needs NumPy.

A criterion takes a value within its tolerance or two standard errors, whichever is wider, and a trend beyond two standard errors.
Statements on which the data cannot tell (an elongation that was not run, a map to be looked at) are not tested.
"""

import dataclasses

import numpy as np

from rcr.study.statistics import pearson

AGREES, DIFFERS, NOT_TESTED = "agrees", "does not agree", "not tested"
SIGMAS = 2  # standard errors that a deviation may have by chance


@dataclasses.dataclass(frozen=True)
class Finding:
    """One row of the table.

    Attributes
    ----------
    observable : str
        O1 … O18.
    statement, criterion : str
        What the paper says; when that counts as found.
    value, error : str
        Measured, and its standard error over seeds or snapshots, see `rcr.study.analysis`.
    verdict : str
        `AGREES`, `DIFFERS` or `NOT_TESTED`.
    """

    observable: str
    statement: str
    criterion: str
    value: str
    error: str
    verdict: str


class NotTested(Exception):
    """The data do not tell; the message says why."""


_CLAIMS = []


def claim(observable, statement, criterion):
    """Register a function (value of the observable) → (agrees, value, error) as a row of the table."""

    def register(test):
        _CLAIMS.append((observable, statement, criterion, test))
        return test

    return register


def findings(analysis):
    """The table: a list of `Finding`, in the order of the observables; `analysis` as `rcr.study.analysis.analyse` returns it."""
    rows = []
    for observable, statement, criterion, test in _CLAIMS:
        try:
            agrees, value, error = test({key: entry["value"] for key, entry in analysis.items()})
            verdict = AGREES if agrees else DIFFERS
        except NotTested as reason:
            value, error, verdict = str(reason), "", NOT_TESTED
        rows.append(Finding(observable, statement, criterion, value, error, verdict))
    return sorted(rows, key=lambda row: int(row.observable[1:]))


# --- what the criteria share --------------------------------------------------------------------------------------------


def _row(v, eta):
    """Index of an elongation."""
    index = int(np.argmin(np.abs(v["eta"] - eta)))
    if abs(v["eta"][index] - eta) > 0.02:
        raise NotTested(f"no run of η = {eta:g}")
    return index


def _rows(v, low, high, least=1):
    """Indices of the elongations within [low, high]."""
    rows = np.flatnonzero((v["eta"] >= low - 1e-9) & (v["eta"] <= high + 1e-9))
    if len(rows) < least:
        raise NotTested(f"wanted {least} elongation{'s' * (least > 1)} in [{low:g}, {high:g}], there are {len(rows)}")
    return rows


def _at(v, name, xi, rows=slice(None)):
    """Values and errors at a cutoff ξ."""
    k = int(np.argmin(np.abs(v["xi"] - xi)))
    return v[name][rows, k], _known(v[f"{name}_error"][rows, k])


def _told(values):
    """The values; not tested if one is no number, as of a class with too few contacts."""
    if not np.isfinite(values).all():
        raise NotTested("too few contacts")
    return values


def _known(error):
    """Errors with 0 for the unknown ones of a single snapshot: only the tolerance counts then."""
    return np.nan_to_num(error)


def _ends(v, name, low, high, tolerance):
    """Values at η = 0 and 0.7 against those of the paper."""
    rows = [_row(v, 0), _row(v, 0.7)]
    value, error = _told(v[name][rows]), v[f"{name}_error"][rows]
    agrees = np.abs(value - (low, high)) <= np.maximum(tolerance, SIGMAS * _known(error))
    return agrees.all(), f"{value[0]:.3g} → {value[1]:.3g}", _errors(error)


def _errors(error):
    return ", ".join("?" if np.isnan(e) else f"{e:.1g}" for e in np.atleast_1d(error))


def _slope(x, y):
    """Slope of a straight line and its standard error from the scatter about it."""
    keep = np.isfinite(y)
    x, y = np.asarray(x)[keep], np.asarray(y)[keep]
    if len(x) < 3:
        raise NotTested(f"wanted at least three values for a trend, there are {len(x)}")
    dx = x - x.mean()
    slope = dx @ y / (dx @ dx)
    rest = y - y.mean() - slope * dx
    return slope, np.sqrt(rest @ rest / (len(x) - 2) / (dx @ dx))


def _trend(v, name, sign, low=0, high=1):
    """Does a value grow (sign +1) or fall (−1) with η?"""
    rows = _rows(v, low, high, 3)
    slope, error = _slope(v["eta"][rows], v[name][rows])
    (first, last), (low, high) = _told(v[name][rows[[0, -1]]]), v["eta"][rows[[0, -1]]]
    value = f"{first:.3g} → {last:.3g} (η = {low:g} → {high:g})"
    return sign * slope > SIGMAS * error, value, f"slope {slope:.2g} ± {error:.1g}"


def _listed(v, rows, values, form="{:.2f}"):
    return ", ".join(form.format(values[i]) + f" ({v['eta'][row]:g})" for i, row in enumerate(rows))


def _all(v, rows, agrees, values, errors=None):
    """Verdict on several elongations: the value of each, η in brackets, and where it fails."""
    off = ", ".join(f"{v['eta'][row]:g}" for row, fine in zip(rows, agrees) if not fine)
    value = _listed(v, rows, _told(values)) + (f"; off at η = {off}" if off else "")
    return not off, value, "" if errors is None else f"≤ {_known(errors).max():.1g}"


def _monotonic(v, name, sign, rows, low=0.2):
    """Does a function of ξ grow (fall) for ξ ≥ low: its largest step back over its largest size, below 2 errors or 10 %."""
    keep = (v["xi"] >= low) & (v["xi"] <= 6)
    back, allowed = [], []
    for row in rows:
        curve = sign * v[name][row, keep]
        back.append(np.max(np.maximum.accumulate(curve) - curve))
        allowed.append(max(0.1 * np.ptp(curve), SIGMAS * _known(v[f"{name}_error"][row, keep]).max()))
    return np.array(back) <= np.array(allowed), np.array(back)


def _extremum(v, name, row, high=6):
    """ξ and value of the lowest point of a function of ξ."""
    keep = v["xi"] <= high
    k = int(np.argmin(v[name][row, keep]))
    return v["xi"][k], v[name][row, k], _known(v[f"{name}_error"][row, k])


# --- strength and compaction --------------------------------------------------------------------------------------------


@claim("O1", "sin φ = 0.30 + 0.30 η at the critical state", "within 0.02 or two errors at every η")
def _(all_):
    v = all_["O1"]
    away = np.abs(v["sin_phi"] - 0.3 - 0.3 * v["eta"])
    agrees = away <= np.maximum(0.02, SIGMAS * _known(v["sin_phi_error"]))
    return _all(v, range(len(away)), agrees, v["sin_phi"], v["sin_phi_error"])


@claim(
    "O2",
    "P(θ) is isotropic after compaction",
    "|a_c| below 0.05, a tenth of that of the critical state, or 3 √(2/C), that of C independent directions",
)
def _(all_):
    v = all_["O2"]
    if not np.isfinite(v["a_c"]).all():
        raise NotTested("no isotropic.h5")
    return _all(v, range(len(v["eta"])), v["a_c"] <= np.maximum(0.05, 3 * v["a_c_error"]), v["a_c"], v["a_c_error"])


@claim(
    "O2",
    "frictionless packings are isostatic: Z = 4 for discs, Z_c = 6 for long particles (each ss twice)",
    "within 5 %, η = 0 and η ≥ 0.3",
)
def _(all_):
    v = all_["O2"]
    rows = [*_rows(v, 0, 0, 0), *_rows(v, 0.3, 1, 0)]
    if not rows or not np.isfinite(v["coordination_number_twice"]).all():
        raise NotTested("no isotropic state of these elongations")
    measured, wanted = v["coordination_number_twice"][rows], np.where(v["eta"][rows] == 0, 4, 6)
    return _all(v, rows, np.abs(measured / wanted - 1) <= 0.05, measured)


@claim("O2", "packing fraction after compaction has its peak near η = 0.4", "largest at η in [0.3, 0.5], of runs on both sides")
def _(all_):
    v = all_["O2"]
    for low, high in ((0, 0.2), (0.3, 0.5), (0.6, 1)):
        _rows(v, low, high)
    if not np.isfinite(v["packing_fraction"]).all():
        raise NotTested("no isotropic.h5")
    densest = v["eta"][np.argmax(v["packing_fraction"])]
    return 0.3 - 1e-9 <= densest <= 0.5 + 1e-9, _listed(v, range(len(v["eta"])), v["packing_fraction"], "{:.3f}"), ""


# --- forces -------------------------------------------------------------------------------------------------------------


@claim("O3", "α_n falls with η", "slope negative beyond two errors")
def _(all_):
    return _trend(all_["O3"], "alpha_n", -1)


@claim("O3", "β_n from 0.1 (η = 0) to −0.4 (η = 0.7)", "both within 0.1 or two errors")
def _(all_):
    return _ends(all_["O3"], "beta_n", 0.1, -0.4, 0.1)


@claim("O3", "share of weak contacts from 60 % (η = 0) to 70 % (η = 0.7)", "both within 0.03 or two errors")
def _(all_):
    return _ends(all_["O3"], "weak_fraction", 0.6, 0.7, 0.03)


def _saturates(v, name):
    """Falls up to η = 0.4, and from there to 0.7 by less than half as much."""
    falls, value, error = _trend(v, name, -1, 0, 0.4)
    first, middle, last = (v[name][_row(v, eta)] for eta in (0, 0.4, 0.7))
    return falls and abs(last - middle) < 0.5 * abs(middle - first), f"{first:.3g} → {middle:.3g} → {last:.3g} (η = 0, 0.4, 0.7)", error


@claim("O4", "α_t falls with η and saturates beyond 0.4", "falls beyond two errors to 0.4; changes by less than half of that to 0.7")
def _(all_):
    return _saturates(all_["O4"], "alpha_t")


@claim("O4", "β_t falls with η and saturates beyond 0.4", "falls beyond two errors to 0.4; changes by less than half of that to 0.7")
def _(all_):
    return _saturates(all_["O4"], "beta_t")


@claim("O5", "I_M from 0.4 (η = 0) to 0.6 (η = 0.7)", "both within 0.05 or two errors")
def _(all_):
    return _ends(all_["O5"], "friction_mobilization", 0.4, 0.6, 0.05)


@claim(
    "O6",
    "mobilised contacts (I_m > 0.99) belong mostly to the weak network",
    "a larger share of them is weak than of all contacts, at every η",
)
def _(all_):
    v, weak = all_["O5"], all_["O3"]["weak_fraction"]
    if not np.isfinite(v["mobilized_weak_share"]).all():
        raise NotTested("no mobilised contact at some η")
    return _all(v, range(len(weak)), v["mobilized_weak_share"] > weak, v["mobilized_weak_share"], v["mobilized_weak_share_error"])


def _force_levels(v):
    """Mean I_mf of the weak classes, f_n in [0.1, 1], and the strong ones, [1, 4]; (2, η)."""
    levels = [(v["f_n"] > 0.1) & (v["f_n"] < 1), (v["f_n"] > 1) & (v["f_n"] < 4)]
    told = [np.isfinite(v["i_mf"]) & level for level in levels]
    count = _told(np.where(np.array(told).any(axis=2), np.sum(told, axis=2), np.nan))
    return np.array([np.where(level, v["i_mf"], 0).sum(axis=1) for level in told]) / count


@claim("O7", "I_mf falls with f_n", "I_mf of strong classes below that of weak ones, at every η (difference given)")
def _(all_):
    v = all_["O7"]
    weak, strong = _force_levels(v)
    return _all(v, range(len(weak)), strong < weak, strong - weak)


@claim("O7", "I_mf rises with η at every force", "slope with η positive beyond two errors, for weak and for strong classes")
def _(all_):
    v = all_["O7"]
    (weak, weak_error), (strong, strong_error) = (_slope(v["eta"], level) for level in _force_levels(v))
    agrees = weak > SIGMAS * weak_error and strong > SIGMAS * strong_error
    return agrees, f"slope {weak:.2g} (weak), {strong:.2g} (strong)", f"{weak_error:.1g}, {strong_error:.1g}"


@claim("O8", "discs: P(I_m) falls nearly linearly", "straight line through all classes: slope negative, r² ≥ 0.8")
def _(all_):
    v = all_["O8"]
    pdf = v["pdf"][_row(v, 0)]
    slope, error = _slope(v["i_m"], pdf)
    r2 = _told(pearson(v["i_m"], pdf)) ** 2
    inner, _ = _slope(v["i_m"][:-1], pdf[:-1])
    inner_r2 = _told(pearson(v["i_m"][:-1], pdf[:-1])) ** 2
    value = f"slope {slope:.2f}, r² {r2:.2f}; without the last class {inner:.2f}, {inner_r2:.2f}; last class {pdf[-1]:.2f}"
    return slope < 0 and r2 >= 0.8, value, f"slope {error:.1g}"


@claim(
    "O8",
    "long particles: a class of contacts close to I_m = 1 stands out",
    "at the largest η ≥ 0.5 P(I_m) of the last class is over twice the mean of the others",
)
def _(all_):
    v = all_["O8"]
    row = _rows(v, 0.5, 1)[-1]
    pdf = v["pdf"][row]
    last, others = pdf[-1], pdf[:-1].mean()
    return last > 2 * others, f"{last:.2f} against {others:.2f} (η = {v['eta'][row]:g})", _errors(v["pdf_error"][row, -1])


@claim("O9", "chains of particles with side-side contacts, of like orientation", "a map: to be looked at")
def _(all_):
    raise NotTested("see the map")


# --- branch vectors -----------------------------------------------------------------------------------------------------


def _mode(v, row, place, reach=0.04):
    """Position, height and error of the largest density within `reach` of a place, and whether the density falls off on its open sides.

    It is a mode if it exceeds, by more than its error, the lowest density between `reach` and half of the way to the next mode.
    """
    eta, l_r, pdf = v["eta"][row], v["l_r"], v["pdf"][row]
    near = np.flatnonzero(np.abs(l_r - place) <= max(reach, 0.2 * eta) / 2 + 1e-9)
    k = near[np.argmax(pdf[near])]
    error = np.nan_to_num(v["pdf_error"][row, k])
    sides = [side for side in ((l_r > place - eta / 2) & (l_r < l_r[k]), (l_r < place + eta / 2) & (l_r > l_r[k])) if side.any()]
    inside = [side & (l_r > 1 - eta) for side in sides]
    stands_out = all(pdf[k] - pdf[side].min() > error for side in inside if side.any())
    return l_r[k], pdf[k], stands_out


def _modes(all_, where, sign):
    v = all_["O10"]
    rows = _rows(v, 0.2, 1, 3)
    modes = [_mode(v, row, where(v["eta"][row])) for row in rows]
    heights = np.array([mode[1] for mode in modes])
    agrees = all(mode[2] for mode in modes)
    if sign:
        slope, error = _slope(v["eta"][rows], heights)
        agrees &= sign * slope > SIGMAS * error
    listed = ", ".join(f"{at:.2f} ({height:.2f})" for at, height, _ in modes)
    etas = ", ".join(f"{eta:g}" for eta in v["eta"][rows])
    return agrees, f"at ℓ_r (height): {listed} for η = {etas}", f"height ≤ {_known(v['pdf_error'][rows]).max():.1g}"


@claim("O10", "P(ℓ_r) has a mode at 1 − η that grows with η", "a local maximum there at every η ≥ 0.2, rising beyond two errors")
def _(all_):
    return _modes(all_, lambda eta: 1 - eta, +1)


@claim("O10", "P(ℓ_r) has a mode near 1 − η/2 that shrinks with η", "a local maximum there at every η ≥ 0.2, falling beyond two errors")
def _(all_):
    return _modes(all_, lambda eta: 1 - eta / 2, -1)


@claim("O10", "P(ℓ_r) has a mode near 1", "a local maximum there at every η ≥ 0.2")
def _(all_):
    return _modes(all_, lambda eta: 1, 0)


@claim("O11", "the share of side-side contacts grows with η", "slope positive beyond two errors")
def _(all_):
    return _trend(all_["O11"], "fraction_ss", +1)


def _sign_change(name):
    def test(all_):
        v = all_["O12"]
        rows = [row for row in range(len(v["eta"])) if np.isfinite(v[name][row])]
        if len({v["eta"][row] > 0.3 + 1e-9 for row in rows}) < 2:
            raise NotTested("wanted elongations below and above 0.3")
        value, error = v[name][rows], v[f"{name}_error"][rows]
        wanted = np.where(v["eta"][rows] <= 0.3 + 1e-9, 1, -1)
        return _all(v, rows, wanted * value > -SIGMAS * _known(error), value, error)

    return test


for name, label in (("c_f_lr", "C(f, ℓ_r)"), ("c_f_l", "C(f, ℓ)")):
    statement = f"{label} is positive for η ≤ 0.3, negative above"
    claim("O12", statement, "its sign, within two errors, at every η (discs have no ℓ_r)")(_sign_change(name))


@claim("O12", "down to −0.22", "smaller of the two at η = 0.7 within 0.05 or two errors of −0.22")
def _(all_):
    v = all_["O12"]
    row = _row(v, 0.7)
    value, error = min((v[name][row], v[f"{name}_error"][row]) for name in ("c_f_lr", "c_f_l"))
    _told(value)
    return abs(value + 0.22) <= max(0.05, SIGMAS * np.nan_to_num(error)), f"{value:.3f}", _errors(error)


@claim(
    "O13",
    "force above the mean for side-side contacts, well below it for aligned cap-cap ones",
    "first class of ℓ_r above 1, last below 0.8, at every η ≥ 0.4",
)
def _(all_):
    v = all_["O13"]
    rows = _rows(v, 0.4, 1)
    classes = [v["f_l_r"][row][np.isfinite(v["f_l_r"][row])] for row in rows]
    if not all(map(len, classes)):
        raise NotTested("too few contacts")
    ends = np.array([means[[0, -1]] for means in classes])
    value = ", ".join(f"{first:.2f} and {last:.2f} ({v['eta'][row]:g})" for row, (first, last) in zip(rows, ends))
    return ((ends[:, 0] > 1) & (ends[:, 1] < 0.8)).all(), value, ""


@claim("O13", "mean force rises with ℓ for η ≤ 0.3 and falls above", "sign of the slope over the classes of ℓ, at every η")
def _(all_):
    v = all_["O13"]
    if len(set(v["eta"] > 0.3 + 1e-9)) < 2:
        raise NotTested("wanted elongations below and above 0.3")
    slopes, errors = np.array([_slope(v["l"], means) for means in v["f_l"]]).T
    return _all(v, range(len(slopes)), np.where(v["eta"] <= 0.3 + 1e-9, 1, -1) * slopes > 0, slopes, errors)


# --- anisotropies -------------------------------------------------------------------------------------------------------


@claim(
    "O14",
    "at η = 0.5 P(θ, ξ) has the axis of σ₁ for every ξ",
    "axis of its Fourier fit within 10° or two errors of θσ for each ξ shown",
)
def _(all_):
    v = all_["O14"]
    row = _row(v, 0.5)
    away, error = np.degrees(_told(v["off_axis"][row])), np.degrees(_known(v["off_axis_error"][row]))
    agrees = (np.abs(away) <= np.maximum(10, SIGMAS * error)).all()
    return agrees, ", ".join(f"{a:.1f}° (ξ = {xi})" for a, xi in zip(away, [*(f"{xi:g}" for xi in v["xi"][:-1]), "∞"])), f"≤ {error.max():.1g}°"


@claim("O14", "at η = 0.5 its anisotropy grows with ξ", "amplitude of each ξ shown not below that of the one before by two errors")
def _(all_):
    v = all_["O14"]
    row = _row(v, 0.5)
    amplitude, error = _told(v["amplitude"][row]), _known(v["amplitude_error"][row])
    rises = np.diff(amplitude) > -SIGMAS * np.hypot(error[1:], error[:-1])
    return rises.all() and amplitude[-1] > amplitude[0], ", ".join(f"{a:.2f}" for a in amplitude), f"≤ {error.max():.1g}"


@claim(
    "O15",
    "discs: a_c(ξ) negative with its extremum at ξ ≈ 1, then positive",
    "lowest at ξ in [0.7, 1.3] and below 0 by two errors; positive at the end",
)
def _(all_):
    v = all_["O15"]
    row = _row(v, 0)
    xi, lowest, error = _extremum(v, "a_c", row)
    end = v["a_c"][row, -1]
    return 0.7 <= xi <= 1.3 and lowest < -SIGMAS * error and end > 0, f"{lowest:.3f} at ξ = {xi:.2f}, {end:.3f} at the end", _errors(error)


@claim("O15", "η > 0: a_c(ξ) positive for every ξ", "not below 0 by two errors at any ξ ≥ 0.2, for every η > 0 (lowest value given)")
def _(all_):
    v = all_["O15"]
    rows = _rows(v, 0.01, 1)
    value, error = (v[name][rows][:, v["xi"] >= 0.2] for name in ("a_c", "a_c_error"))
    return _all(v, rows, (value >= -SIGMAS * _known(error)).all(axis=1), value.min(axis=1), _known(error))


@claim("O15", "a_c = 0.3 at ξ = 1 for long particles", "within 0.05 or two errors at every η ≥ 0.5")
def _(all_):
    v = all_["O15"]
    rows = _rows(v, 0.5, 1)
    value, error = _at(v, "a_c", 1, rows)
    return _all(v, rows, np.abs(value - 0.3) <= np.maximum(0.05, SIGMAS * error), value, error)


@claim("O16", "a_ln positive for η ≤ 0.1, negative above", "sign of a_ln(∞), within two errors, at every η")
def _(all_):
    v = all_["O16"]
    value, error = v["a_ln"][:, -1], _known(v["a_ln_error"][:, -1])
    wanted = np.where(v["eta"] <= 0.1 + 1e-9, 1, -1)
    return _all(v, range(len(value)), wanted * value > -SIGMAS * error, value, error)


@claim("O16", "where negative, a_ln has its peak for ξ in [1, 2]", "lowest at ξ in [0.9, 2.1] for every η ≥ 0.2 (ξ given)")
def _(all_):
    v = all_["O16"]
    rows = _rows(v, 0.2, 1)
    xi = np.array([_extremum(v, "a_ln", row)[0] for row in rows])
    return _all(v, rows, (xi >= 0.9) & (xi <= 2.1), xi)


@claim("O16", "a_lt < 0 and monotonic in ξ", "a_lt(∞) < 0; steps back below 10 % of its range or two errors, for every η > 0")
def _(all_):
    v = all_["O16"]
    rows = _rows(v, 0.01, 1)
    smooth, _ = _monotonic(v, "a_lt", -1, rows)
    value = v["a_lt"][rows, -1]
    return _all(v, rows, smooth & (value < 0), value, _known(v["a_lt_error"][rows, -1]))


@claim("O16", "|a_lt| > |a_ln|, both weak compared with a_c", "at ξ = ∞ for every η ≥ 0.2: |a_ln| < |a_lt| < a_c/2 (|a_lt|/|a_ln| given)")
def _(all_):
    v = all_["O16"]
    rows = _rows(v, 0.2, 1)
    a_c, a_ln, a_lt = all_["O15"]["a_c"][rows, -1], np.abs(v["a_ln"][rows, -1]), np.abs(v["a_lt"][rows, -1])
    return _all(v, rows, (a_ln < a_lt) & (a_lt < 0.5 * a_c), np.divide(a_lt, a_ln, out=np.full_like(a_lt, np.nan), where=a_ln > 0))


@claim("O17", "discs: a_fn(ξ) positive", "not below 0 by two errors at any ξ ≥ 0.2 (lowest value given)")
def _(all_):
    v = all_["O17"]
    row, seen = _row(v, 0), v["xi"] >= 0.2
    value, error = v["a_fn"][row, seen], _known(v["a_fn_error"][row, seen])
    return bool((value >= -SIGMAS * error).all()), f"{value.min():.3f}", f"≤ {error.max():.1g}"


@claim(
    "O17",
    "η > 0: a_fn(ξ) negative for ξ < 1 with its extremum at ξ = 1",
    "lowest at ξ in [0.9, 1.1] and below 0 by two errors, for every η > 0 (ξ given)",
)
def _(all_):
    v = all_["O17"]
    rows = _rows(v, 0.01, 1)
    xi, lowest, error = np.array([_extremum(v, "a_fn", row) for row in rows]).T
    return _all(v, rows, (xi > 0.89) & (xi < 1.11) & (lowest < -SIGMAS * error), xi)


@claim("O17", "η > 0: a_fn becomes positive beyond ξ ≈ 2", "last change of sign at ξ in [1.5, 3] for every η > 0 (ξ given)")
def _(all_):
    v = all_["O17"]
    rows = _rows(v, 0.01, 1)
    negative = [np.flatnonzero(v["a_fn"][row] < 0) for row in rows]
    xi = np.array([v["xi"][k[-1]] if len(k) else 0 for k in negative])
    return _all(v, rows, (xi >= 1.5) & (xi <= 3), xi)


@claim("O17", "a_ft rises with ξ", "steps back below 10 % of its range or two errors, at every η (largest given)")
def _(all_):
    v = all_["O17"]
    smooth, back = _monotonic(v, "a_ft", +1, range(len(v["eta"])))
    return _all(v, range(len(back)), smooth, back)


@claim("O17", "a_ft rises with η", "slope of a_ft(∞) positive beyond two errors")
def _(all_):
    v = all_["O17"]
    return _trend(v | dict(whole=v["a_ft"][:, -1]), "whole", +1)


@claim("O18", "discs: q(ξ)/p is 0 for ξ < 1", "|q(ξ)/p| below 0.02 or two errors for every ξ ≤ 1 (largest given)")
def _(all_):
    v = all_["O18"]
    row, weak = _row(v, 0), v["xi"] <= 1 + 1e-9
    value, error = np.abs(v["q_over_p"][row, weak]), _known(v["q_over_p_error"][row, weak])
    return bool((value <= np.maximum(0.02, SIGMAS * error)).all()), f"{value.max():.3f}", f"≤ {error.max():.1g}"


@claim("O18", "q/p of the weak network below 0.1", "q(1)/p below 0.1 or two errors above it, at every η")
def _(all_):
    v = all_["O18"]
    value, error = _at(v, "q_over_p", 1)
    return _all(v, range(len(value)), value - SIGMAS * error < 0.1, value, error)


@claim(
    "O18",
    "half-sum of the anisotropies fits q(ξ)/p at every ξ",
    "difference below 10 % of q(∞)/p at every ξ and η (largest share given)",
)
def _(all_):
    v = all_["O18"]
    share = np.abs(v["closure"]).max(axis=1) / np.abs(v["q_over_p"][:, -1])
    return _all(v, range(len(share)), share <= 0.1, share)
