"""Files of contact problems: NumPy archives of problems with bodies, and FCLIB's HDF5."""

import io
import os
import zipfile

import numpy as np

from rcr._data import checks, files
from rcr._data.problem import BodyProblem, DelassusProblem
from rcr._data.siconos import load_siconos


def load(path):
    """Load a problem.

    Returns
    -------
    BodyProblem or DelassusProblem
        A BodyProblem from ``.npz``, a DelassusProblem from FCLIB's ``.h5`` or ``.hdf5`` and from
        Siconos' ``.dat``.

    Raises
    ------
    ValueError
        If the file is malformed or of another kind.
    OSError
        If the file cannot be read.
    """
    suffix = _suffix(path, (".npz", ".h5", ".hdf5", ".dat"))
    with files.reading(path, f"a {suffix} file"):
        return {".npz": _load_npz, ".dat": load_siconos}.get(suffix, _load_fclib)(path)


def save(path, problem):
    """Save a BodyProblem as ``.npz``, or any problem as FCLIB ``.h5``.

    Parameters
    ----------
    path : str
        An existing file is replaced.
    problem : BodyProblem or DelassusProblem
        A DelassusProblem has no bodies and needs ``.h5``.

    Raises
    ------
    ValueError
        If the suffix is unknown, or a problem without bodies is saved as ``.npz``.
    """
    if _suffix(path, (".npz", ".h5", ".hdf5")) != ".npz":
        return save_fclib(path, problem)
    if not isinstance(problem, BodyProblem):
        raise ValueError(f"{path}: the problem has no bodies; save it as .h5")
    p, (a, b) = problem, problem.bodies.T
    meta = [1.0, 1.0, len(p.inverse_mass)]  # dt and length 1: units as given; number of grains
    points = dict(a=a, b=b, n=p.normal, ra=p.arm1, rb=p.arm2, bn=p.bias, mu=p.friction)
    points["p0"] = p.impulse
    mass = dict(im=p.inverse_mass[:, :2], iI=p.inverse_mass[:, 2])
    image = npz(np.savez_compressed, **mass, vfree=p.free_velocity, meta=meta, **points)
    files.write(path, image)


def save_fclib(path, problem):
    """Save a problem as FCLIB's ``fclib_local``; its warm start becomes the first guess.

    `path` ends in ``.h5`` or ``.hdf5``; see `save`.
    """
    _suffix(path, (".h5", ".hdf5"))
    if isinstance(problem, BodyProblem):
        problem = problem.delassus()
    row, column, value = problem.entries()
    size = 2 * problem.contacts
    pointers = np.searchsorted(row, np.arange(size + 1))
    info = dict(title="contact problem of yade-rcr",
                description="u = W r + q, local (n, t); b_n is in q",
                math_info="W symmetric, semi-definite")

    def fill(file):
        def integer(name, data):
            file.create_dataset(name, data=np.atleast_1d(data).astype(np.int32))

        integer("fclib_local/spacedim", 2)
        matrix = dict(nzmax=len(value), m=size, n=size, nz=-2, p=pointers, i=column)
        for name, data in matrix.items():
            integer(f"fclib_local/W/{name}", data)
        file["fclib_local/W/x"] = value
        file["fclib_local/vectors/q"] = problem.q.ravel()
        file["fclib_local/vectors/mu"] = problem.friction
        for name, text in info.items():
            file[f"fclib_local/info/{name}"] = np.bytes_(text)
        integer("guesses/number_of_guesses", 1)
        file["guesses/1/r"] = problem.impulse.ravel()
        file["guesses/1/u"] = problem.velocity(problem.impulse).ravel()

    files.write(path, files.hdf5(fill))


def result_suffix(path):
    """Return ``.npz`` or ``.h5`` of a file for results; another suffix raises a ValueError."""
    return _suffix(path, (".npz", ".h5"))


def npz(save, **arrays):
    """Return the bytes of a NumPy archive, written by the function `save`."""
    image = io.BytesIO()
    save(image, **arrays)
    return image.getvalue()


def _suffix(path, known):
    suffix = os.path.splitext(files.path_of("the path of a problem", path))[1].lower()
    if suffix not in known:
        expected = f"one of {', '.join(known)}"
        raise ValueError(f"{path}: unknown suffix {suffix!r}; expected {expected}")
    return suffix


def _load_npz(path):
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            files.check_size(member.filename, member.file_size, path)
    with np.load(path) as file:
        names = ("a", "b", "n", "ra", "rb", "bn", "mu", "p0", "im", "iI", "vfree", "meta")
        missing = [name for name in names if name not in file]
        if missing:
            raise ValueError(f"lacks {', '.join(missing)}; expected the arrays {', '.join(names)}")
        d = {name: file[name] for name in names}
    nc, nb = np.size(d["a"]), np.size(d["iI"])
    shapes = dict.fromkeys(("a", "b", "bn", "mu"), (nc,))
    shapes |= dict.fromkeys(("n", "ra", "rb", "p0"), (nc, 2))
    shapes |= dict(im=np.shape(d["im"]), iI=(nb,), vfree=(nb, 3), meta=(3,))
    d = {name: checks.array(name, d[name], shapes[name]) for name in names}
    checks.require(d["mu"] >= 0, "mu", d["mu"], "µ ≥ 0")
    grains = d["meta"][2]
    if not (grains == int(grains) and 0 <= grains <= nb):
        expected = f"the number of grains, at most {nb}"
        raise ValueError(f"meta[2] = {grains:g}; expected {expected}")
    if d["im"].shape == (nb,):
        d["im"] = np.column_stack([d["im"], d["im"]])
        d["im"][int(grains) :, 1] = 0  # walls move along x alone
    inverse_mass = np.column_stack([checks.array("im", d["im"], (nb, 2)), d["iI"]])
    bodies = np.column_stack([checks.ids("a", d["a"], nb), checks.ids("b", d["b"], nb)])
    points = (d[name] for name in ("n", "ra", "rb", "bn", "mu", "p0"))
    return BodyProblem(inverse_mass, d["vfree"], bodies, *points)


def _load_fclib(path):
    import h5py

    files.check_seal(path)
    with h5py.File(path, "r") as file:
        if "fclib_local" not in file:
            others = [name for name in ("fclib_global", "fclib_global_rolling") if name in file]
            found = f" but {others[0]}" if others else ""
            raise ValueError(f"no group fclib_local{found}; expected a local problem of FCLIB")
        group = file["fclib_local"]
        dimension = _scalar(group, "spacedim")
        if dimension != 2:
            raise ValueError(f"spacedim = {dimension}; expected 2, contacts in the plane")
        if "V" in group or "R" in group:
            message = "equality constraints (V, R) are not supported; expected W, q and mu alone"
            raise ValueError(message)
        q, mu = _dataset(group, "vectors/q"), _dataset(group, "vectors/mu")
        guess = _dataset(file, "guesses/1/r") if "guesses/1/r" in file else None
        return DelassusProblem(_fclib_entries(group, 2 * len(mu)), q, mu, guess)


def _fclib_entries(group, size):
    """Return rows, columns and values of the matrix W."""
    rows, columns, kind = (_scalar(group, f"W/{name}") for name in ("m", "n", "nz"))
    if (rows, columns) != (size, size):
        given = f"W is {rows} × {columns} and mu holds {size // 2}"
        raise ValueError(f"{given}; expected 2 rows and columns per contact")
    pointers, index, value = (_dataset(group, f"W/{name}") for name in "pix")
    if kind >= 0:
        lengths = [len(array) for array in (pointers, index, value)]
        if min(lengths) < kind:
            given = ", ".join(map(str, lengths))
            raise ValueError(f"W: nz = {kind} triplets, but p, i, x hold {given}")
        return pointers[:kind], index[:kind], value[:kind]
    if kind not in (-1, -2):
        expected = "−1 (compressed columns), −2 (compressed rows) or a number of triplets"
        raise ValueError(f"W/nz = {kind}; expected {expected}")
    pointers = checks.ids("W/p", checks.array("W/p", pointers, (None,)), 2**31)
    count = pointers[-1] if len(pointers) else -1
    fits = len(pointers) == size + 1 and pointers[0] == 0 and (np.diff(pointers) >= 0).all()
    if not fits or min(len(index), len(value)) < count:
        held = f"the {len(index)} entries of W/i and {len(value)} of W/x"
        raise ValueError(f"W/p is not {size + 1} ascending pointers into {held}")
    index, value = index[:count], value[:count]
    outer = np.repeat(np.arange(size), np.diff(pointers))
    return (index, outer, value) if kind == -1 else (outer, index, value)


def _dataset(group, name):
    """Return a dataset of numbers as an array with at least one axis."""
    if name not in group or not hasattr(group[name], "dtype"):  # missing, or a group
        raise ValueError(f"{group.name[1:]} lacks {name}")
    data = group[name]
    if data.shape is None or data.dtype.kind not in "iuf":
        raise ValueError(f"{group.name[1:]}/{name} does not hold numbers")
    files.check_size(data.name[1:], data.nbytes, group.file.filename)
    return np.atleast_1d(data[()])


def _scalar(group, name):
    data = _dataset(group, name)
    if data.size != 1 or data.dtype.kind not in "iu":
        raise ValueError(f"{group.name[1:]}/{name} = {data}; expected one whole number")
    return int(data.ravel()[0])
