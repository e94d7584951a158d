"""A scene at one moment as plain arrays: grains, contacts, obstacles, cell. Pictures, files and measures are made of it. Needs NumPy.

`Frame.of` takes the present scene of YADE, a saved `rcr.Network` or its file. Everything lies in the plane z = 0 and is per unit depth.

Conventions
-----------
* A grain is a body of the shape `Rcr` or `Sphere` (a disc in the plane); a clump's members are grains with the clump's id.
* An obstacle is a `Wall`, `Box` or `Facet`. A grain whose motion is prescribed is `fixed`.
* The force of a contact acts on body 2 from body 1, the normal runs from 1 to 2, compression is positive.
* Positions of grains are the present ones. A step moves the bodies after its forces, so contacts lie, by dt times a velocity, where
  the forces belong: lever arms are those of the step that found the forces.
* A clump moves as one: lever arms of its members begin at its centre of mass, loads and stresses of its members are those of the whole.
"""

import math
import os
from dataclasses import dataclass, field

import numpy as np

from rcr import _outlines as outlines
from rcr.network import CAP_CAP, WALL, Network
from rcr._outlines import half_extents

KINDS = ("rcr", "disc", "clumped", "fixed")

_GRAINS = dict(id=int, clump=int, fixed=bool, position=(float, 2), angle=float, half_length=float, cap_radius=float, mass=float,
               velocity=(float, 3), color=(float, 3))  # fmt: skip
_CONTACTS = dict(body1=int, body2=int, type=int, points=int, position=(float, 2), normal=(float, 2), force=(float, 2), friction=float,
                 shift=(float, 2))  # fmt: skip
_WALLS = dict(id=int, axis=int, position=float)
OUTLINE = ("position", "angle", "half_length", "cap_radius")  # columns of the grains
STRIPS = 2000  # that a clump is cut into: its area is right to 1e-5


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
        from the centre of mass of the body or its clump to the position, 0 for obstacles [m].
    walls : dict of arrays
        ``id``, ``axis`` 0 or 1 of the normal, ``position`` along it [m].
    outlines : list of (id, kind, (k, 2) array)
        Corners of boxes ("box") and ends of facets ("facet") [m].
    cell : (2, 2) array or None
        Edges of the periodic cell as columns [m].
    cell_velocity : (2, 2) array or None
        Their velocities [m/s]: by them an image moves faster than its grain.
    time : float
        [s], NaN where it is not known.
    centers : (N, 2) array
        Centre of mass of each grain or its clump when the forces acted [m].
    """

    grains: dict
    contacts: dict
    walls: dict = field(default_factory=lambda: _columns(_WALLS, []))
    outlines: list = field(default_factory=list)
    cell: np.ndarray = None
    time: float = math.nan
    cell_velocity: np.ndarray = None
    centers: np.ndarray = None

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
        grains |= dict(cap_radius=radius, clump=p["clump"], fixed=np.zeros(rows, bool), color=color)
        contacts = {name: c[name] for name in ("body1", "body2", "type", "points", "position", "normal", "force", "friction")}
        known = network.attributes
        frame = cls(grains, contacts, cell=known.get("cell"), time=float(known.get("time", math.nan)),
                    cell_velocity=known.get("cell_velocity"), centers=p["center"])  # fmt: skip
        contacts["arm1"] = c["position"] - p["center"][frame.rows(c["body1"])]
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
        """Area that each grain adds to the solid, (N,) [m²]: members of a clump share the area of their union by their own."""
        own, clump = outlines.areas(self.grains), self.grains["clump"]
        for number in np.unique(clump[clump >= 0]):
            members = clump == number
            union, _, _ = outlines.union({name: self.grains[name][members] for name in OUTLINE}, STRIPS)
            own[members] *= union / own[members].sum()
        return own

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
        """Sum of a number of the contacts over the contacts of each grain; members of a clump have the sum of all, (N,)."""
        total = np.zeros(len(self.grains["id"]))
        for body in ("body1", "body2"):
            at = self.rows(self.contacts[body])
            np.add.at(total, at[at >= 0], values[at >= 0])
        return self._of_clumps(total)

    def _of_clumps(self, values):
        """Numbers (N, …) of the grains, with the sum over its members for each member of a clump."""
        clump = self.grains["clump"]
        member = clump >= 0
        if not member.any():
            return values
        _, group = np.unique(clump[member], return_inverse=True)
        sums = np.zeros((group.max() + 1, *values.shape[1:]))
        np.add.at(sums, group, values[member])
        values = values.copy()
        values[member] = sums[group]
        return values

    def stress_tensors(self):
        """Mean stress in each grain by the moments of its contact forces (Love, Weber), compression positive.

        σ = (1/A) Σ f ⊗ r summed over its contacts, f being the force that the grain exerts and r the arm from its centre. Weight and
        inertia are left out: the stress is that of the contacts. Members of a clump have the stress of the whole. Times `areas` over the
        volume, the sum is `Network.stress`.

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
        return self._of_clumps(sums) / self._of_clumps(self.areas())[:, None, None]

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
    clumps = {}  # id: whether its motion is prescribed, its centre and velocity
    centers = []  # of mass, where they were when the forces acted
    grains, walls, outlines, facets = [], [], [], []
    z = 0.0  # of the grains' plane
    for body in O.bodies:
        shape, state = body.shape, body.state
        if isinstance(shape, (Rcr, Sphere)):
            half, cap = (shape.halfLength, shape.capRadius) if isinstance(shape, Rcr) else (0.0, shape.radius)
            clump = body.clumpId
            pos, vel = state.pos, state.vel
            if clump >= 0:
                if clump not in clumps:
                    whole = O.bodies[clump].state
                    clumps[clump] = prescribed(whole.blockedDOFs), whole.pos - O.dt * whole.vel
                fixed, center = clumps[clump]
            else:
                clump, fixed, center = -1, prescribed(state.blockedDOFs), pos - O.dt * vel
            centers.append((center[0], center[1]))
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
    frame = Frame(_columns(_GRAINS, grains), {}, _columns(_WALLS, walls), outlines, time=O.time, centers=np.array(centers).reshape(-1, 2))
    if O.periodic:
        frame.cell = np.array(O.cell.hSize)[:2, :2]
        frame.cell_velocity = np.array(O.cell.velGrad)[:2, :2] @ frame.cell
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
    centers = np.append(frame.centers, [[math.nan] * 2], axis=0)  # row −1: no grain
    columns["arm1"] = np.nan_to_num(columns["position"] - centers[at["body1"]])
    columns["arm2"] = np.nan_to_num(columns["position"] - centers[at["body2"]] - shift)
    columns["type"] = np.where((at["body1"] < 0) | (at["body2"] < 0), WALL, columns["type"])
    return columns
