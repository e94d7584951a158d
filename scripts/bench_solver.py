#!/usr/bin/env python3
"""Time the contact solvers on one-step problems from files, alone and against Siconos, and check their residuals in NumPy.

Prints tables and writes them as CSV: sweeps (time per contact point and sweep), tolerances (time to a residual), peers,
growth (with the size of the problem), roofline. Ratios are of one run; times are the minimum of several. Times of one
thread are processor time, which other programs on the machine hardly change; those of more are by the clock.
"""

import csv
import json
import os
import re
import sys
import tempfile
from functools import partial

from lib import environment  # puts bench on the path

from benchmarks import outside

try:
    from benchmarks import measure
    import numpy as np
    import rcr._kernel as kernel
    from rcr import problems, results, script
except ImportError as error:  # not for this Python: in the environment of yade-rcr there is one that fits
    environment.reenter(error, outside.stay)

TOLERANCES = 1e-4, 1e-6, 1e-8, 1e-10
SOLVERS = "nesterov", "exact", "auto"
SWEEPERS = "nlgs", "nesterov"
LANES = 1, 4, 8

ABOUT = ["problem", "shape", "bodies", "points"]
COLUMNS = dict(
    sweeps=[*ABOUT, "solver", "lanes", "threads", "ns", "ns_by_clock", "ratio_to_one_thread"],
    tolerances=[*ABOUT, "solver", "start", "tolerance", "iterations", "seconds", "residual", "residual_numpy", "reached",
                "siconos_seconds", "siconos_figure", "siconos_ratio"],
    peers=[*ABOUT, "peer", "figure", "start", "tolerance", "iterations", "seconds", "residual", "reached", "ns"],
    growth=["shape", "solver", "start", "problems", "points_from", "points_to", "sweeps_exponent", "seconds_exponent"],
    roofline=[*ABOUT, "solver", "megabytes", "bytes_per_point", "operations_per_point", "triad_gb_per_s", "ns_of_bytes", "ns_of_operations", "ns",
              "ns_a_point", "ns_a_pair"],
)  # fmt: skip

# What a sweep touches and computes for one contact point (packed_blocks.hpp, packed_kernels.cpp): numbers of the point read
# and written; sums, products, products with their sum, minima and maxima. A pair reads two bodies of 4 numbers and two ids of 4 bytes and writes the
# bodies; momentum also reads and writes each body and its old record. With momentum a large island is swept in floats.
FIELDS_READ = dict(nlgs=14, nesterov=17)
FIELDS_WRITTEN = dict(nlgs=2, nesterov=4)
OPERATIONS = dict(nlgs=37, nesterov=45)
POINT_FIELDS, BODY_FIELDS, ID_BYTES = 18, 4, 4
REGISTER_BYTES = 64  # AVX-512, one operation a cycle
FLOAT_PAIRS = 1024  # of an island, beyond which it is swept in floats


class Case:
    """A problem with what the tables say about it, its points ordered as the kernels want them."""

    def __init__(self, name, problem):
        self.name, self.points = name, problem.contacts
        if isinstance(problem, problems.BodyProblem):
            self.arrays = problem.arrays()
            self.problem = problems.BodyProblem(**self.arrays)
            self.bodies = int((problem.inverse_mass > 0).all(1).sum())
            self.shape = "discs" if measure.lever(problem) < 1e-6 else "long"
            self.delassus = self.problem.delassus()
        else:
            self.arrays, self.problem, self.delassus, self.bodies, self.shape = None, problem, problem, None, "unknown"
        self.matrix = measure.matrix(self.delassus)
        self.about = dict(problem=name, shape=self.shape, bodies=self.bodies, points=self.points)

    def solve(self, warm=False, **settings):
        """What the kernels return."""
        start = self.delassus.impulse if warm else np.zeros((self.points, 2))
        if self.arrays is not None:
            return kernel.solve(**{**self.arrays, "impulse": start}, violation=np.inf, **settings)
        d = self.delassus
        return kernel.solve_delassus(d.row_start, d.column, d.block.reshape(-1, 4), d.q, d.friction, start, **settings)

    def residual(self, p):
        return measure.residual(self.matrix, self.delassus.q, self.delassus.friction, p)


# ---------------------------------------------------------------------------------------------- measurements


def sweep_rows(case, repeats, threads):
    """Time of a sweep for every solver, number of lanes and number of threads."""
    if case.arrays is None:
        settings = [dict(solver=solver) for solver in SWEEPERS]
    else:
        settings = [dict(solver=s, lanes=n, threads=t, workspace=kernel.Workspace()) for s in SWEEPERS for n in LANES for t in threads]
    rows, of_one = [], {}
    runs = [(case.points, partial(case.solve, **setting)) for setting in settings]
    for setting, (clock, processor) in zip(settings, measure.sweep_times(runs, repeats)):
        row = dict(case.about, ns_by_clock=clock, **{key: setting.get(key) for key in ("solver", "lanes", "threads")})
        row["ns"] = processor if setting.get("threads", 1) == 1 else clock
        if "threads" in setting:
            row["ratio_to_one_thread"] = of_one.setdefault((row["solver"], row["lanes"]), clock) / clock
        rows.append(row)
    return rows


def tolerance_rows(case, solver, warm, options):
    """Time and iterations to each tolerance, from large to small, up to the first that is not reached."""
    for tolerance in sorted(options.tolerances, reverse=True):

        def run():
            found = case.solve(warm, solver=solver, tolerance=tolerance, max_iterations=options.max_iterations)
            return dict(found, seconds=found["processor_seconds"])

        (found,) = measure.best(options.repeats, options.budget, run)
        reached = bool(found["residual"] <= tolerance)
        yield dict(
            case.about, solver=solver, start="warm" if warm else "cold", tolerance=tolerance, iterations=found["iterations"],
            seconds=found["seconds"], residual=found["residual"], residual_numpy=case.residual(found["impulse"]), reached=reached,
        )  # fmt: skip
        if not reached:
            return


def siconos_rows(case, warm, options):
    """The same of Siconos, solved by its own Python."""
    rows, columns, values = case.delassus.entries()
    d = case.delassus
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "problem.npz")
        start = d.impulse if warm else np.zeros((case.points, 2))
        np.savez(path, rows=rows, columns=columns, values=values, q=d.q, friction=d.friction, start=start)
        for method in options.siconos_methods:
            answer = outside.run(
                [options.siconos, os.path.join(environment.BENCHMARKS, "peers", "siconos_solve.py"), path, "--method", method, "--limit", str(options.limit)]
                + ["--tolerances", *map(str, options.tolerances)]
            )
            found = json.loads(answer.splitlines()[-1])  # Siconos may print lines of its own
            for row in found["rows"]:
                reached = row["residual"] <= row["tolerance"]
                yield dict(
                    case.about, peer=f"Siconos {method.upper()}", figure="measured", start="warm" if warm else "cold", **row,
                    reached=reached, ns=found["ns"],
                )  # fmt: skip


def stated_rows(case):
    """Figures measured before, on another machine of this kind, for problems of the same name."""
    with open(os.path.join(environment.BENCHMARKS, "reference.csv"), newline="") as file:
        for row in csv.DictReader(file):
            if row["problem"] == case.name:
                numbers = {key: float(row[key]) for key in ("tolerance", "seconds", "ns")}
                yield dict(case.about, peer=row["peer"], figure="stated", start="cold", reached=True, **numbers)


def compare(rows, peers):
    """Adds the best figure of Siconos for the same start and tolerance."""
    for row in rows:
        same = [p for p in peers if p["reached"] and all(p[key] == row[key] for key in ("problem", "start", "tolerance"))]
        if same:
            best = min(same, key=lambda peer: peer["seconds"])
            row.update(siconos_seconds=best["seconds"], siconos_figure=best["figure"])
            if row["reached"]:
                row["siconos_ratio"] = best["seconds"] / row["seconds"]


def growth_rows(rows):
    """Exponents of sweeps and seconds to the largest tolerance over the number of contact points, discs and long grains apart."""
    largest = max((row["tolerance"] for row in rows), default=None)
    groups = {}
    for row in rows:
        if row["tolerance"] == largest and row["reached"] and row["iterations"]:
            groups.setdefault((row["shape"], row["solver"], row["start"]), []).append(row)
    for (shape, solver, start), group in groups.items():
        points = [row["points"] for row in group]
        if max(points) >= 2 * min(points):  # sizes that differ little tell nothing of growth
            yield dict(
                shape=shape, solver=solver, start=start, problems=len(group), points_from=min(points), points_to=max(points),
                sweeps_exponent=measure.exponent(points, [row["iterations"] for row in group]),
                seconds_exponent=measure.exponent(points, [row["seconds"] for row in group]),
            )  # fmt: skip


def roofline_rows(case, repeats):
    """What bytes and arithmetic alone would take at one thread and 8 lanes, beside what was measured.

    What a pair costs, whatever its points, and what a point costs, follow from the same pairs with two points each.
    """
    if case.arrays is None:
        return
    doubled = Case(case.name, measure.with_two_points(case.problem))
    runs = [
        (each.points, partial(each.solve, solver=solver, lanes=LANES[-1], workspace=kernel.Workspace()))
        for solver in SWEEPERS
        for each in (case, doubled)
    ]
    times = measure.sweep_times(runs, repeats)[:, 1]
    pairs = len(np.unique(case.problem.bodies, axis=0)) / case.points
    bodies = len(case.problem.inverse_mass) / case.points
    for solver, ns, ns_doubled in zip(SWEEPERS, times[::2], times[1::2]):
        size = 4 if solver == "nesterov" and pairs * case.points > FLOAT_PAIRS else 8
        megabytes = 1e-6 * case.points * (size * (POINT_FIELDS + BODY_FIELDS * bodies) + 2 * ID_BYTES * pairs)
        bandwidth = measure.triad_bandwidth(1e6 * megabytes)
        of_point = (ns_doubled * doubled.points - ns * case.points) / (doubled.points - case.points)
        volume = size * (FIELDS_READ[solver] + FIELDS_WRITTEN[solver]) + (4 * BODY_FIELDS * size + 2 * ID_BYTES) * pairs
        volume += 4 * BODY_FIELDS * size * bodies if solver == "nesterov" else 0
        yield dict(
            case.about, solver=solver, megabytes=megabytes, bytes_per_point=volume, operations_per_point=OPERATIONS[solver],
            triad_gb_per_s=1e-9 * bandwidth, ns_of_bytes=1e9 * volume / bandwidth,
            ns_of_operations=OPERATIONS[solver] * size / REGISTER_BYTES / clock_ghz(), ns=ns,
            ns_a_point=of_point, ns_a_pair=(ns - of_point) / pairs,
        )  # fmt: skip


def clock_ghz():
    """Clock of the processor as the system states it; NaN where it does not."""
    try:
        with open("/proc/cpuinfo") as file:
            found = re.search(r"cpu MHz\s*: ([\d.]+)", file.read())
    except OSError:
        found = None
    return float(found[1]) / 1000 if found else float("nan")


# ---------------------------------------------------------------------------------------------- the script


def arguments():
    parser = script.Parser(prog="bench_solver.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("problems", nargs="*", metavar="PROBLEM", help="file .npz, .h5, .hdf5 or .dat (default: lattices, good for sweeps alone)")
    add("--mirror", type=script.at_least(0, 20), default=0, metavar="K", help="also each problem with bodies doubled 1 … K times at its walls")
    add("--only", nargs="+", choices=("sweeps", "tolerances"), default=["sweeps", "tolerances"], help="what to measure")
    add("--solvers", nargs="+", default=list(SOLVERS), metavar="S", help="for the tolerances (default: nesterov exact auto)")
    add("--tolerances", type=script.number("numbers between 0 and 1", lambda v: 0 < v < 1), nargs="+", default=list(TOLERANCES), metavar="T", help="(default: 1e-4 1e-6 1e-8 1e-10)")
    add("--warm", action="store_true", help="start from the impulses in the files too")
    add("--threads", type=script.THREADS, nargs="+", default=[1, 2], metavar="N", help="(default: 1 2)")
    add("--repeats", type=script.at_least(1), default=20, metavar="N", help="runs of which the least counts (default %(default)s)")
    add("--budget", type=script.number("seconds ≥ 0", lambda v: v >= 0), default=5, metavar="S", help="s after which a time is not repeated (default %(default)s)")
    add("--max-iterations", type=script.at_least(1), default=100000, metavar="N", help="sweeps or steps at most (default %(default)s)")
    add("--siconos", metavar="PYTHON", help="a Python with siconos.numerics and scipy, also one outside of the environment")
    add("--siconos-methods", nargs="+", choices=("nsgs", "admm"), default=["nsgs"], help="(default: nsgs)")
    add("--limit", type=script.number("seconds > 0", lambda v: v > 0), default=20, metavar="S", help="seconds after which Siconos is given up (default %(default)s)")
    script.add_results(parser, "tables")
    return parser.parse_args()


def check(options):
    wrong = [name for name in options.solvers if name not in kernel.solver_names()]
    if wrong:
        raise ValueError(f"--solvers {wrong[0]}: wanted some of {', '.join(kernel.solver_names())}")


def given(options):
    """(name, problem) of every problem, each followed by its doubled ones."""
    for name, problem in measure.given(options.problems):
        if not problem.contacts:
            raise ValueError(f"{name}: has no contacts, nothing to time")
        yield name, problem
        for k in range(1, options.mirror + 1 if isinstance(problem, problems.BodyProblem) else 1):
            problem = measure.mirrored(problem, seed=k)
            yield f"{name} x{2**k}", problem


def main():
    options = arguments()
    check(options)
    with results.owned(options.out, "bench_solver.py", measure.told(options), [f"{name}.csv" for name in COLUMNS], overwrite=options.overwrite) as begin:
        tables = measured(options)
        begin()
        for name, rows in tables.items():
            measure.show(name, rows, COLUMNS[name])
            measure.write(os.path.join(options.out, f"{name}.csv"), rows, COLUMNS[name])


def measured(options):
    """Rows of every table."""
    tables = {name: [] for name in COLUMNS}
    for name, problem in given(options):
        case = Case(name, problem)
        print(f"{name}: {case.points} contact points", file=sys.stderr)
        if "sweeps" in options.only:
            tables["sweeps"] += sweep_rows(case, options.repeats, options.threads)
            tables["roofline"] += roofline_rows(case, options.repeats)
        if "tolerances" in options.only:
            for warm in (False, True) if options.warm else (False,):
                rows = [row for solver in options.solvers for row in tolerance_rows(case, solver, warm, options)]
                peers = list(siconos_rows(case, warm, options)) if options.siconos else [] if warm else list(stated_rows(case))
                compare(rows, peers)
                tables["tolerances"] += rows
                tables["peers"] += peers
    tables["growth"] = list(growth_rows(tables["tolerances"]))
    return tables


script.run(main)
