"""Steps in arrays (pkg/dem/transfer/ArraySteps.hpp) give the bits of YADE's engines."""

import math
import threading
import time

import numpy as np
import pytest
import rcr
from scenes import (box, build, contact_forces, insert, material, plane, snapshot, solver, stadium,
                    wait_until)
from yade import O, utils
from yade.minieigenHP import Vector3
from yade.wrapper import PyRunner, RotationEngine

STEPS = 600
MOST_STEPS = 100  # steps in arrays before a step of engines updates YADE's objects
SOLVER = dict(tolerance=1e-4, maxIterations=200)
R = 0.05


def grains(count, columns, seed, spheres=False):
    """Grains of all elongations on a lattice, above y = 0."""
    rng = np.random.default_rng(seed)
    rough = material(0.5)
    for k in range(count):
        at = (0.1 + 0.115 * (k % columns) + rng.uniform(0, 0.01), 0.1 + 0.115 * (k // columns))
        if spheres and k % 3 == 0:
            yield rcr.disc(at, rng.uniform(0.7, 1) * R, rough)
        else:
            yield rcr.particle(at, rng.uniform(0.7, 1) * R, rng.uniform(0, 0.8),
                               rng.uniform(0, math.pi), rough)


def walls(width):
    return [rcr.wall(axis, at, sense, material=material(0.5))
            for axis, at, sense in (("x", 0, +1), ("x", width, -1), ("y", 0, +1))]


def run_each(period, function, module=__name__, **options):
    """A PyRunner that calls a function of a test module every `period` steps."""
    return PyRunner(command=f"import {module}; {module}.{function}()", iterPeriod=period, **options)


def pressed():
    """A box of grains under a lid with a constant load, and a driven wall."""
    build(*grains(60, 8, 1), *walls(1.1), rcr.mobile_wall("y", 1.2, 5, -1, material(0)), dt=2e-3,
          **SOLVER)
    O.bodies[61].state.vel = Vector3(-0.05, 0, 0)
    insert(3, rcr.WallStress(wall=63, start=60, end=61, stress=-2000))


def without_inertia():
    """`pressed` without inertia, in a flow."""
    pressed()
    solver().overdamped = True
    solver().flow = plane(0.02, 0.01, -0.01, -0.02)
    O.dt = 5e-3


def in_a_flow_that_follows():
    """`without_inertia` with a flow that the step finds."""
    without_inertia()
    solver().trackMeanStretch = True


def pile():
    """Falling grains, some inserted and erased."""
    build(*grains(30, 6, 2), *walls(3), dt=2e-3, **SOLVER)
    O.engines = [*O.engines, run_each(50, "replace")]


def replace():
    O.bodies.append(rcr.particle((1.0, 1.2), 0.8 * R, 0.4, O.iter, material(0.5)))
    O.bodies.erase(O.iter // 50)


def drum():
    """Boxes that turn about a common centre, with discs and Rcrs inside."""
    sides = [box((0.5 + 0.62 * math.cos(angle), 0.5 + 0.62 * math.sin(angle)), (0.05, 0.3), angle,
                 material(0.5)) for angle in (k * math.pi / 4 for k in range(8))]
    inside = list(grains(36, 6, 3, spheres=True))
    for b in inside:
        b.state.pos += Vector3(0.1, 0.1, 0)
    build(*inside, *sides, dt=1e-3,
          before=[RotationEngine(ids=list(range(36, 44)), rotateAroundZero=True,
                                 rotationAxis=(0, 0, 1), zeroPoint=(0.5, 0.5, 0),
                                 angularVelocity=2)], **SOLVER)


def mixed():
    """Discs and Rcrs fall between walls onto a facet and a fixed box, restitution 0.5."""
    facet = utils.facet([(0.6, 0.05, -1), (0.8, 0.02, -1), (0.7, 0.035, 1)], material=material(0.5))
    build(*grains(48, 6, 4, spheres=True), *walls(0.9),
          box((0.3, 0.05), (0.1, 0.05), 0.3, material(0.5)), facet, dt=1e-3, restitution=0.5,
          **SOLVER)
    for body in range(48):
        O.bodies[body].state.pos += Vector3(0, 0.09, 0)


def shot():
    """Fast discs over and through grains at rest: the neighbour list is repaired around them."""
    build(*grains(160, 20, 7), *walls(2.5),
          *[rcr.disc((0.1 + 0.2 * k, 1.05 + 0.1 * k), 0.3 * R, material(0.5)) for k in range(3)],
          dt=1e-3, **SOLVER)
    for k in range(163, 166):
        O.bodies[k].state.vel = Vector3(6, -3, 0)


def watched():
    """A PyRunner that reads and writes bodies during the run."""
    build(*grains(40, 6, 5), *walls(0.9), dt=2e-3, **SOLVER)
    O.engines = [*O.engines, run_each(37, "stir")]


def stir():
    for b in O.bodies:
        if b.id % 7 == O.iter % 7 and not b.state.blockedDOFs == "xyzXYZ":
            b.state.vel += Vector3(0.1 * math.sin(O.iter) * b.state.pos[0], 0.3, 0)


def cell():
    """A periodic cell under compression and shear; engines take its steps."""
    build(*grains(60, 8, 6), cell=1.0, dt=2e-3, **SOLVER)
    O.cell.velGrad = plane(-0.03, 0.2, 0, -0.03)


SCENES = [pressed, without_inertia, in_a_flow_that_follows, pile, drum, mixed, shot, watched]


def contacts():
    """All data of the contacts, by the ids of their bodies."""
    rows = {}
    for i in O.interactions:
        geom, phys = i.geom, i.phys
        rows[i.id1, i.id2] = (
            geom.points, geom.type, *geom.gap, *geom.along, *geom.position1, *geom.normal1,
            *geom.normal, *geom.contactPoint, geom.refR1, geom.refR2,
            phys.points, *phys.along, *phys.force1, *phys.force2, *phys.normalForce,
            *phys.shearForce, phys.tangensOfFrictionAngle, phys.restitution, i.iterMadeReal,
        )  # fmt: skip
    return rows


def moment():
    return O.iter, O.time, snapshot(), contacts()


def after(scene, arrays, count=STEPS, **attributes):
    """The moment after `count` steps, the one after another step, and the model in between."""
    scene()
    for name, value in dict(attributes, arrays=arrays).items():
        setattr(solver(), name, value)
    O.run(count, True)
    result, model = moment(), dict(solver().model)
    O.step()
    return (*result, *moment()), model


def after_reload(scene, count, folder, **attributes):
    """The moment after `count` steps in arrays, with a reload after half of them."""
    scene()
    for name, value in attributes.items():
        setattr(solver(), name, value)
    O.run(count // 2, True)
    O.save(str(folder / "half.xml.gz"))
    O.load(str(folder / "half.xml.gz"))
    O.run(count - count // 2, True)
    return moment()


def same(one, two):
    return all(np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b
               for a, b in zip(one, two))


@pytest.mark.parametrize("scene", SCENES)
def test_same_bits_as_the_engines(scene):
    expected, by_engines = after(scene, False)
    found, in_arrays = after(scene, True)
    assert by_engines["arrays"] == 0 and by_engines["engines"] == "ContactDynamics.arrays = False"
    assert in_arrays["arrays"] > 0.8 * STEPS
    assert len(expected[3]) > 30
    assert same(found, expected)


@pytest.mark.parametrize("threads, lanes", [(2, 4), (4, 1)])
def test_same_bits_for_threads_and_lanes(threads, lanes):
    expected, _ = after(pressed, True, threads=1, lanes=8)
    found, _ = after(pressed, True, threads=threads, lanes=lanes)
    assert same(found, expected)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [pressed, pile, drum, mixed, cell])
def test_same_bits_in_the_long_run(scene, tmp_path):
    """1000 steps by engines against arrays with all numbers of threads and lanes, and a reload."""
    count = 1000
    expected, _ = after(scene, False, count, threads=1, lanes=8)
    assert len(expected[3]) > 30
    for threads in (1, 2, 4):
        for lanes in (1, 4, 8):  # 8 take 16 floats at a time
            found, model = after(scene, True, count, threads=threads, lanes=lanes)
            assert (model["arrays"] > 0.8 * count) == (scene is not cell)
            assert same(found, expected), (threads, lanes)
    assert same(after_reload(scene, count, tmp_path, threads=2), expected[:4])


@pytest.mark.parametrize("scene", [mixed, in_a_flow_that_follows])
def test_same_bits_after_reload(scene, tmp_path):
    expected, _ = after(scene, True)
    assert same(after_reload(scene, STEPS, tmp_path), expected[:4])


def test_a_run_ends_at_its_step_or_time():
    mixed()
    O.run(17, True)
    assert O.iter == 17 and O.time == pytest.approx(0.017)
    O.stopAtTime = 0.05
    O.run()
    O.wait()
    assert O.time == pytest.approx(0.05, abs=0.5e-3)


def test_pause_takes_hold_within_a_step():
    mixed()
    O.run()
    wait_until(lambda: O.iter > 10)
    O.pause()
    wait_until(lambda: not O.running)
    stopped = O.iter
    time.sleep(0.1)
    assert stopped == O.iter
    assert all(math.isfinite(x) for b in O.bodies for x in b.state.pos)


def test_a_velocity_written_during_a_run_stays():
    """A velocity that a console sets during a run is not overwritten from the arrays.

    A step of engines may overwrite it, as in every YADE scene, so that it is set up to 20 times.
    """
    build(stadium(0.1, 0.05, (0, 1)), stadium(0.1, 0.05, (0, 2)), *walls(3)[2:], gravity=(0, 0, 0),
          dt=1e-5, **SOLVER)
    for body in (0, 1):
        O.bodies[body].state.vel = Vector3(1, 0, 0)
    O.run()
    wait_until(lambda: O.iter > 10)
    for _ in range(20):
        O.bodies[0].state.vel = Vector3(7, 0, 0)
        written = O.iter
        wait_until(lambda: O.iter > written + 3 * MOST_STEPS)
        if O.bodies[0].state.vel[0] == 7:
            break
    O.pause()
    O.wait()
    one, two = (O.bodies[body].state for body in (0, 1))
    assert one.vel[0] == 7 and two.vel[0] == 1
    assert two.pos[0] == pytest.approx(O.time) and one.pos[0] > two.pos[0]


@pytest.mark.parametrize("change, reason", [
    (lambda: setattr(O, "trackEnergy", True), "O.trackEnergy"),
    (lambda: setattr(solver(), "arrays", False), "ContactDynamics.arrays = False"),
    (lambda: insert(5, PyRunner(command="pass", iterPeriod=1)), "the end of the run"),
])  # fmt: skip
def test_the_model_has_the_reason_for_steps_of_engines(change, reason):
    mixed()
    change()
    O.run(20, True)
    assert (solver().model["arrays"], solver().model["engines"]) == (0, reason)
    O.trackEnergy = False


def least_in_arrays(count):
    """Least steps in arrays of an uninterrupted run: engines take the last and one in 100."""
    return count - 1 - count // MOST_STEPS


def test_an_error_leaves_the_scene_as_the_step_began():
    """An error during steps in arrays reaches the script; the scene can continue."""
    mixed()
    O.run(50, True)
    insert(-1, PyRunner(command="raise RuntimeError('enough')", iterPeriod=80))
    with pytest.raises(RuntimeError, match="enough"):
        O.run(200, True)
    assert O.iter == 130 and np.isfinite(snapshot()).all() and contact_forces()


@pytest.mark.parametrize("period", [1, 2, 7, 50])
def test_forces_that_a_script_adds_now_and_then_act(period):
    """A force added by a PyRunner in the first step of a series in arrays acts."""
    speeds = []
    for arrays in (True, False):
        build(*[stadium(0.2, 0.1, (k, 5), material=material(0)) for k in range(2)],
              before=[PyRunner(command="O.forces.addF(0, (2, 0, 0)); O.forces.addT(1, (0, 0, 1))",
                               iterPeriod=period)])
        solver().arrays = arrays
        O.run(150, True)
        speeds.append((O.bodies[0].state.vel[0], O.bodies[1].state.angVel[2]))
    assert speeds[0] == speeds[1] and min(speeds[0]) > 0


def test_a_history_is_kept_without_a_stop():
    """One run returns the history of many short runs, to the bit."""
    ids = [3, 60, 61, 63]
    pressed()
    short = solver()
    short.observe = ids
    expected = []
    for _ in range(5):
        O.run(20, True)
        seen = short.observed()
        seen.update(step=O.iter, time=O.time, points=short.contactPoints,
                    last_iterations=short.iterations, last_residual=short.residual)
        seen["positions"] = {i: (O.bodies[i].state.pos[0], O.bodies[i].state.pos[1]) for i in ids}
        expected.append(seen)
    pressed()
    long = solver()
    long.observe, long.observeEvery = ids, 20
    O.run(110, True)
    assert long.model["arrays"] >= least_in_arrays(110) and long.observed()["steps"] == 10
    assert long.observations() == expected
    assert long.observations() == []


def test_observe_every_is_a_number_of_steps():
    pressed()
    solver().observeEvery = -1
    with pytest.raises(ValueError, match="ContactDynamics.observeEvery = -1; expected a "
                       "number of steps"):
        O.run(1, True)


def test_advance_is_one_run():
    """advance makes one run: pieces of 0.2 s would each gather all bodies."""
    pressed()
    assert rcr.advance(300)
    assert O.iter == 300 and solver().model["arrays"] >= least_in_arrays(300)
    shown = []
    assert rcr.advance(100, until=lambda: shown.append(O.iter) or O.iter >= 360, every=20)
    assert shown == [320, 340, 360] and O.iter == 360
    for count in (0, 1.5, None):
        with pytest.raises(ValueError, match="steps = "):
            rcr.advance(count)


def test_arrays_count_steps_and_speed_as_yade_does():
    """O.speed is the mean rate of the last ten steps; O.timingEnabled counts every engine."""
    pressed()
    speeds = []
    O.timingEnabled = True
    try:
        for _ in range(5):  # other load may delay ten steps
            counts = [engine.execCount for engine in O.engines]
            began = time.monotonic()
            O.run(290, True)
            speeds.append(O.speed * (time.monotonic() - began) / 290)
            counts = [engine.execCount - count for engine, count in zip(O.engines, counts)]
            assert counts == [290] * len(counts)
            assert solver().model["arrays"] >= least_in_arrays(290)
    finally:
        O.timingEnabled = False
    assert max(speeds) > 0.5  # the first steps are the longest; engines take one in 100


def test_an_engine_ends_advance():
    pressed()
    O.engines = [*O.engines, PyRunner(iterPeriod=7, firstIterRun=7, command="O.pause()")]
    assert rcr.advance(50) and O.iter == 8


def test_a_change_of_observed_bodies_starts_a_new_mean():
    """Each entry holds the bodies and steps of one observation."""
    pressed()
    watched = solver()
    watched.observe, watched.observeEvery = [3], 100
    O.run(175, True)
    watched.observe = [3, 60]
    O.run(125, True)
    first, second = watched.observations()
    assert set(first["forces"]) == set(first["positions"]) == {3} and first["steps"] == 100
    assert set(second["forces"]) == set(second["positions"]) == {3, 60}
    assert (second["steps"], second["step"]) == (100, 275)
    assert watched.observed()["steps"] == 25


def test_an_observed_body_that_is_erased():
    """The history leaves out its position; the next step raises."""
    pressed()
    watched = solver()
    watched.observe, watched.observeEvery = [5, 60], 50
    O.run(100, True)
    O.bodies.erase(5)
    first, second = watched.observations()
    assert set(first["positions"]) == set(second["forces"]) == {5, 60}
    assert set(second["positions"]) == {60}
    with pytest.raises(RuntimeError, match="ContactDynamics.observe holds 5, a body that was "
                       "erased; remove the id"):
        O.run(10, True)
    watched.observe = [60]
    O.run(60, True)
    assert len(watched.observations()) == 1


def test_a_member_of_a_clump_is_not_observed():
    """Its contacts act on the clump, so the member is rejected."""
    build(rcr.wall("y", 0, +1), dt=1e-3)
    clump, (member, _) = rcr.clump([rcr.particle((0, 0.1), R, 0.5),
                                    rcr.particle((0, 0.1), R, 0.5, math.pi / 2)])
    solver().observe = [member]
    with pytest.raises(RuntimeError, match=f"observe holds {member}, a member of clump "
                       f"{clump}; its contacts act on the clump"):
        O.run(2, True)


def test_advance_beside_another_run_is_refused():
    """It would end the other run, or wait for the run of the engine that calls it."""
    pressed()
    O.engines = [*O.engines,
                 PyRunner(iterPeriod=5, firstIterRun=5, command="import rcr; rcr.advance(3)")]
    with pytest.raises(RuntimeError, match="rcr.advance: a run is active"):
        O.run(20, True)


def test_advance_in_a_thread():
    """Only the main thread receives signals."""
    pressed()
    done = []
    thread = threading.Thread(target=lambda: done.append(rcr.advance(30)))
    thread.start()
    thread.join()
    assert done == [True] and O.iter == 30
