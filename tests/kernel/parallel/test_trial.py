"""A trial takes the faster way, with helpers or alone, and follows where that changes."""

import os
import random
import subprocess
import sys

import pytest
from kernel.contact_problems import assert_same_bits, pile
from rcr import _kernel

TRIED, INTERVAL = 8, 400  # rounds of a way on trial; of the faster one in between


def ways(trial, rounds, helped, alone, cold=1):
    """The ways taken where a round takes these times, `cold` times as long in the first two of a way."""
    taken = []
    for _ in range(rounds):
        way = trial.helped
        early = len(taken) < 2 or taken[-2:] != [way, way]
        taken.append(way)
        trial.book((helped if way else alone) * (cold if early else 1))
    return taken


@pytest.mark.parametrize("cold", [1, 4])
@pytest.mark.parametrize("helped, alone", [(1.0, 1.8), (1.8, 1.0), (1.0, 1.1)])
def test_the_faster_way_is_taken(helped, alone, cold):
    """Also where the first rounds after a change of the way take longer than either: their data come from the other caches."""
    taken, faster = ways(_kernel.Trial(), 2000, helped, alone, cold), helped < alone
    assert taken[: 2 * TRIED] == [True] * TRIED + [False] * TRIED
    period = [faster] * INTERVAL + [not faster] * TRIED
    assert taken[2 * TRIED :] == (period * 5)[: 2000 - 2 * TRIED]


def test_a_way_that_is_far_slower_is_not_tried_for_long():
    taken = ways(_kernel.Trial(), 2000, 5.0, 1.0)
    assert sum(taken) == TRIED + 4 * 3


def test_a_disturbed_round_does_not_change_the_way():
    trial = _kernel.Trial()
    ways(trial, 2 * TRIED, 1.0, 1.8)
    trial.book(100.0)
    assert trial.helped


def test_a_way_that_is_held_up_now_and_then_is_not_taken_for_its_best_rounds():
    """A helper that saves 30 %, but is paused in every fiftieth round for thirty: by its least times it looked faster, and two threads took 1.29 of the time of one."""
    trial, chance, total = _kernel.Trial(), random.Random(1), 0
    for _ in range(100_000):
        time = (30 if chance.random() < 0.02 else 0.7) if trial.helped else 1
        trial.book(time)
        total += time
    assert total / 100_000 < 1.1


def test_the_trial_follows_the_machine():
    """Helpers that lose their cores are left, and taken again when they are back."""
    trial = _kernel.Trial()
    ways(trial, 1000, 1.0, 1.8)
    busy = ways(trial, 4000, 5.0, 1.8)
    assert sum(busy[800:]) <= 3200 / INTERVAL * TRIED
    free = ways(trial, 4000, 1.0, 1.8)
    assert sum(free[800:]) >= 3200 - 3200 / INTERVAL * TRIED


@pytest.mark.parametrize("solver", ["nlgs", "nesterov"])
def test_the_way_changes_no_bit(solver):
    """An island that threads share, solved twelve times with one workspace and so one trial: the first rounds go with and without help in turn, the
    later ones as was faster, while other processes take all cores from the fifth to the eighth solve. The bits are those of one thread."""
    problem, workspace = pile(2, 60, 40), _kernel.Workspace()
    settings = dict(tolerance=0, max_iterations=60)
    alone = problem.solve(solver, threads=1, **settings)
    others = []
    try:
        for solve in range(12):
            if solve == 4:
                others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count())]
            if solve == 8:
                [other.kill() for other in others]
            assert_same_bits(alone, problem.solve(solver, threads=2, workspace=workspace, **settings), f"solve {solve}")
    finally:
        for other in others:
            other.kill()
            other.wait()
