"""Springs: closed forms of spring, dashpot and slider; stiffness, critical time step."""

import functools
import math

import numpy as np
import pytest
import rcr
import yade.utils
from rcr.study.biaxial import Biaxial
from scenes import (G, KN, KS, build, engines, gaps, grain_on_floor, inertia, insert, material,
                    point_forces, pressed_box, refused, set_state, springs, springy, stadium, steps,
                    velocity, walls, warns, weightless)
from yade import O
from yade.wrapper import FrictMat, GlobalStiffnessTimeStepper, MatchMaker

MU = 0.5
on_floor = functools.partial(grain_on_floor, friction=MU, make=springs)


@pytest.mark.parametrize("zeta, rel", [(0, 1e-2), (0.1, 2e-2), (0.5, 2e-2)])
def test_rebound(zeta, rel):
    """e = exp(−ζωt₁), ω√(1−ζ²) t₁ = π − arctan(2ζ√(1−ζ²)/(1−2ζ²)) (Schwager and Pöschel 2007)."""
    disc = on_floor(0, height=0.1005, gravity=(0, 0, 0), damping=zeta, share=0.01)
    disc, touched = O.bodies[disc].state, []
    disc.vel = (0, -0.1, 0)
    while not touched or disc.pos[1] < 0.1:
        O.step()
        touched += [O.time] if disc.pos[1] < 0.1 else []
    root = math.sqrt(1 - zeta**2)
    angle = math.pi - math.atan2(2 * zeta * root, 1 - 2 * zeta**2)  # k x + c x' = 0: no tension
    if zeta == 0:  # a damped disc ends its force before its overlap; seen a step late
        time = math.pi * math.sqrt(disc.mass / KN)
        assert O.time - touched[0] == pytest.approx(time, abs=2 * O.dt)
    assert disc.vel[1] / 0.1 == pytest.approx(math.exp(-zeta / root * angle), rel=rel)  # dt ω


@pytest.mark.parametrize("damping", ["damping", "local_damping"])
def test_resting_grain_sinks_by_its_weight(damping):
    """Two points a grain: δ = m g/(2 k_n), with dashpots alone and with YADE's local damping."""
    block = on_floor(0.3, share=0.2, **{damping: 0.5 if damping == "damping" else 0.3})
    m, _ = inertia(0.3, 0.1)
    steps(3000)
    assert 0.1 - O.bodies[block].state.pos[1] == pytest.approx(m * G / (2 * KN), rel=1e-3)
    assert point_forces(0, block)[:, 0] == pytest.approx(m * G / 2, rel=1e-3)


def test_two_points_resist_tilting():
    """Rocking: I θ'' = −2 k_n a² θ while both ends press, period 2π √(I/(2 k_n a²))."""
    a = 0.4
    m, I = inertia(a, 0.1)
    sunk = m * G / (2 * KN)
    block = on_floor(a, friction=0, height=0.1 - sunk)
    O.bodies[block].state.angVel = (0, 0, 1e-5)  # amplitude v/ω < `sunk`
    rotation = []
    while len(rotation) < 2 or not rotation[-2] < 0 <= rotation[-1]:
        O.step()
        rotation.append(O.bodies[block].state.angVel[2])
    # ω starts at a maximum; it passes 0, rising, after three quarters of a period
    period = 2 * math.pi * math.sqrt(I / (2 * KN * a * a))
    assert len(rotation) * O.dt == pytest.approx(0.75 * period, rel=5e-3)


def block_on_a_slope(alpha):
    """A flat block on a floor that was tilted slowly, without oscillation."""
    m, _ = inertia(0.3, 0.1)
    # local damping too: tangential springs have no dashpot
    block = on_floor(0.3, height=0.1 - m * G / (2 * KN), damping=0.3, local_damping=0.3, share=0.2)
    for now in np.linspace(0, alpha, 10000):
        O.engines[-1].gravity = (G * math.sin(now), -G * math.cos(now), 0)
        O.step()
    return block, m


def test_block_that_sticks_hangs_in_its_springs():
    """Both points carry T/2, T = m g sin α, whose moment T r turns the block by T r/(2 k_n a²)."""
    a, r = 0.3, 0.1
    alpha = math.atan(0.5 * MU)
    block, m = block_on_a_slope(alpha)
    steps(5000)
    T = m * G * math.sin(alpha)
    assert O.bodies[block].state.pos[0] == pytest.approx(T / (2 * KS) + T * r**2 / (2 * KN * a**2),
                                                         rel=1e-2)
    assert point_forces(0, block)[:, 1] == pytest.approx(np.full(2, T / 2), rel=1e-2)


@pytest.mark.parametrize("factor", [0.98, 1.02], ids=["below", "above"])
def test_block_on_a_slope(factor):
    """Sticks for tan α ≤ µ; else a = g (sin α − µ cos α)."""
    alpha = math.atan(factor * MU)
    block, _ = block_on_a_slope(alpha)
    O.engines[-1].damping = 0
    steps(1000)
    before, time = velocity(block)[0], O.time
    steps(2000)
    expected = max(0, G * (math.sin(alpha) - MU * math.cos(alpha)))
    assert (velocity(block)[0] - before) / (O.time - time) == pytest.approx(expected, abs=1e-3 * G)


def test_tangential_springs_stay_with_their_points():
    """A block pushed to and fro tips on an end and back: the closed end's spring does not jump."""
    m, _ = inertia(0.4, 0.1)
    block = on_floor(0.4, friction=10, height=0.1 - m * G / (2 * KN), share=0.1, damping=0.3,
                     local_damping=0.2)
    O.forces.setPermF(block, (0.3 * m * G, 0, 0))
    steps(3000)
    points, held = [], []
    for torque in np.linspace(0, 1.3 * m * G * 0.4, 4000):  # tips over its right end
        O.forces.setPermT(block, (0, 0, -torque))
        O.step()
        points.append(O.interactions[0, block].geom.points)
        held.append(O.interactions[0, block].phys.shearForce[0])
    assert set(points) == {1, 2}
    jump = points.index(1)  # the open point carried no force
    assert np.abs(np.diff(held[jump - 5 : jump + 5])).max() < 0.02 * 0.3 * m * G


def test_energy_is_kept_or_accounted_for():
    """A block thrown onto the floor: the sum of all energies is constant to first order in dt."""
    worst = []
    for share in (0.1, 0.05):
        rod = on_floor(0.3, friction=0.3, height=0.4, angle=0.7, share=share, damping=0.1)
        O.trackEnergy = True
        (m, _), state, energies = inertia(0.3, 0.1), O.bodies[rod].state, []
        state.vel = (1.0, -1.0, 0)
        for _ in range(round(0.4 / O.dt)):
            O.step()
            energies.append(yade.utils.kineticEnergy() + m * G * state.pos[1] + sum(
                energy for name, energy in O.energy.items()
                if name in ("elastPotential", "plastDissip", "viscDissip")))
        worst.append(np.abs(np.array(energies[-100:]) / energies[0] - 1).max())
        assert O.energy["plastDissip"] > 0 and O.energy["viscDissip"] > 0
    assert worst[0] < 0.02 and worst[1] < 0.7 * worst[0]


@pytest.mark.parametrize("young, share, least, most", [
    (1e7, 0.5, 0.05, 1), (1e8, 0.5, 0, 0.05), (1e9, 0.5, 0, 0.05),
    *(pytest.param(*case, marks=pytest.mark.slow)
      for case in [(1e7, 0.02, 0.05, 1), (1e8, 0.1, 0, 0.05), (1e8, 0.02, 0, 0.05),
                   (1e9, 0.1, 0, 0.005)]),
])  # fmt: skip
def test_energy_that_contacts_make_where_they_change_their_kind(young, share, least, most):
    """Figures of docs/law.md: a cap that penetrates a side gains a second point within a step."""
    worst, deepest = 0, 0
    for seed in range(5):
        m = FrictMat(density=2600, frictionAngle=0, young=young, poisson=0.8)
        rng = np.random.default_rng(seed)
        grains = [rcr.particle((0.0125 + 0.024 * i, 0.0125 + 0.024 * j), rng.uniform(0.007, 0.01),
                               0.5, i * j, m) for i in range(3) for j in range(4)]
        build(*walls(m, x=(0, 0.075), y=[0]), *grains, law="smooth")
        O.trackEnergy = True
        O.dt = share * rcr.critical_time_step()
        for _ in range(25):
            O.run(int(0.01 / O.dt), True)
            deepest = max(deepest, -min(gaps(), default=0) / 0.0035)
        worst = max(worst, abs(O.energy.total() / O.energy["gravWork"]))
    O.trackEnergy = False
    print(f"E = {young:g}, dt = {share} critical: overlaps up to {deepest:.2g} cap radii, balance "
          f"off by {worst:.2g} of the work of gravity")
    assert least <= worst <= most


def test_stock_stiffness_from_materials():
    """k_n = 2 E R₁R₂/(R₁ + R₂) of circumscribed radii, k_s = ν k_n; a wall has R₂ = R₁."""
    rough = FrictMat(density=1000, frictionAngle=0.4, young=1e7, poisson=0.25)
    build(rcr.wall("y", 0, material=rough), stadium(0.2, 0.1, (0, 0.0999), material=rough),
          stadium(0.05, 0.1, (0, 0.2997), material=rough), law="smooth")
    O.dt = 0.1 * rcr.critical_time_step()
    O.step()
    wall, pair = O.interactions[0, 1].phys, O.interactions[1, 2].phys
    assert (wall.kn, wall.ks) == pytest.approx((1e7 * 0.3, 0.25e7 * 0.3))
    assert pair.kn == pytest.approx(2e7 * 0.3 * 0.15 / 0.45)
    assert math.tan(0.4) == pytest.approx(pair.tangensOfFrictionAngle)
    yade.utils.setContactFriction(0.1)
    assert O.interactions[1, 2].phys.tangensOfFrictionAngle == pytest.approx(math.tan(0.1))


def test_contact_that_opens_is_erased():
    disc = on_floor(0, height=0.0999, gravity=(0, 0, 0))
    O.step()
    assert O.interactions[0, disc].isReal
    O.bodies[disc].state.pos = (0, 0.11, 0)  # farther than 1 % of the radius
    O.bodies[disc].state.vel = (0, 0, 0)
    steps(2)
    assert O.interactions.countReal() == 0
    O.bodies[disc].state.pos = (0, 0.1005, 0)  # found, but open
    steps(2)
    assert O.interactions[0, disc].isReal and O.forces.f(disc).norm() == 0


@pytest.mark.parametrize("share, holds", [(0.9, True), (8, False)])
@pytest.mark.parametrize("zeta", [0, 0.3])
def test_critical_time_step(share, holds, zeta):
    """A pressed box at rest stays at rest below the critical step and diverges well above it."""
    pressed_box(springs, 0, share=0.3, damping=zeta, local_damping=0.2)
    steps(10000)
    O.engines[-1].damping = 0
    still = yade.utils.kineticEnergy()
    O.dt = share * rcr.critical_time_step()
    with warns("springs .* become unstable", when=not holds):
        steps(2000)
    grown = yade.utils.kineticEnergy() / still
    assert grown < 2 if holds else grown > 1e3, grown


def test_stock_time_stepper():
    """O.dt = 1.41044 s √(m/k) for a disc on its floor; s is timestepSafetyCoefficient."""
    on_floor(0, height=0.0999,
             before=[GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.4,
                                                timeStepUpdateInterval=1, defaultDt=1e-5)])
    O.dynDt = True
    steps(3)
    m, I = inertia(0, 0.1)
    stiffest = max(KN / m, KS / m, KS * 0.1**2 / I)
    assert O.dt == pytest.approx(1.41044 * 0.4 / math.sqrt(stiffest), rel=1e-6)


def test_the_stress_of_the_network_is_that_of_the_walls():
    """σ = (1/V) Σ f⊗ℓ is the load of the walls once the box is at rest."""
    pressed_box(springs, 0, share=0.3, damping=0.3, local_damping=0.2)
    steps(40000)
    network = rcr.contact_network((0, 1, 2, 3), strain=0.0, eta=0.5, friction=0.3, seed=1)
    assert len(network.contacts["force"]) > 20
    assert np.diag(network.stress()) == pytest.approx(1e3, rel=5e-3)
    assert network.stress()[0, 1] == pytest.approx(network.stress()[1, 0], abs=5)
    assert network.friction_mobilization().max() <= 1 + 1e-9


# --- laws that change

@pytest.mark.parametrize("change, name", [
    (lambda loop: insert(3, rcr.ContactDynamics()), "the engine ContactDynamics"),
    (lambda loop: setattr(loop.lawDispatcher, "functors", [
        *loop.lawDispatcher.functors, rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
     "Law2_RcrGeom_CdPhys_SignoriniCoulomb"),
    (lambda loop: setattr(loop.physDispatcher, "functors", [rcr.Ip2_FrictMat_FrictMat_CdPhys()]),
     "Ip2_FrictMat_FrictMat_CdPhys"),
], ids=["engine", "law", "ip2"])  # fmt: skip
def test_mixed_laws(change, name):
    """The message names the class that does not fit, and no contact forms, in a run too."""
    on_floor(0, height=0.0999)
    change(O.engines[2])
    mixed = rf"O.engines mix Law2_RcrGeom_FrictPhys_CundallStrack \(springs\) with {name}"
    for step in (O.step, lambda: O.run(1000, wait=True)):
        refused(mixed, step)
    assert O.interactions.countReal() == 0 and O.iter <= 2


def test_contacts_of_the_other_law():
    """A scene changes its law and keeps its contacts, which have no stiffness."""
    grain_on_floor(0)
    O.step()
    O.engines = engines(law="smooth")
    O.saveTmp(quiet=True)
    O.loadTmp(quiet=True)  # otherwise YADE uses the functors stored in each contact
    refused(r"has a CdPhys, made for ContactDynamics; .*O.interactions.clear\(\)", O.step)
    O.interactions.clear()
    steps(2)
    assert isinstance(O.interactions[0, 1].phys, rcr.RcrFrictPhys)


@pytest.mark.slow
def test_biaxial_test_with_springs():
    """With springs overlaps are σ₀/k_n d, and the contact stress is that of the walls."""
    stiffness = 1e3
    test = Biaxial.prepare(eta=0.5, particles=60, seed=1, law="smooth", stiffness=stiffness)
    test.compact()
    assert not any(isinstance(engine, rcr.ContactDynamics) for engine in O.engines)
    for _ in range(10):  # after three records the unloaded springs carry load again
        test.shear_record()
    overlaps = test.overlaps()  # f/k_n, f ≈ σ₀ d, shared by two points
    assert 0.1 / stiffness < overlaps[overlaps > 0].mean() < 2 / stiffness
    summary = test.summary()
    assert summary["residual_max"] == 0
    assert summary["dt"] < 0.02 * test.time_unit
    assert 0 < summary["friction_mobilization"] <= 1 and summary["sin_phi"] > 0
    friction = {(max(i.id1, i.id2) in test.walls): i.phys.tangensOfFrictionAngle
                for i in O.interactions}
    assert friction == {True: 0, False: pytest.approx(0.5)}


def test_checkpoint_of_springs(tmp_path):
    test = Biaxial.prepare(eta=0.3, particles=20, seed=1, law="smooth")
    test.compact()
    test.shear_record()
    test.save(tmp_path)
    again = Biaxial.load(tmp_path)
    assert again.parameters == test.parameters
    again.shear_record()
    assert len(again.rows) == 2


def test_the_critical_time_step_counts_light_clumps_and_lids():
    """Light clumps vibrate faster, as a lid of a hundredth of a grain on six grains."""
    found = []
    for mass in (1.0, 0.01):
        build(law="smooth")
        rcr.clump([rcr.disc((x, 0), 0.1, material=material()) for x in (-0.1, 0.1)], mass=mass)
        found.append(rcr.critical_time_step())
    assert found[0] == pytest.approx(10 * found[1], rel=1e-9)
    rough = springy(0.3)
    grains = [rcr.disc((0.1 + 0.2 * k, 0.1), 0.1, rough) for k in range(6)]
    mass = 0.01 * grains[0].state.mass
    weightless(rcr.wall("y", 0, +1, material=rough), *grains,
               rcr.mobile_wall("y", 0.2, mass, -1, material=rough), law="smooth")
    lid = len(O.bodies) - 1
    O.forces.setPermF(lid, (0, -100, 0))
    O.dt = 0.5 * rcr.critical_time_step()
    O.run(3000, True)
    assert O.bodies[lid].state.pos[1] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize("mass", [0, 1, 1000])
def test_the_critical_time_step_of_a_hinged_segment_is_that_of_its_rotation(mass):
    """√4 = 2 points at each end: dt ≤ 2/√(2 z k a²/I); a = 0.2 m bounds the corners of the Facet."""
    hinged = rcr.segment((-0.1, 0), (0.1, 0), material=springy(0.3))
    hinged.state.blockedDOFs, hinged.state.inertia = "xyzXY", (1, 1, 1e-4)
    hinged.state.mass = mass
    heavy = [rcr.disc((2 * k, 5), 0.1, springy(0.3)) for k in range(4)]
    build(hinged, *heavy, law="smooth")
    for body in O.bodies:
        if body.id > 0:
            body.state.mass, body.state.inertia = 1e6, (1e6, 1e6, 1e6)
    stiffness = 1e7 * 0.1
    assert rcr.critical_time_step() == pytest.approx(
        2 / math.sqrt(2 * 2 * stiffness * 0.2**2 / 1e-4), rel=0.05)


def test_a_body_without_shape_or_material_bounds_no_time_step():
    build(rcr.disc((0, 1), 0.1, springy(0.3)), law="smooth")
    expected = rcr.critical_time_step()
    for shape in (None, yade.wrapper.Sphere(radius=0.1)):
        marker = yade.wrapper.Body()
        marker.shape = shape
        marker.state.blockedDOFs = "zXY"
        O.bodies.append(marker)
    assert rcr.critical_time_step() == expected


def test_the_critical_time_step_reads_matches():
    """A match counts for its two materials, then the value for other pairs; else E R counts."""
    steps_of = []
    for make in (lambda one, two: None,
                 lambda one, two: MatchMaker(matches=((one.id, two.id, 100 * KN),)),
                 lambda one, two: MatchMaker(matches=((one.id, one.id, 100 * KN),)),
                 lambda one, two: MatchMaker(matches=((two.id, two.id, 100 * KN),)),
                 lambda one, two: MatchMaker(algo="val", val=400 * KN,
                                             matches=((one.id, one.id, 100 * KN),)),
                 lambda one, two: MatchMaker(algo="val", val=KN,
                                             matches=((two.id, one.id, 100 * KN),))):
        build(law="smooth")
        one, two = (O.materials[O.materials.append(springy(young=KN / 0.1))] for _ in range(2))
        O.bodies.append(rcr.disc((0, 0), 0.1, material=one))
        O.bodies.append(rcr.disc((1, 0), 0.1, material=two, fixed=True))
        functor = O.engines[2].physDispatcher.functors[0]
        if maker := make(one, two):
            functor.kn = functor.ks = maker
        steps_of.append(rcr.critical_time_step())
    given = 2 / math.sqrt(12 * 100 * KN * 2 / O.bodies[0].state.mass)  # I = m R²/2, k_s = k_n
    assert steps_of[1:4] == pytest.approx([given, given, steps_of[0]], rel=1e-9)
    assert steps_of[4:] == pytest.approx([0.5 * given, given], rel=1e-9)


@pytest.mark.parametrize("clumped", [False, True])
def test_the_drive_of_springs_is_booked(clumped):
    """A driven disc, or clump of two, pushes a free disc: the drive gives its kinetic energy."""
    rough = springy()
    springs(rcr.disc((0.2001, 0), 0.1, rough), gravity=(0, 0, 0))
    discs = [rcr.disc((x, 0), 0.1, rough) for x in ((0, -0.15) if clumped else (0,))]
    driven = rcr.clump(discs)[0] if clumped else O.bodies.append(discs[0])
    set_state(driven, vel=(0.1, 0, 0), blockedDOFs="xyzXYZ")
    O.trackEnergy = True
    while O.bodies[0].state.vel[0] < 0.19:  # it leaves at twice the velocity of the drive
        O.step()
    O.run(20, True)
    assert O.energy["driveWork"] == pytest.approx(-0.5 * O.bodies[0].state.mass * 0.2**2, rel=0.02)


def rolling_disc(angle, rolling_friction, **options):
    """A disc on an incline of this angle [rad] under springs with rolling resistance; its state."""
    disc = on_floor(0, height=0.1, gravity=(G * math.sin(angle), -G * math.cos(angle), 0),
                    damping=0.3, **options)
    O.engines[2].lawDispatcher.functors[0].rollingFriction = rolling_friction
    return O.bodies[disc].state


@pytest.mark.parametrize("rolling_friction", [0.05, 0.2])
def test_a_disc_rolls_down_an_incline(rolling_friction):
    """a = (2/3) g (sin α − µ_r cos α), as under rigid contacts."""
    angle = 0.3
    disc = rolling_disc(angle, rolling_friction)
    expected = 2 / 3 * G * (math.sin(angle) - rolling_friction * math.cos(angle))
    O.run(int(0.05 / O.dt), True)
    speed, time = disc.vel[0], O.time
    O.run(int(1 / O.dt), True)
    # the undamped slider swings by 7 mm/s
    assert (disc.vel[0] - speed) / (O.time - time) == pytest.approx(expected, abs=0.014)
    assert -disc.angVel[2] * 0.1 == pytest.approx(disc.vel[0], abs=0.014)
    (contact,) = O.interactions
    bound = rolling_friction * 0.1 * contact.phys.force1[0]
    assert abs(contact.phys.rollingMoment) == pytest.approx(bound, rel=1e-9)


def test_a_disc_rests_on_an_incline():
    """Its moment is W R sin α for tan α < µ_r. Without a dashpot it swings about it."""
    angle = 0.15
    disc = rolling_disc(angle, 0.2, local_damping=0.3)
    O.run(int(1 / O.dt), True)
    (contact,) = O.interactions
    assert disc.vel.norm() < 1e-5
    expected = disc.mass * G * 0.1 * math.sin(angle)
    assert abs(contact.phys.rollingMoment) == pytest.approx(expected, rel=2e-3)
    network = rcr.contact_network()
    assert abs(network.contacts["rolling_moment"][0]) == pytest.approx(expected, rel=2e-3)


def test_rolling_resistance_closes_the_energy():
    """Discs and rods that fall into a heap, with contacts of one point and of two."""
    m, rng = springy(0.4), np.random.default_rng(2)
    grains = [rcr.particle((0.22 * (k % 4), 0.12 + 0.22 * (k // 4)), 0.1, 0.3 * (k % 2),
                           rng.uniform(0, 3), m) for k in range(16)]
    build(rcr.wall("y", 0, material=m), *grains, law="smooth", damping=0.2, rollingFriction=0.2)
    O.dt = 0.05 * rcr.critical_time_step()
    O.trackEnergy = True
    O.step()
    height = lambda: sum(b.state.mass * G * b.state.pos[1] for b in grains)
    start, before = O.energy.total(), height()
    O.run(int(0.6 / O.dt), True)
    assert any(i.phys.rollingMoment for i in O.interactions if i.isReal)
    assert O.energy.total() == pytest.approx(start, abs=0.01 * (before - height()))


def test_a_rolling_coefficient_below_zero_is_refused():
    refused("rollingFriction = -0.1; expected a coefficient of 0",
            rcr.Law2_RcrGeom_FrictPhys_CundallStrack, rollingFriction=-0.1)
