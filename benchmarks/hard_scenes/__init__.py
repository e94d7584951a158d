"""Scenes on which contact solvers are known to fail.

A scene is a module of this package, or one of `driven.SCENES`. It has

    TITLE, PREDICATE, BOUND, REASON     what must hold: measured ≤ BOUND
    build(law, dt)                      makes the scene, returns what measure needs
    measure(built, clock)               advances the scene, returns the measured number
    RIGID_ONLY                          True if the predicate is meaningless for springs

`law` is `ContactDynamics()` or `Smooth()`. In every scene `Clock` also checks that contacts give no
energy and that no grain tunnels.
"""

import dataclasses
import importlib
import math
import pkgutil
import time

from . import driven
from .stage import COARSE, DT, Clock, ContactDynamics, Smooth

__all__ = ["COARSE", "DT", "TIGHT", "ContactDynamics", "Result", "Smooth", "names", "run", "scene",
           "title"]  # fmt: skip

TUNNEL = 1.0  # overlap over the smaller cap radius at which a contact reaches a centre line
TIGHT = ContactDynamics(dict(tolerance=1e-10, kinematicTolerance=1e-5))  # without solver errors
BLOW_UP = 0.05  # energy gain over the scale; time stepping gives some per cent at 10 dt


def names():
    """Names of all scenes, in order."""
    modules = [name for _, name, _ in pkgutil.iter_modules(__path__) if name[1:3].isdigit()]
    return sorted([*modules, *driven.SCENES])


def scene(name):
    """The scene of this name."""
    return driven.SCENES.get(name) or importlib.import_module(f"{__name__}.{name}")


def title(name):
    """Number and title of a scene."""
    return f"{name[:3].upper().replace('S0', 'S')} {scene(name).TITLE}"


@dataclasses.dataclass(frozen=True)
class Result:
    """One run of a scene."""

    measured: float  # value of the predicate
    gain: float  # largest energy gain over the scale of the scene [-]
    overlap: float  # largest overlap over the smaller cap radius [-]
    steps: int
    seconds: float  # processor time
    holds: bool  # measured ≤ BOUND
    stable: bool  # neither an energy gain nor tunnelling


def run(name, law=ContactDynamics(), dt=DT, **shortened):
    """Build a scene, advance it and judge it.

    Parameters
    ----------
    name : str
        One of `names`.
    law : ContactDynamics or Smooth
    dt : float
        Time step [s].
    **shortened
        Passed to ``measure``: ``seconds`` of long scenes.

    Returns
    -------
    Result
    """
    module = scene(name)
    built = module.build(law, dt)
    clock, start = Clock(), time.process_time()
    measured = float(module.measure(built, clock, **shortened))
    return Result(
        measured=measured, gain=clock.gain / clock.scale, overlap=clock.overlap, steps=clock.steps,
        seconds=time.process_time() - start, holds=measured <= module.BOUND,
        stable=math.isfinite(clock.gain) and clock.gain <= BLOW_UP * clock.scale
        and clock.overlap < TUNNEL)
