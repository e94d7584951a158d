"""Compaction and shear in a periodic cell without walls: the second geometry of the study.

Grains, density, stress and units are those of `rcr.study.protocol`. `rcr.CellStress` loads the
cell. Stresses are those of its contacts, compression positive. Needs YADE.
"""

import math

import numpy as np
from yade.minieigenHP import Matrix3
from yade.wrapper import (
    ForceResetter, FrictMat, InsertionSortCollider, InteractionLoop, NewtonIntegrator, Omega,
)  # fmt: skip

import rcr
from rcr._data import checks
from rcr.study.compaction import random_radii, relaxation_interval, relaxation_time_step, rest
from rcr.study.protocol import PROTOCOL

O = Omega()

LOOSE_FRACTION = 0.7  # packing fraction up to which the cell contracts without a load [-]
CONTRACTION = 0.004  # strain of a step of that contraction [-]
MIN_RELAXATION_STEPS = 50  # steps under load, at least
MAX_COMPACTION_STEPS = 10_000  # steps under load after which the compaction fails
SOLVER_ITERATIONS = 2000  # of a step, at most
INERTIA = 0.1  # of the cell in shear, `rcr.CellStress.mass`
MODES = "biaxial", "simple"
COLUMNS = "strain sin_phi packing_fraction pressure iterations".split()


class CellTest:
    """A test of one packing: `compact`, then `shear`.

    Parameters
    ----------
    eta : float
        Elongation, 0 ≤ eta < 1.
    particles : int
        Number of grains, at least 100: YADE requires cells wider than four grains.
    seed : int
        Seed of radii, positions and orientations.
    friction : float
        Coefficient between grains in the shear; the compaction has none.
    inertial_number, time_step : float
        I and dt/t₀ of the shear [-].
    tolerance, threads
        Attributes of `rcr.ContactDynamics`.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """

    def __init__(self, eta=0.5, particles=1000, seed=1, friction=0.5, inertial_number=1e-3,
                 time_step=0.1, tolerance=1e-4, threads=1):
        elongation = "an elongation from 0 to below 1"
        eta = checks.number("eta", eta, elongation, lambda v: 0 <= v < 1)
        least = "at least 100: a cell must be wider than four grains"
        particles = checks.integer("particles", particles, least, lambda v: v >= 100)
        positive = dict(inertial_number=inertial_number, time_step=time_step, tolerance=tolerance)
        for name, value in positive.items():
            checks.number(name, value, "a finite number > 0", lambda v: v > 0)
        self.friction, self.rate, self.time_step = friction, inertial_number, time_step
        mass = self._make_grains(eta, particles, seed)
        self.area = mass / PROTOCOL.density
        self.time_unit = math.sqrt(mass / particles / PROTOCOL.confining_stress)
        self.press = rcr.CellStress(stress=(math.nan, math.nan), mass=12 / particles)
        self.solver = rcr.ContactDynamics(
            tolerance=tolerance, maxIterations=SOLVER_ITERATIONS, threads=threads, overdamped=True)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([rcr.Bo1_Rcr_Aabb()], verletDist=0.1 * PROTOCOL.smallest_radius),
            InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                            [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
            self.press,
            self.solver,
            NewtonIntegrator(damping=0),
        ]

    def _make_grains(self, eta, particles, seed):
        """Make a square lattice of grains at random angles; return their mass."""
        O.reset()
        rng = np.random.default_rng(seed)
        radii = random_radii(particles, rng)
        row = math.ceil(math.sqrt(particles))
        space = 2.02 * radii.max()
        O.periodic = True
        O.cell.setBox(row * space, row * space, row * space)
        self.material = FrictMat(density=PROTOCOL.density, frictionAngle=0, label="grain")
        O.materials.append(self.material)
        for place, radius in zip(rng.permutation(row * row), radii):
            at = (place % row + 0.5) * space, (place // row + 0.5) * space
            angle = rng.uniform(0, math.pi)
            O.bodies.append(rcr.particle(at, radius, eta, angle, self.material))
        return sum(b.state.mass for b in O.bodies)

    @property
    def packing_fraction(self):
        """Area of the grains over the area of the cell [-]."""
        h = O.cell.hSize
        return self.area / (h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0])

    @property
    def stress(self):
        """Stress of the contacts, compression positive; (2, 2) [Pa]."""
        return rcr.contact_network().stress()

    def compact(self, report=lambda test: None):
        """Contract the loose packing, then load it by σ₀ until every grain is balanced.

        Parameters
        ----------
        report : callable
            Called with the test after every step.

        Raises
        ------
        RuntimeError
            If the packing is not at rest after `MAX_COMPACTION_STEPS`.
        """
        O.dt = 0.1 * self.time_unit
        rate = -CONTRACTION / O.dt
        O.cell.velGrad = Matrix3(rate, 0, 0, 0, rate, 0, 0, 0, 0)
        while self.packing_fraction < LOOSE_FRACTION:
            O.step()
            report(self)
        O.cell.velGrad = Matrix3.Zero
        self.press.stress = (PROTOCOL.confining_stress, PROTOCOL.confining_stress)
        solver, balanced = self.solver, PROTOCOL.balance_tolerance
        tolerance = solver.tolerance
        state, first = {}, O.iter
        while O.iter - first < MAX_COMPACTION_STEPS:
            for _ in range(relaxation_interval(solver)):
                unbalance = min(0.1, max(solver.unbalancedForce, balanced))
                solver.tolerance = PROTOCOL.relaxation_tolerance * unbalance
                O.step()
                report(self)
            if O.iter - first > MIN_RELAXATION_STEPS and solver.unbalancedForce < balanced:
                solver.tolerance = tolerance
                return
            O.dt = self.time_unit * relaxation_time_step(state, solver)
        raise RuntimeError(
            f"the packing has not come to rest after {MAX_COMPACTION_STEPS} steps: mean net force "
            f"of a grain {solver.unbalancedForce:.1e} of the mean contact force "
            f"(expected {balanced:g}); try another seed or a smaller tolerance"
        )

    def shear(self, mode, strain, report=lambda test, row: None, every=0.01):
        """Shear the compacted packing.

        Parameters
        ----------
        mode : str
            'biaxial': contraction along y under σ₀ along x; 'simple': shear along x under σ₀
            along x and y.
        strain : float
            Strain at the end, > 0, of a biaxial test below 1 [-].
        report : callable
            Called with the test and each row.
        every : float
            Strain of a row [-].

        Returns
        -------
        dict of (n,) float arrays
            Means of each row, by `COLUMNS`: strain, q/p, packing fraction, pressure [σ₀],
            iterations.
        """
        checks.choice("mode", mode, MODES)
        limit = 1 if mode == "biaxial" else math.inf
        expected = "a strain > 0, of a biaxial test below 1"
        checks.number("strain", strain, expected, lambda v: 0 < v < limit)
        self._start_shear(mode)
        height = O.cell.hSize[1, 1]
        rows, steps, now = [], [], 0.0
        while now < strain:
            O.step()
            h = O.cell.hSize
            now = 1 - h[1, 1] / height if mode == "biaxial" else h[0, 1] / h[1, 1]
            least, most = np.linalg.eigvalsh(self.stress)
            ratio = (most - least) / (most + least)
            pressure = (most + least) / 2 / PROTOCOL.confining_stress
            steps.append([ratio, self.packing_fraction, pressure, self.solver.iterations])
            if now >= every * (len(rows) + 1):
                rows.append([now, *np.mean(steps, axis=0)])
                steps = []
                report(self, dict(zip(COLUMNS, rows[-1])))
        return dict(zip(COLUMNS, np.array(rows).reshape(-1, len(COLUMNS)).T))

    def _start_shear(self, mode):
        """Set the friction, the rate and the load of the shear."""
        solver = self.solver
        solver.overdamped = False
        self.material.frictionAngle = math.atan(self.friction)
        rest()
        for i in O.interactions:
            if i.isReal:
                i.phys.tangensOfFrictionAngle = self.friction
        O.dt = self.time_step * self.time_unit
        self.press.mass = INERTIA
        rate, stress = self.rate / self.time_unit, PROTOCOL.confining_stress
        if mode == "biaxial":
            self.press.stress = (stress, math.nan)
            O.cell.velGrad = Matrix3(0, 0, 0, 0, -rate, 0, 0, 0, 0)
        else:
            self.press.stress = (stress, stress)
            O.cell.velGrad = Matrix3(0, rate, 0, 0, 0, 0, 0, 0, 0)
