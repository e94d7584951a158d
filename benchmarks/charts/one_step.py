"""Chart a. One step of a sheared packing: true error against time of each solver, cold and warm.

The true error (`benchmarks.true_error`) is the larger one of velocities and forces. The shaded band
is the spread of the solutions of the problem. Rows are those of scripts/bench_solver.py and
scripts/bench_step.py. Problems with 'x2' are mirrored and changed by 5 %
(`benchmarks.measure.mirrored`). Packings of more than 500 grains have residuals only: `exact`
reaches few solutions of them.
"""

import math
import os
from functools import partial
from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from benchmarks import bench_solver, bench_step, charts, measure, true_error
from benchmarks import packing as packings
from rcr import problems
from rcr.study.biaxial import Biaxial

COLUMNS = ("problem eta particles contacts library start tolerance iterations seconds"
           " residual velocities forces").split()
DEPENDS = "quick", "protocol"
DEFAULT = "auto, default settings"  # the star
SPREAD = "spread of the solutions"  # the band
MOST_JUDGED = 500  # grains of packings with a true error, at most
STEPPED = "chipmunk", "box2d"  # libraries whose steps are timed
ETAS = 0.0, 0.4, 0.7
STRAIN = 0.01
ERRORS = 0.3, 0.1, 0.03, 0.01, 1e-3  # true errors of the table [-]
RESIDUALS = [10.0**-k for k in range(2, 11)]
RANGE = 1e-3, 2  # of the true errors in the figure [-]


def sizes(options):
    """(particles of the test, number of reflections)."""
    return [(250, 0), (250, 1)] if options.quick else [(250, 0), (500, 0), (1600, 1)]


def points(options):
    stepped = [name for name in STEPPED if os.path.exists(_program(name, options))]
    libraries = ["spread", *charts.SOLVERS, "default", *(["siconos"] if options.siconos else []),
                 *stepped]
    return [f"{n * 2**k}/{eta:g}/{library}"
            for n, k in sizes(options) for eta in ETAS for library in libraries
            if not (library in STEPPED and k or library == "spread" and n * 2**k > MOST_JUDGED)]


def _program(name, options):
    return os.path.join(options.peers, f"{name}_step")


def files_of(particles, eta, options, seed=1):
    """Paths of the problem and the network of a sheared packing, made at the first call."""
    name = f"n{particles}_e{eta:g}" + (f"_s{seed}" if seed != 1 else "")
    base = charts.folder("problems", name, options)
    if not os.path.exists(base + ".h5"):
        os.makedirs(os.path.dirname(base), exist_ok=True)
        test = Biaxial.prepare(eta, particles, seed, threads=1)
        test.compact()
        test.shear(math.inf, STRAIN)
        test.solver.save(base + ".npz")
        test.network().save(base + ".h5")
    return base + ".npz", base + ".h5"


def run(name, options):
    count, eta, library = name.split("/")
    particles, mirror = next((n, k) for n, k in sizes(options) if n * 2**k == int(count))
    problem, network = files_of(particles, float(eta), options)
    title = f"n{particles}_e{float(eta):g}" + (f" x{2**mirror}" if mirror else "")
    about = dict(eta=float(eta), particles=int(count), problem=title)
    if library in STEPPED:
        rows = _stepped(library, network, options)
    else:
        problem = problems.load(problem)
        for k in range(1, mirror + 1):
            problem = measure.mirrored(problem, seed=k)
        case = bench_solver.Case("", problem)
        rows = dict(spread=_spread, default=_default).get(library, partial(_solved, library))(
            case, options)
    return [dict(about, **row) for row in rows]


def _spread(case, options):
    """Row of the distance between the solutions from the warm start and from zero impulses."""
    return [dict(library=SPREAD, contacts=case.points, **true_error.spread(case.arrays))]


def _default(case, options):
    """Rows of one solve with the default settings of ContactDynamics, cold and warm."""
    for warm in False, True:
        run = partial(case.solve, warm, solver="auto", tolerance=1e-4, accuracy=0.01)
        (found,) = measure.best(5, 1, run)
        yield dict(library=DEFAULT, contacts=case.points, start="warm" if warm else "cold",
                   iterations=found["iterations"], seconds=found["processor_seconds"],
                   residual=found["residual"], **_judged(case, found["impulse"]))


def _judged(case, impulse):
    """True error of impulses; {} if the problem is too large."""
    judged = case.about["bodies"] <= MOST_JUDGED
    return true_error.true_error(case.arrays, impulse) if judged else {}


def _solved(library, case, options):
    """Rows of the time to each tolerance, cold and warm, up to the first not reached."""
    ours = library != "siconos"
    given = SimpleNamespace(
        repeats=3, budget=1, tolerances=[float(f"1e-{k}") for k in range(1, 11 if ours else 9)],
        max_iterations=5000 if options.quick else 10000, siconos=options.siconos,
        limit=2 if options.quick else 10,
    )  # fmt: skip
    measured = (partial(bench_solver.tolerance_rows, case, library) if ours
                else partial(bench_solver.siconos_rows, case))
    for warm in False, True:
        for row in measured(warm, given):
            if ours or row["reached"]:
                yield dict(library=row.get("solver") or row["peer"], contacts=case.points,
                           start=row["start"], tolerance=row["tolerance"],
                           iterations=float(row["iterations"]), seconds=row["seconds"],
                           residual=row["residual"], **_judged(case, row["impulse"]))


def _stepped(library, network, options):
    """Rows of a whole step of a game library, over the number of iterations."""
    packing, program = packings.load(network), _program(library, options)
    for iterations in (10, 40, 160) if options.quick else (10, 40, 160, 640):
        given = SimpleNamespace(repeats=3, budget=1, friction=0.5, iterations=iterations, steps=20,
                                present=network)
        for row in bench_step.peer_rows(library, program, packing, given):
            yield dict(library=row["library"], contacts=row["points"], start=row["start"],
                       iterations=iterations, seconds=1e-3 * row["ms"],
                       **{name: row.get(name) for name in ("residual", "velocities", "forces")})


# ---- the figure and the tables

def _error(row):
    """Larger true error of velocities and forces; infinite without one."""
    found = [row.get(name) for name in ("velocities", "forces")]
    return max(found) if all(isinstance(value, float) for value in found) else math.inf


def _packing(row):
    return row["particles"], row["eta"]


def _spreads(rows):
    """{packing: spread of its solutions}."""
    return {_packing(row): _error(row) for row in rows if row["library"] == SPREAD}


def ratios(rows):
    """Table of the times to true errors; packings whose solutions differ by more do not count."""
    return _times(rows, "true error", ERRORS, _error, _spreads(rows))


def residuals(rows):
    """Table of the times to residuals."""
    return _times(rows, "residual", RESIDUALS, lambda row: row["residual"], {})


def _times(rows, title, levels, size, spreads):
    """Table of the time of each library over that of `auto`: least – largest (number of pairs)."""
    least = {}  # (level, library, problem and start): seconds
    for row in rows:
        for level in levels if row["library"] not in (SPREAD, DEFAULT) else ():
            key = level, row["library"], (*_packing(row), row["start"])
            if size(row) <= level and spreads.get(_packing(row), 0) <= level:
                least[key] = min(row["seconds"], least.get(key, np.inf))
    others = list(dict.fromkeys(library for _, library, _ in least if library != "auto"))
    yield [f"{title}: time over that of auto", *others]
    for level in levels:
        cells = []
        for library in others:
            found = [seconds / least[level, "auto", of] for (at, who, of), seconds in least.items()
                     if (at, who) == (level, library) and (level, "auto", of) in least]
            cells.append(f"{min(found):.2g} – {max(found):.2g} ({len(found)})" if found else "")
        yield [f"{level:g}", *cells]


def default_steps(rows):
    """Table of the true errors that the default settings leave, beside the spread."""
    spreads = _spreads(rows)
    yield ["grains", "η", "spread", *(f"{start}: {name}" for start in ("cold", "warm")
                                      for name in ("residual", "true error", "time [ms]"))]
    for packing in sorted(set(map(_packing, rows))):
        at = {row["start"]: row for row in rows
              if row["library"] == DEFAULT and _packing(row) == packing}
        shown = lambda value: f"{value:.2g}" if value < math.inf else "unknown"
        yield [f"{packing[0]:g}", f"{packing[1]:g}", shown(spreads.get(packing, math.inf)),
               *(text for start in ("cold", "warm") for text in
                 (f"{at[start]['residual']:.0e}", shown(_error(at[start])),
                  f"{1e3 * at[start]['seconds']:.2g}"))]


def _panel(ax, rows):
    for library in dict.fromkeys(row["library"] for row in rows):
        color = next((color for name, color in charts.COLORS.items() if library.startswith(name)),
                     "0.5")
        for start, style in ("cold", "o-"), ("warm", "s--"):
            curve = [(row["seconds"], min(max(_error(row), RANGE[0]), RANGE[1])) for row in rows
                     if (row["library"], row["start"]) == (library, start)
                     and _error(row) < math.inf]
            if curve:
                filled = start == "cold"
                star = library == DEFAULT
                ax.loglog(*np.array(curve).T, "*" if star else style, color=color, lw=1,
                          ms=10 if star else 3, label=library if filled else None,
                          mfc=color if filled else "w")


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok" and row["particles"] <= MOST_JUDGED]
    counts, spreads = sorted({row["particles"] for row in rows}), _spreads(rows)
    figure = Figure(figsize=(5.5 * max(2, len(counts)), 10))
    axes = figure.subplots(len(ETAS), max(1, len(counts)), squeeze=False, sharey=True)
    for line, eta in zip(axes, ETAS):
        for ax, count in zip(line, counts):
            _panel(ax, [row for row in rows if _packing(row) == (count, eta)
                        and row["library"] != SPREAD])
            spread = spreads.get((count, eta), math.inf)
            if spread < math.inf:
                ax.axhspan(0.7 * RANGE[0], max(spread, RANGE[0]), color="0.88", lw=0, label=SPREAD)
            ax.set_title(f"{count:g} grains, η = {eta:g}"
                         + ("" if spread < math.inf else " (spread unknown)"), fontsize=10)
            ax.set_ylim(0.7 * RANGE[0], 1.5 * RANGE[1])
            ax.grid(alpha=0.3)
        line[0].set_ylabel("true error [-]")
    for ax in axes[-1]:
        ax.set_xlabel("processor time [s]")
    charts.add_legend(figure, ncol=5, bbox_to_anchor=(0.5, 1.0), fontsize=8)
    figure.text(0.5, 0.93, "filled, full line: cold start; open, dashed: warm start. Errors below "
                f"{RANGE[0]:g} and above {RANGE[1]:g} are drawn there", ha="center", fontsize=8)
    figure.subplots_adjust(top=0.89, hspace=0.3, wspace=0.06)
    return figure
