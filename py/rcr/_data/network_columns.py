"""Columns of a contact network: names, shapes and checks. Needs NumPy."""

import numpy as np

from rcr._data import checks, files

LEFT, BOTTOM, RIGHT, TOP, OTHER = -1, -2, -3, -4, -5  # ids of obstacles; body #k is OTHER − k
CAP_CAP, CAP_SIDE, SIDE_SIDE, OBSTACLE = range(4)  # types of contacts

SHAPES = dict(
    particles=dict(id=(), position=(2,), angle=(), R=(), cap_radius=(), half_length=(), mass=(),
                   velocity=(3,), clump=(), center=(2,), shape=()),
    contacts=dict(body1=(), body2=(), type=(), normal=(2,), branch=(2,), force=(2,), position=(2,),
                  points=(), friction=(), point_moments=(2, 2), adhesion=(), rolling_moment=()),
)  # fmt: skip
MOST = 10**8  # largest id; the analysis makes arrays by id
INTEGERS = {"id", "body1", "body2", "type", "points", "clump", "shape"}


def checked(group, arrays):
    """Return the columns of a group as arrays of integers or doubles, after a check of shapes."""
    shapes = SHAPES[group]
    missing = sorted(set(shapes) - set(arrays))
    if missing:
        expected = ", ".join(shapes)
        raise ValueError(f"group {group!r} lacks {', '.join(missing)}; expected {expected}")
    first = next(iter(shapes))
    rows, found = len(checks.reals(f"{group}/{first}", arrays[first], (None,))), {}
    for column, shape in shapes.items():
        name = f"{group}/{column}"
        values = checks.reals(name, arrays[column], (rows, *shape))
        if column == "adhesion":
            checks.require(values >= 0, name, values, "a pull ≥ 0 [N]")
        if column == "friction":
            valid = np.isnan(values) | (values >= 0)
            checks.require(valid, name, values, "a coefficient ≥ 0, or NaN if it is unknown")
        elif not np.isfinite(values).all():
            raise ValueError(f"{name} holds a number that is not finite")
        if column in INTEGERS:
            whole = (values == np.floor(values)) & (np.abs(values) < 2**63)
            checks.require(whole, name, values, "whole numbers of 64 bits")
            values = np.asarray(arrays[column]).astype(np.int64)
        found[column] = values
    return found


def rows(known, ids):
    """Return the row of each id in the array `known`, −1 for an unknown id."""
    if not len(known):
        return np.full(np.shape(ids), -1)
    order = np.argsort(known)
    at = order[np.minimum(np.searchsorted(known, ids, sorter=order), len(known) - 1)]
    return np.where(known[at] == ids, at, -1)


def read(file, group, path):
    """Return the columns of a group of an HDF5 file."""
    if not hasattr(file[group], "items"):
        raise ValueError(f"{group} is not a group of columns")
    columns = {}
    for name, data in file[group].items():
        if getattr(data, "shape", None) is None:
            raise ValueError(f"{group}/{name} is not a column")
        files.check_size(f"{group}/{name}", data.nbytes, path)
        columns[name] = data[()]
    return columns


def check_meaning(particles, contacts, shapes):
    """Raise a ValueError unless the columns and `Outline`s can be those of a scene."""
    for group, columns, rules in (("particles", particles, _of_grains(particles, shapes)),
                                  ("contacts", contacts, _of_contacts(contacts, particles["id"]))):
        for name, good, expected in rules:
            checks.require(good, f"{group}/{name}", columns[name], expected)
    length = np.hypot(*contacts["normal"].T)
    checks.require(abs(length - 1) < 1e-6, "the length of contacts/normal", length, "1")
    normal_force = np.einsum("ca,ca->c", contacts["force"], contacts["normal"])
    if len(length) and not contacts["adhesion"].any() and not normal_force.mean() > 0:
        given = f"the mean normal force is {normal_force.mean():g}"
        raise ValueError(f"{given}; expected > 0, compression")
    distance = _distances_along_normals(particles, contacts)
    if len(distance) and not distance.mean() > 0:
        given = f"the mean distance of grains along contacts/normal is {distance.mean():g}"
        raise ValueError(f"{given}; expected > 0: branch and normal point from body 1 to body 2")


def _distances_along_normals(particles, contacts):
    """Return the distance of centres along the normal of each contact between grains [m].

    It is positive between convex grains. Branch vectors of clumps, which may be hooked into each
    other, are replaced by those of their members.
    """
    inner = contacts["body2"] >= 0
    one, two = (rows(particles["id"], contacts[body][inner]) for body in ("body1", "body2"))
    from_center = particles["position"] - particles["center"]
    branch = contacts["branch"][inner] + from_center[two] - from_center[one]
    return np.einsum("ca,ca->c", branch, contacts["normal"][inner])


def _of_grains(p, shapes):
    """Return (column, mask of valid rows, what is expected) of the grains."""
    tips, shape = p["half_length"] + p["cap_radius"], p["shape"]
    known = (shape >= -1) & (shape < len(shapes))
    inscribed = np.array([outline.inscribed for outline in shapes] + [1.0])  # over R
    inscribed = np.where(shape >= 0, inscribed[np.where(known, shape, -1)] * tips, p["cap_radius"])
    _, row, count = np.unique(p["id"], return_inverse=True, return_counts=True)
    return [
        *((name, p[name] > 0, "> 0") for name in ("R", "cap_radius", "mass")),
        ("half_length", p["half_length"] >= 0, "≥ 0"),
        ("R", abs(p["R"] - tips) <= 1e-6 * tips, "half_length + cap_radius"),
        ("shape", known, f"−1, or a row of the {len(shapes)} shapes"),
        ("cap_radius", abs(p["cap_radius"] - inscribed) <= 1e-6 * tips,
         "the inscribed radius of its shape, times R"),
        ("id", (p["id"] >= 0) & (p["id"] <= MOST) & (count[row] == 1),
         f"ids from 0 to {MOST:g}, each once"),
        ("clump", ~np.isin(p["clump"], p["id"]) & (p["clump"] >= -1) & (p["clump"] <= MOST),
         f"−1, or an id up to {MOST:g} that no particle has")]


def _of_contacts(c, ids):
    """Return (column, mask of valid rows, what is expected) of the contacts."""
    one, two, kind = c["body1"], c["body2"], c["type"]
    return [
        ("body1", np.isin(one, ids), "the id of a particle"),
        ("body2", (two < 0) | np.isin(two, ids),
         "the id of a particle, or a negative one of an obstacle"),
        ("body2", one != two, "another body than body 1"),
        ("type", (kind >= CAP_CAP) & (kind <= OBSTACLE), "0 to 3"),
        ("type", (kind == OBSTACLE) == (two < 0),
         f"{OBSTACLE} for an obstacle as body 2, and only there"),
        ("points", np.isin(c["points"], (1, 2)), "1 or 2"),
        ("point_moments", (c["point_moments"] == 0) | (c["points"] == 2)[:, None, None],
         "0 for a contact of one point")]
