"""Energy with O.trackEnergy: accounts of friction, impacts, drive and correction keep the total."""

import math

import numpy as np
import pytest
import rcr
from scenes import (G, LAWS, build, grain_on_floor, kinetic, material, set_state, solver, springy,
                    stadium, steps, velocity, walls, warns, weightless)
from yade import O, utils
from yade.wrapper import MatchMaker


def run(count):
    """Largest change of the total over the steps; energy of friction, impact, dashpots, (n, 3)."""
    O.trackEnergy = True
    O.step()
    start = O.energy.total()
    off, dissipated = 0.0, []
    for _ in range(count):
        O.step()
        off = max(off, abs(O.energy.total() - start))
        energy = dict(O.energy.items())
        dissipated.append([energy.get(f"{name}Dissip", 0) for name in ("plast", "impact", "visc")])
    return off, np.array(dissipated)


def never_gives(dissipated, scale):
    """No account decreases by more than the rounding of velocities in a step."""
    return (np.diff(dissipated, axis=0) >= -1e-3 * scale).all() and (dissipated[-1] >= 0).all()


def test_sliding():
    """A brick slides to rest: friction takes ½ m v²."""
    brick = grain_on_floor(0.2, friction=0.4)
    s = O.bodies[brick].state
    s.vel = (2, 0, 0)
    kinetic = 0.5 * s.mass * 4
    off, dissipated = run(800)
    assert s.vel.norm() < 1e-9 and off < 0.01 * kinetic and never_gives(dissipated, kinetic)
    assert dissipated[-1, 0] == pytest.approx(kinetic, rel=0.01)
    assert dissipated[-1, 1] < 0.01 * kinetic


@pytest.mark.parametrize("e", [0, 0.5, 0.9])
def test_bouncing(e):
    """A disc falls by h and bounces: an impact takes (1 − e²) m g h."""
    disc = grain_on_floor(0, height=0.6, restitution=e, dt=1e-4)
    released = O.bodies[disc].state.mass * G * 0.5
    off, dissipated = run(4000)
    assert off < 0.01 * released and never_gives(dissipated, released)
    assert dissipated[-1, 1] == pytest.approx((1 - e**2) * released, rel=0.01)


@LAWS
def test_column_that_collapses(law):
    m, rng = springy(), np.random.default_rng(3)
    grains = [rcr.particle((0.22 * i, 0.12 + 0.24 * j), 0.1, 0.5, angle=rng.uniform(0, 3),
                           material=m) for i in range(3) for j in range(8)]
    build(rcr.wall("y", 0, material=m), *grains, **({} if law == "rigid" else
                                                    dict(law=law, damping=0.3)))
    O.dt = O.dt if law == "rigid" else 0.1 * rcr.critical_time_step()
    height = lambda: sum(b.state.mass * G * b.state.pos[1] for b in grains)
    before = height()
    off, dissipated = run(1500 if law == "rigid" else int(1.0 / O.dt))
    released = before - height()
    assert off < 0.01 * released and never_gives(dissipated, released)


def test_the_total_gains_the_work_of_a_load():
    """A piston compacts grains: its work is Σ F · v dt; its path lacks what correction lifts."""
    m, rng = material(0.5), np.random.default_rng(3)
    box = walls(m, x=(0, 1.0), y=(0,))
    grains = [rcr.particle((0.12 + 0.25 * i, 0.12 + 0.24 * j), 0.1, 0.5, rng.uniform(0, 3),
                           material=m) for i in range(4) for j in range(6)]
    load = -1e4  # [N] on the unit length between the side walls
    *_, piston = build(*box, *grains, rcr.mobile_wall("y", 1.6, 100, sense=-1, material=m),
                       before=[rcr.WallStress(wall=3 + len(grains), start=0, end=1, stress=load)],
                       tolerance=1e-6)
    O.trackEnergy = True
    work, state = 0.0, O.bodies[piston].state
    for _ in range(1500):
        O.step()
        work += load * state.vel[1] * O.dt
    path = 1.6 - state.pos[1]
    assert path > 0.1 and state.vel.norm() < 1e-6
    assert O.energy.total() == pytest.approx(work, rel=1e-8)
    assert work > -load * path


@pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_bounce_with_slip_reversal_never_lowers_an_account(mu, restitution):
    """A long grain falls on its end: impact and friction together take a positive energy."""
    for angle in np.linspace(0.1, 1.4, 8):
        m = material(friction=mu)
        grain = stadium(0.018, 0.002, (0, 0.03), angle=angle, velocity=(0.2, -1), material=m)
        weightless(rcr.wall("y", 0, material=m), grain, dt=1e-4, restitution=restitution)
        off, dissipated = run(400)
        assert never_gives(dissipated, 1e-6) and off < 1e-6


def motion(rng, speed, spin):
    """A random angle, and a motion up to this speed along each axis [m/s] and this spin [rad/s]."""
    return dict(angle=rng.uniform(0, math.pi), velocity=tuple(rng.uniform(-speed, speed, 2)),
                angular_velocity=rng.uniform(-spin, spin))


def test_two_fast_grains_gain_nothing_in_a_step():
    """Random pairs, some overlapping, up to 0.4 R and 0.15 rad a step, whose points may change."""
    rng = np.random.default_rng(3)

    def gained():
        grains = []
        for side in (-1, 1):
            a = rng.choice([0, 0.05, 0.09])
            place = side * rng.uniform(0.03, 0.13), rng.uniform(-0.05, 0.05)
            grains.append(stadium(a, 0.1 - a, place, material=material(0), **motion(rng, 20, 150)))
        weightless(*grains, solver="exact", tolerance=1e-8)
        before = utils.kineticEnergy()
        O.step()
        return utils.kineticEnergy() / before - 1

    with warns("bodies #0 and #1 overlap"):
        gained = [gained() for _ in range(600)]
    assert max(gained) < 1e-6 and min(gained) < -0.1


@pytest.mark.parametrize("solver_name", ["auto", "nlgs"])
@pytest.mark.parametrize("slip", [0.5, -0.5])
def test_two_points_that_stick_bounce_as_one(slip, solver_name):
    """Only the sum of their tangential impulses is determined; it stops the slip, e = 1."""
    rough = material(0.3)
    _, rod = weightless(rcr.wall("y", 0, +1, material=rough),
                        rcr.particle((0, 0.05), 0.1, 0.5, material=rough, velocity=(slip, -3)),
                        restitution=1, solver=solver_name)
    O.step()
    assert velocity(rod) == pytest.approx([0, 3, 0], abs=1e-3)


@pytest.mark.parametrize("rounding", [-1e-12, 1e-12])
def test_a_closing_speed_of_rounding_is_no_impact(rounding):
    def end(speed):
        build(rcr.segment((-0.5, 0), (0.5, 0)), rcr.disc((0.5, 0.1), 0.1, velocity=(6, speed)),
              gravity=(0, -300, 0), dt=5e-3, restitution=0.5)
        O.step()
        return velocity(1)

    assert end(rounding) == pytest.approx(end(0), abs=1e-9)


@pytest.mark.parametrize("restitution", [0.9, 1])
def test_a_thin_grain_between_two_others_is_no_lever(restitution):
    """At 0.18 rad a step a blow at one end must not throw it against the contact that opens."""
    weightless(*(stadium(a, r, at, angle, velocity=v, angular_velocity=turn, material=material(0))
                 for a, r, at, angle, v, turn in (
        (0.0023, 0.0053, (-0.0467, -0.0212), -0.13409, (0.2726, -0.2826), 17.16),
        (0.0053, 0.0003, (-0.03757, -0.0252), 1.65572, (-1.918, 0.1254), 366.1),
        (0, 0.0107, (-0.02526, -0.02173), 2.54758, (-0.07956, 0.08846), 3.954))),
        dt=5e-4, restitution=restitution, tolerance=1e-8)  # fmt: skip
    before = utils.kineticEnergy()
    O.step()
    assert sum(i.phys.normalForce.norm() > 0 for i in O.interactions) == 2
    assert 0.3 < utils.kineticEnergy() / before <= 1 + 1e-9


def test_an_elastic_impact_of_two_grains_keeps_their_energy():
    """They may move far in a step, and meet by turning only."""
    rng, kept, met = np.random.default_rng(1), [], 0
    for _ in range(150):
        grains = []
        for side in (-1, 1):
            motion = dict(angle=rng.uniform(0, math.pi),
                          velocity=(-side * rng.uniform(0.3, 1), rng.uniform(-0.2, 0.2)),
                          angular_velocity=rng.uniform(-10, 10))
            grains.append(stadium(0.008, 0.002, (side * 0.013, rng.uniform(-0.006, 0.006)),
                                  material=material(0), **motion))
        weightless(*grains, restitution=1, tolerance=1e-10)
        before, velocity = utils.kineticEnergy(), tuple(O.bodies[0].state.vel)
        O.run(30, True)
        kept.append(utils.kineticEnergy() / before)
        met += tuple(O.bodies[0].state.vel) != velocity
    assert met > 100
    np.testing.assert_allclose(kept, 1, atol=1e-8)


@pytest.mark.parametrize("restitution", [0.5, 1])
def test_a_gap_narrower_than_the_way_of_a_step_is_no_jam(restitution):
    """A disc between two walls at rest: both bounces fall into one step, which has a solution."""
    m, R, gap = material(0), 0.01, 1e-4
    *_, disc = weightless(*walls(m, x=(-R - gap, R + gap)),
                          stadium(0, R, (0, 0), velocity=(1, 0), material=m),
                          restitution=restitution)
    steps(50)
    assert solver().yieldedSteps == 0 and solver().deepestOverlap < 1e-3
    assert abs(O.bodies[disc].state.vel[0]) < 1


@pytest.mark.parametrize("friction", [0, 0.4])
@pytest.mark.parametrize("restitution", [0.9, 1])
def test_a_cloud_gains_nothing_in_a_step(restitution, friction):
    """Discs to needles, up to 0.15 rad and 0.1 R a step."""
    rng, gained = np.random.default_rng(2), []
    for _ in range(4):
        m, grains = material(friction), []
        for i in range(36):
            half, eta = rng.uniform(0.005, 0.0115), rng.choice([0, 0.3, 0.7, 0.95])
            grains.append(rcr.particle((0.013 + 0.026 * (i % 6), 0.013 + 0.026 * (i // 6)), half,
                                       eta, material=m, **motion(rng, 1, 300)))
        weightless(*walls(m, x=(0, 0.156), y=(0, 0.156)), *grains, dt=5e-4,
                   restitution=restitution, tolerance=1e-8)
        kinetic = [utils.kineticEnergy()]
        for _ in range(100):
            O.step()
            kinetic.append(utils.kineticEnergy())
        gained.append(max(np.diff(kinetic) / kinetic[:-1]))
    assert max(gained) < 1e-5


@pytest.mark.parametrize("options", [{}, dict(tolerance=1e-8), dict(maxIterations=20000)])
def test_a_jam_leaves_the_impact_of_its_bodies_and_of_others_alone(options):
    """A jammed disc is hit along the walls, e = 0.5. Rods hit a floor elsewhere, e = 1."""
    R, rough, smooth = 0.01, material(0.5), material(0)
    angles, slips = np.radians(np.linspace(10, 80, 8)), (-4, -2, -1, -0.5, 0.5, 1, 2, 4)
    rods = [stadium(0.9 * R, 0.1 * R, (4 * R * (8 * j + k), (0.1 + 0.9 * math.sin(angle)) * R),
                    angle, material=rough) for j, angle in enumerate(angles) for k in range(8)]
    low, high = (rcr.segment((-1.05, y), (-0.95, y), material=smooth) for y in (1, 1 + 2 * R))
    hit, striker = (rcr.disc((-1 - x, 1 + R), R, material=smooth) for x in (0, 2 * R + 1e-5))
    ids = weightless(rcr.wall("y", 0, material=rough), *rods, low, high, hit, striker,
                     **dict(dict(tolerance=1e-4), **options))
    O.materials.append([rough, smooth])
    O.engines[2].physDispatcher.functors[0].restitution = MatchMaker(
        matches=((rough.id, rough.id, 1), (smooth.id, smooth.id, 0.5)), algo="val", val=0)
    set_state(ids[-3], vel=(0, -0.01, 0))
    set_state(ids[-1], vel=(0.3, 0, 0))
    for k, rod in enumerate(ids[1:-4]):
        set_state(rod, vel=(10 * R * slips[k % 8], -10 * R, 0))
    before = [kinetic([O.bodies[k]]) for k in ids[1:-4]]
    O.step()
    assert solver().yielded
    gains = np.array([kinetic([O.bodies[k]]) for k in ids[1:-4]]) / before - 1
    assert max(gains) < 1e-3
    hit, striker = (O.bodies[k].state.vel[0] for k in ids[-2:])
    assert hit - striker == pytest.approx(0.15, rel=0.05)


def test_shear_between_driven_walls():
    """Friction and impacts take the work of two driven lids."""
    m, rng = material(friction=0.5), np.random.default_rng(5)
    box = [rcr.wall(axis, at, material=m) for axis, at in (("y", 0), ("x", -0.15), ("x", 1.35))]
    grains = [rcr.particle((0.25 * i, 0.13 + 0.26 * j), 0.1, 0.4, angle=rng.uniform(0, 3),
                           material=m) for i in range(6) for j in range(4)]
    lid = [rcr.particle((0.3 * i, 1.2), 0.15, 0, fixed=True, velocity=(0.5, 0), material=m)
           for i in range(-8, 5)]
    build(*box, *grains, *lid)
    off, dissipated = run(1500)
    work = -dict(O.energy.items())["driveWork"]
    given = max(work, dissipated[-1].sum())
    assert given > 0 and off < 0.01 * given and never_gives(dissipated, given)


@pytest.mark.parametrize("mass", [1e-3, 1.0])
def test_the_position_correction_of_a_wall_is_bounded(mass):
    """As that of a grain, by 1e-4 R in a step."""
    smooth = material(0)
    weightless(rcr.disc((0, 0), 0.1, smooth, fixed=True),
               rcr.mobile_wall("y", 0.095, mass, -1, smooth), dt=1e-4, tolerance=1e-4)
    steps(2)
    assert 0 < O.bodies[1].state.pos[1] - 0.095 <= 2.001e-5


def test_position_correction_lifts():
    """The correction of overlaps lifts grains: its account balances gravity's."""
    disc = grain_on_floor(0, height=0.099)
    O.step()
    assert not dict(O.energy.items())  # without O.trackEnergy
    set_state(disc, pos=(0, 0.099, 0), vel=(0, 0, 0))
    s = O.bodies[disc].state
    off, _ = run(200)
    lifted = s.mass * G * (s.pos[1] - 0.099)
    assert lifted > 0 and off < 1e-9
    assert dict(O.energy.items())["correctionWork"] == pytest.approx(-lifted, rel=0.02)


def test_a_reset_of_the_time_loses_no_energy():
    """YADE adds the kinetic energy one step late, and so do the accounts of the solver."""
    def dissipated(reset):
        grain_on_floor(0, height=0.12, restitution=0.5)
        set_state(vel=(1, -1, 0))
        O.trackEnergy = True
        while not O.interactions.countReal() or O.interactions[0, 1].phys.normalForce[1] == 0:
            O.step()  # the impact is pending
        if reset:
            O.resetTime()
        steps(3)
        return dict(O.energy.items())["impactDissip"]

    assert dissipated(False) > 0 and dissipated(True) == dissipated(False)


def test_no_energy_of_an_earlier_account_is_entered():
    grain_on_floor(0, height=0.2)
    O.trackEnergy = True
    while not solver().contactPoints:
        O.step()
    O.step()
    O.trackEnergy = False
    O.run(100, True)
    O.energy.clear()
    O.bodies[1].state.pos = (0, 5, 0)
    O.trackEnergy = True
    O.run(10, True)
    assert dict(O.energy.items()).get("impactDissip", 0) == 0
