"""A team works on every index once, whatever helps; what throws, or cannot be hired, does not stop it."""

import os
import subprocess
import sys

import numpy as np
import pytest
from kernel.contact_problems import assert_same_bits, grains_on_a_floor, pile
from rcr import _kernel

SLICE = 2**20 - 1  # indices that one word of a part can hold (shared_loop.cpp)


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 511, 512, 513, 10_000])
def test_every_index_once(threads, count):
    team = _kernel.Team()
    for each in (False, True):
        for nested in (False, True):
            assert team.share_counts(threads, count, loops=20, each=each, nested=nested) == [20] * count, (each, nested)


@pytest.mark.parametrize("count", [SLICE, SLICE + 1, SLICE + 2, 2 * SLICE + 1])
def test_more_indices_than_a_word_holds(count):
    """In a process of its own, which can be given up: work that is lost is waited for without end."""
    code = f"from rcr import _kernel; counts = _kernel.Team().share_counts(2, {count}); assert counts == [1] * {count}"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


@pytest.mark.parametrize("each", [False, True])
@pytest.mark.parametrize("threads", [1, 2, 4])
def test_what_work_throws_reaches_the_leader(threads, each):
    """The exception of the least index, and the team is as good as before."""
    team = _kernel.Team()
    for failing in ([3, 700, 1999], [1999], [0]):
        for _ in range(20):
            with pytest.raises(RuntimeError, match=f"^{failing[0]}$"):
                team.share_counts(threads, 2000, failing=failing, each=each)
    assert team.share_counts(threads, 2000, each=each) == [1] * 2000


def test_a_team_that_cannot_hire_goes_on_with_fewer():
    """The address space has no room for the stacks of 64 threads: the same bits, and helpers as soon as there is room."""
    code = """if True:
        import resource
        from pathlib import Path
        import numpy as np
        from kernel.contact_problems import pile
        from rcr import _kernel
        problem = pile(1)
        alone = problem.solve(tolerance=0, max_iterations=50)["impulse"]
        space = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (space + 40_000_000, hard))
        team, workspace = _kernel.Team(), _kernel.Workspace()
        solve = lambda: problem.solve(tolerance=0, max_iterations=50, threads=64, workspace=workspace)["impulse"]
        assert (solve() == alone).all() and team.share_counts(64, 5000) == [1] * 5000
        few = _kernel.helper_count()
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
        assert (solve() == alone).all() and team.share_counts(64, 5000) == [1] * 5000
        assert few < 63 == _kernel.helper_count(), (few, _kernel.helper_count())
    """
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120, env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)))


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core: who waits for another keeps it from coming")
def test_a_helper_that_was_waited_for_is_called_again_within_the_run():
    """All steps of O.run are one run of the team: a helper that lost its core once was left alone until its end."""
    assert _kernel.helps_after_stalls(_kernel.Team(), stalls=1, stall=50, rest=500)


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core: who waits for another keeps it from coming")
def test_short_stalls_do_not_leave_the_leader_alone_for_long():
    """Each doubled the time that the leader went on alone, up to two seconds: two threads took as long as one where the system paused a core at times."""
    assert _kernel.helps_after_stalls(_kernel.Team(), stalls=8, stall=3, rest=100)


def test_a_million_islands_and_two_threads():
    """2²⁰ grains, each at one point of the floor: more islands than a word holds."""
    problem = grains_on_a_floor(2**20)
    one, two = (problem.solve("nlgs", tolerance=1e-6, threads=threads) for threads in (1, 2))
    assert two["converged"] and two["residual"] < 1e-6
    assert_same_bits(one, two, problem.name)


def test_more_threads_than_islands_or_processors():
    problem = pile(3)
    alone = problem.solve(tolerance=0, max_iterations=30)
    for threads in (2, 3, 17, 64):
        assert_same_bits(alone, problem.solve(tolerance=0, max_iterations=30, threads=threads), f"{threads} threads")
    assert np.isfinite(alone["impulse"]).all()
