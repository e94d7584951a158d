"""JamDetector and StepCounts: verdicts and warnings for given sequences of steps."""

import pytest
from rcr._kernel import JamDetector, StepCounts

JAM_OVERLAP, PATIENCE = JamDetector.jam_overlap, JamDetector.patience


def verdicts(detector, overlaps, yielded=()):
    """(step, verdict) of all verdicts; `yielded` holds the steps that yielded."""
    found = [detector.update(overlap, step in yielded) for step, overlap in enumerate(overlaps)]
    return [(step, verdict) for step, verdict in enumerate(found) if verdict != "none"]


def growing(steps, start=1.1, rate=0.1):
    return [JAM_OVERLAP * (start + rate * k) for k in range(steps)]


@pytest.mark.parametrize("overlaps, yielded, expected", [
    pytest.param(growing(25), (), [(PATIENCE - 1, "not converged"),
                                   (2 * PATIENCE - 1, "not converged")], id="growth"),
    pytest.param(growing(25), range(25), [(PATIENCE - 1, "jam"), (2 * PATIENCE - 1, "jam")],
                 id="growth without a solution"),
    pytest.param(growing(15), {3}, [(PATIENCE - 1, "jam")], id="one step without a solution"),
    pytest.param([JAM_OVERLAP * k / 200 for k in range(200)], range(200), [], id="shallow"),
    pytest.param([1.4 * JAM_OVERLAP + 4e-6 * k for k in range(200)], (), [],
                 id="drift of a tolerance"),
    pytest.param([10 * JAM_OVERLAP * 0.99**k for k in range(200)], range(200), [], id="impact"),
    pytest.param([factor * overlap for overlap in growing(PATIENCE) for factor in (1, 1, .99, .98)],
                 (), [(4 * (PATIENCE - 1), "not converged")], id="small recessions"),
    pytest.param([*growing(PATIENCE - 1), 0.9 * JAM_OVERLAP, *growing(PATIENCE - 1)], range(5), [],
                 id="removed overlap"),
])
def test_verdicts(overlaps, yielded, expected):
    """Overlaps that grow for `PATIENCE` steps give a verdict."""
    assert verdicts(JamDetector(), overlaps, yielded) == expected


def test_a_saved_detector_gives_the_same_verdict():
    overlaps = growing(PATIENCE)
    first, again = JamDetector(), JamDetector()
    assert verdicts(first, overlaps[:4], {0}) == []
    again.new_maxima, again.deepest, again.yielded = first.new_maxima, first.deepest, first.yielded
    assert verdicts(again, overlaps[4:]) == [(PATIENCE - 1 - 4, "jam")]


def warnings(steps):
    """(step, message) of all warnings for (missed, yielded, overlap) of each step."""
    watch = StepCounts()
    return [(k, watch.message()) for k, step in enumerate(steps) if watch.count(*step)]


@pytest.mark.parametrize("steps", [
    pytest.param([(False, False, 0.1)] * 100, id="initial overlaps"),
    pytest.param([(False, False, 4.9e-3 * k / 100) for k in range(100)], id="shallow overlaps"),
    pytest.param([(True, False, 4.9e-3)] * 100, id="shallow overlaps, not converged"),
    pytest.param([(False, False, 0.1 * k, True) for k in range(100)], id="overdamped steps"),
    pytest.param([*[(False, False, 0.3, True)] * 5, *[(False, False, 1e-4)] * 5,
                  (True, False, 1e-4)], id="compaction, then shear"),
])
def test_no_warning(steps):
    assert warnings(steps) == []


def test_a_deep_overlap_of_a_missed_step_warns():
    ((step, message),) = warnings([(False, False, 1e-4), (True, False, 0.03)])
    assert step == 1
    assert message.startswith("1 of 2 steps have not converged; the deepest overlap is 0.03")
    assert "Positions are wrong" in message and "smaller O.dt" in message


def test_growing_overlaps_of_converged_steps_warn():
    overlaps = 1e-4, 4e-3, 1e-2, 1.5e-2, 2.5e-2, 0.06
    messages = warnings([(False, False, overlap) for overlap in overlaps])
    assert [k for k, _ in messages] == [2, 4, 5]
    start = "the deepest overlap is 0.01 of R₁ + R₂ and grows, although all steps converged."
    assert messages[0][1].startswith(start)


def test_a_warning_repeats_when_overlaps_double():
    overlaps = 1e-4, 4e-3, 6e-3, 1e-2, 1.3e-2, 2e-2, 5e-2
    messages = warnings([(True, False, overlap) for overlap in overlaps])
    assert [k for k, _ in messages] == [2, 4, 6]
    assert "0.05" in messages[-1][1]


def test_steps_without_a_solution_warn_at_each_tenfold():
    messages = warnings([(True, True, 0.0)] * 1000)
    assert [k for k, _ in messages] == [0, 9, 99, 999]
    assert "without a solution" in messages[0][1]
    assert "leave these steps out of averages" in messages[0][1]


def test_steps_without_a_solution_warn_at_tolerance_0():
    """No step counts as missed then."""
    ((_, message),) = warnings([(False, True, 0.01)])
    assert message.startswith("1 of 1 step has no solution; the deepest overlap is 0.01")
    assert "leave these steps out of averages" in message


def test_counts_of_steps():
    watch = StepCounts()
    for step in [(False, False, 0.01), (True, False, 0.02), (True, True, 0.0), (False, False, 0.0)]:
        watch.count(*step)
    assert (watch.steps, watch.missed, watch.yielded, watch.deepest) == (4, 2, 1, 0.02)
