#!/usr/bin/env python3
"""Solve W, q, µ with Siconos and print the time to each residual as JSON.

It needs a Python with Siconos. The 2D NSGS runs in pieces, each from the end of the previous one,
which equals one run of Gauss–Seidel. Our residual is computed between pieces, outside the timing;
Siconos evaluates its own error once a piece.
"""

import argparse
import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import siconos.numerics as sn
from scipy.sparse import csc_matrix

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from benchmarks.measure import rounds
from oracle import residual

FIRST, GROWTH = 20, 0.1  # iterations of the first piece; later pieces over all iterations so far
REPEATS, BUDGET = 12, 2.0  # largest number of runs; seconds after which no run begins


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("problem", help="arrays rows, columns, values, q, friction, start; .npz")
    parser.add_argument("--tolerances", type=float, nargs="+", required=True)
    parser.add_argument("--impulses", required=True, metavar="FILE",
                        help="impulses at these residuals, (tolerances, contacts, 2), .npy")
    parser.add_argument("--limit", type=float, default=10, help="limit of processor time [s]")
    return parser.parse_args()


def nsgs(data, matrix, tolerances, limit):
    """Rows of the 2D NSGS and its cost of an iteration and contact [s]."""
    friction, q, p = data["friction"], data["q"], data["start"].ravel().copy()
    blocks = sn.SBM_from_csparse(2, matrix)[1]  # it must live as long as the problem
    task = sn.FrictionContactProblem(2, len(friction), blocks, np.ascontiguousarray(q.ravel()),
                                     friction)
    velocity, seconds, iterations, rows = np.zeros(len(p)), 0.0, 0, []
    pending = sorted(tolerances, reverse=True)
    while pending and seconds < limit:
        piece = max(FIRST, int(GROWTH * iterations))
        options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = piece
        full = sn.SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_FULL
        options.iparam[sn.SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] = full
        options.iparam[sn.SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION_FREQUENCY] = piece
        options.dparam[sn.SICONOS_DPARAM_TOL] = 1e-16
        start = time.process_time()
        sn.fc2d_driver(task, p, velocity, options)
        seconds += time.process_time() - start
        iterations += piece
        reached = residual(matrix, q, friction, p.reshape(-1, 2))
        found = dict(iterations=iterations, seconds=seconds, residual=reached,
                     impulse=p.reshape(-1, 2).copy())
        while pending and reached <= pending[0]:
            rows.append(dict(tolerance=pending.pop(0), **found))
    rows += [dict(tolerance=t, **found) for t in pending]
    return rows, seconds / iterations / len(friction)


def fastest(run):
    """Rows and cost of the fastest of several runs."""
    rows, costs = zip(*(result for (result,) in rounds(REPEATS, BUDGET, [run])))
    return [min(same, key=lambda row: row["seconds"]) for same in zip(*rows)], min(costs)


def main():
    options = arguments()
    warnings.simplefilter("ignore")
    data = dict(np.load(options.problem))
    size = 2 * len(data["friction"])
    matrix = csc_matrix((data["values"], (data["rows"], data["columns"])), shape=(size, size))
    matrix.indices, matrix.indptr = matrix.indices.astype(np.int64), matrix.indptr.astype(np.int64)
    sn.numerics_set_verbose(0)
    rows, cost = fastest(lambda: nsgs(data, matrix, options.tolerances, options.limit))
    np.save(options.impulses, [row.pop("impulse") for row in rows])
    print(json.dumps(dict(rows=rows, ns=1e9 * cost)))


try:
    main()
except (OSError, ValueError, KeyError) as error:
    sys.exit(f"siconos_solve.py: {error}")
