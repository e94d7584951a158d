#!/usr/bin/env python3
"""Observables of whole biaxial tests over the sweeps of their steps.

    scripts/campaign --particles 4000 --seeds 1,2 --etas 0,0.7 --iterations 300 --out sweeps
    scripts/lib/run python3 benchmarks/sweeps_of_tests.py sweeps/runs/* --out sweeps-of-tests.csv

Runs differ in --particles, --eta, --iterations and --seed. A row has means over the seeds of one
setting, of the second half of the strain, and their standard errors. Overlaps are those of the last
record, in mean grain diameters. Prints a table and writes it as CSV.
"""

import numpy as np
import yade  # noqa: F401: rcr loads its plugin into it

from benchmarks.charts.quasi_static import observed
from rcr import script
from rcr._data import files
from rcr.ensemble import Ensemble
from rcr.observables.forces import mean_mobilization
from rcr.statistics import standard_error
from rcr.study.runs import Run

SETTING = "particles", "eta", "iterations"
OBSERVABLES = ("sin_phi", "friction_mobilization", "mobilized_fraction", "beta_n", "weak_fraction",
               "a_c_half", "a_c_weak", "a_c", "coordination_number")
COST = "mean_overlap", "max_overlap", "missed_fraction", "wall_seconds"
COLUMNS = [*SETTING, "seeds", *OBSERVABLES, *(f"{name}_error" for name in OBSERVABLES), *COST]


def arguments():
    parser = script.Parser(prog="sweeps_of_tests.py", description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", metavar="RUNS", help="folders of scripts/biaxial.py")
    parser.add_argument("--out", type=script.new_file, default="sweeps-of-tests.csv",
                        metavar="FILE", help="CSV")
    return parser.parse_args()


def values(run):
    """Observables and cost of one test."""
    found = observed(run.networks)
    found.update(mean_mobilization(Ensemble(run.networks), None))
    return found | {name: run.summary[name] for name in ("sin_phi", "coordination_number", *COST)}


def row(setting, runs):
    tests = [values(run) for run in runs]
    of = lambda name: [test[name] for test in tests]
    return (dict(zip(SETTING, setting), seeds=len(runs))
            | {name: np.mean(of(name)) for name in (*OBSERVABLES, *COST)}
            | {f"{name}_error": standard_error(of(name)) for name in OBSERVABLES})


def main():
    options, groups = arguments(), {}
    for folder in options.folders:
        run = Run.read(folder)
        if run.summary is None:
            raise ValueError(f"{folder} has no summary.json; expected complete tests")
        setting = tuple(run.record["parameters"][name] for name in SETTING)
        groups.setdefault(setting, []).append(run)
    rows = [row(setting, groups[setting]) for setting in sorted(groups)]
    rows = [{name: f"{value:.4g}" for name, value in r.items()} for r in rows]
    files.write(options.out, files.table(COLUMNS, rows))
    for name in COLUMNS:
        print(f"{name:28}" + "".join(f"{r[name]:>10}" for r in rows))


if __name__ == "__main__":
    script.run(main)
