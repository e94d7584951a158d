"""Chart j. True errors of solves of large packings, of single bodies and of cells of many.

Problems are steps of packings sheared to a strain of 1 % as in chart a. Each is solved from its
warm start and from zero impulses, by a number of sweeps or by the default settings. The reference
is what `auto` reaches from the same start (`true_error.swept`). The spread is the distance of the
references of both starts. Errors are those of `benchmarks.true_error`, with momenta of the grains
of 8 × 8 and 2 × 2 cells.
"""

import numpy as np
from matplotlib.figure import Figure

from benchmarks import charts, true_error
from benchmarks.charts import estimate, one_step
from rcr import _kernel as kernel
from rcr import problems
from rcr.network import Network

ERRORS = true_error.TITLES
COLUMNS = ["particles", "eta", "start", "method", "sweeps", "seconds", "residual", "estimate",
           *ERRORS]
DEPENDS = "quick", "protocol"
ETAS = 0.0, 0.7
SWEEPS = dict(nesterov=(40, 80, 160, 320, 640, 1280, 2560, 5120), nlgs=(80, 320, 1280, 5120))
AUTO, REFERENCE, SPREAD = one_step.DEFAULT, "reference", one_step.SPREAD
STYLES = dict(velocities="-", cells_8="--", cells_2=":")


def points(options):
    """Names particles/eta."""
    return [f"{count}/{eta:g}" for count in ((250,) if options.quick else (5000, 13000))
            for eta in ETAS]


def run(name, options):
    count, eta = name.split("/")
    path, present = one_step.files_of(int(count), float(eta), options)
    problem = problems.load(path).arrays()
    position = np.zeros((len(problem["inverse_mass"]), 2))
    position[: int(count)] = Network.load(present).particles["position"]  # grains, then walls
    rows, references = [], []
    for start in "warm", "cold":
        if start == "cold":
            problem = dict(problem, impulse=np.zeros_like(problem["impulse"]))
        reference = true_error.swept(problem, problem["impulse"])
        references.append(reference["impulse"])
        rows.append(dict(start=start, **_row(REFERENCE, reference)))
        for method, found in _solves(problem):
            errors = true_error.distance(problem, found["impulse"], references[-1], position)
            rows.append(dict(start=start, **_row(method, found), **errors))
    rows.append(dict(method=SPREAD, **true_error.distance(problem, *references, position)))
    return [dict(particles=int(count), eta=float(eta), **row) for row in rows]


def _solves(problem):
    for method, counts in SWEEPS.items():
        for count in counts:
            yield method, kernel.solve(**problem, solver=method, tolerance=0, max_iterations=count)
    yield AUTO, kernel.solve(**problem, **estimate.DEFAULT)


def _row(method, found):
    return dict(method=method, sweeps=found["iterations"], seconds=found["processor_seconds"],
                residual=found["residual"], estimate=found["error_estimate"])


# ---- the figure and the table

def ratios(rows):
    """Table of the errors of each solve, and of the residual of its reference."""
    yield ["grains", "η", "start", "method", "sweeps", "time [s]", "residual", "estimate",
           *ERRORS.values()]
    for row in rows:
        error = [f"{row[name]:.2g}" if isinstance(row.get(name), float) else "" for name in ERRORS]
        if row["method"] == SPREAD:
            cells = ["", SPREAD, "", "", "", ""]
        else:
            known = row["estimate"] < 1
            cells = [row["start"], row["method"], f"{row['sweeps']:.0f}", f"{row['seconds']:.2g}",
                     f"{row['residual']:.0e}", f"{row['estimate']:.2g}" if known else ""]
        yield [f"{row['particles']:.0f}", f"{row['eta']:g}", *cells, *error]


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    packings = sorted({(row["particles"], row["eta"]) for row in rows})
    figure = Figure(figsize=(4 * max(2, len(packings)), 5))
    axes = figure.subplots(1, max(1, len(packings)), sharey=True, squeeze=False)[0]
    for ax, (count, eta) in zip(axes, packings):
        _panel(ax, [row for row in rows if (row["particles"], row["eta"]) == (count, eta)])
        ax.set_title(f"{count:g} grains, η = {eta:g}", fontsize=10)
        ax.set_xlabel("processor time [s]")
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("true error, warm starts [-]")
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    charts.add_legend(figure, ncol=5, fontsize=9)
    return figure


def _panel(ax, rows):
    for row in rows:
        if row["method"] == SPREAD:
            ax.axhspan(1e-3, row["velocities"], color="0.88", lw=0,
                       label=f"{SPREAD} (velocities)")
    warm = [row for row in rows if row.get("start") == "warm"]
    for method in (*SWEEPS, AUTO):
        of, star = [row for row in warm if row["method"] == method], method == AUTO
        for name, style in STYLES.items():
            ax.loglog([row["seconds"] for row in of], [row[name] for row in of],
                      "*" if star else f"o{style}", color="k" if star else charts.COLORS[method],
                      ms=9 if star else 3, lw=1,
                      label=method if star else f"{method}, {ERRORS[name]}")
    ax.set_ylim(1e-3, 5)
