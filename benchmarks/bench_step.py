"""Time the steps of a packing in other libraries and our solver, or of a biaxial test in YADE.

    python3 scripts/bench_step.py PACKING… --out DIR                        network .h5
    scripts/yade-rcr -n -x scripts/bench_step.py FOLDER… --out DIR

The first compares Chipmunk, Box2D 2 and 3, and our solver: cost of an iteration and of a step, and
errors of the contact laws (of Box2D 3 with one substep only). The second continues checkpoints of
scripts/biaxial.py and gives the share of each engine, in steps by YADE's engines and in steps on
arrays. Times are the minimum of several runs: processor time of the libraries and our solver,
wall-clock time in YADE. Tables are printed and written as CSV.
"""

import json
import os
import sys
import tempfile
import time
from functools import partial

import numpy as np

import rcr._kernel as kernel
import oracle
from benchmarks import measure, outside, tables, true_error
from benchmarks import packing as packings
from rcr import script
from rcr.problems import BodyProblem

FEW, MANY = 10, 210  # iterations; their difference gives the cost of one
SKIN = 1e-3  # growth of the grains in other libraries, which need an overlap [mean diameters]
WAYS = dict(engines=False, arrays=True)  # ContactDynamics.arrays
BLOCK = 50  # steps in YADE between two readings of the clock
SETTLE = 10  # steps in YADE before the timing
PEERS = "chipmunk", "box2d", "box2d_v3"

COLUMNS = dict(
    yade_engines="folder grains points threads way engine ms share".split(),
    yade_step=("folder eta grains points threads way steps in_arrays ms ms_least iterations "
               "tolerance").split(),
    step=("packing shape grains points library start iterations ns covers ms "
          "ms_without_iterations residual velocities forces mean_overlap velocity_error").split(),
)


# ---- other libraries

def run_program(program, packing, options, iterations, steps):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "packing.txt")
        np.savetxt(path, packing.table(SKIN))
        numbers = packing.dt, options.friction, 2 * SKIN, iterations, steps
        output = outside.run([os.path.abspath(program), path, *map(str, numbers)], try_here=True)
        return json.loads(output[output.index("{") :])  # Chipmunk may print a line before


def accuracy(packing, outcome):
    """Errors of the contact laws after the last step of a library, over its own contacts and
    impulses: residual, and true error of velocities and forces (`benchmarks.true_error`).
    `velocity_error` compares the velocities that follow with its own; overlaps are before the step.
    """
    table = np.array(outcome["contacts"]).reshape(-1, 12)
    bodies, normal = table[:, :2].astype(int), table[:, 2:4]
    arm1, arm2, friction, impulse = table[:, 4:6], table[:, 6:8], table[:, 8], table[:, 9:11]
    normal = normal / np.hypot(*normal.T)[:, None]
    free = packing.free_velocity(np.array(outcome["before"]))
    problem = BodyProblem(packing.inverse_mass, free, bodies, normal, arm1, arm2, 0 * friction,
                          friction, impulse)
    impulses = oracle.generalised(bodies, normal, arm1, arm2, impulse, len(free))
    after, stated = free + packing.inverse_mass * impulses, np.array(outcome["after"])
    overlap = -table[:, 11] - SKIN * (bodies < packing.grains).sum(1)
    residual = oracle.residual_of(problem.delassus(), impulse)
    arrays = problem.arrays()
    error = np.linalg.norm(stated - after) / max(np.linalg.norm(stated), 1e-300)
    return dict(points=len(table), residual=residual, velocity_error=float(error),
                mean_overlap=float(np.maximum(0, overlap).mean()),
                **true_error.true_error(arrays, arrays["impulse"]))


def peer_rows(name, program, packing, options):
    """Rows of the first step, cold, and of the last of several steps, warm."""

    def least(iterations, steps):
        def run():
            outcome = run_program(program, packing, options, iterations, steps)
            return dict(outcome, seconds=min(outcome["seconds"][steps // 2 :]))

        return run

    count = options.iterations
    runs = least(FEW, 1), least(MANY, 1), least(count, 1), least(count, options.steps)
    few, many, cold, warm = measure.best(options.repeats, options.budget, *runs, by="seconds")
    points = len(cold["contacts"])
    if not points:
        raise ValueError(f"{name} finds no contact in {options.present}; give a dense packing")
    an_iteration = (many["seconds"] - few["seconds"]) / (MANY - FEW)
    for start, outcome in ("cold", cold), ("warm", warm):
        yield dict(library=outcome["library"], start=start,
                   ns=1e9 * an_iteration / points if start == "cold" else None, covers="step",
                   **step_times(outcome["seconds"], an_iteration, options),
                   **(accuracy(packing, outcome) if outcome.get("complete", True)
                      else dict(points=len(outcome["contacts"]))))


def step_times(seconds, an_iteration, options):
    """Columns of the time of a step, with and without its iterations."""
    rest = seconds - options.iterations * an_iteration
    return dict(iterations=options.iterations, ms=1e3 * seconds, ms_without_iterations=1e3 * rest)


def our_rows(packing, options):
    """Rows of our solver on the contacts of our detector, cold."""
    problem = packing.problem(options.friction, 2 * SKIN)
    arrays = problem.arrays()
    delassus = BodyProblem(**arrays).delassus()  # the points have the order of the arrays
    for solver in "nlgs", "nesterov":
        solve = partial(kernel.solve, **arrays, solver=solver, accuracy=np.inf,
                        workspace=kernel.Workspace())
        limits = 5 * options.repeats, options.budget
        ((_, ns),) = measure.sweep_times([(problem.contacts, solve)], *limits)
        (found,) = measure.best(*limits, partial(solve, tolerance=0, check_interval=10**9,
                                                 max_iterations=options.iterations))
        residual = oracle.residual_of(delassus, found["impulse"])
        yield dict(points=problem.contacts, library=f"rcr {solver}", start="cold", covers="solver",
                   ns=ns, residual=residual, **true_error.true_error(arrays, found["impulse"]),
                   **step_times(
                       found["processor_seconds"], 1e-9 * ns * problem.contacts, options))


def compare_libraries(options):
    rows = []
    for path in options.inputs:
        packing, options.present = packings.load(path), path
        name = os.path.splitext(os.path.basename(path))[0]
        about = dict(packing=name, shape=packing.shape, grains=packing.grains)
        found = [*our_rows(packing, options)]
        for library in PEERS:
            program = os.path.join(options.peers, f"{library}_step")
            if os.path.exists(program):
                found += peer_rows(library, program, packing, options)
            else:
                print(f"bench_step.py: {library} is left out: {program} is missing",
                      file=sys.stderr)
        rows += [dict(about, **row) for row in found]
    return dict(step=rows)


# ---- inside YADE

def time_checkpoint(folder, way, options):
    """Continue a checkpoint by some steps; rows of the engines, and a row of the whole step."""
    from rcr.study.biaxial import Biaxial
    from yade import timing
    from yade.wrapper import Omega

    scene = Omega()
    test = Biaxial.load(folder)
    solver = test.solver
    if test.parameters["law"] != "cd":
        raise ValueError(f"{folder} holds a test with springs; give one with rigid contacts")
    solver.threads, solver.arrays = options.threads, WAYS[way]
    if options.iterations:
        solver.solver, solver.tolerance, solver.maxIterations = "nesterov", 0, options.iterations
    scene.run(SETTLE, True)
    solver.observed()
    scene.timingEnabled = True
    timing.reset()
    before, in_arrays = dict(solver.seconds), solver.model["array_steps"]
    times = []
    for done in range(0, options.steps, BLOCK):
        count = min(BLOCK, options.steps - done)
        start = time.perf_counter()
        scene.run(count, True)
        times.append((time.perf_counter() - start) / count)
    scene.timingEnabled = False
    seen = solver.observed()
    name = os.path.basename(os.path.normpath(folder))
    about = dict(folder=name, grains=len(test.grains), points=solver.contactPoints,
                 threads=options.threads, way=way)
    engines = [(engine.label or type(engine).__name__, 1e-6 * engine.execTime / options.steps)
               for engine in scene.engines if not engine.dead]
    parts = [(f"ContactDynamics: {part}", 1e3 * (seconds - before.get(part, 0)) / options.steps)
             for part, seconds in solver.seconds.items()]
    total = sum(ms for _, ms in engines)
    rows = [dict(about, engine=engine, ms=ms, share=ms / total) for engine, ms in engines + parts]
    whole = dict(about, eta=test.parameters["eta"], steps=options.steps,
                 in_arrays=solver.model["array_steps"] - in_arrays, ms=1e3 * float(np.mean(times)),
                 ms_least=1e3 * min(times), iterations=seen["iterations"] / options.steps,
                 tolerance=solver.tolerance)
    return rows, whole


def time_yade(options):
    engines, whole = zip(*(time_checkpoint(folder, way, options)
                           for folder in options.inputs for way in WAYS))
    return dict(yade_engines=sum(engines, []), yade_step=whole)


# ---- the script

def arguments(in_yade):
    parser = script.Parser(prog="bench_step.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("inputs", nargs="+", metavar="PACKING|FOLDER",
        help="network .h5; with YADE, a folder of scripts/biaxial.py")
    add("--iterations", type=script.at_least(1), default=None if in_yade else 40, metavar="N",
        help="iterations of a step; without a default, to the tolerance of the scene")
    add("--steps", type=script.at_least(1), default=200 if in_yade else 20, metavar="N",
        help="steps in YADE, or warm steps in the libraries")
    add("--friction", type=script.number("a coefficient ≥ 0", lambda v: v >= 0), default=0.5,
        help="friction between grains; in YADE it is that of the checkpoint")
    add("--threads", type=script.THREADS, default=1, metavar="N",
        help="threads of our solver in YADE")
    tables.add_repeats(parser, 5, budget=20, runs="runs without YADE", run="a run without YADE")
    tables.add_peers(parser, "; not used in YADE")
    script.add_results(parser, "tables")
    options = parser.parse_args()
    for path in options.inputs:
        if os.path.isdir(path) and not in_yade:
            raise ValueError(f"{path} is a folder: a checkpoint needs YADE, "
                             f"scripts/yade-rcr -n -x scripts/bench_step.py {path} --out DIR")
        if in_yade and not os.path.isdir(path):
            raise ValueError(
                f"{path} is no folder: give a folder of scripts/biaxial.py, or run without YADE")
    return options


def main():
    in_yade = "yade" in sys.modules
    tables.store("bench_step.py", arguments(in_yade), COLUMNS,
                 time_yade if in_yade else compare_libraries)
