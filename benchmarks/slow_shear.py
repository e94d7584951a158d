"""What rate, time step and sweeps of the slow shear cost, and what they change.

    scripts/yade-rcr -n -x benchmarks/slow_shear.py FOLDER … --out slow-shear.csv

A FOLDER is a test of scripts/biaxial.py at its final strain. Each setting continues it by `STRAIN`
from its checkpoint. Means leave out the first `SETTLING` of strain. `scatter` is the standard
deviation of sin φ over records of 0.001 of strain. Prints a table and writes it as CSV.
"""

import time

import numpy as np
from yade.wrapper import Omega

from benchmarks import tables
from benchmarks.charts.quasi_static import observed
from rcr import script
from rcr._data import files
from rcr.ensemble import Ensemble
from rcr.observables.forces import mean_mobilization
from rcr.study.biaxial import Biaxial

O = Omega()
STRAIN, SETTLING, NETWORK = 0.08, 0.02, 0.005  # strains: of a setting, before means, of a network
SETTINGS = [  # ρ (ε̇ W/2)²/σ₀, dt/t₀, most sweeps
    (2e-5, 0.4, 300), (5e-5, 0.4, 300), (1e-4, 0.4, 300), (2e-4, 0.4, 300),
    (2e-5, 0.4, 1000), (2e-5, 0.8, 300),
]  # fmt: skip
NO_BOUND = 1e-3  # --inertial-number: sample_inertia alone decides
OBSERVABLES = ("friction_mobilization", "mobilized_fraction", "beta_n", "weak_fraction", "a_c",
               "a_c_weak", "c_f_lr")
COLUMNS = ("shape eta grains strain sample_inertia time_step iterations inertial_number "
           "steps seconds sin_phi scatter coordination_number").split() + [
    *OBSERVABLES, "mean_overlap", "max_overlap", "missed", "failed"]


def measure(folder, inertia, time_step, iterations):
    """Row of a setting."""
    test = Biaxial.load(folder)
    test.parameters.update(sample_inertia=inertia, time_step=time_step, inertial_number=NO_BOUND)
    test.solver.maxIterations = iterations
    about = dict(shape=test.parameters["shape"], eta=test.parameters["eta"],
                 grains=len(test.grains), sample_inertia=inertia, time_step=time_step,
                 iterations=iterations)
    try:
        return about | _continue(test)
    except RuntimeError as error:
        return about | dict(failed=str(error).splitlines()[0])


def _continue(test):
    """Continue a test by `STRAIN`; return the results of the row."""
    start, first = test.strain, len(test.rows)
    networks, overlaps, began, steps = [], [], time.process_time(), O.iter
    while not test.has_reached(start + STRAIN):
        test.shear(5, start + STRAIN)
        if test.has_reached(start + SETTLING + NETWORK):
            networks.append(test.network())
            overlaps.append(test.overlaps())
    seconds = time.process_time() - began
    rows = [row for row in test.rows[first:] if row["strain"] > start + SETTLING]
    sin_phi = np.array([row["sin_phi"] for row in rows])
    made = rows[-1]["step"] - rows[0]["step"]
    missed = sum(row["unconverged_steps"] + row["yielded_steps"] for row in rows[1:])
    ensemble = Ensemble(networks)
    found = observed(ensemble) | mean_mobilization(ensemble, None)
    return dict(strain=round(test.strain, 3), inertial_number=test.progress["rate"],
                steps=O.iter - steps, seconds=seconds, sin_phi=sin_phi.mean(), scatter=sin_phi.std(),
                coordination_number=np.mean([n.coordination() for n in networks]),
                **{name: float(found[name]) for name in OBSERVABLES},
                mean_overlap=np.mean([values.mean() for values in overlaps]),
                max_overlap=np.max([values.max() for values in overlaps]), missed=missed / made)


def main():
    options = tables.tests_and_csv("slow_shear.py", __doc__, "slow-shear.csv")
    rows = []
    for folder in options.folders:
        for setting in SETTINGS:
            rows.append(measure(folder, *setting))
            print(" ".join(f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}"
                           for name, value in rows[-1].items()), flush=True)
            files.write(options.out, files.table(COLUMNS, rows))


script.run(main)
