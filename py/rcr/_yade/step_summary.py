"""Summary of the steps of this session: `rcr.info()` and a line at the end of a script.

Counts of ContactDynamics are added when its scene is replaced, since a script may run many scenes.
"""

import time

from yade.wrapper import Omega

from rcr import _plugin

LEAST_ERROR = 1e-4  # below it, a step misses for another reason, such as an overlap
_counts = dict(steps=0, missed=0, yielded=0, deepest=0.0, largest_error=0.0)
_before = dict(_counts)  # of the present scene, at the last `add`
_clock = dict(begun=None, first=0, seconds=0.0, steps=0)


def begin_run():
    """Start the clock of a run, unless it runs."""
    if _clock["begun"] is None:
        _clock.update(begun=time.perf_counter(), first=Omega().iter)


def end_run():
    """Stop the clock of a run."""
    if _clock["begun"] is not None and not Omega().running:
        _clock["seconds"] += time.perf_counter() - _clock["begun"]
        _clock["steps"] += max(0, Omega().iter - _clock["first"])
        _clock["begun"] = None


def add():
    """Add the steps of the present scene since the last call, before the scene is replaced."""
    now = _of_scene()
    for name in ("steps", "missed", "yielded"):
        _counts[name] += max(0, now[name] - _before[name])
    for name in ("deepest", "largest_error"):
        if now["steps"] > _before["steps"]:
            _counts[name] = max(_counts[name], now[name])
    _before.update(now)


def skip():
    """Leave out the steps that the present scene has already, after it has been replaced."""
    _before.update(_of_scene())


def _of_scene():
    now = dict.fromkeys(_counts, 0)
    for engine in Omega().engines:
        if hasattr(engine, "_step_counts"):
            now = engine._step_counts()
    return now


def text():
    """Return the summary in one line, '' without a step of a scene with classes of rcr."""
    end_run()
    add()
    steps = _clock["steps"]
    if not steps or not (_counts["steps"] or _plugin.uses_rcr()):
        return ""
    line = f"{steps} steps, {_duration(_clock['seconds'] / steps)} a step"
    if not _counts["steps"]:
        return line  # springs
    return f"{line}; {_missed()}; deepest overlap {_counts['deepest']:.2g} (R₁ + R₂)"


def _duration(seconds):
    return f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def _missed():
    """Return the number of missed steps and their largest error, as text."""
    missed, steps, yielded = (_counts[name] for name in ("missed", "steps", "yielded"))
    if not missed:
        return "all converged"
    share = f"{missed} of {steps} did not converge ({100 * missed / steps:.3g} %)"
    without = f", {yielded} of them without a solution" if yielded else ""
    return f"{share}{without}, error {largest_error()}"


def largest_error():
    """Return the bound of the estimated errors of the missed steps as text; they count up to 1."""
    error = _counts["largest_error"]
    if error < LEAST_ERROR:
        return f"below {100 * LEAST_ERROR:g} %"
    return f"up to {100 * error:.2g} %" if error < 1 else "up to 100 % or more"
