"""Time the contact solvers on one-step problems from files, alone and against Siconos.

Prints tables and writes them as CSV: sweeps (time per contact point and sweep), tolerances (time to
a residual, checked in NumPy), peers, growth (with the size of the problem), roofline. Times are the
minimum of several runs. With one thread they are processor time, which other programs hardly
change; with more they are wall-clock time.
"""

import json
import os
import re
import sys
import tempfile
from functools import partial

import numpy as np

import rcr._kernel as kernel
from benchmarks import ROOT, measure, outside, tables
from rcr import problems, script

TOLERANCES = 1e-4, 1e-6, 1e-8, 1e-10
SOLVERS = "nesterov", "exact", "auto"
SWEEPERS = "nlgs", "nesterov"
LANES = 1, 4, 8

ABOUT = ["problem", "shape", "bodies", "points"]
COLUMNS = dict(
    sweeps=[*ABOUT, "solver", "lanes", "threads", "ns", "ns_by_clock", "ratio_to_one_thread"],
    tolerances=[*ABOUT, "solver", "start", "tolerance", "iterations", "seconds", "residual",
                "residual_numpy", "reached", "siconos_seconds", "siconos_ratio"],
    peers=[*ABOUT, "peer", "start", "tolerance", "iterations", "seconds", "residual",
           "reached", "ns"],
    growth=["shape", "solver", "start", "problems", "points_from", "points_to", "sweeps_exponent",
            "seconds_exponent"],
    roofline=[*ABOUT, "solver", "megabytes", "bytes_per_point", "operations_per_point",
              "triad_gb_per_s", "ns_of_bytes", "ns_of_operations", "ns", "ns_a_point", "ns_a_pair"],
)

# Numbers that a sweep reads and writes for one contact point, and its arithmetic operations
# (packed_blocks.hpp, packed_kernels.cpp); a product with its sum counts as one. A pair reads two
# bodies of 4 numbers and two ids of 4 bytes, and writes the bodies. Momentum also reads and writes
# each body and its old record, and sweeps a large island in floats.
FIELDS_READ = dict(nlgs=14, nesterov=17)
FIELDS_WRITTEN = dict(nlgs=2, nesterov=4)
OPERATIONS = dict(nlgs=37, nesterov=45)
POINT_FIELDS, BODY_FIELDS, ID_BYTES = 18, 4, 4
REGISTER_BYTES = 64  # AVX-512, one operation a cycle
FLOAT_PAIRS = 1024  # larger islands are swept in floats


class Case:
    """A problem in the point order of the kernels, and its columns of the tables."""

    def __init__(self, name, problem):
        self.name, self.points = name, problem.contacts
        if isinstance(problem, problems.BodyProblem):
            self.arrays = problem.arrays()
            self.problem = problems.BodyProblem(**self.arrays)
            self.bodies = int((problem.inverse_mass > 0).all(1).sum())
            self.shape = "discs" if measure.lever(problem) < 1e-6 else "long"
            self.delassus = self.problem.delassus()
        else:
            self.problem = self.delassus = problem
            self.arrays, self.bodies, self.shape = None, None, "unknown"
        self.matrix = measure.matrix(self.delassus)
        self.about = dict(problem=name, shape=self.shape, bodies=self.bodies, points=self.points)

    def solve(self, warm=False, **settings):
        """Result of the kernel for this problem."""
        start = self.delassus.impulse if warm else np.zeros((self.points, 2))
        if self.arrays is not None:
            settings.update(self.arrays, impulse=start, kinematic_tolerance=np.inf)
            return kernel.solve(**settings)
        d = self.delassus
        return kernel.solve_delassus(d.row_start, d.column, d.block.reshape(-1, 4), d.q, d.friction,
                                     start, **settings)

    def residual(self, p):
        return measure.residual(self.matrix, self.delassus.q, self.delassus.friction, p)


# ---- measurements


def sweep_rows(case, repeats, threads):
    """Time of a sweep for every solver, lane width and number of threads."""
    if case.arrays is None:
        settings = [dict(solver=solver) for solver in SWEEPERS]
    else:
        settings = [dict(solver=s, lanes=n, threads=t, workspace=kernel.Workspace())
                    for s in SWEEPERS for n in LANES for t in threads]
    rows, of_one = [], {}
    runs = [(case.points, partial(case.solve, **setting)) for setting in settings]
    for setting, (clock, processor) in zip(settings, measure.sweep_times(runs, repeats)):
        shown = {key: setting.get(key) for key in ("solver", "lanes", "threads")}
        row = dict(case.about, ns_by_clock=clock, **shown)
        row["ns"] = processor if setting.get("threads", 1) == 1 else clock
        if "threads" in setting:
            one_thread = of_one.setdefault((row["solver"], row["lanes"]), clock)
            row["ratio_to_one_thread"] = one_thread / clock
        rows.append(row)
    return rows


def tolerance_rows(case, solver, warm, options):
    """Time and iterations to each tolerance, from large to small, up to the first not reached."""
    for tolerance in sorted(options.tolerances, reverse=True):

        def run():
            found = case.solve(warm, solver=solver, tolerance=tolerance,
                               max_iterations=options.max_iterations)
            return dict(found, seconds=found["processor_seconds"])

        (found,) = measure.best(options.repeats, options.budget, run)
        reached = bool(found["residual"] <= tolerance)
        yield dict(case.about, solver=solver, start="warm" if warm else "cold", tolerance=tolerance,
                   iterations=found["iterations"], seconds=found["seconds"],
                   residual=found["residual"], residual_numpy=case.residual(found["impulse"]),
                   reached=reached)
        if not reached:
            return


def siconos_rows(case, warm, options):
    """Time and iterations of Siconos, which runs in its own Python."""
    d, program = case.delassus, os.path.join(ROOT, "benchmarks", "peers", "siconos_solve.py")
    rows, columns, values = d.entries()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "problem.npz")
        start = d.impulse if warm else np.zeros((case.points, 2))
        np.savez(path, rows=rows, columns=columns, values=values, q=d.q, friction=d.friction,
                 start=start)
        answer = outside.run([options.siconos, program, path, "--limit", str(options.limit),
                              "--tolerances", *map(str, options.tolerances)])
    found = json.loads(answer.splitlines()[-1])  # Siconos may print lines before
    for row in found["rows"]:
        yield dict(case.about, peer="Siconos NSGS", start="warm" if warm else "cold", **row,
                   reached=row["residual"] <= row["tolerance"], ns=found["ns"])


def compare(rows, peers):
    """Add the best time of Siconos for the same start and tolerance."""
    key = lambda row: (row["problem"], row["start"], row["tolerance"])
    for row in rows:
        same = [peer for peer in peers if peer["reached"] and key(peer) == key(row)]
        if same:
            best = min(same, key=lambda peer: peer["seconds"])
            row.update(siconos_seconds=best["seconds"])
            if row["reached"]:
                row["siconos_ratio"] = best["seconds"] / row["seconds"]


def growth_rows(rows):
    """Exponents of sweeps and seconds over contact points, at the largest tolerance.

    Discs and long grains are fitted separately.
    """
    largest = max((row["tolerance"] for row in rows), default=None)
    groups = {}
    for row in rows:
        if row["tolerance"] == largest and row["reached"] and row["iterations"]:
            groups.setdefault((row["shape"], row["solver"], row["start"]), []).append(row)
    for (shape, solver, start), group in groups.items():
        points = [row["points"] for row in group]
        if max(points) >= 2 * min(points):  # else the exponent is noise
            yield dict(
                shape=shape, solver=solver, start=start, problems=len(group),
                points_from=min(points), points_to=max(points),
                sweeps_exponent=measure.exponent(points, [row["iterations"] for row in group]),
                seconds_exponent=measure.exponent(points, [row["seconds"] for row in group]))


def roofline_rows(case, repeats):
    """Time that memory traffic and arithmetic alone need, on one thread and 8 lanes.

    The costs of a pair and of a point follow from the same pairs with two points each.
    """
    if case.arrays is None:
        return
    doubled = Case(case.name, measure.with_two_points(case.problem))
    solve = lambda each, solver: partial(
        each.solve, solver=solver, lanes=LANES[-1], workspace=kernel.Workspace())
    runs = [(each.points, solve(each, solver)) for solver in SWEEPERS for each in (case, doubled)]
    times = measure.sweep_times(runs, repeats)[:, 1]
    pairs = len(np.unique(case.problem.bodies, axis=0)) / case.points
    bodies = len(case.problem.inverse_mass) / case.points
    for solver, ns, ns_doubled in zip(SWEEPERS, times[::2], times[1::2]):
        size = 4 if solver == "nesterov" and pairs * case.points > FLOAT_PAIRS else 8
        bytes_per_point = size * (POINT_FIELDS + BODY_FIELDS * bodies) + 2 * ID_BYTES * pairs
        megabytes = 1e-6 * case.points * bytes_per_point
        bandwidth = measure.triad_bandwidth(1e6 * megabytes)
        of_point = (ns_doubled * doubled.points - ns * case.points) / (doubled.points - case.points)
        volume = size * (FIELDS_READ[solver] + FIELDS_WRITTEN[solver])
        volume += (4 * BODY_FIELDS * size + 2 * ID_BYTES) * pairs
        volume += 4 * BODY_FIELDS * size * bodies if solver == "nesterov" else 0
        yield dict(case.about, solver=solver, megabytes=megabytes, bytes_per_point=volume,
                   operations_per_point=OPERATIONS[solver], triad_gb_per_s=1e-9 * bandwidth,
                   ns_of_bytes=1e9 * volume / bandwidth,
                   ns_of_operations=OPERATIONS[solver] * size / REGISTER_BYTES / clock_ghz(), ns=ns,
                   ns_a_point=of_point, ns_a_pair=(ns - of_point) / pairs)


def clock_ghz():
    """Clock of the processor in /proc/cpuinfo [GHz]; NaN if it is missing."""
    try:
        with open("/proc/cpuinfo") as file:
            found = re.search(r"cpu MHz\s*: ([\d.]+)", file.read())
    except OSError:
        found = None
    return float(found[1]) / 1000 if found else float("nan")


# ---- the script


def arguments():
    parser = script.Parser(prog="bench_solver.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("problems", nargs="*", metavar="PROBLEM",
        help="file .npz, .h5, .hdf5 or .dat (default: lattices, for sweeps only)")
    add("--mirror", type=script.at_least(0, 20), default=0, metavar="K",
        help="also each problem doubled 1 … K times by reflection at its walls")
    add("--only", nargs="+", choices=("sweeps", "tolerances"), default=["sweeps", "tolerances"],
        help="tables to measure (default: both)")
    add("--solvers", nargs="+", default=list(SOLVERS), metavar="S",
        help="solvers of the tolerances (default: nesterov exact auto)")
    add("--tolerances", type=script.number("numbers between 0 and 1", lambda v: 0 < v < 1),
        nargs="+", default=list(TOLERANCES), metavar="T",
        help="residuals to reach (default: 1e-4 1e-6 1e-8 1e-10)")
    add("--warm", action="store_true", help="start from the impulses in the files too")
    add("--threads", type=script.THREADS, nargs="+", default=[1, 2], metavar="N",
        help="numbers of threads of the sweeps (default: 1 2)")
    tables.add_repeats(parser, 20, budget=5)
    add("--max-iterations", type=script.at_least(1), default=100000, metavar="N",
        help="largest number of iterations (default %(default)s)")
    add("--siconos", metavar="PYTHON",
        help="a Python with siconos.numerics and scipy, inside or outside the environment")
    add("--limit", type=script.number("seconds > 0", lambda v: v > 0), default=20, metavar="S",
        help="time limit of Siconos [s] (default %(default)s)")
    script.add_results(parser, "tables")
    return parser.parse_args()


def check(options):
    wrong = [name for name in options.solvers if name not in kernel.solver_names()]
    if wrong:
        raise ValueError(
            f"--solvers {wrong[0]}: expected some of {', '.join(kernel.solver_names())}")


def given(options):
    """(name, problem) of every problem, each followed by its doubled versions."""
    for name, problem in measure.given(options.problems):
        if not problem.contacts:
            raise ValueError(f"{name}: has no contacts; give a problem with contacts")
        yield name, problem
        for k in range(1, options.mirror + 1 if isinstance(problem, problems.BodyProblem) else 1):
            problem = measure.mirrored(problem, seed=k)
            yield f"{name} x{2**k}", problem


def measured(options):
    """{name: rows} of every table."""
    made = {name: [] for name in COLUMNS}
    for name, problem in given(options):
        case = Case(name, problem)
        print(f"{name}: {case.points} contact points", file=sys.stderr)
        if "sweeps" in options.only:
            made["sweeps"] += sweep_rows(case, options.repeats, options.threads)
            made["roofline"] += roofline_rows(case, options.repeats)
        if "tolerances" in options.only:
            for warm in (False, True) if options.warm else (False,):
                rows = [row for solver in options.solvers
                        for row in tolerance_rows(case, solver, warm, options)]
                peers = list(siconos_rows(case, warm, options)) if options.siconos else []
                compare(rows, peers)
                made["tolerances"] += rows
                made["peers"] += peers
    made["growth"] = list(growth_rows(made["tolerances"]))
    return made


def main():
    options = arguments()
    check(options)
    tables.store("bench_solver.py", options, COLUMNS, measured)
