"""Chart g. Estimate of the error of a solve against its true error (`benchmarks.true_error`).

Problems are first steps of the scenes of chart h, and steps of sheared packings with and without
friction. Each is solved from zero impulses and from a warm start: that of the step, or in the
scenes of chart h the solution for free velocities that differ by 5 %. Solves stop after a number of
sweeps of `nesterov`, or by the default settings of `auto`. The true error is the larger one of
velocities and forces; solves without a reference solution have none and are left out.
"""

import numpy as np
from matplotlib.figure import Figure
from yade.wrapper import Omega

from benchmarks import charts, true_error
from benchmarks.charts import one_step
from benchmarks.charts.scenes_with_answers import SCENES
from benchmarks.hard_scenes import stage
from rcr import _kernel as kernel
from rcr import problems
from rcr._yade.last_problem import last_problem

O = Omega()
COLUMNS = ("scene particles eta seed friction start stop estimate converged velocities"
           " forces").split()
DEPENDS = "quick", "protocol"
SWEEPS = 20, 40, 80, 160, 320, 640, 1280
DEFAULT = dict(solver="auto", tolerance=1e-4, accuracy=0.01, max_iterations=1000)
ETAS = 0.0, 0.3, 0.7, 0.9
CHANGE = 0.05  # of the free velocities of a warm start, standard deviation [-]
FACTOR, LEAST_SHARE, TENTH = 3, 0.95, 0.1  # aim: 95 % within a factor of 3, none below a tenth
CLEAR = 1e-3  # true errors above it count in the table [-]
CLASSES = CHAINS, RODS, SMOOTH, ROUGH = ("rows, columns and slots", "rods on carts, bricks",
                                         "packings without friction", "packings with friction")


def points(options):
    """Names scene/bodies/eta/seed."""
    scenes = (10, 100) if options.quick else (10, 30, 100, 300, 1000)
    packings = {100: 1, 250: 1} if options.quick else {100: 3, 300: 3, 1000: 1, 2000: 1}  # seeds
    return ([f"{scene}/{count}/0/1" for scene in SCENES for count in scenes]
            + [f"packing/{count}/{eta:g}/{seed}" for count, seeds in packings.items()
               for eta in ETAS for seed in range(1, seeds + 1)])


def run(name, options):
    scene, count, eta, seed = name.split("/")
    about = dict(scene=scene, particles=int(count), eta=float(eta), seed=int(seed))
    if scene == "packing":
        path, _ = one_step.files_of(int(count), float(eta), options, int(seed))
        problem = problems.load(path).arrays()
        smooth = dict(problem, friction=0 * problem["friction"],
                      impulse=problem["impulse"] * [1, 0])
        cases = [(True, problem), (False, smooth)]
    else:
        cases = [(None, _first_step(scene, int(count)))]
    rows = [dict(about, friction=friction, start=start, **row)
            for friction, problem in cases for start in ("cold", "warm")
            for row in _solves(problem, start)]
    if not rows:
        raise ValueError("`exact` reaches no reference solution")
    return rows


def _first_step(scene, count):
    """Problem of the first step of a scene of chart h, with a warm start of another load."""
    SCENES[scene](stage.ContactDynamics(), count)
    O.run(1, True)
    problem = last_problem(stage.solver()).arrays()
    noise = np.random.default_rng(1).normal(1, CHANGE, problem["free_velocity"].shape)
    other = dict(problem, free_velocity=problem["free_velocity"] * noise)
    return dict(problem, impulse=kernel.solve(**other, **true_error.REFERENCE)["impulse"])


def _solves(problem, start):
    """Rows of all stops that have a true error."""
    if start == "cold":
        problem = dict(problem, impulse=np.zeros_like(problem["impulse"]))
    stops = {count: dict(solver="nesterov", tolerance=0, max_iterations=count) for count in SWEEPS}
    for stop, settings in (stops | dict(auto=DEFAULT)).items():
        found = kernel.solve(**problem, **settings)
        error = true_error.true_error(problem, found["impulse"])
        if error:
            yield dict(stop=stop, estimate=found["error_estimate"], converged=found["converged"],
                       **error)


# ---- the figure and the table

def _class(row):
    if row["scene"] == "packing":
        return ROUGH if str(row["friction"]) == "True" else SMOOTH
    return RODS if row["scene"] in ("cart", "bricks") else CHAINS


def _error(row):
    return max(row["velocities"], row["forces"])


def ratios(rows):
    """Table of the agreement of the estimate with the true error, by class."""
    yield ["solves", "number", f"within a factor of {FACTOR}", "below a tenth", "above ten times",
           "median ratio", f"of estimates below 1: within a factor of {FACTOR}", "aim met"]
    for title in CLASSES:
        for stop in "sweeps", "auto":
            chosen = [row for row in rows if _class(row) == title and _error(row) > CLEAR
                      and (row["stop"] == "auto") == (stop == "auto")]
            if chosen:
                yield [f"{title}, {stop}", f"{len(chosen)}", *_agreement(chosen)]


def _agreement(rows):
    ratio = np.array([row["estimate"] / _error(row) for row in rows])
    close_to = (ratio <= FACTOR) & (ratio >= 1 / FACTOR)
    close, below, above = np.mean(close_to), np.mean(ratio < TENTH), np.mean(ratio > 1 / TENTH)
    met = "yes" if close >= LEAST_SHARE and below == 0 else "no"
    of_small = close_to[[row["estimate"] < 1 for row in rows]]
    share = lambda found: f"{100 * found:.1f} %"
    return [*map(share, (close, below, above)), f"{np.median(ratio):.2g}",
            f"{share(np.mean(of_small))} ({len(of_small)})" if len(of_small) else "", met]


TRUE, ESTIMATED = np.array([1e-6, 10]), np.array([1e-6, 100])  # axes [-]
PANELS = (("scenes of chart h, and packings without friction", lambda row: _class(row) != ROUGH,
           lambda row: row["scene"] if row["scene"] != "packing" else SMOOTH),
          ("packings with friction", lambda row: _class(row) == ROUGH,
           lambda row: f"η = {row['eta']:g}"))


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(12, 7))
    for ax, (title, belongs, label) in zip(figure.subplots(1, 2, sharey=True), PANELS):
        _panel(ax, [(label(row), row) for row in rows if belongs(row)])
        ax.set_title(title, fontsize=10, y=1.14)
        ax.set_xlabel("true error, the larger one of velocities and forces [-]")
    figure.axes[0].set_ylabel("estimated error [-]")
    figure.subplots_adjust(wspace=0.12, top=0.82)
    return figure


def _panel(ax, labelled):
    ax.fill_between(TRUE, TRUE / FACTOR, TRUE * FACTOR, color="0.88", lw=0,
                    label=f"within a factor of {FACTOR}")
    ax.plot(TRUE, TRUE * TENTH, color="0.4", lw=1, ls="--", label="a tenth of the true error")
    for k, name in enumerate(sorted({name for name, _ in labelled})):
        for marker, stops in ("o", lambda stop: stop != "auto"), ("*", lambda stop: stop == "auto"):
            chosen = [row for label, row in labelled if label == name and stops(row["stop"])]
            x = np.clip([_error(row) for row in chosen], *TRUE)
            y = np.clip([row["estimate"] for row in chosen], *ESTIMATED)
            ax.plot(x, y, marker, color=f"C{k}", ms=4 if marker == "o" else 9, mew=0.5,
                    mec="w" if marker == "o" else "k", alpha=0.7,
                    label=name if marker == "o" else None)
    ax.plot([], [], "*", color="w", mec="k", ms=9, label="default settings of auto")
    ax.set(xscale="log", yscale="log", xlim=TRUE, ylim=ESTIMATED)
    ax.grid(alpha=0.3)
    ax.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3,
              columnspacing=1, handletextpad=0.4)
