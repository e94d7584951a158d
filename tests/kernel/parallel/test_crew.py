"""Threads belong to the process: teams come and go, threads do not grow in number, and a forked child has its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from kernel.contact_problems import pile
from rcr import _kernel

RETIREMENT = 10  # s without a call, after which a helper ends (crew.cpp)


def threads_now():
    return len(list(Path("/proc/self/task").iterdir()))


def run(code, timeout=120):
    """In a process of its own, without helpers at first."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    return subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True)


@pytest.fixture(scope="module", autouse=True)
def retired():
    """Started first, asked last: it sleeps for ten seconds."""
    yield run(f"""if True:
        import time
        from rcr import _kernel
        _kernel.Team().share_counts(3, 1000)
        before = _kernel.helper_count()
        time.sleep({RETIREMENT + 1})
        between = _kernel.helper_count()
        _kernel.Team().share_counts(2, 1000)
        print(before, between, _kernel.helper_count())
    """)


def test_dropped_teams_leave_no_threads():
    """200 workspaces with four threads each, all kept: as many helpers as one needs."""
    problem = pile(1)
    before = threads_now()
    kept = []
    for _ in range(200):
        kept.append(_kernel.Workspace())
        problem.solve(tolerance=0, max_iterations=2, threads=4, workspace=kept[-1])
    assert _kernel.helper_count() >= 3  # others may be left of other tests
    assert threads_now() <= before + 3, f"{threads_now()} threads, {before} before"


def test_teams_that_run_at_once_have_helpers_of_their_own():
    """Four leaders with two helpers each: every loop is right, and there are no more helpers than all of them asked for."""
    code = """if True:
        import threading
        from rcr import _kernel
        wrong = []
        def lead():
            team = _kernel.Team()
            for _ in range(50):
                if team.share_counts(3, 3000, loops=3) != [3] * 3000:
                    wrong.append(1)
        leaders = [threading.Thread(target=lead) for _ in range(4)]
        [leader.start() for leader in leaders]
        [leader.join() for leader in leaders]
        print(len(wrong), _kernel.helper_count())
    """
    wrong, helpers = map(int, run(code).communicate(timeout=120)[0].split())
    assert wrong == 0 and 2 <= helpers <= 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork()")
def test_a_forked_child_has_helpers_of_its_own():
    """Also where a thread of the parent is in the midst of a loop at the fork."""
    code = """if True:
        import os, sys, threading, time
        from kernel.contact_problems import pile
        from rcr import _kernel
        problem, workspace, team = pile(1), _kernel.Workspace(), _kernel.Team()
        solve = lambda: problem.solve(tolerance=0, max_iterations=30, threads=3, workspace=workspace)["impulse"]
        expected = solve()
        stop = False
        def busy():
            while not stop:
                team.share_counts(4, 20000)
        other = threading.Thread(target=busy)
        other.start()
        failed = 0
        for _ in range(20):
            child = os.fork()
            if not child:
                right = (solve() == expected).all() and _kernel.Team().share_counts(2, 5000) == [1] * 5000 and _kernel.helper_count() in (1, 2)
                os._exit(0 if right else 1)
            until = time.time() + 20
            while not (ended := os.waitpid(child, os.WNOHANG))[0] and time.time() < until:
                time.sleep(0.001)
            failed += ended[0] == 0 or ended[1] != 0
            if not ended[0]:
                os.kill(child, 9)
        stop = True
        other.join()
        assert (solve() == expected).all()
        print(failed)
    """
    assert run(code).communicate(timeout=500)[0].split() == ["0"]


def test_a_helper_that_nobody_calls_ends(retired):
    before, between, after = map(int, retired.communicate(timeout=60)[0].split())
    assert (before, between, after) == (2, 0, 1)
