"""Refusals and advice before a run: ``O.run`` and ``O.step`` refuse scenes that would go wrong without a word.

The rules stand in pkg/dem/Gate.cpp; what is served but hardly meant is warned of. A scene without any class of rcr is none of its business.
"""

import functools
import threading
import time
import warnings

from yade.wrapper import Omega, TimeStepper

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


def guard():
    """Let every O.run and O.step of this session look at the scene first."""
    if not hasattr(Omega.run, "__wrapped__"):
        Omega.run = _guarded(_promptly(Omega.run))
        Omega.step = _guarded(Omega.step)
        Omega.pause = _settled(Omega.pause)
    if not hasattr(Omega.wait, "__wrapped__"):
        Omega.wait = _told(_settled(Omega.wait))
