"""Scenes of known solution. Docstrings give the formulas, in the plane and per unit depth."""

import math

import numpy as np
import pytest
import rcr
from rcr import _kernel
from scenes import (EXACT, G, assert_reload_changes_nothing, box, build, grain_on_floor, inertia,
                    material, open_box, pile, plane, point_forces, solver, stadium, steps,
                    tilted, velocity)
from yade import O
from yade import wrapper as w

DT = 1e-3
MU = 0.5
STILL = 1e-11  # rounding of gravity's dt g = 1e-2 over some steps [m/s]
ROUNDING = 1e-12  # relative: a few dozen operations
slightly = pytest.mark.parametrize("factor", [0.99, 1.01], ids=["below", "above"])


@pytest.mark.parametrize("eta", [0, 0.3, 0.7, 0.95])
@pytest.mark.parametrize("angle", [0, 1.0])
def test_particle_has_the_mass_centre_and_inertia_of_its_shape(eta, angle):
    """m = ρ A and I = ρ ∫ |x|² dA, which tests/kernel compares with integrals."""
    R, density = 0.3, 2600.0
    core = eta * R, (1 - eta) * R
    state = rcr.particle((1, 2), R, eta, angle, material(density=density)).state
    assert state.mass == pytest.approx(density * _kernel.area(*core), rel=ROUNDING)
    assert state.inertia[2] == pytest.approx(density * _kernel.polar_moment(*core), rel=ROUNDING)
    assert tuple(state.pos) == (1, 2, 0) and state.blockedDOFs == "zXY"


def floor_and_slope(kind, alpha, body, mu):
    """(id, direction down) of a body on a wall under tilted gravity, or on a turned box."""
    a, r, angle = body
    turned = 0 if kind == "wall" else alpha
    down = np.array([math.cos(turned), -math.sin(turned)])
    up = np.array([math.sin(turned), math.cos(turned)])
    floor = (rcr.wall("y", 0, material=material(mu)) if kind == "wall"
             else box(-0.5 * up, (5, 0.5), -alpha, material(mu)))
    _, i = build(floor, stadium(a, r, (r + a * abs(math.sin(angle))) * up, angle - turned,
                                material=material(10)), gravity=tilted(alpha - turned))
    return i, down


on_slopes = pytest.mark.parametrize("kind", ["wall", "box"])


@on_slopes
@slightly
def test_flat_slider_on_a_slope(kind, factor):
    """A flat RCR sticks for tan α ≤ µ, else a = g (sin α − µ cos α)."""
    alpha = math.atan(factor * MU)
    slider, down = floor_and_slope(kind, alpha, (0.4, 0.1, 0), MU)
    steps(50)
    v = velocity(slider)
    expected = max(0, G * (math.sin(alpha) - MU * math.cos(alpha)))
    assert v[:2] @ down / (50 * DT) == pytest.approx(expected, abs=1e-10 * G)
    assert v[2] == pytest.approx(0, abs=1e-10)  # no rotation


@on_slopes
@slightly
def test_disc_on_a_slope(kind, factor):
    """Rolls for tan α ≤ µ (1 + mR²/I): a = g sin α/(1 + I/(mR²)), ω = −v/R; else it slides:
    a = g (sin α − µ cos α), ω' = −µ m g cos α R/I.
    """
    R = 0.2
    m, I = inertia(0, R)
    alpha = math.atan(factor * MU * (1 + m * R**2 / I))
    disc, down = floor_and_slope(kind, alpha, (0, R, 0), MU)
    steps(50)
    v = velocity(disc)
    if factor < 1:
        linear = G * math.sin(alpha) / (1 + I / (m * R**2))
        angular = -linear / R
    else:
        linear = G * (math.sin(alpha) - MU * math.cos(alpha))
        angular = -MU * m * G * math.cos(alpha) * R / I
    assert v[:2] @ down / (50 * DT) == pytest.approx(linear, rel=1e-10)
    assert v[2] / (50 * DT) == pytest.approx(angular, rel=1e-10)


@on_slopes
@slightly
def test_block_on_a_slope_tips_over_its_lower_edge(kind, factor):
    """Tips about its core's end for tan α > a/r: ω' = −m g (r sin α − a cos α)/(I + m(a² + r²))."""
    a, r = 0.3, 0.5
    alpha = math.atan(factor * a / r)
    block, _ = floor_and_slope(kind, alpha, (a, r, 0), 2.0)
    steps(1)  # the lever arm changes later
    m, I = inertia(a, r)
    torque = -m * G * (r * math.sin(alpha) - a * math.cos(alpha))
    expected = min(0, torque / (I + m * (a**2 + r**2)))
    assert velocity(block)[2] / DT == pytest.approx(expected, abs=1e-10 * G / r)


@pytest.mark.parametrize("angle", [0.2, 0.8, 1.5, math.pi / 2, 2.5])
def test_rcr_starts_to_rock_about_its_contact(angle):
    """On one cap without sliding ω' = −m g x/(I + m (x² + y²)), (x, y) from contact to centre."""
    a, r = 0.4, 0.1
    rod = grain_on_floor(a, 100, r + a * math.sin(angle), angle)
    steps(1)
    m, I = inertia(a, r)
    x, y = a * math.cos(angle), r + a * math.sin(angle)
    expected = -m * G * x / (I + m * (x * x + y * y))
    assert velocity(rod)[2] / DT == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_rcr_rocks_and_keeps_its_energy():
    """Rolling on a cap has no losses: E is constant up to O(dt)."""
    a, r = 0.4, 0.1
    m, I = inertia(a, r)
    losses = []
    for dt in (1e-3, 5e-4):
        rod = grain_on_floor(a, 100, r + a * math.sin(1.2), 1.2, dt=dt)
        height = O.bodies[rod].state.pos[1]
        steps(round(0.2 / dt))
        v = velocity(rod)
        gained = 0.5 * m * v[:2] @ v[:2] + 0.5 * I * v[2] ** 2
        losses.append(1 - gained / (m * G * (height - O.bodies[rod].state.pos[1])))
    assert abs(losses[0]) < 0.03  # g dt/v at v = 1 m/s, of the leapfrog's potential energy
    assert losses[1] == pytest.approx(losses[0] / 2, rel=0.1)  # first order


@pytest.mark.parametrize("theta", [0.7, 1.0, 1.3])
@pytest.mark.parametrize("factor", [0.999, 1.001], ids=["above", "below"])
def test_ladder_against_a_smooth_wall(theta, factor):
    """Moments about the foot: N_wall (r + 2a sin θ) = m g a cos θ, N_wall = F ≤ µ m g."""
    a, r = 1.0, 0.05
    mu = factor * a * math.cos(theta) / (r + 2 * a * math.sin(theta))
    *_, ladder = build(rcr.wall("y", 0, material=material(mu)),
                       rcr.wall("x", a * math.cos(theta) + r, material=material(0)),
                       stadium(a, r, (0, r + a * math.sin(theta)), theta, material=material(10)))
    steps(5)
    speed = abs(velocity(ladder)[2])
    assert speed > 1e-6 if factor < 1 else speed < STILL


@pytest.mark.parametrize("where", ["discs", "floor"])
@slightly
def test_pyramid_of_three_discs(where, factor):
    """One disc on two: N and T act at 30° to the vertical, the lower disc is free of torque, F = T.

        N sin 30° = T cos 30° + F  ⟹  T/N = sin 30°/(1 + cos 30°) = tan(π/12)
        2 (N cos 30° + T sin 30°) = W  ⟹  N = W/2, at the floor F/(3W/2) = tan(π/12)/3
    """
    critical = {"discs": math.tan(math.pi / 12), "floor": math.tan(math.pi / 12) / 3}
    mu = {"discs": 1.0, "floor": 1.0, where: factor * critical[where]}
    R = 0.1
    discs = material(mu["discs"])
    build(rcr.wall("y", 0, material=material(mu["floor"])), *(
        stadium(0, R, at, material=discs) for at in [(-R, R), (R, R), (0, R + math.sqrt(3) * R)]))
    for i in (1, 2, 3):  # the smaller angle counts, so that the discs do not limit the floor
        O.bodies[i].material = discs if where == "discs" else material(1.0)
    steps(5)
    top = -velocity(3)[1]
    assert top < STILL if factor > 1 else top > 1e-6


@pytest.mark.parametrize("support", ["rcr", "box"])
@pytest.mark.parametrize("shift", [0.0, 0.1, 0.25, 0.39, 0.41, 0.5])
def test_eccentric_load_is_shared_by_the_lever_rule_or_tips(support, shift):
    """On its own end at s − a and the support's edge at a: N₁ = W (a − s)/(2a − s), N₂ = W − N₁.

    s > a leaves one point at the edge: ω' = −m g x/(I + m (x² + r²)), x = s − a.
    """
    a, r, x = 0.4, 0.1, shift - 0.4
    rough, (m, I) = material(100.0 if x > 0 else 0.5), inertia(a, r)
    below = (stadium(a, r, (0, -r), material=rough, fixed=True) if support == "rcr"
             else box((0, -0.3), (a, 0.3), material=rough))
    lower, upper = build(below, stadium(a, r, (shift, r), material=rough))
    steps(1 if x > 0 else 20)
    if x > 0:
        expected = -m * G * x / (I + m * (x * x + r * r))
        assert velocity(upper)[2] / DT == pytest.approx(expected, rel=1e-10)
    else:
        expected = m * G / (2 * a - shift) * np.array([a - shift, a])
        assert point_forces(lower, upper)[:, 0] == pytest.approx(expected, rel=1e-10)
        assert velocity(upper) == pytest.approx(0, abs=STILL)


def test_zigzag_column_presses_like_a_fluid():
    """Frictionless discs stacked from wall to wall at tan φ = Δx/Δy: disc k presses its wall by
    (2k − 1) W tan φ, the bottom one by (n − 1) W tan φ.
    """
    n, R, dx = 20, 0.1, 0.09
    dy = math.sqrt(4 * R * R - dx * dx)
    smooth = material(0)
    m, _ = inertia(0, R)
    discs = [stadium(0, R, (R + dx * (k % 2), R + k * dy), material=smooth) for k in range(n)]
    ids = build(*open_box(2 * R + dx, smooth), *reversed(discs),
                **EXACT | dict(maxIterations=1_000_000))
    steps(3)
    expected = (2 * np.arange(1, n + 1) - 1.0) * m * G * dx / dy
    expected[-1] = (n - 1) * m * G * dx / dy
    walls = [point_forces((n - 1 - k) % 2, ids[3 + k])[0, 0] for k in range(n)]
    assert walls == pytest.approx(expected, rel=1e-10)
    assert -O.forces.f(2)[1] == pytest.approx(n * m * G, rel=1e-10)


def test_resting_pile_presses_with_its_weight():
    grains = pile(30, dt=4e-3, tolerance=1e-6, maxIterations=5000)
    steps(3000)
    solver().tolerance, solver().maxIterations = 1e-13, 200_000
    steps(5)
    weight = G * sum(b.state.mass for b in grains)
    force = sum(np.array(O.forces.f(i)) for i in range(3))
    replay = f"residual {solver().residual:g} after {solver().iterations} iterations"
    assert force[:2] == pytest.approx([0, -weight], abs=1e-8 * weight), replay


def test_free_flight_is_that_of_the_symplectic_scheme():
    """v_n = v₀ + n dt g, x_n = x₀ + n dt v₀ + n(n+1)/2 dt² g, θ_n = θ₀ + n dt ω."""
    (body,) = build(stadium(0.2, 0.1, (1, 2), 0.3))
    state = O.bodies[body].state
    state.vel, state.angVel = (3, 4, 0), (0, 0, 1.5)
    n = 200
    steps(n)
    assert velocity(body) == pytest.approx([3, 4 - G * n * DT, 1.5], rel=ROUNDING)
    place = (1 + 3 * n * DT, 2 + 4 * n * DT - G * DT**2 * n * (n + 1) / 2, 0)
    assert tuple(state.pos) == pytest.approx(place, rel=ROUNDING)
    angle = 2 * math.atan2(state.ori[2], state.ori[3])
    assert angle == pytest.approx(0.3 + 1.5 * n * DT, rel=ROUNDING)


def test_plastic_disc_closes_its_gap_and_rests():
    """e = 0: the last gap closes within one step, v = −gap/dt; the next step stops the disc."""
    h, R = 0.5, 0.1
    disc = grain_on_floor(0, height=R + h)
    steps(round(math.sqrt(2 * h / G) / DT) + 3)  # a few steps after the impact
    assert velocity(disc) == pytest.approx(0, abs=STILL)
    assert O.bodies[disc].state.pos[1] == pytest.approx(R, abs=STILL * DT)


@pytest.mark.parametrize("e", [0.3, 0.8, 1.0])
def test_disc_bounces(e):
    """v⁺ = −e v⁻ in the step of the impact; the apexes are at e^{2n} h, up to a step's way v dt."""
    h, R = 0.5, 0.1
    disc = grain_on_floor(0, height=R + h, restitution=e)
    count, bounces = {0.3: (500, 1), 0.8: (1300, 2), 1.0: (1000, 1)}[e]
    apexes, before = [], 0.0
    for _ in range(count):
        O.step()
        v = velocity(disc)[1]
        if before < -10 * G * DT and v > before:  # an impact, no resting contact
            assert v == pytest.approx(-e * before, rel=ROUNDING, abs=STILL)
        if before > 0 >= v:
            apexes.append(O.bodies[disc].state.pos[1] - R)
        before = v
    speed = math.sqrt(2 * G * h)
    assert len(apexes) >= bounces
    for n, apex in enumerate(apexes[:bounces], start=1):
        assert apex == pytest.approx(e ** (2 * n) * h, abs=2 * n * speed * DT)


def test_half_step_start_takes_gravity_and_permanent_loads_of_what_is_free():
    """Velocities at the present time make x = a t²/2 exact; test_chart.py has the order."""
    m = material()
    _, grain = build(rcr.wall("y", 0, material=m), stadium(0.2, 0.1, (0, 5), material=m), dt=1e-2)
    clump, members = rcr.clump([rcr.disc((3 + k, 5), 0.4, m) for k in range(2)])
    guided = O.bodies.append(rcr.particle((8, 5), 0.2, 0.5, material=m))
    O.bodies[guided].state.blockedDOFs = "xzXYZ"
    wall = O.bodies.append(rcr.mobile_wall("x", 20, 2.0, material=m))  # without inertia
    s = O.bodies[grain].state
    O.forces.setPermF(grain, (3 * s.mass, 0, 0))
    O.forces.setPermT(grain, (0, 0, 2 * s.inertia[2]))
    O.forces.setPermF(guided, (1, 0, 0))
    O.forces.setPermF(wall, (3, 0, 0))
    c = O.bodies[clump].state
    for member, turn in zip(members, (-1, 1)):  # forces make half of the torque
        O.forces.setPermF(member, (c.mass, turn * c.inertia[2] / 2, 0))
        O.forces.setPermT(member, (0, 0, c.inertia[2] / 4))
    starts = {i: O.bodies[i].state.pos for i in (grain, clump, guided, wall)}
    rcr.half_step_start()
    O.run(20, True)
    t = 20 * O.dt
    for i, (x, y) in {grain: (1.5 * t**2, -0.5 * G * t**2), clump: (t**2, -0.5 * G * t**2),
                      guided: (0, -0.5 * G * t**2), wall: (0.75 * t**2, 0)}.items():
        assert tuple(O.bodies[i].state.pos - starts[i]) == pytest.approx((x, y, 0), abs=1e-9), i
    assert s.rot()[2] == pytest.approx(t**2, abs=1e-9)
    assert c.rot()[2] == pytest.approx(0.5 * t**2, abs=1e-5)  # the arms turn with the clump


def test_half_step_start_leaves_a_pile_at_rest():
    m = material(friction=0.5)
    ids = build(rcr.wall("y", 0, material=m), *(stadium(0.2, 0.1, (0, 0.1 + 0.2 * k), material=m)
                                                for k in range(5)))
    rcr.half_step_start()
    O.run(100, True)
    assert max(O.bodies[i].state.vel.norm() for i in ids) < 1e-6
    assert max(O.bodies[i].state.displ().norm() for i in ids) < 1e-6


@pytest.mark.parametrize("together", [1, 50], ids=["single steps", "runs"])
@pytest.mark.parametrize("restitution", [0, 0.5, 0.9])
def test_a_shaken_wall_bears_what_rests_on_it(restitution, together):
    """F = M (g + a), a = g/2 cos ωt: no impact, whatever the restitution. Two discs and a rod."""
    omega, grain = 2 * math.pi * 5, material()
    shaken = w.HarmonicMotionEngine(ids=[0], A=(0, 0.5 * G / omega**2, 0), f=(0, 5, 0),
                                    fi=(0, math.pi, 0))
    grains = [rcr.disc((0, 0.1), 0.1, grain), rcr.disc((0, 0.3), 0.1, grain),
              stadium(0.1, 0.1, (1, 0.1), material=grain)]
    floor, *_ = build(rcr.wall("y", 0, +1), *grains, before=[shaken], restitution=restitution,
                      **EXACT | dict(observe=[0]))
    mass = sum(body.state.mass for body in grains)
    for k in range(0, 200, together):
        times = O.dt * np.arange(k, k + together)
        O.run(together, True)
        force = -solver().observed()["forces"][floor][1]
        if k:
            assert force == pytest.approx(
                mass * G * (1 + 0.5 * np.cos(omega * times).mean()), rel=0.03)


@pytest.mark.parametrize("arrays", [False, True])
@pytest.mark.parametrize("cell, rate", [(None, 0), (3, 0), (3, 0.05)])
def test_a_shaken_grain_bears_a_disc_in_a_cell_too(cell, rate, arrays):
    """Also in a cell that stretches along x at `rate` [1/s]."""
    omega, m = 2 * math.pi * 5, material()
    shaken = w.HarmonicMotionEngine(ids=[0], A=(0, 0.5 * G / omega**2, 0), f=(0, 5, 0),
                                    fi=(0, math.pi, 0))
    _, disc = build(rcr.particle((0, 1), 0.3, 0.5, fixed=True, material=m),
                    rcr.disc((0, 1.25), 0.1, m), cell=cell, before=[shaken], restitution=0.9,
                    **EXACT | dict(observe=[1], arrays=arrays))
    if rate:
        O.cell.velGrad = plane(rate, 0, 0, 0)
    weight = O.bodies[disc].state.mass * G
    for k in range(150):
        O.run(1, True)
        force = solver().observed()["forces"][disc][1]
        if k:
            expected = weight * (1 + 0.5 * math.cos(omega * k * O.dt))
            assert force == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("flow", [None, (0.2, 0.1, 0, -0.1)])
def test_a_drive_that_starts_hits_what_it_touches_in_arrays_too(flow):
    """Its velocity is 0 in the first step. `flow`: velocity gradient of a periodic cell [1/s]."""
    ends = []
    for arrays in False, True:
        shaken = w.HarmonicMotionEngine(ids=[0], A=(0, 0.001, 0), f=(0, 10, 0), fi=(0, math.pi, 0))
        floor = (rcr.particle((1, 1), 0.5, 0.8, fixed=True, material=material()) if flow else
                 rcr.wall("y", 0, +1))
        _, disc = build(floor, rcr.disc((1, 1.2) if flow else (0, 0.1), 0.1, material()),
                        before=[shaken], restitution=0.8, cell=3 if flow else None,
                        **EXACT | dict(arrays=arrays))
        if flow:
            O.cell.velGrad = plane(*flow)
        O.run(20, True)
        ends.append((*O.bodies[disc].state.pos, *O.bodies[disc].state.vel))
    assert ends[0] == ends[1]


def test_the_velocity_of_a_drive_survives_a_reload(tmp_path):
    shaken = w.HarmonicMotionEngine(ids=[0], A=(0, 0.001, 0), f=(0, 10, 0), fi=(0, math.pi, 0))
    grain = material()
    build(rcr.wall("y", 0, +1, material=grain), rcr.disc((0, 0.1), 0.1, grain), before=[shaken],
          restitution=0.8, observe=[0])
    steps(20)
    solver().observed()
    assert_reload_changes_nothing(
        tmp_path / "scene.xml.gz", lambda: [(O.step(), solver().observed()["forces"][0][1])[1]
                                             for _ in range(5)])


@pytest.mark.parametrize("ratio", [0.5, 2])
def test_a_shaken_wall_throws_a_disc_if_it_brakes_faster_than_gravity(ratio):
    """y = A (1 − cos ωt); if A ω² = 2 g, the disc leaves at cos ωt = −1/2 and flies to v²/2g."""
    omega, dt = 2 * math.pi * 10, 1e-5
    size = ratio * G / omega**2
    shaken = w.HarmonicMotionEngine(ids=[0], A=(0, size, 0), f=(0, 10, 0), fi=(0, math.pi, 0))
    floor, disc = build(rcr.wall("y", 0, +1), rcr.disc((0, 0.1), 0.1, material()), dt=dt,
                        before=[shaken], **EXACT)
    height = lambda t: size * (1 - math.cos(omega * t))
    if ratio < 1:
        time = 0.18
        highest = height(time)
    else:
        leaves = math.acos(-1 / ratio) / omega
        speed = size * omega * math.sin(omega * leaves)
        time, highest = leaves + speed / G, height(leaves) + speed**2 / (2 * G)
    steps(round(time / dt))
    rounding = 2 * size * omega * dt  # two steps at the largest speed
    assert O.bodies[floor].state.pos[1] == pytest.approx(height(time), abs=rounding)
    assert O.bodies[disc].state.pos[1] == pytest.approx(0.1 + highest, abs=rounding)
