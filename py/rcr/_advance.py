"""Steps of the present scene with a progress bar, and an end that loses nothing at Ctrl-C."""

import time

from yade.wrapper import Omega

from rcr import _checks as checks
from rcr.script import stoppable

SHOWN = 1.0  # s, after which a bar appears
PAUSE = 0.02  # s between two looks at a run and at Ctrl-C


def advance(steps, label="steps", until=None, every=None):
    """Make steps as ``O.run(steps, wait=True)`` does, with a progress bar on a terminal.

    Outside the main thread, which alone hears of Ctrl-C, it makes the steps all the same. A first Ctrl-C (or SIGTERM) ends the run after a whole step, so that a script can write what it has:
    ``if not rcr.advance(5000): print("stopped early")``. A second one raises KeyboardInterrupt. An engine ends it by ``O.pause()``.

    Parameters
    ----------
    steps : int
        At most so many.
    label : str
        What the bar is of.
    until : callable, optional
        Ends the run when it returns True; it is asked after each `every` whole steps, so that runs repeat.
    every : int, optional
        By default a hundredth of the steps.

    Returns
    -------
    bool
        False if the user stopped it; ``O.iter`` tells how far it came.

    Raises
    ------
    ValueError
        If a number is not whole and at least 1; and what ``O.run`` raises.
    RuntimeError
        If a run is under way.
    """
    from tqdm import tqdm

    if Omega().running:
        raise RuntimeError("rcr.advance: a run is under way, perhaps the one of the engine that calls it; wanted a scene at rest: O.pause() or O.wait() first")
    steps = checks.integer("steps", steps, "a number of steps, at least 1", lambda v: v >= 1)
    every = checks.integer("every", max(1, steps // 100) if every is None else every, "a number of steps, at least 1", lambda v: v >= 1)
    with stoppable() as stop, tqdm(total=steps, desc=label, unit="step", disable=None, delay=SHOWN, leave=False) as bar:
        done = 0
        while done < steps:
            count = min(steps - done, every if until else steps)
            made = _run(count, bar, stop)
            done += made
            if stop.asked or made < count or (until and done % every == 0 and until()):
                break
    return not stop.asked


def _run(count, bar, stop):
    """Make steps in one run, since the start of each costs a look at all bodies; return how many it came to, fewer where `stop` or an engine asked for its end."""
    O = Omega()
    first, shown, pause = O.iter, bar.n, 1e-4
    O.run(count)
    try:
        while O.running:
            time.sleep(pause)
            pause = min(2 * pause, PAUSE)
            bar.update(shown + O.iter - first - bar.n)
            if stop.asked:
                O.pause()
    except BaseException:
        O.pause()
        raise
    O.wait()
    bar.update(shown + O.iter - first - bar.n)
    return O.iter - first
