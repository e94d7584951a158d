"""Chart c. The biaxial test to 20 % of strain: true errors of its steps and errors of its
observables against processor time.

All runs of one elongation and seed start from the same frictionless packing (rigid contacts,
`Biaxial.compact`), with the loads and walls of scripts/biaxial.py. Observables are means over
strains of 10 to 20 %: q/p and packing fraction over all records, the others over one network a per
cent. Energies come from a further per cent with O.trackEnergy, over the work of the walls. Laws:

    cd       ContactDynamics, over dt/t₀, tolerance, accuracy and rate, one of them at a time
    smooth   Law2_RcrGeom_FrictPhys_CundallStrack, over k_n/σ₀, as with `--law smooth`
    stock    YADE without this plugin: Law2_ScGeom_FrictPhys_CundallStrack, over k_n/σ₀ of a sphere,
             local damping 0.2. Clumps of spheres of the cap radius, every R'/2 along the core, have
             the mass and inertia of the grain.

The error of a setting is the mean over seeds of its difference from the reference of the same
packing: rigid contacts with the shortest step and the smallest tolerance and accuracy, for rates
the slowest one. Its error bar is the standard deviation of the differences over √seeds; smaller
differences are noise.

The true error of a step (`benchmarks.true_error`) is the mean over one step a per cent of strain.
Such a step is solved again, with its settings and warm start. The spread of the solutions is the
mean of the same steps; the band is the mean over all tests of an elongation.
"""

import math
import os
import time

import numpy as np
from matplotlib.figure import Figure
from yade.wrapper import Omega

from benchmarks import charts, true_error
from benchmarks.charts.yade_clumps import Stock
from rcr import _kernel as kernel
from rcr._yade.last_problem import last_problem
from rcr.statistics import standard_error
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import ONE_RATE, PROTOCOL
from rcr.study.shear import switch_to_springs

O = Omega()
STRESS = PROTOCOL.confining_stress  # [Pa]
TITLES = dict(sin_phi="q/p", packing_fraction="packing fraction", friction_mobilization="I_M",
              mobilized="share of sliding contacts (I_m > 0.99)",
              weak_fabric="fabric of weak contacts, a_c(ξ = 1)",
              friction_share="share of the work that friction takes",
              mean_overlap="mean overlap [d]", energy_error="work unaccounted for")
OBSERVED = tuple(TITLES)
TRUE = true_error.TITLES
SPREADS = tuple(f"spread_{name}" for name in TRUE)
ERRORS = "mean_overlap", "energy_error", *TRUE, *SPREADS  # errors themselves, without a reference
SETTING = "law", "dt", "tolerance", "accuracy", "inertial_number", "stiffness"
COLUMNS = ["eta", "particles", *SETTING, "seed", "steps", "seconds", *OBSERVED, *TRUE, *SPREADS]
DEPENDS = "quick", "particles", "protocol"
ETAS = 0.0, 0.5
STRAIN, FROM, LOOK, ACCOUNT = 0.2, 0.1, 0.01, 0.01
RATE = 1e-3
DEFAULT = dict(dt=0.1, tolerance=1e-4, accuracy=0.01, inertial_number=RATE)  # one differs
FINEST = dict(dt=0.05, tolerance=1e-5, accuracy=1e-3, inertial_number=RATE)  # reference
SLOWEST = dict(DEFAULT, inertial_number=5e-4)  # reference of rates
SWEEPS = dict(dt=(0.4, 0.2, 0.1, 0.05), tolerance=(1e-2, 1e-3, 1e-4),
              accuracy=(math.inf, 0.1, 0.01, 1e-3), inertial_number=(4e-3, 2e-3, RATE))
MAX_ITERATIONS = 1000  # of a step, enough to reach the tolerance
LEAST = 5e-3  # lower edge of the panel of true errors [-]
SLIDING = 0.99  # smallest I_m of a sliding contact


def compacted(eta, seed, options):
    """Compacted packing of an elongation and a seed, made at the first call."""
    folder = charts.folder("packings", f"n{options.particles}-e{eta:g}-s{seed}", options)
    if not os.path.exists(os.path.join(folder, "checkpoint.yade.gz")):
        os.makedirs(folder, exist_ok=True)
        test = Biaxial.prepare(eta, options.particles, seed, threads=1, **ONE_RATE)
        test.compact()
        test.save(folder)
    return Biaxial.load(folder)


# ---- the chart

def _sheared(test, rigid):
    """Shear to 20 % of strain; returns means over the second half, `rigid`: with true errors."""
    seconds, networks, overlaps, steps, look = 0.0, [], [], [], FROM + LOOK
    while not test.has_reached(STRAIN):
        start = time.process_time()
        test.shear_record()
        seconds += time.process_time() - start
        if test.has_reached(look):
            network = test.network()
            mobilization = network.friction_mobilization()
            networks.append((mobilization.mean(), (mobilization > SLIDING).mean(),
                             network.anisotropies(1.0)[0]))
            overlaps.append(test.overlaps().mean())
            if rigid:
                steps.append(_errors_of_last_step(test))
            look += LOOK
    late = [row for row in test.rows if row["strain"] > FROM]
    mean = lambda name: float(np.mean([row[name] for row in late]))
    names = "friction_mobilization", "mobilized", "weak_fabric"
    found = dict(zip(names, map(float, np.mean(networks, axis=0))))
    found |= dict(sin_phi=mean("sin_phi"), packing_fraction=mean("packing_fraction"),
                  mean_overlap=float(np.mean(overlaps)), seconds=seconds)
    return found | _means(steps) | _energies(test)


def _errors_of_last_step(test):
    """True errors of the last step and the spread of its solutions; {} without a reference."""
    solver, problem = test.solver, last_problem(test.solver).arrays()
    position = np.array([body.state.pos for body in O.bodies])[:, :2]
    found = kernel.solve(**problem, solver=solver.solver, tolerance=solver.tolerance,
                         accuracy=solver.accuracy, max_iterations=solver.maxIterations)
    spread = true_error.spread(problem, position)
    return (true_error.true_error(problem, found["impulse"], position)
            | {f"spread_{name}": value for name, value in spread.items()})


def _means(steps):
    """Means over the steps that have the value."""
    values = {name: [step[name] for step in steps if name in step] for name in (*TRUE, *SPREADS)}
    return {name: float(np.mean(found)) for name, found in values.items() if found}


def _energies(test):
    """Dissipation by friction and unaccounted energy over the work of the walls in `ACCOUNT`.
    YADE's accounts lag by a step, and count a local damping of the driven top wall that does not
    act.
    """
    O.trackEnergy = True
    last = _work(test)
    first, work, end = _accounts(), np.zeros(2), test.strain + ACCOUNT
    while test.strain < end:
        work += last
        last = _work(test)
    O.trackEnergy = False
    friction, other = _accounts() - first
    error = abs(work.sum() - friction - other + O.engines[-1].damping * work[0])
    return dict(friction_share=friction / work.sum(), energy_error=error / work.sum())


def _work(test):
    """Make a step; returns the work of the top wall and of the loads on the side walls [J]."""
    left, right = (O.bodies[wall].state for wall in (test.left, test.right))
    spreading, load = lambda: right.vel[0] - left.vel[0], STRESS * test.height
    before = spreading()
    O.step()
    of_top = O.forces.f(test.top)[1] * O.bodies[test.top].state.vel[1]
    return -O.dt * np.array([of_top, load * (before + spreading()) / 2])


def _accounts():
    """Dissipation by friction so far, and all other dissipated or stored energy [J]."""
    accounts = dict(O.energy.items())
    other = "kinetic", "impactDissip", "viscDissip", "nonviscDamp", "elastPotential"
    return np.array([accounts.get("plastDissip", 0), sum(accounts.get(name, 0) for name in other)])


def points(options):
    """Names eta/law/setting/seed; that of rigid contacts is dt/tolerance/accuracy/rate."""
    rigid = [FINEST, SLOWEST, *(dict(DEFAULT, **{name: value})
                                for name, values in SWEEPS.items() for value in values)]
    settings = dict.fromkeys("/".join(["cd", *(f"{value:g}" for value in s.values())])
                             for s in rigid)
    stiffnesses = (1e2, 1e3) if options.quick else (1e2, 1e3, 1e4)
    springs = [f"{law}/{k:g}" for law in ("smooth", "stock") for k in stiffnesses]

    def names(settings, seeds):
        return [f"{eta:g}/{setting}/{seed}"
                for seed in range(1, seeds + 1) for eta in ETAS for setting in settings]

    return names(settings, 2 if options.quick else 6) + names(springs, 2)


def run(name, options):
    eta, law, *setting, seed = name.split("/")
    row = dict(eta=float(eta), particles=options.particles, law=law, seed=int(seed))
    keys = tuple(DEFAULT) if law == "cd" else ("stiffness", )
    row.update(zip(keys, map(float, setting)))
    test = compacted(row["eta"], row["seed"], options)
    test.parameters["inertial_number"] = row.get("inertial_number", RATE)
    first = O.iter
    if law == "smooth":
        switch_to_springs(test, row["stiffness"])
    elif law == "stock":
        test, first = Stock(test, row["stiffness"]), 0
    else:
        test.parameters["time_step"] = row["dt"]
        test.solver.tolerance, test.solver.accuracy = row["tolerance"], row["accuracy"]
        test.solver.maxIterations = MAX_ITERATIONS
    return [dict(row, **_sheared(test, law == "cd"), steps=O.iter - first)]


def _difference(runs, target, name):
    """Processor time [s], mean difference from the target, if any, its standard error or NaN."""
    exact = lambda seed: 0 if name in ERRORS else target[seed][name]
    differences = [row[name] - exact(seed) for seed, row in runs.items()
                   if seed in target and isinstance(row.get(name), float)]
    if not differences:
        return None
    seconds = np.mean([row["seconds"] for row in runs.values()])
    return seconds, np.mean(differences), float(standard_error(differences))


def sweeps(rows, name):
    """{setting or law: [(value, processor time [s], error, standard error)]} of one elongation."""
    runs = {}  # {setting: {seed: row}}
    for row in rows:
        runs.setdefault(tuple(row.get(key, "") for key in SETTING), {})[row["seed"]] = row
    rigid = lambda **changed: runs.get(("cd", *dict(DEFAULT, **changed).values(), ""), {})
    finest, slowest = rigid(**FINEST), rigid(**SLOWEST)
    found = {}
    for swept, values in SWEEPS.items():
        target = slowest if swept == "inertial_number" else finest
        found[swept] = [(value, _difference(rigid(**{swept: value}), target, name))
                        for value in values]
    for law in ("smooth", "stock"):
        settings = sorted((setting for setting in runs if setting[0] == law), key=str)
        found[law] = [(setting[-1], _difference(runs[setting], finest, name))
                      for setting in settings]
    return {swept: [(value, *difference) for value, difference in line if difference]
            for swept, line in found.items()}


LABELS = dict(dt="rigid, dt/t₀ = 0.4 … 0.05", tolerance="rigid, tolerance 1e-2 … 1e-4",
              accuracy="rigid, accuracy ∞ … 1e-3",
              inertial_number="rigid, I = 4e-3 … 1e-3",
              smooth="springs on RCRs, k_n/σ₀ = 10², 10³ …",
              stock="YADE's clumps, k_n/σ₀ = 10², 10³ …")
STYLES = dict(dt=("0", "o", "-"), tolerance=("0", "s", "--"),
              accuracy=("C3", "P", "-"), inertial_number=("0", "^", ":"),
              smooth=("0.55", "D", "-"), stock=("0.55", "v", "--"))


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    titles = {"velocities": "true error of velocities in a step [-]"} | TITLES
    figure = Figure(figsize=(9, 2.6 * len(titles)))
    for line, name in zip(figure.subplots(len(titles), len(ETAS), sharex="col"), titles):
        for ax, eta in zip(line, ETAS):
            chosen = [row for row in rows if row["eta"] == eta]
            _draw_sweeps(ax, sweeps(chosen, name))
            ax.set(xscale="log", yscale="log")
            if name == "velocities":
                seconds = [row["seconds"] for row in chosen] or [1, 10]
                width = 0.8 * min(seconds), 1.25 * max(seconds)  # axhspan would include 1e-3 s
                ax.fill_between(width, LEAST, max(LEAST, _mean_spread(chosen)), color="0.88", lw=0,
                                label="spread of the solutions")
                ax.set_xlim(width)
            title = titles[name] if name in ERRORS else "error of " + TITLES[name]
            ax.set_title(f"η = {eta:g}: {title}", fontsize=10)
            ax.grid(alpha=0.3)
            if name != "mean_overlap":
                ax.set_ylim(bottom=LEAST if name == "velocities" else 1e-4)
            if name == OBSERVED[-1]:
                ax.set_xlabel("processor time [s]")
    figure.tight_layout(rect=(0, 0, 1, 0.95))
    charts.add_legend(figure, ncol=2, fontsize=9)
    return figure


def _mean_spread(rows):
    """Spread of the velocities of solutions, mean over all tests that have one [-]."""
    found = [row["spread_velocities"] for row in rows
             if isinstance(row.get("spread_velocities"), float)]
    return float(np.mean(found)) if found else 0.0


def _draw_sweeps(ax, lines):
    for swept, points in lines.items():
        if not points:
            continue
        _, seconds, difference, error = np.array(points).reshape(-1, 4).T
        color, marker, dashes = STYLES[swept]
        size, above = np.abs(difference), np.nan_to_num(error)
        below = np.minimum(above, 0.999 * size)  # keeps bars above 0 on the log axis
        ax.errorbar(seconds, size, (below, above), color=color, marker=marker, ls=dashes, ms=5,
                    mfc="w" if swept in ("dt", "smooth") else color, lw=1, label=LABELS[swept])


def _formatted(name, difference, error):
    if name in ERRORS:
        return f"{difference:.1e}"
    return f"{difference:+.1g}" + ("" if math.isnan(error) else f" ± {error:.0e}")


NAMES = dict(dt="dt/t₀ = {:g}", tolerance="tolerance {:.0e}", accuracy="accuracy {:g}",
             inertial_number="I = {:g}")  # of the settings of rigid contacts


def true_errors(rows):
    """Table of the true errors of steps by setting, and of the spreads of their solutions."""
    yield ["η", "setting", "seconds", *TRUE.values(), "spread of velocities", "spread of forces"]
    shown = *TRUE, "spread_velocities", "spread_forces"
    for eta in ETAS:
        chosen = [row for row in rows if row["eta"] == eta]
        for swept, values in SWEEPS.items():
            for value in values:
                of = [row for row in chosen
                      if all(row.get(name) == wanted
                             for name, wanted in dict(DEFAULT, **{swept: value}).items())]
                means = [[row[name] for row in of if isinstance(row.get(name), float)]
                         for name in ("seconds", *shown)]
                yield [f"{eta:g}", NAMES[swept].format(value),
                       *(f"{np.mean(cells):.2g}" if cells else "unknown" for cells in means)]


def ratios(rows):
    """Table of the errors of each setting, with standard errors, and its processor time."""
    yield ["setting", "seconds", *TITLES.values()]
    names = NAMES | dict(smooth="springs, k_n/σ₀ = {:.0e}", stock="clumps, k_n/σ₀ = {:.0e}")
    for eta in ETAS:
        chosen = [row for row in rows if row["eta"] == eta]
        of_eta = {name: sweeps(chosen, name) for name in OBSERVED}
        for swept, line in of_eta[OBSERVED[0]].items():
            for k, (value, seconds, *_) in enumerate(line):
                cells = [_formatted(name, *of_eta[name][swept][k][2:]) for name in OBSERVED]
                yield [f"η = {eta:g}, {names[swept].format(value)}", f"{seconds:.2g}", *cells]
