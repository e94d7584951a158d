"""Sweeps in floats about a reference in doubles, on islands that threads share: nothing of the accuracy is lost, nor of the bits."""

import numpy as np
import pytest
from kernel.contact_problems import assert_laws, assert_same_bits, discs, frictionless, pile
from rcr import _kernel

UNCHECKED = dict(tolerance=0, check_interval=1_000_000)  # so that no check takes the sweeps back to doubles


def large(kind=lambda problem: problem):
    """One island of some 4000 pairs; its impulses are those of 400 sweeps."""
    return kind(pile(2, 60, 40))


def on_a_plate(problem):
    """The floor as a heavy body that moves, with more contacts than there are colours: most of them are overflow."""
    mass = problem["inverse_mass"].copy()
    floor = np.bincount(problem["bodies"].ravel(), minlength=len(mass)).argmax()
    assert not mass[floor].any()
    mass[floor] = 1e-2 * np.median(mass[mass[:, 0] > 0], axis=0)
    return type(problem)(f"{problem.name}, on a plate", problem.seed, **{**problem, "inverse_mass": mass})


KINDS = {"frictional": large, "frictionless": lambda: large(frictionless), "discs": lambda: large(discs), "overflow": lambda: large(on_a_plate)}


@pytest.fixture(params=KINDS, scope="module")
def problem(request):
    return KINDS[request.param]()


def test_lanes_and_threads_change_no_bit(problem):
    """Over three references."""
    first, *others = [
        problem.solve("nesterov", max_iterations=130, lanes=lanes, threads=threads, **UNCHECKED) for lanes, threads in ((1, 1), (4, 1), (8, 1), (8, 2), (0, 4))
    ]
    for other in others:
        assert_same_bits(first, other, problem.name)


def test_floats_alone_go_far(problem):
    """To some 6e-8, the rounding of impulses, in the end; where a reference did not follow, or a sweep took something else than the law of a
    point, they would end at 1e-3 or above."""
    assert problem.solve("nesterov", max_iterations=12_000, **UNCHECKED)["residual"] < 1e-6


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_tolerances_are_met_in_doubles(problem, tolerance):
    result = problem.solve("nesterov", tolerance=tolerance, max_iterations=50_000)
    assert_laws(problem, result, tolerance)
    assert result["converged"] and result["residual"] <= tolerance


@pytest.mark.parametrize("violation", [0.3, 0.1, 0.03])
def test_violation_is_that_of_doubles(problem, violation):
    """Floats hold velocities less those of their reference, and still end at the first sweep at which the whole velocities are good enough."""
    cold = type(problem)(f"{problem.name}, cold", problem.seed, **{**problem, "impulse": np.zeros_like(problem["impulse"])})
    for start in (problem, cold):
        end = start.solve("nesterov", tolerance=0.9, violation=violation, check_interval=1, max_iterations=5000)
        assert end["violation"] <= violation and end["converged"], start.name
        if end["iterations"] > 0:
            earlier = start.solve("nesterov", violation=violation, max_iterations=end["iterations"] - 1, **UNCHECKED)
            assert earlier["violation"] > 0.999 * violation or earlier["residual"] > 0.9, start.name


def test_fine_tolerances_are_left_to_doubles():
    problem = large(frictionless)
    result = problem.solve("nesterov", tolerance=1e-10, max_iterations=100_000)
    assert result["converged"] and result["residual"] <= 1e-10


def test_a_common_velocity_costs_no_accuracy():
    """Floats hold what differs from the reference, so it does not matter how fast all bodies move along."""
    problem = large()
    moving = type(problem)(f"{problem.name}, moving", problem.seed, **{key: value.copy() for key, value in problem.items()})
    moving["free_velocity"][:, 0] += 1e5 * np.abs(problem["free_velocity"]).max()
    residuals = [p.solve("nesterov", max_iterations=1000, **UNCHECKED)["residual"] for p in (problem, moving)]
    assert residuals[1] < 3 * residuals[0] + 1e-5


@pytest.mark.parametrize("scale", [1e-30, 1e-10, 1e10, 1e30])
def test_masses_of_any_size(scale):
    """Where floats would overflow or vanish, doubles sweep."""
    problem = large()
    scaled = type(problem)(f"{problem.name} x {scale:g}", problem.seed, **{key: value.copy() for key, value in problem.items()})
    scaled["inverse_mass"] = problem["inverse_mass"] / scale
    scaled["impulse"] = problem["impulse"] * scale
    result = scaled.solve("nesterov", tolerance=1e-4, max_iterations=20_000)
    assert_laws(scaled, result, 1e-4)
    assert np.isfinite(result["impulse"]).all() and result["converged"]


def test_growth_is_that_of_the_last_hundred_sweeps(problem):
    """In floats and doubles: what `auto` takes for the impulses that a step without a solution would let grow. Of fewer sweeps it is not known."""
    end, earlier = (problem.solve("nesterov", max_iterations=sweeps, **UNCHECKED) for sweeps in (230, 130))
    change = np.linalg.norm(end["impulse"] - earlier["impulse"]) / np.linalg.norm(end["impulse"])
    assert end["grown"] == pytest.approx(change, rel=1e-3) and change > 0
    assert problem.solve("nesterov", max_iterations=99, **UNCHECKED)["grown"] == np.inf
