"""Time the contact solvers on one-step problems from files, alone and against Siconos.

Prints tables and writes them as CSV: sweeps (time per contact point and sweep), tolerances (time to
a residual, checked in NumPy), peers, and parallel (wall-clock time to a residual by number of
threads). Times are the minimum of several runs. In the other tables they are processor time, which
other programs hardly change; sweeps of more than one thread have wall-clock time.
"""

import json
import os
import sys
import tempfile
from functools import partial

import numpy as np

import rcr._kernel as kernel
import oracle
from benchmarks import ROOT, measure, outside, tables
from rcr import problems, script

TOLERANCES = 1e-4, 1e-6, 1e-8, 1e-10
SOLVERS = "nesterov", "exact", "auto"
SWEEPERS = "nlgs", "nesterov"
LANES = 1, 4, 8

ABOUT = ["problem", "bodies", "points"]
COLUMNS = dict(
    sweeps=[*ABOUT, "solver", "lanes", "threads", "ns", "ns_by_clock", "ratio_to_one_thread"],
    tolerances=[*ABOUT, "solver", "start", "tolerance", "iterations", "seconds", "residual",
                "residual_numpy", "reached"],
    peers=[*ABOUT, "peer", "start", "tolerance", "iterations", "seconds", "residual",
           "reached", "ns"],
    parallel=[*ABOUT, "program", "threads", "tolerance", "iterations", "seconds", "residual"],
)


class Case:
    """A problem in the point order of the kernels, and its columns of the tables."""

    def __init__(self, name, problem):
        self.points = problem.contacts
        if isinstance(problem, problems.BodyProblem):
            self.arrays = problem.arrays()
            bodies = int((problem.inverse_mass > 0).all(1).sum())
            self.delassus = problems.BodyProblem(**self.arrays).delassus()
        else:
            self.arrays, bodies, self.delassus = None, None, problem
        self.about = dict(problem=name, bodies=bodies, points=self.points)

    def solve(self, warm=False, **settings):
        start = self.delassus.impulse if warm else np.zeros((self.points, 2))
        if self.arrays is not None:
            return kernel.solve(**self.arrays | dict(accuracy=np.inf, impulse=start) | settings)
        d = self.delassus
        return kernel.solve_delassus(d.row_start, d.column, d.block.reshape(-1, 4), d.q, d.friction,
                                     start, **settings)


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
        row = dict(case.about, **setting, ns_by_clock=clock,
                   ns=processor if setting.get("threads", 1) == 1 else clock)
        if "threads" in setting:
            one_thread = of_one.setdefault((row["solver"], row["lanes"]), clock)
            row["ratio_to_one_thread"] = one_thread / clock
        rows.append(row)
    return rows


def tolerance_rows(case, solver, warm, options, clock="processor_seconds", **settings):
    """Time, iterations and impulses to each tolerance, from large to small, up to the first not
    reached.
    """
    for tolerance in sorted(options.tolerances, reverse=True):
        run = partial(case.solve, warm, solver=solver, tolerance=tolerance,
                      max_iterations=options.max_iterations, **settings)
        (found,) = measure.best(options.repeats, options.budget, run, by=clock)
        reached = bool(found["residual"] <= tolerance)
        yield dict(case.about, solver=solver, start="warm" if warm else "cold", tolerance=tolerance,
                   iterations=found["iterations"], seconds=found[clock],
                   residual=found["residual"], reached=reached, impulse=found["impulse"],
                   residual_numpy=oracle.residual_of(case.delassus, found["impulse"]))
        if not reached:
            return


def siconos_rows(case, warm, options):
    """Time, iterations and impulses of Siconos, which runs in its own Python."""
    d, program = case.delassus, os.path.join(ROOT, "benchmarks", "peers", "siconos_solve.py")
    rows, columns, values = d.entries()
    with tempfile.TemporaryDirectory() as folder:
        path, impulses = (os.path.join(folder, name) for name in ("problem.npz", "impulses.npy"))
        start = d.impulse if warm else np.zeros((case.points, 2))
        np.savez(path, rows=rows, columns=columns, values=values, q=d.q, friction=d.friction,
                 start=start)
        answer = outside.run([options.siconos, program, path, "--limit", str(options.limit),
                              "--impulses", impulses,
                              "--tolerances", *map(str, options.tolerances)])
        impulse = np.load(impulses)
    found = json.loads(answer.splitlines()[-1])  # Siconos may print lines before
    for row, p in zip(found["rows"], impulse):
        yield dict(case.about, peer="Siconos NSGS", start="warm" if warm else "cold", **row,
                   reached=row["residual"] <= row["tolerance"], ns=found["ns"], impulse=p)


def parallel_rows(case, options):
    """Wall-clock time to each tolerance from zero impulses, by number of threads."""
    if case.arrays is None:
        raise ValueError(f"{case.about['problem']}: problems of W and q are solved on one thread; "
                         "give one with bodies (.npz) for --only parallel")
    for threads in options.threads:
        about = dict(case.about, threads=threads)
        for solver in options.solvers:
            rows = tolerance_rows(case, solver, False, options, clock="seconds", threads=threads,
                                  workspace=kernel.Workspace())
            yield from (dict(row, threads=threads, program=f"rcr {solver}")
                        for row in rows if row["reached"])
        program = os.path.join(os.path.abspath(options.peers), "siconos_nsgs")
        if os.path.exists(program):
            for row in _siconos_runs(program, case.delassus, threads, options):
                yield dict(about, program="Siconos NSGS", **row)


def _siconos_runs(program, delassus, threads, options):
    """Rows of the fewest iterations of benchmarks/peers/siconos_nsgs to each tolerance."""
    with tempfile.TemporaryDirectory() as folder:
        problem, impulses = (os.path.join(folder, name) for name in ("problem.dat", "impulses"))
        with open(problem, "w") as file:
            file.write(siconos_text(delassus))
        answer = outside.run([program, problem, impulses, str(threads), str(options.limit)],
                             try_here=True)
        found = json.loads(answer.splitlines()[-1])  # Siconos may print lines before
        runs = np.fromfile(impulses).reshape(len(found["seconds"]), -1, 2)
    pending = sorted(options.tolerances)
    for iterations, seconds, impulse in zip(found["iterations"], found["seconds"], runs):
        residual = oracle.residual_of(delassus, impulse)
        while pending and residual <= pending[-1]:
            yield dict(tolerance=pending.pop(), iterations=iterations, seconds=seconds,
                       residual=residual)


def siconos_text(delassus):
    """A DelassusProblem as Siconos' text file, with W in blocks of 2 × 2."""
    d, nc = delassus, delassus.contacts
    ends = 2 * np.arange(1, nc + 1)
    lines = [[2], [nc], [1], [2 * nc, 2 * nc], [len(d.column)], [nc, nc], ends, ends, [nc + 1],
             [len(d.column)], d.row_start, d.column]
    for k, block in enumerate(d.block.reshape(-1, 2, 2)):
        lines += [[k], block.T.ravel()]
    lines += [d.q.ravel(), d.friction]
    return "\n".join(" ".join(map(str, np.asarray(line).tolist())) for line in lines) + "\n"


# ---- the script

def arguments():
    parser = script.Parser(prog="bench_solver.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("problems", nargs="*", metavar="PROBLEM",
        help="file .npz, .h5, .hdf5 or .dat (default: lattices, for sweeps only)")
    add("--mirror", type=script.at_least(0, 20), default=0, metavar="K",
        help="also each problem doubled 1 … K times by reflection at its walls")
    add("--only", nargs="+", choices=("sweeps", "tolerances", "parallel"),
        default=["sweeps", "tolerances"],
        help="tables to measure (default: sweeps tolerances)")
    add("--solvers", nargs="+", choices=kernel.solver_names(), default=list(SOLVERS), metavar="S",
        help="solvers of the tolerances (default: nesterov exact auto)")
    add("--tolerances", type=script.number("numbers between 0 and 1", lambda v: 0 < v < 1),
        nargs="+", default=list(TOLERANCES), metavar="T",
        help="residuals to reach (default: 1e-4 1e-6 1e-8 1e-10)")
    add("--warm", action="store_true",
        help="start the tolerances from the impulses in the files too")
    add("--threads", type=script.THREADS, nargs="+", default=[1, 2], metavar="N",
        help="numbers of threads of sweeps and parallel (default: 1 2)")
    tables.add_repeats(parser, 20, budget=5, run="a run to a tolerance")
    add("--max-iterations", type=script.at_least(1), default=100000, metavar="N",
        help="largest number of iterations to a tolerance")
    add("--siconos", metavar="PYTHON",
        help="for the tolerances: a Python with siconos.numerics and scipy, inside or outside the "
        "environment")
    tables.add_peers(parser, "; also of siconos_nsgs, for parallel")
    add("--limit", type=script.number("seconds > 0", lambda v: v > 0), default=20, metavar="S",
        help="time limit of Siconos [s]")
    script.add_results(parser, "tables")
    return parser.parse_args()


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
    made = {name: [] for name in COLUMNS}
    for name, problem in given(options):
        case = Case(name, problem)
        print(f"{name}: {case.points} contact points", file=sys.stderr)
        if "sweeps" in options.only:
            made["sweeps"] += sweep_rows(case, options.repeats, options.threads)
        if "tolerances" in options.only:
            for warm in (False, True) if options.warm else (False,):
                for solver in options.solvers:
                    made["tolerances"] += tolerance_rows(case, solver, warm, options)
                if options.siconos:
                    made["peers"] += siconos_rows(case, warm, options)
        if "parallel" in options.only:
            made["parallel"] += parallel_rows(case, options)
    return made


def main():
    tables.store("bench_solver.py", arguments(), COLUMNS, measured)
