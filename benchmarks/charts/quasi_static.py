"""Chart e. The biaxial test over its rate: observables, their quasi-static limits and deviations.

Tests of one elongation, size and seed start from the same frictionless packing and shear at I =
1e-3 to a strain of 0.1. From there to 0.3 each has its own rate I, time step and number of sweeps.
I = 0 is shear without inertia (`overdamped`) by `STRAIN_STEP` a step; its time step sets the
remaining drag over the confining stress, STRAIN_STEP/dt². Observables are means over strains from
0.15: stresses and packing fraction over all records, the others over one network a per cent. Tests
of one seed are pairs, so differences between rates have smaller errors than the values.

The fit is y(I) = y₀ + b √I with the same b for all seeds. The rate changes I_M most, and a line in
√I fits it at all rates. A test saves a checkpoint once a minute, so an interrupted point resumes.
Its networks are in the folder `rates` of the charts.
"""

import dataclasses
import math
import pathlib
import time

import numpy as np
from yade.wrapper import Omega

from rcr.network import sin_phi
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT
from rcr.study.plot_style import legend_outside
from rcr.study.protocol import PROTOCOL

from . import biaxial_cost

O = Omega()
RECORD = PROTOCOL.record_strain  # strain of a record
TITLE = "Biaxial test: observables against the rate of shear"
APPROACH, FROM, STRAIN, LOOK = 0.1, 0.15, 0.3, 0.01
# Shear up to the strain `APPROACH`.
APPROACH_PACE = dict(inertial_number=1e-3, time_step=0.4, overdamped=False)
STRAIN_STEP = 1e-4  # strain of a step of overdamped shear
PAUSE = 60  # seconds between two checkpoints
OBSERVED = dict(sin_phi="sin φ", packing_fraction="packing fraction", friction_mobilization="I_M",
                weak_fraction="share of weak contacts", a_c_half="a_c(ξ = 0.5)",
                a_c_weak="a_c(ξ = 1)", a_c="a_c", a_fn_weak="a_fn(ξ = 1)", a_fn="a_fn", a_ft="a_ft",
                q_weak="q(ξ = 1)/p", mean_overlap="mean overlap [d]",
                wall_scatter="scatter of the free wall's speed over its mean",
                sample_inertia="ρ (ε̇ W)²/σ₀")
ERRORS = "mean_overlap", "wall_scatter", "sample_inertia"  # errors of the method, not fitted
PAPER = dict(sin_phi={0: 0.30, 0.7: 0.51}, friction_mobilization={0: 0.4, 0.7: 0.6},
             weak_fraction={0: 0.6, 0.7: 0.7}, a_c_weak={0.7: 0.3}, q_weak={0: 0.0})
DRAWN = "sin_phi", "friction_mobilization", "a_c_weak", "a_fn_weak", "q_weak", "packing_fraction"
COLUMNS = "eta particles inertial_number dt iterations seed steps seconds".split() + [*OBSERVED]
DEPENDS = ("quick",)
RATES = "1e-3/0.4/300", "1e-4/0.4/300", "3e-4/0.4/300", "3e-5/1/300"
STEPS = "1e-4/0.2/300", "1e-4/0.4/100", "1e-4/0.4/1000"  # other steps and sweeps at one rate
# Without inertia; the first equals --quasi-static.
OVERDAMPED = "0/1/300", "0/0.5/300", "0/2/300", "0/4/300", "0/2/100", "0/1/1000"


def points(options):
    """Names eta/particles/I/dt/sweeps/seed, the most informative first."""
    etas = "0", "0.7"
    if options.quick:
        rates = "1e-3/0.4/300", "5e-4/0.4/300", "0/1/300"
        return [f"{eta}/100/{rate}/{seed}" for eta in etas for rate in rates for seed in (1, 2)]

    def names(particles, settings, seeds):
        return [f"{eta}/{particles}/{setting}/{seed}"
                for seed in seeds for setting in settings for eta in etas]

    return [*names(1000, (OVERDAMPED[0], *RATES), (1, 2, 3)),
            *names(1000, OVERDAMPED[1:], (1, 2, 3)),
            *names(4000, (OVERDAMPED[0], *RATES[:3]), (1,)), *names(1000, STEPS, (1,))]


def _test(name, options, folder):
    """Test of a point, from its checkpoint or its compacted packing."""
    if (folder / CHECKPOINT).exists():
        return Biaxial.load(folder)
    eta, particles, _, _, iterations, seed = name.split("/")
    test = biaxial_cost.compacted(float(eta), int(seed),
                                  dataclasses.replace(options, particles=int(particles)))
    test.parameters["iterations"] = test.solver.maxIterations = int(iterations)
    test.progress.update(seconds=0.0, looks=[], speeds=[], first=O.iter)
    return test


def _look(test):
    """Observables of the present network."""
    network = test.network()
    half, weak, whole = (network.anisotropies(xi) for xi in (0.5, 1, np.inf))
    force = network.local_components()[3][:, 0]
    return dict(friction_mobilization=network.friction_mobilization().mean(),
                weak_fraction=np.mean(force < force.mean()), a_c_half=half[0], a_c_weak=weak[0],
                a_c=whole[0], a_fn_weak=weak[3], a_fn=whole[3], a_ft=whole[4],
                q_weak=network.shear_stress_ratio(1), mean_overlap=test.overlaps().mean(),
                sample_inertia=test.sample_inertia()[0])


def run(name, options):
    folder = pathlib.Path(options.out, "rates", name.replace("/", "-"))
    folder.mkdir(parents=True, exist_ok=True)
    test = _test(name, options, folder)
    rate, time_step = map(float, name.split("/")[2:4])
    pace = dict(inertial_number=rate or STRAIN_STEP / time_step, time_step=time_step,
                overdamped=rate == 0)
    saved = time.monotonic()
    looks = lambda: math.floor((test.strain + 0.5 * RECORD) / LOOK)
    while test.strain < STRAIN - 0.5 * RECORD:
        approaching = test.strain < APPROACH - 0.5 * RECORD
        test.parameters.update(APPROACH_PACE if approaching else pace)
        if pace["overdamped"] and not approaching and not test.solver.overdamped:
            test.remove_inertia()
        O.dt = test.parameters["time_step"] * test.time_unit
        looked, width, began, start = looks(), test.width, O.time, time.process_time()
        test.shear_record()
        test.progress["seconds"] += 0 if approaching else time.process_time() - start
        test.progress["first"] = O.iter if approaching else test.progress["first"]
        speed = (test.width - width) / (O.time - began)
        test.progress["speeds"].append(speed * test.time_unit / test.diameter)
        if looks() > looked and test.strain > FROM:
            test.network().save(folder / f"network-{test.strain:.4f}.h5")
            test.progress["looks"].append({key: float(value) for key, value in _look(test).items()})
        if time.monotonic() > saved + PAUSE or test.strain >= STRAIN - 0.5 * RECORD:
            test.save(folder)
            saved = time.monotonic()
    return [_row(test)]


def _row(test):
    parameters, looks = test.parameters, test.progress["looks"]
    late = [k for k, row in enumerate(test.rows) if row["strain"] > FROM]
    mean = lambda name: np.mean([test.rows[k][name] for k in late])
    speeds = np.array(test.progress["speeds"])[late]
    found = {key: np.mean([look[key] for look in looks]) for key in looks[0]}
    found |= dict(sin_phi=sin_phi([mean("stress_x"), mean("stress_y")]),
                  packing_fraction=mean("packing_fraction"))
    found |= dict(wall_scatter=speeds.std() / speeds.mean())
    row = {name: parameters[name] for name in ("eta", "particles", "iterations", "seed")}
    row |= dict(inertial_number=0.0 if parameters["overdamped"] else parameters["inertial_number"],
                dt=parameters["time_step"], steps=O.iter - test.progress["first"],
                seconds=test.progress["seconds"])
    return row | {name: float(value) for name, value in found.items()}


# ---- limit and figure


def fit(rows, name):
    """Fit y = y₀ + b √I by least squares, with a y₀ for each seed.

    Parameters
    ----------
    rows : list of dict
        Rows of one elongation and one size.
    name : str
        Name of the observable.

    Returns
    -------
    (dict, float, (n, n) float array) or None
        {seed: y₀}, b, and the covariance of (y₀ …, b); None for fewer than two rates.
    """
    seeds = sorted({row["seed"] for row in rows})
    x = np.sqrt(np.array([row["inertial_number"] for row in rows], dtype=float))
    y = np.array([row[name] for row in rows], dtype=float)
    if np.ptp(x) == 0:
        return None
    of_seed = [[row["seed"] == seed for seed in seeds] for row in rows]
    design = np.column_stack([of_seed, x]).astype(float)
    values = np.linalg.lstsq(design, y, rcond=None)[0]
    freedom = len(y) - design.shape[1]
    variance = np.sum((y - design @ values)**2) / freedom if freedom > 0 else math.nan
    covariance = np.linalg.inv(design.T @ design) * variance
    return dict(zip(seeds, values)), float(values[-1]), covariance


def limit(rows, name):
    """(mean y₀, error, b, error) of `fit`; the first error includes the scatter of the seeds.

    Values are NaN for too few rows.
    """
    found = fit(rows, name)
    if found is None:
        return math.nan, math.nan, math.nan, math.nan
    levels, slope, covariance = list(found[0].values()), found[1], found[2]
    share = np.append(np.full(len(levels), 1 / len(levels)), 0)
    scatter = np.var(levels, ddof=1) / len(levels) if len(levels) > 1 else 0.0
    error = math.sqrt(max(share @ covariance @ share, scatter))
    return float(np.mean(levels)), error, slope, math.sqrt(covariance[-1, -1])


def _with(rows, *settings):
    """Rows with numbers of these settings I/dt/sweeps."""
    chosen = {tuple(map(float, setting.split("/"))) for setting in settings}
    setting = lambda row: (row["inertial_number"], row["dt"], row["iterations"])
    return [row for row in rows if row["status"] == "ok" and setting(row) in chosen]


def _plain(rows):
    """Rows of the sweep over the rate, without other steps and sweeps."""
    return _with(rows, *RATES, "5e-4/0.4/300")


def _groups(rows):
    """{(eta, particles): rows}"""
    groups = {}
    for row in rows:
        groups.setdefault((row["eta"], row["particles"]), []).append(row)
    return dict(sorted(groups.items()))


def mean(rows, name):
    """Mean over the seeds and its standard error, NaN for too few rows."""
    values, count = np.array([row[name] for row in rows]), len(rows)
    return (float(values.mean()) if count else math.nan,
            float(values.std(ddof=1) / math.sqrt(count)) if count > 1 else math.nan)


def changes(rows, name, setting):
    """Mean change from the first of `OVERDAMPED` to a setting, over equal seeds, and its error."""
    first = {row["seed"]: row[name] for row in _with(rows, OVERDAMPED[0])}
    pairs = [row for row in _with(rows, setting) if row["seed"] in first]
    return mean([{name: row[name] - first[row["seed"]]} for row in pairs], name)


def ratios(rows):
    """Lines of the limits I → 0, the deviations at I = 1e-3 and 1e-4, and shear without inertia."""
    rates = lambda group: {row["inertial_number"] for row in group}
    groups = {key: group for key, group in _groups(_plain(rows)).items() if len(rates(group)) > 1}
    yield "observable | " + " | ".join(
        f"η = {eta:g}, N = {particles:g}: limit | off at 1e-3 | off at 1e-4 | without inertia"
        for eta, particles in groups)
    yield "---|" * 4 * len(groups) + "---"
    for name, title in OBSERVED.items():
        if name in ERRORS:
            continue
        cells = []
        for key, group in groups.items():
            value, error, slope, slope_error = limit(group, name)
            cells.append(f"{value:.3g} ± {error:.1g}")
            cells += [f"{slope * root:+.1g} ± {slope_error * root:.1g}"
                      for root in (math.sqrt(1e-3), math.sqrt(1e-4))]
            still = mean(_with(_groups(rows).get(key, []), OVERDAMPED[0]), name)
            cells.append("{:.3g} ± {:.1g}".format(*still))
        yield f"{title} | " + " | ".join(cells)


def other_steps(rows, particles=1000):
    """Lines of the changes of shear without inertia by other steps and sweeps."""
    groups = {eta: group for (eta, size), group in _groups(rows).items() if size == particles}
    others = [setting for setting in OVERDAMPED[1:]
              if all(_with(group, setting) for group in groups.values())]
    words = ["dt = {} t₀, {} sweeps".format(*setting.split("/")[1:]) for setting in others]
    yield "observable | " + " | ".join(f"η = {eta:g}: {word}" for eta in groups for word in words)
    yield "---|" * len(others) * len(groups) + "---"
    for name, title in OBSERVED.items():
        if name not in ERRORS[1:]:
            yield f"{title} | " + " | ".join(
                "{:+.1g} ± {:.1g}".format(*changes(group, name, setting))
                for group in groups.values() for setting in others)


def plot(rows, options):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6.6), layout="constrained")
    groups = _groups(_plain(rows))
    for ax, name in zip(figure.subplots(2, 3).flat, DRAWN):
        for (eta, particles), group in groups.items():
            _panel(ax, group, name, f"η = {eta:g}, N = {particles:g}", *_style(eta, particles))
            still, error = mean(_with(_groups(rows)[eta, particles], OVERDAMPED[0]), name)
            ax.errorbar([-0.0014], [still], [np.nan_to_num(error)], color=_style(eta, particles)[0],
                        marker="*", mfc=_style(eta, particles)[2], ms=9, ls="")
        ax.set(title=OBSERVED[name], xlim=(-0.0035, 0.034))
        ax.set_xticks([math.sqrt(rate) for rate in (0, 3e-5, 1e-4, 3e-4, 1e-3)],
                      ["0", "3e-5", "1e-4", "3e-4", "1e-3"], fontsize=7, rotation=40)
        ax.set_xlabel("I (axis ∝ √I)", fontsize=8)
        ax.grid(alpha=0.3)
    figure.suptitle("Each observable against the rate, its limit I → 0 at the left; "
                    "stars: without inertia; grey triangles: the paper", fontsize=10)
    legend_outside(figure, figure.axes[0], "lower center", 4, fontsize=9)
    return figure


def _style(eta, particles):
    """(colour, marker, fill, line); discs are filled and solid."""
    color, fill, line = ("k", "k", "-") if eta == 0 else ("C3", "w", "--")
    return color, {1000: "o", 4000: "s"}.get(particles, "^"), fill, line


def _panel(ax, rows, name, label, color, marker, fill, line):
    """Draw means over the seeds, shifted to the common y₀, the fit and the paper's value."""
    start, error, slope, _ = limit(rows, name)
    levels = fit(rows, name)[0] if math.isfinite(start) else {}
    rates = sorted({row["inertial_number"] for row in rows})
    shift = lambda row: start - levels.get(row["seed"], start) if levels else 0
    values = [np.array([row[name] + shift(row) for row in rows if row["inertial_number"] == rate])
              for rate in rates]
    errors = [v.std(ddof=1) / math.sqrt(len(v)) if len(v) > 1 else 0 for v in values]
    x = np.sqrt(rates)
    ax.errorbar(x, [v.mean() for v in values], errors, color=color, marker=marker, mfc=fill, ms=5,
                ls="", label=label)
    if levels:
        ax.plot([0, x[-1]], [start, start + slope * x[-1]], color=color, ls=line, lw=0.8)
        ax.errorbar([0], [start], [np.nan_to_num(error)], color=color, marker="_", ms=10, capsize=4)
    paper = PAPER.get(name, {}).get(rows[0]["eta"])
    if paper is not None:
        ax.plot([-0.0028], [paper], marker=">", color="0.5", ms=7, ls="", label=None)
