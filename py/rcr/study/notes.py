"""Small studies of the statements that do not agree with the paper: each isolates a cause, in one figure and three sentences.

A note is a function of runs by elongation, {η: list of `Run`}, and of others to set against them (another rate, say), which
returns its text and its figure; the numbers of a text are those of the runs. Needs NumPy and Matplotlib.
"""

import dataclasses

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from rcr import files
from rcr.drawing import COLUMN, PAGE, STYLE
from rcr.network import COMPLEX, RIGHT, SIDE_SIDE, TOP
from rcr.study import statistics
from rcr.study.analysis import STRIPS, POWER_RANGE, standard_error
from rcr.study.ensemble import Ensemble
from rcr.study.figures import color, marker
from rcr.study.runs import Run
from rcr.xi_networks import XiNetworks

SECTORS = 36  # of the direction of normals, in which means are taken


@dataclasses.dataclass(frozen=True)
class Note:
    """Title and text in Markdown, name and figure of its picture."""

    title: str
    text: str
    name: str
    figure: Figure


_NOTES = []


def note(function):
    """Register a function (runs, others) → Note, or None where the runs do not tell."""
    _NOTES.append(function)
    return function


def notes(runs, others):
    """All notes that the runs can tell, in the order of this file.

    Parameters
    ----------
    runs, others : dict of lists of Run
        By elongation; `others` may be empty.
    """
    with matplotlib.rc_context(STYLE):
        return [made for made in (function(runs, others) for function in _NOTES) if made]


def ensemble(runs):
    return Ensemble([network for run in runs for network in run.networks])


def snapshots(runs):
    return [Ensemble([network]) for run in runs for network in run.networks]


def with_error(values):
    """Mean and standard error over snapshots."""
    return np.mean(values, axis=0), standard_error(values)


def _figure(count=1, width=None):
    figure = Figure(figsize=(width or (COLUMN if count == 1 else PAGE), 0.85 * COLUMN), layout="constrained")
    axes = figure.subplots(1, count, squeeze=False)[0]
    return figure, axes


def _curve(ax, eta, x, mean, error):
    """The line of an elongation, with its errors where they are known."""
    ax.errorbar(x, mean, np.nan_to_num(error), color=color(eta), marker=marker(eta), ms=3, lw=0.8, label=rf"$\eta = {eta:g}$")


def _number(mean, error):
    return f"{mean:.3f} ± {np.nan_to_num(error):.3f}"


def _rate(runs):
    """I of runs as their run.json or the name of their folder tells it, as text; 0 without inertia."""
    told = {_recorded_rate(run.record["parameters"]) if run.record else _folder_rate(run) for run in runs} - {None}
    return ", ".join(f"{rate:g}" for rate in sorted(told)) or "unknown"


def _recorded_rate(parameters):
    return 0.0 if parameters.get("overdamped") else parameters["inertial_number"]


def _folder_rate(run):
    """I of a point of chart e, whose folder is named eta-particles-I-dt-sweeps-seed."""
    words = run.folder.name.replace("e-", "e~").split("-")
    return float(words[2].replace("~", "-")) if len(words) == 6 else None


# --- the half-sum ---------------------------------------------------------------------------------------------------------


def products(e):
    """X(∞) of the half-sum in two parts: the product of the angular means of force and branch, and what is left, their correlation.

    With φ and λ the fluctuations of force and branch over their means (complex, along n and t), X = (1/C) Re Σ φ λ e^{2iθ}. The first part
    has φ and λ replaced by their means over the contacts of the same direction, in `SECTORS` classes.

    Returns
    -------
    (of means, of correlations) : floats [-]
    """
    force, branch = (e.fn + 1j * e.ft) / e.fn.mean() - 1, (e.ln + 1j * e.lt) / e.ln.mean() - 1
    sector = np.minimum((e.theta % np.pi / np.pi * SECTORS).astype(int), SECTORS - 1)
    count = np.maximum(np.bincount(sector, minlength=SECTORS), 1)
    mean = lambda values: ((np.bincount(sector, values.real, SECTORS) + 1j * np.bincount(sector, values.imag, SECTORS)) / count)[sector]
    turn = np.exp(2j * e.theta)
    whole, means = np.mean((force * branch * turn).real), np.mean((mean(force) * mean(branch) * turn).real)
    return means, whole - means


@note
def half_sum(runs, others):
    """The closure of q/p by anisotropies."""
    etas, rows = list(runs), []
    for group in runs.values():
        e = ensemble(group)
        xi = e.xi_networks()
        rows.append([xi.shear_stress_ratio(), 0.5 * np.sum(xi.anisotropies()), *products(e), xi.pressure_factor()])
    ratio, half, means, correlations, kappa = np.array(rows).T
    rest = np.abs(half + means + correlations - kappa * ratio).max()
    figure, (ax,) = _figure()
    ax.plot(etas, ratio, "D-", color="tab:green", mfc="none", label=r"$q/p$")
    ax.plot(etas, kappa * ratio, "ko-", label=r"$\kappa\,q/p$")
    ax.plot(etas, half, "s--", color="tab:red", mfc="none", label="half-sum")
    ax.plot(etas, half + means, "^:", color="tab:blue", mfc="none", label="+ products of angular means")
    ax.plot(etas, half + means + correlations, "x", color="0.4", ms=7, label="+ correlations: exact")
    ax.set(xlabel=r"$\eta$", ylim=(0, None))
    ax.legend(fontsize=7)
    k = int(np.argmax(etas))
    text = (
        f"At η = {etas[k]:g} the half-sum of the five anisotropies is {half[k]:.3f} and q/p {ratio[k]:.3f}, at η = {etas[0]:g} {half[0]:.3f} and {ratio[0]:.3f}. "
        f"What it leaves out is the product of the angular means of force and branch ({means[k]:+.3f} at η = {etas[k]:g}), their correlation at one direction "
        f"({correlations[k]:+.3f}), and the factor κ = {kappa[k]:.3f} that the correlation puts to the pressure: with all of them, κ q/p = half-sum + X holds to {rest:.0e} at every η. "
        f"The half-sum alone is κ q/p within {np.abs(half - kappa * ratio).max():.3f}, so that κ, large forces on short branches, is the most of what is missing."
    )
    return Note("The half-sum of the anisotropies", text, "half-sum", figure)


# --- weak contacts of discs -----------------------------------------------------------------------------------------------


def _inner(network):
    """Mask, of the contacts between grains, of those whose grains touch no wall."""
    one, two = network.contacts["body1"], network.contacts["body2"]
    outer = np.unique(one[two < 0])
    pick = network.between_particles
    return ~(np.isin(one[pick], outer) | np.isin(two[pick], outer))


def _a_c(network, xi, pick=None):
    """a_c(ξ) of a share of the contacts; forces over the mean of all."""
    n, _, branch, force = network.local_components()
    pick = np.ones(len(n), dtype=bool) if pick is None else pick
    theta = np.angle(n @ COMPLEX) - network.stress_angle()
    return XiNetworks(theta[pick], branch[pick] @ COMPLEX, force[pick] @ COMPLEX, force[pick, 0] / force[:, 0].mean()).anisotropies(xi)[0]


@note
def weak_discs(runs, others):
    """Sign of a_c below ξ = 1."""
    if 0 not in runs:
        return None
    xi = np.linspace(0.1, 1.6, 31)
    networks = [network for run in runs[0] for network in run.networks]
    figure, (ax,) = _figure()
    ax.axhline(0, color="0.7", lw=0.6)
    found = {}
    variants = [("all contacts", networks, lambda network: None, "-"), ("grains that touch no wall", networks, _inner, "--")]
    if 0 in others:
        other = [network for run in others[0] for network in run.networks]
        variants.append((f"all contacts, I = {_rate(others[0])}", other, lambda network: None, ":"))
    for (label, of, pick, line), tint in zip(variants, ("k", "tab:red", "tab:blue")):
        mean, error = with_error([_a_c(network, xi, pick(network)) for network in of])
        found[label] = mean, error
        ax.plot(xi, mean, line, color=tint, label=label)
        ax.fill_between(xi, mean - error, mean + error, color=tint, alpha=0.12, lw=0)
    ax.set(xlabel=r"$\xi$", ylabel=r"$a_c(\xi)$, discs")
    ax.legend(fontsize=7)
    mean, error = found["all contacts"]
    k, one = int(np.argmin(mean)), int(np.argmin(np.abs(xi - 1)))
    inner, inner_error = found["grains that touch no wall"]
    text = (
        f"a_c(ξ) of discs has its lowest value, {_number(mean[k], error[k])}, at ξ = {xi[k]:.2f}, and is {_number(mean[one], error[one])} at ξ = 1 "
        f"(I = {_rate(runs[0])}, {len(networks)} snapshots). Contacts of grains that touch no wall have {_number(inner[k], inner_error[k])} and "
        f"{_number(inner[one], inner_error[one])} there. Beside a_c(∞) = "
        f"{_number(*with_error([network.anisotropies()[0] for network in networks]))} the weak contacts of discs are nearly isotropic, whatever their sign."
    )
    return Note("Weak contacts of discs", text, "weak-discs", figure)


# --- forces and lengths ---------------------------------------------------------------------------------------------------


def correlation_variants(e):
    """C(f, ℓ_r) by what is taken for f: the force of the contact, of each of its points, or of contacts that are no side-side ones."""
    force, sides = np.hypot(e.fn, e.ft), e.type == SIDE_SIDE
    as_points = np.where(sides, 0.5, 1) * force
    twice = np.concatenate([np.arange(len(e)), np.flatnonzero(sides)])
    return (
        statistics.pearson(force, e.reduced_length),
        statistics.pearson(as_points[twice], e.reduced_length[twice]),
        statistics.pearson(force[~sides], e.reduced_length[~sides]),
    )


@note
def force_and_length(runs, others):
    """Sign of C(f, ℓ_r) at small elongations."""
    etas = [eta for eta in runs if eta > 0]
    if not etas:
        return None
    found = np.array([with_error([correlation_variants(part) for part in snapshots(runs[eta])]) for eta in etas])  # (η, mean or error, variant)
    figure, (ax,) = _figure()
    ax.axhline(0, color="0.7", lw=0.6)
    labels = "force of a contact", "force of a point (sides: two)", "without side-side contacts"
    for k, (label, line) in enumerate(zip(labels, ("ko-", "s--", "^:"))):
        ax.errorbar(etas, found[:, 0, k], found[:, 1, k], fmt=line, mfc="none" if k else "k", label=label)
    ax.set(xlabel=r"$\eta$", ylabel=r"$C_{f\ell_r}$", ylim=(None, ax.get_ylim()[1] + 0.12))  # room for the legend
    ax.legend(fontsize=7, loc="upper right")
    signs = [np.sign(found[:, 0, k]) * (np.abs(found[:, 0, k]) > 2 * np.nan_to_num(found[:, 1, k])) for k in range(3)]
    listed = lambda rows: ", ".join(f"{etas[row]:g}" for row in rows)
    told = [" and ".join(f"{word} at η = {listed(rows)}" for word, rows in (("positive", np.flatnonzero(sign > 0)), ("negative", np.flatnonzero(sign < 0))) if len(rows)) or "0 within two errors" for sign in signs]
    ends = [f"{_number(*found[-1, :, k])}" for k in range(3)]
    text = (
        f"With the force of the contact, the resultant of both points of a side-side contact, C(f, ℓ_r) is, by two errors, {told[0]} ({ends[0]} at η = {etas[-1]:g}). "
        f"With each point as a contact of its own, of half the force, it is {told[1]} ({ends[1]}). "
        f"Without side-side contacts, which have the shortest branches and the largest forces, it is {told[2]} ({ends[2]})."
    )
    return Note("Correlation of force and reduced branch length", text, "force-and-length", figure)


@note
def sides_as_points(runs, others):
    """Distributions with side-side contacts counted once and twice."""
    etas, rows = list(runs), []
    for group in runs.values():
        parts = []
        for e in snapshots(group):
            sides = e.type == SIDE_SIDE
            twice = np.concatenate([np.arange(len(e)), np.flatnonzero(sides)])
            points = (np.where(sides, 0.5, 1) * e.fn)[twice]
            points = points / points.mean()
            beta = lambda force: statistics.power_exponent(force, POWER_RANGE)[0]
            parts.append([np.mean(e.fn < 1), np.mean(points < 1), e.mobilization.mean(), e.mobilization[twice].mean(), beta(e.fn), beta(points)])
        rows.append(with_error(parts))
    rows = np.array(rows)
    figure, axes = _figure(3)
    for k, (ax, label) in enumerate(zip(axes, ("share of weak contacts", r"$I_M$", r"$\beta_n$"))):
        for j, (name, line) in enumerate((("once", "ko-"), ("twice", "s--"))):
            ax.errorbar(etas, rows[:, 0, 2 * k + j], rows[:, 1, 2 * k + j], fmt=line, mfc="none" if j else "k", label=f"side-side contacts {name}")
        ax.set(xlabel=r"$\eta$", ylabel=label)
    axes[0].legend(fontsize=7)
    k = int(np.argmax(etas))
    once, twice = rows[k, :, ::2].T, rows[k, :, 1::2].T
    text = (
        f"At η = {etas[k]:g} the share of weak contacts is {_number(*once[0])} with a side-side contact counted once and {_number(*twice[0])} with each of its two points counted, "
        f"with half of the force. I_M is {_number(*once[1])} and {_number(*twice[1])}, β_n {_number(*once[2])} and {_number(*twice[2])}. "
        "The paper gives 0.70, 0.60 and −0.4, and attributes one force to each contact."
    )
    return Note("Side-side contacts counted once or twice", text, "sides-once-or-twice", figure)


# --- exponents ------------------------------------------------------------------------------------------------------------

UPPER_ENDS = np.linspace(0.2, 1.5, 14)  # of the fits below the mean, over the mean
PAPER_BETA = {0: 0.1, 0.7: -0.4}  # β_n


def exponents_by_range(forces):
    """β of each sample of forces over their mean, fitted from `POWER_RANGE` up to each of `UPPER_ENDS`; (samples, ends)."""
    return np.array([[statistics.power_exponent(force, POWER_RANGE, end)[0] for end in UPPER_ENDS] for force in forces])


@note
def fit_range(runs, others):
    """β_n and β_t by the range of the fit."""
    figure, axes = _figure(2)
    told, moved = [], []
    for eta, group in runs.items():
        parts = snapshots(group)
        for ax, forces in zip(axes, ([e.fn for e in parts], [np.abs(e.ft) / np.abs(e.ft).mean() for e in parts])):
            mean, error = with_error(exponents_by_range(forces))
            _curve(ax, eta, UPPER_ENDS, mean, error)
            if ax is axes[0] and eta in PAPER_BETA:
                ax.axhline(PAPER_BETA[eta], color=color(eta), ls="--", lw=0.8)
                least, at_mean, most = (int(np.argmin(np.abs(UPPER_ENDS - end))) for end in (0.5, 1, 1.5))
                reached = UPPER_ENDS[np.abs(mean - PAPER_BETA[eta]) < 0.05]
                where = f"within 0.05 with an upper end from {reached[0]:.1f} to {reached[-1]:.1f}" if len(reached) else "not reached with any"
                moved.append(np.ptp(mean))
                told.append(
                    f"At η = {eta:g} β_n is {_number(mean[least], error[least])} fitted up to half of the mean force, {_number(mean[at_mean], error[at_mean])} up to the mean "
                    f"and {_number(mean[most], error[most])} up to 1.5 times it; the paper's {PAPER_BETA[eta]:+g} is {where}."
                )
    if not told:
        return None
    for ax, label in zip(axes, (r"$\beta_n$", r"$\beta_t$")):
        ax.set(xlabel=r"upper end of the fit, over the mean force", ylabel=label)
    axes[0].legend(fontsize=7, ncols=2)
    text = (
        f"{' '.join(told)} The density is no power law, so that the range, of which the paper says nothing, is part of an exponent; it moves β_n by up to {max(moved):.2f} (left; dashed: "
        "the paper) and β_t alike (right). Where no range reaches the paper's exponent, it is the density of small forces that differs."
    )
    return Note("Exponents and the range of their fit", text, "fit-range", figure)


# --- inertia --------------------------------------------------------------------------------------------------------------


@note
def strips(runs, others):
    """Normal forces from wall to wall."""
    shared = [eta for eta in runs if eta in others]
    if not shared:
        return None
    edges = np.linspace(0, 1, STRIPS + 1)
    figure, axes = _figure(2)
    worst = []
    for ax, of in zip(axes, (others, runs)):
        ax.axhspan(0.9, 1.1, color="0.92", lw=0)
        away = []
        for eta in shared:
            mean, error = with_error([statistics.class_means(e.across, e.fn, edges) for e in snapshots(of[eta])])
            ax.errorbar(statistics.centres(edges), mean, error, color=color(eta), marker=marker(eta), lw=0.8, label=rf"$\eta = {eta:g}$")
            away.append((np.ptp(mean), error.max(), eta))
        worst.append(max(away))
        ax.set(xlabel=r"$x/W$ (fixed wall at 0, free wall at 1)", title=f"I = {_rate([run for eta in shared for run in of[eta]])}", ylim=(0.6, 1.4))
    axes[0].set_ylabel(r"$\langle f_n\rangle_x/\langle f_n\rangle$")
    axes[0].legend(fontsize=7, ncols=2)
    rates = [_rate([run for eta in shared for run in of[eta]]) for of in (others, runs)]
    sizes = [len(of[shared[0]][0].networks[0].particles["id"]) for of in (others, runs)]
    told = [f"{spread:.2f} (errors up to {error:.2f}, η = {eta:g}) in tests of {size} grains at I = {rate}" for (spread, error, eta), rate, size in zip(worst, rates, sizes)]
    text = (
        "In a sample that flows homogeneously the fixed side wall feels ρ (ε̇ W)² more than the free one, by I² N (W/h)(h₀/h)² of σ₀: 5 % for 13 000 grains at I = 1e-3 and W/h = 2, "
        f"21 % at W/h = 4. The mean normal force in five strips from wall to wall differs by {told[0]}, and by {told[1]}. "
        "`sample_inertia` of summary.json foretells the share of inertia, which is below 2 % where grains are few: there, strips differ by chance. Errors are those over snapshots, which share the layers of one packing."
    )
    return Note("Forces from wall to wall", text, "strips", figure)


def wall_speed(history):
    """Strain and speed of the free wall over that of a flow of constant area, ε̇ W: 1 − (1 − ε) d ln φ/dε of the packing fraction φ, a record each."""
    strain, fraction = history["strain"], np.log(history["packing_fraction"])
    middle = 0.5 * (strain[1:] + strain[:-1])
    return middle, 1 - (1 - middle) * np.diff(fraction) / np.diff(strain)


@note
def free_wall(runs, others):
    """How smoothly the free wall moves."""
    shared = [eta for eta in runs if eta in others]
    if not shared:
        return None
    eta = shared[0]
    figure, axes = _figure(2)
    told = []
    for ax, group in zip(axes, (others[eta], runs[eta])):
        run = group[0]
        strain, speed = wall_speed(np.genfromtxt(run.folder / "history.csv", delimiter=",", names=True))
        late = run.looked_at(strain)
        ax.axhline(1, color="0.7", lw=0.6)
        ax.plot(strain[late], speed[late], "k", lw=0.6)
        ax.set(xlabel=r"strain $\varepsilon$", ylim=(0, 3), title=rf"$I = {_rate([run])}$, $\eta = {eta:g}$")
        told.append(f"{speed[late].std():.2f} at I = {_rate([run])}")
    axes[0].set_ylabel(r"$v_{\rm wall}/(\dot\varepsilon W)$")
    text = (
        "The free wall moves at ε̇ W, the speed at which the sample widens, plus what the packing dilates: 0.11 to 0.45 d a time unit for 13 000 grains at I = 1e-3. "
        f"Over a record of 0.1 % of strain its speed scatters by {' and '.join(told)} of the mean (η = {eta:g}). The wall follows the grains: no wave and no inertia of its own "
        "are seen, and what looks abrupt is the speed itself, which the rate sets."
    )
    return Note("Motion of the free wall", text, "free-wall", figure)


# --- friction mobilisation ------------------------------------------------------------------------------------------------


@note
def last_class(runs, others):
    """P(I_m) of discs near 1."""
    if 0 not in runs or 0 not in others:
        return None
    edges = np.linspace(0, 1, 21)
    figure, (ax,) = _figure()
    told, inner, sliding, mobilization = [], [], [], []
    for of, line in ((others[0], "s--"), (runs[0], "ko-")):
        mean, error = with_error([statistics.density(np.minimum(e.mobilization, 1), edges) for e in snapshots(of)])
        ax.errorbar(statistics.centres(edges), mean, error, fmt=line, ms=3, mfc="none" if of is others[0] else "k", label=f"I = {_rate(of)}")
        told.append(f"{_number(mean[-1], error[-1])} at I = {_rate(of)}")
        e = ensemble(of)
        sliding.append(np.mean(e.mobilization > edges[-2]))
        mobilization.append(e.mobilization.mean())
        rest = e.mobilization[e.mobilization <= edges[-2]].mean()
        inner.append(np.polyfit(statistics.centres(edges)[:-1], mean[:-1], 1)[0])
    ax.set(xlabel=r"$I_m$", ylabel=r"$P(I_m)$, discs", ylim=(0, None))
    ax.legend(fontsize=7)
    text = (
        f"P(I_m) of discs falls linearly, with a slope of {inner[1]:.2f}, but for the last class, [0.95, 1]: {' and '.join(told)}. Contacts that slide are at I_m = 1 exactly, so that the class holds "
        f"a peak as high as the share of sliding contacts over the width of the class. I_M falls by {mobilization[0] - mobilization[1]:.3f} from one rate to the other; the share of this class "
        f"falls from {sliding[0]:.3f} to {sliding[1]:.3f}, which alone would lower it by {(sliding[0] - sliding[1]) * (1 - rest):.3f}: slower shear has fewer sliding contacts."
    )
    return Note("The last class of P(I_m) of discs", text, "last-class", figure)


# --- frictionless packings ------------------------------------------------------------------------------------------------

MOST_GRAINS = 2000  # of a packing whose modes are looked for
NEUTRAL = 1e-9  # of the largest eigenvalue: a smaller one is 0


def neutral_modes(packing):
    """Motions of a frictionless packing that open and close no contact, from the rank of its contacts' constraints.

    A contact holds the normal velocity of its point, a side-side one the relative rotation besides. Rattlers are left out; the right wall may move
    along x and the top one along y; discs do not turn.

    Returns
    -------
    (modes, wanting, rotation) : int, int, float
        Number of motions; degrees of freedom beyond the number of constraints, the same if these are independent; share of rotation in the
        motions, of all squares, a turn counted as what it moves the end of a grain by.
    """
    alive, kept, _ = packing.backbone(True)
    grains, contacts = packing.particles, {name: column[kept] for name, column in packing.contacts.items()}
    own = np.flatnonzero(alive[grains["id"]])
    number = np.full(len(alive), -1)
    number[grains["id"][own]] = np.arange(len(own))
    radius, center = grains["R"][own], grains["position"][own]
    turns = grains["half_length"].any()
    rows = len(contacts["body1"])
    held = np.zeros((rows + np.sum(contacts["points"] == 2), 3 * len(own) + 2))
    k, n = np.arange(rows), contacts["normal"]
    second = np.flatnonzero(contacts["points"] == 2)
    for body, sign in (("body1", -1), ("body2", 1)):
        is_grain = contacts[body] >= 0
        i = number[np.where(is_grain, contacts[body], 0)]
        arm = contacts["position"] - center[i]
        for row, column, value in (
            (k, 3 * i, n[:, 0]),
            (k, 3 * i + 1, n[:, 1]),
            (k, 3 * i + 2, (arm[:, 0] * n[:, 1] - arm[:, 1] * n[:, 0]) / radius[i]),
        ):
            held[row[is_grain], column[is_grain]] += sign * value[is_grain]
        turning = second[is_grain[second]]
        held[rows + np.flatnonzero(is_grain[second]), 3 * i[turning] + 2] += sign
    for wall, column, axis in ((RIGHT, -2, 0), (TOP, -1, 1)):
        pushed = contacts["body2"] == wall
        held[k[pushed], column] += n[pushed, axis]
    free = np.ones(held.shape[1], dtype=bool)
    free[2:-2:3] = turns
    free[-2:] = held[:, -2:].any(axis=0)
    values, motions = np.linalg.eigh(held[:, free].T @ held[:, free])
    motions = motions[:, values < NEUTRAL * values[-1]]
    turning = np.zeros(held.shape[1], dtype=bool)
    turning[2:-2:3] = True
    return motions.shape[1], int(free.sum()) - len(held), float(np.sum(motions[turning[free]] ** 2) / max(1, motions.shape[1]))


@note
def neutral(runs, others):
    """Why long particles have fewer contacts than three degrees of freedom ask for."""
    packings = {eta: run.isotropic for groups in (runs, others) for eta, group in groups.items() for run in group[:1] if run.isotropic is not None}
    small = {eta: packing for eta, packing in sorted(packings.items()) if len(packing.particles["id"]) <= MOST_GRAINS}
    if not any(eta > 0 for eta in small):
        return None
    found = {eta: (*neutral_modes(packing), packing.backbone(True)[0].sum(), packing.coordination(count_side_contacts_twice=True)) for eta, packing in small.items()}
    etas = list(found)
    modes, wanting, rotation, grains, coordination = map(np.array, zip(*found.values()))
    figure, axes = _figure(2)
    axes[0].plot(etas, coordination, "ko-")
    axes[0].axhline(6, color="0.7", lw=0.6)
    axes[0].set(xlabel=r"$\eta$", ylabel=r"$Z_c$, frictionless")
    axes[1].plot(etas, modes / grains, "ko-", label="neutral motions a grain")
    axes[1].plot(etas, wanting / grains, "x", color="tab:red", ms=7, label="degrees of freedom beyond contacts")
    axes[1].plot(etas, rotation, "s--", color="tab:blue", mfc="none", label="share of rotation in them")
    axes[1].set(xlabel=r"$\eta$", ylim=(0, 1.4))  # room for the legend
    axes[1].legend(fontsize=7)
    least = min((eta for eta in etas if eta > 0), key=lambda eta: abs(eta - 0.3))
    k = etas.index(least)
    text = (
        f"Packings of {' and '.join(map(str, sorted({len(packing.particles['id']) for packing in small.values()})))} grains, a side-side contact counted twice. "
        f"At η = {least:g} Z_c is {coordination[k]:.2f} where three degrees of freedom a grain ask for 6: {modes[k]} motions, {modes[k] / grains[k]:.3f} a grain, open and close no contact. "
        f"They are as many as degrees of freedom exceed contacts ({wanting[k]}), within {np.abs(modes - wanting).max()} at every η: contacts are independent, none is missing by chance. "
        f"{rotation[k]:.0%} of these motions is rotation: the less a grain differs from a disc, which turns freely, the more of its rotations need no contact that holds them."
    )
    return Note("Contacts of frictionless packings", text, "neutral", figure)


# --- side-side contacts behind a mean -------------------------------------------------------------------------------------


def force_by_length(e, edges):
    """Mean force of classes of branch length over that of all: of all contacts, of side-side ones and of the rest; (3, classes)."""
    force, length, sides = np.hypot(e.fn, e.ft), np.hypot(e.ln, e.lt), e.type == SIDE_SIDE
    return np.array([statistics.class_means(length[pick], force[pick] / force.mean(), edges) for pick in (np.ones_like(sides), sides, ~sides)])


@note
def force_by_type(runs, others):
    """Mean force against the branch length about η = 0.3, where the paper has it rise."""
    etas = sorted(sorted((eta for eta in runs if eta > 0), key=lambda eta: abs(eta - 0.3))[:3])
    if not etas:
        return None
    figure, axes = _figure(len(etas))
    told = []
    for ax, eta in zip(axes, etas):
        whole = ensemble(runs[eta])
        length = np.hypot(whole.ln, whole.lt)
        edges = np.linspace(*np.quantile(length, (0.01, 0.99)), 11)
        mean, error = with_error([force_by_length(e, edges) for e in snapshots(runs[eta])])
        for row, (label, line) in enumerate((("all", "ko-"), ("side-side", "s--"), ("the rest", "^:"))):
            ax.errorbar(statistics.centres(edges), mean[row], np.nan_to_num(error[row]), fmt=line, ms=3, mfc="none" if row else "k", label=label)
        ax.set(xlabel=r"$\ell/R_{\max}$", title=rf"$\eta = {eta:g}$", ylim=(0.5, 2.2))
        sides = whole.type == SIDE_SIDE
        short = length < np.median(length)
        slope = [np.polyfit(statistics.centres(edges)[kept], row[kept], 1)[0] for row in mean for kept in [np.isfinite(row)]]
        told.append(
            f"at η = {eta:g} {slope[1]:+.2f} among side-side contacts, {slope[2]:+.2f} among the rest and {slope[0]:+.2f} of all, "
            f"{np.mean(sides[short]):.0%} of the shorter half of the branches and {np.mean(sides[~short]):.0%} of the longer one being side-side"
        )
    axes[0].set_ylabel(r"$\langle f\rangle_\ell/\langle f\rangle$")
    axes[0].legend(fontsize=7)
    text = (
        f"The slope of the mean force (over that of all) against the branch length (over R_max) is {'; '.join(told)}. "
        "Larger grains have the longer branches and bear more. Side-side contacts bear more than the rest, too, and have the shorter branches: so the slope of all is below that "
        "of either type, the more of them there are, and turns where their share outweighs the sizes of grains."
    )
    return Note("Force and branch length by type of contact", text, "force-by-type", figure)


def length_anisotropy(e, xi, pick):
    """What the contacts of a mask add to a_ln(ξ)."""
    share = pick * (e.ln / e.ln.mean() - 1) * np.cos(2 * e.theta)
    return np.array([2 * np.sum(share[e.fn <= cut]) / len(e) for cut in xi])


@note
def length_peak(runs, others):
    """Where a_ln(ξ) is lowest."""
    etas = [eta for eta in runs if eta >= 0.3 - 1e-9]
    if not etas:
        return None
    xi = np.arange(0.25, 6.01, 0.25)
    figure, axes = _figure(2)
    lowest = []
    for eta in etas:
        for ax, sides in zip(axes, (True, False)):
            mean, error = with_error([length_anisotropy(e, xi, (e.type == SIDE_SIDE) == sides) for e in snapshots(runs[eta])])
            _curve(ax, eta, xi, mean, error)
            if not sides:
                lowest.append(f"{xi[int(np.argmin(mean))]:g} (η = {eta:g})")
    for ax, title in zip(axes, ("side-side contacts", "all others")):
        ax.set(xlabel=r"$\xi$", title=title)
        ax.axvspan(1, 2, color="0.92", lw=0)
    axes[0].set_ylabel(r"share of $a_{ln}(\xi)$")
    axes[0].legend(fontsize=7)
    text = (
        f"Without side-side contacts a_ln(ξ) has its lowest value at ξ = {', '.join(lowest)}; the paper's peak is in [1, 2], shaded. "
        "What side-side contacts add falls on to the largest forces, since these are the strongest contacts, the shortest ones, and turned to the axis of σ₁. "
        "So a_ln has a peak where they bear no force much above the mean, and none here."
    )
    return Note("The peak of the anisotropy of branch lengths", text, "length-peak", figure)


@note
def nearest_to_one(runs, others):
    """How far the mode of ℓ_r near 1 stands out."""
    etas = [eta for eta in runs if eta >= 0.2 - 1e-9]
    if not etas:
        return None
    figure, (ax,) = _figure()
    told = []
    for eta in etas:
        edges = np.linspace(1 - eta, 1, 21)  # the mode and its neighbours alike at every η
        mean, error = with_error([statistics.density(np.clip(e.reduced_length, 1 - eta, 1 - 1e-9), edges) for e in snapshots(runs[eta])])
        _curve(ax, eta, (statistics.centres(edges) - 1) / eta, mean / mean[-4:].max(), error / mean[-4:].max())
        top, dip = int(np.argmax(mean[-4:])) + 16, int(np.argmin(mean[10:])) + 10
        told.append(f"{mean[top] / mean[dip]:.2f} ± {np.hypot(error[top], error[dip] * mean[top] / mean[dip]) / mean[dip]:.2f} (η = {eta:g})")
    ax.set(xlabel=r"$(\ell_r - 1)/\eta$", ylabel=r"$P(\ell_r)$ over its mode near 1", xlim=(-0.5, 0.02), ylim=(0, 2.5))
    ax.legend(fontsize=7, ncols=2)
    text = (
        f"The density of the highest class near 1 over that of the lowest one between there and 1 − η/2 is {', '.join(told)}. "
        "Grains whose axes lie on one line touch there by their caps. The broad mode at 1 − η/2, caps on sides, reaches over it the more the shorter the grains are: "
        "whether a mode is seen is a matter of the class width and of chance at small η."
    )
    return Note("The mode of the longest branches", text, "longest-branches", figure)


# --- strain ---------------------------------------------------------------------------------------------------------------


@note
def weak_fabric(runs, others):
    """a_c(ξ = 1) of long particles against the strain."""
    etas = [eta for eta in runs if eta >= 0.5 - 1e-9]
    if not etas:
        return None
    figure, (ax,) = _figure()
    ax.axhspan(0.25, 0.35, color="0.92", lw=0)
    told = []
    for eta in etas:
        for groups, fill in ((runs, True), (others, False)):
            series = [(network.attributes["strain"], network.anisotropies(1)[0]) for run in groups.get(eta, []) for network in Run.read(run.folder, 0).networks]
            strain, value = np.array(sorted(series)).T if series else np.zeros((2, 0))
            ax.plot(strain, value, marker(eta), color=color(eta), mfc=None if fill else "none", ms=4, label=rf"$\eta = {eta:g}$" if fill else None)
            if fill:
                third = np.minimum((3 * strain / strain.max()).astype(int), 2)
                told.append(", ".join(f"{value[third == k].mean():.2f}" for k in range(3)) + f" (η = {eta:g})")
    ax.set(xlabel=r"strain $\varepsilon$", ylabel=r"$a_c(\xi = 1)$", ylim=(0, None))
    ax.legend(fontsize=7)
    last = max(float(network.attributes["strain"]) for eta in etas for run in runs[eta] for network in run.networks)
    text = (
        f"a_c of the weak contacts of long particles is, in three equal parts of the strain up to {last:.2g}, {', '.join(told)}; the paper's 0.3 ± 0.05 is shaded. "
        f"It goes on changing while sin φ stays, as long particles go on turning{'; open marks: I = ' + _rate([run for eta in etas for run in others.get(eta, [])]) if any(eta in others for eta in etas) else ''}."
    )
    return Note("The fabric of weak contacts and the strain", text, "weak-fabric", figure)


# --- the page -------------------------------------------------------------------------------------------------------------

HEAD = """# Notes on the study

Each statement of the paper that does not agree, or agrees only in its definition, has a note: one figure, and what isolates the cause. The page and its numbers are
made by `scripts/study_notes.py`, from {what}.
"""


def write(runs, others, out, name="study-notes"):
    """Write the page out/NAME.md and its pictures out/NAME/*.png; returns the path of the page."""
    made = notes(runs, others)
    if not made:
        raise ValueError("the runs tell none of the notes; wanted runs of scripts/biaxial.py")
    pictures = out / name
    pictures.mkdir(parents=True, exist_ok=True)
    parts = [HEAD.format(what=_what(runs, others))]
    for one in made:
        with matplotlib.rc_context(STYLE):
            one.figure.savefig(pictures / f"{one.name}.png", dpi=150)
        parts.append(f"## {one.title}\n\n![{one.title}]({name}/{one.name}.png)\n\n{one.text}\n")
    page = out / f"{name}.md"
    files.write(page, "\n".join(parts))
    return page


def _what(runs, others):
    def told(groups):
        grains = sorted({len(run.networks[0].particles["id"]) for group in groups.values() for run in group})
        seeds, count = max(map(len, groups.values())), sum(len(run.networks) for group in groups.values() for run in group)
        return (
            f"tests of {' and '.join(map(str, grains))} grains at I = {_rate([run for group in groups.values() for run in group])}, η = {', '.join(f'{eta:g}' for eta in groups)}, "
            f"{seeds} seed{'s' * (seeds > 1)} at most, {count} snapshots"
        )

    return told(runs) + (f"; set against {told(others)}" if others else "")
