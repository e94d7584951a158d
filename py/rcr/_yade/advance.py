"""Steps of the present scene with a progress bar and a clean stop at Ctrl-C."""

from yade.wrapper import Omega

from rcr._data import checks
from rcr._yade.session import wait_for_end
from rcr.script import stoppable

BAR_DELAY = 1.0  # time before a bar appears [s]
LONGEST_PAUSE = 0.02  # longest time between two checks of a run and of Ctrl-C [s]


def advance(steps, label="steps", until=None, every=None):
    """Make steps as ``O.run(steps, wait=True)`` does, with a progress bar on a terminal.

    A first Ctrl-C, SIGTERM or SIGHUP ends the run after a whole step; the function then returns
    False, so that a script can save its results: ``if not rcr.advance(500): print("early")``. A
    second one raises KeyboardInterrupt. Signals reach the main thread alone. An engine can end the
    run by ``O.pause()``. A RuntimeError reports an active run, a ValueError a number that is not
    whole or below 1; all errors of ``O.run`` can occur.

    Parameters
    ----------
    steps : int
        Largest number of steps.
    label : str
        Text of the bar.
    until : callable, optional
        Ends the run when it returns True. It is called after each `every` steps, so that runs
        are reproducible.
    every : int, optional
        Steps between calls of `until`; by default a hundredth of the steps.
    """
    from tqdm import tqdm

    if Omega().running:
        raise RuntimeError("rcr.advance: a run is active, perhaps that of the calling engine; end "
                           "it first by O.pause() or O.wait()")
    expected = "a number of steps, at least 1"
    steps = checks.integer("steps", steps, expected, lambda v: v >= 1)
    every = max(1, steps // 100) if every is None else every
    every = checks.integer("every", every, expected, lambda v: v >= 1)
    bar = tqdm(total=steps, desc=label, unit="step", disable=None, delay=BAR_DELAY, leave=False)
    with stoppable() as stop, bar:
        done = 0
        while done < steps:
            count = min(steps - done, every if until else steps)
            made = _run(count, bar, stop)
            done += made
            if stop.asked or made < count or (until and done % every == 0 and until()):
                break
    return not stop.asked


def _run(count, bar, stop):
    """Make steps in one run and return their number.

    One run is faster than many, because YADE checks all bodies at the start of each. The number is
    smaller than `count` if `stop` or an engine has ended the run.
    """
    O = Omega()
    first, shown = O.iter, bar.n

    def check():
        bar.update(shown + O.iter - first - bar.n)
        if stop.asked:
            O.pause()

    O.run(count)
    wait_for_end(O, LONGEST_PAUSE, check)
    bar.update(shown + O.iter - first - bar.n)
    return O.iter - first
