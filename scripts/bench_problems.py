"""Contact problems of dense sheared packings, for benchmarks: a biaxial test, one file a state, with its warm start.

Run it with YADE:  scripts/yade-rcr -n -x scripts/bench_problems.py --particles 2000 --eta 0.7 --states 5 --out problems
Writes DIR/nPARTICLES_eETA_STRAIN.npz, to be read by scripts/solve.py, scripts/bench_solver.py and rcr.problems.load.
"""

import os

from rcr import results, script
from rcr.study.biaxial import RECORD, TIME_STEP, Biaxial, checked


def arguments():
    parser = script.Parser(prog="bench_problems.py", description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=script.whole(), default=2000, help="number of grains (default %(default)s)")
    parser.add_argument("--eta", type=script.number(), default=0.7, help="elongation, 0 = disc (default %(default)s)")
    parser.add_argument("--seed", type=script.whole(), default=1, help="of sizes, places and orientations (default %(default)s)")
    parser.add_argument("--time-step", type=script.number(), default=TIME_STEP, help="of the shear, over √(m/σ0) (default %(default)s)")
    parser.add_argument("--states", type=script.at_least(1), default=5, help="number of problems, at equal strains (default %(default)s)")
    parser.add_argument("--strain", type=script.number(), default=0.05, help="strain of the last one (default %(default)s)")
    script.add_results(parser, "problems")
    options = parser.parse_args()
    if not options.states * RECORD <= options.strain < 1:
        parser.error(f"--strain {options.strain}: wanted at least {RECORD:g} a state, below 1")
    return options


def main():
    options = arguments()
    parameters = checked(options.eta, options.particles, options.seed, time_step=options.time_step)
    told = dict(parameters, states=options.states, strain=options.strain)
    with results.owned(options.out, "bench_problems.py", told, ["n*_e*.npz"], overwrite=options.overwrite) as begin:
        test = Biaxial.prepare(**parameters)
        test.compact()
        begin()
        for state in range(1, options.states + 1):
            while test.strain < state * options.strain / options.states - 0.5 * RECORD:
                test.shear_record()
            path = os.path.join(options.out, f"n{options.particles}_e{options.eta:g}_{test.strain:.4f}.npz")
            test.solver.save(path)
            print(f"{path}: {test.solver.contactPoints} contact points", flush=True)


script.run(main)
