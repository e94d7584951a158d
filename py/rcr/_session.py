"""Refusals and advice before a run: ``O.run``, ``O.step`` and ``O.bodies.erase`` refuse what would go wrong without a word.

The rules stand in pkg/dem/Gate.cpp; what is served but hardly meant is warned of. A scene without any class of rcr is none of its business.
"""

import functools
import threading
import time
import warnings

from yade.wrapper import InsertionSortCollider, Omega, TimeStepper

from rcr import _plugin, scene

_DEFAULT_TIME_STEP = 1e-8  # YADE's, of a scene that nobody has set one for
_advised = None  # of the scene when advice was given last: number of bodies, time step


def _time_step(omega):
    """Advice on O.dt, a list of texts."""
    if omega.iter == 0 and omega.dt == _DEFAULT_TIME_STEP:
        return ["O.dt = 1e-8 s is YADE's default; set it by the accuracy you want (rigid contacts) or to 0.5 * rcr.critical_time_step() (springs)."]
    if any(isinstance(engine, TimeStepper) and engine.active and not engine.dead for engine in omega.engines):
        return []
    try:
        most = scene.critical_time_step()
    except ValueError:  # rigid contacts, or nothing that springs could set in motion
        return []
    if omega.dt <= most:
        return []
    return [f"O.dt = {omega.dt:.3g} s is beyond {most:.3g} s, where springs of this stiffness become unstable; set O.dt = 0.5 * rcr.critical_time_step()."]


def _advise(omega):
    global _advised
    known, before = (len(omega.bodies), omega.dt), _advised
    _advised = known
    if omega.iter > 0 and known == before:
        return
    told = [] if omega.iter > 0 and before and known[0] == before[0] else _plugin.advice()
    if _plugin.serves():
        told += _time_step(omega)
    for text in told:
        warnings.warn("rcr: " + text, stacklevel=4)


def _guarded(method):
    @functools.wraps(method)
    def run(omega, *arguments, **keywords):
        told = _plugin.refusal()
        if told:
            raise ValueError("rcr: " + told)
        _advise(omega)
        _plugin.take_error()
        return _told(method)(omega, *arguments, **keywords)

    return run


def _promptly(run):
    """O.run whose wait ends with the run, or with Ctrl-C, which ends the run; YADE's looks every 40 ms, longer than many a run takes."""

    @functools.wraps(run)
    def prompt(omega, nSteps=-1, wait=False):
        run(omega, nSteps, False)
        if not wait:
            return
        pause = 1e-4
        try:
            while omega.running:
                time.sleep(pause)
                pause = min(2 * pause, 5e-3)
        except KeyboardInterrupt:
            omega.pause()
            raise
        omega.wait()

    return prompt


def _settled(method):
    """O.pause or O.wait that returns with the scene in order: YADE's return in the midst of a step, of which an engine that calls them is a part itself."""

    @functools.wraps(method)
    def settled(omega):
        method(omega)
        if not isinstance(threading.current_thread(), threading._DummyThread):  # YADE's own, in which engines run
            _plugin.await_end()

    return settled


def _told(method):
    """YADE tells a session of an exception of its run thread only where the session is waiting for it already."""

    @functools.wraps(method)
    def run(omega, *arguments, **keywords):
        try:
            result = method(omega, *arguments, **keywords)
        except Exception:
            _plugin.take_error()
            raise
        error = "" if omega.running else _plugin.take_error()
        if error:
            raise RuntimeError(error)
        return result

    return run


def _apart_from_bounds(erase):
    """O.bodies.erase that refuses where YADE's collider may not end: it keeps bounds of the body, and a cell that has changed can leave them out of reach."""

    @functools.wraps(erase)
    def apart(bodies, id, *arguments, **keywords):
        omega = Omega()
        if omega.periodic and _plugin.serves() and any(isinstance(engine, InsertionSortCollider) and engine.numReinit > 0 for engine in omega.engines):
            raise ValueError(
                f"rcr: body #{id} cannot be erased from a periodic cell whose collider has run, for that may then never end; put a new InsertionSortCollider into O.engines first"
            )
        return erase(bodies, id, *arguments, **keywords)

    return apart


def guard():
    """Let every O.run and O.step of this session look at the scene first, and O.bodies.erase at the cell."""
    container = type(Omega().bodies)
    if not hasattr(container.erase, "__wrapped__"):
        container.erase = _apart_from_bounds(container.erase)
    if not hasattr(Omega.run, "__wrapped__"):
        Omega.run = _guarded(_promptly(Omega.run))
        Omega.step = _guarded(Omega.step)
        Omega.pause = _settled(Omega.pause)
    if not hasattr(Omega.wait, "__wrapped__"):
        Omega.wait = _told(_settled(Omega.wait))
