"""Steps of the present scene with a progress bar, and an end that loses nothing at Ctrl-C."""

import time

from yade.wrapper import Omega

from rcr import checks
from rcr.script import stoppable

SHOWN = 1.0  # s, after which a bar appears
PIECE = 0.2  # s between two looks at the clock and at Ctrl-C


def advance(steps, label="steps", until=None, every=None):
    """Make steps as ``O.run(steps, wait=True)`` does, with a progress bar on a terminal.

    A first Ctrl-C (or SIGTERM) ends the run after a whole step, so that a script can write what it has:
    ``if not rcr.advance(5000): print("stopped early")``. A second one raises KeyboardInterrupt.

    Parameters
    ----------
    steps : int
        At most so many.
    label : str
        What the bar is of.
    until : callable, optional
        Ends the run when it returns True; it is asked after each `every` steps, so that runs repeat.
    every : int, optional
        By default a hundredth of the steps.

    Returns
    -------
    bool
        False if the user stopped it.

    Raises
    ------
    ValueError
        If a number is not whole and at least 1; and what ``O.run`` raises.
    """
    from tqdm import tqdm

    steps = checks.whole("steps", steps, "a number of steps, at least 1", lambda v: v >= 1)
    every = checks.whole("every", max(1, steps // 100) if every is None else every, "a number of steps, at least 1", lambda v: v >= 1)
    O = Omega()
    piece = 1
    with stoppable() as stop, tqdm(total=steps, desc=label, unit="step", disable=None, delay=SHOWN, leave=False) as bar:
        done = 0
        while done < steps and not stop.asked:
            count = min(piece, steps - done, every - done % every if until else steps)
            began = time.perf_counter()
            O.run(count, True)
            done += count
            bar.update(count)
            took = time.perf_counter() - began
            piece = max(1, min(2 * piece, round(count * PIECE / took))) if took > 0 else 2 * piece
            if until and done % every == 0 and until():
                break
    return not stop.asked
