"""A team processes every index once, with any helpers; exceptions and missing threads are safe."""

import os

import pytest
from kernel.contact_problems import (assert_lanes_and_threads_change_no_bit, assert_same_bits,
                                     grains_on_a_floor, pile, run)
from rcr import _kernel

SLICE = 2**20 - 1  # largest number of indices of one slice (shared_loop.cpp)


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 511, 512, 513, 10_000])
def test_every_index_once(threads, count):
    team = _kernel.ThreadTeam()
    for chunks in (False, True):
        for nested in (False, True):
            found = team.loop_counts(threads, count, loops=20, chunks=chunks, nested=nested)
            assert found == [20] * count, (chunks, nested)


@pytest.mark.parametrize("count", [SLICE, SLICE + 1, SLICE + 2, 2 * SLICE + 1])
def test_loop_of_several_slices(count):
    code = f"""if True:
        from rcr import _kernel
        assert _kernel.ThreadTeam().loop_counts(2, {count}) == [1] * {count}
    """
    with run(code) as process:
        assert process.wait() == 0


@pytest.mark.parametrize("chunks", [False, True])
@pytest.mark.parametrize("threads", [1, 2, 4])
def test_exception_reaches_the_leader(threads, chunks):
    """The exception of the smallest index is rethrown; the team remains usable."""
    team = _kernel.ThreadTeam()
    for failing in ([3, 700, 1999], [1999], [0]):
        for _ in range(20):
            with pytest.raises(RuntimeError, match=f"^{failing[0]}$"):
                team.loop_counts(threads, 2000, failing=failing, chunks=chunks)
    assert team.loop_counts(threads, 2000, chunks=chunks) == [1] * 2000


def test_team_works_with_fewer_threads():
    """Without address space for 64 stacks: the same bits. Later, with space: all helpers."""
    code = """if True:
        import resource
        from pathlib import Path
        import numpy as np
        from kernel.contact_problems import pile
        from rcr import _kernel
        problem = pile(1)
        settings = dict(tolerance=0, max_iterations=50)
        alone = problem.solve(**settings)["impulse"]
        space = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (space + 40_000_000, hard))
        team, workspace = _kernel.ThreadTeam(), _kernel.Workspace()
        solve = lambda: problem.solve(threads=64, workspace=workspace, **settings)["impulse"]
        assert (solve() == alone).all() and team.loop_counts(64, 5000) == [1] * 5000
        few = _kernel.helper_count()
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
        assert (solve() == alone).all() and team.loop_counts(64, 5000) == [1] * 5000
        assert few < 63 == _kernel.helper_count(), (few, _kernel.helper_count())
    """
    with run(code) as process:
        assert process.wait() == 0


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2,
                    reason="on one core, the waiting thread blocks the helper")
@pytest.mark.parametrize("stalls", [dict(stalls=1, stall=50, rest=500),
                                    dict(stalls=8, stall=3, rest=100)], ids=["long", "short"])
def test_stalls_exclude_helpers_briefly(stalls):
    """All steps of O.run are one run of the team, so no time without helpers may accumulate."""
    assert _kernel.helps_after_stalls(_kernel.ThreadTeam(), **stalls)


def test_a_million_islands_and_two_threads():
    """2²⁰ grains, each at one point of the floor: more islands than one slice holds."""
    problem = grains_on_a_floor(2**20)
    settings = dict(solver="nlgs", tolerance=1e-6)
    one, two = (problem.solve(threads=threads, **settings) for threads in (1, 2))
    assert two["converged"] and two["residual"] < 1e-6
    assert_same_bits(one, two, problem.name)


def test_more_threads_than_islands_or_processors():
    choices = [(0, threads) for threads in (1, 2, 3, 17, 64)]
    assert_lanes_and_threads_change_no_bit(pile(3), "nesterov", choices, tolerance=0,
                                           max_iterations=30)
