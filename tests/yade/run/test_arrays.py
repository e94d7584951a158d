"""Steps in arrays (ArraySteps.hpp) give the bits of YADE's engines, also while scripts act."""

import concurrent.futures
import math
import time

import numpy as np
import pytest
import rcr
import run_fuzzer
import scenes
from scenes import (G, box, build, calls, contact_forces, exchange, grain_on_floor, insert,
                    material, plane, refused, set_state, snapshot, solver, stadium, steps,
                    wait_until, warns, weightless)
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Matrix3, Quaternion

STEPS = 600
MOST_STEPS = 100  # steps in arrays before a step of engines updates YADE's objects
SOLVER = dict(tolerance=1e-4, maxIterations=200)
R = 0.05


def grains(count, columns, seed, spheres=False, shift=(0, 0)):
    """Grains of all elongations, a third of them discs if `spheres`, on a shifted lattice."""
    rng = np.random.default_rng(seed)
    rough = material(0.5)
    for k in range(count):
        at = (0.1 + 0.115 * (k % columns) + rng.uniform(0, 0.01) + shift[0],
              0.1 + 0.115 * (k // columns) + shift[1])
        if spheres and k % 3 == 0:
            yield rcr.disc(at, rng.uniform(0.7, 1) * R, rough)
        else:
            yield rcr.particle(at, rng.uniform(0.7, 1) * R, rng.uniform(0, 0.8),
                               rng.uniform(0, math.pi), rough)


def box_of(width):
    return scenes.walls(material(0.5), x=(0, width), y=[0])


def pressed():
    """A box of grains under a lid with a constant load, and a driven wall."""
    build(*grains(60, 8, 1), *box_of(1.1), rcr.mobile_wall("y", 1.2, 5, -1, material(0)), dt=2e-3,
          **SOLVER)
    set_state(61, vel=(-0.05, 0, 0))
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
    build(*grains(30, 6, 2), *box_of(3), dt=2e-3, **SOLVER)
    insert(9, calls(replace, 50))


def replace():
    O.bodies.append(rcr.particle((1.0, 1.2), 0.8 * R, 0.4, O.iter, material(0.5)))
    O.bodies.erase(O.iter // 50)


def drum():
    """Boxes that turn about a common centre, with discs and Rcrs inside."""
    sides = [box((0.5 + 0.62 * math.cos(angle), 0.5 + 0.62 * math.sin(angle)), (0.05, 0.3), angle,
                 material(0.5)) for angle in (k * math.pi / 4 for k in range(8))]
    turn = w.RotationEngine(ids=list(range(36, 44)), rotateAroundZero=True, angularVelocity=2,
                            rotationAxis=(0, 0, 1), zeroPoint=(0.5, 0.5, 0))
    build(*grains(36, 6, 3, spheres=True, shift=(0.1, 0.1)), *sides, before=[turn], **SOLVER)


def mixed():
    """Discs and Rcrs fall between walls onto a facet and a fixed box, restitution 0.5."""
    facet = utils.facet([(0.6, 0.05, -1), (0.8, 0.02, -1), (0.7, 0.035, 1)], material=material(0.5))
    build(*grains(48, 6, 4, spheres=True, shift=(0, 0.09)), *box_of(0.9),
          box((0.3, 0.05), (0.1, 0.05), 0.3, material(0.5)), facet, restitution=0.5, **SOLVER)


def shot():
    """Fast discs over and through grains at rest: the neighbour list is repaired around them."""
    discs = [rcr.disc((0.1 + 0.2 * k, 1.05 + 0.1 * k), 0.3 * R, material(0.5), velocity=(6, -3))
             for k in range(3)]
    build(*grains(160, 20, 7), *box_of(2.5), *discs, **SOLVER)


def add_clumps(count, height):
    """Turning clumps of a disc and an Rcr that overlap, above the other grains."""
    rough = material(0.5)
    for k in range(count):
        x, y = 0.15 + 0.2 * (k % 4), height + 0.2 * (k // 4)
        clump, _ = rcr.clump([rcr.disc((x - 0.03, y), 0.04, rough),
                              rcr.particle((x + 0.03, y), R, 0.5, k, rough)])
        set_state(clump, angVel=(0, 0, k - 3), vel=(0.1 * k, 0, 0))
        O.bodies[clump].state.blockedDOFs = "zXYZ" if k == 5 else "zXY"


def clumps():
    """Clumps among discs and Rcrs; engines load a member and drive a clump."""
    build(*grains(24, 6, 8, spheres=True, shift=(0, 0.1)), *box_of(0.9), restitution=0.3, **SOLVER)
    add_clumps(12, 0.8)
    pushed, driven = O.bodies[28].id, next(b.id for b in reversed(list(O.bodies)) if b.isClump)
    set_state(driven, blockedDOFs="xyzXYZ", vel=(0, 0, 0), angVel=(0, 0, 0))
    insert(1, w.ForceEngine(ids=[pushed], force=(30, 60, 0)),
           w.RotationEngine(ids=[driven], rotationAxis=(0, 0, 1), angularVelocity=3))


def packing_in_a_cell():
    """Discs and Rcrs that are pressed together within half of the steps."""
    weightless(*grains(60, 8, 6, spheres=True), cell=0.93, dt=2e-3, restitution=0.3, **SOLVER)


def cell():
    """A periodic cell under compression and shear."""
    packing_in_a_cell()
    O.cell.velGrad = plane(-0.4, 0.3, 0, -0.35)


def resting_cell():
    """A cell at rest with moving grains, a fixed one and a segment."""
    build(*grains(48, 8, 6), rcr.particle((0.5, 0.9), R, 0.5, fixed=True),
          rcr.segment((0.1, 0.85), (0.25, 0.9)), cell=1.0, dt=2e-3, restitution=0.5, **SOLVER)
    for k in range(48):
        set_state(k, vel=(math.sin(k), math.cos(5 * k), 0), angVel=(0, 0, k % 5))


def pressed_cell():
    """A sheared cell under CellStress."""
    packing_in_a_cell()
    O.cell.velGrad = plane(-0.1, 0.2, 0, -0.1)
    insert(3, rcr.CellStress(stress=(100, 60)))


def flipping_cell():
    """A cell that flips in a shear, with the first term of its motion only."""
    cell()
    O.cell.hSize = Matrix3(0.93, 0.42, 0, 0, 0.93, 0, 0, 0, 0.93)
    O.cell.flipFlippable, O.cell.homoDeform = True, 1


def cell_without_inertia():
    packing_in_a_cell()
    O.cell.velGrad = plane(-0.4, 0.2, 0, 0)
    insert(3, rcr.CellStress(stress=(math.nan, 60)))
    solver().overdamped = True


def clumps_in_a_cell():
    """Clumps in a sheared cell, with energies."""
    weightless(*grains(24, 8, 8, spheres=True), cell=0.93, dt=2e-3, restitution=0.5, **SOLVER)
    add_clumps(12, 0.45)
    O.cell.velGrad = plane(-0.4, 0.3, 0, -0.4)
    O.trackEnergy = True


def tracked(scene):
    """The scene with energies."""

    def track():
        scene()
        O.trackEnergy = True

    track.__name__ = f"{scene.__name__} tracked"
    return track


CELLS = [cell, resting_cell, pressed_cell, flipping_cell, cell_without_inertia, clumps_in_a_cell]
SCENES = [pressed, without_inertia, in_a_flow_that_follows, pile, drum, mixed, shot, clumps, *CELLS,
          *map(tracked, [pressed, without_inertia, pile, mixed, clumps, *CELLS[:5]])]


def after(scene, arrays, count=STEPS, reload="", **attributes):
    """The state after `count` steps, reloaded half-way if `reload`, a step later, the model."""
    scene()
    for name, value in dict(attributes, arrays=arrays).items():
        setattr(solver(), name, value)
    O.run(count // 2 if reload else count, True)
    if reload:
        O.save(str(reload))
        O.load(str(reload))
        O.run(count - count // 2, True)
    result, model = run_fuzzer.state(), dict(solver().model)
    O.step()
    return (result, run_fuzzer.state()), model


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.__name__)
def test_same_bits_as_the_engines(scene):
    """Most steps in arrays."""
    expected, by_engines = after(scene, False)
    found, in_arrays = after(scene, True)
    assert by_engines["array_steps"] == 0
    assert by_engines["engines"] == "ContactDynamics.arrays = False"
    assert in_arrays["array_steps"] > 0.8 * STEPS and len(expected[0]["contacts"]) > 30
    assert found == expected


def lattice(obstacle):
    """Rods at rest, which renew no list, below an obstacle that meets some after its change."""
    rough = material(0.5)
    obstacle.material = rough
    weightless(*(rcr.particle((0.15 * (k % 8), 0.15 * (k // 8)), R, 0.5, material=rough)
                 for k in range(40)), obstacle, **SOLVER)
    insert(9, calls(change_obstacle, 100, firstIterRun=100, nDo=1))


def change_obstacle():
    for holder, values in zip((O.bodies[-1].shape, O.bodies[-1].state), CHANGE):
        for name, value in values.items():
            setattr(holder, name, value)


CHANGE = []  # of the shape and the state of the obstacle
TOP = 0.6 + 0.48 * R  # within the upper row of rods
FIELDS = {  # of PlanarShape: an obstacle, and a change of its shape and state
    "kind": (lambda: utils.wall((0, TOP, 5), 2, sense=-1), dict(axis=1)),
    "axis": (lambda: utils.wall((3.0, TOP, 0), 0, sense=-1), dict(axis=1)),
    "length of a box": (lambda: box((0.6, TOP + 0.3), (0.2, 0.1), math.pi / 2, material()),
                        dict(extents=(0.3, 0.1, 1))),
    "width of a box": (lambda: box((0.6, TOP + 0.3), (0.2, 0.1), 0, material()),
                       dict(extents=(0.2, 0.3, 1))),
    "length of a rod": (lambda: rcr.particle((0.6, TOP + 0.3), 0.2, 0.5, math.pi / 2, fixed=True),
                        dict(halfLength=0.2)),
    "width of a rod": (lambda: rcr.particle((0.6, TOP + 0.3), 0.2, 0.5, fixed=True),
                       dict(capRadius=0.3)),
    "radius of a disc": (lambda: rcr.disc((0.6, TOP + 0.3), 0.2, fixed=True), dict(radius=0.3)),
    "place of a segment": (lambda: rcr.segment((0, 2), (1, 2)), {}, dict(pos=(0.5, TOP, 0))),
    "direction of a segment": (lambda: rcr.segment((0.3, TOP + 0.3), (0.9, TOP + 0.3)), {},
                               dict(ori=Quaternion((0, 0, 1), math.pi / 2))),
}


@pytest.mark.parametrize("field", FIELDS)
def test_a_changed_shape_renews_the_list_of_pairs(field):
    make, *CHANGE[:] = FIELDS[field]
    expected, _ = after(lambda: lattice(make()), False, 200)
    found, in_arrays = after(lambda: lattice(make()), True, 200)
    assert in_arrays["array_steps"] > 100
    assert any(40 in row[:2] for row in expected[0]["contacts"])
    assert found == expected


FALL = dict(count=40, kinds=["Rcr", "Sphere"], gravity=9.81, dt=1e-3, solver="auto", speed=0.5,
            overdamped=False, turning=False, motion="none", blocked=0, violent=0, events=[],
            periodic=False, cell_stress=0, flip=False, runs=[STEPS, 1])


CHANGES = {
    "shaken wall": dict(floor="Wall", motion="HarmonicMotionEngine", motion_at=0),
    "shaken box": dict(floor="Box", motion="HarmonicMotionEngine", motion_at=0),
    "shaken box after the loop": dict(floor="Box", motion="HarmonicMotionEngine"),
    "torque on grains": dict(motion="TorqueEngine", motion_at=1),
    "stirrer": dict(motion="RotationEngine", turning=True, motion_at=0),
    "drag on fast grains": dict(motion="LinearDragEngine", speed=20.0, motion_at=1),
    "two shaken grains": dict(motion="shakers"),
    "kicked before the collider": dict(events=[dict(event="kick", at=10, every=7, place="first")]),
    "masks that change": dict(events=[dict(event="mask", at=50, every=7, place="last")]),
    "watched and kicked": dict(events=[dict(event=event, at=37, every=37, place="last")
                                       for event in ("look", "kick")]),
}  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_same_bits_under_engines_and_scripts(changes, seed):
    drag = changes.get("motion") == "LinearDragEngine"
    with warns("LinearDragEngine exerts no force", when=drag):
        found, in_arrays = run_fuzzer.difference({**run_fuzzer.draw(seed), **FALL, **changes})
    assert found == "same" and in_arrays > 0.3 * STEPS


@pytest.mark.parametrize("scene", [pressed, clumps_in_a_cell])
@pytest.mark.parametrize("threads, lanes", [(2, 4), (4, 1)])
def test_same_bits_for_threads_and_lanes(scene, threads, lanes):
    expected, _ = after(scene, True, threads=1, lanes=8)
    found, _ = after(scene, True, threads=threads, lanes=lanes)
    assert found == expected


@pytest.mark.slow
@pytest.mark.parametrize("scene, count", [
    *((scene, 1000) for scene in (pressed, pile, drum, mixed, clumps, pressed_cell)),
    (cell, 600)])  # its compression jams at step 654
def test_same_bits_in_the_long_run(scene, count, tmp_path):
    """Steps by engines against arrays with all numbers of threads and lanes, and a reload."""
    expected, _ = after(scene, False, count, threads=1, lanes=8)
    assert len(expected[0]["contacts"]) > 30
    for threads in (1, 2, 4):
        for lanes in (1, 4, 8):  # 8 take 16 floats at a time
            found, model = after(scene, True, count, threads=threads, lanes=lanes)
            assert model["array_steps"] > 0.8 * count
            assert found == expected, (threads, lanes)
    found, _ = after(scene, True, count, tmp_path / "half.xml.gz", threads=2)
    assert found == expected


@pytest.mark.parametrize("scene", [mixed, in_a_flow_that_follows])
def test_same_bits_after_reload(scene, tmp_path):
    expected, _ = after(scene, True)
    assert after(scene, True, reload=tmp_path / "half.xml.gz")[0] == expected


SEEN = []


def see():
    SEEN.append(O.iter)


@pytest.mark.parametrize("arrays", [True, False])
def test_a_dead_solver_delays_no_engine(arrays):
    mixed()
    solver().arrays = arrays
    insert(3, rcr.ContactDynamics(dead=True), calls(see, 10))
    SEEN.clear()
    O.run(41, True)
    assert SEEN == [10, 20, 30, 40]


def test_a_run_ends_at_its_step_or_time_or_by_a_pause():
    mixed()
    O.run(17, True)
    assert O.iter == 17 and O.time == pytest.approx(0.017)
    O.stopAtTime = 0.05
    O.run()
    O.wait()
    assert O.time == pytest.approx(0.05, abs=0.5e-3)
    O.stopAtTime = 0
    O.run()
    wait_until(lambda: O.iter > 60)
    O.pause()
    wait_until(lambda: not O.running)
    stopped = O.iter
    time.sleep(0.1)
    assert stopped == O.iter
    assert all(math.isfinite(x) for b in O.bodies for x in b.state.pos)


def test_a_velocity_written_during_a_run_stays():
    """Steps in arrays keep it; a step of engines may not, so that it is set up to 20 times."""
    weightless(*(stadium(0.1, 0.05, (0, y), velocity=(1, 0)) for y in (1, 2)), *box_of(3)[2:],
               dt=1e-5, **SOLVER)
    O.run()
    wait_until(lambda: O.iter > 10)
    for _ in range(20):
        set_state(0, vel=(7, 0, 0))
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
    (lambda: setattr(O.engines[-1], "mask", 1), "NewtonIntegrator.mask"),
    (lambda: setattr(solver(), "arrays", False), "ContactDynamics.arrays = False"),
    (lambda: insert(5, w.PyRunner(command="pass", iterPeriod=1)), "the end of the run"),
])  # fmt: skip
def test_the_model_has_the_reason_for_steps_of_engines(change, reason):
    mixed()
    change()
    O.run(20, True)
    assert (solver().model["array_steps"], solver().model["engines"]) == (0, reason)


def least_in_arrays(count):
    """Least steps in arrays of an uninterrupted run: engines take the last and one in 100."""
    return count - 1 - count // MOST_STEPS


def test_an_error_leaves_the_scene_as_the_step_began():
    mixed()
    O.run(50, True)
    insert(-1, w.PyRunner(command="raise RuntimeError('enough')", iterPeriod=80))
    refused("enough", O.run, 200, True, error=RuntimeError)
    assert O.iter == 130 and np.isfinite(snapshot()).all() and contact_forces()


@pytest.mark.parametrize("period", [1, 2, 7, 50])
def test_forces_that_a_script_adds_now_and_then_act(period):
    speeds = []
    for arrays in (True, False):
        build(*[stadium(0.2, 0.1, (k, 5), material=material(0)) for k in range(2)],
              before=[w.PyRunner(command="O.forces.addF(0, (2, 0, 0)); O.forces.addT(1, (0, 0, 1))",
                                 iterPeriod=period)])
        solver().arrays = arrays
        O.run(150, True)
        speeds.append((O.bodies[0].state.vel[0], O.bodies[1].state.angVel[2]))
    assert speeds[0] == speeds[1] and min(speeds[0]) > 0


def observed(ids, every):
    pressed()
    watched = solver()
    watched.observe, watched.observeEvery = ids, every
    return watched


def test_a_history_is_kept_without_a_stop():
    """One run returns the history of many short runs, to the bit."""
    ids = [3, 60, 61, 63]
    short, expected = observed(ids, 0), []
    for _ in range(5):
        O.run(20, True)
        seen = short.observed()
        seen.update(step=O.iter, time=O.time, points=short.contactPoints,
                    last_iterations=short.iterations, last_residual=short.residual)
        seen["positions"] = {i: (O.bodies[i].state.pos[0], O.bodies[i].state.pos[1]) for i in ids}
        expected.append(seen)
    long = observed(ids, 20)
    O.run(110, True)
    assert long.model["array_steps"] >= least_in_arrays(110) and long.observed()["steps"] == 10
    assert long.observations() == expected
    assert long.observations() == []


def test_each_entry_of_a_history_has_its_number_of_steps():
    """Also after steps before `observeEvery`, and if a script reads means meanwhile."""
    watched = observed([3], 0)
    O.run(130, True)
    watched.observeEvery = 100
    for _ in range(5):
        O.run(60, True)
        watched.observed()
    entries = watched.observations()
    assert [(entry["step"], entry["steps"]) for entry in entries] == [
        (230, 100), (330, 100), (430, 100)]


def test_means_continue_after_a_reset_of_the_time():
    watched = observed([3], 0)
    O.run(100, True)
    O.resetTime()
    O.run(50, True)
    assert watched.observed()["steps"] == 150


def test_positions_of_an_entry_are_those_at_its_end():
    watched = observed([3], 50)
    O.run(50, True)
    at = tuple(O.bodies[3].state.pos)[:2]
    O.bodies[3].state.pos = (0, 50, 0)
    assert watched.observations()[0]["positions"][3] == at
    # another scene does not replace them either
    O.bodies[3].state.pos = (*at, 0)
    O.run(50, True)
    at, engines = tuple(O.bodies[3].state.pos)[:2], O.engines
    pressed()
    O.engines = engines
    O.run(10, True)
    assert watched.observations()[0]["positions"][3] == at


def test_advance_is_one_run():
    """advance makes one run: pieces of 0.2 s would each gather all bodies. An engine may end it."""
    pressed()
    assert rcr.advance(300)
    assert O.iter == 300 and solver().model["array_steps"] >= least_in_arrays(300)
    shown = []
    assert rcr.advance(100, until=lambda: shown.append(O.iter) or O.iter >= 360, every=20)
    assert shown == [320, 340, 360] and O.iter == 360
    for count in (0, 1.5, None):
        refused("steps = ", rcr.advance, count)
    with concurrent.futures.ThreadPoolExecutor() as threads:  # receive no signals
        assert threads.submit(rcr.advance, 30).result() is True and O.iter == 390
    insert(9, w.PyRunner(iterPeriod=7, firstIterRun=397, command="O.pause()"))
    assert rcr.advance(50) and O.iter == 398
    # beside another run it would end that run, or wait for the run of the engine that calls it
    insert(9, w.PyRunner(iterPeriod=5, firstIterRun=400, command="import rcr; rcr.advance(3)"))
    refused("rcr.advance: a run is active", O.run, 20, True, error=RuntimeError)


def test_arrays_count_steps_and_speed_as_yade_does(monkeypatch):
    """O.speed is the mean rate of the last ten steps; O.timingEnabled counts every engine."""
    pressed()
    monkeypatch.setattr(O, "timingEnabled", True)
    began = time.monotonic()
    O.run(290, True)
    rate = 290 / (time.monotonic() - began)
    assert [engine.execCount for engine in O.engines] == [290] * len(O.engines)
    assert solver().model["array_steps"] >= least_in_arrays(290)
    assert O.speed > 0.01 * rate  # without a count of steps in arrays, YADE's rate is 1 or less


def test_a_change_of_observed_bodies_starts_a_new_mean():
    """Each entry holds the bodies and steps of one observation."""
    watched = observed([3], 100)
    O.run(175, True)
    watched.observe = [3, 60]
    O.run(125, True)
    first, second = watched.observations()
    assert set(first["forces"]) == set(first["positions"]) == {3} and first["steps"] == 100
    assert set(second["forces"]) == set(second["positions"]) == {3, 60}
    assert (second["steps"], second["step"]) == (100, 275)
    assert watched.observed()["steps"] == 25
    # an observed body is erased: the next step raises
    watched = observed([5, 60], 50)
    O.run(100, True)
    O.bodies.erase(5)
    first, second = watched.observations()
    assert set(first["positions"]) == set(second["forces"]) == {5, 60}
    assert set(second["positions"]) == {5, 60}  # those at its end
    refused("ContactDynamics.observe holds 5, a body that was erased; remove the id", O.run, 10,
            True, error=RuntimeError)
    watched.observe = [60]
    O.run(60, True)
    assert len(watched.observations()) == 1


def add_force():
    first = next(k for k, engine in enumerate(O.engines) if isinstance(engine, w.ForceResetter))
    insert(first + 1, w.ForceEngine(ids=[1], force=(20, 0, 0)))


@pytest.mark.parametrize("arrays", [False, True])
@pytest.mark.parametrize("place", [0, 3, 5])
def test_engines_set_during_a_run_act(arrays, place):
    """YADE applies the new list of a PyRunner at the next step."""
    weightless(*(rcr.disc((x, 0), 0.05, material(0.5)) for x in (0, 1)), **SOLVER)
    solver().arrays = arrays
    insert(place, calls(add_force, 1000, firstIterRun=100, nDo=1))
    O.run(300, True)
    moved = O.bodies[1].state.pos[0] - 1
    acceleration = 20 / O.bodies[1].state.mass
    steps = O.bodies[1].state.vel[0] / (acceleration * O.dt)
    assert 198 <= round(steps) <= 201
    assert moved == pytest.approx(acceleration * O.dt**2 * steps * (steps + 1) / 2)


def test_python_reads_everything_during_a_run():
    """Results, settings and observations are locked, so any thread may access them."""
    rough = material(0.5)
    resting = [rcr.particle((0.025 * (k % 6), 0.03 * (k // 6)), 0.01, 0.5, k, rough)
               for k in range(30)]
    build(*resting, rcr.wall("y", -0.02, +1, material=rough), dt=1e-4)
    engine = solver()
    engine.observe, engine.observeEvery = [30], 10
    O.run()
    reads = 0
    while reads < 100 or O.iter < 1000:
        assert O.running
        engine.solver = ("auto", "nesterov")[reads % 2]
        assert engine.solver in ("auto", "nesterov") and engine.model["bodies"] <= 31
        seconds, entries = engine.seconds, engine.observations()
        assert all(value > -1e-3 for value in seconds.values())
        assert all(entry["steps"] == 10 and set(entry["forces"]) == {30} for entry in entries)
        engine.observed()
        results = {name: getattr(engine, name) for name in dir(engine) if name[0] != "_"}
        assert results["residual"] >= 0 and results["missedSteps"] <= O.iter
        reads += 1
    O.pause()
    O.wait()


def test_an_engine_begins_anew_in_another_scene():
    """Its means and its energies belong to one scene; YADE's account is that of the new one."""
    grain_on_floor(0, restitution=0.5, height=0.2)
    watched = solver()
    watched.observe = [0, 0]  # it counts once
    O.trackEnergy = True
    steps(200)
    O.reset()
    grain_on_floor(0)
    exchange(watched)
    O.trackEnergy = True
    steps(20)
    seen = watched.observed()
    assert seen["steps"] == 20
    assert seen["forces"][0][1] == pytest.approx(-O.bodies[1].state.mass * G)
    assert O.energy["impactDissip"] == pytest.approx(0, abs=1e-9)


def test_a_body_that_the_integrator_leaves_out_is_at_rest():
    """Its state keeps a velocity; a disc with e = 0.5 bounces off it as off a wall."""
    weightless(rcr.disc((0, 0), 0.1, material(0), velocity=(-3, 0), mask=2),
               rcr.disc((0.25, 0), 0.1, material(0), velocity=(-1, 0), mask=3), restitution=0.5)
    O.engines[-1].mask = 1
    steps(200)
    assert O.bodies[1].state.vel[0] == pytest.approx(0.5)


def test_forces_of_contacts_are_those_of_their_points_after_an_error():
    """A jam stops the run within steps in arrays."""
    weightless(*scenes.walls(material(0.4), x=(0, 0.2), y=[0]),
               rcr.wall("y", 0.21, -1, velocity=-0.1, material=material(0.4)),
               *(rcr.particle((0.0125 + 0.025 * i, 0.0125 + 0.025 * j), 0.0124, 0.1, 0.4 * i + j,
                              material(0.4)) for i in range(8) for j in range(8)), **SOLVER)
    refused("jam", O.run, 1000, True, error=RuntimeError)
    assert solver().model["array_steps"] > 0
    for i in O.interactions:
        own = i.phys.force1[0] + i.phys.force2[0]
        assert i.phys.normalForce.norm() == pytest.approx(own, rel=1e-3)


def test_bits_when_bodies_become_unbounded():
    """A body without a bound gets no new contacts, with and without arrays."""
    ends = []
    for arrays in True, False:
        build(rcr.wall("y", 0, 1, material=material(0.4)), rcr.disc((0, 0.1), 0.1, material(0.4)),
              rcr.disc((0, 0.35), 0.1, material(0.4)), **SOLVER)
        solver().arrays = arrays
        O.run(20, True)
        O.bodies[2].bounded = False
        O.run(300, True)
        ends.append(snapshot())
    np.testing.assert_array_equal(*ends)
