"""Choice of the solver by name, invalid settings, and the steps of `auto`."""

import numpy as np
import pytest
from common import refused
from kernel.contact_problems import (assert_laws, assert_same_bits, assert_solved, beside,
                                     frictionless, grains_on_a_floor, jammed_box, kinetic_energy,
                                     parts_of, pile, problem_of_rows, stored, wall_of_bricks)
from rcr import _kernel


def scaled(problem, mass, speed):
    """The problem with other units of mass and velocity."""
    factors = dict(inverse_mass=1 / mass, free_velocity=speed, bias=speed, impulse=mass * speed)
    changes = {key: factor * problem[key] for key, factor in factors.items()}
    return problem.copy(f"{problem.name} of mass {mass}", **changes)


@pytest.mark.parametrize("change, message", [
    ({"solver": "newton"}, "newton"), ({"tolerance": -1.0}, "tolerance = -1"),
    ({"tolerance": float("nan")}, "tolerance = nan"), ({"threads": 0}, "threads = 0"),
    ({"max_iterations": 0}, "maxIterations = 0"), ({"lanes": 3}, "lanes = 3"),
    *(({"yield_compliance": value}, "yieldCompliance") for value in (-1.0, np.nan)),
    *(({"yield_impulse": value}, "yieldImpulse") for value in (0.0, -1.0, np.nan)),
    ({"reductions": ["islands", "walls"]},
     "reduction 'walls' is not known; expected one of frictionless, discs, fixed, islands"),
])
def test_invalid_settings_are_rejected(change, message):
    refused(message, pile(1).solve, **change)


def test_problem_without_contacts():
    result = pile(1).at_points("none", []).solve("exact", tolerance=1e-10)
    assert result["converged"] and result["residual"] == 0


@pytest.mark.parametrize("name", ["shear-500-eta-0.7", "shear-1000-eta-0"])
def test_auto_runs_exact_steps_for_fine_tolerances(name):
    assert_solved(stored(name).cold(), "auto", 1e-9)


@pytest.mark.parametrize("friction, same", [(0.0, "nesterov"), (0.5, "exact")])
def test_auto_sweeps_without_friction(friction, same):
    problem = pile(1, 30, 30)
    problem["friction"][:] = friction
    settings = dict(tolerance=1e-9, max_iterations=1500)
    auto, other = (problem.solve(solver, **settings) for solver in ("auto", same))
    assert_same_bits(auto, other, same, ("iterations", "impulse"))
    if not friction:
        assert_laws(problem, auto, 1e-9)


def test_iterations_of_auto_bound_its_time():
    """An exact iteration costs about twenty sweeps and must count as twenty iterations."""
    problem = stored("ram_between_slopes").cold()

    def seconds(solver, **settings):
        results = (problem.solve(solver, max_iterations=1000, **settings) for _ in range(5))
        return min(result["processor_seconds"] for result in results)

    exact = seconds("auto", tolerance=2e-6, accuracy=1e-3)
    assert exact < 4 * seconds("nesterov", tolerance=0)


def test_distant_start_adds_no_energy(solver):
    """An unconverged solve from huge impulses must not keep them."""
    problem = frictionless(pile(1))
    problem["bias"][:] = 0
    scale = np.abs(problem.solve("exact")["impulse"]).max()
    start = np.random.default_rng(0).random(len(problem["impulse"]))
    problem["impulse"][:, 0] = 1e3 * scale * start
    found = problem.solve(solver, max_iterations=3, tolerance=1e-8)
    assert not found["converged"]
    free = kinetic_energy(problem, problem["free_velocity"])
    assert kinetic_energy(problem, found["velocity"]) <= free


@pytest.mark.parametrize("iterations", [20, 100, 300])
def test_converged_holds_for_each_island(solver, iterations):
    """The impulses of a light wall vanish in the sums over a scene with heavy grains."""
    parts = grains_on_a_floor(400), scaled(wall_of_bricks(3), 1e-6, 1e-3)
    settings = dict(max_iterations=iterations, accuracy=0.01)
    result = beside(*parts).solve(solver, **settings)
    alone = [part.solve(solver, **settings) for part in parts]
    assert result["converged"] == all(one["converged"] for one in alone)
    assert result["error_estimate"] == max(one["error_estimate"] for one in alone)


@pytest.mark.parametrize("mass", [1, 1e-3, 1e-6])
def test_a_jam_of_light_grains_beside_heavy_grains_yields(solver, mass):
    parts = grains_on_a_floor(400), scaled(jammed_box(3, 6, closing=0.3), mass, 0.1)
    result = beside(*parts).solve(solver, yield_compliance=0.01)
    alone = parts[0].solve(solver)["velocity"]
    assert result["yielded"] and not result["converged"]
    heavy, light = parts_of(result, parts)
    assert abs(light["velocity"]).max() < 1
    np.testing.assert_array_equal(heavy["velocity"], alone)


def pressed_hinged_body(lever):
    """A disc that can only turn; a driven body presses it at this lever."""
    return problem_of_rows("hinged body", [[0, 0, 1.0], [0, 0, 0]], [[0, 0, 0], [0, -1, 0]],
                           [(0, 1, 0, 1, lever, 1, 0, -0.5, 0, 0.3)])


@pytest.mark.parametrize("lever", [0, 1e-17, 1e-13])
def test_a_hinged_body_pressed_through_its_centre_has_no_solution(solver, lever):
    rigid, yielding = (pressed_hinged_body(lever).solve(solver, yield_compliance=c)
                       for c in (0, 0.01))
    assert not rigid["converged"] and yielding["yielded"]
    for found in rigid, yielding:
        assert abs(found["velocity"][0, 2]) < 10, found


def test_a_hinged_body_pressed_at_a_lever_turns(solver):
    found = pressed_hinged_body(0.5).solve(solver, tolerance=1e-10, yield_compliance=0.01)
    assert found["converged"] and not found["yielded"]
    np.testing.assert_allclose(found["relative_velocity"][0, 0], 0, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_a_body_on_a_rail_that_is_struck_gives_way(solver, seed):
    """It moves along x only: w_tt − w_nt²/w_nn is a rounding error. Friction may lock it."""
    rng = np.random.default_rng(seed)
    angle, mu, v = rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 1.2), rng.normal(0, 1, 2)
    n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    problem = problem_of_rows("rail", [[1, 0, 0], [0, 0, 0]], [[0, 0, 0], [*v, 0]],
                              [(0, 1, *n, 0, 0, 0, 0, 0, mu)])
    found = problem.solve(solver, tolerance=1e-10, max_iterations=1000)
    approach, slip = -(v @ n), v @ t - n[0] * t[0] * (v @ n) / n[0] ** 2
    give = n[0] ** 2 - mu * np.sign(slip) * n[0] * t[0]  # u_n over p_n while it slides
    expected = [approach / give, -mu * np.sign(slip) * approach / give]
    if approach > 0 and give < 0.1:  # near the angle of locking, the energy bound refuses
        assert give > 0 or not found["converged"]
    else:
        assert found["converged"]
        np.testing.assert_allclose(found["impulse"][0], expected if approach > 0 else 0, rtol=1e-8)


def column(count, velocities, friction):
    """Discs on top of each other above a floor, with these velocities along y."""
    points = [(k, k + 1, 0, 1, 0, 0.5 if k else 0, 0, -0.5, 0, friction)
              for k in range(count)]
    inverse_mass, velocity = np.tile([1.0, 1, 8], (count + 1, 1)), np.zeros((count + 1, 3))
    inverse_mass[0], velocity[1:, 1] = 0, velocities
    return problem_of_rows("column", inverse_mass, velocity, points)


def pushed(problem, impulse):
    problem["impulse"][:, 0] = impulse
    return problem


@pytest.mark.parametrize("iterations", [1, 3, 10])
def test_impulses_of_islands_that_start_again_from_zero_are_stored(solver, iterations):
    """Discs fly apart, from impulses that push them together."""
    apart = pushed(column(30, 0.1 * np.arange(1, 31), friction=0), 1)
    problem = beside(apart, apart)
    found = problem.solve(solver, max_iterations=iterations)
    problem["impulse"] = found["impulse"]
    assert not found["converged"] or _kernel.residual(**problem) <= 1e-4


@pytest.mark.parametrize("tolerance, make", [
    pytest.param(1e-8, lambda: (pile(1), wall_of_bricks(4, 3, 4), pile(2, 6, 5)), id="three"),
    pytest.param(1e-4, lambda: (column(200, -1.0, friction=0.5), grains_on_a_floor(1200)),
                 id="a small one, which is solved as a small problem"),
    pytest.param(1e-4, lambda: (pile(1), pushed(wall_of_bricks(3, 3, 3), 1e200)), id="overflow"),
])
def test_islands_alone_and_together_get_the_same_impulses(solver, tolerance, make):
    parts = make()
    together = beside(*parts).solve(solver, tolerance=tolerance)
    for problem, own in zip(parts, parts_of(together, parts)):
        alone = problem.solve(solver, tolerance=tolerance)
        np.testing.assert_array_equal(own["impulse"], alone["impulse"], problem.name)
        assert alone["converged"] or solver != "auto"
    assert together["converged"] or solver != "auto"


def test_residual_zero_meets_the_tolerance_zero(solver):
    apart = problem_of_rows("apart", [[0, 0, 0], [1, 1, 8]], [[0, 0, 0], [0, 1, 0]],
                            [(0, 1, 0, 1, 0, 0, 0, -0.5, 0, 0.5)])
    assert apart.solve(solver, tolerance=0, max_iterations=50)["converged"]


def test_residual_of_yielding_contacts_is_that_of_the_given_problem(solver):
    problem = jammed_box(3, 6, closing=0.3)
    problem["recovery_bias"] = np.full(len(problem["bodies"]), -0.01)
    found = problem.solve(solver, yield_compliance=0.01)
    problem["impulse"] = found["impulse"]
    assert found["yielded"]
    del problem["recovery_bias"]
    assert found["residual"] == pytest.approx(_kernel.residual(**problem), rel=1e-9)


@pytest.mark.parametrize("tilt", [0, 1e-8, 1e-5, 1e-3])
def test_a_lid_that_can_hardly_give_way_is_a_jam(tilt):
    """Driven along y and free along x: its tilted contacts could push it aside, very fast."""
    problem, lid = jammed_box(1, 6, closing=0.3), 39
    problem["inverse_mass"][lid] = 1, 0, 0
    at_lid = (problem["bodies"] == lid).any(1)
    sign = np.where(np.arange(at_lid.sum()) % 2, tilt, -tilt)
    problem["normal"][at_lid] = np.column_stack([sign, np.sqrt(1 - sign**2)])
    assert problem.solve("auto", yield_compliance=0.01)["yielded"]
