"""Time each reduction of the model: the same problems with and without it, on one thread.

Problems are lattices of discs, or the given files. A reduction for frictionless problems is timed
without friction. Times are processor time, the minimum of several runs: per contact point and
sweep, or of a whole solution.
"""

from functools import partial

import numpy as np

import rcr._kernel as kernel
from benchmarks import measure, tables
from rcr import problems, script

ALL = ["frictionless", "discs", "fixed", "islands", "layout"]
COLUMNS = ["reduction", "problem", "points", "what", "full", "reduced", "full_over_reduced"]


def without(*names):
    """All reductions but these."""
    return [name for name in ALL if name not in names]


def frictionless(given):
    """The problem without friction."""
    return {**given, "friction": 0 * given["friction"], "impulse": given["impulse"] * [1, 0]}


def beside(parts):
    """One problem of several that do not touch."""
    columns, count = {key: [] for key in parts[0]}, 0
    for part in parts:
        for key, value in part.items():
            columns[key].append(value + count if key == "bodies" else value)
        count += len(part["inverse_mass"])
    return {key: np.concatenate(values).astype(np.int32 if key == "bodies" else float)
            for key, values in columns.items()}


def heap(discs, seed):
    """A lattice that falls on the floor of a fixed box; more discs take more sweeps."""
    given = measure.lattice(discs, seed)
    walls = slice(len(given["inverse_mass"]) - 4, None)
    given["inverse_mass"][walls] = given["free_velocity"][walls] = 0
    given["free_velocity"][: walls.start, 1] -= 0.05
    return given


def single_grain():
    """A disc on a fixed floor."""
    return dict(inverse_mass=np.array([[1.0, 1, 8], [0, 0, 0]]),
                free_velocity=np.array([[0.1, -0.1, 0.3], [0, 0, 0]]),
                bodies=np.array([[0, 1]], np.int32), normal=np.array([[0.0, -1]]),
                arm1=np.array([[0.1, -0.5]]), arm2=np.zeros((1, 2)), bias=np.zeros(1),
                friction=np.full(1, 0.5), impulse=np.zeros((1, 2)))


def full_and_reduced(given, left_out, **settings):
    """Two calls of the solver: without the reductions `left_out`, and with all."""
    settings.update(given, kinematic_tolerance=np.inf)
    solve = partial(kernel.solve, **settings)
    return [partial(solve, workspace=kernel.Workspace(), reductions=without(*left))
            for left in (left_out, ())]


def row(name, about, given, what, full, reduced):
    return dict(reduction=name, problem=about, points=len(given["bodies"]), what=what, full=full,
                reduced=reduced, full_over_reduced=full / reduced)


def sweep_row(name, about, given, left_out, solver, repeats):
    runs = [(len(given["bodies"]), solve)
            for solve in full_and_reduced(given, left_out, solver=solver)]
    return row(name, about, given, f"sweeps of {solver} [ns]",
               *measure.sweep_times(runs, repeats)[:, 1])


def call_row(name, about, given, left_out, repeats, what, **settings):
    times = call_times(full_and_reduced(given, left_out, **settings), repeats)
    return row(name, about, given, f"{what} [µs]", *times)


def call_times(calls, repeats):
    """Processor time of each call [µs], the minimum of several."""
    times = [lambda call=call: call()["processor_seconds"] for call in calls]
    return [1e6 * seconds for seconds in measure.best(repeats, 60, *times)]


def residuals(parts, impulse):
    """Residual of each problem in the joint solution."""
    end = np.cumsum([len(part["bodies"]) for part in parts])
    of_parts = zip([problems.BodyProblem(**part).delassus() for part in parts],
                   np.split(impulse, end[:-1]))
    return [measure.residual(measure.matrix(d), d.q, d.friction, p) for d, p in of_parts]


def island_rows(about, parts, tolerance, repeats):
    """Cost until each island has reached the tolerance.

    Without the reduction, one residual over all islands ends the sweeps. It is lowered until the
    last island has reached the tolerance.
    """
    given = beside(parts)
    settings = dict(given, kinematic_tolerance=np.inf, solver="nesterov", max_iterations=20000)
    as_one = dict(reductions=without("islands"), tolerance=tolerance)
    while max(residuals(parts, kernel.solve(**settings, **as_one)["impulse"])) > tolerance:
        as_one["tolerance"] /= 1.1
    solve = partial(kernel.solve, **settings)
    ways = [partial(solve, **way, workspace=kernel.Workspace())
            for way in (as_one, dict(tolerance=tolerance))]
    work = [way()["work"] for way in ways]
    yield row("islands", about, given, f"sweeps × points to {tolerance:g} each", *work)
    yield row("islands", about, given, f"to {tolerance:g} each [µs]", *call_times(ways, repeats))


def rows(given, options):
    repeats = options.repeats
    for name, problem in given:
        slippery = frictionless(problem)
        # normals with levers
        turning = dict(slippery, arm1=slippery["arm1"] + 0.1, arm2=slippery["arm2"] - 0.1)
        both = ["frictionless", "discs"]
        for solver in "nlgs", "nesterov":
            yield sweep_row("frictionless", name, turning, both, solver, repeats)
            yield sweep_row("discs", name, slippery, ["discs"], solver, repeats)
            yield sweep_row("both", name, slippery, both, solver, repeats)
        yield sweep_row("fixed", name, problem, ["fixed"], "nesterov", repeats)
        yield sweep_row("islands", name + ", one island", problem, ["islands"], "nesterov", repeats)
        sweeps = dict(what="40 sweeps", solver="nesterov", tolerance=0, max_iterations=40)
        yield call_row("islands", name + ", one island", problem, ["islands"], repeats, **sweeps)
        yield call_row("layout", name, problem, ["layout"], repeats, **sweeps)
    heaps = [heap(40 * 2**k, k) for k in range(5)] + [heap(60, 10 + k) for k in range(4)]
    yield from island_rows("nine heaps", heaps, 1e-4, repeats)
    grains = [single_grain() for _ in range(1000)]
    yield from island_rows("1000 grains on a floor", grains, 1e-4, repeats)


def main():
    parser = script.Parser(prog="bench_reductions.py", description=__doc__.splitlines()[0])
    parser.add_argument(
        "problems", nargs="*", metavar="PROBLEM",
        help="file .npz with bodies (default: lattices of 500, 2000 and 8000 discs)")
    tables.add_repeats(parser, 20)
    script.add_results(parser, "table", required=False)
    options = parser.parse_args()
    given = measure.given(options.problems)
    for name, problem in given:
        if not isinstance(problem, problems.BodyProblem):
            raise ValueError(f"{name}: holds W and q; expected bodies, give a .npz file")
    arrays = [(name, problem.arrays()) for name, problem in given]
    measured = lambda options: dict(reductions=list(rows(arrays, options)))
    tables.store("bench_reductions.py", options, dict(reductions=COLUMNS), measured)
