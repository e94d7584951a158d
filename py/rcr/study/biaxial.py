"""The biaxial test of Azéma and Radjaï: isotropic compaction without friction, then shear at constant lateral stress.

Units and rules
---------------
Grains have radii in [R_min, 2 R_min], uniform in volume fraction, and the density ρ; the confining stress is σ₀. With the
mean grain mass m and the mean diameter d, the time unit is t₀ = √(m/σ₀). The time step is a fixed share of t₀, since no
stiffness bounds it. The top wall moves at the rate ε̇ = I/t₀ of the first height, I being the inertial number; the strain is
(h₀ − h)/h₀. Every quantity is per unit depth.

With the smooth law the packing is made by rigid contacts too. Springs replace them where the shear starts, and the time step
is a fixed share of theirs (`rcr.critical_time_step`).
"""

import contextlib
import gzip
import json
import math
import os
import time
import typing

import numpy as np
from yade import utils
from yade.minieigenHP import Matrix3, Vector3
from yade.wrapper import (
    Bo1_Wall_Aabb, ForceResetter, FrictMat, InsertionSortCollider, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, MatchMaker, NewtonIntegrator,
    Omega,
)  # fmt: skip

import rcr
from rcr import _kernel, _checks as checks, _files as files, _results as results
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE, sin_phi

O = Omega()

R_MIN = 5e-3  # [m]; sets the scale only
DENSITY = 2600.0  # [kg/m³]
STRESS = 1e4  # σ₀ [Pa]
DEPOSITED = 0.82  # packing fraction of the circles that are deposited; it sets the width of the box
MOST_CONTRACTION = 0.005  # strain of a step of the collapse, at most: overlaps that it makes are taken back in the same step
SPARSE = 1.5  # contact points over grains, up to which no contacts reach from wall to wall, so that …
CONTRACTION = 0.1  # … walls may move further than this in a step of the collapse [d]; the grains move along, homogeneously
COLLAPSED = 4.0  # stress of the walls over σ₀ at the end of the collapse, at most: large packings push back later than they are squeezed
TIME_STEPS = 0.1, 1.0  # shortest and longest dt/t₀ of the compaction
FARTHEST = 0.1  # displacement of a grain in a step of the approach to rest, at most [d] …
REACH = 20.0  # … and this times the mean net force over the mean contact force [d] …
SHORTER = 0.6  # … shortened to this share whenever the net forces of `LOOKS` looks are not `FALL` of those before: flips that long steps keep up end so …
LOOKS, FALL = 5, 0.8
LEAST_REACH = 0.05  # … and as long as at first below this: short steps make large packings creep
LOOK, ROUGH = 10, 0.03  # steps of the approach between two looks at the net forces, all of one length, where these are below that; else one
HELD_UP = 3  # deviation of the wall stresses from σ₀ over the mean net force, from which on the drag of the whole sample holds up its contraction
TIME_STEP = 0.1  # dt/t₀ of the shear
INERTIAL_NUMBER = 1e-3  # quick: the largest net force of a grain in a step is then 20 to 40 % of the mean contact force
QUASI_STATIC_PACE = 1e-4  # I t₀/dt of shear without inertia: the drag of a grain over σ₀
# `ContactDynamics.kinematicTolerance` of overdamped shear at this pace: what velocities are wrong by are gaps, which the next step takes back
# whole. It is a share of the velocities without contacts, too, to which those of slower shear and longer steps are less and less: there it falls with I/dt.
OVERDAMPED_VIOLATION = 0.1
QUASI_STATIC = dict(overdamped=True, inertial_number=QUASI_STATIC_PACE, time_step=1.0)  # near those of the limit I → 0 (docs/measurements.md, Quasi-static limit)
SHEAR_ITERATIONS = 300  # of a step of the shear, at most: where a large packing is about to yield, thousands would change no average
RAMP = 0.002  # strain over which the top wall takes up its velocity
BALANCED = 2e-3  # mean net force of a grain over the mean contact force, at the end of the compaction
ISOTROPIC = 1e-2  # largest relative deviation of the wall stresses from σ₀, likewise …
CREEPING, CREEP_LOOKS = 3e-2, 10  # … or this one, of a balanced packing that has crept on for so many looks, and flips in longer steps
REST_TOLERANCE = 0.003  # residual of the solver over the net forces that are left, while the packing comes to rest: its errors must stay below
PATIENCE = 20_000  # steps after which a compaction that has not come to rest is given up
STIFFNESS = 1e3  # k_n/σ₀ of the smooth law: mean overlaps of some 1e-3 d
SHEAR_STIFFNESS = 0.8  # k_s/k_n
VISCOUS_DAMPING = 0.3  # of the smooth law, along normals, in shares of the critical one; there is no other damping in the shear
SMOOTH_TIME_STEP = 0.5  # dt over `rcr.critical_time_step`
SMOOTH_STRIDE = 10  # steps of the smooth law between two looks at the wall stresses
RECORD = 1e-3  # strain between two rows of the history
POSSIBLE = 0.2, 1.5  # packing fractions, walls included, outside of which a test has blown up or collapsed
COLUMNS = "step time strain sin_phi stress_x stress_y packing_fraction points iterations residual".split()
CHECKPOINT = "checkpoint.yade.gz"
FREE = ("threads",)  # parameters that change no bit of the results
SOLVERS = _kernel.solver_names()


def next_look(solver):
    """Steps towards rest until the next look at the net forces."""
    return LOOK if solver.unbalancedForce < ROUGH else 1


def approach(course, solver):
    """dt/t₀ of the steps to the next look towards rest, no longer than the last net forces allow: under the net force F ⟨f⟩ a grain moves by about F d (dt/t₀)².

    Parameters
    ----------
    course : dict
        How the approach has gone so far, empty at first; carried on.
    solver : ContactDynamics
        For its `unbalance` and `largestUnbalancedForce`.
    """
    reach, unbalances, before = course.get("reach", REACH), course.get("unbalances", []), course.get("steps", 0)
    steps = before + next_look(solver)
    if steps // LOOK > before // LOOK:
        unbalances = [*unbalances, solver.unbalancedForce]
    if len(unbalances) == 2 * LOOKS:
        earlier, unbalances = unbalances[:LOOKS], unbalances[LOOKS:]
        if sum(unbalances) > FALL * sum(earlier):
            reach = course["longest"] = SHORTER * reach
            if reach <= LEAST_REACH:
                reach = REACH
                del course["longest"]
    course.update(reach=reach, unbalances=unbalances, steps=steps)
    shortest, longest = TIME_STEPS
    largest = max(solver.largestUnbalancedForce, 1e-300)  # 0 in perfect balance
    return min(longest, max(shortest, math.sqrt(min(FARTHEST, reach * solver.unbalancedForce) / largest)))


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


def checked(
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
    iterations=SHEAR_ITERATIONS,
    approach=0.0,
    overdamped=False,
):
    """The parameters of a test as a dict, in numbers that fit; those of `Biaxial.prepare`.

    Raises
    ------
    ValueError
        For a parameter out of its range.
    """
    made = dict(
        eta=checks.number("eta", eta, "an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1),
        particles=checks.integer("particles", particles, "at least 10 and at most 10 million", lambda v: 10 <= v <= 10**7),
        seed=checks.integer("seed", seed, "a whole number ≥ 0", lambda v: v >= 0),
        friction=checks.number("friction", friction, "a coefficient ≥ 0, at most 100", lambda v: 0 <= v <= 100),
        tolerance=checks.number("tolerance", tolerance, "a residual 0 ≤ tolerance < 1", lambda v: 0 <= v < 1),
        solver=solver,
        threads=checks.integer("threads", threads, "0 (as YADE has) to 1024", lambda v: 0 <= v <= 1024),
        inertial_number=checks.number("inertial_number", inertial_number, "a number > 0", lambda v: v > 0),
        time_step=checks.number("time_step", time_step, "a number > 0, at most 10", lambda v: 0 < v <= 10),
        law=checks.choice("law", law, ("cd", "smooth")),
        stiffness=checks.number("stiffness", stiffness, "a number ≥ 1, at most 1e9", lambda v: 1 <= v <= 1e9),
        iterations=checks.integer("iterations", iterations, "a whole number > 0 of 32 bits", lambda v: 0 < v < 2**31),
        approach=checks.number("approach", approach, "a strain 0 ≤ approach < 1", lambda v: 0 <= v < 1),
        overdamped=checks.flag("overdamped", overdamped),
    )
    if solver not in SOLVERS:
        raise ValueError(f"solver {solver!r} is not known; wanted one of {', '.join(SOLVERS)}")
    if law == "smooth" and overdamped:
        raise ValueError("overdamped = True: springs have an inertia; wanted law = 'cd'")
    if approach > 0 and overdamped:
        raise ValueError(f"approach = {approach:g}: a faster way to the critical state is one with inertia; wanted 0 with overdamped = True")
    if law == "cd" and inertial_number * time_step > RECORD:
        raise ValueError(
            f"inertial_number × time_step = {inertial_number * time_step:g} is the strain of a step; wanted at most {RECORD:g}, that of a record"
        )
    return made


class Look(typing.NamedTuple):
    """The test after some steps, and what the walls felt in them."""

    step: int
    time: float  # [s]
    width: float  # [m]
    height: float  # [m]
    stresses: np.ndarray  # σ_x and σ_y, means of the steps [Pa], compression positive
    points: int  # of the last step, as what follows
    iterations: int
    residual: float  # [-]


class Springs:
    """Stand-in for `ContactDynamics` under the smooth law, which iterates nothing."""

    tolerance = residual = 0.0
    iterations = threads = 0
    overdamped = False

    @property
    def contactPoints(self):
        return sum(i.geom.points for i in O.interactions if i.isReal)


class Biaxial:
    """A biaxial test in the running YADE. The test lives in the scene: `O.save` keeps it, `Biaxial.load` goes on to the same bits.

    Attributes
    ----------
    parameters : dict
        Those of `prepare`: what the test is of.
    progress : dict
        phase ('collapse', 'rest', then 'shear'), counts and what the next step needs.
    rows : list of dict
        History, one row every 0.1 % of strain.
    isotropic : Network or None
        The end of the compaction, if it was made in this process.
    """

    def __init__(self, parameters, progress, rows):
        self.parameters, self.progress, self.rows, self.isotropic = parameters, progress, rows, None
        count = parameters["particles"]
        self.grains = range(count)
        self.left, self.bottom, self.right, self.top = self.walls = range(count, count + 4)
        masses = np.array([O.bodies[i].state.mass for i in self.grains])
        shapes = [O.bodies[i].shape for i in self.grains]
        self.area = masses.sum() / DENSITY
        self.diameter = 2 * np.mean([shape.halfLength + shape.capRadius for shape in shapes])
        self.time_unit = math.sqrt(masses.mean() / STRESS)
        engines = [engine for engine in O.engines if isinstance(engine, rcr.ContactDynamics)]
        self.solver = engines[0] if engines else Springs()

    @classmethod
    def prepare(cls, *arguments, **parameters):
        """A new test in a loose state: particles of random orientation, each in its circle of a deposited packing.

        Parameters
        ----------
        eta : float
            Elongation, 0 ≤ eta < 1 (default 0.5).
        particles : int
            Number of grains, at least 10 (1000).
        seed : int
            Of radii, places and orientations (1).
        friction : float
            Coefficient between grains during shear (0.5); walls have none.
        tolerance, solver, threads
            Of `ContactDynamics` (1e-4, 'auto', 0).
        inertial_number : float
            Rate of the shear times t₀, > 0 (`INERTIAL_NUMBER`).
        time_step : float
            dt/t₀ of the shear, 0 < time_step ≤ 10 (`TIME_STEP`); with the smooth law the stiffness sets the step.
        law : str
            Of the shear: 'cd', rigid contacts, or 'smooth', springs, with `VISCOUS_DAMPING` along normals and no other damping ('cd').
        stiffness : float
            k_n/σ₀ of the smooth law [-] (`STIFFNESS`).
        iterations : int
            Of the solver in a step of the shear at most (`SHEAR_ITERATIONS`); a tolerance below 1e-4 wants thousands.
        approach : float
            Strain up to which the shear is no slower than `INERTIAL_NUMBER`: the way to the critical state need not be slow (0).
        overdamped : bool
            Shear without inertia, `ContactDynamics.overdamped` (False): a step of the strain I dt/t₀ starts from rest, moves the grains as little as
            the top wall and the contacts ask for, and ends in balance but for a drag of I t₀/dt of the confining stress.

        Raises
        ------
        ValueError
            For a parameter out of its range.
        """
        parameters = checked(*arguments, **parameters)
        eta, particles, seed = (parameters[name] for name in ("eta", "particles", "seed"))
        O.reset()
        rng = np.random.default_rng(seed)
        centres, radii, width, height = deposited_packing(particles, rng)
        angles = rng.uniform(0, math.pi, particles)
        grain = O.materials.append(FrictMat(density=DENSITY, frictionAngle=0, label="grain"))
        plate = O.materials.append(FrictMat(density=DENSITY, frictionAngle=0, label="plate"))
        O.bodies.append([rcr.particle(c, R, eta, angle, grain) for c, R, angle in zip(centres, radii, angles)])
        mass = sum(b.state.mass for b in O.bodies)
        row = mass / math.sqrt(particles)  # a wall as heavy as a row of grains follows them; a heavier one answers each jump with its inertia
        left, bottom, right, top = O.bodies.append(
            [
                rcr.wall("x", 0, +1, material=plate),
                rcr.wall("y", 0, +1, material=plate),
                rcr.mobile_wall("x", width, row, -1, plate),
                rcr.mobile_wall("y", height, row, -1, plate),
            ]
        )
        O.dt = TIME_STEPS[0] * math.sqrt(mass / particles / STRESS)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R_MIN),
            InteractionLoop(
                [rcr.Ig2_Rcr_Rcr_RcrGeom(), rcr.Ig2_Wall_Rcr_RcrGeom()],
                [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()],
            ),
            rcr.WallStress(wall=right, start=bottom, end=top, stress=-STRESS),
            rcr.WallStress(wall=top, start=left, end=right, stress=-STRESS),
            rcr.ContactDynamics(maxIterations=3000, solver=parameters["solver"], threads=parameters["threads"], overdamped=True),
            NewtonIntegrator(damping=0),
        ]
        progress = dict(phase="collapse", iterations=0, residual_max=0.0, missed=0, missed_sum=0.0, missed_max=0.0, wall_seconds=0.0)
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

    @property
    def unbalance(self):
        """Mean net force of a grain over the mean contact force [-]: of the compaction's last step, so far or at its end."""
        return self.progress["unbalance_initial"] if self.progress["phase"] == "shear" else self.solver.unbalancedForce

    def sample_inertia(self, strain=None):
        """Inertia of the whole sample over σ₀ along its width W and its height h: ρ (ε̇ W)²/σ₀ and ρ (ε̇ h)²/σ₀, now or at a strain to come [-].

        ε̇ = v/h, v being the speed of the top wall. Where the sample flows homogeneously, u = ε̇ (x, −y), at constant v and area, a point
        has the acceleration 2 ε̇² x, and none along y: the fixed side wall feels ρ (ε̇ W)² more than the free one, exactly.
        """
        strain = self.strain if strain is None else strain
        height = self.progress["first_height"] * (1 - strain)
        width = self.area / (self.packing_fraction * height)
        rate = 0.0 if self.parameters["overdamped"] else self.top_speed(strain) / height
        return tuple(DENSITY * self.packing_fraction * (rate * length) ** 2 / STRESS for length in (width, height))

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

        Grains and walls have no inertia (`ContactDynamics.overdamped`). First they collapse: the loose packing is contracted
        homogeneously, 0.5 % a step or less, and moves as little as its contacts ask for, until these carry the load. Then they
        come to rest under the walls' load. The longer a step the faster, as long as its chords follow the paths: no grain
        shall move farther than 0.1 d, nor than 20 d, less where the balance does not come nearer, times the share of its forces that is not balanced yet.
        The wall stresses are then within 1 % of σ₀; within 3 % in a packing that creeps on though it is balanced, and flips in longer steps.

        Parameters
        ----------
        report : callable
            Called with the test after every step of the collapse, and after every ten of the rest.
        balanced : float
            Mean net force of a grain over the mean contact force at which the packing counts as balanced [-].

        Raises
        ------
        RuntimeError
            If it has not come to rest after `PATIENCE` steps.
        """
        while self.progress["phase"] != "shear":
            self.solver.tolerance = REST_TOLERANCE * min(0.1, max(self.solver.unbalancedForce, balanced))
            if self.progress["phase"] == "collapse":
                self._collapse()
            else:
                self._approach_rest()
                if self.solver.unbalancedForce < balanced:
                    if self._off_isotropic() < ISOTROPIC or self._creeps():
                        self._start_shear()
            report(self)
            if O.iter > PATIENCE:
                raise RuntimeError(
                    f"the compaction has not come to rest after {O.iter} steps: mean net force of a grain "
                    f"{self.solver.unbalancedForce:.1e} of the mean contact force (wanted {balanced:g}), wall stresses "
                    f"{self.mean_stresses / STRESS} σ₀ (wanted 1); another seed or a smaller tolerance may help"
                )

    def _off_isotropic(self):
        return float(np.abs(self.mean_stresses / STRESS - 1).max())

    def _creeps(self):
        """Whether the balanced packing is as near to σ₀ as it gets. Else the steps are lengthened, since it creeps the faster the longer they are; not
        beyond those that kept up flips, at first."""
        course = self.progress["approach"]
        longer = course["reach"] / SHORTER
        looks = course.get("looks", 0) + 1
        course.update(unbalances=[], looks=looks)
        if longer > course.get("longest", longer):
            if looks < CREEP_LOOKS:
                return False
            if self._off_isotropic() < CREEPING:
                return True
            del course["longest"]
        course.update(reach=longer, looks=0)
        return False

    def _collapse(self):
        contraction = MOST_CONTRACTION
        if self.solver.contactPoints > SPARSE * len(self.grains):
            contraction = min(contraction, CONTRACTION * self.diameter / max(self.width, self.height))
        for body in O.bodies:
            body.state.pos *= 1 - contraction
        width, height = self.width, self.height
        self._steps(1)
        if max(self.width / width, self.height / height) > 1 + contraction / 2 or self.mean_stresses.min() > COLLAPSED * STRESS:
            self.progress.update(phase="rest", approach={})

    def _approach_rest(self):
        O.dt = self.time_unit * approach(self.progress["approach"], self.solver)
        self._steps(next_look(self.solver))
        self.solver.trackMeanStretch = bool(self._off_isotropic() > HELD_UP * self.solver.unbalancedForce)

    def _start_shear(self):
        self.isotropic = self.network()
        self.progress.update(
            phase="shear",
            first_step=O.iter,
            first_height=self.height,
            packing_fraction_initial=self.packing_fraction,
            unbalance_initial=self.solver.unbalancedForce,
            stress_deviation_initial=self._off_isotropic(),
            residual_max=0.0,  # of the shear; the compaction is solved as finely as it is balanced
            missed=0,
            missed_sum=0.0,
            missed_max=0.0,
        )
        self.solver.tolerance = self.parameters["tolerance"]
        self.solver.maxIterations = self.parameters["iterations"]
        self.solver.overdamped = self.solver.trackMeanStretch = False
        if self.parameters["overdamped"]:
            self.drop_inertia()
        for body in O.bodies:
            body.state.vel = body.state.angVel = Vector3.Zero
        friction = self.parameters["friction"]
        O.materials["grain"].frictionAngle = math.atan(friction)  # of contacts to come; those with a wall stay smooth
        for i in O.interactions:
            if i.isReal and max(i.id1, i.id2) < self.left:
                i.phys.tangensOfFrictionAngle = friction
        for engine in O.engines:
            if isinstance(engine, rcr.WallStress) and engine.wall == self.top:
                engine.dead = True
        O.bodies[self.top].state.blockedDOFs = "xyzXYZ"
        if self.parameters["law"] == "smooth":
            self.soften(self.parameters["stiffness"])
        else:
            O.dt = self.parameters["time_step"] * self.time_unit

    def drop_inertia(self):
        """Make the steps from here on start from rest; see `ContactDynamics.overdamped`."""
        self.parameters.update(overdamped=True)
        pace = self.parameters["inertial_number"] / self.parameters["time_step"]
        self.solver.overdamped, self.solver.trackMeanStretch, self.solver.kinematicTolerance = True, True, OVERDAMPED_VIOLATION * min(1, pace / QUASI_STATIC_PACE)

    def soften(self, stiffness):
        """Let springs of k_n = `stiffness` σ₀ replace the rigid contacts; they are unloaded at first, and the packing shrinks by some σ₀/k_n."""
        O.interactions.clear()
        O.engines = [engine for engine in O.engines if not isinstance(engine, rcr.ContactDynamics)]
        loop = utils.typedEngine("InteractionLoop")
        loop.physDispatcher.functors, loop.lawDispatcher.functors = smooth_functors(stiffness)
        O.dt = SMOOTH_TIME_STEP * rcr.critical_time_step()
        self.parameters.update(law="smooth", stiffness=stiffness)
        self.solver = Springs()

    def pace(self, strain=None):
        """I and dt/t₀ of the shear, now or at a strain: the approach has I ≥ `INERTIAL_NUMBER` in steps of `TIME_STEP` at most."""
        rate, step = (self.parameters[name] for name in ("inertial_number", "time_step"))
        return (max(rate, INERTIAL_NUMBER), min(step, TIME_STEP)) if self._approaches(strain) else (rate, step)

    def _approaches(self, strain=None):
        return (self.strain if strain is None else strain) < self.parameters["approach"] - 0.5 * RECORD

    def top_speed(self, strain=None):
        """Speed of the top wall, now or at a strain, after its ramp [m/s]."""
        return self.pace(strain)[0] / self.time_unit * self.progress["first_height"]

    @property
    def steps_a_record(self):
        return max(1, round(RECORD * self.time_unit / (self.pace()[0] * O.dt)))

    @property
    def strain_a_record(self):
        """Strain of a record, after the ramp [-]."""
        return self.top_speed() * self.steps_a_record * O.dt / self.progress["first_height"]

    def shear_record(self):
        """Shear by one record: 0.1 % of strain, and a row of the history. See `shear`."""
        self.shear(1)

    def shear(self, records):
        """Shear by so many records, each of 0.1 % of strain and with a row of the history.

        Runs are as long as walls, time step and flow stay as they are, since each costs a look at all grains; the results are to the bit those of
        one run a record.

        Raises
        ------
        RuntimeError
            If the packing has blown up.
        """
        while records > 0:
            ramp = min(1, max(self.strain, RECORD / 10) / RAMP)
            O.bodies[self.top].state.vel = Vector3(0, -ramp * self.top_speed(), 0)
            if not isinstance(self.solver, Springs):
                O.dt = self.pace()[1] * self.time_unit
            if self.solver.overdamped:
                self.solver.flow = self._flow()
            alike = 1 if ramp < 1 or self.solver.overdamped or self._approaches() else records
            try:
                self._steps(self.steps_a_record, alike)
            finally:
                self.rows += map(self._row, self.looks)
            records -= alike

    def _row(self, look):
        """A row of the history; its step may be one of many in a run."""
        x, y = look.stresses
        first, fraction = self.progress["first_height"], self.area / (look.width * look.height)
        strain = (first - look.height) / first
        low, high = POSSIBLE
        if not (np.isfinite([x, y, strain]).all() and low < fraction < high):
            raise RuntimeError(
                f"the packing has blown up by step {look.step}, strain {strain:.4g}: packing fraction {fraction:.4g}, stresses of the "
                f"walls {x / STRESS:.3g} and {y / STRESS:.3g} σ₀; a smaller time step, inertial number or tolerance may help"
            )
        return dict(
            step=look.step,
            time=look.time,
            strain=strain,
            sin_phi=sin_phi(look.stresses),
            stress_x=x,
            stress_y=y,
            packing_fraction=fraction,
            points=look.points,
            iterations=look.iterations,
            residual=look.residual,
        )

    def _flow(self):
        """Velocity gradient of a sample that keeps its area [1/s]: what it dilates follows from the steps before (`ContactDynamics.trackMeanStretch`)."""
        closing = O.bodies[self.top].state.vel[1] / self.height
        return Matrix3(-closing, 0, 0, 0, closing, 0, 0, 0, 0)

    def _steps(self, count, times=1):
        """Make steps, and a look after each `count`, which is left in `looks`; add up the solver's work and average the wall stresses, which
        fluctuate from step to step."""
        start = time.perf_counter()
        self.looks = []
        if isinstance(self.solver, Springs):
            for _ in range(times):
                self._smooth_steps(count)
        else:
            self._rigid_steps(count, times)
        self.mean_stresses = self.looks[-1].stresses
        self.progress["wall_seconds"] += time.perf_counter() - start

    def _smooth_steps(self, count):
        stresses = []
        for left in reversed(range(count)):
            O.step()
            if left % SMOOTH_STRIDE == 0:
                stresses.append(self.wall_stresses())
        solver = self.solver
        self.looks.append(
            Look(O.iter, O.time, self.width, self.height, np.mean(stresses, axis=0), solver.contactPoints, solver.iterations, solver.residual)
        )

    def _rigid_steps(self, count, times):
        self.solver.observe, self.solver.observeEvery = [self.left, self.right, self.bottom, self.top], count
        self.solver.observed()
        self.solver.observations()
        width, height = self.width, self.height
        try:
            if count * times == 1:
                O.step()
            else:
                O.run(count * times, True)
        finally:
            self.solver.observeEvery = 0
            for seen in self.solver.observations():
                width, height = self._take_in(seen, width, height)

    def _take_in(self, seen, width, height):
        """Take in an observation of the solver; return width and height at its end, those given being of its beginning."""
        left, right, bottom, top = self.solver.observe
        before = np.array([height, height, width, width])
        width, height = seen["positions"][right][0] - seen["positions"][left][0], seen["positions"][top][1] - seen["positions"][bottom][1]
        lengths = (before + [height, height, width, width]) / 2
        forces = [abs(seen["forces"][wall][axis]) for wall, axis in zip(self.solver.observe, (0, 0, 1, 1))]
        stresses = (forces / lengths).reshape(2, 2).mean(axis=1)
        self.looks.append(Look(seen["step"], seen["time"], width, height, stresses, seen["points"], seen["last_iterations"], seen["last_residual"]))
        self.progress["iterations"] += seen["iterations"]
        self.progress["residual_max"] = max(self.progress["residual_max"], seen["residual"])
        self.progress["missed"] += seen["missed"]
        self.progress["missed_sum"] += seen["missed_sum"]
        self.progress["missed_max"] = max(self.progress["missed_max"], seen["missed_largest"])
        return width, height

    # --- results -------------------------------------------------------------------------------------------------------

    def network(self):
        """Contact network of the last step; see `rcr.Network`. Its friction is 0 until the first record of the shear."""
        friction = self.parameters["friction"] if self.rows else 0.0
        return rcr.contact_network(
            self.walls, strain=self.strain, eta=self.parameters["eta"], friction=friction, seed=self.parameters["seed"], run=self.run
        )

    @property
    def run(self):
        """Short hash of the parameters, which files of the test carry."""
        return results.identity(self.identity)

    @property
    def identity(self):
        """Parameters that set the results; the number of threads does not."""
        return {name: value for name, value in self.parameters.items() if name not in FREE}

    def overlaps(self):
        """Overlap of each contact point, 0 where it is open, in mean diameters [-]; ascending, so that sums do not know YADE's order."""
        gaps = [i.geom.gap[k] for i in O.interactions if i.isReal for k in range(i.geom.points)]
        return np.sort(np.maximum(0, -np.array(gaps))) / self.diameter

    def summary(self):
        """Contents of `summary.json`; stresses and fractions of the second half of the strain.

        `stress_deviation_initial` is the largest deviation of the wall stresses from σ₀ at the end of the compaction, over σ₀.
        `aspect_ratio` is width over height at the end, `sample_inertia` and `sample_inertia_height` what `sample_inertia` tells then.
        `stress_x_std` is the scatter of the lateral stress over σ₀, from record to record.
        `missed_fraction` is the share of the shear's steps that missed the tolerance or `kinematicTolerance`, `missed_mean` and `missed_max` by what
        factor; 0 without such steps.
        """
        network = self.network()
        late = [row for row in self.rows if row["strain"] >= 0.5 * self.strain]
        stresses = [np.mean([row[name] for row in late]) for name in ("stress_x", "stress_y")]
        between = network.between_particles
        types = network.contacts["type"][between]
        force = np.einsum("ca,ca->c", network.contacts["force"], network.contacts["normal"])[between]
        overlaps = self.overlaps()
        frictional = network.attributes["friction"] > 0
        first_width = self.area / (self.progress["packing_fraction_initial"] * self.progress["first_height"])
        along_width, along_height = self.sample_inertia()
        return dict(
            eta=self.parameters["eta"],
            particles=self.parameters["particles"],
            seed=self.parameters["seed"],
            strain=self.strain,
            sin_phi=float(sin_phi(stresses)),
            sin_phi_std=float(np.std([row["sin_phi"] for row in late])),
            stress_x_std=float(np.std([row["stress_x"] for row in late]) / STRESS),
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
            overdamped=self.parameters["overdamped"],
            approach=self.parameters["approach"],
            aspect_ratio_initial=first_width / self.progress["first_height"],
            aspect_ratio=self.width / self.height,
            sample_inertia=along_width,
            sample_inertia_height=along_height,
            unbalance_initial=self.progress["unbalance_initial"],
            stress_deviation_initial=self.progress["stress_deviation_initial"],
            steps=O.iter,
            dt=O.dt,
            iterations_mean=self.progress["iterations"] / O.iter,
            residual_max=self.progress["residual_max"],
            missed_fraction=self.progress["missed"] / max(1, O.iter - self.progress["first_step"]),
            missed_mean=self.progress["missed_sum"] / max(1, self.progress["missed"]),
            missed_max=self.progress["missed_max"],
            tolerance=self.parameters["tolerance"],
            run=self.run,
            wall_seconds=self.progress["wall_seconds"],
            threads=self.solver.threads or O.numThreads,
            version=rcr.__version__,
        )

    # --- files ---------------------------------------------------------------------------------------------------------

    def save(self, folder):
        """Write the history, and a checkpoint: scene, parameters and history in one file; each file whole or not at all."""
        kept = dict(parameters=self.parameters, progress=self.progress, rows=self.rows)
        O.tags["biaxial"] = json.dumps(kept, separators=(",", ":"))
        files.write(os.path.join(folder, "history.csv"), files.table(COLUMNS, self.rows))
        with _memory_file() as (handle, name):
            O.save(name, quiet=True)  # never to the disk: compressed, YADE spins for ever where that is full
            scene = handle.read()
        files.write(os.path.join(folder, CHECKPOINT), gzip.compress(scene, compresslevel=3, mtime=0))

    @classmethod
    def load(cls, folder):
        """The test as its last checkpoint left it.

        Raises
        ------
        FileNotFoundError
            If the folder has no checkpoint.
        ValueError
            If it is damaged, or no checkpoint of a biaxial test of this version.
        """
        checkpoint = os.path.join(folder, CHECKPOINT)
        if not os.path.exists(checkpoint):
            raise FileNotFoundError(2, "is missing: nothing to resume; run without --resume", checkpoint)
        with files.reading(checkpoint, "a checkpoint of a biaxial test"), _memory_file() as (handle, name):
            with gzip.open(checkpoint) as file:
                handle.write(file.read())  # its check sum tells every flipped bit before YADE sees one
            handle.flush()
            O.load(name, quiet=True)
            kept = json.loads(O.tags["biaxial"])
            return cls(checked(**kept["parameters"]), kept["progress"], kept["rows"])


@contextlib.contextmanager
def _memory_file():
    """A file in memory and its name, for YADE, which knows names only."""
    with open(os.memfd_create("scene"), "w+b") as handle:
        yield handle, f"/proc/self/fd/{handle.fileno()}"
