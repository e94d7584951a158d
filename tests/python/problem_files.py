"""Contact problems and their files in the formats that rcr reads."""

from pathlib import Path

import h5py
import numpy as np


def heap(seed, count=30):
    """Arrays of an `.npz` step: `count` discs fall onto each other and a floor between two walls.

    The right wall is free along x; some pairs touch at two points, some contacts are open.
    """
    rng = np.random.default_rng(seed)
    nb = count + 4
    left, floor, right, top = range(count, nb)
    columns = 6
    rows = []

    def touch(a, b, angle, points=1):
        n = np.array([np.cos(angle), np.sin(angle)])
        t = np.array([-n[1], n[0]])
        for k in range(points):
            along = 0.0 if points == 1 else (0.3, -0.3)[k]
            open_ = rng.random() < 0.2
            wall = a >= count
            rows.append((a, b, *n, *(0 * n if wall else 0.5 * n + along * t),
                         *(along * t - 0.5 * n), 0.05 * open_, 0.0 if wall else 0.5))

    for k in range(count):
        i, j = divmod(k, columns)
        if i == 0:
            touch(floor, k, np.pi / 2)
        else:
            touch(k - columns, k, np.pi / 2 + rng.normal(0, 0.2), rng.integers(1, 3))
        if j == 0:
            touch(left, k, 0)
        else:
            touch(k - 1, k, rng.normal(0, 0.1))
        if j == columns - 1:
            touch(right, k, np.pi)
    touch(floor, top, np.pi / 2)  # both bodies prescribed: no impulse matters
    t = np.array(rows)[rng.permutation(len(rows))]
    im, iI, v = np.zeros(nb), np.zeros(nb), np.zeros((nb, 3))
    im[:count], im[right] = 1 / rng.uniform(0.5, 2, count), 0.05
    iI[:count] = 8 * im[:count]
    v[:count] = rng.normal(0, 0.02, (count, 3)) + [0, -0.1, 0]
    v[right] = -0.2, 0, 0
    return dict(a=t[:, 0].astype(int), b=t[:, 1].astype(int), n=t[:, 2:4], ra=t[:, 4:6],
                rb=t[:, 6:8], bn=t[:, 8], mu=t[:, 9], gap=0.01 * t[:, 8],
                p0=abs(rng.normal(0, 0.01, (len(t), 2))) * [1, 0], im=im, iI=iI, vfree=v, vprev=v,
                meta=np.array([0.01, 1.0, count]))


def dense(arrays):
    """W (2 nc, 2 nc) and q (nc, 2) with b_n of an `.npz` step, from a dense Jacobian."""
    nc, nb = len(arrays["a"]), len(arrays["im"])
    m = np.column_stack([arrays["im"], arrays["im"], arrays["iI"]])
    m[int(arrays["meta"][2]) :, 1] = 0
    jacobian = np.zeros((nc, 2, nb, 3))
    for k in range(nc):
        n = arrays["n"][k]
        for row, (x, y) in enumerate((n, (-n[1], n[0]))):
            for body, arm, sign in (("a", "ra", -1), ("b", "rb", 1)):
                r = arrays[arm][k]
                jacobian[k, row, arrays[body][k]] += sign * np.array([x, y, r[0] * y - r[1] * x])
    jacobian = jacobian.reshape(2 * nc, 3 * nb)
    q = (jacobian @ arrays["vfree"].ravel()).reshape(nc, 2)
    q[:, 0] += arrays["bn"]
    return jacobian * m.ravel() @ jacobian.T, q


def write_fclib(path, w, q, mu, kind=-1, change=None):
    """The local problem in FCLIB's format; nz = −1 columns, −2 rows, or "triplets".

    `change(group)` damages it.
    """
    outer, inner = np.nonzero(w.T if kind == -1 else w)
    row, column = (inner, outer) if kind == -1 else (outer, inner)
    triplets = kind == "triplets"
    values = dict(nzmax=[len(row)], m=[len(w)], n=[len(w)], nz=[len(row) if triplets else kind],
                  p=row if triplets else np.searchsorted(outer, np.arange(len(w) + 1)), i=inner)
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
