"""Contact problems and their files in the formats that rcr reads."""

from pathlib import Path

import h5py
import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array


def npz(problem):
    """Arrays of an `.npz` step; the last four bodies of the problem are walls."""
    p, mass = problem, problem["inverse_mass"]
    return dict(a=p["bodies"][:, 0], b=p["bodies"][:, 1], n=p["normal"], ra=p["arm1"], rb=p["arm2"],
                bn=p["bias"], mu=p["friction"], gap=0.01 * p["bias"], p0=p["impulse"],
                im=mass[:, 0], iI=mass[:, 2], vfree=p["free_velocity"],
                vprev=p["free_velocity"], meta=np.array([0.01, 1.0, len(mass) - 4]))


def write(path, step, change=None):
    """Write a step in the format of the suffix; the stem is the storage of W. Returns the path."""
    arrays, w, q = step
    if path.suffix == ".npz":
        np.savez(path, **arrays)
    elif path.suffix == ".h5":
        write_fclib(path, w, q, arrays["mu"], path.stem, change)
    else:
        write_siconos(path, w, q, arrays["mu"], path.stem)
    return path


def write_fclib(path, w, q, mu, storage="columns", change=None):
    """Write FCLIB's local problem as columns, rows or triplets; `change(group)` damages it."""
    matrix = dict(columns=csc_array, rows=csr_array, triplets=coo_array)[storage](w)
    nz = dict(columns=-1, rows=-2, triplets=matrix.nnz)[storage]
    pointers, inner = ((matrix.row, matrix.col) if storage == "triplets"
                       else (matrix.indptr, matrix.indices))
    values = dict(nzmax=[matrix.nnz], m=[len(w)], n=[len(w)], nz=[nz], p=pointers, i=inner)
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([2], np.int32)
        for name, value in values.items():
            group[f"W/{name}"] = np.array(value, np.int32)
        group["W/x"], group["vectors/q"], group["vectors/mu"] = matrix.data, q.ravel(), mu
        if change:
            change(group)


def write_siconos(path, w, q, mu, storage="columns"):
    """Siconos' text format: a dense matrix, rows of 2×2 blocks, CSparse columns or triplets."""
    size, nc = len(w), len(w) // 2
    numbers = lambda values: [f"{x:.17e}" for x in values.ravel()]
    tabs = lambda values: "\t".join(map(str, values))
    if storage == "dense":
        text = ["0", size, size, tabs([size, size]), " ".join(numbers(w.T))]
    elif storage == "blocks":
        blocks = w.reshape(nc, 2, nc, 2).swapaxes(1, 2)
        row, column = np.nonzero(blocks.any((2, 3)) | np.eye(nc, dtype=bool))
        ends = tabs(range(2, size + 1, 2))
        text = ["1", size, size, len(row), nc, nc, ends, ends, nc + 1, len(row),
                tabs(np.searchsorted(row, range(nc + 1))), tabs(column)]
        for k, place in enumerate(zip(row, column)):
            text += [k, *numbers(blocks[place].T)]
    else:
        matrix, triplets = csc_array(w), storage == "triplets"
        text = ["2", size, size, 1 if triplets else 2, "CSparse Version 3.1.9, May 4, 2016.  "
                "Copyright (c) Timothy A. Davis, 2006-2016",
                f"{'triplet: ' * triplets}{size}-by-{size}, nzmax: {matrix.nnz} nnz: {matrix.nnz}"
                + ("" if triplets else ", 1-norm: 1")]
        for j, (begin, end) in enumerate(zip(matrix.indptr, matrix.indptr[1:])):
            if not triplets:
                text += [f"    col {j} : locations {begin} to {end - 1}"]
            text += [f"      {f'{row} {j}' if triplets else row} : {x}" for row, x in
                     zip(matrix.indices[begin:end], numbers(matrix.data[begin:end]))]
    text += [" ".join(numbers(q)), " ".join(numbers(mu))]
    Path(path).write_text("\n".join(map(str, [2, nc, *text])) + "\n")
