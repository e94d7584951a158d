"""Chart h. Where methods fail: scenes of N bodies whose momentum or base force is known.

Each point is one step of 1 ms from zero impulses, by one method and else the default settings of
ContactDynamics. Rows have the relative error of the momentum or the force. Filled markers:
`converged` is True.
"""

import time

from matplotlib.figure import Figure
from yade.wrapper import Omega

from benchmarks import charts
from benchmarks.charts import SOLVERS as METHODS
from benchmarks.charts.scenes_with_answers import SCENES
from benchmarks.hard_scenes import stage

O = Omega()
COLUMNS = "scene bodies method error seconds converged estimate iterations".split()
DEPENDS = ("quick",)
TITLES = dict(row="row struck by a wall:\nmomentum", column="column of discs:\nforce on the floor",
              slot="discs in a slot:\nforce on the floor",
              cart="rods on a cart:\nforce on the cart",
              bricks="flat rods beside a wall:\nforce on the floor")
LEAST = 1e-6  # smaller errors are drawn at this height [-]
RUNS = 3  # of a step; the fastest counts
GOAL = 0.01  # default accuracy [-]


def points(options):
    """Names scene/bodies/method."""
    counts = (10, 100) if options.quick else (10, 30, 100, 300, 1000)
    return [f"{scene}/{count}/{method}"
            for scene in SCENES for count in counts for method in METHODS]


def run(name, options):
    scene, count, method = name.split("/")
    law = stage.ContactDynamics(dict(solver=method, threads=1))
    seconds = []
    for _ in range(1 + RUNS):
        error = SCENES[scene](law, int(count))
        start = time.process_time()
        O.run(1, True)
        seconds.append(time.process_time() - start)
    solver = stage.solver()
    return [dict(scene=scene, bodies=int(count), method=method, error=error(),
                 seconds=min(seconds[1:]),  # the first run loads libraries
                 converged=solver.converged, estimate=solver.errorEstimate,
                 iterations=solver.iterations)]


def _true(cell):
    return cell in (True, "True")


def ratios(rows):
    """Table of the errors by scene and method; brackets: the step has not converged."""
    counts = sorted({row["bodies"] for row in rows})
    yield ["scene", "method", *(f"N = {count:g}" for count in counts)]
    cells = {(row["scene"], row["method"], row["bodies"]):
             f"{row['error']:.0e}" if _true(row["converged"]) else f"({row['error']:.0e})"
             for row in rows}
    for scene, title in TITLES.items():
        for method in METHODS:
            yield [title.partition(":")[0], method,
                   *(cells.get((scene, method, count), "") for count in counts)]


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(14, 6))
    axes = figure.subplots(2, len(TITLES), sharex=True, sharey="row")
    for column, (scene, title) in zip(axes.T, TITLES.items()):
        for method in METHODS:
            of = [row for row in rows if (row["scene"], row["method"]) == (scene, method)]
            chosen = sorted(of, key=lambda row: row["bodies"])
            if chosen:
                _curve(column, chosen, method)
        column[0].axhline(GOAL, color="0.6", lw=1, ls=":")
        column[0].set_title(title, fontsize=9)
        column[1].set_xlabel("bodies N")
        for ax in column:
            ax.grid(alpha=0.3)
    axes[0, 0].set(ylabel="relative error [-]", ylim=(LEAST / 2, 5))
    axes[1, 0].set_ylabel("processor time of the step [ms]")
    charts.add_legend(figure, ncol=len(METHODS), fontsize=9)
    figure.text(0.5, 0.925, "filled: the step says that it has converged; open: it says that it "
                "has not; dotted: default accuracy", ha="center", fontsize=8)
    figure.subplots_adjust(top=0.83, hspace=0.08, wspace=0.06)
    return figure


def _curve(column, rows, method):
    color = charts.COLORS[method]
    count = [row["bodies"] for row in rows]
    values = [[max(row["error"], LEAST) for row in rows], [1e3 * row["seconds"] for row in rows]]
    for ax, value in zip(column, values):
        ax.loglog(count, value, "-", color=color, lw=1)
        for row, x, y in zip(rows, count, value):
            ax.loglog(x, y, "o", color=color, ms=4, mfc=color if _true(row["converged"]) else "w")
        ax.loglog([], [], "o-", color=color, ms=4, lw=1, label=method)
