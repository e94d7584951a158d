"""Grains that cut through each other within a step: the step has not converged, and it warns."""

import math

import numpy as np
import pytest
import rcr
from benchmarks import meetings
from scenes import material, solver, weightless
from yade import O

INSTANTS = np.linspace(0, 1, 401)  # of a step [-]
DT = meetings.DT


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def to_segments(points, ends):
    """Smallest distance of points (n, 2, 2) from segments with these ends (n, 2, 2), (n,)."""
    start, along = ends[:, :1], ends[:, 1:] - ends[:, :1]
    length = (along**2).sum(axis=-1)
    share = ((points - start) * along).sum(axis=-1) / np.where(length > 0, length, 1)
    feet = start + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points - feet, axis=-1).min(axis=1)


def distances(one, two):
    """Distances of two cores at each instant, 0 where they cross, (n,) [m]."""
    (a, b), (c, d) = (np.moveaxis(core, 1, 0) for core in (one, two))
    crossing = ((cross(b - a, c - a) * cross(b - a, d - a) < 0)
                & (cross(d - c, a - c) * cross(d - c, b - c) < 0))
    return np.where(crossing, 0, np.minimum(to_segments(one, two), to_segments(two, one)))


def poses():
    """Centre and angle of each body, (bodies, 3)."""
    return [(b.state.pos[0], b.state.pos[1], 2 * math.atan2(b.state.ori[2], b.state.ori[3]))
            for b in O.bodies]


def paths(starts, half_length):
    """Ends of the cores at INSTANTS of the step that has just moved the bodies from `starts`."""
    for (x, y, angle), body in zip(starts, O.bodies):
        (vx, vy, _), spin = body.state.vel, body.state.angVel[2]
        at = np.array([x, y]) + np.outer(INSTANTS, [vx, vy]) * DT
        turned = angle + INSTANTS * spin * DT
        along = half_length * np.column_stack([np.cos(turned), np.sin(turned)])
        yield np.stack([at - along, at + along], axis=1)


def meeting(seed, eta, path):
    """Steps of two grains of R = 1 m that meet: (missed, smallest distance of cores) of each.

    Their surfaces move by up to `path` in a step. The list ends once the overlap is nearly a cap
    radius, since later steps would begin with it.
    """
    found = []
    for _ in range(meetings.place(seed, eta, path)):
        starts, missed = poses(), solver().missedSteps
        O.step()
        least = distances(*paths(starts, eta)).min()
        found.append((solver().missedSteps > missed, least))
        if least < 1.03 * (1 - eta):
            break
    return found


@pytest.mark.parametrize("eta, path", [(0.6, 3), (0.8, 3), (0.9, 3), (0.98, 1), (0.999, 0.3)])
def test_a_step_misses_if_and_only_if_grains_intrude_on_their_paths(eta, path):
    """Their overlap exceeds the cap radius: cores come closer than this. Needles cross."""
    steps = np.array([step for seed in range(60) for step in meeting(seed, eta, path)])
    missed, distance, radius = steps[:, 0] == 1, steps[:, 1], 1 - eta
    intruding = distance < 0.97 * radius
    assert intruding.sum() >= 3 and not (intruding & ~missed).any()
    assert not (missed & (distance > 1.03 * radius + path / len(INSTANTS))).any()


@pytest.mark.parametrize("eta", [0, 0.6, 0.9, 0.99])
def test_grains_do_not_intrude_within_the_rule_for_the_time_step(eta):
    """docs/law.md: paths up to 0.3 R and 10 R′ in a step."""
    path = min(meetings.PATHS[0], meetings.CAPS * (1 - eta))
    steps = np.array([step for seed in range(60) for step in meeting(seed, eta, path)])
    assert steps[:, 1].min() > 0.97 * (1 - eta) and not steps[:, 0].any()


def test_an_intrusion_warns(capfd):
    """A needle cuts through the tip of another one between the beginning and the end of a step."""
    first = rcr.particle((1.225330466460918, -0.12891557850073654), 1, 0.999, 2.369080069250101,
                         material(0), velocity=(-2.1019308608546967, -202.65772220430106))
    second = rcr.particle((1.242485500169459, -1.3963221478896197), 1, 0.999, 2.942161597433343,
                          material(0), velocity=(-75.1299785803171, 146.18609460286267))
    weightless(first, second, dt=DT, tolerance=1e-8)
    for step in range(5):
        O.step()
        assert solver().missedSteps == (step >= 2) and solver().deepestOverlap < 1e-4
    told = capfd.readouterr().err
    (line,) = [line for line in told.splitlines() if "ContactDynamics" in line]
    assert "In 1 step bodies moved into each other by more than a cap radius" in line
    assert line.rstrip().endswith("in this step: bodies #0 and #1.")
