"""Reads YADE's present scene into the columns of a `rcr.table.Table`."""

import math
import threading

import numpy as np
from yade.wrapper import ContactDynamics, Omega, Rcr, RoundedPolygon, Sphere

from rcr import _plugin
from rcr.geometry import areas
from rcr.outlines import Outline

GRAINS = Rcr, Sphere, RoundedPolygon  # classes of shapes

# names and widths of the columns of pkg/python/scene_columns.cpp
_GRAINS = dict(id=0, clump=0, fixed=0, shape=0), dict(
    position=2, angle=0, half_length=0, cap_radius=0, mass=0, velocity=3, color=3, center=2)
_CONTACTS = dict(body1=0, body2=0, type=0, points=0), dict(
    position=2, normal=2, force=2, branch=2, friction=0, point_moments=4, adhesion=0,
    rolling_moment=0)
_OBSTACLES = dict(id=0, kind=0, axis=0), dict(position=0, rest=7)
_LENGTHS = dict(shape=0), dict(half_length=0, cap_radius=0)
_OUTLINES = dict(count=0), dict(radius=0)  # of polygons, over R: number of corners, rounding
_CORNERS = dict(outline=0), dict(corner=2)
_ENDS = dict(box=4, facet=2)  # kinds 1 and 2 of obstacles


def read():
    """Return the attributes of the scene's `Frame` as a dict.

    A RuntimeError refuses to read within a step, which would mix two states.
    """
    O = Omega()
    # Python did not start the thread of a run
    if O.running and not isinstance(threading.current_thread(), threading._DummyThread):
        raise RuntimeError("the scene changes while it is read, because a run is under way; "
                           "pause the run (O.pause()), or call this from a PyRunner")
    found = _plugin.scene_columns()
    grains, contacts, obstacles = map(_columns, (_GRAINS, _CONTACTS, _OBSTACLES), found)
    shapes = _outlines(*found[3:])
    grains["fixed"] = grains["fixed"].astype(bool)
    # members of a clump, which have its mass here, share it by area
    member = grains["clump"] >= 0
    area, clump = areas(grains, shapes)[member], grains["clump"][member]
    grains["mass"][member] *= area / np.bincount(clump, area)[clump]
    contacts["point_moments"] = contacts["point_moments"].reshape(-1, 2, 2)
    wall, outlines = obstacles["kind"] == 0, []
    for kind, (name, count) in enumerate(_ENDS.items(), 1):
        corners = np.column_stack([obstacles["position"], obstacles["rest"]]).reshape(-1, 4, 2)
        pick = obstacles["kind"] == kind
        outlines += [(int(id_), name, ends[:count])
                     for id_, ends in zip(obstacles["id"][pick], corners[pick])]
    solvers = (e for e in O.engines if isinstance(e, ContactDynamics))
    change = _plugin.change_since_end() or "".join(e._change_since_step() for e in solvers)
    frame = dict(grains=grains, contacts=contacts, shapes=shapes, outlines=outlines,
                 walls={name: obstacles[name][wall] for name in ("id", "axis", "position")},
                 time=O.time, change=change, run=O.tags["id"])
    if O.periodic:
        cell = np.array(O.cell.hSize)[:2, :2]
        frame |= dict(cell=cell, cell_velocity=np.array(O.cell.velGrad)[:2, :2] @ cell)
    return frame


def _columns(names, raw):
    """Return rows of whole numbers and of doubles as {name: array}."""
    found = {}
    for widths, kind, data in zip(names, (np.int64, float), raw):
        width = [max(1, columns) for columns in widths.values()]
        rows = np.frombuffer(data, kind).reshape(-1, sum(width))
        parts = np.split(rows, np.cumsum(width)[:-1], axis=1)
        found |= {name: (part if columns else part[:, 0]).copy()
                  for (name, columns), part in zip(widths.items(), parts)}
    return found


def angle(ori):
    """Return the rotation about z [rad]."""
    return 2 * math.atan2(ori[2], ori[3])


def lengths(shapes):
    """Return half lengths, cap radii and outlines of shapes of grains.

    The results are the columns ``half_length``, ``cap_radius`` [m] and ``shape`` of a table of
    grains, and its list of `Outline`s.
    """
    rows, *outlines = _plugin.shape_columns(list(shapes))
    return _columns(_LENGTHS, rows), _outlines(*outlines)


def _outlines(outlines, corners):
    """Return the `Outline`s of rows of outlines and corners."""
    found = _columns(_OUTLINES, outlines)
    ends = np.cumsum(found["count"])[:-1]
    parts = np.split(_columns(_CORNERS, corners)["corner"], ends) if len(found["count"]) else []
    return [Outline(*outline) for outline in zip(parts, found["radius"])]
