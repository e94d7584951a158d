"""The biaxial test of Azéma and Radjaï: frictionless isotropic compaction, then shear.

Grains have radii in [R_min, size_span R_min], uniform in volume fraction; `rcr.study.grains` has
their shapes, `rcr.study.protocol` the units and all constants. The time step is a fixed share of
t₀, since no stiffness bounds it.

With `law` smooth, the packing is compacted with rigid contacts too. Springs replace them at the
start of the shear, and the time step is a fixed share of `rcr.critical_time_step`.
"""

import math
import os
import time

import numpy as np
from yade.wrapper import Omega

import rcr
from rcr._data import run_folder
from rcr.study import checkpoint, compaction, grains, shear as shearing
from rcr.study.protocol import (FREE_PARAMETERS, HALF_RECORD, PROTOCOL, check_parameters,
                                stored_attributes)
from rcr.study.records import COUNTERS, Springs, make_records
from rcr.study.summary import summarize

O = Omega()


class Biaxial:
    """A biaxial test in the running YADE. `prepare` or `load` makes one.

    Attributes
    ----------
    parameters, progress : dict
        See `prepare`; ``phase`` ('collapse', 'relaxation' or 'shear'), counts and state of the
        compaction.
    rows, records : list of dict
        History, one row for each record of 0.1 % of strain; intervals of the last run of steps,
        see `rcr.study.records.make_records`.
    mean_stresses : (2,) float array
        σ_x and σ_y on the walls, means of the last interval [Pa], compression positive.
    isotropic : Network or None
        End of the compaction, if this process made it.
    solver : ContactDynamics or Springs
    grains : list of int
        Ids of grains, of a clump that of the clump.
    walls, left, bottom, right, top : range or int
        Ids.
    area, diameter, time_unit : float
        Area of all grains [m²], mean diameter [m], t₀ [s].
    """

    def __init__(self, parameters, progress, rows):
        self.start = time.monotonic() - progress["wall_seconds"]
        self.parameters, self.progress, self.rows = parameters, progress, rows
        self.isotropic = None
        count = len(O.bodies)
        self.grains = grains.ids()
        self.left, self.bottom, self.right, self.top = self.walls = range(count - 4, count)
        masses = np.array([O.bodies[i].state.mass for i in self.grains])
        self.area = float(masses.sum() / PROTOCOL.density)
        self.diameter = float(2 * np.mean(grains.circumscribed_radii(self.grains)))
        self.time_unit = math.sqrt(masses.mean() / PROTOCOL.confining_stress)
        engines = [engine for engine in O.engines if isinstance(engine, rcr.ContactDynamics)]
        self.solver = engines[0] if engines else Springs()

    @classmethod
    def prepare(cls, *arguments, place=compaction.deposited, **parameters):
        """Make a new test in a loose state, in place of YADE's scene.

        Parameters are those of `rcr.study.protocol.check_parameters`: options of
        scripts/biaxial.py, which docs/study/biaxial.md describes. A ValueError reports one out of
        its range. `place`: function of the radii of the circles around the grains (N,) [m], which
        returns their centres (N, 2) and the width of their box, from 0 [m].
        """
        parameters = check_parameters(*arguments, **parameters)
        compaction.make_scene(parameters, place)
        progress = dict(COUNTERS, phase="collapse", iterations=0, wall_seconds=0.0)
        return cls(parameters, progress, [])

    @property
    def width(self):
        """Distance of the side walls [m]."""
        return O.bodies[self.right].state.pos[0] - O.bodies[self.left].state.pos[0]

    @property
    def height(self):
        """Distance of the top and the bottom wall [m]."""
        return O.bodies[self.top].state.pos[1] - O.bodies[self.bottom].state.pos[1]

    @property
    def strain(self):
        """(h₀ − h)/h₀ since the start of the shear; 0 before."""
        first = self.progress.get("first_height")
        return 0.0 if first is None else shearing.rounded((first - self.height) / first)

    @property
    def packing_fraction(self):
        """Area of the grains over the area of the box [-]."""
        return self.area / (self.width * self.height)

    @property
    def unbalance(self):
        """Mean net force over mean contact force [-], of the compaction's last step."""
        if self.progress["phase"] == "shear":
            return self.progress["unbalance_initial"]
        return self.solver.unbalancedForce

    def sample_inertia(self):
        """Return the present inertia of the sample along its width and height.

        ρ (ε̇ W/2)²/σ₀ and ρ (ε̇ h)²/σ₀ [-], with ε̇ = v/h and the speed v of the top wall. At a
        constant v, the first one is the excess of the stress in the middle over that at the side
        walls, see `rcr.study.shear`. ε̇ W/2 is the speed of a side wall.
        """
        width, height = shearing.box(self)
        rate = shearing.wall_speed(self, self.progress["rate"]) / height
        density = PROTOCOL.density * self.packing_fraction
        stress = PROTOCOL.confining_stress
        return tuple(density * (rate * length) ** 2 / stress for length in (width / 2, height))

    def wall_stresses(self):
        """Return σ_x and σ_y, the mean contact forces on opposite walls over their lengths [Pa]."""
        load = {e.wall: e for e in O.engines if isinstance(e, rcr.WallStress) and not e.dead}

        def contact_force(wall, axis, length):
            applied = load[wall].stress * length if wall in load else 0.0
            return abs(O.forces.f(wall)[axis] - applied)

        x = [contact_force(wall, 0, self.height) for wall in (self.left, self.right)]
        y = [contact_force(wall, 1, self.width) for wall in (self.bottom, self.top)]
        return sum(x) / (2 * self.height), sum(y) / (2 * self.width)

    def overlaps(self):
        """Return the overlap of each contact point in mean diameters [-], 0 where it is open.

        They ascend, so that sums do not depend on the order of `O.interactions`.
        """
        gaps = [i.geom.gap[k] for i in O.interactions if i.isReal for k in range(i.geom.points)]
        return np.sort(np.maximum(0, -np.array(gaps))) / self.diameter

    def network(self):
        """Return the contact `Network` of the last step; friction 0 before the first record."""
        friction = self.parameters["friction"] if self.rows else 0.0
        return rcr.contact_network(self.walls, strain=self.strain, friction=friction,
                                   run=self.run, **stored_attributes(self.parameters))

    def compact(self, report=lambda test: None, balanced=PROTOCOL.balance_tolerance):
        """Compress without friction under σ₀ from the right and the top until all is balanced.

        The mean net force of a grain over the mean contact force is then below `balanced`. The
        wall stresses are within 1 % of σ₀, or within 3 % in a packing that creeps. `report` is
        called with the test after every step of the collapse and every interval of the relaxation.
        A packing that is not at rest after `Protocol.max_compaction_steps` raises a RuntimeError.
        """
        while self.progress["phase"] != "shear":
            if compaction.compact(self, balanced):
                shearing.start(self)
            report(self)

    def shear_record(self):
        """Shear by one record; see `shear`."""
        self.shear(1)

    def has_reached(self, strain):
        """Return whether the test is at a strain, or at most half a record before it."""
        return self.strain >= strain - HALF_RECORD

    def step(self, count, times=1, speeds=None):
        """Make `times` intervals of `count` steps; set `records` and `mean_stresses`.

        `speeds` are those of the top wall, see `rcr.study.records.make_records`.
        """
        make_records(self, count, times, speeds)
        last = self.records[-1]
        self.mean_stresses = np.array([last["stress_x"], last["stress_y"]])

    @property
    def wall_seconds(self):
        """Wall time of all sessions [s]: earlier ones up to their checkpoint, this one up to now."""
        return time.monotonic() - self.start

    @property
    def run(self):
        """Short hash of what determines the results, stored in the files."""
        given = {name: v for name, v in self.parameters.items() if name not in FREE_PARAMETERS}
        return run_folder.identity(given | dict(protocol=PROTOCOL.identity))

    @classmethod
    def load(cls, folder):
        """Return the test of the last checkpoint in a folder; see `checkpoint.load`."""
        return cls(*checkpoint.load(os.path.join(folder, checkpoint.CHECKPOINT)))

    def go_back(self, folder):
        """Return to the older of the last two states in a folder, with a smaller time step.

        The time step is dt/2, then dt/3 and so on. It stays smaller up to the first state beyond
        the strain at which the test failed.
        """
        failed = max(self.strain, self.progress["failed_strain"])
        divisor, start = self.progress["divisor"] + 1, self.start
        path = checkpoint.states(folder, self.strain)[-checkpoint.KEPT_STATES:][0]
        threads = self.parameters["threads"]
        self.__init__(*checkpoint.load(path))
        self.start, self.parameters["threads"], self.solver.threads = start, threads, threads
        self.progress.update(divisor=divisor, failed_strain=failed,
                             repeated=self.progress["repeated"] + 1)

    summary, save, shear = summarize, checkpoint.save, shearing.shear
