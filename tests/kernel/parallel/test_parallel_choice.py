"""ParallelChoice uses the faster mode, serial or parallel, and follows changes of the machine."""

import os
import random
import subprocess
import sys

import pytest
from kernel.contact_problems import assert_same_bits, pile
from rcr import _kernel

TRIAL, INTERVAL = 8, 400  # rounds of a trial; rounds between trials


def modes(choice, rounds, parallel, serial, cold=1):
    """Modes used, True if parallel, for these times; the first two take `cold` times as long."""
    used = []
    for _ in range(rounds):
        mode = choice.parallel
        early = len(used) < 2 or used[-2:] != [mode, mode]
        used.append(mode)
        choice.record((parallel if mode else serial) * (cold if early else 1))
    return used


@pytest.mark.parametrize("cold", [1, 4])
@pytest.mark.parametrize("parallel, serial", [(1.0, 1.8), (1.8, 1.0), (1.0, 1.1)])
def test_faster_mode_is_used(parallel, serial, cold):
    used = modes(_kernel.ParallelChoice(), 2000, parallel, serial, cold)
    faster = parallel < serial
    assert used[: 2 * TRIAL] == [True] * TRIAL + [False] * TRIAL
    period = [faster] * INTERVAL + [not faster] * TRIAL
    assert used[2 * TRIAL :] == (period * 5)[: 2000 - 2 * TRIAL]


def test_much_slower_mode_is_tried_briefly_and_one_delayed_round_changes_nothing():
    assert sum(modes(_kernel.ParallelChoice(), 2000, 5.0, 1.0)) == TRIAL + 4 * 3
    choice = _kernel.ParallelChoice()
    modes(choice, 2 * TRIAL, 1.0, 1.8)
    choice.record(100.0)
    assert choice.parallel


def test_frequent_delays_count_against_a_mode():
    """Helpers save 30 %, but every fiftieth round on average takes 30 times as long."""
    choice, chance, total = _kernel.ParallelChoice(), random.Random(1), 0
    for _ in range(100_000):
        time = (30 if chance.random() < 0.02 else 0.7) if choice.parallel else 1
        choice.record(time)
        total += time
    assert total / 100_000 < 1.1


def test_mode_follows_the_machine():
    """Helpers that lose their cores are not used, until they are faster again."""
    choice = _kernel.ParallelChoice()
    modes(choice, 1000, 1.0, 1.8)
    assert sum(modes(choice, 4000, 5.0, 1.8)[800:]) <= 3200 / INTERVAL * TRIAL
    assert sum(modes(choice, 4000, 1.0, 1.8)[800:]) >= 3200 - 3200 / INTERVAL * TRIAL


@pytest.mark.parametrize("solver", ["nlgs", "nesterov"])
def test_mode_changes_no_bit(solver):
    """A shared island has the bits of one thread in twelve solves; cores are busy in four."""
    problem, workspace = pile(2, 60, 40), _kernel.Workspace()
    settings = dict(tolerance=0, max_iterations=60)
    alone = problem.solve(solver, threads=1, **settings)
    endless = [sys.executable, "-c", "while True: pass"]
    others = []
    try:
        for solve in range(12):
            if solve == 4:
                others = [subprocess.Popen(endless) for _ in os.sched_getaffinity(0)]
            if solve == 8:
                [other.kill() for other in others]
            shared = problem.solve(solver, threads=2, workspace=workspace, **settings)
            assert_same_bits(alone, shared, f"solve {solve}")
    finally:
        for other in others:
            other.kill()
            other.wait()
