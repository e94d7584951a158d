"""Compaction and shear in a periodic cell, without walls: the second geometry of the study.

Grains, densities, stress and units are those of `rcr.study.biaxial`: radii in [R_min, 2 R_min] uniform in volume fraction, time unit
t₀ = √(m/σ₀), rates by the inertial number I = ε̇ t₀. The cell is pressed by `rcr.CellStress`; stresses are those of its contacts,
compression positive.
"""

import math

import numpy as np
from yade.minieigenHP import Matrix3
from yade.wrapper import ForceResetter, FrictMat, InsertionSortCollider, InteractionLoop, NewtonIntegrator, Omega

import rcr
from rcr import _checks as checks
from rcr.study.biaxial import BALANCED, DENSITY, OVERDAMPED_VIOLATION, R_MIN, REST_TOLERANCE, SHEAR_ITERATIONS, STRESS, approach, next_look, random_radii

O = Omega()

LOOSE = 0.7  # packing fraction up to which the cell contracts before it is pressed
CONTRACTION = 0.004  # strain of a step of the contraction
PATIENCE = 10_000  # steps after which a compaction that has not come to rest is given up
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
        Number of grains, at least 100: YADE wants cells of more than four grains' width.
    seed : int
        Of radii, places and orientations.
    friction : float
        Coefficient between grains during shear; they are compacted without.
    inertial_number, time_step : float
        Rate of the shear times t₀, and dt/t₀.
    tolerance : float
        Of `rcr.ContactDynamics`.
    threads : int
        Of `rcr.ContactDynamics`.
    overdamped : bool
        Shear without inertia; `inertial_number` × `time_step` is then the strain of a step. (`rcr.study.biaxial.QUASI_STATIC` has what averages need.)

    Raises
    ------
    ValueError
        For a parameter out of its range.
    """

    def __init__(self, eta=0.5, particles=1000, seed=1, friction=0.5, inertial_number=1e-3, time_step=0.1, tolerance=1e-4, threads=1, overdamped=False):
        eta = checks.number("eta", eta, "an elongation from 0 to below 1", lambda v: 0 <= v < 1)
        particles = checks.integer("particles", particles, "at least 100: a cell must be wider than four grains", lambda v: v >= 100)
        for name, value in dict(inertial_number=inertial_number, time_step=time_step, tolerance=tolerance).items():
            checks.number(name, value, "a finite number > 0", lambda v: v > 0)
        self.friction, self.rate, self.time_step, self.overdamped = friction, inertial_number, time_step, overdamped
        O.reset()
        rng = np.random.default_rng(seed)
        radii = random_radii(particles, rng)
        row = math.ceil(math.sqrt(particles))
        space = 2.02 * radii.max()
        O.periodic = True
        O.cell.setBox(row * space, row * space, row * space)
        self.material = FrictMat(density=DENSITY, frictionAngle=0, label="grain")
        O.materials.append(self.material)
        for place, radius in zip(rng.permutation(row * row), radii):
            at = (place % row + 0.5) * space, (place // row + 0.5) * space
            O.bodies.append(rcr.particle(at, radius, eta, rng.uniform(0, math.pi), self.material))
        mass = sum(b.state.mass for b in O.bodies)
        self.area, self.time_unit = mass / DENSITY, math.sqrt(mass / particles / STRESS)
        self.press = rcr.CellStress(stress=(math.nan, math.nan), mass=12 / particles)
        self.solver = rcr.ContactDynamics(tolerance=tolerance, maxIterations=2000, threads=threads, overdamped=True)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([rcr.Bo1_Rcr_Aabb()], verletDist=0.1 * R_MIN),
            InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()], [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
            self.press,
            self.solver,
            NewtonIntegrator(damping=0),
        ]

    @property
    def packing_fraction(self):
        """Area of the grains over that of the cell [-]."""
        h = O.cell.hSize
        return self.area / (h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0])

    @property
    def stress(self):
        """Stress of the contacts, compression positive; (2, 2) [Pa]."""
        return rcr.contact_network().stress()

    def compact(self, report=lambda test: None):
        """Contracts the loose packing, then presses it by σ₀ from all sides until every grain is balanced; no inertia, no friction.

        Raises
        ------
        RuntimeError
            If it has not come to rest after `PATIENCE` steps.
        """
        O.dt = 0.1 * self.time_unit
        contraction = -CONTRACTION / O.dt
        O.cell.velGrad = Matrix3(contraction, 0, 0, 0, contraction, 0, 0, 0, 0)
        while self.packing_fraction < LOOSE:
            O.step()
            report(self)
        O.cell.velGrad = Matrix3.Zero
        self.press.stress = (STRESS, STRESS)
        tolerance = self.solver.tolerance
        course, first = {}, O.iter
        while O.iter - first < PATIENCE:
            for _ in range(next_look(self.solver)):
                self.solver.tolerance = REST_TOLERANCE * min(0.1, max(self.solver.unbalancedForce, BALANCED))
                O.step()
                report(self)
            if O.iter - first > 50 and self.solver.unbalancedForce < BALANCED:
                self.solver.tolerance = tolerance
                return
            O.dt = self.time_unit * approach(course, self.solver)
        raise RuntimeError(f"the packing has not come to rest after {PATIENCE} steps: mean net force of a grain {self.solver.unbalancedForce:.1e} of the mean contact force")

    def shear(self, mode, strain, report=lambda test, row: None, every=0.01):
        """Shears the compacted packing: 'biaxial', contracting along y under σ₀ along x, or 'simple', along x under σ₀ along x and y.

        Returns
        -------
        dict of (n,) float arrays
            Means over each `every` of strain, by `COLUMNS`: strain, q/p, packing fraction, pressure [σ₀], iterations.
        """
        checks.choice("mode", mode, MODES)
        checks.number("strain", strain, "a strain > 0, of a biaxial test below 1", lambda v: 0 < v < (1 if mode == "biaxial" else math.inf))
        self.solver.overdamped = self.overdamped
        if self.overdamped:
            self.solver.kinematicTolerance, self.solver.maxIterations = OVERDAMPED_VIOLATION, SHEAR_ITERATIONS
        self.material.frictionAngle = math.atan(self.friction)
        for b in O.bodies:
            b.state.vel = b.state.angVel = (0, 0, 0)
        for i in O.interactions:
            if i.isReal:
                i.phys.tangensOfFrictionAngle = self.friction
        O.dt = self.time_step * self.time_unit
        self.press.mass = INERTIA
        rate = self.rate / self.time_unit
        if mode == "biaxial":
            self.press.stress = (STRESS, math.nan)
            O.cell.velGrad = Matrix3(0, 0, 0, 0, -rate, 0, 0, 0, 0)
        else:
            self.press.stress = (STRESS, STRESS)
            O.cell.velGrad = Matrix3(0, rate, 0, 0, 0, 0, 0, 0, 0)
        height = O.cell.hSize[1, 1]
        rows, steps, now = [], [], 0.0
        while now < strain:
            O.step()
            h = O.cell.hSize
            now = 1 - h[1, 1] / height if mode == "biaxial" else h[0, 1] / h[1, 1]
            least, most = np.linalg.eigvalsh(self.stress)
            steps.append([(most - least) / (most + least), self.packing_fraction, (most + least) / 2 / STRESS, self.solver.iterations])
            if now >= every * (len(rows) + 1):
                rows.append([now, *np.mean(steps, axis=0)])
                steps = []
                report(self, dict(zip(COLUMNS, rows[-1])))
        return dict(zip(COLUMNS, np.array(rows).reshape(-1, len(COLUMNS)).T))
