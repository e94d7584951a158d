"""Chart i. What the error of a step means for the observables of the biaxial test.

A test with the default settings stores a state every 3 % of strain, from 15 % on, where the
shear is slow. From each state, `STEPS` steps are made again, solved to each of `ERRORS` by the
estimate, and with at most each number of `SWEEPS`; tests of many grains make at most
`Protocol.iterations`. All thus have the same packings, and their differences no noise of
different ones.

Observables are those of the network of the last step. Its forces change by ‖f − f'‖/‖f'‖
from the smallest error, over all pairs of grains.
"""

import os
import time

import numpy as np
from matplotlib.figure import Figure
from scipy.sparse import csr_array
from scipy.sparse.linalg import norm as sparse_norm
from yade.wrapper import Omega

from benchmarks import charts
from benchmarks.charts import quasi_static
from rcr import _kernel as kernel
from rcr.ensemble import Ensemble
from rcr.statistics import standard_error
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT

O = Omega()
NAMES = "beta_n", "weak_fraction", "a_c_half", "a_c_weak", "c_f_lr", "friction_mobilization"
TITLES = {name: quasi_static.OBSERVED[name] for name in (*NAMES, "sin_phi")} | dict(
    tiny_share="share of forces below ⟨f⟩/10")
COLUMNS = "eta particles seed strain error estimate missed sweeps seconds force_change".split() + [
    *TITLES]
DEPENDS = "quick", "particles", "protocol"
ETAS = 0.0, 0.7
FIRST, LAST, INTERVAL = 0.15, 0.3, 0.03  # strains of the states
STEPS = 40
ERRORS = 0.01, 0.03, 0.1, 0.3
FINEST = ERRORS[0]
SWEEPS = 30, 100, 300
LIMITS = {f"{sweeps} sweeps": sweeps for sweeps in SWEEPS}  # stand in place of an error
MOST_SWEEPS = 20_000


def points(options):
    """Names eta/seed."""
    return [f"{eta:g}/{seed}" for seed in range(1, 2 if options.quick else 4) for eta in ETAS]


def run(name, options):
    eta, seed = name.split("/")
    about = dict(eta=float(eta), particles=options.particles, seed=int(seed))
    rows = []
    for path in _states(float(eta), int(seed), options):
        reference = None
        for error in (*ERRORS, *LIMITS):
            test = Biaxial.load(path)
            row = dict(about, strain=test.strain, error=error, **_steps(test, error))
            network = test.network()
            reference = reference or network
            rows.append(row | _observables(network)
                        | dict(force_change=_change(network, reference)))
    return rows


def _states(eta, seed, options):
    """Folders of the states of the test with the default settings, made at the first call."""
    folder = charts.folder("states", f"n{options.particles}-e{eta:g}-s{seed}", options)
    wanted = np.arange(FIRST, LAST + INTERVAL / 2, INTERVAL)
    folders = [os.path.join(folder, f"{strain:.3f}") for strain in wanted]
    if not os.path.exists(os.path.join(folders[-1], CHECKPOINT)):
        test = Biaxial.prepare(eta, options.particles, seed, threads=1)
        test.compact()
        for strain, path in zip(wanted, folders):
            while not test.has_reached(strain):
                test.shear_record()
            os.makedirs(path, exist_ok=True)
            test.save(path)
    return folders


def _steps(test, error):
    """Make the steps; return their means."""
    solver = test.solver
    if error in LIMITS:
        solver.maxIterations = LIMITS[error]
    else:
        solver.accuracy, solver.maxIterations = error / kernel.solution_spread, MOST_SWEEPS
    estimates, missed, sweeps, start = [], 0, 0, time.process_time()
    for _ in range(STEPS):
        O.step()
        estimates.append(solver.errorEstimate)
        missed += not solver.converged
        sweeps += solver.iterations
    return dict(estimate=float(np.median(estimates)), missed=missed / STEPS, sweeps=sweeps / STEPS,
                seconds=time.process_time() - start)


def _observables(network):
    found = quasi_static.observed(Ensemble([network]))
    return {name: float(found[name]) for name in NAMES} | dict(
        sin_phi=network.sin_phi(), tiny_share=network.weak_share(0.1))


def _change(network, reference):
    """‖f − f'‖/‖f'‖ over the pairs of grains; a force is 0 where the pair bears none."""
    force = [_force_matrices(n) for n in (network, reference)]
    difference, size = (np.sqrt(sum(sparse_norm(m)**2 for m in matrices)) for matrices in (
        [one - other for one, other in zip(*force)], force[1]))
    return float(difference / size)


def _force_matrices(network):
    """Sparse matrices (N, N) of both components of the forces of pairs of grains [N/m]."""
    c, count = network.contacts, len(network.particles["id"])
    pick = network.between_particles
    pairs = c["body1"][pick], c["body2"][pick]
    return [csr_array((f, pairs), (count, count)) for f in c["force"][pick].T]


# ---- the figure and the table

def _differences(rows, name):
    """{error: differences of an observable from the smallest error, at the same states}."""
    exact = {(row["seed"], row["strain"]): row[name] for row in rows if row["error"] == FINEST}
    found = {}
    for row in rows:
        found.setdefault(row["error"], []).append(row[name] - exact[row["seed"], row["strain"]])
    return {error: np.array(values) for error, values in found.items()}


def ratios(rows):
    """Table of the observables and of their changes with the error of the steps."""
    yield ["η", "error of a step", "estimate", "sweeps a step", "missed steps",
           "change of forces", *TITLES.values()]
    for eta in ETAS:
        chosen = [row for row in rows if row["eta"] == eta]
        if not chosen:
            continue
        for error in (*ERRORS, *LIMITS):
            of = [row for row in chosen if row["error"] == error]
            mean = lambda name: np.mean([row[name] for row in of])
            cells = [_mean(chosen, error, name) for name in TITLES]
            label = error if error in LIMITS else f"{100 * error:g} %"
            estimate = np.median([row["estimate"] for row in of])
            known = f"{100 * estimate:.0f} %" if estimate < 1 else "unknown"
            yield [f"{eta:g}", label, known, f"{mean('sweeps'):.0f}",
                   f"{100 * mean('missed'):.0f} %", f"{mean('force_change'):.2g}", *cells]


def _mean(rows, error, name):
    """Mean at the smallest error, or mean change from it, with the standard error, as text."""
    if error == FINEST:
        values, sign = [row[name] for row in rows if row["error"] == error], ""
    else:
        values, sign = _differences(rows, name)[error], "+"
    if not np.isfinite(values).all():
        return "–"
    return f"{np.mean(values):{sign}.3f} ± {standard_error(values):.3f}"


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(12, 5.5))
    for ax, name in zip(figure.subplots(2, 4).flat, TITLES):
        for k, eta in enumerate(ETAS):
            found = _differences([row for row in rows if row["eta"] == eta], name)
            errors = [error for error in ERRORS if np.isfinite(found.get(error, np.nan)).all()]
            bars = [standard_error(found[error]) for error in errors]
            ax.errorbar(errors, [found[error].mean() for error in errors], bars, marker="o", ms=4,
                        color=f"C{k}", label=f"η = {eta:g}")
        ax.axhline(0, color="0.7", lw=1)
        ax.set(xscale="log", xlabel="error of a step [-]")
        ax.set_title("change of " + TITLES[name], fontsize=9)
    figure.tight_layout(rect=(0, 0, 1, 0.94))
    charts.add_legend(figure, ncol=2)
    return figure
