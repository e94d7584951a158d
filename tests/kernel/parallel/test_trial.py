"""A trial takes the faster way, with helpers or alone, and follows where that changes."""

import os
import subprocess
import sys

import pytest
from kernel.contact_problems import assert_same_bits, pile
from rcr import _kernel

FIRST, INTERVAL = 6, 50  # rounds in turn; between two of the other way


def ways(trial, rounds, helped, alone):
    """The ways taken where a round takes these times."""
    taken = []
    for _ in range(rounds):
        taken.append(trial.helped)
        trial.book(trial.helped, helped if trial.helped else alone)
    return taken


@pytest.mark.parametrize("helped, alone", [(1.0, 1.8), (1.8, 1.0), (1.0, 1.1)])
def test_the_faster_way_is_taken(helped, alone):
    taken = ways(_kernel.Trial(), 500, helped, alone)
    assert taken[:FIRST] == [True, False] * (FIRST // 2)
    faster = helped < alone
    other = [k for k in range(FIRST, 500) if taken[k] != faster]
    assert other == list(range(INTERVAL, 500, INTERVAL))


def test_a_disturbed_round_does_not_change_the_way():
    trial = _kernel.Trial()
    ways(trial, FIRST, 1.0, 1.8)
    trial.book(True, 100.0)
    assert trial.helped


def test_the_trial_follows_the_machine():
    """Helpers that lose their cores are left, and taken again when they are back."""
    trial = _kernel.Trial()
    ways(trial, 200, 1.0, 1.8)
    busy = ways(trial, 1000, 5.0, 1.8)
    assert sum(busy[200:]) <= 800 / INTERVAL + 1
    free = ways(trial, 4000, 1.0, 1.8)
    assert sum(free[3000:]) >= 1000 - 1000 / INTERVAL - 1


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
