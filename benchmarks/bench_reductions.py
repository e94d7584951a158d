"""Time each reduction of the model: the same problems with and without it, on one thread.

Problems are lattices of discs, or the given files. A reduction for frictionless problems is timed
without friction. Times are processor time, the minimum of several runs: per contact point and
sweep, or of a whole solution.
"""

from functools import partial

import numpy as np

import rcr._kernel as kernel
from benchmarks import measure, tables
from oracle import REDUCTIONS, residual_of, without
from rcr import problems, script

COLUMNS = ["reduction", "problem", "points", "what", "full", "reduced", "full_over_reduced"]
TOLERANCE = 1e-4  # of each island


def beside(parts):
    """One problem of several that do not touch."""
    first = np.cumsum([0] + [len(part["inverse_mass"]) for part in parts])
    parts = [dict(part, bodies=part["bodies"] + shift) for part, shift in zip(parts, first)]
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}


def heap(discs, seed):
    """A lattice that falls on the floor of a fixed box; more discs take more sweeps."""
    given = measure.lattice(discs, seed)
    given["inverse_mass"][-4:] = given["free_velocity"][-4:] = 0
    given["free_velocity"][:-4, 1] -= 0.05
    return given


def single_grain():
    """A disc on a fixed floor."""
    return dict(inverse_mass=np.array([[1.0, 1, 8], [0, 0, 0]]),
                free_velocity=np.array([[0.1, -0.1, 0.3], [0, 0, 0]]), bodies=np.array([[0, 1]]),
                normal=np.array([[0.0, -1]]), arm1=np.array([[0.1, -0.5]]), arm2=np.zeros((1, 2)),
                bias=np.zeros(1), friction=np.full(1, 0.5), impulse=np.zeros((1, 2)))


def ways(given, *options, **settings):
    """A call of the solver for each of `options`, each with its own workspace."""
    settings.update(given, accuracy=np.inf)
    return [partial(kernel.solve, workspace=kernel.Workspace(), **settings | more)
            for more in options]


def row(name, about, given, what, full, reduced):
    return dict(reduction=name, problem=about, points=len(given["bodies"]), what=what, full=full,
                reduced=reduced, full_over_reduced=full / reduced)


def call_times(calls, repeats):
    """Processor time of each call [µs], the minimum of several."""
    return [1e6 * found["processor_seconds"] for found in measure.best(repeats, 60, *calls)]


def largest_residual(parts, impulse):
    end = np.cumsum([len(part["bodies"]) for part in parts])
    return max(residual_of(problems.BodyProblem(**part).delassus(), p)
               for part, p in zip(parts, np.split(impulse, end[:-1])))


def island_rows(about, parts, repeats):
    """Cost until each island has the tolerance; one residual over all is lowered until then."""
    given = beside(parts)
    as_one = dict(reductions=without("islands"), tolerance=TOLERANCE)
    both = lambda: ways(given, as_one, dict(tolerance=TOLERANCE), solver="nesterov",
                        max_iterations=20000)
    while largest_residual(parts, both()[0]()["impulse"]) > TOLERANCE:
        as_one["tolerance"] /= 1.1
    calls = both()
    yield row("islands", about, given, f"sweeps × points to {TOLERANCE:g} each",
              *[call()["work"] for call in calls])
    yield row("islands", about, given, f"to {TOLERANCE:g} each [µs]", *call_times(calls, repeats))


def rows(given, repeats):
    for name, problem in given:
        cold = dict(problem, impulse=0 * problem["impulse"])  # a solution may end sweeps early
        slippery = dict(cold, friction=0 * problem["friction"])
        # normals with levers
        turning = dict(slippery, arm1=slippery["arm1"] + 0.1, arm2=slippery["arm2"] - 0.1)
        both, one_island = ["frictionless", "discs"], name + ", one island"
        of_sweeps = [row for solver in ("nlgs", "nesterov") for row in (
            ("frictionless", name, turning, both, solver), ("both", name, slippery, both, solver),
            ("discs", name, slippery, ["discs"], solver),
            ("discs, µ > 0", name, cold, ["discs"], solver))]
        of_sweeps += [("fixed", name, problem, ["fixed"], "nesterov"),
                      ("islands", one_island, problem, ["islands"], "nesterov")]
        for reduction, about, arrays, left_out, solver in of_sweeps:
            calls = ways(arrays, dict(reductions=without(*left_out)), {}, solver=solver)
            runs = [(len(arrays["bodies"]), call) for call in calls]
            yield row(reduction, about, arrays, f"sweeps of {solver} [ns]",
                      *measure.sweep_times(runs, repeats)[:, 1])
        for reduction, about in ("islands", one_island), ("layout", name):
            calls = ways(problem, dict(reductions=without(reduction)), {}, solver="nesterov",
                         tolerance=0, max_iterations=40)
            yield row(reduction, about, problem, "40 sweeps [µs]", *call_times(calls, repeats))
    heaps = [heap(40 * 2**k, k) for k in range(5)] + [heap(60, 10 + k) for k in range(4)]
    yield from island_rows("nine heaps", heaps, repeats)
    yield from island_rows("1000 grains on a floor", [single_grain()] * 1000, repeats)


def main():
    parser = script.Parser(prog="bench_reductions.py", description=__doc__.splitlines()[0])
    parser.add_argument(
        "problems", nargs="*", metavar="PROBLEM",
        help="file .npz with bodies (default: lattices of 500, 2000 and 8000 discs)")
    tables.add_repeats(parser, 20)
    script.add_results(parser, "table")
    options = parser.parse_args()
    given = measure.given(options.problems)
    for name, problem in given:
        if not isinstance(problem, problems.BodyProblem):
            raise ValueError(f"{name}: holds W and q; expected bodies, give a .npz file")
    arrays = [(name, problem.arrays()) for name, problem in given]
    tables.store("bench_reductions.py", options, dict(reductions=COLUMNS),
                 lambda options: dict(reductions=list(rows(arrays, options.repeats))))
