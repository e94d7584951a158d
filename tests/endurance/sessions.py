"""Random calls of a session that starts, pauses, saves and replaces runs in the background.

No call may end the process, hang, or raise an error of an unknown kind. Afterwards a scene takes
exactly the steps that it is told to. Half of the sessions have one processor, on which the thread
of a run begins late.

    scripts/check sessions [-- --scenes 300 --first 0]
"""

import collections
import os
import random
import signal
import tempfile
import threading
import time

import children
from scene_fuzzer import O, rcr, scenes  # imports YADE before rcr

CALLS = 400  # of a session
HANGS = 120  # seconds after which a session hangs
KNOWN = ("while the scene runs", "while simulation is running", "doesn't exist", "out of range",
         "no scene in memory", "a run is under way", "expected the id of a body")


def build(count):
    """A scene of so many grains that fall on a floor."""
    rough = scenes.material()
    scenes.build(rcr.wall("y", 0, material=rough), *(
        rcr.particle((0.3 * k, 0.2), 0.1, 0.5, k, rough) for k in range(count)), tolerance=1e-4)


class Session:
    """Calls by name; each takes no argument."""

    def __init__(self, seed, folder):
        self.random, self.path = random.Random(seed), os.path.join(folder, "scene.yade")
        self.calls = {name: getattr(self, name) for name in vars(Session) if name[0] != "_"}
        self.calls |= {"O.run": O.run, "O.pause": O.pause, "O.step": O.step, "O.reset": O.reset,
                       "O.resetThisScene": O.resetThisScene, "O.interactions.clear":
                       O.interactions.clear}

    def make(self):
        O.pause()
        build(self.random.randrange(1, 9))

    def some_steps(self):
        O.run(self.random.randrange(1, 50))

    def steps_and_wait(self):
        if not O.running:
            O.run(self.random.randrange(1, 50), True)

    def interrupt(self):
        """Ctrl-C while the session waits."""
        O.run()
        thread = threading.Thread(target=self._press, args=(threading.main_thread().ident,))
        thread.start()
        try:
            O.wait()
        except KeyboardInterrupt:
            pass
        finally:
            thread.join()

    def _press(self, ident):
        time.sleep(self.random.choice((0, 1e-3)))
        signal.pthread_kill(ident, signal.SIGINT)

    def of_another_thread(self):
        thread = threading.Thread(target=lambda: (O.pause(), O.run(2)))
        thread.start()
        thread.join()

    def save(self):
        O.pause()
        O.save(self.path, quiet=True)

    def load(self):
        if os.path.exists(self.path):
            O.load(self.path, quiet=True)

    def erase(self):
        O.bodies.erase(len(O.bodies) - 1)

    def assign_engines(self):
        O.engines = list(O.engines)

    def nap(self):
        time.sleep(self.random.choice((0, 1e-5, 1e-4, 1e-3)))


def play(session, counts):
    """Random calls. Returns a sentence on an error of an unknown kind, or None."""
    for _ in range(CALLS):
        name = session.random.choice(list(session.calls))
        try:
            session.calls[name]()
            counts["calls"] += 1
        except KeyboardInterrupt:  # after the wait
            counts["late interrupts"] += 1
        except (RuntimeError, ValueError, IndexError) as error:
            if not any(words in str(error) for words in KNOWN):
                return f"{name}: {error}"
            counts["refused"] += 1
    return None


def outcome(seed):
    """A sentence on an error, or None; and counts of calls."""
    everywhere, counts = os.sched_getaffinity(0), collections.Counter()
    signal.alarm(HANGS)
    with tempfile.TemporaryDirectory() as folder:
        try:
            os.sched_setaffinity(0, {min(everywhere)} if seed % 2 else everywhere)
            wrong = play(Session(seed, folder), counts)
            O.pause()
            build(3)
            O.run(7, True)
            if not wrong and O.iter != 7:
                wrong = f"a run of 7 steps took {O.iter}"
        finally:
            O.pause()
            os.sched_setaffinity(0, everywhere)
            signal.alarm(0)
    return wrong, counts


if __name__ == "__main__":
    children.main(children.parser(__doc__, 300).parse_args(), outcome)
