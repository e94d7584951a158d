"""Driven scenes, small and short, and a recorded step that once diverged."""

import contextlib
import math

import numpy as np
import pytest
import rcr
from benchmarks.hard_scenes import driven
from rcr import particle
from scenes import (build, heap, iterations, material, refused, set_state, solver, squeezed, steps,
                    warns, weightless)
from yade import O
from yade.wrapper import Body

# The other scenes are too slow, or too short for the message.
BOUNDS = {"ended", "speed", "force"}


def assert_within_bounds(scene):
    """Run the scene under both laws; returns the course of the rigid run."""
    with warns("body #0 turns about its own centre", when=scene.motion == "rotating"):
        rigid, springs = driven.run(scene)
    broken = BOUNDS & set(driven.violations(scene, rigid, springs))
    assert not broken, f"{scene}\n{rigid}\n{springs}"
    return rigid


@pytest.mark.parametrize("seed", range(len(driven.MOTIONS)), ids=driven.MOTIONS)
def test_a_driven_scene_conserves_what_springs_conserve(seed):
    assert_within_bounds(driven.draw(seed, grains=(20, 40), steps=150))


def test_a_lid_beside_a_receding_wall_does_not_explode():
    scene = driven.Scene(seed=0, motion="receding", eta=0.5, friction=0.5, grains=60, dt=1e-3,
                         speed=0.03, steps=300)
    rigid = assert_within_bounds(scene)
    assert rigid.yielded > 0, "no step without a solution: this scene tests nothing"


@pytest.mark.parametrize("seed", [0, 2])
def test_a_heap_that_nothing_drives_never_yields(seed):
    heap(seed)
    O.run(3500, True)
    assert solver().yieldedSteps == 0


def struck_row(count, speed, gap, **options):
    """Discs of R = 0.01 in a line, and a wall that moves towards them across the gap [m]."""
    smooth = material(0)
    grains = [rcr.disc((0.02 * k, 0), R=0.01, material=smooth) for k in range(count)]
    weightless(rcr.wall("x", -0.01 - gap, sense=1, velocity=speed, material=smooth), *grains,
               dt=1e-4, **options)


def assert_speed_of_discs(speed):
    np.testing.assert_allclose([b.state.vel[0] for b in O.bodies][1:], speed, rtol=1e-3)


@pytest.mark.parametrize("count", [12, 30])
@pytest.mark.parametrize("speed", [0.1, 10])
def test_a_free_row_that_is_struck_is_no_jam(count, speed):
    """The wall bears the momentum of the discs; they leave with its speed."""
    struck_row(count, speed, gap=0, tolerance=1e-6)
    O.step()
    assert not solver().yielded
    momentum = count * O.bodies[1].state.mass * speed
    assert O.forces.f(0)[0] == pytest.approx(-momentum / O.dt, rel=1e-3)
    steps(30)
    assert solver().deepestOverlap < 1e-5
    assert_speed_of_discs(speed)


@pytest.mark.parametrize("count, speed", [(10, 10), (20, 10), (30, 0.5)])
def test_grains_that_fly_together_are_solved(count, speed):
    """Rounding between them must not cost 1000 sweeps a step or count as a jam."""
    struck_row(count, speed, gap=1e-4)
    O.engines[1].verletDist = 1e-3
    steps(int(1e-3 / speed / O.dt) + 20)  # the first disc is hit, and all fly
    missed = solver().missedSteps
    assert np.mean(iterations(40)) < 20
    assert solver().missedSteps == missed and solver().yieldedSteps == 0
    assert_speed_of_discs(speed)


@pytest.mark.parametrize("rigid, springs, broken", [
    (dict(fastest=1.2), {}, ["speed"]), (dict(force=101.0), {}, ["force"]),
    (dict(slowest=11.0), {}, ["step_time"]), (dict(ended=False), {}, ["ended"]),
    (dict(crushed=0.1, stopped=0.14), {}, ["false_alarm"]),
    (dict(crushed=0.1, stopped=0.14, taken_over=0.019), {}, ["false_alarm"]),
    (dict(crushed=0.1, stopped=0.14, taken_over=0.03), {}, []),
    (dict(crushed=0.1), dict(crushed=0.2), ["no_alarm"]),
    (dict(crushed=0.1, stopped=0.5), dict(crushed=0.1), ["late_alarm"]),
    (dict(crushed=0.1, stopped=0.14), dict(crushed=0.3), []), ({}, dict(crushed=0.1), []),
])  # fmt: skip
def test_each_bound_is_seen(rigid, springs, broken):
    scene = driven.Scene(seed=0, motion="lid", eta=0, friction=0, grains=20, dt=1e-3, speed=0.1,
                         steps=1000)
    course = lambda changes: driven.Course(**dict(fastest=0.5, force=1.0, median=1.0, slowest=2.0,
                                                  steps=1000, duration=1.0) | changes)
    assert driven.violations(scene, course(rigid), course(springs)) == broken


def test_springs_start_from_the_motion_of_the_rigid_grains():
    scene = driven.draw(0, grains=(20, 40), steps=150)
    bed = driven._settled(scene)
    driven.begin(scene, driven.RIGID, bed)
    steps(20)
    moment = driven.Moment.now()
    driven._follow(scene, driven.SPRINGS, bed, 0.0, start=moment.motion)
    assert moment.motion == driven.Moment.now().motion


def test_a_step_pays_no_more_than_its_iterations():
    scene = driven.draw(28)
    driven.begin(scene, driven.RIGID, driven._settled(scene))
    assert max(iterations(60)) <= solver().maxIterations


def test_a_first_driven_contact_that_was_missed_yields_too():
    """A heavy disc turns a rod, which then meets a driven disc at a lever of 0.01 of its length."""
    R, smooth = 0.01, material(0)
    rod = particle((0, 0), 10 * R, 0.9, material=smooth)
    driven = rcr.disc((0.4 * R, -2.05 * R), R, material=smooth)
    rod.state.blockedDOFs, driven.state.blockedDOFs = "xyzXY", "xyzXYZ"
    driven.state.vel = (0, 5 * R, 0)
    heavy = rcr.disc((8 * R, 2.02 * R), R, material(0, density=1e5), velocity=(0, -2000 * R))
    weightless(rod, driven, heavy, yieldCompliance=100)
    O.step()
    assert solver().yielded


def test_all_passes_of_a_squeeze_have_ten_times_the_sweeps():
    """A disc hits a row, which takes several passes, while two other discs overlap or do not."""
    R, smooth, taken = 0.01, material(0), {}
    for second in (1.9, 2.1):
        weightless(*(rcr.disc((x * R, y * R), R, material=smooth)
                     for x, y in ((0, 10), (second, 10), (0, 0), (2.5, 0), (4.7, 0))),
                   tolerance=0, maxIterations=10, solver="nlgs", correction=0)
        with warns("bodies #0 and #1 overlap", when=second < 2):
            O.step()
        set_state(2, vel=(1000 * R, 0, 0))
        taken[second], = iterations(1)
    assert taken[2.1] > 10, "the step has one pass: the test tests nothing"
    assert taken[1.9] == 10 * taken[2.1]


@pytest.mark.parametrize("most, further", [(20, 10), (300, 30), (2000, 100)])
def test_a_further_pass_has_a_share_of_the_sweeps(most, further):
    """A disc hits another one, which then meets a row of 300 discs that close up."""
    R, smooth = 0.01, material(0)
    weightless(*(rcr.disc((x * R, 0), R, material=smooth) for x in (-4.7, -2.2)),
               *(rcr.disc((2 * R * k, 0), R, material=smooth, velocity=(-1e-3 * R * k, 0))
                 for k in range(300)),
               tolerance=1e-6, accuracy=1e-9, maxIterations=most, solver="nlgs")
    O.step()
    set_state(0, vel=(1000 * R, 0, 0))
    taken, = iterations(1)
    assert taken > most and (taken - most) % further == 0


def test_a_squeeze_takes_the_largest_number_of_sweeps():
    smooth = material(0)
    weightless(*(rcr.disc((x, 0), 0.01, material=smooth) for x in (0, 0.019)),
               maxIterations=2**31 - 1)
    with warns("bodies #0 and #1 overlap"):
        steps(3)
    assert solver().missedSteps == 0 and solver().deepestOverlap > 0.02


def test_yielding_contacts_push_no_bodies_that_do_not_meet():
    """Two discs approach each other by 0.3 mm across a gap of 0.9 mm, far from a squeeze."""
    squeezed(((5, 0), (0, 0)), ((5.2009, 0), (-0.3, 0)))
    O.step()
    assert solver().yielded
    assert [O.bodies[k].state.vel[0] for k in (3, 4)] == pytest.approx([0, -0.3], abs=1e-9)


def test_an_impact_is_no_jam_of_a_slow_drive():
    """A fast disc of a long row hits a wall while the last disc is driven slowly."""
    smooth = material(0.3)
    discs = [rcr.disc((0.25 * k, 0), 0.1, smooth) for k in range(30)]
    weightless(rcr.wall("x", -1, 1, material=smooth), *discs,
               rcr.disc((-0.899, 0), 0.1, smooth, velocity=(-2, 0)),
               rcr.disc((7.45, 0), 0.1, smooth, fixed=True, velocity=(-1e-3, 0)), dt=2e-3,
               tolerance=1e-4)
    O.step()
    assert not solver().yielded
    assert O.bodies[31].state.vel[0] == pytest.approx(-0.5, rel=1e-6)  # closes the gap of 1 mm


@pytest.mark.parametrize("eta, angle, blocked", [(0, 0, "yzXY"), (0.6, 0.3, "yzXYZ")])
def test_a_prescribed_component_that_closes_a_contact_is_a_jam(eta, angle, blocked):
    """The floor stops a grain whose velocity along y is prescribed, but free along x."""
    rough = material(0.3)
    weightless(rcr.wall("y", 0, 1, material=rough), particle((0, 0.1), 0.1, eta, angle, rough),
               tolerance=1e-4)
    lowest = 0.1 * (1 - eta + eta * math.sin(angle))
    set_state(1, blockedDOFs=blocked, vel=(0, -1, 0), pos=(0, lowest + 1e-3, 0))
    steps(1)
    assert not solver().yielded  # the gap closes
    steps(2)
    assert solver().yieldedSteps >= 1
    refused("jam.*body #1", steps, 40, error=RuntimeError)


@pytest.mark.parametrize("friction", [0, 0.5])
@pytest.mark.parametrize("x, angle", [(0.134, 0.8), (0.847, 0.25), (0.764, -0.1)])
def test_a_hinged_body_that_a_driven_body_presses_through_its_centre_is_a_jam(x, angle, friction):
    """The lever of the contact is a rounding error; the disc must not spin."""
    rough = material(friction)
    apart, direction = 0.2, np.array([math.sin(angle), math.cos(angle)])
    build(rcr.disc((x, 0.1), 0.1, rough),
          rcr.disc((x, 0.1) + (apart + 5e-4) * direction, 0.1, rough, fixed=True,
                   velocity=-0.1 * direction), tolerance=1e-4)
    set_state(0, blockedDOFs="xyzXY")
    for _ in range(12):
        O.step()
        assert abs(O.bodies[0].state.angVel[2]) < 1e-6
    assert solver().yieldedSteps >= 6


@pytest.mark.parametrize("name", ["auto", "exact", "nesterov"])
def test_a_jam_of_fine_grains_is_seen_beside_coarse_ones(name):
    """The impulses of discs of 1 mm vanish in the sums over a scene with discs of 0.1 m."""
    rough, fine = material(0.4), 1e-3
    squeeze = [rcr.disc((0, 2 * fine * k), fine, rough, fixed=k in (0, 5),
                        velocity=(0, -1e-3) if k == 5 else (0, 0)) for k in range(6)]
    coarse = [rcr.disc((10 + 0.3 * k, -0.9 + 1e-4), 0.1, rough, velocity=(0.1 * k, -1))
              for k in range(30)]
    build(rcr.wall("y", -1, 1, material=rough), *squeeze, *coarse, solver=name, tolerance=1e-4)
    O.step()
    assert solver().yielded


def test_a_hinged_body_without_a_shape_has_no_contacts():
    """Its radius 0 must not enter the bounds of driven scenes."""
    squeezed(((5, 0), (0, 0)))
    hinged = Body()
    hinged.state.mass, hinged.state.inertia = 1, (1, 1, 1)
    hinged.state.blockedDOFs, hinged.state.angVel = "xyzXY", (0, 0, 3)
    O.bodies.append(hinged)
    O.step()
    assert solver().yielded


def test_a_jam_that_is_tried_again_counts_no_step():
    squeezed()
    refused("jam", steps, 100, error=RuntimeError)
    assert solver().yieldedSteps == O.iter
    for _ in range(3):
        with contextlib.suppress(RuntimeError):
            O.step()
    assert solver().yieldedSteps == O.iter


@pytest.mark.parametrize("speed", [0, 0.01])
def test_only_a_squeeze_with_a_drive_ends_the_run(speed, capfd):
    """A heavy body sinks into a column that one sweep a step does not support.

    A wall that moves elsewhere is a drive (docs/law.md).
    """
    smooth = material(0)
    column = [rcr.disc((0, 0.1 + 0.2 * k), 0.1, smooth) for k in range(20)]
    heavy = rcr.disc((0, 4.1), 0.1, smooth)
    heavy.state.mass *= 1e4
    build(rcr.wall("y", 0, 1, material=smooth), *column, heavy,
          rcr.wall("x", 5, material=smooth, velocity=speed), maxIterations=1, solver="nlgs",
          tolerance=1e-8, dt=1e-3)
    with warns("body #21, a Sphere, has the mass"):
        if speed:
            refused("not converged: bodies", O.run, 200, True, error=RuntimeError)
        else:
            O.run(200, True)
    if not speed:
        assert solver().deepestOverlap > 0.05 and "have not converged" in capfd.readouterr().err


@pytest.mark.parametrize("elastic", [False, True], ids=["torque", "impact"])
def test_a_drive_elsewhere_does_not_let_turning_bodies_yield(elastic):
    """Pegs hold a rod against a torque, or reflect its spin; far away, a wall creeps."""
    def end(speed):
        m = material(0 if elastic else 0.3)
        build(rcr.wall("x", 0.3, velocity=speed, material=m), rcr.disc((0.31, 0), 0.01, m),
              rcr.disc((0.015, 0.013 if elastic else 0.007), 0.005, m, fixed=True),
              rcr.disc((-0.015, -0.007 if not elastic else -0.05), 0.005, m, fixed=True),
              rcr.particle((0, 0), 0.02, 0.9, material=m, angular_velocity=20 * elastic),
              gravity=(0, 0, 0), dt=1e-4, restitution=float(elastic), tolerance=1e-8)
        if not elastic:
            O.forces.setPermT(4, (0, 0, 30))
        O.run(400, True)
        assert solver().yieldedSteps == 0
        return O.bodies[4].state.angVel[2]

    assert end(1e-3) == pytest.approx(end(0), rel=1e-3, abs=1e-6)


def test_a_large_friction_is_no_jam():
    """A guided grain rests on a belt: p = (m g dt, ±µ m g dt)."""
    m = material(5.0)
    grain = rcr.particle((0, 0.01), 0.01, 0.5, material=m, angle=math.pi / 2)
    build(rcr.segment((-1, 0), (1, 0), material=m), grain, tolerance=1e-6)
    set_state(0, vel=(0.01, 0, 0))
    set_state(1, blockedDOFs="xzXYZ")
    O.run(100, True)
    assert solver().missedSteps == solver().yieldedSteps == 0


def fall_between_pegs(angle, friction, creep=0, boost=0, tolerance=1e-8):
    """Rebound speed of a disc that falls between two fixed ones; e = 0.5, contacts at this angle.

    A wall far away creeps, or the whole scene moves at the speed `boost`.
    """
    rough, R = material(friction), 0.1
    x, y = 2 * R * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    pegs = [rcr.disc((side * x, 0), R, material=rough, fixed=True, velocity=(boost, 0))
            for side in (-1, 1)]
    falling = rcr.disc((0, y + 0.0503), R, material=rough, velocity=(boost, -2))
    far = [rcr.wall("x", 50, -1, velocity=-creep, material=rough),
           rcr.disc((50 - R, 0), R, material=rough)]
    weightless(*pegs, falling, *far[: 2 * (creep > 0)], dt=1e-4, restitution=0.5,
               tolerance=tolerance)
    O.run(400, True)
    return O.bodies[2].state.vel[1]


@pytest.mark.parametrize("drive", [dict(creep=1e-3), dict(boost=1e-3)], ids=["far", "boost"])
@pytest.mark.parametrize("angle", [10, 12])
def test_an_impact_that_nothing_drives_keeps_its_restitution(angle, drive):
    assert fall_between_pegs(angle, 0, **drive) == pytest.approx(1, rel=1e-5)
    assert solver().missedSteps == solver().yieldedSteps == 0


@pytest.mark.parametrize("angle", [10, 40])
def test_a_distant_drive_does_not_change_an_impact_with_friction(angle):
    alone = fall_between_pegs(angle, 1, tolerance=1e-4)
    missed = solver().missedSteps
    assert fall_between_pegs(angle, 1, creep=1e-6, tolerance=1e-4) == alone
    assert solver().missedSteps == missed


@pytest.mark.parametrize("e", [0.5, 1])
def test_a_wall_strikes_a_disc_up_a_slope_with_restitution(e):
    R, V, smooth = 0.1, 1.0, material(0)
    a = math.radians(45)
    normal = np.array([-math.sin(a), math.cos(a)])
    slope = rcr.segment(*((t * math.cos(a), t * math.sin(a)) for t in (-3, 3)), material=smooth)
    center = tuple(R * normal)
    weightless(slope, rcr.disc(center, R, material=smooth),
               rcr.wall("x", center[0] - R - 0.01, 1, velocity=V, material=smooth), dt=1e-4,
               restitution=e, tolerance=1e-8)
    O.run(150, True)
    assert tuple(O.bodies[1].state.vel)[:2] == pytest.approx(((1 + e) * V,) * 2, rel=1e-3)
    assert solver().yieldedSteps == 0
