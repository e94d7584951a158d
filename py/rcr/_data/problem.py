"""One-step contact problems in memory: with bodies, or as W and q. Needs NumPy."""

from dataclasses import dataclass

import numpy as np

from rcr._data import checks

LAWS = ("pull", "rolling_friction", "rolling_length", "rolling_impulse")  # beyond Coulomb's law
BLOCKED = 1e-20  # w_nn/w_tt of a blocked normal, negligibleLever² of coulomb.hpp, at most [-]
MOST_FRICTION = 1000  # errors of larger coefficients cannot be measured [-]
SYMMETRY = 1e-8  # largest |W − Wᵀ| over largest |W| [-]; files of Siconos reach 1e-10


@dataclass
class BodyProblem:
    """Contact problem of one step with nb bodies and nc contact points.

    The kernels' contact_problem.hpp has the equations. A ValueError reports wrong shapes, numbers
    that are not finite, negative masses or friction, normals of another length than 1, and contacts
    of a body with itself.
    """

    inverse_mass: np.ndarray  # (nb, 3) along x, y [1/kg], about z [1/(kg m²)]; 0 = prescribed
    free_velocity: np.ndarray  # (nb, 3) [m/s, m/s, 1/s]
    bodies: np.ndarray  # (nc, 2)
    normal: np.ndarray  # (nc, 2) from body 1 to body 2
    arm1: np.ndarray  # (nc, 2) [m]
    arm2: np.ndarray  # (nc, 2) [m]
    bias: np.ndarray  # (nc,) b_n [m/s]
    friction: np.ndarray  # (nc,)
    impulse: np.ndarray  # (nc, 2) warm start, local (n, t) [N s]
    # of docs/law.md, adhesion and rolling resistance; None: 0
    pull: np.ndarray = None  # (nc,) f_a dt [N s]
    rolling_friction: np.ndarray = None  # (nc,) µ_r [-]
    rolling_length: np.ndarray = None  # (nc,) R₁ + R₂ [m]
    rolling_impulse: np.ndarray = None  # (nc,) warm start [N s]

    def __post_init__(self):
        self.inverse_mass = checks.array("inverse_mass", self.inverse_mass, (None, 3))
        nb = len(self.inverse_mass)
        self.bodies = checks.ids("bodies", self.bodies, nb, (None, 2))
        nc = len(self.bodies)
        self.free_velocity = checks.array("free_velocity", self.free_velocity, (nb, 3))
        vectors = dict.fromkeys(("normal", "arm1", "arm2", "impulse"), (nc, 2))
        for name, shape in (vectors | dict(bias=(nc,), friction=(nc,))).items():
            setattr(self, name, checks.array(name, getattr(self, name), shape))
        for name in LAWS:
            given = getattr(self, name)
            given = np.zeros(nc) if given is None else given
            setattr(self, name, checks.array(name, given, (nc,)))
        for name in LAWS[:3]:
            checks.require(getattr(self, name) >= 0, name, getattr(self, name), "≥ 0")
        checks.require(self.inverse_mass >= 0, "inverse_mass", self.inverse_mass, "≥ 0")
        _check_friction("friction", self.friction)
        length = np.hypot(*self.normal.T)
        checks.require(abs(length - 1) <= 1e-6, "the length of normal", length, "1")
        one, two = self.bodies.T
        checks.require(one != two, "bodies", one, "two different bodies")

    @property
    def contacts(self):
        """Number of contact points."""
        return len(self.bodies)

    def order(self):
        """Return the kernels' order of the points, (nc,): by bodies, so that the points of a
        contact are side by side and forces do not depend on the order of contacts.
        """
        return np.lexsort(self.bodies.T[::-1])

    def arrays(self):
        """Return the arguments of the kernels, with the points in their `order`.

        Adhesion and rolling resistance are left out where no point has them.
        """
        self.__post_init__()  # attributes may have been set since
        order, of_bodies = self.order(), ("inverse_mass", "free_velocity")
        without = {"pull"} if not self.pull.any() else set()
        without |= set(LAWS[1:]) if not self.rolling_friction.any() else set()
        columns = [(name, value) for name, value in vars(self).items() if name not in without]
        return {name: value if name in of_bodies else value[order] for name, value in columns}

    def delassus(self):
        """Return the problem as W and q, a DelassusProblem.

        A ValueError refuses adhesion and rolling friction, which W, q and µ cannot hold. q_n is at
        least 0 at points of two prescribed bodies: the contact laws do not apply to them.
        """
        self.__post_init__()  # attributes may have been set since
        if self.pull.any() or self.rolling_friction.any():
            raise ValueError("W, q and mu hold neither adhesion nor rolling friction; save the "
                             "problem with its bodies, as .npz")
        nc, (a, b), n = self.contacts, self.bodies.T, self.normal
        t = np.stack([-n[:, 1], n[:, 0]], 1)
        cross = lambda r, d: r[:, 0] * d[:, 1] - r[:, 1] * d[:, 0]
        rows = lambda r: np.stack([np.column_stack([d, cross(r, d)]) for d in (n, t)], 1)
        # one side of a contact per row: body 1 of all contacts, then body 2
        jacobian = np.concatenate([-rows(self.arm1), rows(self.arm2)])  # (2 nc, 2, 3)
        body, point = np.concatenate([a, b]), np.tile(np.arange(nc), 2)
        q = np.zeros((nc, 2))
        np.add.at(q, point, np.einsum("kij,kj->ki", jacobian, self.free_velocity[body]))
        q[:, 0] += self.bias
        prescribed = (self.inverse_mass[self.bodies] == 0).all((1, 2))
        q[prescribed, 0] = np.maximum(q[prescribed, 0], 0)
        i, j = self._coupled_sides(body)
        mass = self.inverse_mass[body[i]]
        blocks = np.einsum("kia,ka,kja->kij", jacobian[i], mass, jacobian[j])
        own, same = np.zeros((nc, 2, 2)), point[i] == point[j]
        np.add.at(own, point[i][same], blocks[same])
        moves = np.ones((nc, 2))  # 0: rounding errors of a blocked normal direction
        moves[:, 0] = own[:, 0, 0] > BLOCKED * own[:, 1, 1]
        blocks *= moves[point[i], :, None] * moves[point[j], None, :]
        entries = *_places(point[i], point[j]), blocks.ravel()
        return DelassusProblem(entries, q, self.friction, self.impulse)

    def _coupled_sides(self, body):
        """Return all pairs of contact sides that share a body with a mass."""
        order = np.argsort(body, kind="stable")
        order = order[(self.inverse_mass[body[order]] > 0).any(1)]
        count = np.bincount(body[order], minlength=len(self.inverse_mass))[body[order]]
        first = np.searchsorted(body[order], body[order])
        i = np.repeat(np.arange(len(order)), count)
        j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
        return order[i], order[j]


class DelassusProblem:
    """Contact problem of one step as W and q.

    A ValueError reports sizes that do not fit, a number that is not finite, W asymmetric beyond
    1e-8 of its largest entry or with a negative diagonal, or µ < 0.

    Parameters
    ----------
    entries : (rows, columns, values)
        Entries of W (2 nc, 2 nc) in the order n₀, t₀, n₁, t₁ … [1/kg]. Entries of one place are
        added.
    q : (nc, 2) or (2 nc,) float array
        Velocities without impulses, b_n included, local (n, t) [m/s].
    friction : (nc,) float array
        Friction coefficients µ [-].
    impulse : (nc, 2) or (2 nc,) float array, optional
        Warm start, local (n, t) [N s].

    Attributes
    ----------
    row_start, column, block : (nc + 1,) int, (nb,) int and (nb, 2, 2) float arrays
        W in compressed rows of blocks. Columns ascend, and each row has its diagonal block.
    """

    def __init__(self, entries, q, friction, impulse=None):
        self.friction = checks.array("mu", friction, (None,))
        nc = len(self.friction)
        self.q = _pairs("q", q, nc)
        impulse = np.zeros(2 * nc) if impulse is None else impulse
        self.impulse = _pairs("the warm start", impulse, nc)
        _check_friction("mu", self.friction)
        try:
            row, column, value = entries
        except (TypeError, ValueError):
            raise ValueError("entries: expected (rows, columns, values) of W") from None
        value = checks.array("W", value, (None,))
        row, column = (checks.ids(f"a {name} of W", ids, 2 * nc, value.shape).astype(np.int64)
                       for name, ids in (("row", row), ("column", column)))
        self._assemble(nc, row, column, value)

    def _assemble(self, nc, row, column, value):
        size = 2 * nc
        # each entry, its mirror image, and the diagonal, with zeros for missing entries
        diagonal, zeros = np.arange(size), np.zeros(len(value) + size)
        row, column = np.concatenate([[row, column], [column, row], [diagonal] * 2], axis=1)
        value = np.concatenate([value, zeros])
        place, at = np.unique(row * size + column, return_inverse=True)
        value = np.bincount(at.ravel(), value, len(place))
        row, column = place // (size or 1), place % (size or 1)
        _check_matrix(row, column, value, size)
        places, at = np.unique(row // 2 * nc + column // 2, return_inverse=True)
        self.block = np.zeros((len(places), 2, 2))
        self.block[at.ravel(), row % 2, column % 2] = value
        self.column = (places % (nc or 1)).astype(np.int32)
        starts = np.searchsorted(places // (nc or 1), np.arange(nc + 1))
        self.row_start = starts.astype(np.int32)

    @property
    def contacts(self):
        """Number of contact points."""
        return len(self.friction)

    def _block_rows(self):
        return np.repeat(np.arange(self.contacts), np.diff(self.row_start))

    def entries(self):
        """Return the nonzero entries of W as (rows, columns, values), sorted by row and column."""
        (row, column), value = _places(self._block_rows(), self.column), self.block.ravel()
        keep = np.flatnonzero(value)
        keep = keep[np.lexsort((column[keep], row[keep]))]
        return row[keep], column[keep], value[keep]

    def velocity(self, impulse):
        """Return u = W p + q of impulses p (nc, 2), both local (n, t)."""
        u = self.q.copy()
        products = np.einsum("kij,kj->ki", self.block, impulse[self.column])
        np.add.at(u, self._block_rows(), products)
        return u


def _check_friction(name, friction):
    expected = f"µ ≥ 0, and at most {MOST_FRICTION}"
    checks.require((friction >= 0) & (friction <= MOST_FRICTION), name, friction, expected)


def _places(row, column):
    """Return rows and columns of the entries of 2 × 2 blocks, (4 n,) each."""
    rows, columns = 2 * row[:, None, None] + [[0], [1]], 2 * column[:, None, None] + [[0, 1]]
    return [index.ravel() for index in np.broadcast_arrays(rows, columns)]


def _check_matrix(row, column, value, size):
    """Raise a ValueError unless W is symmetric with a diagonal ≥ 0."""
    mirror = np.argsort(column * size + row)
    asymmetry, largest = abs(value - value[mirror]), abs(value).max(initial=0)
    if asymmetry.max(initial=0) > SYMMETRY * largest:
        k = asymmetry.argmax()
        one = f"W[{row[k]}, {column[k]}] = {value[k]:.9g}"
        two = f"W[{column[k]}, {row[k]}] = {value[mirror[k]]:.9g}"
        expected = f"a difference of at most {SYMMETRY:g} of its largest entry"
        raise ValueError(f"W is not symmetric: {one}, {two}; expected {expected}")
    diagonal = value[row == column]
    expected = "≥ 0, because W is positive semi-definite"
    checks.require(diagonal >= 0, "the diagonal of W", diagonal, expected)


def _pairs(name, array, count):
    """Return a flat or (count, 2) array as (count, 2) doubles."""
    array = checks.reals(name, array)
    array = array.reshape(-1, 2) if array.shape == (2 * count,) else array
    return checks.array(name, array, (count, 2))
