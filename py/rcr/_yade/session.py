"""Checks of the scene before ``O.run`` and of erasures, and clean ends of runs.

pkg/dem/validation holds the rules that reject a scene. This module adds warnings about suspicious
scenes. Scenes without classes of rcr are not checked. `refuse_unknown_attributes` rejects
misspelt attributes of these classes. The end of the process removes YADE's temporary folder.
"""

import atexit
import contextlib
import difflib
import functools
import os
import shutil
import signal
import sys
import threading
import time
import warnings

import numpy as np
import yade.runtime
from yade.wrapper import InsertionSortCollider, Omega, TimeStepper

from rcr import _plugin
from rcr import scene as _scene
from rcr import script
from rcr._yade import step_summary
from rcr._yade.time_step import critical_time_step

_ended = False  # `end` was called
DEFAULT_TIME_STEP = 1e-8  # YADE's O.dt of a new scene [s]
_advised = None  # number and mass of bodies, and time step at the last advice


def guard():
    """Add the checks to methods of O, O.bodies and O.interactions of this session."""
    if hasattr(Omega.run, "__wrapped__"):  # an earlier import has added them
        return
    container = type(Omega().bodies)
    container.erase = _checked_erase(container.erase)
    for name in ("append", "insertAtId", "erase", "clear", "replace", "appendClumped", "clump",
                 "addToClump", "releaseFromClump", "deleteClumpBody", "deleteClumpMember"):
        setattr(container, name, _at_rest(f"O.bodies.{name}")(getattr(container, name)))
    contacts = type(Omega().interactions)
    contacts.clear = _at_rest("O.interactions.clear")(contacts.clear)
    contacts.eraseNonReal = _without_rcr()(contacts.eraseNonReal)
    Omega.run = _guarded(_recorded()(_raising()(_responsive(Omega.run))))
    Omega.step = _guarded(_recorded()(_raising()(Omega.step)))
    Omega.pause = _recorded()(_after_step()(Omega.pause))
    Omega.wait = _recorded()(_raising()(_after_step()(_interruptible(Omega.wait))))
    Omega.engines = Omega.engines.setter(
        _summed()(_at_rest("O.engines = …")(Omega.engines.fset)))
    _end_cleanly()
    for name in ("load", "loadTmp", "reload"):
        setattr(Omega, name, _summed()(_recorded()(getattr(Omega, name))))
    for name in ("reset", "resetThisScene", "switchScene"):
        setattr(Omega, name, _summed()(getattr(Omega, name)))


def _end_cleanly():
    """Call `end` before the end of this process, also by SIGTERM and by SIGHUP."""
    global _owner, _temporary
    _owner, _temporary = os.getpid(), os.path.dirname(Omega().tmpFilename())
    atexit.register(end)
    if threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, script.signal_handler(_end_by))


def end():
    """Pause the run, which reads objects of this process; remove YADE's temporary folder.

    A script that `yade -x` runs prints the summary of its steps.
    """
    global _ended
    if os.getpid() == _owner and not _ended:  # else a fork
        _ended = True
        Omega().pause()
        if getattr(getattr(yade.runtime, "opts", None), "exitAfter", False):
            if line := step_summary.text():
                print(f"yade-rcr: {line}", file=sys.stderr)
        shutil.rmtree(_temporary, ignore_errors=True)


def _end_by(number):
    """End the process by a signal, at once: it does not wait for the step."""
    if os.getpid() == _owner:
        shutil.rmtree(_temporary, ignore_errors=True)
        os.write(2, f"yade-rcr: ended by {signal.Signals(number).name}\n".encode())
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _guarded(method):
    """O.run or O.step that rejects an unsupported scene and warns of a suspicious one."""

    @functools.wraps(method)
    def run(omega, *arguments, **keywords):
        if error := _plugin.prepare_run():
            raise ValueError("rcr: " + error)
        _advise(omega)
        _plugin.take_error()
        step_summary.begin_run()
        return method(omega, *arguments, **keywords)

    return run


def _advise(omega):
    """Warn of a suspicious scene: at step 0, and when bodies or the time step have changed."""
    global _advised
    bodies = len(omega.bodies), _plugin.total_mass()
    present, before = (bodies, omega.dt), _advised
    _advised = present
    if omega.iter > 0 and present == before:
        return
    same_bodies = omega.iter > 0 and before and bodies == before[0]
    texts = [] if same_bodies else _plugin.advice(_scene.union_area)
    if _plugin.uses_rcr():
        texts += _time_step_advice(omega)
    for text in texts:
        warnings.warn("rcr: " + text, stacklevel=3)


def _time_step_advice(omega):
    """Return a list of warnings about O.dt."""
    if omega.iter == 0 and omega.dt == DEFAULT_TIME_STEP:
        return ["O.dt = 1e-8 s is YADE's default; set it by the accuracy you want (rigid contacts) "
                "or to 0.5 * rcr.critical_time_step() (springs)."]
    if any(isinstance(e, TimeStepper) and e.active and not e.dead for e in omega.engines):
        return []
    try:
        most = critical_time_step()
    except ValueError:  # rigid contacts, or no free grain
        return []
    if omega.dt <= most:
        return []
    return [f"O.dt = {omega.dt:.3g} s is beyond {most:.3g} s, where springs of this stiffness "
            "become unstable; set O.dt = 0.5 * rcr.critical_time_step()."]


def _responsive(run):
    """O.run that returns after its thread has begun, and notices its end and Ctrl-C within 5 ms."""

    @functools.wraps(run)
    def wrapped(omega, nSteps=-1, wait=False):
        _refuse_to_wait_for_itself(omega, wait)
        run(omega, nSteps, False)
        if not _in_run_thread():
            _plugin.await_start()
        if wait:
            wait_for_end(omega, 5e-3)

    return wrapped


def _interruptible(wait):
    """O.wait that Ctrl-C ends, with the run."""

    @functools.wraps(wait)
    def wrapped(omega):
        _refuse_to_wait_for_itself(omega)
        _await(omega, 5e-3)
        wait(omega)

    return wrapped


def _refuse_to_wait_for_itself(omega, wait=True):
    if wait and omega.running and _in_run_thread():
        raise RuntimeError("rcr: an engine waits for the end of the run, which waits for this "
                           "engine; call O.wait() or O.run(…, True) outside of the run")


def wait_for_end(omega, longest_pause, each=lambda: None):
    """Wait for the end of a run and call `each` between the checks; an exception ends the run."""
    _await(omega, longest_pause, each)
    omega.wait()


def _await(omega, longest_pause, each=lambda: None):
    pause = 1e-4
    try:
        while omega.running:
            time.sleep(pause)
            pause = min(2 * pause, longest_pause)
            each()
    except BaseException:
        omega.pause()
        raise


def _in_run_thread():
    """True in the thread of a run and its PyRunners, which Python did not start."""
    return isinstance(threading.current_thread(), threading._DummyThread)


@contextlib.contextmanager
def _after_step():
    """Wrapper of O.pause and O.wait: they return after a whole step; YADE's may return within one.

    An engine that calls it is part of a step, so it returns at once there.
    """
    yield
    if not _in_run_thread():
        _plugin.await_end()


@contextlib.contextmanager
def _recorded():
    """Wrapper that records the end of the last step, for `Frame.check_unchanged`."""
    try:
        yield
    finally:
        if not Omega().running:
            _plugin.record_end()
            step_summary.end_run()


@contextlib.contextmanager
def _summed():
    """Wrapper of what replaces the scene or its engines: adds their steps to the summary."""
    step_summary.add()
    try:
        yield
    finally:
        step_summary.skip()


@contextlib.contextmanager
def _raising():
    """Wrapper that raises errors of YADE's run thread; YADE does so only in a waiting session."""
    try:
        yield
    except Exception:
        _plugin.take_error()
        raise
    if not Omega().running and (error := _plugin.take_error()):
        raise RuntimeError(error)


@contextlib.contextmanager
def _at_rest(name):
    """Refuse a method that changes what a run loops over to a console while the scene runs."""
    if Omega().running and not _in_run_thread() and _plugin.uses_rcr():
        raise RuntimeError(f"rcr: {name} while the scene runs can end the process; call "
                           "O.pause() first, or do it in a PyRunner")
    yield


def _checked_erase(erase):
    """O.bodies.erase that rejects negative ids, which end the process, and some periodic cells.

    YADE's collider keeps bounds of the erased body. After a change of the cell, its search for the
    place of these bounds may never end.
    """

    @functools.wraps(erase)
    def wrapped(bodies, id, *arguments, **keywords):
        if id < 0:
            raise IndexError(f"rcr: O.bodies.erase({id}): expected the id of a body, ≥ 0")
        has_run = lambda e: isinstance(e, InsertionSortCollider) and e.numReinit > 0
        if Omega().periodic and _plugin.uses_rcr() and any(map(has_run, Omega().engines)):
            raise ValueError(
                f"rcr: body #{id} cannot be erased from a periodic cell whose collider has run, "
                "because it may then hang; put a new InsertionSortCollider into O.engines first")
        return erase(bodies, id, *arguments, **keywords)

    return wrapped


@contextlib.contextmanager
def _without_rcr():
    """Refuse O.interactions.eraseNonReal with classes of rcr.

    The collider lists an erased pair again only when the boxes of its bodies meet anew.
    """
    if _plugin.uses_rcr():
        raise ValueError(
            "rcr: after O.interactions.eraseNonReal() the collider would miss contacts; "
            "leave these interactions, or call O.interactions.clear()")
    yield


def refuse_unknown_attributes(classes):
    """Make an assignment to an unknown, perhaps misspelt attribute of these classes an error."""

    def set_attribute(self, name, value):
        kind = type(self)
        if kind in classes and not hasattr(kind, name):
            near = difflib.get_close_matches(name, dir(kind), 1)
            hint = f"; expected {near[0]!r}?" if near else ""
            raise AttributeError(f"{kind.__name__} has no attribute {name!r}{hint}")
        known = isinstance(getattr(kind, name, None), property)  # an attribute of YADE
        object.__setattr__(self, name, _without_numpy(value) if known else value)

    for kind in classes:
        kind.__setattr__ = set_attribute
        kind.__init__ = _converting(kind.__init__)


def _converting(init):
    """A constructor of YADE that also takes numbers of NumPy."""

    @functools.wraps(init)
    def wrapped(self, *arguments, **keywords):
        init(self, *arguments, **{k: _without_numpy(v) for k, v in keywords.items()})

    return wrapped


def _without_numpy(value):
    """Return the value with numbers and sequences of Python, which YADE's attributes take."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_without_numpy(v) for v in value]
    return value
