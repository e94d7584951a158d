"""Chart f. Cost over the number of grains: a column of discs collapses on a floor.

N discs with radii of 6 to 10 mm are deposited between two walls (`geometry/deposition.hpp`), twice
as high as wide. Without the walls they collapse. A point times 100 steps of 1 ms. Memory is the
peak of the process less its size before the scene. The method `nlgs` is the plain one.

Points N/true-error solve the problem of the last of these steps from zero impulses, with and
without friction, to a true error of velocities of 0.1. The reference is what `auto` reaches from
zero impulses (`true_error.swept`). The spread is its distance to what `auto` reaches from the
impulses of the previous step.
"""

import ctypes
import gc
import math
import pathlib
import time
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from yade.wrapper import Omega

import rcr
from rcr import _kernel as kernel
from rcr._yade.last_problem import last_problem
from rcr.study.summary import memory

from benchmarks import charts, true_error
from benchmarks.hard_scenes import stage

O = Omega()
STEPS = 100
COLUMNS = "particles method seconds bytes sweeps missed points friction reference spread".split()
DEPENDS = ("quick",)
METHODS = "auto", "nlgs"  # of the steps
SWEEPERS = "nlgs", "sor", "nesterov"
ERROR = 0.1  # true error of velocities [-]
TRUE_ERROR = "true-error"  # points of solves to ERROR
SEARCHED = 30_000  # most sweeps to ERROR
TOLERANCES = 10.0 ** -np.arange(1, 9.5, 0.5)  # of auto
PANELS = dict(seconds=("processor time per grain and step [µs]", 1e6), sweeps=("sweeps per step", 1),
              bytes=("memory per grain [kB]", 1e-3))


def points(options):
    """Names particles/method, small ones first."""
    counts = (100, 1000) if options.quick else (10**3, 10**4, 10**5, 10**6)
    costs = [f"{count}/{method}" for count in counts for method in METHODS]
    return costs + [f"{count}/{TRUE_ERROR}" for count in counts if count < 10**6]


def _column(count, method):
    """The scene; returns its solver."""
    radii = np.random.default_rng(1).uniform(0.6, 1, count) * stage.R
    centres = rcr._kernel.deposit(radii, math.sqrt(2 * np.sum(radii**2)))
    law = stage.ContactDynamics(dict(solver=method, threads=1, observe=[0]))
    grain = stage.material()
    stage.on_floor(partial(stage.build, law, stage.DT), grain,
                   *(rcr.particle(at, radius, 0, 0, grain) for at, radius in zip(centres, radii)))
    return O.engines[3]


def run(name, options):
    count, method = name.split("/")
    return _solves(int(count)) if method == TRUE_ERROR else _steps(int(count), method)


def _steps(count, method):
    """One row: cost of the first steps of the collapse."""
    _column(100, method)
    O.run(STEPS, True)  # loads all libraries
    O.reset()
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pathlib.Path("/proc/self/clear_refs").write_text("5")  # VmHWM begins here
    before = memory("VmRSS")
    solver = _column(count, method)
    start = time.process_time()
    O.run(STEPS, True)
    seconds = time.process_time() - start
    return [dict(particles=count, method=method, seconds=seconds / STEPS / count,
                 bytes=(memory("VmHWM") - before) / count, points=solver.contactPoints,
                 sweeps=solver.observed()["iterations"] / STEPS,
                 missed=solver.missedSteps / STEPS)]


def _solves(count):
    """Rows of the solves to ERROR: sweeps, and time a grain; without them if it is not reached."""
    solver = _column(count, "auto")
    O.run(STEPS, True)
    problem = last_problem(solver).arrays()
    cold, rows = np.zeros_like(problem["impulse"]), []
    for friction in problem["friction"], np.zeros_like(problem["friction"]):
        given = dict(problem, friction=friction)
        warm, reference = (true_error.swept(given, start) for start in (given["impulse"], cold))
        given["impulse"] = cold
        error = partial(_error, given, reference["impulse"])
        about = dict(particles=count, friction=friction.max(), points=len(friction),
                     reference=reference["residual"], spread=error(warm))
        for method in (*SWEEPERS, "auto"):
            found = (_first(error, (kernel.solve(**given, tolerance=t, max_iterations=SEARCHED,
                                                 accuracy=np.inf) for t in TOLERANCES))
                     if method == "auto" else _least_sweeps(given, method, error))
            rows.append(dict(about, method=method, **found))
    return rows


def _error(problem, reference, found):
    return true_error.distance(problem, found["impulse"], reference)["velocities"]


def _first(error, solves):
    """Sweeps and time of the first of the solves with at most ERROR; {} without one."""
    for found in solves:
        if error(found) <= ERROR:
            return dict(sweeps=found["iterations"], seconds=found["processor_seconds"])
    return {}


def _least_sweeps(problem, method, error):
    """Least sweeps to ERROR, to a factor of 2^(1/4), and their time; {} beyond SEARCHED."""
    solve = lambda sweeps: kernel.solve(**problem, solver=method, tolerance=0,
                                        max_iterations=round(sweeps))
    least = {}
    high, factor = 10, 2
    while high <= SEARCHED and not (least := _first(error, [solve(high)])):
        high *= factor
    while least and factor > 2**0.3:  # ERROR lies between high / factor and high
        factor **= 0.5
        better = _first(error, [solve(high / factor)])
        least, high = (better, high / factor) if better else (least, high)
    return least


# ---- the figure and the tables

def _is_solve(row):
    return isinstance(row.get("reference"), float)


def _is_reached(row):
    """Return whether the solve has reached ERROR; cells of a file are empty otherwise."""
    return row["sweeps"] not in ("", None)


def _curves(rows):
    """(method, rows of growing size) of every method."""
    rows = sorted((row for row in rows if row["status"] == "ok" and not _is_solve(row)),
                  key=lambda row: row["particles"])
    for method in METHODS:
        yield method, [row for row in rows if row["method"] == method]


def _exponent(last, row, name):
    """Exponent of a power law over the number of grains, from the size before.

    NaN if a number is not positive: the memory of a small scene may be below that freed meanwhile.
    """
    ratio = row[name] / last[name] if last[name] > 0 else 0
    grains = row["particles"] / last["particles"]
    return math.log(ratio) / math.log(grains) if ratio > 0 else math.nan


def ratios(rows):
    """Table of all points, with exponents over the number of grains from the size before."""
    yield ["method", "grains", *(f"{label} (exponent)" for label, _ in PANELS.values()),
           "steps that missed the tolerance"]
    for method, curve in _curves(rows):
        for last, row in zip([None, *curve], curve):
            cells = [f"{row[name] * unit:.3g}" + (f" ({_exponent(last, row, name):+.2f})" if last
                                                  else "") for name, (_, unit) in PANELS.items()]
            yield [method, f"{row['particles']:.0f}", *cells, f"{row['missed']:.2f}"]


def _to_error(rows):
    """{(friction, method): its rows of growing size} of the solves to ERROR."""
    solves = sorted(filter(_is_solve, rows), key=lambda row: (-row["friction"], row["particles"]))
    curves = {}
    for row in solves:
        curves.setdefault((row["friction"], row["method"]), []).append(row)
    return curves


def true_errors(rows):
    """Table of the sweeps to ERROR, with exponents over the number of grains, and of their time."""
    curves = _to_error(rows)
    methods = list(dict.fromkeys(method for _, method in curves))
    yield ["friction", "grains", "residual of the reference", "spread",
           *(f"{method}: sweeps (exponent), µs a grain" for method in methods)]
    for friction in dict.fromkeys(friction for friction, _ in curves):
        of = [curves[friction, method] for method in methods]
        for k, row in enumerate(of[0]):
            about = f"{row['reference']:.0e}", f"{row['spread']:.1g}"
            yield [f"{friction:g}", f"{row['particles']:.0f}", *about,
                   *(_cost(curve[k - 1] if k else None, curve[k]) for curve in of)]


def _cost(last, row):
    """Cell of the table of solves; empty if ERROR is not reached."""
    if not _is_reached(row):
        return ""
    known = last and _is_reached(last)
    exponent = f" ({_exponent(last, row, 'sweeps'):+.2f})" if known else ""
    return f"{row['sweeps']:.0f}{exponent}, {1e6 * row['seconds'] / row['particles']:.2g}"


def plot(rows, options):
    figure = Figure(figsize=(16, 4))
    *costs, last = figure.subplots(1, len(PANELS) + 1)
    for ax, (name, (label, unit)) in zip(costs, PANELS.items()):
        for method, curve in _curves(rows):
            ax.semilogx([row["particles"] for row in curve], [row[name] * unit for row in curve],
                        "o-", color=charts.COLORS[method], ms=4, lw=1, label=method)
        ax.set(xlabel="grains", ylabel=label, ylim=(0, None))
    for (friction, method), curve in _to_error(rows).items():
        reached = list(filter(_is_reached, curve))
        last.loglog([row["particles"] for row in reached], [row["sweeps"] for row in reached],
                    "o-" if friction else "o:", color=charts.COLORS[method], ms=4, lw=1,
                    label=method + ("" if friction else ", no friction"))
    last.set(xlabel="grains", ylabel=f"sweeps to a true error of {ERROR:g}")
    for ax in figure.axes:
        ax.grid(alpha=0.3)
    charts.add_legend(figure, ncol=4, bbox_to_anchor=(0.5, 1.02))
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    return figure
