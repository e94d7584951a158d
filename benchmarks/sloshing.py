"""Measure how far the stress on the bottom wall of a biaxial test changes from step to step.

    scripts/yade-rcr -n -x benchmarks/sloshing.py FOLDER --out sloshing.csv

FOLDER is a test of scripts/biaxial.py at its final strain. Each setting starts from its checkpoint,
with grains at rest and walls under the confining stress, and shears for `DURATION`. The second half
counts. A sample without inertia has a constant stress. It oscillates between the side walls, whose
own stress is constant; σ_y follows the lateral stress in the sample. Prints a table and writes it
as CSV.
"""

import time

import numpy as np
from yade.minieigenHP import Vector3
from yade.wrapper import Omega

from rcr import script
from rcr._data import files
from rcr.study import shear
from rcr.study.biaxial import Biaxial
from rcr.study.compaction import rest
from rcr.study.protocol import PROTOCOL

O = Omega()
DURATION = 360  # of a setting [t₀]; the period of the oscillation is about 20
CALM = dict(steps=80, iterations=3000)  # before each setting
SETTINGS = [  # ρ (ε̇ W/2)²/σ₀, dt/t₀, iterations
    (2e-4, 0.4, 300), (2e-4, 0.1, 300), (2e-4, 0.4, 3000), (2e-5, 0.4, 300), (2e-5, 1.2, 300),
]  # fmt: skip
COLUMNS = "eta grains strain sample_inertia time_step iterations scatter missed seconds".split()


def arguments():
    parser = script.Parser(prog="sloshing.py", description=__doc__.splitlines()[0])
    parser.add_argument("folder", metavar="FOLDER", help="test of scripts/biaxial.py")
    parser.add_argument("--out", type=script.new_file, default="sloshing.csv", metavar="FILE",
                        help="CSV")
    return parser.parse_args()


def measure(folder, inertia, time_step, iterations):
    test = Biaxial.load(folder)
    solver, top = test.solver, O.bodies[test.top].state
    top.vel = Vector3.Zero
    solver.maxIterations = CALM["iterations"]
    for _ in range(2):
        rest()
        O.run(CALM["steps"] // 2, True)
    test.parameters.update(sample_inertia=inertia)
    top.vel = Vector3(0, -shear.wall_speed(test, shear.largest_rate(test)), 0)
    O.dt = time_step * test.time_unit
    solver.maxIterations = iterations
    solver.observe, solver.observeEvery = [test.bottom], 1
    solver.observations()
    start = time.process_time()
    O.run(round(DURATION / time_step), True)
    seconds = time.process_time() - start
    seen = solver.observations()[round(0.5 * DURATION / time_step) :]
    stress = np.array([step["forces"][test.bottom][1] for step in seen]) / test.width
    return dict(eta=test.parameters["eta"], grains=len(test.grains), strain=round(test.strain, 3),
                sample_inertia=inertia, time_step=time_step, iterations=iterations,
                scatter=stress.std() / PROTOCOL.confining_stress,
                missed=np.mean([step["missed"] for step in seen]), seconds=seconds)


def main():
    options = arguments()
    rows = []
    for setting in SETTINGS:
        rows.append(measure(options.folder, *setting))
        print(" ".join(f"{name} {value:.3g}" for name, value in rows[-1].items()), flush=True)
    files.write(options.out, files.table(COLUMNS, rows))


script.run(main)
