"""JamDetector and StepCounts: verdicts and warnings for given sequences of steps."""

import re

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
    assert verdicts(JamDetector(), overlaps, yielded) == expected


def test_a_saved_detector_gives_the_same_verdict():
    overlaps = growing(PATIENCE)
    first, again = JamDetector(), JamDetector()
    assert verdicts(first, overlaps[:4], {0}) == []
    again.new_maxima, again.deepest, again.yielded = first.new_maxima, first.deepest, first.yielded
    assert verdicts(again, overlaps[4:]) == [(PATIENCE - 1 - 4, "jam")]


def of_overlaps(*overlaps, missed=False):
    return [(missed, False, overlap) for overlap in overlaps]


@pytest.mark.parametrize("steps, warned, last", [
    pytest.param(of_overlaps(*[0.1] * 100), [], "", id="initial overlaps"),
    pytest.param(of_overlaps(*[4.9e-5 * k for k in range(100)]), [], "", id="shallow overlaps"),
    pytest.param(of_overlaps(*[4.9e-3] * 100, missed=True), [], "", id="shallow, not converged"),
    pytest.param([(False, False, 0.1 * k, True) for k in range(100)], [], "", id="overdamped"),
    pytest.param([*[(False, False, 0.3, True)] * 5, *of_overlaps(*[1e-4] * 5),
                  (True, False, 1e-4)], [], "", id="compaction, then shear"),
    pytest.param([(False, False, 1e-4), (True, False, 0.03)], [1],
                 "1 of 2 steps have not converged; the deepest overlap is 0.03.*Positions are wrong"
                 ".*smaller O.dt", id="deep overlap of a missed step"),
    pytest.param(of_overlaps(1e-4, 4e-3, 1e-2, 1.5e-2, 2.5e-2, 0.06), [2, 4, 5],
                 r"the deepest overlap is 0.06 of R₁ \+ R₂ and grows, although all steps "
                 "converged.", id="growing overlaps of converged steps"),
    pytest.param(of_overlaps(1e-4, 4e-3, 6e-3, 1e-2, 1.3e-2, 2e-2, 5e-2, missed=True), [2, 4, 6],
                 ".*0.05", id="overlaps that double"),
    pytest.param([(True, True, 0.0)] * 1000, [0, 9, 99, 999], ".*without a solution.*leave these "
                 "steps out of averages", id="each tenfold without a solution"),
    pytest.param([(True, False, 0.0, False, True)] * 100, [0, 9, 99], "100 of 100 steps have not "
                 "converged.*In 100 steps bodies moved into each other by more than a cap radius "
                 "on their paths.*smaller O.dt.$", id="each tenfold with intrusions"),
    pytest.param([(False, False, 0.0, False, True)], [0], "1 of 1 step has intrusions; the deepest "
                 "overlap is 0 of .*In 1 step bodies", id="intrusion at tolerance 0"),
    pytest.param([(False, True, 0.01)], [0], "1 of 1 step has no solution; the deepest overlap is "
                 "0.01.*leave these steps out of averages", id="no solution at tolerance 0"),
])
def test_warnings(steps, warned, last):
    """Steps that warn, and the last message; at tolerance 0 no step counts as missed."""
    watch = StepCounts()
    found = [(k, watch.message()) for k, step in enumerate(steps) if watch.count(*step)]
    assert [step for step, _ in found] == warned
    assert not warned or re.match(last, found[-1][1], re.S)


def test_counts_of_steps():
    watch = StepCounts()
    for step in [(False, False, 0.01), (True, False, 0.02), (True, True, 0.0), (False, False, 0.0)]:
        watch.count(*step)
    assert (watch.steps, watch.missed, watch.yielded, watch.deepest) == (4, 2, 1, 0.02)
