"""Helper threads belong to the process: their number is bounded, and a forked child has its own."""

import os
from pathlib import Path

import pytest
from kernel.contact_problems import pile, run
from rcr import _kernel

IDLE_LIMIT = 10  # s without a request, after which a helper ends (thread_pool.cpp)


def threads_now():
    return len(list(Path("/proc/self/task").iterdir()))


@pytest.fixture(scope="module", autouse=True)
def idle_helpers():
    """Process that counts its helpers before and after they idle. It sleeps during other tests."""
    yield run(f"""if True:
        import time
        from rcr import _kernel
        _kernel.ThreadTeam().loop_counts(3, 1000)
        before, end = _kernel.helper_count(), time.monotonic() + {IDLE_LIMIT + 20}
        while _kernel.helper_count() and time.monotonic() < end:
            time.sleep(0.1)
        between = _kernel.helper_count()
        _kernel.ThreadTeam().loop_counts(2, 1000)
        print(before, between, _kernel.helper_count())
    """)


def test_idle_teams_hold_no_threads():
    """200 workspaces with four threads each, all kept, have as many helpers as one."""
    problem = pile(1)
    before = threads_now()
    kept = []
    for _ in range(200):
        kept.append(_kernel.Workspace())
        problem.solve(tolerance=0, max_iterations=2, threads=4, workspace=kept[-1])
    assert _kernel.helper_count() >= 3  # earlier tests may have left helpers
    assert threads_now() <= before + 3, f"{threads_now()} threads, {before} before"


def test_simultaneous_teams_have_separate_helpers():
    """Four leaders with two helpers each: every loop is right, and there are at most 8 helpers."""
    code = """if True:
        import threading
        from rcr import _kernel
        wrong = []
        def lead():
            team = _kernel.ThreadTeam()
            for _ in range(50):
                if team.loop_counts(3, 3000, loops=3) != [3] * 3000:
                    wrong.append(1)
        leaders = [threading.Thread(target=lead) for _ in range(4)]
        [leader.start() for leader in leaders]
        [leader.join() for leader in leaders]
        print(len(wrong), _kernel.helper_count())
    """
    wrong, helpers = map(int, run(code).communicate()[0].split())
    assert wrong == 0 and 2 <= helpers <= 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork()")
def test_forked_child_has_its_own_helpers():
    """Includes forks during a loop of another thread of the parent."""
    code = """if True:
        import os, sys, threading, time
        from kernel.contact_problems import pile
        from rcr import _kernel
        problem, workspace, team = pile(1), _kernel.Workspace(), _kernel.ThreadTeam()
        settings = dict(tolerance=0, max_iterations=30, threads=3, workspace=workspace)
        solve = lambda: problem.solve(**settings)["impulse"]
        expected = solve()
        stop = False
        def busy():
            while not stop:
                team.loop_counts(4, 20000)
        other = threading.Thread(target=busy)
        other.start()
        failed = 0
        for _ in range(20):
            child = os.fork()
            if not child:
                right = (solve() == expected).all()
                right = right and _kernel.ThreadTeam().loop_counts(2, 5000) == [1] * 5000
                right = right and _kernel.helper_count() in (1, 2)
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
    assert run(code, 500).communicate()[0].split() == ["0"]


def test_idle_helper_ends(idle_helpers):
    before, between, after = map(int, idle_helpers.communicate(timeout=60)[0].split())
    assert (before, between, after) == (2, 0, 1)
