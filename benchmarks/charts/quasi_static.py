"""Chart e. The biaxial test over its rate, time step and solver, in pairs of equal packings.

Tests of one elongation, size and seed start from the same frictionless packing. They shear as in
the study to a strain of 0.1, then at the settings of the point to 0.3. At the settings of the study
they continue to 0.5. A row has the observables of the strains from 0.15 to 0.3, or from 0.3 to 0.5.
Stresses and packing fraction are means over all records, the others over one network a per cent.

The limit I → 0 is that of the fit y(I) = y₀ + b √I with the same b for all seeds. A test saves a
checkpoint once a minute, so an interrupted point resumes. Its networks are in the folder `rates` of
the charts.
"""

import dataclasses
import math
import pathlib
import time

import numpy as np
from matplotlib.figure import Figure
from yade.wrapper import Omega

from rcr.network import Network, sin_phi
from rcr import statistics
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT
from rcr.ensemble import Ensemble
from rcr.distributions import POWER_RANGE
from rcr._pictures.curves import legend_outside
from rcr.study.protocol import HALF_RECORD

from benchmarks import charts
from benchmarks.charts import biaxial_cost

O = Omega()
APPROACH, FROM, STRAIN, LAST, LOOK = 0.1, 0.15, 0.3, 0.5, 0.01  # strains
PAUSE = 60  # seconds between two checkpoints
OBSERVED = dict(sin_phi="sin φ", packing_fraction="packing fraction", friction_mobilization="I_M",
                weak_fraction="share of weak contacts", beta_n="β_n", a_c_half="a_c(ξ = 0.5)",
                a_c_weak="a_c(ξ = 1)", a_c="a_c", a_ln="a_ln", a_fn_weak="a_fn(ξ = 1)",
                a_fn="a_fn", a_ft="a_ft", q_weak="q(ξ = 1)/p", half_sum="half-sum over q/p",
                c_f_lr="C(f, ℓ_r)", missed="steps that missed the tolerance")
COLUMNS = "eta particles inertial_number seed strain steps seconds".split() + [*OBSERVED]
DEPENDS = "quick", "protocol"
# Settings are I/dt/iterations/tolerance. The tolerance mean-X is that of the paper: plain
# Gauss–Seidel ends at a relative change X of the mean force.
BASE = "1e-4/0.4/300/1e-4"
RATES = "1e-3/0.4/300/1e-4", "2e-4/0.4/300/1e-4", "5e-5/0.4/300/1e-4"
OTHERS = "1e-4/0.4/1000/1e-4", "1e-4/0.2/300/1e-4", "1e-4/0.1/300/1e-4", "1e-4/0.4/300/1e-3"
PLAIN = "1e-4/0.1/300/mean-1e-3", "1e-4/0.1/300/mean-1e-4"
CHANGES = {  # setting: (label, marker, fill) of its difference from BASE
    RATES[0]: ("I = 1e-3", "o", "w"), RATES[1]: ("I = 2e-4", "o", "0.6"),
    RATES[2]: ("I = 5e-5", "o", "k"), OTHERS[0]: ("1000 sweeps", "^", "k"),
    OTHERS[1]: ("dt = 0.2 t₀", "s", "0.6"), OTHERS[2]: ("dt = 0.1 t₀", "s", "k"),
    OTHERS[3]: ("tolerance 1e-3", "v", "w"), PLAIN[0]: ("dt = 0.1 t₀, mean force 1e-3", "P", "w"),
    PLAIN[1]: ("dt = 0.1 t₀, mean force 1e-4", "P", "k"),
}  # fmt: skip
LIMIT, LATER = ("I → 0", "*", "k"), ("strains 0.3 to 0.5", "D", "w")


def points(options):
    """Names eta/particles/I/dt/sweeps/tolerance/seed, the most informative first."""
    etas = "0", "0.7"

    def names(particles, settings, seeds):
        return [f"{eta}/{particles}/{setting}/{seed}"
                for seed in seeds for setting in settings for eta in etas]

    if options.quick:
        return names(100, (RATES[0], "5e-4/0.4/300/1e-4"), (1, 2))
    return [*names(1000, (BASE, *OTHERS, *PLAIN, *RATES), (1, 2, 3)),
            *names(4000, (BASE, OTHERS[0], *RATES[1:]), (1,))]


# ---- tests

def _test(name, options, folder):
    """Test of a point, from its checkpoint or its compacted packing."""
    if (folder / CHECKPOINT).exists():
        return Biaxial.load(folder)
    eta, particles, *_, seed = name.split("/")
    test = biaxial_cost.compacted(float(eta), int(seed),
                                  dataclasses.replace(options, particles=int(particles)))
    test.progress.update(seconds=0.0, steps=0)
    return test


def _set(test, setting):
    rate, dt, iterations, tolerance = setting.split("/")
    test.parameters.update(inertial_number=float(rate), time_step=float(dt), approach=APPROACH)
    solver, change = test.solver, tolerance.removeprefix("mean-")
    plain = change != tolerance
    solver.maxIterations, solver.solver = int(iterations), "nlgs" if plain else "auto"
    solver.tolerance = 1e-4 if plain else float(tolerance)
    solver.meanForceChange = float(change) if plain else 0


def run(name, options):
    folder = pathlib.Path(charts.folder("rates", name.replace("/", "-"), options))
    folder.mkdir(parents=True, exist_ok=True)
    test, setting = _test(name, options, folder), _setting(name)
    saved = time.monotonic()
    end = LAST if setting == BASE else STRAIN
    looks = lambda: math.floor((test.strain + HALF_RECORD) / LOOK)
    while not test.has_reached(end):
        approaching = not test.has_reached(APPROACH)
        _set(test, BASE if approaching else setting)
        looked, first, start = looks(), O.iter, time.process_time()
        test.shear_record()
        if not approaching and test.strain < STRAIN + HALF_RECORD:
            test.progress["seconds"] += time.process_time() - start
            test.progress["steps"] += O.iter - first
        if looks() > looked and test.strain > FROM:
            test.network().save(folder / f"network-{test.strain:.4f}.h5")
        if time.monotonic() > saved + PAUSE or test.has_reached(end):
            test.save(folder)
            saved = time.monotonic()
    windows = [(FROM, STRAIN), (STRAIN, LAST)] if setting == BASE else [(FROM, STRAIN)]
    return [_row(test, folder, *window) for window in windows]


def _row(test, folder, first, last):
    within = lambda strain: first + HALF_RECORD < strain < last + HALF_RECORD
    paths = [path for path in sorted(folder.glob("network-*.h5"))
             if within(float(path.stem.split("-")[1]))]
    rows = [row for row in test.rows if within(row["strain"])]
    total = lambda name: sum(row[name] for row in rows)
    row = {name: test.parameters[name] for name in ("eta", "particles", "inertial_number", "seed")}
    row |= dict(strain=last) | {name: test.progress[name] for name in ("steps", "seconds")}
    found = observed(Ensemble([Network.load(path) for path in paths]))
    found |= dict(sin_phi=sin_phi([total("stress_x"), total("stress_y")]),
                  packing_fraction=total("packing_fraction") / len(rows),
                  missed=(total("unconverged_steps") + total("yielded_steps"))
                  / (rows[-1]["step"] - rows[0]["step"]) * (1 - 1 / len(rows)))
    if test.solver.meanForceChange:
        found["missed"] = math.nan  # steps may end above the tolerance
    return row | {name: float(value) for name, value in found.items()}


def observed(ensemble):
    """Observables of the cumulated contacts of networks, an `Ensemble`."""
    parts = ensemble.xi_networks
    half, weak, whole = np.transpose(parts.anisotropies(np.array([0.5, 1, ensemble.fn.max()])))
    ratio = parts.shear_stress_ratio(np.array([1, ensemble.fn.max()]))
    beta, _ = statistics.power_exponent(ensemble.fn, POWER_RANGE)
    return dict(friction_mobilization=ensemble.mobilization.mean(),
                weak_fraction=np.mean(ensemble.fn < 1), beta_n=beta, a_c_half=half[0],
                a_c_weak=weak[0], a_c=whole[0], a_ln=whole[1], a_fn_weak=weak[3], a_fn=whole[3],
                a_ft=whole[4], q_weak=ratio[0], q_over_p=ratio[1],
                half_sum=0.5 * whole.sum() / ratio[1], **ensemble.correlations())


# ---- limit, changes and figure

def slope_of_rates(rows, name):
    """Slope b of the fit y = y₀ + b √I, with a y₀ for each seed, and its standard error."""
    root = lambda row: math.sqrt(row["inertial_number"])
    groups = [np.array([(root(row), row[name]) for row in rows if row["seed"] == seed]).T
              for seed in {row["seed"] for row in rows}]
    return statistics.common_slope(groups)


def _with(rows, setting, strain=STRAIN):
    return [row for row in rows if _setting(row["point"]) == setting and row["strain"] == strain]


def _setting(point):
    """I/dt/iterations/tolerance of a point."""
    return point.split("/", 2)[2].rsplit("/", 1)[0]


def _groups(rows):
    """{(eta, particles): rows with numbers}"""
    groups = {}
    for row in rows:
        if row["status"] == "ok":
            groups.setdefault((row["eta"], row["particles"]), []).append(row)
    return dict(sorted(groups.items()))


def change(rows, others, name):
    """Mean difference of `others` from `rows` over equal seeds, and its standard error."""
    first = {row["seed"]: row[name] for row in rows}
    values = np.array([row[name] - first[row["seed"]] for row in others if row["seed"] in first])
    return (float(values.mean()) if len(values) else math.nan,
            float(statistics.standard_error(values)))


def changes(rows, name):
    """{label: (difference from BASE, error)} of the settings of one elongation and size."""
    base = _with(rows, BASE)
    found = {label: change(base, _with(rows, setting), name)
             for setting, (label, *_) in CHANGES.items()}
    rates = [row for setting in (BASE, *RATES) for row in _with(rows, setting)]
    slope, error = slope_of_rates(rates, name)
    step = -math.sqrt(float(BASE.split("/")[0]))
    if name != "missed":
        found[LIMIT[0]] = slope * step, -error * step
    found[LATER[0]] = change(base, _with(rows, BASE, LAST), name)
    return {label: pair for label, pair in found.items() if not math.isnan(pair[0])}


def ratios(rows):
    """Table of the means at BASE and of the changes by other settings."""
    labels = [label for label, *_ in (LIMIT, *CHANGES.values(), LATER)]
    yield ["observable", "elongation, particles", "mean", *labels]
    for name, title in OBSERVED.items():
        for (eta, particles), group in _groups(rows).items():
            values = [row[name] for row in _with(group, BASE)]
            if not values or math.isnan(values[0]):
                continue
            found = changes(group, name)
            cells = [_cell(*found[label]) if label in found else "" for label in labels]
            yield [title, f"η = {eta:g}, N = {particles:g}", f"{np.mean(values):.3g}", *cells]


def _cell(value, error):
    return f"{value:+.1g}" + (f" ± {error:.1g}" if math.isfinite(error) else "")


def plot(rows, options):
    groups = {key: group for key, group in _groups(rows).items() if _with(group, BASE)}
    figure = Figure(figsize=(2 + 3 * max(1, len(groups)), 11), layout="constrained")
    axes = figure.subplots(1, max(1, len(groups)), sharex=True, sharey=True, squeeze=False)[0]
    names = [name for name in OBSERVED if name != "missed"]  # an error of the solver
    styles = [LIMIT, *CHANGES.values(), LATER]
    step = 0.8 / (len(styles) - 1)
    for ax, ((eta, particles), group) in zip(axes, groups.items()):
        for k, name in enumerate(names):
            if k % 2:
                ax.axhspan(k - 0.5, k + 0.5, color="0.93", lw=0)
            found = changes(group, name)
            for j, (label, marker, fill) in enumerate(styles):
                value, error = found.get(label, (math.nan, math.nan))
                ax.errorbar([value], [k + step * (j - (len(styles) - 1) / 2)], color="k",
                            xerr=[np.nan_to_num(error)], marker=marker, mfc=fill, ms=5, lw=0.7,
                            ls="", label=label if k == 0 else None)
        ax.axvline(0, color="k", lw=0.7)
        ax.set(title=f"η = {eta:g}, N = {particles:g}", ylim=(len(names) - 0.5, -0.5),
               xlabel="change from the base setting")
        ax.set_yticks(range(len(names)), [OBSERVED[name] for name in names])
    if groups:
        legend_outside(figure, figure.axes[0], "lower center", 5, fontsize=9)
    return figure
