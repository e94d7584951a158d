"""What watches a run: a squeeze that goes on, and steps that missed the tolerance."""

from rcr._kernel import MissedSteps, Squeeze

CRUSHED, PATIENCE = Squeeze.crushed, Squeeze.patience


def tell(squeeze, overlaps):
    """Steps in which the squeeze is told."""
    return [step for step, overlap in enumerate(overlaps) if squeeze.goes_on(overlap)]


def growing(steps, start=1.1, rate=0.1):
    return [CRUSHED * (start + rate * k) for k in range(steps)]


def test_a_squeeze_is_told_after_its_patience_and_again():
    assert tell(Squeeze(), growing(25)) == [PATIENCE - 1, 2 * PATIENCE - 1]


def test_overlaps_of_beds_at_rest_and_in_flow_are_not_told():
    assert tell(Squeeze(), [CRUSHED * k / 200 for k in range(200)]) == []


def test_a_blow_that_is_taken_back_is_not_told():
    assert tell(Squeeze(), [10 * CRUSHED * 0.99**k for k in range(200)]) == []


def test_pauses_and_small_recessions_do_not_end_a_squeeze():
    overlaps = [value for overlap in growing(PATIENCE) for value in (overlap, overlap, 0.99 * overlap, 0.98 * overlap)]
    assert tell(Squeeze(), overlaps) == [4 * (PATIENCE - 1)]


def test_what_is_taken_back_whole_ends_a_squeeze():
    half = growing(PATIENCE - 1)
    assert tell(Squeeze(), [*half, 0.9 * CRUSHED, *half]) == []


def test_a_saved_squeeze_speaks_in_the_same_step():
    overlaps = growing(PATIENCE)
    first = Squeeze()
    assert tell(first, overlaps[:4]) == []
    again = Squeeze()
    again.grown, again.deepest = first.grown, first.deepest
    assert tell(again, overlaps[4:]) == [PATIENCE - 1 - 4]


def told(steps):
    """(number of the step, message) of every message, for (missed, yielded, overlap) of each step."""
    watch = MissedSteps()
    return [(k, watch.message()) for k, step in enumerate(steps) if watch.count(*step)]


def test_steps_that_all_converge_are_silent():
    assert told([(False, False, 0.1)] * 100) == []
    assert told([(False, False, 1.9e-2 * k / 100) for k in range(100)]) == []
    assert told([(False, False, 0.1 * k, True) for k in range(100)]) == []


def test_overlaps_of_a_compaction_are_none_of_the_shear_after_it():
    """Overdamped steps take them back: of the first missed step of the shear they were told as the deepest overlap."""
    ((k, message),) = told([(False, False, 0.3, True)] * 5 + [(False, False, 1e-4)] * 5 + [(True, False, 1e-4)])
    assert k == 10 and "0.0001 of R₁ + R₂, is harmless" in message


def test_a_deep_overlap_is_told_as_what_missed():
    ((_, message),) = told([(False, False, 1e-4), (True, False, 0.03)])
    assert message.startswith("1 of 2 steps so far did not reach the tolerance or left an overlap beyond 0.02; the deepest overlap, 0.03")


def test_overlaps_that_grow_without_a_miss_are_told_at_each_doubling():
    messages = told([(False, False, overlap) for overlap in (1e-4, 1e-2, 3e-2, 4e-2, 0.1)])
    assert [k for k, _ in messages] == [2, 4]
    assert messages[0][1].startswith("the deepest overlap, 0.03 of R₁ + R₂, grows although all steps reached the tolerance. Something moves")


def test_harmless_misses_are_told_once():
    messages = told([(False, False, 1e-4)] * 9 + [(True, False, 1e-4)] * 500)
    assert [k for k, _ in messages] == [9]
    assert messages[0][1] == (
        "1 of 10 steps so far did not reach the tolerance; the deepest overlap, 0.0001 of R₁ + R₂, is harmless. This is told again if it gets worse."
    )


def test_a_first_step_is_not_counted_aloud():
    ((_, message),) = told([(True, False, 0.0)])
    assert message == "the first step did not reach the tolerance; no bodies overlap, so it is harmless. This is told again if it gets worse."


def test_misses_are_told_again_when_overlaps_double():
    messages = told([(True, False, overlap) for overlap in (1e-4, 4e-3, 6e-3, 1e-2, 1.3e-2, 2e-2, 5e-2)])
    assert [k for k, _ in messages] == [0, 2, 4, 6]
    assert "harmless" not in messages[-1][1] and "0.05" in messages[-1][1] and "smaller time step" in messages[-1][1]


def test_steps_without_a_solution_are_told_at_each_tenfold():
    messages = told([(True, True, 0.0)] * 1000)
    assert [k for k, _ in messages] == [0, 9, 99, 999]
    assert "without a solution" in messages[0][1]


def test_counts_and_share():
    watch = MissedSteps()
    for step in [(False, False, 0.01), (True, False, 0.02), (True, True, 0.0), (False, False, 0.0)]:
        watch.count(*step)
    assert (watch.steps, watch.missed, watch.yielded, watch.deepest, watch.share) == (4, 2, 1, 0.02, 0.5)
