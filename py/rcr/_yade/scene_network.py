"""Contact network of the present scene."""

from collections.abc import Sequence

import numpy as np
from yade.wrapper import Omega

from rcr._data import checks
from rcr.frame import Frame
from rcr.network import BOTTOM, LEFT, OBSTACLE, OTHER, RIGHT, TOP, Network

O = Omega()


def contact_network(walls=None, volume=None, **attributes):
    """Return the Network of the last step, under any law: one row per pair that bears a force.

    Grains are the free and clumped bodies of the shape `Rcr`, `Sphere` or `RoundedPolygon`.
    Obstacles are walls, boxes, facets and grains with prescribed motion. An obstacle is always body
    2 and has a negative id; contacts between obstacles are left out. Positions, branch vectors and
    normals belong to the time of the forces, before the step moved the bodies. Contacts in tension
    are included.

    A ValueError says that no grain is free, or that an argument is invalid. It also says that O.dt,
    a velocity or a place has changed since the last step.

    Parameters
    ----------
    walls : (int, int, int, int), optional
        Ids of the left, bottom, right and top wall of a box. The network has the ids −1, −2, −3,
        −4 for them, and −5 − k for any other obstacle #k.
    volume : float, optional
        Area of the region over which the stress is averaged [m²]; by default that of the periodic
        cell or of the box of four walls. Without it `Network.stress` raises an error; ratios of
        stresses, fabric and forces do not need it.
    **attributes
        Stored with the network: ``strain``, ``eta``, ``friction``, ``seed``. ``time``, ``dt``,
        ``cell``, ``cell_velocity`` and ``stress`` come from the scene.
    """
    if own := {"time", "dt", "cell", "cell_velocity", "stress"} & attributes.keys():
        given = ", ".join(sorted(own))
        raise ValueError(f"contact_network({given}=…): the scene gives it; choose another name")
    frame = Frame.of_scene()
    frame.check_unchanged()
    if frame.grains["fixed"].all():
        raise ValueError("the scene holds no free Rcr, Sphere or RoundedPolygon, so it has no network")
    codes = {}
    if walls is not None:
        codes, box_area = _box(walls)
        volume = box_area if volume is None else volume
    if frame.cell is not None:
        attributes |= dict(cell=frame.cell, cell_velocity=frame.cell_velocity)
        volume = abs(np.linalg.det(frame.cell)) if volume is None else volume
    if volume is not None:
        attributes["volume"] = volume
    attributes = dict(time=O.time, dt=O.dt, **attributes)
    return Network(_grains(frame), _contacts(frame, codes), attributes, frame.shapes)


def _grains(frame):
    """Return the columns of `Network.particles`: free grains at the time of the forces."""
    grains = frame.free_grains()
    del grains["color"], grains["fixed"]
    velocity = grains["velocity"]
    return grains | dict(position=grains["position"] - O.dt * velocity[:, :2],
                         angle=grains["angle"] - O.dt * velocity[:, 2])


def _contacts(frame, codes):
    """Return the columns of `Network.contacts`: with a force, fixed grains as obstacles."""
    bearing = frame.free_ends()[0] & frame.contacts["force"].any(axis=1)
    c = {name: column[bearing] for name, column in frame.contacts.items()}
    at_obstacle = c["type"] == OBSTACLE
    fixed = at_obstacle & (frame.rows(c["body2"]) >= 0)
    c["branch"][fixed] = frame.arms()[0, bearing][fixed]
    obstacles = [codes.get(int(id_), OTHER - int(id_)) for id_ in c["body2"]]
    c["body2"] = np.where(at_obstacle, obstacles, c["body2"])
    # by ids, because YADE's order changes when a scene is reloaded
    order = np.lexsort((c["body2"], c["body1"]))
    return {name: column[order] for name, column in c.items()}


def _box(walls):
    """Return the codes of four walls by id, and the area between them at the time of the forces."""
    expected = "the ids of the left, bottom, right and top Wall of a box, or None"
    if not isinstance(walls, (Sequence, np.ndarray)) or len(walls) != 4:
        raise checks.error("walls", walls, expected)
    ids = [checks.integer(f"walls[{k}]", w, expected) for k, w in enumerate(walls)]
    bodies = [O.bodies[k] if 0 <= k < len(O.bodies) else None for k in ids]
    axes = [getattr(getattr(b, "shape", None), "axis", None) for b in bodies]
    if axes != [0, 1, 0, 1]:
        raise checks.error("walls", walls, expected)
    left, bottom, right, top = (b.state.pos - O.dt * b.state.vel for b in bodies)
    if left[0] >= right[0] or bottom[1] >= top[1]:
        places = f"x = {left[0]:g}, y = {bottom[1]:g}, x = {right[0]:g}, y = {top[1]:g}"
        raise ValueError(
            f"walls = {walls!r} are at {places}; expected the order left, bottom, right, top")
    area = (right[0] - left[0]) * (top[1] - bottom[1])
    return dict(zip(ids, (LEFT, BOTTOM, RIGHT, TOP))), area
