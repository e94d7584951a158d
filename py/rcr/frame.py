"""A scene at one moment as plain arrays: grains, contacts, obstacles, cell. What is drawn, exported and measured. Needs NumPy.

`Frame.of` takes the present scene of YADE, a saved `rcr.Network` or its file. Everything lies in the plane z = 0 and is per unit depth.

Conventions
-----------
* A grain is a body of the shape `Rcr` or `Sphere` (a disc in the plane); a clump's members are grains with the clump's id.
* An obstacle is a `Wall`, `Box` or `Facet`. A grain whose motion is prescribed is `fixed`.
* The force of a contact acts on body 2 from body 1, the normal runs from 1 to 2, compression is positive.
* Positions of grains are the present ones. A step moves the bodies after its forces, so contacts lie, by dt times a velocity, where
  the forces belong: lever arms are those of the step that found the forces.
"""

import math
import os
from dataclasses import dataclass, field

import numpy as np

from rcr.network import CAP_CAP, WALL, Network

KINDS = ("rcr", "disc", "clumped", "fixed")

_GRAINS = dict(id=int, clump=int, fixed=bool, position=(float, 2), angle=float, half_length=float, cap_radius=float, mass=float,
               velocity=(float, 3), color=(float, 3))  # fmt: skip
_CONTACTS = dict(body1=int, body2=int, type=int, points=int, position=(float, 2), normal=(float, 2), force=(float, 2), friction=float,
                 shift=(float, 2))  # fmt: skip
_WALLS = dict(id=int, axis=int, position=float)


def _columns(kinds, rows):
    """Rows of values as {name: array}, also if there is none."""
    table = np.array(rows, dtype=[(name, *(kind if isinstance(kind, tuple) else (kind,))) for name, kind in kinds.items()])
    return {name: np.ascontiguousarray(table[name]) for name in kinds}


@dataclass
class Frame:
    """Bodies and contacts at one moment.

    Attributes
    ----------
    grains : dict of arrays
        ``id`` (N,), ``clump`` (N,) id of the clump or −1, ``fixed`` (N,) bool, ``position`` (N, 2) [m], ``angle`` (N,) of the long axis
        to x [rad], ``half_length``, ``cap_radius`` (N,) [m], ``mass`` (N,) [kg/m], ``velocity`` (N, 3) [m/s, m/s, 1/s], ``color`` (N, 3)
        that of YADE's view.
    contacts : dict of arrays
        ``body1``, ``body2``, ``type`` (C,) 0 cc, 1 cs, 2 ss, 3 wall, ``points`` (C,) 1 or 2, ``position`` (C, 2) of the resultant
        [m], ``normal`` (C, 2), ``force`` (C, 2) [N/m], ``friction`` (C,) µ or NaN where it is not known, ``arm1``, ``arm2`` (C, 2)
        from the centre of the body to the position, 0 for obstacles [m].
    walls : dict of arrays
        ``id``, ``axis`` 0 or 1 of the normal, ``position`` along it [m].
    outlines : list of (id, kind, (k, 2) array)
        Corners of boxes ("box") and ends of facets ("facet") [m].
    cell : (2, 2) array or None
        Edges of the periodic cell as columns [m].
    time : float
        [s], NaN where it is not known.
    """

    grains: dict
    contacts: dict
    walls: dict = field(default_factory=lambda: _columns(_WALLS, []))
    outlines: list = field(default_factory=list)
    cell: np.ndarray = None
    time: float = math.nan

    @classmethod
    def of(cls, what=None):
        """Frame of a scene, network or file.

        Parameters
        ----------
        what : None, Frame, Network or path
            None is the present scene of YADE; a path is that of a file which `Network.load` reads.

        Raises
        ------
        ValueError
            If it is None outside YADE; TypeError if it is something else.
        """
        if what is None:
            return cls.of_scene()
        if isinstance(what, cls):
            return what
        if isinstance(what, (str, os.PathLike)):
            what = Network.load(what)
        if isinstance(what, Network):
            return cls.of_network(what)
        raise TypeError(f"{type(what).__name__} given; wanted None (the present scene of YADE), a Frame, a Network or the path of one")

    @classmethod
    def of_scene(cls):
        """Frame of YADE's present scene."""
        try:
            from yade.wrapper import Omega
        except ImportError as error:
            raise ValueError("no scene: this Python runs without YADE; give a rcr.Network, or the path of its file") from error
        return _read_scene(Omega())

    @classmethod
    def of_network(cls, network):
        """Frame of a contact network; its obstacles are not in it, only the contacts with them."""
        p, c = network.particles, network.contacts
        rows = len(p["id"])
        radius = p["cap_radius"]
        color = np.full((rows, 3), 0.7)
        grains = {name: p[name] for name in ("id", "position", "angle", "half_length", "mass", "velocity")}
        grains |= dict(cap_radius=radius, clump=np.full(rows, -1), fixed=np.zeros(rows, bool), color=color)
        contacts = {name: c[name] for name in ("body1", "body2", "type", "points", "position", "normal", "force")}
        friction = c.get("friction", network.attributes.get("friction", math.nan))
        contacts["friction"] = np.broadcast_to(np.asarray(friction, float), len(c["body1"]))
        frame = cls(grains, contacts, time=float(network.attributes.get("time", math.nan)))
        one = frame.rows(c["body1"])
        contacts["arm1"] = c["position"] - p["position"][one]
        contacts["arm2"] = np.where(network.between_particles[:, None], contacts["arm1"] - c["branch"], 0.0)
        return frame

    def rows(self, ids):
        """Rows of the grains with these ids; −1 for what is no grain."""
        known = self.grains["id"]
        if not len(known):
            return np.full(np.shape(ids), -1)
        order = np.argsort(known)
        at = order[np.minimum(np.searchsorted(known, ids, sorter=order), len(known) - 1)]
        return np.where(known[at] == ids, at, -1)

    @property
    def between_grains(self):
        """Mask of the contacts between grains, fixed ones too, (C,) bool."""
        return (self.rows(self.contacts["body1"]) >= 0) & (self.rows(self.contacts["body2"]) >= 0)

    @property
    def radius(self):
        """Circumscribed radius R of each grain, (N,) [m]."""
        return self.grains["half_length"] + self.grains["cap_radius"]

    def mean_radius(self):
        """⟨R⟩ of the free grains, of all if none is free [m]."""
        free = ~self.grains["fixed"]
        return float(self.radius[free if free.any() else slice(None)].mean()) if len(free) else math.nan

    def areas(self):
        """Area of each grain's outline, (N,) [m²]."""
        r, a = self.grains["cap_radius"], self.grains["half_length"]
        return np.pi * r**2 + 4 * a * r

    def kinds(self):
        """Index of each grain in `KINDS`, (N,)."""
        disc = (self.grains["half_length"] == 0).astype(int)
        return np.where(self.grains["fixed"], 3, np.where(self.grains["clump"] >= 0, 2, disc))

    def normal_force(self):
        """f_n of each contact, (C,) [N/m]."""
        return np.einsum("ca,ca->c", self.contacts["force"], self.contacts["normal"])

    def mobilization(self):
        """|f_t|/(µ f_n) of each contact, 0 where there is no force or friction, (C,) [-]."""
        normal, n = self.normal_force(), self.contacts["normal"]
        tangential = self.contacts["force"][:, 1] * n[:, 0] - self.contacts["force"][:, 0] * n[:, 1]
        limit = self.contacts["friction"] * normal
        return np.divide(np.abs(tangential), limit, out=np.zeros_like(limit), where=limit > 0)

    def per_grain(self, values):
        """Sum of a number of the contacts over the contacts of each grain; those of a clump share the sum of its members, (N,)."""
        total = np.zeros(len(self.grains["id"]))
        for body in ("body1", "body2"):
            at = self.rows(self.contacts[body])
            np.add.at(total, at[at >= 0], values[at >= 0])
        clump = self.grains["clump"]
        member = clump >= 0
        if member.any():
            _, group = np.unique(clump[member], return_inverse=True)
            total[member] = np.bincount(group, total[member])[group]
        return total

    def stress_tensors(self):
        """Mean stress in each grain by the moments of its contact forces (Love, Weber), compression positive.

        σ = (1/A) Σ f ⊗ r summed over its contacts, f being the force that the grain exerts and r the arm from its centre. Weight and
        inertia are left out: the stress is that of the contacts. Times the areas over the volume, the sum is `Network.stress`.

        Returns
        -------
        (N, 2, 2) float array
            [Pa]
        """
        sums = np.zeros((len(self.grains["id"]), 2, 2))
        for body, arm, sign in (("body1", "arm1", 1), ("body2", "arm2", -1)):
            at = self.rows(self.contacts[body])
            moments = sign * np.einsum("ca,cb->cab", self.contacts["force"], self.contacts[arm])
            np.add.at(sums, at[at >= 0], moments[at >= 0])
        return sums / self.areas()[:, None, None]

    def wrap(self, points):
        """Shifts that bring points into the periodic cell, (n, 2) [m]; zeros without one."""
        points = np.asarray(points, float)
        if self.cell is None:
            return np.zeros_like(points)
        return -np.floor(points @ np.linalg.inv(self.cell).T) @ self.cell.T

    def segments(self):
        """From the centre of 1 to the contact to the centre of 2, (C, 3, 2) [m]; an obstacle's centre is the contact."""
        place = self.contacts["position"]
        return np.stack([place - self.contacts["arm1"], place, place - self.contacts["arm2"]], axis=1)

    def extent(self):
        """Lower left and upper right corner of what a picture of the frame shows, (2, 2) [m].

        The periodic cell and the grains, but for strays: those farther from the box of 98 % of all, along x and along y, than half its
        size. Of obstacles what lies within half the size of all that: a long floor does not make the grains dots.
        """
        corners = [(self.cell @ np.array([[0, 1, 0, 1], [0, 0, 1, 1]])).T] if self.cell is not None else []
        if len(self.grains["id"]):
            place = self.grains["position"] + self.wrap(self.grains["position"])
            low, high = np.quantile(place, (0.01, 0.99), axis=0)
            near = (np.abs(place - 0.5 * (low + high)) <= 0.5 * (high - low) + 0.5 * (high - low).max() + 2 * self.mean_radius()).all(axis=1)
            reach = np.column_stack([half_extents(self.grains, k) for k in (0, 1)])
            corners += [(place - reach)[near], (place + reach)[near]]
        obstacles = [vertices for _, _, vertices in self.outlines]
        around = np.concatenate(corners or obstacles or [np.zeros((1, 2))])
        low, high = around.min(axis=0), around.max(axis=0)
        reach, middle = 0.5 * (high - low).max(), 0.5 * (low + high)
        obstacles += [np.where([axis == 0, axis == 1], at, middle)[None] for axis, at in zip(self.walls["axis"], self.walls["position"])]
        shown = np.clip(np.concatenate([[low, high], *obstacles]), low - reach, high + reach)
        return np.stack([shown.min(axis=0), shown.max(axis=0)])


def half_extents(grains, axis):
    """Half the width of grains along x (axis 0) or y (1), (N,) [m]."""
    along = np.abs(np.cos(grains["angle"]) if axis == 0 else np.sin(grains["angle"]))
    return grains["half_length"] * along + grains["cap_radius"]


def polygons(grains, points=12):
    """Outlines of grains as polygons, `points` on each cap; (N, 2 points, 2) [m]."""
    half = np.linspace(-np.pi / 2, np.pi / 2, points)
    turn = np.concatenate([half, half + np.pi])
    sign = np.repeat([1, -1], points)
    x = grains["cap_radius"][:, None] * np.cos(turn) + sign * grains["half_length"][:, None]
    y = grains["cap_radius"][:, None] * np.sin(turn)
    z = (x + 1j * y) * np.exp(1j * grains["angle"])[:, None]
    return np.stack([z.real, z.imag], axis=-1) + grains["position"][:, None]


# --- YADE's scene -------------------------------------------------------------------------------------------------------


def _about_z(ori):
    return 2 * math.atan2(ori[2], ori[3])


def _corners(shape, state):
    """Corners of a box, seen along z."""
    ex, ey, _ = shape.extents
    turn = np.exp(1j * _about_z(state.ori))
    z = turn * np.array([ex + 1j * ey, -ex + 1j * ey, -ex - 1j * ey, ex - 1j * ey])
    return np.column_stack([z.real, z.imag]) + np.array(state.pos)[:2]


def _cut(shape, state, z):
    """Ends of the line in which a facet cuts the plane at z, None where it does not or lies in it."""
    corners = np.array([state.pos + state.ori * v for v in shape.vertices])
    ends = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0)):
        above, below = one[2] - z, two[2] - z
        if above != below and above * below <= 0:
            t = above / (above - below)
            ends.append(((1 - t) * one + t * two)[:2])
    one, two = max(((a, b) for a in ends for b in ends), key=lambda pair: np.linalg.norm(pair[1] - pair[0]), default=(None, None))
    return None if one is None or np.array_equal(one, two) else np.array([one, two])


def _read_scene(O):
    from yade.wrapper import Box, Facet, Rcr, Sphere, Wall

    prescribed = {"x", "y", "Z"}.issubset
    blocked = {}  # of clumps
    grains, walls, outlines, facets = [], [], [], []
    z = 0.0  # of the grains' plane
    for body in O.bodies:
        shape, state = body.shape, body.state
        if isinstance(shape, (Rcr, Sphere)):
            half, cap = (shape.halfLength, shape.capRadius) if isinstance(shape, Rcr) else (0.0, shape.radius)
            clump = body.clumpId
            if clump >= 0:
                fixed = blocked.get(clump)
                if fixed is None:
                    fixed = blocked[clump] = prescribed(O.bodies[clump].state.blockedDOFs)
            else:
                clump, fixed = -1, prescribed(state.blockedDOFs)
            pos, vel = state.pos, state.vel
            z = pos[2]
            grains.append((body.id, clump, fixed, (pos[0], pos[1]), _about_z(state.ori), half, cap, state.mass,
                           (vel[0], vel[1], state.angVel[2]), tuple(shape.color)))  # fmt: skip
        elif isinstance(shape, Wall):
            if shape.axis < 2:
                walls.append((body.id, shape.axis, state.pos[shape.axis]))
        elif isinstance(shape, Box):
            outlines.append((body.id, "box", _corners(shape, state)))
        elif isinstance(shape, Facet):
            facets.append((body.id, shape, state))
    cuts = [(id_, "facet", _cut(shape, state, z)) for id_, shape, state in facets]
    outlines += [cut for cut in cuts if cut[2] is not None]
    cell = np.array(O.cell.hSize)[:2, :2] if O.periodic else None
    frame = Frame(_columns(_GRAINS, grains), {}, _columns(_WALLS, walls), outlines, cell, O.time)
    frame.contacts = _contacts(O, frame)
    return frame


def _contacts(O, frame):
    from yade.wrapper import FrictPhys, GenericSpheresContact, NormPhys, NormShearPhys, RcrGeom

    rows = []
    cell = frame.cell
    for i in O.interactions:
        if not i.isReal:
            continue
        geom, phys = i.geom, i.phys
        if not isinstance(geom, GenericSpheresContact) or not isinstance(phys, NormPhys):
            continue
        ours = isinstance(geom, RcrGeom)
        force = phys.normalForce + phys.shearForce if isinstance(phys, NormShearPhys) else phys.normalForce
        normal, position = geom.normal, geom.contactPoint
        points = geom.points if ours else 1
        if points == 0:
            continue
        if points == 2:
            one, two = phys.force1[0], phys.force2[0]
            if one + two > 0:
                position = (one * geom.position1 + two * geom.position2) / (one + two)
        shift = (0.0, 0.0) if cell is None else tuple(cell @ np.array(i.cellDist, float)[:2])
        rows.append((i.id1, i.id2, geom.type if ours else CAP_CAP, points, (position[0], position[1]), (normal[0], normal[1]),
                     (force[0], force[1]), phys.tangensOfFrictionAngle if isinstance(phys, FrictPhys) else math.nan, shift))  # fmt: skip
    columns = _columns(_CONTACTS, rows)
    shift = columns.pop("shift")
    at = {body: frame.rows(columns[body]) for body in ("body1", "body2")}
    before = np.append(frame.grains["position"] - O.dt * frame.grains["velocity"][:, :2], [[math.nan] * 2], axis=0)  # row −1: no grain
    columns["arm1"] = np.nan_to_num(columns["position"] - before[at["body1"]])
    columns["arm2"] = np.nan_to_num(columns["position"] - before[at["body2"]] - shift)
    columns["type"] = np.where((at["body1"] < 0) | (at["body2"] < 0), WALL, columns["type"])
    return columns
