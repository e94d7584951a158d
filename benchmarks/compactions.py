#!/usr/bin/env python3
"""Packing fraction after the compaction, with and without inertia.

    scripts/yade-rcr -n -x benchmarks/compactions.py --out compactions.csv

Frictionless grains of radii R_min to 3 R_min. *Without* inertia they are compacted as
scripts/biaxial.py does. *With* inertia, free walls under σ₀ first close in on the loose packing at
dt = `STEP` t₀, and grains collide inelastically, until the mean net force of a grain is below
`QUIET` of the mean contact force; the relaxation without inertia follows. Prints means over the
seeds and writes them as CSV; errors are standard errors.
"""

from yade.wrapper import Omega

from benchmarks import tables
from rcr import script
from rcr._data import files
from rcr.study import compaction
from rcr.study.biaxial import Biaxial

O = Omega()
GRAINS = [("rcr", 0.0), ("rcr", 0.4), ("hexagon", 0.134), ("hexagon", 0.3), ("hexagon", 0.5),
          ("truncated", 0.2), ("truncated", 0.4)]
STEP, QUIET, INTERVAL, SWEEPS = 0.2, 0.02, 50, 1000  # t₀, unbalance, steps, sweeps a step
COLUMNS = ["shape", "eta", "grains", "seeds", "without", "without_error", "with", "with_error"]


def with_inertia(test):
    """Close in on the loose packing until it is nearly at rest."""
    solver = test.solver
    solver.overdamped, most, solver.maxIterations = False, solver.maxIterations, SWEEPS
    O.dt = STEP * test.time_unit
    while O.iter < 5 * INTERVAL or solver.unbalancedForce > QUIET:
        O.run(INTERVAL, True)
    compaction.rest()
    solver.overdamped, solver.maxIterations = True, most
    test.progress.update(phase="relaxation", relaxation={})
    test.step(1)  # stresses of a step without inertia


def packing_fraction(shape, eta, particles, seed, inertia):
    test = Biaxial.prepare(eta, particles, seed, shape=shape, size_span=3, threads=1)
    if inertia:
        with_inertia(test)
    test.compact()
    return test.packing_fraction


def main():
    parser = script.Parser(prog="compactions.py", description=__doc__.splitlines()[0])
    tables.add_packings(parser, 1000, 100)
    parser.add_argument("--out", type=script.new_file, default="compactions.csv", metavar="FILE")
    options = parser.parse_args()
    rows = []
    for shape, eta in GRAINS:
        found = {name: [packing_fraction(shape, eta, options.particles, seed, name == "with")
                        for seed in options.seeds] for name in ("without", "with")}
        about = dict(shape=shape, eta=eta, grains=options.particles, seeds=len(options.seeds))
        rows.append(about | {name: f"{value:.4f}" for name, value in tables.means(found).items()})
        print("  ".join(f"{name} {value}" for name, value in rows[-1].items()), flush=True)
    files.write(options.out, files.table(COLUMNS, rows))


script.run(main)
