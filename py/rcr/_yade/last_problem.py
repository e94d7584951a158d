"""The contact problem of the last step of a ContactDynamics, and its files. Needs YADE."""

import os

import numpy as np
from yade.wrapper import ContactDynamics, Omega

from rcr import problems

O = Omega()


def last_problem(engine):
    """Return the contact problem of the last step of a ContactDynamics, with its warm start."""
    raw = engine._problem()
    column = lambda name, width, kind=np.float64: np.frombuffer(raw[name], kind).reshape(-1, width)
    inverse_mass, points = column("inverse_mass", 3), column("points", 12)
    if not len(inverse_mass):
        raise ValueError("ContactDynamics has solved no step yet; call O.step() before save()")
    return problems.BodyProblem(
        inverse_mass=inverse_mass, free_velocity=column("free_velocity", 3),
        bodies=column("bodies", 2, np.int32), normal=points[:, 0:2], arm1=points[:, 2:4],
        arm2=points[:, 4:6], bias=points[:, 6], friction=points[:, 7], impulse=column("impulse", 2),
        pull=points[:, 8], rolling_friction=points[:, 9], rolling_length=points[:, 10],
        rolling_impulse=points[:, 11])


def save_problem(engine, path):
    """Save the contact problem of the last step with its warm start: ``ContactDynamics.save``.

    `path` ends in ``.h5`` for FCLIB (W, q, µ) or ``.npz`` (with the bodies); see `rcr.problems`. A
    ValueError reports another suffix, no step since the scene was made or loaded, contacts across
    the boundary of a deforming periodic cell, or adhesion and rolling friction in FCLIB.
    """
    problems.save(path, last_problem(engine))


def save_not_finite():
    """Save the last problem, whose solution is not finite; return a sentence for the exception."""
    engine = next(e for e in O.engines if isinstance(e, ContactDynamics))
    path = os.path.abspath(f"not-finite-{O.iter}.npz")
    try:
        save_problem(engine, path)
    except (OSError, ValueError) as error:
        return f"Its problem cannot be saved: {error}."
    return f"Its problem is in {path}; rcr.solve({path!r}, warm=True) replays it."
