"""Chart c. The biaxial test to 20 % of strain: error of what a study reports against processor time of the shear.

Every run of one elongation and seed starts from the same frictionless packing (rigid, `Biaxial.compact`); its loads and walls are those of
scripts/biaxial.py. Means over strains of 10 to 20 %: q/p and the packing fraction of all records, most of the rest of one network a per cent.
Energies are those of a further per cent, with O.trackEnergy, over the work of the walls. Laws:

| law    | what it is                                                                                                             |
|--------|------------------------------------------------------------------------------------------------------------------------|
| cd     | ContactDynamics, over dt/t₀, tolerance and rate, one of them at a time                                                  |
| smooth | Law2_RcrGeom_FrictPhys_CundallStrack, over k_n/σ₀, as `--law smooth` has it                                              |
| stock  | what YADE has without this plugin: clumps of spheres of the cap radius, every R'/2 along the core, with the mass and inertia of the grain, Law2_ScGeom_FrictPhys_CundallStrack, k_n/σ₀ a sphere, local damping 0.2 |

The error of a setting is the mean, over seeds, of its difference from the reference of the same packing: rigid contacts with the shortest step
and the smallest tolerance, or, for rates, at the slowest of them. Its error bar is the standard deviation of the differences over √seeds: below it
a difference is chance.
"""

import math
import os
import time

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
from yade.wrapper import (
    Bo1_Sphere_Aabb, Bo1_Wall_Aabb, ForceResetter, FrictMat, Ig2_Sphere_Sphere_ScGeom, Ig2_Wall_Sphere_ScGeom, InsertionSortCollider,
    InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, Law2_ScGeom_FrictPhys_CundallStrack, MatchMaker, NewtonIntegrator, Omega,
)  # fmt: skip

import rcr
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from rcr.study.records import Springs
from rcr.network import BOTTOM, LEFT, RIGHT, TOP, Network
from rcr.study.analysis import standard_error

O = Omega()
RECORD = PROTOCOL.record_strain  # strain of a record
STRESS = PROTOCOL.confining_stress  # [Pa]
TITLE = "Biaxial test: error against processor time of 20 % of strain"
TITLES = dict(
    sin_phi="q/p", packing_fraction="packing fraction", friction_mobilization="I_M", mobilized="share of sliding contacts (I_m > 0.99)",
    weak_fabric="fabric of weak contacts, a_c(ξ = 1)", friction_share="share of the work that friction takes", mean_overlap="mean overlap [d]",
    energy_error="work unaccounted for",
)  # fmt: skip
OBSERVED = tuple(TITLES)
ERRORS = "mean_overlap", "energy_error"  # as they are
SETTING = "law", "dt", "tolerance", "inertial_number", "stiffness"
COLUMNS = ["eta", "particles", *SETTING, "seed", "steps", "seconds", *OBSERVED]
DEPENDS = ("quick", "particles")
ETAS = 0.0, 0.5
STRAIN, FROM, LOOK, ACCOUNT = 0.2, 0.1, 0.01, 0.01
RATE = 1e-3
DEFAULT = dict(dt=0.1, tolerance=1e-4, inertial_number=RATE)  # about which one setting at a time is changed
FINEST = dict(dt=0.05, tolerance=1e-5, inertial_number=RATE)  # the reference …
SLOWEST = dict(DEFAULT, inertial_number=5e-4)  # … and that of rates
SWEEPS = dict(dt=(0.4, 0.2, 0.1, 0.05), tolerance=(1e-2, 1e-3, 1e-4), inertial_number=(4e-3, 2e-3, RATE))
MOST_ITERATIONS = 1000  # of a step: here the tolerance shall end it
STOCK_DAMPING = 0.2
SLIDING = 0.99  # least I_m of a contact that counts as sliding


# ---------------------------------------------------------------------------------------------- the three laws


def _compacted(eta, seed, options):
    """The balanced packing of an elongation and a seed, made once."""
    folder = os.path.join(options.out, "packings", f"n{options.particles}-e{eta:g}-s{seed}")
    if not os.path.exists(os.path.join(folder, "checkpoint.yade.gz")):
        os.makedirs(folder, exist_ok=True)
        test = Biaxial.prepare(eta, options.particles, seed, threads=1)
        test.compact()
        test.save(folder)
    return Biaxial.load(folder)


def rigid(test, dt, tolerance, inertial_number):
    """The test with rigid contacts, each step solved to the tolerance."""
    test.parameters.update(time_step=dt, inertial_number=inertial_number)
    O.dt = dt * test.time_unit
    test.solver.tolerance, test.solver.maxIterations, test.solver.threads = tolerance, MOST_ITERATIONS, 1
    return test


class StockSprings(Springs):
    @property
    def contactPoints(self):
        return sum(i.isReal for i in O.interactions)


class Stock(Biaxial):
    """The test with clumps of spheres and YADE's own law, from a compacted one."""

    def __init__(self, test, stiffness):
        self.parameters, self.progress, self.rows = test.parameters, test.progress, []
        self.area, self.diameter, self.time_unit = test.area, test.diameter, test.time_unit
        self.solver = StockSprings()
        axis = lambda b: 2 * math.atan2(b.state.ori[2], b.state.ori[3])
        grains = [
            (tuple(b.state.pos), axis(b), b.shape.halfLength, b.shape.capRadius, b.state.mass, b.state.inertia[2])
            for b in (O.bodies[i] for i in test.grains)
        ]
        walls = [O.bodies[i] for i in test.walls]
        edges = [wall.state.pos[wall.shape.axis] for wall in walls]
        mass = walls[2].state.mass
        O.reset()
        rough = O.materials.append(FrictMat(density=PROTOCOL.density, frictionAngle=math.atan(self.parameters["friction"])))
        plate = O.materials.append(FrictMat(density=PROTOCOL.density, frictionAngle=0))
        self.ids = [_clump(*grain, rough) for grain in grains]
        self.left, self.bottom, self.right, self.top = self.walls = O.bodies.append(
            [
                rcr.wall("x", edges[0], +1, material=plate),
                rcr.wall("y", edges[1], +1, material=plate),
                rcr.mobile_wall("x", edges[2], mass, -1, plate),
                rcr.wall("y", edges[3], -1, material=plate),
            ]
        )
        kn, ks = stiffness * STRESS, PROTOCOL.shear_stiffness * stiffness * STRESS
        value = lambda k: MatchMaker(algo="val", val=k)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * PROTOCOL.smallest_radius),
            InteractionLoop(
                [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                [Ip2_FrictMat_FrictMat_FrictPhys(kn=value(kn), ks=value(ks))],
                [Law2_ScGeom_FrictPhys_CundallStrack()],
            ),
            rcr.WallStress(wall=self.right, start=self.bottom, end=self.top, stress=-STRESS),
            NewtonIntegrator(damping=STOCK_DAMPING),
        ]
        fastest = max(max(kn / m, kn * a * a / inertia, ks * (a + r) ** 2 / inertia) for _, _, a, r, m, inertia in grains)
        O.dt = PROTOCOL.smooth_time_step * 2 / math.sqrt(12 * fastest)  # the rule of rcr.critical_time_step

    def network(self):
        """All sphere contacts of two grains are one contact; the normal is that of the sum of their normal forces."""
        number = {i: k for k, i in enumerate(self.ids)}
        codes = dict(zip(self.walls, (LEFT, BOTTOM, RIGHT, TOP)))
        place = [np.array(O.bodies[i].state.pos)[:2] for i in self.ids]
        found = {}
        for i in O.interactions:
            if i.isReal and i.phys.normalForce.norm() > 0:
                pair, sign = [O.bodies[k].clumpId if O.bodies[k].isClumpMember else k for k in (i.id1, i.id2)], 1
                if pair[0] in codes or (pair[1] not in codes and pair[0] > pair[1]):
                    pair, sign = pair[::-1], -1
                entry = found.setdefault(tuple(pair), [np.zeros(2), np.zeros(2), np.zeros(2), 0])
                entry[0] += sign * np.array(i.phys.normalForce)[:2]
                entry[1] += sign * np.array(i.phys.shearForce)[:2]
                entry[2] += np.array(i.geom.contactPoint)[:2]
                entry[3] += 1
        rows = []
        for (one, two), (along, across, point, count) in found.items():
            point = point / count
            wall = two in codes
            branch = (point if wall else place[number[two]]) - place[number[one]]
            rows.append((number[one], codes[two] if wall else number[two], 3 if wall else 0, along / np.linalg.norm(along), branch, along + across, point, min(count, 2)))
        columns = [np.array(column) for column in zip(*rows)]
        n = len(self.ids)
        particles = dict(
            id=np.arange(n), position=np.array(place), angle=np.zeros(n), R=np.ones(n), cap_radius=np.ones(n), half_length=np.zeros(n),
            mass=np.ones(n), velocity=np.zeros((n, 3)),
        )  # fmt: skip
        contacts = dict(zip("body1 body2 type normal branch force position points".split(), columns))
        attributes = dict(time=O.time, strain=self.strain, dt=O.dt, volume=self.width * self.height, eta=self.parameters["eta"])
        return Network(particles, contacts, dict(attributes, friction=self.parameters["friction"], seed=self.parameters["seed"]))

    def overlaps(self):
        return np.array([max(0, i.geom.penetrationDepth) for i in O.interactions if i.isReal]) / self.diameter


def _clump(center, angle, a, r, mass, inertia, material):
    """A grain of spheres; mass and inertia are those of the grain. Returns the id of what moves."""
    count = 1 + math.ceil(4 * a / r)
    axis = np.array([math.cos(angle), math.sin(angle), 0])
    spheres = [utils.sphere(tuple(np.array(center) + s * axis), r, material=material) for s in (np.linspace(-a, a, count) if a > 0 else [0])]
    moving = O.bodies.append(spheres[0]) if a == 0 else O.bodies.appendClumped(spheres)[0]
    body = O.bodies[moving]
    body.state.mass, body.state.inertia = mass, Vector3(inertia, inertia, inertia)
    body.aspherical = False
    body.state.blockedDOFs = "zXY"
    return moving


# ---------------------------------------------------------------------------------------------- the chart


def _sheared(test):
    """Shear to 20 %; means over the second half."""
    seconds, networks, overlaps, look = 0.0, [], [], FROM + LOOK
    while test.strain < STRAIN - 0.5 * RECORD:
        start = time.process_time()
        test.shear_record()
        seconds += time.process_time() - start
        if not (math.isfinite(test.packing_fraction) and 0.2 < test.packing_fraction < 1.5):
            raise RuntimeError(f"the packing flew apart at a strain of {test.strain:.3f}")
        if test.strain > look - 0.5 * RECORD:
            network = test.network()
            mobilization = network.friction_mobilization()
            networks.append((mobilization.mean(), (mobilization > SLIDING).mean(), network.anisotropies(1.0)[0]))
            overlaps.append(test.overlaps().mean())
            look += LOOK
    late = [row for row in test.rows if row["strain"] > FROM]
    mean = lambda name: float(np.mean([row[name] for row in late]))
    looked = dict(zip(("friction_mobilization", "mobilized", "weak_fabric"), map(float, np.mean(networks, axis=0))))
    own = dict(sin_phi=mean("sin_phi"), packing_fraction=mean("packing_fraction"), mean_overlap=float(np.mean(overlaps)), seconds=seconds)
    return looked | own | _energies(test)


def _energies(test):
    """What friction takes, and what no account holds, of the work of the walls on a strain of `ACCOUNT`; both over that work.

    YADE's accounts hold what has come of a step when the next one is made; they count its local damping of the driven top wall, too, which that does not feel.
    """
    O.trackEnergy = True
    last = _work(test)
    first, work, end = _accounts(), np.zeros(2), test.strain + ACCOUNT
    while test.strain < end:
        work += last
        last = _work(test)
    O.trackEnergy = False
    friction, other = _accounts() - first
    return dict(friction_share=friction / work.sum(), energy_error=abs(work.sum() - friction - other + O.engines[-1].damping * work[0]) / work.sum())


def _work(test):
    """A step, and the work of the top wall and of the load on the right one in it [J]."""
    right, load = O.bodies[test.right].state, STRESS * test.height
    before = right.vel[0]
    O.step()
    return -O.dt * np.array([O.forces.f(test.top)[1] * O.bodies[test.top].state.vel[1], load * (before + right.vel[0]) / 2])


def _accounts():
    """Energy that friction has taken so far, and all other that was taken or is stored [J]."""
    accounts = dict(O.energy.items())
    other = "kinetic", "impactDissip", "viscDissip", "nonviscDamp", "elastPotential"
    return np.array([accounts.get("plastDissip", 0), sum(accounts.get(name, 0) for name in other)])


def points(options):
    """Names eta/law/setting/seed; of rigid contacts dt, tolerance and rate."""
    rigid = [FINEST, SLOWEST, *(dict(DEFAULT, **{name: value}) for name, values in SWEEPS.items() for value in values)]
    settings = dict.fromkeys(f"cd/{s['dt']:g}/{s['tolerance']:g}/{s['inertial_number']:g}" for s in rigid)
    springs = [f"{law}/{k:g}" for law in ("smooth", "stock") for k in ((1e2, 1e3) if options.quick else (1e2, 1e3, 1e4))]
    rigid_seeds, spring_seeds = (2, 2) if options.quick else (6, 2)
    of = lambda settings, seeds: [f"{eta:g}/{setting}/{seed}" for seed in range(1, seeds + 1) for eta in ETAS for setting in settings]
    return of(settings, rigid_seeds) + of(springs, spring_seeds)


def run(name, options):
    eta, law, *setting, seed = name.split("/")
    row = dict(eta=float(eta), particles=options.particles, law=law, seed=int(seed))
    row.update(zip(("dt", "tolerance", "inertial_number") if law == "cd" else ("stiffness",), map(float, setting)))
    test = _compacted(row["eta"], row["seed"], options)
    first = O.iter
    if law == "smooth":
        test.switch_to_springs(row["stiffness"])
    elif law == "stock":
        test, first = Stock(test, row["stiffness"]), 0
    else:
        test = rigid(test, row["dt"], row["tolerance"], row["inertial_number"])
    found = _sheared(test)
    return [dict(row, **found, steps=O.iter - first)]


def _difference(runs, target, name):
    """Processor time [s], mean difference from the target in pairs of equal packings, and its standard error, NaN of one pair alone. `ERRORS` are taken as they are."""
    differences = [row[name] - (0 if name in ERRORS else target[seed][name]) for seed, row in runs.items() if seed in target]
    if not differences:
        return None
    return np.mean([row["seconds"] for row in runs.values()]), np.mean(differences), float(standard_error(differences))


def sweeps(rows, name):
    """Of one elongation: {what is swept: [(its value, processor time [s], difference from the reference, its standard error)]}."""
    of = {}
    for row in rows:
        of.setdefault(tuple(row.get(key, "") for key in SETTING), {})[row["seed"]] = row
    rigid = lambda **changed: of.get(("cd", *dict(DEFAULT, **changed).values(), ""), {})
    finest, slowest = rigid(**FINEST), rigid(**SLOWEST)
    found = {}
    for swept, values in SWEEPS.items():
        found[swept] = [(value, _difference(rigid(**{swept: value}), slowest if swept == "inertial_number" else finest, name)) for value in values]
    for law in ("smooth", "stock"):
        found[law] = [(setting[-1], _difference(runs, finest, name)) for setting, runs in sorted(of.items(), key=lambda item: str(item[0])) if setting[0] == law]
    return {swept: [(value, *difference) for value, difference in line if difference] for swept, line in found.items()}


LABELS = dict(
    dt="rigid, dt/t₀ = 0.4 … 0.05", tolerance="rigid, tolerance 1e-2 … 1e-4", inertial_number="rigid, I = 4e-3 … 1e-3", smooth="springs on RCRs, k_n/σ₀ = 10², 10³ …",
    stock="YADE's clumps, k_n/σ₀ = 10², 10³ …",
)  # fmt: skip
STYLES = dict(dt=("0", "o", "-"), tolerance=("0", "s", "--"), inertial_number=("0", "^", ":"), smooth=("0.55", "D", "-"), stock=("0.55", "v", "--"))


def plot(rows, options):
    from matplotlib.figure import Figure

    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(9, 2.6 * len(OBSERVED)))
    for line, name in zip(figure.subplots(len(OBSERVED), len(ETAS), sharex="col"), OBSERVED):
        for ax, eta in zip(line, ETAS):
            for swept, points in sweeps([row for row in rows if row["eta"] == eta], name).items():
                _, seconds, difference, error = np.array(points).reshape(-1, 4).T
                color, marker, dashes = STYLES[swept]
                size = np.abs(difference)
                below = np.minimum(np.nan_to_num(error), 0.999 * size)  # a bar that would reach 0 ends just above it
                ax.errorbar(seconds, size, (below, np.nan_to_num(error)), color=color, marker=marker, ls=dashes, mfc="w" if swept in ("dt", "smooth") else color, ms=5, lw=1, label=LABELS[swept])
            ax.set(xscale="log", yscale="log")
            ax.set_title(f"η = {eta:g}: {TITLES[name] if name in ERRORS else 'error of ' + TITLES[name]}", fontsize=10)
            ax.grid(alpha=0.3)
            if name != "mean_overlap":
                ax.set_ylim(bottom=1e-4)
            if name == OBSERVED[-1]:
                ax.set_xlabel("processor time [s]")
    handles = {label: handle for ax in figure.axes for handle, label in zip(*ax.get_legend_handles_labels())}
    figure.tight_layout(rect=(0, 0, 1, 0.95))
    figure.legend(handles.values(), handles.keys(), ncols=2, loc="upper center", fontsize=9)
    return figure


def _told(name, difference, error):
    if name in ERRORS:
        return f"{difference:.1e}"
    return f"{difference:+.1g}" + ("" if math.isnan(error) else f" ± {error:.0e}")


def ratios(rows):
    """Errors of each setting, with those of chance, and its processor time."""
    rows = [row for row in rows if row["status"] == "ok"]
    yield " | ".join(["setting", "seconds", *TITLES.values()])
    yield "---|" * (len(OBSERVED) + 1) + "---"
    names = dict(dt="dt/t₀ = {:g}", tolerance="tolerance {:.0e}", inertial_number="I = {:g}", smooth="springs, k_n/σ₀ = {:.0e}", stock="clumps, k_n/σ₀ = {:.0e}")
    for eta in ETAS:
        of_eta = {name: sweeps([row for row in rows if row["eta"] == eta], name) for name in OBSERVED}
        for swept, line in of_eta[OBSERVED[0]].items():
            for k, (value, seconds, *_) in enumerate(line):
                cells = [_told(name, *of_eta[name][swept][k][2:]) for name in OBSERVED]
                yield " | ".join([f"η = {eta:g}, {names[swept].format(value)}", f"{seconds:.2g}", *cells])
