"""Write contact problems of dense sheared packings, each with its warm start.

A biaxial test saves one problem a state: DIR/nPARTICLES_eETA_STRAIN.npz, which scripts/solve.py,
scripts/bench_solver.py and rcr.problems.load read. Run it with YADE:

    scripts/yade-rcr -n -x scripts/bench_problems.py --particles 2000 --eta 0.7 --out problems
"""

import math
import os

from rcr import script
from rcr._data import run_folder
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import ONE_RATE, PROTOCOL, check_parameters

RECORD = PROTOCOL.record_strain  # strain of a record


def arguments():
    parser = script.Parser(prog="bench_problems.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--particles", type=script.integer(), default=2000, help="number of grains")
    add("--eta", type=script.number(), default=0.7, help="elongation, 0 = disc")
    add("--seed", type=script.integer(), default=1, help="seed of the packing")
    add("--time-step", type=script.number(), default=PROTOCOL.quick_time_step,
        help="time step of the shear over √(m/σ0)")
    add("--states", type=script.at_least(1), default=5, help="number of problems, at equal strains")
    add("--strain", type=script.number(), default=0.05, help="strain of the last problem")
    script.add_results(parser, "problems")
    options = parser.parse_args()
    if not options.states * RECORD <= options.strain < 1:
        parser.error(f"--strain {options.strain}: expected at least {RECORD:g} a state, below 1")
    return options


def main():
    options = arguments()
    parameters = check_parameters(options.eta, options.particles, options.seed, **ONE_RATE,
                                  inertial_number=PROTOCOL.quick_inertial_number,
                                  time_step=options.time_step)
    given = dict(parameters, states=options.states, strain=options.strain)
    with run_folder.claim_folder(options.out, "bench_problems.py", given, ["n*_e*.npz"],
                              overwrite=options.overwrite) as begin:
        test = Biaxial.prepare(**parameters)
        test.compact()
        begin()
        for state in range(1, options.states + 1):
            strain = state * options.strain / options.states
            if not test.has_reached(strain):
                test.shear(math.inf, strain)
            name = f"n{options.particles}_e{options.eta:g}_{test.strain:.4f}.npz"
            path = os.path.join(options.out, name)
            test.solver.save(path)
            print(f"{path}: {test.solver.contactPoints} contact points", flush=True)
