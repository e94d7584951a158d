"""Chart a. One step of a sheared packing: residual against time of each solver, cold and warm.

Rows are those of scripts/bench_solver.py and scripts/bench_step.py. Problems with 'x8' are mirrored
three times and changed by 5 % (`benchmarks.measure.mirrored`): large problems without large tests.
"""

import math
import os
from functools import partial
from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from benchmarks import bench_solver, bench_step, charts, measure
from benchmarks import packing as packings
from rcr import problems
from rcr.study.biaxial import Biaxial

COLUMNS = ("problem eta particles contacts library start tolerance iterations seconds"
           " residual").split()
DEPENDS = "quick", "protocol"
SOLVERS = "nlgs", "sor", "nesterov", "exact", "auto"
STEPPED = "chipmunk", "box2d"  # libraries whose steps are timed
ETAS = 0.0, 0.4, 0.7
STRAIN = 0.01
LEVELS = [10.0**-k for k in range(2, 11)]
LIBRARIES = *SOLVERS, "Siconos NSGS", "Chipmunk", "Box2D"
COLORS = dict(zip(LIBRARIES, "C0 C9 C1 C3 k C2 C4 C5".split()))


def sizes(options):
    """(particles of the test, number of reflections)."""
    return [(250, 0), (250, 3)] if options.quick else [(500, 0), (1600, 1), (1600, 3)]


def points(options):
    stepped = [name for name in STEPPED if os.path.exists(_program(name, options))]
    libraries = [*SOLVERS, *(["siconos"] if options.siconos else []), *stepped]
    return [f"{n * 2**k}/{eta:g}/{library}"
            for n, k in sizes(options) for eta in ETAS for library in libraries
            if library not in STEPPED or k == 0]


def _program(name, options):
    return os.path.join(options.peers, f"{name}_step")


def _files(particles, eta, options):
    """Paths of the problem and the network of a sheared packing, made at the first call."""
    base = charts.folder("problems", f"n{particles}_e{eta:g}", options)
    if not os.path.exists(base + ".h5"):
        os.makedirs(os.path.dirname(base), exist_ok=True)
        test = Biaxial.prepare(eta, particles, threads=1)
        test.compact()
        test.shear(math.inf, STRAIN)
        test.solver.save(base + ".npz")
        test.network().save(base + ".h5")
    return base + ".npz", base + ".h5"


def run(name, options):
    count, eta, library = name.split("/")
    particles, mirror = next((n, k) for n, k in sizes(options) if n * 2**k == int(count))
    problem, network = _files(particles, float(eta), options)
    title = f"n{particles}_e{float(eta):g}" + (f" x{2**mirror}" if mirror else "")
    about = dict(eta=float(eta), particles=int(count), problem=title)
    if library in STEPPED:
        rows = _stepped(library, network, options)
    else:
        problem = problems.load(problem)
        for k in range(1, mirror + 1):
            problem = measure.mirrored(problem, seed=k)
        rows = _solved(library, problem, options)
    return [dict(about, **row) for row in rows]


def _solved(library, problem, options):
    """Rows of the time to each tolerance, cold and warm, up to the first not reached."""
    ours, case = library != "siconos", bench_solver.Case("", problem)
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
                           residual=row["residual"])


def _stepped(library, network, options):
    """Rows of a whole step of a game library, over the number of iterations."""
    packing, program = packings.load(network), _program(library, options)
    for iterations in (10, 40, 160) if options.quick else (10, 40, 160, 640):
        given = SimpleNamespace(repeats=3, budget=1, friction=0.5, iterations=iterations, steps=20,
                                present=network)
        for row in bench_step.peer_rows(library, program, packing, given):
            yield dict(library=row["library"], contacts=row["points"], start=row["start"],
                       iterations=iterations, seconds=1e-3 * row["ms"], residual=row["residual"])


def ratios(rows):
    """Table of the time of each library over that of `auto`: least – largest (number of pairs)."""
    least = {}  # (residual, library, problem and start): seconds
    for row in rows:
        for level in LEVELS:
            key = level, row["library"], (row["particles"], row["eta"], row["start"])
            if row["residual"] <= level:
                least[key] = min(row["seconds"], least.get(key, np.inf))
    others = list(dict.fromkeys(library for _, library, _ in least if library != "auto"))
    yield ["time over that of auto", *others]
    for level in LEVELS:
        cells = []
        for library in others:
            found = [seconds / least[level, "auto", of] for (at, who, of), seconds in least.items()
                     if (at, who) == (level, library) and (level, "auto", of) in least]
            cells.append(f"{min(found):.2g} – {max(found):.2g} ({len(found)})" if found else "")
        yield [f"{level:.0e}", *cells]


def _panel(ax, rows):
    for library in dict.fromkeys(row["library"] for row in rows):
        color = next((value for key, value in COLORS.items() if library.startswith(key)), "0.5")
        for start, style in ("cold", "o-"), ("warm", "s--"):
            curve = [(row["seconds"], max(row["residual"], 1e-13)) for row in rows
                     if (row["library"], row["start"]) == (library, start)]
            if curve:
                filled = start == "cold"
                ax.loglog(*np.array(curve).T, style, color=color, ms=3, lw=1,
                          label=library if filled else None, mfc=color if filled else "w")


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    counts = sorted({row["particles"] for row in rows})
    figure = Figure(figsize=(4 * len(counts), 9))
    axes = figure.subplots(len(ETAS), len(counts), squeeze=False, sharey=True)
    for line, eta in zip(axes, ETAS):
        for ax, count in zip(line, counts):
            _panel(ax, [row for row in rows if (row["particles"], row["eta"]) == (count, eta)])
            ax.set_title(f"{count:g} particles, η = {eta:g}", fontsize=9)
            ax.grid(alpha=0.3)
        line[0].set_ylabel("residual of the contact laws")
    for ax in axes[-1]:
        ax.set_xlabel("processor time [s]")
    charts.add_legend(figure, ncol=4, bbox_to_anchor=(0.5, 1.0), fontsize=8)
    figure.text(0.5, 0.93, "filled, full line: cold start; open, dashed: warm start", ha="center",
                fontsize=8)
    figure.subplots_adjust(top=0.89, hspace=0.35, wspace=0.1)
    return figure
