"""Contact problems and their files in the formats that rcr reads."""

from pathlib import Path

import h5py
import numpy as np


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
    by_columns, triplets = storage == "columns", storage == "triplets"
    outer, inner = np.nonzero(w.T if by_columns else w)
    row, column = (inner, outer) if by_columns else (outer, inner)
    nz = len(row) if triplets else -1 if by_columns else -2
    pointers = row if triplets else np.searchsorted(outer, np.arange(len(w) + 1))
    values = dict(nzmax=[len(row)], m=[len(w)], n=[len(w)], nz=[nz], p=pointers, i=inner)
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([2], np.int32)
        for name, value in values.items():
            group[f"W/{name}"] = np.array(value, np.int32)
        group["W/x"], group["vectors/q"], group["vectors/mu"] = w[row, column], q.ravel(), mu
        if change:
            change(group)


def write_siconos(path, w, q, mu, storage="columns"):
    """Siconos' text format: a dense matrix, rows of 2×2 blocks, CSparse columns or triplets."""
    size, text = len(w), []
    number = lambda x: f"{x:.17e}"
    if storage == "dense":
        text += ["0", size, size, f"{size}\t{size}", " ".join(map(number, w.T.ravel()))]
    elif storage == "blocks":
        nc = size // 2
        blocks = [[j for j in range(nc) if w[2 * i : 2 * i + 2, 2 * j : 2 * j + 2].any() or i == j]
                  for i in range(nc)]
        ends = "\t".join(str(2 * i + 2) for i in range(nc))
        count = np.cumsum([0] + [len(row) for row in blocks])
        text += ["1", size, size, count[-1], nc, nc, ends, ends, nc + 1, count[-1],
                 "\t".join(map(str, count)), "\t".join(str(j) for row in blocks for j in row)]
        for i, row in enumerate(blocks):
            for k, j in enumerate(row, count[i]):
                text += [k, *(number(x) for x in w[2 * i : 2 * i + 2, 2 * j : 2 * j + 2].T.ravel())]
    else:
        column, row = np.nonzero(w.T)
        triplets = storage == "triplets"
        text += ["2", size, size, 1 if triplets else 2, "CSparse Version 3.1.9, May 4, 2016.  "
                 "Copyright (c) Timothy A. Davis, 2006-2016"]
        text += [f"{'triplet: ' * triplets}{size}-by-{size}, nzmax: {len(row)} nnz: {len(row)}"
                 + ("" if triplets else ", 1-norm: 1")]
        for j in range(size):
            places = np.flatnonzero(column == j)
            if not triplets:
                text += [f"    col {j} : locations {places[0] if len(places) else 0} to "
                         f"{places[-1] if len(places) else -1}"]
            text += [f"      {f'{row[k]} {j}' if triplets else row[k]} : {number(w[row[k], j])}"
                     for k in places]
    Path(path).write_text(
        "\n".join(map(str, [2, size // 2, *text, " ".join(map(number, q.ravel())),
                            " ".join(map(number, mu))])) + "\n")
