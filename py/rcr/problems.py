"""One-step contact problems from files, and their solution. Needs NumPy and the compiled kernels, h5py for ``.h5``; not YADE.

    u = J v,  v = v_free + M⁻¹ Jᵀ p        with bodies:     BodyProblem
    u = W p + q                            without them:    DelassusProblem,  W = J M⁻¹ Jᵀ,  q = J v_free + b_n n
    0 ≤ u_n + b_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where it slides

========  ==========================================================================================================
``.npz``  a step with its bodies: arrays a, b, n, ra, rb, bn, mu, p0, im, iI, vfree, meta
``.h5``   FCLIB, group ``fclib_local``: spacedim = 2, W (m, n, nz, nzmax, p, i, x), vectors/q, vectors/mu; the warm start
          is ``guesses/1/r``. Compressed columns (nz = −1), compressed rows (−2) or triplets (their number)
``.dat``  Siconos, 2D: dimension, contacts, matrix (dense, blocks or CSparse), q, µ
========  ==========================================================================================================

A file that is malformed is refused with a ValueError of one line that says what is wrong.
"""

import io
import os
import zipfile
from dataclasses import dataclass, fields

import numpy as np

from rcr import _checks as checks, _files as files

SYMMETRY = 1e-8  # largest |W − Wᵀ| over largest |W|: files of Siconos are off by 1e-10


@dataclass
class BodyProblem:
    """A step with its bodies, as contact_problem.hpp of the kernels describes it (nb bodies, nc contact points)."""

    inverse_mass: np.ndarray  # (nb, 3) along x, y [1/kg] and about z [1/(kg m²)]; 0 = prescribed
    free_velocity: np.ndarray  # (nb, 3) [m/s, m/s, 1/s]
    bodies: np.ndarray  # (nc, 2)
    normal: np.ndarray  # (nc, 2) from body 1 to body 2
    arm1: np.ndarray  # (nc, 2) [m]
    arm2: np.ndarray  # (nc, 2) [m]
    bias: np.ndarray  # (nc,) b_n [m/s]
    friction: np.ndarray  # (nc,)
    impulse: np.ndarray  # (nc, 2) warm start, local (n, t) [N s]

    def __post_init__(self):
        self.inverse_mass = checks.array("inverse_mass", self.inverse_mass, (None, 3))
        self.bodies = checks.array("bodies", self.bodies, (None, 2))
        nb, nc = len(self.inverse_mass), len(self.bodies)
        self.free_velocity = checks.array("free_velocity", self.free_velocity, (nb, 3))
        for name, shape in dict(normal=(nc, 2), arm1=(nc, 2), arm2=(nc, 2), bias=(nc,), friction=(nc,), impulse=(nc, 2)).items():
            setattr(self, name, checks.array(name, getattr(self, name), shape))
        self.bodies = checks.ids("bodies", self.bodies, nb)
        checks.every(self.inverse_mass >= 0, "inverse_mass", self.inverse_mass, "≥ 0")
        checks.every(self.friction >= 0, "friction", self.friction, "µ ≥ 0")
        length = np.hypot(*self.normal.T)
        checks.every(abs(length - 1) <= 1e-6, "the length of normal", length, "1")
        checks.every(self.bodies[:, 0] != self.bodies[:, 1], "bodies", self.bodies[:, 0], "two different bodies")

    @property
    def contacts(self):
        """Number of contact points."""
        return len(self.bodies)

    def order(self):
        """In which the kernels want the points: those of a pair side by side, (nc,)."""
        return np.lexsort(self.bodies.T[::-1])

    def arrays(self):
        """Arguments of the kernels, points in their `order`."""
        order = self.order()
        return {name: value if name in ("inverse_mass", "free_velocity") else value[order] for name, value in vars(self).items()}

    def delassus(self):
        """The same problem as W and q."""
        nc, (a, b) = self.contacts, self.bodies.T
        n = self.normal
        t = np.stack([-n[:, 1], n[:, 0]], 1)
        turn = lambda r, d: r[:, 0] * d[:, 1] - r[:, 1] * d[:, 0]
        rows = lambda r: np.stack([np.column_stack([d, turn(r, d)]) for d in (n, t)], 1)  # (nc, 2, 3)
        jacobian = np.concatenate([-rows(self.arm1), rows(self.arm2)])
        body, point = np.concatenate([a, b]), np.tile(np.arange(nc), 2)
        q = np.zeros((nc, 2))
        np.add.at(q, point, np.einsum("kij,kj->ki", jacobian, self.free_velocity[body]))
        q[:, 0] += self.bias
        # every two sides that meet at a body
        order = np.argsort(body, kind="stable")
        order = order[(self.inverse_mass[body[order]] > 0).any(1)]
        count = np.bincount(body[order], minlength=len(self.inverse_mass))[body[order]]
        first = np.searchsorted(body[order], body[order])
        i = np.repeat(np.arange(len(order)), count)
        j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
        i, j = order[i], order[j]
        blocks = np.einsum("kia,ka,kja->kij", jacobian[i], self.inverse_mass[body[i]], jacobian[j])
        row = 2 * point[i][:, None, None] + np.array([[0], [1]])
        column = 2 * point[j][:, None, None] + np.array([0, 1])
        row, column = np.broadcast_to(row, blocks.shape), np.broadcast_to(column, blocks.shape)
        return DelassusProblem((row.ravel(), column.ravel(), blocks.ravel()), q, self.friction, self.impulse)


class DelassusProblem:
    """A step as W and q.

    Parameters
    ----------
    entries : (rows, columns, values)
        Entries of W (2 nc, 2 nc) in the order n₀, t₀, n₁, t₁ …; those of the same place are added [1/kg].
    q : (nc, 2) or (2 nc,) float array
        Velocities without impulses, b_n included, local (n, t) [m/s].
    friction : (nc,) float array
    impulse : (nc, 2) float array, optional
        Warm start, local (n, t) [N s].

    Attributes
    ----------
    row_start, column, block : (nc + 1,), (nb,) int and (nb, 2, 2) float arrays
        W in compressed rows of blocks, columns ascending, the diagonal always there.

    Raises
    ------
    ValueError
        If sizes do not fit, a number is not finite, W is asymmetric beyond 1e-8 of its largest entry or has a negative
        diagonal, or µ < 0.
    """

    def __init__(self, entries, q, friction, impulse=None):
        self.friction = checks.array("mu", friction, (None,))
        nc = len(self.friction)
        self.q = _pairs("q", q, nc)
        self.impulse = np.zeros((nc, 2)) if impulse is None else _pairs("the warm start", impulse, nc)
        checks.every(self.friction >= 0, "mu", self.friction, "µ ≥ 0")
        try:
            row, column, value = entries
        except (TypeError, ValueError):
            raise ValueError("entries: wanted (rows, columns, values) of W") from None
        value = checks.array("W", value, (None,))
        row, column = (checks.array(f"a {name} of W", places, value.shape) for name, places in (("row", row), ("column", column)))
        row, column = checks.ids("a row of W", row, 2 * nc), checks.ids("a column of W", column, 2 * nc)
        self._assemble(nc, row.astype(np.int64), column.astype(np.int64), value)

    def _assemble(self, nc, row, column, value):
        # every entry with its mirror image, and the diagonal; zeros where W has none
        diagonal = np.arange(2 * nc)
        zeros = np.zeros(len(value) + 2 * nc)
        row, column, value = np.concatenate([row, column, diagonal]), np.concatenate([column, row, diagonal]), np.concatenate([value, zeros])
        place, at = np.unique(row * 2 * nc + column, return_inverse=True)
        value = np.bincount(at.ravel(), value, len(place))
        row, column = place // (2 * nc or 1), place % (2 * nc or 1)
        mirror = np.argsort(column * 2 * nc + row)
        asymmetry, largest = abs(value - value[mirror]), abs(value).max(initial=0)
        if asymmetry.max(initial=0) > SYMMETRY * largest:
            k = asymmetry.argmax()
            raise ValueError(
                f"W is not symmetric: W[{row[k]}, {column[k]}] = {value[k]:.9g}, W[{column[k]}, {row[k]}] = {value[mirror[k]]:.9g}; wanted "
                f"a difference of at most {SYMMETRY:g} of its largest entry"
            )
        on_diagonal = value[row == column]
        checks.every(on_diagonal >= 0, "the diagonal of W", on_diagonal, "≥ 0, W being positive semi-definite")
        places, at = np.unique(row // 2 * nc + column // 2, return_inverse=True)
        self.block = np.zeros((len(places), 2, 2))
        self.block[at.ravel(), row % 2, column % 2] = value
        self.column = (places % (nc or 1)).astype(np.int32)
        self.row_start = np.searchsorted(places // (nc or 1), np.arange(nc + 1)).astype(np.int32)

    @property
    def contacts(self):
        """Number of contact points."""
        return len(self.friction)

    def entries(self):
        """Entries of W as (rows, columns, values), those that are zero left out; by row, columns ascending."""
        rows = np.repeat(np.arange(self.contacts), np.diff(self.row_start))
        row = (2 * rows[:, None, None] + np.array([[0], [1]]) + np.zeros((1, 2), int)).ravel()
        column = (2 * self.column[:, None, None] + np.array([0, 1]) + np.zeros((2, 1), int)).ravel()
        value = self.block.ravel()
        keep = np.flatnonzero(value)
        keep = keep[np.lexsort((column[keep], row[keep]))]
        return row[keep], column[keep], value[keep]

    def velocity(self, impulse):
        """u = W p + q of impulses (nc, 2), both local (n, t)."""
        u = self.q.copy()
        np.add.at(u, np.repeat(np.arange(self.contacts), np.diff(self.row_start)), np.einsum("kij,kj->ki", self.block, impulse[self.column]))
        return u


@dataclass
class Solution:
    """Result of `solve`. `velocity` is without b_n where the problem has its bodies, else u = W p + q."""

    solver: str
    contacts: int
    iterations: int
    residual: float  # natural map, relative [-]
    converged: bool  # the tolerance was reached
    seconds: float  # of the solver alone
    reaction: np.ndarray  # (nc, 2) impulses, local (n, t)
    velocity: np.ndarray  # (nc, 2) relative velocities, local (n, t)

    def save(self, path):
        """Write reaction and velocity as ``.npz`` or ``.h5``, whole or not at all."""
        if result_suffix(path) == ".npz":
            image = _npz(np.savez, reaction=self.reaction, velocity=self.velocity)
        else:

            def fill(file):
                file["reaction"], file["velocity"] = self.reaction, self.velocity
                file.attrs.update({field.name: getattr(self, field.name) for field in fields(self)[:6]})

            image = files.hdf5(fill)
        files.write(path, image)


def result_suffix(path):
    """``.npz`` or ``.h5``, from the name of a file for results; ValueError for any other."""
    return _suffix(path, (".npz", ".h5"))


def solve(problem, solver="auto", tolerance=1e-4, max_iterations=10000, warm=False):
    """Solve a one-step contact problem.

    Parameters
    ----------
    problem : path, BodyProblem or DelassusProblem
        A path is read by `load`.
    solver : str
        nlgs (plain Gauss–Seidel), sor (over-relaxed), nesterov (accelerated), exact or auto.
    tolerance : float
        Residual at which to stop [-]; 0 runs all iterations.
    max_iterations : int
        Sweeps, and of the exact solver its pivots or Newton steps.
    warm : bool
        Start from the impulses of the problem instead of zeros.

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        If the problem is malformed, the solver unknown or a setting out of range, or if numbers grow beyond those of doubles.
    ImportError
        If the kernels were not compiled.
    """
    try:
        from rcr import _kernel
    except ImportError as error:
        raise ImportError(
            f"rcr in {os.path.dirname(__file__)} has no kernels, only the analysis: the solver has to be compiled; from the sources: "
            "pip install . --config-settings=cmake.define.RCR_PLUGIN=OFF"
        ) from error
    settings = dict(
        solver=solver if isinstance(solver, str) else checks.choice("solver", solver, _kernel.solver_names()),
        tolerance=checks.number("tolerance", tolerance, "a residual ≥ 0", lambda v: v >= 0),
        max_iterations=checks.integer("maxIterations", max_iterations, "at least 1 and at most 2147483647", lambda v: 1 <= v < 2**31),
    )
    if not isinstance(problem, (BodyProblem, DelassusProblem)):
        problem = load(problem)
    start = problem.impulse if warm else np.zeros((problem.contacts, 2))
    if isinstance(problem, BodyProblem):
        order = problem.order()
        found = _kernel.solve(**{**problem.arrays(), "impulse": start[order]}, **settings, violation=np.inf)
        for name in ("impulse", "relative_velocity"):
            found[name][order] = found[name].copy()
    else:
        found = _kernel.solve_delassus(
            problem.row_start, problem.column, problem.block.reshape(-1, 4), problem.q, problem.friction, start, **settings
        )
    if not (np.isfinite(found["residual"]) and np.isfinite(found["impulse"]).all() and np.isfinite(found["relative_velocity"]).all()):
        raise ValueError(f"solver {solver!r} ended with numbers that are not finite; masses, velocities or W of the problem differ too much in size")
    return Solution(
        solver, problem.contacts, found["iterations"], found["residual"], found["converged"], found["seconds"],
        found["impulse"], found["relative_velocity"],
    )  # fmt: skip


# ---------------------------------------------------------------------------------------------- files


def load(path):
    """BodyProblem from ``.npz``, DelassusProblem from FCLIB ``.h5``/``.hdf5`` or Siconos ``.dat``.

    Raises
    ------
    ValueError
        If the file is malformed or of another kind; OSError if it cannot be read.
    """
    suffix = _suffix(path, (".npz", ".h5", ".hdf5", ".dat"))
    with files.reading(path, f"a {suffix} file"):
        return {".npz": _load_npz, ".dat": _load_siconos}.get(suffix, _load_fclib)(path)


def _load_npz(path):
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            files.check_size(member.filename, member.file_size, path)
    with np.load(path) as file:
        names = ("a", "b", "n", "ra", "rb", "bn", "mu", "p0", "im", "iI", "vfree", "meta")
        missing = [name for name in names if name not in file]
        if missing:
            raise ValueError(f"lacks {', '.join(missing)}; wanted the arrays {', '.join(names)}")
        d = {name: file[name] for name in names}
    nc, nb = np.size(d["a"]), np.size(d["iI"])
    shapes = dict(a=(nc,), b=(nc,), n=(nc, 2), ra=(nc, 2), rb=(nc, 2), bn=(nc,), mu=(nc,), p0=(nc, 2), im=np.shape(d["im"]), iI=(nb,), vfree=(nb, 3), meta=(3,))
    d = {name: checks.array(name, d[name], shape) for name, shape in shapes.items()}
    checks.every(d["mu"] >= 0, "mu", d["mu"], "µ ≥ 0")
    particles = d["meta"][2]
    if not (particles == int(particles) and 0 <= particles <= nb):
        raise ValueError(f"meta[2] = {particles:g}; wanted the number of particles, at most {nb}")
    if d["im"].shape == (nb,):
        d["im"] = np.column_stack([d["im"], d["im"]])
        d["im"][int(particles) :, 1] = 0  # walls move along x only
    inverse_mass = np.column_stack([checks.array("im", d["im"], (nb, 2)), d["iI"]])
    bodies = np.column_stack([checks.ids("a", d["a"], nb), checks.ids("b", d["b"], nb)])
    return BodyProblem(inverse_mass, d["vfree"], bodies, d["n"], d["ra"], d["rb"], d["bn"], d["mu"], d["p0"])


def _load_fclib(path):
    import h5py

    files.check_seal(path)
    with h5py.File(path, "r") as file:
        if "fclib_local" not in file:
            groups = [name for name in ("fclib_global", "fclib_global_rolling") if name in file]
            raise ValueError(f"no group fclib_local{' but ' + groups[0] if groups else ''}; wanted a local problem of FCLIB")
        group = file["fclib_local"]
        dimension = _scalar(group, "spacedim")
        if dimension != 2:
            raise ValueError(f"spacedim = {dimension}; wanted 2, contacts in the plane")
        if "V" in group or "R" in group:
            raise ValueError("holds equality constraints (V, R), which are not served; wanted W, q and mu alone")
        q, mu = _dataset(group, "vectors/q"), _dataset(group, "vectors/mu")
        guess = _dataset(file, "guesses/1/r") if "guesses/1/r" in file else None
        return DelassusProblem(_fclib_entries(group, 2 * len(mu)), q, mu, guess)


def _fclib_entries(group, size):
    """Rows, columns and values of the matrix W of FCLIB."""
    rows, columns, kind = (_scalar(group, f"W/{name}") for name in ("m", "n", "nz"))
    if (rows, columns) != (size, size):
        raise ValueError(f"W is {rows} × {columns} and mu holds {size // 2}; wanted 2 rows and columns a contact")
    pointers, index, value = (_dataset(group, f"W/{name}") for name in "pix")
    if kind >= 0:
        if min(len(pointers), len(index), len(value)) < kind:
            raise ValueError(f"W: nz = {kind} triplets, but p, i, x hold {len(pointers)}, {len(index)}, {len(value)}")
        return pointers[:kind], index[:kind], value[:kind]
    if kind not in (-1, -2):
        raise ValueError(f"W/nz = {kind}; wanted −1 (compressed columns), −2 (compressed rows) or a number of triplets")
    pointers = checks.ids("W/p", checks.array("W/p", pointers, (None,)), 2**31)
    if len(pointers) != size + 1 or pointers[0] != 0 or (np.diff(pointers) < 0).any() or min(len(index), len(value)) < pointers[-1]:
        raise ValueError(f"W/p is not {size + 1} ascending pointers into the {len(index)} entries of W/i and {len(value)} of W/x")
    index, value = index[: pointers[-1]], value[: pointers[-1]]
    outer = np.repeat(np.arange(size), np.diff(pointers))
    return (index, outer, value) if kind == -1 else (outer, index, value)


def save(path, problem):
    """Write a problem: with its bodies as ``.npz`` (``im`` is then (nb, 2), along x and y), or as FCLIB ``.h5``.

    Parameters
    ----------
    path : str
        Replaced if it exists.
    problem : BodyProblem
        A DelassusProblem has no bodies, so it goes to FCLIB only.

    Raises
    ------
    ValueError
        For another suffix, or a problem without bodies as ``.npz``.
    """
    if _suffix(path, (".npz", ".h5", ".hdf5")) != ".npz":
        return save_fclib(path, problem)
    if not isinstance(problem, BodyProblem):
        raise ValueError(f"{path}: the problem has no bodies; write it as .h5")
    p = problem
    a, b = p.bodies.T
    meta = [1.0, 1.0, len(p.inverse_mass)]  # dt and length: whatever units the problem is in
    arrays = dict(a=a, b=b, n=p.normal, ra=p.arm1, rb=p.arm2, bn=p.bias, mu=p.friction, p0=p.impulse)
    image = _npz(np.savez_compressed, im=p.inverse_mass[:, :2], iI=p.inverse_mass[:, 2], vfree=p.free_velocity, meta=meta, **arrays)
    files.write(path, image)


def _npz(save, **arrays):
    """Bytes of an ``.npz`` file, written by NumPy's `save`."""
    image = io.BytesIO()
    save(image, **arrays)
    return image.getvalue()


def save_fclib(path, problem, title="contact problem of yade-rcr"):
    """Write a problem as FCLIB ``fclib_local`` HDF5, W in compressed rows, its warm start as the first guess.

    Parameters
    ----------
    path : str
        Replaced if it exists.
    problem : BodyProblem, DelassusProblem or dict
        A dict holds the arrays of a BodyProblem by name.
    """
    if isinstance(problem, dict):
        problem = BodyProblem(**problem)
    if isinstance(problem, BodyProblem):
        problem = problem.delassus()
    row, column, value = problem.entries()
    size = 2 * problem.contacts

    def fill(file):
        integer = lambda name, data: file.create_dataset(name, data=np.atleast_1d(data).astype(np.int32))
        integer("fclib_local/spacedim", 2)
        for name, data in dict(nzmax=len(value), m=size, n=size, nz=-2, p=np.searchsorted(row, np.arange(size + 1)), i=column).items():
            integer(f"fclib_local/W/{name}", data)
        file["fclib_local/W/x"] = value
        file["fclib_local/vectors/q"], file["fclib_local/vectors/mu"] = problem.q.ravel(), problem.friction
        for name, text in dict(title=title, description="u = W r + q, local (n, t); b_n is in q", math_info="W symmetric, semi-definite").items():
            file[f"fclib_local/info/{name}"] = np.bytes_(text)
        integer("guesses/number_of_guesses", 1)
        file["guesses/1/r"], file["guesses/1/u"] = problem.impulse.ravel(), problem.velocity(problem.impulse).ravel()

    files.write(path, files.hdf5(fill))


def _load_siconos(path):
    with open(path, encoding="ascii", errors="replace") as file:
        lines = file.read().split("\n")
    words = _Words(lines)
    dimension, nc = words.integer("dimension"), words.integer("number of contacts")
    if dimension != 2:
        raise ValueError(f"dimension = {dimension}; wanted 2, contacts in the plane")
    storage, rows, columns = words.integer("storage of the matrix"), words.integer("rows of the matrix"), words.integer("columns of the matrix")
    if nc < 0 or (rows, columns) != (2 * nc, 2 * nc):
        raise ValueError(f"the matrix is {rows} × {columns} for {nc} contacts; wanted 2 rows and columns a contact")
    if storage not in (0, 1, 2):
        raise ValueError(f"storage {storage} of the matrix; wanted 0 dense, 1 blocks or 2 sparse")
    entries = (_siconos_dense, _siconos_blocks, _siconos_sparse)[storage](words, 2 * nc)
    q, mu = words.numbers("q", 2 * nc), words.numbers("mu", nc)
    return DelassusProblem(entries, q, mu)


class _Words:
    """The words of a text file one after another, and its lines."""

    def __init__(self, lines):
        self.lines, self.line, self.word = [line.split() for line in lines], 0, 0
        self.count = sum(map(len, self.lines))

    def skip_line(self):
        self.line, self.word = self.line + 1, 0

    def next_line(self):
        """The words that are left on the line, which may be all of the next."""
        while self.line < len(self.lines) and self.word >= len(self.lines[self.line]):
            self.skip_line()
        return self.lines[self.line][self.word :] if self.line < len(self.lines) else []

    def numbers(self, what, count):
        if not 0 <= count <= self.count:
            raise ValueError(f"{count} numbers of {what} are announced in a file of {self.count} words")
        found = []
        while len(found) < count and (words := self.next_line()):
            words = words[: count - len(found)]
            self.word += len(words)
            found += words
        if len(found) < count:
            raise ValueError(f"the file ends after {len(found)} of {count} numbers of {what}")
        try:
            return np.array(found, float)
        except ValueError:
            raise ValueError(f"{what} holds a word that is no number, before line {self.line + 2}") from None

    def integer(self, what):
        (value,) = self.numbers(what, 1)
        if not (abs(value) < 2**31 and value == np.floor(value)):
            raise ValueError(f"the {what} is {value:g}; wanted a whole number of 32 bits")
        return int(value)

    def integers(self, what, count):
        value = self.numbers(what, count)
        checks.every((abs(value) < 2**31) & (value == np.floor(value)), f"the {what}", value, "whole numbers of 32 bits")
        return value.astype(int)


def _siconos_dense(words, size):
    words.numbers("the size of the matrix", 2)
    value = words.numbers("the matrix", size * size)
    column, row = np.divmod(np.arange(size * size), size or 1)  # column by column
    return row, column, value


def _siconos_blocks(words, size):
    """Blocks row by row, each column by column; the sizes of block rows and columns are given as running sums."""
    count, rows, columns = words.integers("blocks", 3)
    row_end, column_end = words.integers("block rows", rows), words.integers("block columns", columns)
    filled1, filled2 = words.integers("index", 2)
    start, block_column = words.integers("index1", filled1), words.integers("index2", filled2)
    for ends, name in (row_end, "rows"), (column_end, "columns"):
        if (np.diff(ends, prepend=0) < 0).any() or (ends[-1] if len(ends) else 0) != size:
            raise ValueError(f"the ends of the block {name} do not rise from 0 to {size}")
    if count != filled2 or filled1 != rows + 1 or (np.diff(start) < 0).any() or start[-1] != count or ((block_column < 0) | (block_column >= columns)).any():
        raise ValueError(f"the index of the {count} blocks does not fit {rows} block rows and {columns} block columns")
    entries = []
    begin = lambda ends, k: ends[k - 1] if k else 0
    for i in range(rows):
        for k in range(start[i], start[i + 1]):
            j = block_column[k]
            if words.integer("number of a block") != k:
                raise ValueError(f"block {k} is not where its index says")
            row, column = np.arange(begin(row_end, i), row_end[i]), np.arange(begin(column_end, j), column_end[j])
            value = words.numbers(f"block {k}", len(row) * len(column))
            entries.append((np.tile(row, len(column)), np.repeat(column, len(row)), value))
    return tuple(np.concatenate(part) for part in zip(*entries)) if entries else (np.zeros(0, int), np.zeros(0, int), np.zeros(0))


def _siconos_sparse(words, size):
    """As CSparse prints: `col 3 : locations 6 to 9`, then `row : value`; or triplets `row column : value`."""
    words.integer("origin of the matrix")
    row, column, value, at, wanted = [], [], [], None, None
    while (line := words.next_line()) and (":" in line or wanted is None):
        text = " ".join(line)
        try:
            if line[0] == "col":
                at = int(line[1])
            elif "nnz:" in line:
                wanted = int(float(line[line.index("nnz:") + 1].rstrip(",")))
            elif ":" in line:
                split = line.index(":")
                places = [int(float(word)) for word in line[:split]]
                row.append(places[0])
                column.append(places[1] if split == 2 else at)
                value.append(float(line[split + 1]))
        except (ValueError, IndexError, TypeError):
            raise ValueError(f"line {words.line + 1} is no line of a sparse matrix: {text[:60]!r}") from None
        words.skip_line()
    if None in column:
        raise ValueError("entries of the sparse matrix stand before the first line `col`")
    if wanted is None or (wanted < 1e6 and wanted != len(value)):  # printed with six digits
        raise ValueError(f"the sparse matrix has {len(value)} entries; its header says {wanted}")
    return np.array(row, int), np.array(column, int), np.array(value, float)


# ---------------------------------------------------------------------------------------------- checks


def _suffix(path, known):
    suffix = os.path.splitext(files.path_of("the path of a problem", path))[1].lower()
    if suffix not in known:
        raise ValueError(f"{path}: unknown suffix {suffix!r}; wanted one of {', '.join(known)}")
    return suffix


def _pairs(name, array, count):
    """(count, 2) doubles, also from a flat array."""
    array = checks.reals(name, array)
    return checks.array(name, array.reshape(-1, 2) if array.size == 2 * count else array, (count, 2))


def _dataset(group, name):
    if name not in group or not hasattr(group[name], "dtype"):  # a group
        raise ValueError(f"{group.name[1:]} lacks {name}")
    data = group[name]
    if data.shape is None or data.dtype.kind not in "iuf":
        raise ValueError(f"{group.name[1:]}/{name} does not hold numbers")
    files.check_size(data.name[1:], data.nbytes, group.file.filename)
    return np.atleast_1d(data[()])


def _scalar(group, name):
    data = _dataset(group, name)
    if data.size != 1 or data.dtype.kind not in "iu":
        raise ValueError(f"{group.name[1:]}/{name} = {data}; wanted one whole number")
    return int(data.ravel()[0])
