"""Files of contact problems: NumPy archives of problems with bodies, and FCLIB's HDF5."""

import io
import os
import zipfile

import numpy as np

from rcr._data import checks, files
from rcr._data.problem import LAWS, BodyProblem, DelassusProblem
from rcr._data.siconos import load_siconos


def load(path):
    """Return the problem of a file: a BodyProblem of ``.npz``, else a DelassusProblem.

    FCLIB has the suffix ``.h5`` or ``.hdf5``, Siconos ``.dat``. A ValueError reports a file that is
    malformed or of another kind, an OSError one that cannot be read.
    """
    suffix = _suffix(path, (".npz", ".h5", ".hdf5", ".dat"))
    with files.reading(path, f"a {suffix} file"):
        return {".npz": _load_npz, ".dat": load_siconos}.get(suffix, _load_fclib)(path)


def save(path, problem):
    """Save a BodyProblem as ``.npz``, or any problem as FCLIB ``.h5``; replace an existing file.

    A ValueError reports an unknown suffix, or a problem without bodies for ``.npz``.
    """
    if _suffix(path, (".npz", ".h5", ".hdf5")) != ".npz":
        return save_fclib(path, problem)
    if not isinstance(problem, BodyProblem):
        raise ValueError(f"{path}: the problem has no bodies; save it as .h5")
    p, (a, b) = problem, problem.bodies.T
    meta = [1.0, 1.0, len(p.inverse_mass)]  # dt and length 1: units as given; number of grains
    points = dict(a=a, b=b, n=p.normal, ra=p.arm1, rb=p.arm2, bn=p.bias, mu=p.friction)
    points["p0"] = p.impulse
    laws = {name: getattr(p, name) for name in LAWS}
    points |= {name: values for name, values in laws.items() if values.any()}
    mass = dict(im=p.inverse_mass[:, :2], iI=p.inverse_mass[:, 2])
    image = npz(np.savez_compressed, **mass, vfree=p.free_velocity, meta=meta, **points)
    files.write(path, image)


def save_fclib(path, problem):
    """Save a problem as FCLIB's ``fclib_local`` (.h5), its warm start as the first guess."""
    _suffix(path, (".h5", ".hdf5"))
    if isinstance(problem, BodyProblem):
        problem = problem.delassus()
    row, column, value = problem.entries()
    size = 2 * problem.contacts
    integers = {
        "fclib_local/spacedim": 2, "fclib_local/W/nzmax": len(value), "fclib_local/W/m": size,
        "fclib_local/W/n": size, "fclib_local/W/nz": -2,
        "fclib_local/W/p": np.searchsorted(row, np.arange(size + 1)), "fclib_local/W/i": column,
        "guesses/number_of_guesses": 1}
    other = {
        "fclib_local/W/x": value, "fclib_local/vectors/q": problem.q.ravel(),
        "fclib_local/vectors/mu": problem.friction, "guesses/1/r": problem.impulse.ravel(),
        "guesses/1/u": problem.velocity(problem.impulse).ravel(),
        "fclib_local/info/title": np.bytes_("contact problem of yade-rcr"),
        "fclib_local/info/description": np.bytes_("u = W r + q, local (n, t); b_n is in q"),
        "fclib_local/info/math_info": np.bytes_("W symmetric, semi-definite")}

    def fill(file):
        for name, data in integers.items():
            file[name] = np.atleast_1d(data).astype(np.int32)
        for name, data in other.items():
            file[name] = data

    files.write(path, files.hdf5(fill))


def result_suffix(path):
    """Return ``.npz`` or ``.h5`` of a file for results; another suffix raises a ValueError."""
    return _suffix(path, (".npz", ".h5"))


def npz(writer, **arrays):
    """Return the bytes of a NumPy archive, written by the function `writer`."""
    image = io.BytesIO()
    writer(image, **arrays)
    return image.getvalue()


def _suffix(path, known):
    suffix = os.path.splitext(files.path_of("the path of a problem", path))[1].lower()
    if suffix not in known:
        raise ValueError(f"{path}: unknown suffix {suffix!r}; expected one of {', '.join(known)}")
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
        laws = {name: file[name] for name in LAWS if name in file}
    nc, nb = np.size(d["a"]), np.size(d["iI"])
    shapes = dict.fromkeys(("bn", "mu"), (nc,)) | dict.fromkeys(("n", "ra", "rb", "p0"), (nc, 2))
    shapes |= dict(iI=(nb,), vfree=(nb, 3), meta=(3,))
    d |= {name: checks.array(name, d[name], shape) for name, shape in shapes.items()}
    checks.require(d["mu"] >= 0, "mu", d["mu"], "µ ≥ 0")
    grains = d["meta"][2]
    if not (grains == int(grains) and 0 <= grains <= nb):
        raise ValueError(f"meta[2] = {grains:g}; expected the number of grains, at most {nb}")
    if np.shape(d["im"]) == (nb,):  # walls move along x alone
        d["im"] = np.column_stack([d["im"], np.where(np.arange(nb) < grains, d["im"], 0)])
    inverse_mass = np.column_stack([checks.array("im", d["im"], (nb, 2)), d["iI"]])
    bodies = np.column_stack([checks.ids(name, d[name], nb, (nc,)) for name in "ab"])
    points = (d[name] for name in ("n", "ra", "rb", "bn", "mu", "p0"))
    return BodyProblem(inverse_mass, d["vfree"], bodies, *points, **laws)


def _load_fclib(path):
    with files.open_hdf5(path) as file:
        if "fclib_local" not in file:
            others = [name for name in ("fclib_global", "fclib_global_rolling") if name in file]
            found = f" but {others[0]}" if others else ""
            raise ValueError(f"no group fclib_local{found}; expected a local problem of FCLIB")
        group = file["fclib_local"]
        dimension = _scalar(group, "spacedim")
        if dimension != 2:
            raise ValueError(f"spacedim = {dimension}; expected 2, contacts in the plane")
        if "V" in group or "R" in group:
            raise ValueError("equality constraints (V, R); expected W, q and mu alone")
        q, mu = _dataset(group, "vectors/q"), _dataset(group, "vectors/mu")
        guess = _dataset(file, "guesses/1/r") if "guesses/1/r" in file else None
        return DelassusProblem(_fclib_entries(group, 2 * len(mu)), q, mu, guess)


def _fclib_entries(group, size):
    """Return rows, columns and values of the matrix W."""
    rows, columns, kind = (_scalar(group, f"W/{name}") for name in ("m", "n", "nz"))
    if (rows, columns) != (size, size):
        raise ValueError(f"W is {rows} × {columns}; expected {size} × {size}, 2 per number of mu")
    pointers, index, value = (_dataset(group, f"W/{name}") for name in "pix")
    if kind >= 0:
        lengths = [len(array) for array in (pointers, index, value)]
        if min(lengths) < kind:
            raise ValueError(f"W: nz = {kind} triplets, but p, i, x hold {lengths}")
        return pointers[:kind], index[:kind], value[:kind]
    if kind not in (-1, -2):
        raise ValueError(f"W/nz = {kind}; expected −1 (columns), −2 (rows) or a number of triplets")
    pointers = checks.ids("W/p", pointers, 2**31, (None,))
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
