"""Steps of a biaxial test in intervals, and the record of each interval. Needs YADE."""

import typing

import numpy as np
from yade.wrapper import Omega

from rcr.study.protocol import PROTOCOL

O = Omega()

COUNTERS = dict(  # of the shear, in `Biaxial.progress`
    residual_max=0.0, missed=0, missed_sum=0.0, missed_max=0.0, yielded=0,
    divisor=1,  # of the time step
    failed_strain=0.0,  # strain up to which the divisor applies
    repeated=0,  # number of parts of the shear that a smaller time step has repeated
)  # fmt: skip


class Springs:
    """Stand-in for `ContactDynamics` under the smooth law, which has no iterations."""

    tolerance = residual = 0.0
    iterations = threads = 0

    @property
    def contactPoints(self):
        """Number of contact points."""
        return sum(i.geom.points for i in O.interactions if i.isReal)


class Record(typing.NamedTuple):
    """State of the test after an interval of steps, with means and counts of the interval."""

    step: int
    time: float  # [s]
    width: float  # [m]
    height: float  # [m]
    stresses: np.ndarray  # means of σ_x and σ_y on the walls [Pa], compression positive
    points: int  # contact points of the last step
    iterations: int  # of the last step
    residual: float  # of the last step [-]
    unconverged: int = 0  # steps of the interval that missed the tolerance
    yielded: int = 0  # steps of the interval without a solution


def make_records(test, count, times=1):
    """Make `times` intervals of `count` steps; set `test.records`, one for each interval."""
    test.records = []
    if isinstance(test.solver, Springs):
        for _ in range(times):
            _step_smooth(test, count)
    else:
        _step_rigid(test, count, times)


def _step_smooth(test, count):
    stresses = []
    for left in reversed(range(count)):
        O.step()
        if left % PROTOCOL.smooth_stride == 0:
            stresses.append(test.wall_stresses())
    mean, solver = np.mean(stresses, axis=0), test.solver
    state = O.iter, O.time, test.width, test.height, mean
    test.records.append(Record(*state, solver.contactPoints, solver.iterations, solver.residual))


def _step_rigid(test, count, times):
    solver = test.solver
    solver.observe = [test.left, test.right, test.bottom, test.top]
    solver.observeEvery = count
    solver.observed()  # discards what earlier steps left
    solver.observations()
    width, height = test.width, test.height
    try:
        if count * times == 1:
            O.step()
        else:
            O.run(count * times, True)
    finally:
        solver.observeEvery = 0
        for observation in solver.observations():
            _add_record(test, observation, width, height)
            width, height = test.records[-1].width, test.records[-1].height


def _add_record(test, observation, width, height):
    """Add an observation of the solver that began at a width and a height."""
    left, right, bottom, top = test.solver.observe
    positions, forces = observation["positions"], observation["forces"]
    before = np.array([height, height, width, width])
    width = positions[right][0] - positions[left][0]
    height = positions[top][1] - positions[bottom][1]
    lengths = (before + [height, height, width, width]) / 2
    pairs = zip(test.solver.observe, (0, 0, 1, 1))
    force = [abs(forces[wall][axis]) for wall, axis in pairs]
    stresses = (force / lengths).reshape(2, 2).mean(axis=1)
    yielded = observation["yielded"]
    test.records.append(
        Record(observation["step"], observation["time"], width, height, stresses,
               observation["points"], observation["last_iterations"],
               observation["last_residual"], max(0, observation["missed"] - yielded), yielded)
    )  # fmt: skip
    progress = test.progress
    for name in ("iterations", "missed", "missed_sum", "yielded"):
        progress[name] += observation[name]
    progress["residual_max"] = max(progress["residual_max"], observation["residual"])
    progress["missed_max"] = max(progress["missed_max"], observation["missed_largest"])
