"""Warnings of scenes that are hardly meant, scenes that get none, and steps that miss."""

import math
import time
import warnings

import numpy as np
import pytest
import rcr
from scenes import (KN, LAWS, build, gaps, grain_on_floor, insert, material, refused, resting,
                    set_state, snapshot, solver, springs, springy, squeezed, stadium, steps, warns,
                    weightless)
from yade import O, utils
from yade import wrapper as w
from yade.wrapper import (DomainLimiter, DragEngine, GlobalStiffnessTimeStepper, LinearDragEngine,
                          PyRunner)


def add(center, **options):
    """Append a grain that is like the one of the scene."""
    O.bodies.append(stadium(0.2, 0.1, center, material=O.bodies[1].material, **options))


def advised(run=O.step):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run()
    return [str(w.message) for w in caught]


@LAWS
def test_initial_overlaps_warn_once(law):
    resting(law)
    add((0.3, 0.15), angle=1.0)
    add((0, 0.26))
    (told,) = advised()
    assert "bodies #1 and #2 overlap by 0." in told
    assert "of R₁ + R₂, before their first step, and 3 more pairs less deeply." in told
    assert ("take back at most 1e-4 R" in told) == (law == "rigid")
    assert ("Springs begin with the force of it" in told) == (law == "smooth")
    assert advised() == []
    add((3, 0.08))
    (told,) = advised()
    assert ("bodies #0 and #4 overlap by 0.02 m, 0.0333 of R₁ + R₂, before their first "
            "step. ") in told


@LAWS
def test_grains_behind_a_wall_warn(law):
    resting(law)
    O.bodies.append(rcr.wall("x", -1, -1, material=O.bodies[1].material))
    add((3, 1))
    (told,) = advised()
    assert ("body #1 and 1 more lie behind a wall, body #2, which acts towards -x only (sense=-1): "
            "it does not hold such a grain, or pushes it across. Set sense=1, or 0") in told


def test_overlaps_of_images_warn():
    places = (1.95, 1.0), (2.1, 3.0), (0.5, 0.5)
    weightless(*(rcr.disc(at, 0.1, material=material()) for at in places), cell=2)
    (told,) = advised()
    assert "bodies #0 and #1 overlap by 0.05 m, 0.25 of R₁ + R₂, before their first step. " in told


def test_time_step_forgotten():
    for law in "rigid", "smooth":
        resting(law)
        O.dt = 1e-8
        assert any("O.dt = 1e-8 s is YADE's default; set it" in told for told in advised())


def planar(make, *arguments):
    """Append a body of YADE that stays in the plane."""
    body = make(*arguments, material=O.bodies[0].material)
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)


def discs(*places):
    O.bodies.append([rcr.disc(at, 0.1, O.bodies[0].material) for at in places])


MASSES = {
    "ball": ("#1, a Sphere, ", lambda: planar(utils.sphere, (0, 1, 0), 0.1)),
    "ball among discs": ("#2, a Sphere, ", lambda: (
        discs((0, 1)), planar(utils.sphere, (0, 2, 0), 0.1))),
    "block": ("#1, a Box, ", lambda: planar(utils.box, (0, 1, 0), (0.3, 0.1, 0.1))),
    "mass of a disc": ("#1, a Sphere, ", lambda: (discs((0, 1)), set_state(mass=5))),
}


@LAWS
@pytest.mark.parametrize("case", MASSES)
def test_a_mass_that_is_not_density_times_area_warns_once(law, case):
    words, make = MASSES[case]
    build(rcr.wall("y", 0, material=springy()), law=law, dt=1e-5)
    assert advised() == []
    make()
    (told,) = advised()
    assert f"body {words}has the mass " in told and "density × area is" in told
    assert advised() == []


@pytest.mark.parametrize("change", [
    lambda clump, members: utils.growParticles(1.1),
    lambda clump, members: O.bodies.erase(members[0]),
    lambda clump, members: O.bodies.clump([5, 6]),
    lambda clump, members: O.bodies.addToClump([5], clump),
    lambda clump, members: O.bodies.releaseFromClump(members[0], clump),
], ids=["growParticles", "erase", "clump", "addToClump", "releaseFromClump"])
@pytest.mark.parametrize("mass", [None, 70])
def test_functions_of_yade_that_change_or_keep_masses_warn(change, mass):
    """A mass that rcr.clump was given is no reason."""
    weightless(rcr.wall("y", 0, material=material()), dt=1e-5)
    row = [rcr.disc((0.1 * k, 1), 0.1, O.bodies[0].material) for k in range(3)]
    clump, members = rcr.clump(row, mass=mass)
    discs((0.41, 1), (0.62, 1))
    assert advised() == []
    change(clump, members)
    # YADE turns clumps to principal axes; a clump out of the plane is refused before it warns
    told = rcr._plugin.advice(rcr.scene.union_area)
    assert sum("density × area is" in text for text in told) == 1


def test_a_change_of_masses_warns_between_runs():
    resting()
    discs((3, 1))
    assert advised() == []
    with warns("growParticles is written for spheres"):
        utils.growParticles(1.01)
    assert sum("#2, a Sphere, has the mass " in text for text in advised()) == 1
    assert advised() == []


def test_masses_that_may_be_chosen_do_not_warn():
    """Of obstacles, of mobile walls and plates; blocks of 1 m depth have that per unit depth."""
    m = material()
    block = utils.box((0, 3, 0), (0.3, 0.1, 0.5), material=m)
    plate = utils.box((0, 5, 0), (0.3, 0.1, 0.1), material=m)
    plate.state.mass = 2.0
    for body in block, plate:
        body.state.blockedDOFs = "zXY"
    weightless(block, plate, rcr.mobile_wall("x", 9, mass=7, material=m),
               utils.sphere((0, 9, 0), 0.1, fixed=True, material=m))
    assert advised() == []
    pair = O.bodies.append([utils.box((0, 12, 0), (0.1, 0.1, 1), material=m),
                            rcr.disc((0, 12.2), 0.1, m)])
    rcr._plugin.planar_clump(pair, 0, 12.1, 50, 1)
    assert advised() == []


@pytest.mark.parametrize("engine", [DragEngine, LinearDragEngine])
def test_a_drag_that_omits_a_grain_warns(engine):
    """YADE's engines act on Spheres only."""
    for ids, says in ([2], []), ([2, 1], ["body #1, which is no Sphere"]):
        resting()
        O.bodies.append(rcr.disc((5, 0.1), 0.1, material=O.bodies[1].material))
        insert(1, engine(ids=ids))
        told = [warning.split(";")[0] for warning in advised()]
        assert told == [f"rcr: {engine.__name__} exerts no force on {end}" for end in says]


def test_a_factory_of_balls_warns():
    resting()
    insert(0, w.BoxFactory(materialId=0, maxParticles=1))
    assert advised() == ["rcr: BoxFactory makes Spheres with the mass of balls, not of discs of "
                         "unit depth; make discs by a PyRunner: O.bodies.append(rcr.disc(…))."]


def test_a_domain_limiter_that_keeps_rods_warns():
    resting()
    O.engines = [*O.engines, DomainLimiter(lo=(-9, -9, -9), hi=(9, 9, 9))]
    assert advised() == ["rcr: DomainLimiter never deletes body #1, which is no Sphere; delete it by "
                         "a PyRunner: O.bodies.erase(id)."]
    O.bodies.erase(1)
    O.bodies.append(rcr.disc((5, 0.1), 0.1))
    assert advised() == []


def test_a_scene_without_overlaps_is_not_warned_of():
    resting()
    rough = O.bodies[1].material
    rcr.clump([stadium(0.2, 0.1, (2, 0.5), material=rough),
               stadium(0.2, 0.1, (2, 0.5), angle=1.5, material=rough)])
    add((0, 0.3))
    add((5, 0.1), mask=2)
    add((5, 0.1), mask=4)
    assert advised() == []


def test_a_time_step_beyond_the_critical_one_warns():
    resting("smooth")
    O.dt = 0.9 * rcr.critical_time_step()
    assert advised() == []
    O.dt = 1.1 * rcr.critical_time_step()
    (told,) = advised()
    assert ("where springs of this stiffness become unstable; set O.dt = 0.5 * "
            "rcr.critical_time_step()") in told
    assert advised() == []
    O.dt = 2
    insert(0, GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.1, defaultDt=1e-6))
    assert advised() == []


@pytest.mark.parametrize("speed, through", [(0.1, False), (1.5, False), (3, True), (30, True)])
def test_springs_too_soft_for_a_blow_warn(speed, through, capfd):
    """A blow on a spring k_n overlaps by v √(m/k_n), after a quarter of the period.

    The limit is a tenth of the cap radius, which a speed of 1.8 m/s reaches.
    """
    disc = grain_on_floor(0, height=0.1005, make=springs, gravity=(0, 0, 0))
    O.bodies[disc].state.vel = (0, -speed, 0)
    steps(math.ceil(0.5 * math.pi * math.sqrt(O.bodies[disc].state.mass / KN) / O.dt))
    told = capfd.readouterr().err
    assert (O.engines[2].lawDispatcher.functors[0].deepOverlapCount > 0) == through
    assert told.count("too soft") == through


def test_forces_after_the_solver_cause_a_warning(capfd):
    """A PyRunner after ContactDynamics presses a grain in; only the overlap shows it."""
    resting()
    insert(-1, PyRunner(command="O.forces.addF(1, (0, -1e5, 0))", iterPeriod=1))
    steps(100)
    told = capfd.readouterr().err
    for words in ("and grows, although all steps converged.", "forces added after ContactDynamics",
                  "Deepest in this step: bodies #0 and #1."):
        assert words in told


# --- numbers of a step

@pytest.mark.parametrize("dt", [1, 30, 1000])
def test_step_that_ends_in_an_overlap_has_not_converged(dt):
    rough = material()
    weightless(stadium(0.2, 0.1, (0, 0), material=rough, velocity=(1.0 / dt, 0),
                       angular_velocity=5.0 / dt),
               stadium(0.2, 0.1, (1.0, 0.1), angle=1.0, material=rough), dt=dt)
    converged = True
    for _ in range(3):
        O.step()  # gaps are those at the beginning of the step
        assert min(gaps(), default=0) > -0.02 * 0.6 or not converged
        converged = solver().converged
    assert O.bodies[1].state.vel.norm() > 0, "they missed"


def test_missed_steps_are_counted_and_the_counts_are_saved(tmp_path):
    rough = material()
    pile = [stadium(0, 0.1, (0.01 * k, 0.1 + 0.2 * k), material=rough) for k in range(6)]
    build(rcr.wall("y", 0, material=rough), *pile, tolerance=1e-13, maxIterations=1, solver="nlgs")
    missed = lambda count: sum(not (O.step() or solver().converged) for _ in range(count))
    counts = lambda: (solver().missedSteps, solver().yieldedSteps, solver().deepestOverlap)
    first, saved = missed(20), counts()
    assert saved[:2] == (first, 0) and first > 0
    O.save(str(tmp_path / "pile.yade"))
    O.load(str(tmp_path / "pile.yade"))
    assert counts() == saved
    second = missed(5)
    assert solver().missedSteps == first + second and second > 0


def test_new_contacts_do_not_visit_all_bodies():
    """The time of a first step, which finds all contacts, grows with their number only."""
    rough = material()

    def first_step(side):
        """Processor time of the first step of side² discs in contact [s]."""
        weightless(*(rcr.disc((0.2 * i, 0.2 * j), 0.1, material=rough) for i in range(side)
                     for j in range(side)), tolerance=1e-2, maxIterations=2)
        before = time.process_time()
        O.step()
        assert O.interactions.countReal() > 1.9 * side * (side - 1)
        return time.process_time() - before

    # The least of three times excludes other load. Nine times the contacts take 9 times as long; a
    # visit of all bodies for each takes 81 times as long.
    few, many = (min(first_step(side) for _ in range(3)) for side in (15, 45))
    assert many < 27 * few


def heavy_discs(**options):
    """Two discs on a floor. Their momentum at 1e300 m/s exceeds the range of doubles."""
    discs = [rcr.particle((0, y), 0.1, 0, material=material()) for y in (0.0999, 0.2998)]
    for disc in discs:
        disc.state.mass, disc.state.inertia = 1e300, (1, 1, 1e298)
    build(rcr.wall("y", 0, sense=1, material=material()), *discs, tolerance=1e-4, **options)
    return discs


def test_a_step_without_a_finite_solution_does_not_change_the_mean_stretch(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    grains = heavy_discs(overdamped=True, trackMeanStretch=True, gravity=(0, -1e300, 0))
    with warns("has the mass 1e.300"):
        refused("would give body #1", O.step, error=RuntimeError)
    for grain in grains:
        grain.state.mass, grain.state.inertia = 1, (1, 1, 1)
    O.engines[-1].gravity = (0, -10, 0)
    with warns("has the mass 1,"):
        O.step()
    assert math.isfinite(solver().model["mean_stretch_rate"][1])


@pytest.mark.parametrize("method", ["nlgs", "nesterov", "exact", "auto"])
def test_a_step_without_a_finite_solution_moves_nothing_and_saves_its_problem(
        method, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heavy_discs(solver=method)[1].state.vel = (0, -1e300, 0)
    before = snapshot()
    with warns("has the mass 1e.300"):
        told = refused(r"would give body #\d .* Nothing has moved\. Its problem is in (.*); "
                       r"rcr\.solve\('.*', warm=True\) replays it", O.step, error=RuntimeError)
    assert np.array_equal(snapshot()[:, :13], before[:, :13])
    path = tmp_path / "not-finite-0.npz"
    assert str(path) in told
    assert rcr.problems.load(path).contacts == solver().contactPoints


@pytest.mark.parametrize("verlet, drive, warned", [
    (0.01, "velocity", 1), (0.01, "engine", 1), (0.01, "combined", 1), (0, "velocity", 0),
    (0.01, "none", 0)])
def test_an_obstacle_that_turns_unseen_by_the_collider_warns_under_springs(verlet, drive, warned):
    weightless(rcr.segment((-0.2, 0), (0.2, 0), material=springy()),
               rcr.disc((0.15, 0.5), 0.01, springy()), law="smooth", dt=2e-5)
    O.engines[1].verletDist = verlet
    if drive == "velocity":
        set_state(0, angVel=(0, 0, 2))
    turning = w.RotationEngine(ids=[0], rotationAxis=(0, 0, 1), angularVelocity=2)
    if drive == "engine":
        insert(0, turning)
    if drive == "combined":
        insert(0, w.CombinedKinematicEngine(ids=[0], comb=[turning]))
    told = advised(lambda: O.run(2, True))
    turns = [text for text in told if "turns about its own centre" in text]
    assert len(turns) == warned, turns
    assert all("put a new InsertionSortCollider(…, verletDist=0)" in text for text in turns)


def test_counts_of_an_engine_begin_anew_with_a_new_scene():
    """A script may give the same engines to a scene after O.reset()."""
    engines = None
    for _ in range(2):
        squeezed()
        engines = engines or O.engines
        O.engines = engines
        O.run(5, True)
        assert solver().yieldedSteps == solver().missedSteps == 5


def test_sizes_of_single_precision_pass_in_silence():
    """Arrays of other programs often hold float32; NumPy warned of their comparison."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        grain = rcr.particle((0, 0), R=np.float32(0.5), eta=np.float16(0.5), material=material())
    assert grain.shape.capRadius == 0.25
    refused("R = inf; expected", rcr.particle, (0, 0), R=np.float32("inf"), eta=0.5)
