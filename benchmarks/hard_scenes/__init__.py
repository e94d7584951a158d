"""Scenes on which contact solvers are known to fail.

`stage.hard_scene` marks the function that runs a scene. In every scene `Clock` also checks that
contacts give no energy and that no grain tunnels.
"""

import dataclasses
import math
import time
from functools import partial

from . import contacts, driven, impacts, polygons, rest  # noqa: F401: they fill SCENES
from .stage import COARSE, DT, SCENES, Clock, ContactDynamics, D, Smooth, build, farthest

__all__ = ["COARSE", "DT", "SCENES", "TIGHT", "ContactDynamics", "Result", "Smooth", "run", "title"]

TUNNEL = 1.0  # overlap over the smaller inscribed radius at which a contact reaches a centre line
TIGHT = ContactDynamics(dict(tolerance=1e-10, accuracy=1e-5))  # without solver errors
BLOW_UP = 0.05  # energy gain over the scale; time stepping gives some per cent at 10 dt


def title(name):
    return f"{name[:3].upper().replace('S0', 'S')} {SCENES[name].TITLE}"


@dataclasses.dataclass(frozen=True)
class Result:
    """One run of a scene."""

    measured: float  # value of the predicate
    gain: float  # largest energy gain over the scale of the scene [-]
    overlap: float  # largest overlap over the smaller inscribed radius [-]
    steps: int
    seconds: float  # processor time
    holds: bool  # measured ≤ BOUND
    stable: bool  # neither an energy gain nor tunnelling


def run(name, law=ContactDynamics(), dt=DT, **shortened):
    """Result of a scene; long scenes take a number of `seconds`."""
    clock = Clock()
    measured = SCENES[name].run(partial(build, law, dt), clock, **shortened)
    if isinstance(measured, list):
        measured = farthest(measured, clock, 10.0) / D
    return Result(
        measured=float(measured), gain=clock.gain / clock.scale, overlap=clock.overlap,
        steps=clock.steps, seconds=time.process_time() - clock.began,
        holds=measured <= SCENES[name].BOUND,
        stable=math.isfinite(clock.gain) and clock.gain <= BLOW_UP * clock.scale
        and clock.overlap < TUNNEL)
