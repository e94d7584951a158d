#!/usr/bin/env python3
"""Observables of whole biaxial tests over the sweeps of their steps.

    scripts/campaign --particles 4000 --seeds 1,2 --etas 0,0.7 --iterations 300 --out sweeps
    scripts/lib/run python3 benchmarks/sweeps_of_tests.py sweeps/runs/* --out sweeps-of-tests.csv

Runs differ in --particles, --eta, --iterations and --seed. A row has means over the seeds of one
setting, of the second half of the strain, and their standard errors. Overlaps are those of the last
record, in mean grain diameters. Prints a table and writes it as CSV.
"""

import yade  # noqa: F401: rcr loads its plugin into it

from benchmarks import tables
from benchmarks.charts.quasi_static import observed
from rcr import script
from rcr._data import files
from rcr.ensemble import Ensemble
from rcr.observables.forces import mean_mobilization
from rcr.study.runs import Run

SETTING = "particles", "eta", "iterations"
OBSERVABLES = ("sin_phi", "friction_mobilization", "mobilized_fraction", "beta_n", "weak_fraction",
               "a_c_half", "a_c_weak", "a_c", "coordination_number")
COST = "mean_overlap", "max_overlap", "missed_fraction", "wall_seconds"
COLUMNS = [*SETTING, "seeds", *OBSERVABLES, *(f"{name}_error" for name in OBSERVABLES), *COST]


def values(run):
    """Observables and cost of one test."""
    ensemble = Ensemble(run.networks)
    found = observed(ensemble) | mean_mobilization(ensemble, None)
    return found | {name: run.summary[name] for name in ("sin_phi", "coordination_number", *COST)}


def row(setting, runs):
    tests = [values(run) for run in runs]
    of = {name: [test[name] for test in tests] for name in (*OBSERVABLES, *COST)}
    found = dict(zip(SETTING, setting), seeds=len(runs)) | tables.means(of)
    return {name: found[name] for name in COLUMNS}


def main():
    options = tables.tests_and_csv("sweeps_of_tests.py", __doc__, "sweeps-of-tests.csv")
    groups = {}
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
