"""Steps of a biaxial test in intervals, and the record of each interval. Needs YADE."""

import numpy as np
from yade.minieigenHP import Vector3
from yade.wrapper import Omega

from rcr.study.protocol import PROTOCOL

O = Omega()

COUNTERS = dict(  # of the shear, in `Biaxial.progress`
    residual_max=0.0, missed=0, missed_sum=0.0, missed_max=0.0, yielded=0,
    divisor=1,  # of the time step
    failed_strain=0.0,  # strain up to which the divisor applies
    repeated=0,  # number of parts of the shear that a smaller time step has repeated
    rate=0.0,  # I at the present strain
)  # fmt: skip

HISTORY_COLUMNS = ("step", "time", "strain", "sin_phi", "stress_x", "stress_y", "packing_fraction",
                   "points", "iterations", "residual", "unconverged_steps", "yielded_steps")


class Springs:
    """Stand-in for `ContactDynamics` in scenes with springs."""

    threads = 0

    @property
    def contactPoints(self):
        """Number of contact points."""
        return sum(i.geom.points for i in O.interactions if i.isReal)


def make_records(test, count, times, speeds=None):
    """Make `times` intervals of `count` steps; set `test.records`, one dict for each interval.

    `speeds` drives the top wall: (count,) speeds downwards [m/s], equal ones if `times` > 1.

    It has the state after the interval, `HISTORY_COLUMNS` that belong to it, width and height [m].
    Wall stresses are means of the interval [Pa], compression positive. `points`, `iterations` and
    `residual` are those of the last step.
    """
    test.records = []
    if isinstance(test.solver, Springs):
        for _ in range(times):
            _step_smooth(test, speeds)
    else:
        _step_rigid(test, count, times, speeds)


def _drive(test, speed):
    O.bodies[test.top].state.vel = Vector3(0, -speed, 0)


def _step_smooth(test, speeds):
    stresses = []
    for left, speed in zip(reversed(range(len(speeds))), speeds):
        _drive(test, speed)
        O.step()
        if left % PROTOCOL.smooth_stride == 0:
            stresses.append(test.wall_stresses())
    x, y = np.mean(stresses, axis=0).tolist()
    test.records.append(dict(
        step=O.iter, time=O.time, width=test.width, height=test.height, stress_x=x, stress_y=y,
        points=test.solver.contactPoints, iterations=0, residual=0.0, unconverged_steps=0,
        yielded_steps=0))


def _step_rigid(test, count, times, speeds):
    solver = test.solver
    solver.observe = [test.left, test.right, test.bottom, test.top]
    solver.observeEvery = count
    solver.observations()  # discards entries of earlier steps
    width, height = test.width, test.height
    try:
        for speed, steps in _runs(count * times, speeds):
            if speed is not None:
                _drive(test, speed)
            if steps == 1:
                O.step()
            else:
                O.run(steps, True)
    finally:
        solver.observeEvery = 0
        for observation in solver.observations():
            _add_record(test, observation, width, height)
            width, height = (test.records[-1][name] for name in ("width", "height"))


def _runs(steps, speeds):
    """Return the runs of YADE, each a speed of the top wall and a number of steps."""
    if speeds is None:
        return [(None, steps)]
    if (speeds == speeds[0]).all():
        return [(speeds[0], steps)]
    return [(speed, 1) for speed in speeds]


def _add_record(test, observation, width, height):
    """Add an observation of the solver that began at a width and a height."""
    left, right, bottom, top = test.solver.observe
    positions, forces = observation["positions"], observation["forces"]
    before = np.array([height, height, width, width])
    width = positions[right][0] - positions[left][0]
    height = positions[top][1] - positions[bottom][1]
    lengths = (before + [height, height, width, width]) / 2
    force = [abs(forces[wall][k // 2]) for k, wall in enumerate(test.solver.observe)]
    x, y = (force / lengths).reshape(2, 2).mean(axis=1).tolist()
    missed, yielded = observation["missed"], observation["yielded"]
    test.records.append(dict(
        step=observation["step"], time=observation["time"], width=width, height=height, stress_x=x,
        stress_y=y, points=observation["points"], iterations=observation["last_iterations"],
        residual=observation["last_residual"], unconverged_steps=max(0, missed - yielded),
        yielded_steps=yielded))
    progress = test.progress
    for name in ("iterations", "missed", "missed_sum", "yielded"):
        progress[name] += observation[name]
    progress["residual_max"] = max(progress["residual_max"], observation["residual"])
    progress["missed_max"] = max(progress["missed_max"], observation["missed_largest"])
