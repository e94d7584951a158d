"""ContactDynamics against a plain reference in Python (moreau.py), where the solution is unique."""

import math

import moreau
import numpy as np
import pytest
from scenes import EXACT, build, gaps, material, stadium, tilted, velocity, walls
from yade import O

DT = 2e-3
STEPS = 120
CLOSE = dict(EXACT, correction=0)  # position correction is no part of Moreau's step
ROUNDING = 1e-8  # m/s, both solve to a residual of 1e-10 or better, at velocities of 1 m/s


def bodies_of_scene():
    """The bodies of YADE's scene as the reference has them."""
    bodies = []
    for b in O.bodies:
        center = np.array(b.state.pos)[:2]
        if hasattr(b.shape, "sense"):
            angle = 0 if b.shape.axis else math.pi / 2
            bodies.append(moreau.Body(center, angle, half_length=100, radius=0))
            continue
        angle = 2 * math.atan2(b.state.ori[2], b.state.ori[3])
        body = moreau.Body(center, angle, b.shape.halfLength, b.shape.capRadius,
                           velocity=velocity(b.id))
        if b.dynamic:
            body.mass, body.inertia = b.state.mass, b.state.inertia[2]
        bodies.append(body)
    return bodies


def throw(speed, seed):
    rng = np.random.default_rng(seed)
    for b in O.bodies:
        if b.dynamic:
            b.state.vel = (*rng.uniform(-speed, speed, 2), 0)
            b.state.angVel = (0, 0, rng.uniform(-speed, speed) / 0.1)


def discs_in_a_box():
    discs = [stadium(0, 0.1, (0.11 + 0.21 * (k % 3) + 0.01 * k, 0.12 + 0.22 * (k // 3)),
                     material=material(0)) for k in range(6)]
    build(*walls(material(0), x=(0, 0.75), y=[0]), *discs, dt=DT, **CLOSE)
    throw(0.5, 1)


def rods_in_a_box():
    rods = [stadium(0.1, 0.05, (0.2 + 0.4 * (k % 2), 0.15 + 0.3 * (k // 2)), 0.4 * k,
                    material=material(0)) for k in range(6)]
    build(*walls(material(0), x=(0, 0.8), y=[0]), *rods, dt=DT, **CLOSE)
    throw(0.3, 2)


def bouncing_discs():
    """Frictionless discs with restitution 0.7 on a fixed rod, one contact each."""
    discs = [stadium(0, 0.1, (0.4 * k, 0.2 + 0.02 * k), material=material(0)) for k in range(4)]
    rod = stadium(3, 0.05, (0, 0), 0.0, material=material(0), fixed=True)
    build(rod, *discs, dt=DT, restitution=0.7, **CLOSE)


def slope():
    """A rod and a disc on a slope, with friction that does not hold them."""
    pair = [stadium(a, 0.1, (x, 0.1), material=material(0.3)) for a, x in ((0.2, 0), (0, 1))]
    build(*walls(material(0.3), y=[0]), *pair, dt=DT, gravity=tilted(math.atan(1.2)), **CLOSE)


def ladder():
    """A rod that slides down between a rough floor and a rough wall."""
    theta, a, r = 0.9, 0.5, 0.05
    center = (r + a * math.cos(theta), r + a * math.sin(theta))
    rod = stadium(a, r, center, math.pi - theta, material=material(0.2))
    build(*walls(material(0.2), x=[0], y=[0]), rod, dt=DT, **CLOSE)


def rolling_pile():
    """A disc with friction on two fixed ones: isostatic while it rests, then pushed over."""
    base = [stadium(0, 0.1, (x, 0.1), material=material(0.5), fixed=True) for x in (-0.11, 0.11)]
    height = 0.1 + math.sqrt(0.2**2 - 0.11**2)
    build(*base, stadium(0, 0.1, (0, height), material=material(0.5)), dt=DT, **CLOSE)
    O.bodies[2].state.vel = (0.8, 0, 0)


def flat_rod():
    """A rod with friction that slides on the floor on both its ends and comes to rest."""
    rough = material(0.4)
    build(*walls(rough, y=[0]), stadium(0.3, 0.1, (0, 0.1), material=rough), dt=DT, **CLOSE)
    O.bodies[1].state.vel = (0.3, 0, 0)


SCENES = [(discs_in_a_box, 0.0, 0.0), (rods_in_a_box, 0.0, 0.0), (bouncing_discs, 0.0, 0.7),
          (slope, 0.3, 0.0), (ladder, 0.2, 0.0), (rolling_pile, 0.5, 0.0), (flat_rod, 0.4, 0.0)]


def linear():
    """True if all biases of the last step were max(gap, 0)/dt: no point turned far within it."""
    points = [(i.geom.gap[k], i.phys.bias[k]) for i in O.interactions for k in range(i.geom.points)]
    return all(abs(bias - max(gap, 0) / O.dt) < 1e-9 for gap, bias in points)


@pytest.mark.parametrize("scene, friction, restitution", SCENES)
def test_velocities_after_each_step_agree(scene, friction, restitution):
    """Each step starts from the state in YADE, so that differences do not add up."""
    scene()
    gravity = tuple(O.engines[-1].gravity)[:2]
    closed = compared = 0
    for number in range(STEPS):
        bodies = bodies_of_scene()
        _, impulses, residual = moreau.step(bodies, O.dt, gravity, friction, restitution)
        assert residual <= 1e-10
        O.step()
        if restitution or linear():
            worst = max(np.abs(found.velocity - expected.velocity).max()
                        for found, expected in zip(bodies_of_scene(), bodies))
            assert worst < ROUNDING, f"step {number}"
            compared += 1
            closed += (impulses[:, 0] > 0).sum()
    assert closed > 5 and compared > 0.9 * STEPS


@pytest.mark.parametrize("scene, friction", [(s[0], s[1]) for s in SCENES if not s[2]])
def test_energy_and_overlap_agree_in_the_long_run(scene, friction):
    scene()
    gravity = tuple(O.engines[-1].gravity)[:2]
    bodies = bodies_of_scene()
    start = sum(moreau.energy(bodies, gravity))
    for _ in range(STEPS):
        points, _, _ = moreau.step(bodies, O.dt, gravity, friction)
        O.step()
    lost = start - sum(moreau.energy(bodies, gravity))
    found = start - sum(moreau.energy(bodies_of_scene(), gravity))
    assert found == pytest.approx(lost, rel=2e-3)  # impacts come a step earlier or later
    assert min(gaps()) > min(0, *(p.gap for p in points)) - 1e-9  # of the last step
