"""Scenes on which contact solvers are known to fail, one a file, each with one predicate, its bound and the reason of the bound.

A module of this package has

    TITLE, PREDICATE, BOUND, REASON     what must hold: measured ≤ BOUND
    build(law, dt)                      makes the scene, returns what measure needs
    measure(built, clock)               lets time pass, returns the measured number
    RIGID_ONLY                          True where the question makes no sense for springs

`law` is `ContactDynamics()` or `Smooth()`. Besides its own predicate every scene must keep what `Clock` watches: no energy from
contacts, no tunnelling.
"""

import dataclasses
import importlib
import math
import pkgutil
import time

from .stage import COARSE, DT, Clock, ContactDynamics, Smooth

__all__ = ["COARSE", "DT", "TIGHT", "ContactDynamics", "Result", "Smooth", "names", "run", "scene"]

TUNNEL = 1.0  # overlap over the smaller cap radius at which a centre line is reached
TIGHT = ContactDynamics(dict(tolerance=1e-10, kinematicTolerance=1e-5))  # what the law itself does; else the engine's defaults
BLOW_UP = 0.05  # energy out of nothing, over the scale of the scene: the time stepping itself errs by some per cent at 10 dt


def names():
    """Names of all scenes, in order."""
    return sorted(name for _, name, _ in pkgutil.iter_modules(__path__) if name.startswith("s") and name[1:3].isdigit())


def scene(name):
    """The module of a scene."""
    return importlib.import_module(f"{__name__}.{name}")


@dataclasses.dataclass(frozen=True)
class Result:
    """One run of a scene."""

    measured: float  # what its predicate is about
    gain: float  # largest rise of the energy, over the scale of the scene [-]
    overlap: float  # largest, over the smaller cap radius [-]
    steps: int
    seconds: float  # of processor time
    holds: bool  # measured ≤ BOUND
    stable: bool  # no energy out of nothing and no tunnelling


def run(name, law=ContactDynamics(), dt=DT, **shortened):
    """Build the scene, let its time pass, and judge.

    Parameters
    ----------
    name : str
        One of `names`.
    law : ContactDynamics or Smooth
    dt : float
        Time step [s].
    **shortened
        Handed to ``measure``: ``seconds`` of the scenes that take long.

    Returns
    -------
    Result
    """
    module = scene(name)
    built = module.build(law, dt)
    clock, start = Clock(), time.process_time()
    measured = float(module.measure(built, clock, **shortened))
    return Result(
        measured=measured,
        gain=clock.gain / clock.scale,
        overlap=clock.overlap,
        steps=clock.steps,
        seconds=time.process_time() - start,
        holds=measured <= module.BOUND,
        stable=math.isfinite(clock.gain) and clock.gain <= BLOW_UP * clock.scale and clock.overlap < TUNNEL,
    )
