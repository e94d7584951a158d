"""The biaxial test of Azéma and Radjaï: isotropic compaction without friction, then shear at constant lateral stress.

Units and rules
---------------
Grains have radii in [R_min, 2 R_min], uniform in volume fraction, and the density ρ; the confining stress is σ₀. With the
mean grain mass m and the mean diameter d, the time unit is t₀ = √(m/σ₀). The time step is a fixed share of t₀, since no
stiffness bounds it; with the smooth law it is a fixed share of the critical one (`rcr.critical_time_step`). The top wall moves at the rate ε̇ = I/t₀ of the first height, I being the inertial number; the strain is
(h₀ − h)/h₀. All is per unit depth.
"""

import csv
import json
import math
import os
import time

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
from yade.wrapper import (
    Bo1_Wall_Aabb, ForceResetter, FrictMat, InsertionSortCollider, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, MatchMaker, NewtonIntegrator,
    Omega,
)  # fmt: skip

import rcr
from rcr import _kernel
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE

O = Omega()

R_MIN = 5e-3  # [m]; sets the scale only
DENSITY = 2600.0  # [kg/m³]
STRESS = 1e4  # σ₀ [Pa]
DEPOSITED = 0.82  # packing fraction of the circles that are deposited; it sets the width of the box
CONTRACTION = 0.5  # first speed of the walls in the compaction [d/t₀]; the grains move along with them, homogeneously
COMPACTION_TIME_STEP = 0.05  # dt/t₀ of the compaction; 0.1 lets spinning grains overlap by 0.1 d
TIME_STEP = 0.1  # dt/t₀ of the shear
INERTIAL_NUMBER = 1e-3  # quasi-static: the largest net force of a grain in a step is then some 15 % of the mean contact force
RAMP = 0.002  # strain over which the top wall takes up its velocity
BALANCED = 1e-3  # mean net force of a grain over the mean contact force, at the end of the compaction
ISOTROPIC = 1e-2  # largest relative deviation of the wall stresses from σ₀, likewise
REST_TOLERANCE = 0.01  # residual of the solver over the net forces that are left, while the packing comes to rest: its errors must stay below
PATIENCE = 2000  # time units after which a compaction that has not come to rest is given up
STIFFNESS = 1e3  # k_n/σ₀ of the smooth law: mean overlaps of some 1e-3 d
SHEAR_STIFFNESS = 0.8  # k_s/k_n
VISCOUS_DAMPING = 0.3  # of the smooth law, along normals, in shares of the critical one; there is no other damping in the shear
SMOOTH_TIME_STEP = 0.5  # dt over `rcr.critical_time_step`
SMOOTH_STRIDE = 10  # steps of the smooth law between two looks at the wall stresses
RECORD = 1e-3  # strain between two rows of the history
COLUMNS = "step time strain sin_phi stress_x stress_y packing_fraction points iterations residual".split()


def random_radii(count, rng):
    """Radii uniform in volume fraction, number density ∝ R⁻² in [R_min, 2 R_min]; (count,) [m]."""
    return R_MIN / (1 - 0.5 * rng.random(count))


def deposited_packing(count, rng):
    """Circles dropped layer by layer into a box about as high as wide (`deposition.hpp`), the same ones for every elongation.

    Returns
    -------
    centres (count, 2), radii (count,), width, height of the box [m]
    """
    radii = random_radii(count, rng)
    width = max(math.sqrt(math.pi * np.sum(radii**2) / DEPOSITED), 2 * radii.max())
    centres = _kernel.deposit(radii, width)
    return centres, radii, width, (centres[:, 1] + radii).max()


def smooth_functors(stiffness):
    """Ip2 and Law2 of the smooth law with k_n = `stiffness` σ₀ for every pair."""
    value = lambda k: MatchMaker(algo="val", val=k)
    kn = stiffness * STRESS
    return (
        [Ip2_FrictMat_FrictMat_FrictPhys(kn=value(kn), ks=value(SHEAR_STIFFNESS * kn))],
        [rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=VISCOUS_DAMPING)],
    )


class Springs:
    """What a test asks of its `ContactDynamics`, answered for the smooth law, which iterates nothing."""

    tolerance = residual = 0.0
    iterations = threads = 0

    @property
    def unbalance(self):
        """Mean net force of a body over the mean contact force [-]; infinite without contacts."""
        ratio = utils.unbalancedForce()
        return ratio if math.isfinite(ratio) and ratio > 0 else math.inf

    @property
    def contactPoints(self):
        return sum(i.geom.points for i in O.interactions if i.isReal)


class Biaxial:
    """A biaxial test in the running YADE. It lives in the scene: `O.save` keeps it, `Biaxial.load` goes on to the same bits.

    Attributes
    ----------
    parameters : dict
        eta, particles, seed, friction: what the test is of.
    progress : dict
        phase ('collapse', 'rest', then 'shear'), counts and what the next step needs; kept in ``O.tags``.
    rows : list of dict
        History, one row every 0.1 % of strain.
    """

    def __init__(self, parameters, progress, rows):
        self.parameters, self.progress, self.rows = parameters, progress, rows
        count = parameters["particles"]
        self.grains = range(count)
        self.left, self.bottom, self.right, self.top = self.walls = range(count, count + 4)
        masses = np.array([O.bodies[i].state.mass for i in self.grains])
        shapes = [O.bodies[i].shape for i in self.grains]
        self.area = masses.sum() / DENSITY
        self.diameter = 2 * np.mean([shape.halfLength + shape.capRadius for shape in shapes])
        self.time_unit = math.sqrt(masses.mean() / STRESS)
        self.smooth = parameters.get("law", "cd") == "smooth"
        self.solver = Springs() if self.smooth else utils.typedEngine("ContactDynamics")

    @classmethod
    def prepare(
        cls,
        eta=0.5,
        particles=1000,
        seed=1,
        friction=0.5,
        tolerance=1e-4,
        solver="auto",
        threads=0,
        inertial_number=INERTIAL_NUMBER,
        time_step=TIME_STEP,
        law="cd",
        stiffness=STIFFNESS,
    ):
        """A new test in a loose state: particles of random orientation, each in its circle of a deposited packing.

        Parameters
        ----------
        eta : float
            Elongation, 0 ≤ eta < 1.
        particles : int
            Number of grains, at least 10.
        seed : int
            Of radii, places and orientations.
        friction : float
            Coefficient between grains during shear; walls have none.
        tolerance, solver, threads
            Of `ContactDynamics`.
        inertial_number : float
            Rate of the shear times t₀, > 0.
        time_step : float
            dt/t₀ of the shear, > 0; with the smooth law the stiffness sets the step.
        law : str
            'cd', rigid contacts, or 'smooth': springs, with `VISCOUS_DAMPING` along normals and no other damping.
        stiffness : float
            k_n/σ₀ of the smooth law [-], > 0.

        Raises
        ------
        ValueError
            For a parameter out of its range.
        """
        if particles < 10:
            raise ValueError(f"particles = {particles}; wanted at least 10")
        if not (math.isfinite(friction) and friction >= 0):
            raise ValueError(f"friction = {friction}; wanted a coefficient ≥ 0")
        if law not in ("cd", "smooth"):
            raise ValueError(f"law = {law!r}; wanted 'cd' or 'smooth'")
        for name, value in dict(inertial_number=inertial_number, time_step=time_step, stiffness=stiffness).items():
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} = {value}; wanted a number > 0")
        O.reset()
        rng = np.random.default_rng(seed)
        centres, radii, width, height = deposited_packing(particles, rng)
        angles = rng.uniform(0, math.pi, particles)
        grain = O.materials.append(FrictMat(density=DENSITY, frictionAngle=0, label="grain"))
        plate = O.materials.append(FrictMat(density=DENSITY, frictionAngle=0, label="plate"))
        O.bodies.append([rcr.particle(c, R, eta, angle, grain) for c, R, angle in zip(centres, radii, angles)])
        mass = sum(b.state.mass for b in O.bodies)  # a wall as heavy as the grains moves gently
        left, bottom, right, top = O.bodies.append(
            [
                rcr.wall("x", 0, +1, material=plate),
                rcr.wall("y", 0, +1, material=plate),
                rcr.mobile_wall("x", width, mass, -1, plate),
                rcr.mobile_wall("y", height, mass, -1, plate),
            ]
        )
        time_unit = math.sqrt(mass / particles / STRESS)
        speed = CONTRACTION * 2 * radii.mean() / time_unit
        for body in O.bodies:  # walls and grains contract homogeneously, so that no wall sweeps the grains together
            if body.dynamic:
                body.state.vel = Vector3(-speed * body.state.pos[0] / width, -speed * body.state.pos[1] / height, 0)
        O.dt = COMPACTION_TIME_STEP * time_unit
        rigid_functors = [rcr.Ip2_FrictMat_FrictMat_CdPhys()], [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]
        rigid_engine = rcr.ContactDynamics(tolerance=tolerance, maxIterations=3000, solver=solver, threads=threads)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R_MIN),
            InteractionLoop(
                [rcr.Ig2_Rcr_Rcr_RcrGeom(), rcr.Ig2_Wall_Rcr_RcrGeom()],
                *(smooth_functors(stiffness) if law == "smooth" else rigid_functors),
            ),
            rcr.WallStress(wall=right, start=bottom, end=top, stress=-STRESS),
            rcr.WallStress(wall=top, start=left, end=right, stress=-STRESS),
            *([] if law == "smooth" else [rigid_engine]),
            NewtonIntegrator(damping=0),
        ]
        if law == "smooth":
            O.dt = SMOOTH_TIME_STEP * rcr.critical_time_step()
        parameters = dict(eta=eta, particles=particles, seed=seed, friction=friction, inertial_number=inertial_number, time_step=time_step)
        parameters.update(law=law, stiffness=stiffness)
        progress = dict(phase="collapse", kinetic_energy=0.0, iterations=0, residual_max=0.0, wall_seconds=0.0)
        return cls(parameters, progress, [])

    # --- what the walls feel -------------------------------------------------------------------------------------------

    @property
    def width(self):
        return O.bodies[self.right].state.pos[0] - O.bodies[self.left].state.pos[0]

    @property
    def height(self):
        return O.bodies[self.top].state.pos[1] - O.bodies[self.bottom].state.pos[1]

    @property
    def strain(self):
        """(h₀ − h)/h₀ since the start of the shear; 0 before."""
        first = self.progress.get("first_height")
        return 0.0 if first is None else (first - self.height) / first

    @property
    def packing_fraction(self):
        return self.area / (self.width * self.height)

    def wall_stresses(self):
        """σ_x and σ_y from the contact forces on opposite walls, averaged [Pa], compression positive."""
        load = {engine.wall: engine for engine in O.engines if isinstance(engine, rcr.WallStress) and not engine.dead}

        def contact_force(wall, axis, length):
            applied = load[wall].stress * length if wall in load else 0.0
            return abs(O.forces.f(wall)[axis] - applied)

        x = [contact_force(wall, 0, self.height) for wall in (self.left, self.right)]
        y = [contact_force(wall, 1, self.width) for wall in (self.bottom, self.top)]
        return sum(x) / (2 * self.height), sum(y) / (2 * self.width)

    # --- the two phases ------------------------------------------------------------------------------------------------

    def compact(self, report=lambda test: None, balanced=BALANCED):
        """Compress without friction under σ₀ from the right and the top until every grain is balanced.

        The grains first collapse freely. Once both pairs of walls feel half of σ₀, kinetic damping brings the packing to
        rest: at each maximum of the kinetic energy all velocities are set to zero (Cundall 1976), which takes nothing from
        the forces of the balanced state.

        Parameters
        ----------
        report : callable
            Called with the test every 10 steps.
        balanced : float
            Mean net force of a grain over the mean contact force at which the packing counts as balanced [-].

        Raises
        ------
        RuntimeError
            If it has not come to rest after `PATIENCE` time units.
        """
        while self.progress["phase"] != "shear":
            self._steps(10)
            stresses = self.mean_stresses / STRESS
            if self.progress["phase"] == "collapse" and stresses.min() > 0.5:
                self.progress["phase"] = "rest"
                self.progress["tolerance"] = self.solver.tolerance
            if self.progress["phase"] == "rest":
                self.solver.tolerance = REST_TOLERANCE * min(0.1, max(self.solver.unbalance, balanced))
                self._damp_kinetic_energy()
                if self.solver.unbalance < balanced and np.abs(stresses - 1).max() < ISOTROPIC:
                    self._start_shear()
            report(self)
            if O.time > PATIENCE * self.time_unit:
                raise RuntimeError(
                    f"the compaction has not come to rest after {O.iter} steps: mean net force of a grain "
                    f"{self.solver.unbalance:.1e} of the mean contact force (wanted {balanced:g}), wall stresses "
                    f"{stresses} σ₀ (wanted 1); another seed or a smaller tolerance may help"
                )

    def _damp_kinetic_energy(self):
        energy = utils.kineticEnergy()
        if energy < self.progress["kinetic_energy"]:
            for body in O.bodies:
                if body.dynamic:
                    body.state.vel = body.state.angVel = Vector3.Zero
            energy = 0.0
        self.progress["kinetic_energy"] = energy

    def _start_shear(self):
        self.progress.update(
            phase="shear",
            first_height=self.height,
            packing_fraction_initial=self.packing_fraction,
            unbalance_initial=self.solver.unbalance,
            residual_max=0.0,  # of the shear; the compaction is solved as finely as it is balanced
        )
        self.solver.tolerance = self.progress["tolerance"]
        if not self.smooth:
            O.dt = self.parameters["time_step"] * self.time_unit
        friction = self.parameters["friction"]
        O.materials["grain"].frictionAngle = math.atan(friction)  # of contacts to come; those with a wall stay smooth
        for i in O.interactions:
            if i.isReal and max(i.id1, i.id2) < self.left:
                i.phys.tangensOfFrictionAngle = friction
        # A light wall follows the grains; a heavy one would answer each of their jumps with its inertia.
        O.bodies[self.right].state.mass = sum(O.bodies[i].state.mass for i in self.grains) / math.sqrt(len(self.grains))
        for engine in O.engines:
            if isinstance(engine, rcr.WallStress) and engine.wall == self.top:
                engine.dead = True
        O.bodies[self.top].state.blockedDOFs = "xyzXYZ"

    @property
    def steps_a_record(self):
        rate = self.parameters["inertial_number"] / self.time_unit
        return max(1, round(RECORD / (rate * O.dt)))

    def shear_record(self):
        """Shear by one record: 0.1 % of strain, and a row of the history."""
        speed = self.parameters["inertial_number"] / self.time_unit * self.progress["first_height"]
        ramp = min(1, max(self.strain, RECORD / 10) / RAMP)
        O.bodies[self.top].state.vel = Vector3(0, -ramp * speed, 0)
        self._steps(self.steps_a_record)
        x, y = self.mean_stresses
        self.rows.append(
            dict(
                step=O.iter,
                time=O.time,
                strain=self.strain,
                sin_phi=(y - x) / (y + x),
                stress_x=x,
                stress_y=y,
                packing_fraction=self.packing_fraction,
                points=self.solver.contactPoints,
                iterations=self.solver.iterations,
                residual=self.solver.residual,
            )
        )

    def _steps(self, count):
        """Make steps; add up the solver's work and average the wall stresses, which fluctuate from step to step."""
        start = time.perf_counter()
        stresses = []
        stride = SMOOTH_STRIDE if self.smooth else 1
        for left in reversed(range(count)):
            O.step()
            if left % stride == 0:
                stresses.append(self.wall_stresses())
            self.progress["iterations"] += self.solver.iterations
            self.progress["residual_max"] = max(self.progress["residual_max"], self.solver.residual)
        self.mean_stresses = np.mean(stresses, axis=0)
        self.progress["wall_seconds"] += time.perf_counter() - start

    # --- results -------------------------------------------------------------------------------------------------------

    def network(self):
        """Contact network of the last step; see `rcr.Network`. It is frictionless until the first record of the shear."""
        friction = self.parameters["friction"] if self.rows else 0.0
        return rcr.contact_network(
            self.walls, strain=self.strain, eta=self.parameters["eta"], friction=friction, seed=self.parameters["seed"]
        )

    def overlaps(self):
        """Overlap of each contact point, 0 where it is open, in mean diameters [-]."""
        gaps = [i.geom.gap[k] for i in O.interactions if i.isReal for k in range(i.geom.points)]
        return np.maximum(0, -np.array(gaps)) / self.diameter

    def summary(self):
        """What `summary.json` holds; stresses and fractions of the second half of the strain."""
        network = self.network()
        late = [row["sin_phi"] for row in self.rows if row["strain"] >= 0.5 * self.strain]
        between = network.between_particles
        types = network.contacts["type"][between]
        force = np.einsum("ca,ca->c", network.contacts["force"], network.contacts["normal"])[between]
        overlaps = self.overlaps()
        frictional = network.attributes["friction"] > 0
        return dict(
            eta=self.parameters["eta"],
            particles=self.parameters["particles"],
            seed=self.parameters["seed"],
            strain=self.strain,
            sin_phi=float(np.mean(late)),
            sin_phi_std=float(np.std(late)),
            packing_fraction_initial=self.progress["packing_fraction_initial"],
            packing_fraction_final=self.packing_fraction,
            coordination_number=network.coordination(),
            fraction_cc=float(np.mean(types == CAP_CAP)),
            fraction_cs=float(np.mean(types == CAP_SIDE)),
            fraction_ss=float(np.mean(types == SIDE_SIDE)),
            friction_mobilization=float(network.friction_mobilization().mean()) if frictional else 0.0,
            weak_fraction=float(np.mean(force < force.mean())),
            mean_overlap=float(overlaps.mean()),
            max_overlap=float(overlaps.max(initial=0)),
            inertial_number=self.parameters["inertial_number"],
            unbalance_initial=self.progress["unbalance_initial"],
            steps=O.iter,
            dt=O.dt,
            iterations_mean=self.progress["iterations"] / O.iter,
            residual_max=self.progress["residual_max"],
            wall_seconds=self.progress["wall_seconds"],
            threads=self.solver.threads or O.numThreads,
            version=rcr.__version__,
        )

    # --- files ---------------------------------------------------------------------------------------------------------

    def save(self, folder):
        """Checkpoint: scene, parameters and history, each file whole or not at all."""
        O.tags["biaxial"] = json.dumps(dict(parameters=self.parameters, progress=self.progress)).replace(" ", "")
        history = os.path.join(folder, "history.csv")
        with open(history + ".part", "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(self.rows)
        os.replace(history + ".part", history)
        partial = os.path.join(folder, "part-checkpoint.yade.gz")
        O.save(partial, quiet=True)
        os.replace(partial, os.path.join(folder, "checkpoint.yade.gz"))

    @classmethod
    def load(cls, folder):
        """The test as its last checkpoint left it.

        Raises
        ------
        FileNotFoundError
            If the folder has no checkpoint.
        """
        checkpoint = os.path.join(folder, "checkpoint.yade.gz")
        if not os.path.exists(checkpoint):
            raise FileNotFoundError(f"{checkpoint} is missing: nothing to resume; run without --resume")
        O.load(checkpoint, quiet=True)
        kept = json.loads(O.tags["biaxial"])
        with open(os.path.join(folder, "history.csv"), newline="") as file:
            rows = [{k: (int if k in ("step", "points", "iterations") else float)(v) for k, v in row.items()} for row in csv.DictReader(file)]
        return cls(kept["parameters"], kept["progress"], [row for row in rows if row["step"] <= O.iter])


