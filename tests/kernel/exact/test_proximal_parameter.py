"""The stiffness of proximal steps: it rises while they arrive, falls where one fails, and waits longer after each failure."""

from rcr import _kernel


def stiffness(**changes):
    return _kernel.Stiffness(**{**dict(start=100, least=1, most=1e6, rise=10, fall=10, max_patience=8), **changes})


def after(one, steps):
    """ρ after each of the steps: + arrived, − failed."""
    seen = []
    for step in steps:
        one.arrived() if step == "+" else one.failed()
        seen.append(one.rho)
    return seen


def test_rises_with_every_step_up_to_the_most():
    assert after(stiffness(), "+++++") == [1e3, 1e4, 1e5, 1e6, 1e6]
    assert after(stiffness(rise=4, most=1500), "+++") == [400, 1500, 1500]


def test_falls_down_to_the_least():
    assert after(stiffness(), "---") == [10, 1, 1]
    assert after(stiffness(fall=16, least=0.5), "---") == [6.25, 0.5, 0.5]


def test_every_failure_doubles_the_steps_before_the_next_rise():
    one = stiffness()
    assert after(one, "-+") == [10, 10] and after(one, "+") == [100]  # two steps after the first failure
    assert after(one, "-+++") == [10, 10, 10, 10] and after(one, "+") == [100]  # four after the second


def test_patience_has_a_limit_and_comes_back():
    """At most eight steps; two rises without a failure between them halve the number."""
    one = stiffness()
    after(one, "-----")
    assert after(one, "+" * 8) == [1] * 7 + [10]
    assert after(one, "+" * 4) == [10] * 3 + [100]
    assert after(one, "+" * 2) == [100, 1000] and after(one, "++") == [1e4, 1e5]


def test_a_step_that_fails_begins_the_count_anew():
    one = stiffness()
    after(one, "-+")
    assert after(one, "-+++") == [1, 1, 1, 1] and after(one, "+") == [10]


def test_without_patience_every_step_counts():
    assert after(stiffness(max_patience=1), "-+-+") == [10, 100, 10, 100]
