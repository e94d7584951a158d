#!/usr/bin/env python3
"""Solve a one-step contact problem from a file: FCLIB HDF5 (fclib_local), Siconos .dat, .npz.

Problems are in 2D. The results are one line of JSON and a file.
The line has solver, contacts, iterations, residual, converged and seconds of the solver.
The file has `reaction` and `velocity`, (contacts, 2) each, local (n, t).
"""

import json
import os

from lib import environment

try:
    import rcr._kernel
    from rcr import problems, script
except ImportError as error:
    environment.reenter(error)


def arguments():
    parser = script.Parser(prog="solve.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("problem", metavar="PROBLEM", help="file .npz, .h5, .hdf5 or .dat")
    add("--solver", default="auto", metavar="S", help="nlgs, sor, nesterov, exact or auto")
    add("--tolerance", type=script.number(), default=1e-4, metavar="T",
        help="residual to reach; 0 runs all iterations")
    add("--max-iterations", type=script.integer(), default=10000, metavar="N",
        help="largest number of iterations")
    add("--warm", action="store_true", help="start from the impulses in the file, not from zeros")
    add("--out", type=script.new_file, required=True, metavar="FILE",
        help="results, as .npz or .h5")
    options = parser.parse_args()
    both_exist = os.path.exists(options.out) and os.path.exists(options.problem)
    if both_exist and os.path.samefile(options.out, options.problem):
        parser.error(f"--out {options.out}: this is the problem itself; give another file")
    return options


def main():
    options = arguments()
    problems.result_suffix(options.out)
    solution = script.interruptible(problems.solve, options.problem, options.solver,
                                    options.tolerance, options.max_iterations, options.warm)
    solution.save(options.out)
    print(json.dumps(solution.scalars(), allow_nan=False))


script.run(main)
