"""Reads YADE's present scene into the arrays of a `Frame`."""

import math
import threading

import numpy as np
from yade.wrapper import (
    Box, ContactDynamics, Facet, FrictPhys, GenericSpheresContact, NormPhys, NormShearPhys, Omega,
    Rcr, RcrGeom, Sphere, Wall,
)  # fmt: skip

from rcr import _plugin
from rcr._data.network_columns import CAP_CAP, CAP_SIDE, SIDE_SIDE, rows as rows_of
from rcr.geometry import areas

_GRAINS = dict(
    id=int, clump=int, fixed=bool, position=(float, 2), angle=float, half_length=float,
    cap_radius=float, mass=float, velocity=(float, 3), color=(float, 3),
)  # fmt: skip
_CONTACTS = dict(
    body1=int, body2=int, type=int, points=int, position=(float, 2), normal=(float, 2),
    force=(float, 2), friction=float, point_moments=(float, (2, 2)), shift=(float, 2),
)  # fmt: skip
_WALLS = dict(id=int, axis=int, position=float)


def read():
    """Return the attributes of the scene's `Frame` as a dict.

    A RuntimeError refuses to read within a step, which would mix two states.
    """
    O = Omega()
    # Python did not start the thread of a run
    if O.running and not isinstance(threading.current_thread(), threading._DummyThread):
        raise RuntimeError("the scene changes while it is read, because a run is under way; "
                           "pause the run (O.pause()), or call this from a PyRunner")
    grains, centers, z = _grains(O)
    walls, outlines = _obstacles(O, z)
    solvers = (e for e in O.engines if isinstance(e, ContactDynamics))
    change = _plugin.change_since_end() or "".join(e._change_since_step() for e in solvers)
    frame = dict(grains=grains, centers=centers, walls=walls, outlines=outlines, time=O.time,
                 change=change, run=O.tags["id"])
    cell = None
    if O.periodic:
        cell = np.array(O.cell.hSize)[:2, :2]
        frame |= dict(cell=cell, cell_velocity=np.array(O.cell.velGrad)[:2, :2] @ cell)
    return frame | dict(contacts=_contacts(O, grains["id"], centers, cell))


def _columns(kinds, rows):
    """Return rows of values as {name: array}."""
    formats = [kind if isinstance(kind, tuple) else (kind,) for kind in kinds.values()]
    table = np.array(rows, dtype=[(name, *format) for name, format in zip(kinds, formats)])
    return {name: np.ascontiguousarray(table[name]) for name in kinds}


def _grains(O):
    """Return the grains, their centres of mass at the time of the forces, and their z."""
    prescribed = {"x", "y", "Z"}.issubset
    rows, centers, z = [], [], 0.0
    for body in O.bodies:
        shape, state = body.shape, body.state
        if not isinstance(shape, (Rcr, Sphere)):
            continue
        whole = O.bodies[body.clumpId].state if body.clumpId >= 0 else state
        center, (x, y, z), velocity = whole.pos - O.dt * whole.vel, state.pos, state.vel
        centers.append((center[0], center[1]))
        rows.append((body.id, max(body.clumpId, -1), prescribed(whole.blockedDOFs), (x, y),
                     angle(state.ori), *lengths(shape), whole.mass,
                     (velocity[0], velocity[1], state.angVel[2]), tuple(shape.color)))
    grains = _columns(_GRAINS, rows)
    # members of a clump, which have its mass here, share it by area
    member = grains["clump"] >= 0
    area, clump = areas(grains)[member], grains["clump"][member]
    grains["mass"][member] *= area / np.bincount(clump, area)[clump]
    return grains, np.array(centers).reshape(-1, 2), z


def _obstacles(O, z):
    """Return the walls, and the outlines of boxes and facets in the plane at z."""
    walls, boxes, facets = [], [], []
    for body in O.bodies:
        shape, state = body.shape, body.state
        if isinstance(shape, Wall) and shape.axis < 2:
            walls.append((body.id, shape.axis, state.pos[shape.axis]))
        elif isinstance(shape, Box):
            boxes.append((body.id, "box", _corners(shape, state)))
        elif isinstance(shape, Facet):
            ends = _section(shape, state, z)
            if ends is not None:
                facets.append((body.id, "facet", ends))
    return _columns(_WALLS, walls), boxes + facets


def angle(ori):
    """Return the rotation about z [rad]."""
    return 2 * math.atan2(ori[2], ori[3])


def lengths(shape):
    """Return half length and cap radius of an Rcr or a Sphere [m]."""
    if isinstance(shape, Rcr):
        return shape.halfLength, shape.capRadius
    return 0.0, shape.radius


def _corners(shape, state):
    """Return the corners of a box in the plane, (4, 2) [m]."""
    ex, ey, _ = shape.extents
    turn = np.exp(1j * angle(state.ori))
    z = turn * np.array([ex + 1j * ey, -ex + 1j * ey, -ex - 1j * ey, ex - 1j * ey])
    return np.column_stack([z.real, z.imag]) + np.array(state.pos)[:2]


def _section(shape, state, z):
    """Return the ends of a facet's section at z, (2, 2) [m]; None without a section."""
    corners = np.array([state.pos + state.ori * v for v in shape.vertices])
    ends = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0)):
        above, below = one[2] - z, two[2] - z
        if above != below and above * below <= 0:
            t = above / (above - below)
            ends.append(((1 - t) * one + t * two)[:2])
    pairs = ((a, b) for a in ends for b in ends)
    length = lambda pair: np.linalg.norm(pair[1] - pair[0])
    one, two = max(pairs, key=length, default=(None, None))
    return None if one is None or np.array_equal(one, two) else np.array([one, two])


def _contacts(O, ids, centers, cell):
    """Return the contacts between bodies of rcr and of YADE's spheres, under any law."""
    rows = []
    for i in O.interactions:
        supported = isinstance(i.geom, GenericSpheresContact) and isinstance(i.phys, NormPhys)
        if i.isReal and supported:
            row = _contact(i)
            if row is not None:
                shift = (0.0, 0.0) if cell is None else cell @ np.array(i.cellDist, float)[:2]
                rows.append((*row, tuple(shift)))
    columns = _columns(_CONTACTS, rows)
    shift = columns.pop("shift")
    at1, at2 = (rows_of(ids, columns[body]) for body in ("body1", "body2"))
    centers = np.append(centers, [[math.nan] * 2], axis=0)  # the last row is for obstacles
    columns["arm1"] = np.nan_to_num(columns["position"] - centers[at1])
    columns["arm2"] = np.nan_to_num(columns["position"] - centers[at2] - shift)
    return columns


def _contact(i):
    """Return the columns of one contact, None without contact points.

    Of two points, one without a force does not count, since detection reaches further for faster
    grains. Sides that press at one end alone are a cap on a side.
    """
    geom, phys = i.geom, i.phys
    ours = isinstance(geom, RcrGeom)
    force = phys.normalForce
    if isinstance(phys, NormShearPhys):
        force = force + phys.shearForce
    normal, position = geom.normal, geom.contactPoint
    kind, points = (geom.type, geom.points) if ours else (CAP_CAP, 1)
    moments = ((0.0, 0.0), (0.0, 0.0))
    if points == 0:
        return None
    if points == 2:
        one, two = phys.force1[0], phys.force2[0]
        if one + two > 0:
            position = (one * geom.position1 + two * geom.position2) / (one + two)
        if one <= 0 or two <= 0:
            kind, points = (CAP_SIDE if kind == SIDE_SIDE else kind), 1
        else:
            moments = _point_moments(geom, phys, position)
    vectors = tuple((vector[0], vector[1]) for vector in (position, normal, force))
    friction = phys.tangensOfFrictionAngle if isinstance(phys, FrictPhys) else math.nan
    return i.id1, i.id2, kind, points, *vectors, friction, moments


def _point_moments(geom, phys, position):
    """Return Σ f ⊗ (x − position) over the two points x of a contact, (2, 2) [N]."""
    xx = xy = yx = yy = 0.0
    for (normal, tangential), n, x in ((phys.force1, geom.normal1, geom.position1),
                                       (phys.force2, geom.normal2, geom.position2)):
        fx, fy = normal * n[0] - tangential * n[1], normal * n[1] + tangential * n[0]
        dx, dy = x[0] - position[0], x[1] - position[1]
        xx, xy, yx, yy = xx + fx * dx, xy + fx * dy, yx + fy * dx, yy + fy * dy
    return (xx, xy), (yx, yy)
