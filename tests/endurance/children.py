"""Runs random scenes in child processes, so that a crash or a hang is an outcome too.

`outcome(seed)` of a check returns a sentence on an error, or None, and numbers for the report.
"""

import argparse
import collections
import json
import math
import signal
import subprocess
import sys
import tempfile
import time
import warnings

LIMIT = 600  # processor time of a scene [s]
TAIL = 300  # characters of the messages of a child that ended early


def parser(description, scenes):
    """The options of all checks."""
    made = argparse.ArgumentParser(description=description,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--scenes", type=int, default=scenes, help="at most so many")
    made.add_argument("--first", type=int, default=0, metavar="SEED",
                      help="of the first scene (default %(default)s)")
    made.add_argument("--only", type=int, metavar="SEED", help="this scene alone, in this process")
    made.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    return made


def check(outcome, options, seconds=math.inf, seen=lambda seed, numbers: None):
    """Run the scenes of the options and print each error; returns sums of the numbers, of which
    `seen` may remove some, and the seeds of failed scenes.
    """
    if options.child:
        _serve(outcome, range(options.first, options.first + options.scenes))
    if options.only is None:
        found = _of_children(options.first, options.first + options.scenes)
    else:
        warnings.simplefilter("ignore")
        found = [(options.only, *outcome(options.only))]
    counts, wrong, end = collections.Counter(), [], time.monotonic() + seconds
    for seed, sentence, numbers in found:
        seen(seed, numbers)
        counts.update(numbers)
        counts["scenes"] += 1
        if sentence:
            wrong.append(seed)
            print(f"seed {seed}: {sentence}", flush=True)
        if time.monotonic() > end:
            break
    return counts, wrong


def main(options, outcome, draw=None, told=print):
    """Check scenes, print their counts by `told`, and end the process."""
    if draw and options.only is not None:
        print(draw(options.only))
    counts, wrong = check(outcome, options)
    told(dict(counts))
    print(f"{counts['scenes'] - len(wrong)} passed, {len(wrong)} failed")
    sys.exit(bool(wrong))


def shrink(scene, smaller, fails):
    """The least scene that still fails; `smaller(scene)` yields scenes with less."""
    tries = (less for less in smaller(scene) if repr(less) != repr(scene) and fails(less))
    less = next(tries, None)
    return shrink(less, smaller, fails) if less else scene


def _serve(outcome, seeds):
    """Print the outcomes for the parent, and end the process."""
    warnings.simplefilter("ignore")
    for seed in seeds:
        signal.setitimer(signal.ITIMER_PROF, LIMIT)
        print(f"seed {seed}", flush=True)
        print("outcome", json.dumps(outcome(seed)), flush=True)
    sys.exit()


def _of_children(seed, last):
    """Yield (seed, sentence or None, numbers) of each scene."""
    while seed < last:
        command = [sys.executable, *sys.argv, "--child", "--first", str(seed), "--scenes",
                   str(last - seed)]
        with tempfile.TemporaryFile("w+", errors="replace") as messages:
            child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=messages, text=True)
            try:
                for line in child.stdout:
                    word, _, rest = line.partition(" ")
                    if word == "seed":
                        seed = int(rest)
                    elif word == "outcome":
                        yield seed, *json.loads(rest)
                if child.wait():
                    messages.seek(0)
                    words = messages.read().strip()[-TAIL:]
                    yield seed, f"the process ended with {child.returncode}: {words}", {}
            finally:
                child.kill()
                child.wait()
        seed += 1
