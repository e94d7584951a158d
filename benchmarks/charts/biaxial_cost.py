"""Chart c. The biaxial test to 20 % of strain: error of what a study reports against processor time of the shear.

Every run of one elongation starts from the same frictionless packing (rigid, `Biaxial.compact`); its loads, walls and rate are those
of scripts/biaxial.py. Means over strains of 10 to 20 %: q/p and the packing fraction of all records, I_M, a_c and the mean overlap of one
network a per cent. Laws:

| law    | what it is                                                                                                             |
|--------|------------------------------------------------------------------------------------------------------------------------|
| cd     | ContactDynamics, over solver, dt/t₀ and tolerance                                                                       |
| smooth | Law2_RcrGeom_FrictPhys_CundallStrack, over k_n/σ₀, as `--law smooth` has it                                              |
| stock  | what YADE has without this plugin: clumps of spheres of the cap radius, every R'/2 along the core, with the mass and inertia of the grain, Law2_ScGeom_FrictPhys_CundallStrack, k_n/σ₀ a sphere, local damping 0.2 |

The reference is the mean of several seeds with rigid contacts at the finest setting; what is drawn is how far the mean of a setting's seeds is
from it. Below the band s √(1/n + 1/n_ref), s the standard deviation of the reference's seeds, that is chance.
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
from rcr.study.biaxial import DENSITY, R_MIN, RECORD, SHEAR_STIFFNESS, SMOOTH_TIME_STEP, STRESS, Biaxial, Springs
from rcr.network import BOTTOM, LEFT, RIGHT, TOP, Network

O = Omega()
TITLE = "Biaxial test: error against processor time of 20 % of strain"
OBSERVED = "sin_phi", "packing_fraction", "friction_mobilization", "a_c", "mean_overlap"
COLUMNS = ["eta", "particles", "law", "solver", "dt", "tolerance", "stiffness", "seed", "steps", "seconds", *OBSERVED]
DEPENDS = ("quick", "particles")
ETAS = 0.0, 0.5
STRAIN, FROM, LOOK = 0.2, 0.1, 0.01
STOCK_DAMPING = 0.2


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


def rigid(test, solver, time_step, tolerance):
    test.parameters["time_step"] = time_step
    O.dt = time_step * test.time_unit
    test.solver.solver, test.solver.tolerance, test.solver.threads = solver, tolerance, 1
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
        rough = O.materials.append(FrictMat(density=DENSITY, frictionAngle=math.atan(self.parameters["friction"])))
        plate = O.materials.append(FrictMat(density=DENSITY, frictionAngle=0))
        self.ids = [_clump(*grain, rough) for grain in grains]
        self.left, self.bottom, self.right, self.top = self.walls = O.bodies.append(
            [
                rcr.wall("x", edges[0], +1, material=plate),
                rcr.wall("y", edges[1], +1, material=plate),
                rcr.mobile_wall("x", edges[2], mass, -1, plate),
                rcr.wall("y", edges[3], -1, material=plate),
            ]
        )
        kn, ks = stiffness * STRESS, SHEAR_STIFFNESS * stiffness * STRESS
        value = lambda k: MatchMaker(algo="val", val=k)
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R_MIN),
            InteractionLoop(
                [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                [Ip2_FrictMat_FrictMat_FrictPhys(kn=value(kn), ks=value(ks))],
                [Law2_ScGeom_FrictPhys_CundallStrack()],
            ),
            rcr.WallStress(wall=self.right, start=self.bottom, end=self.top, stress=-STRESS),
            NewtonIntegrator(damping=STOCK_DAMPING),
        ]
        fastest = max(max(kn / m, kn * a * a / inertia, ks * (a + r) ** 2 / inertia) for _, _, a, r, m, inertia in grains)
        O.dt = SMOOTH_TIME_STEP * 2 / math.sqrt(12 * fastest)  # the rule of rcr.critical_time_step

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
            networks.append((network.friction_mobilization().mean(), network.anisotropies()[0]))
            overlaps.append(test.overlaps().mean())
            look += LOOK
    late = [row for row in test.rows if row["strain"] > FROM]
    mean = lambda name: float(np.mean([row[name] for row in late]))
    mobilization, anisotropy = np.mean(networks, axis=0)
    values = mean("sin_phi"), mean("packing_fraction"), float(mobilization), float(anisotropy), float(np.mean(overlaps))
    return dict(zip(OBSERVED, values), seconds=seconds)


def points(options):
    """Names eta/law/setting/seed."""
    quick = options.quick
    dts, tolerances = ((0.1, 0.4) if quick else (0.025, 0.05, 0.1, 0.2, 0.4)), (1e-2, 1e-3, 1e-4)
    settings = [f"cd/auto/{dt:g}/{tolerance:g}" for dt in dts for tolerance in tolerances]
    settings += [f"cd/nlgs/0.1/{tolerance:g}" for tolerance in tolerances]
    settings += [f"smooth/{k:g}" for k in (1e2, 1e3, 1e4)] + [f"stock/{k:g}" for k in ((1e2, 1e3) if quick else (1e2, 1e3, 1e4))]
    names = []
    for eta in ETAS:
        names += [f"{eta:g}/reference/{seed}" for seed in range(1, 7)]
        names += [f"{eta:g}/{setting}/{seed}" for setting in settings for seed in ((1, 2, 3) if quick else (1, 2))]
        names += [] if quick else [f"{eta:g}/smooth/{1e5:g}/1"]  # takes minutes
    return names


def run(name, options):
    eta, law, *setting, seed = name.split("/")
    row = dict(eta=float(eta), particles=options.particles, law=law, seed=int(seed))
    if law == "reference":
        row.update(solver="auto", dt=0.1 if options.quick else 0.05, tolerance=1e-5)
    elif law == "cd":
        row.update(solver=setting[0], dt=float(setting[1]), tolerance=float(setting[2]))
    else:
        row["stiffness"] = float(setting[0])
    test = _compacted(row["eta"], row["seed"], options)
    first = O.iter
    if law == "smooth":
        test.soften(row["stiffness"])
    elif law == "stock":
        test, first = Stock(test, row["stiffness"]), 0
    else:
        test = rigid(test, row["solver"], row["dt"], row["tolerance"])
    found = _sheared(test)
    return [dict(row, **found, dt=O.dt / test.time_unit, steps=O.iter - first)]


TITLES = dict(
    sin_phi="relative error of q/p", packing_fraction="relative error of the packing fraction", friction_mobilization="relative error of I_M",
    a_c="error of a_c", mean_overlap="mean overlap [d]",
)  # fmt: skip


def plot(rows, options):
    from matplotlib.figure import Figure

    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(9, 3 * len(OBSERVED)))
    for line, name in zip(figure.subplots(len(OBSERVED), len(ETAS)), OBSERVED):
        for ax, eta in zip(line, ETAS):
            _panel(ax, [row for row in rows if row["eta"] == eta], name)
            ax.set_title(f"η = {eta:g}: {TITLES[name]}", fontsize=10)
            if name == OBSERVED[-1]:
                ax.set_xlabel("processor time [s]")
    handles = {label: handle for ax in figure.axes for handle, label in zip(*ax.get_legend_handles_labels())}
    figure.tight_layout(rect=(0, 0, 1, 0.94))
    figure.legend(handles.values(), handles.keys(), ncols=3, loc="upper center", fontsize=9)
    return figure


def _errors(rows, name):
    """Of one elongation: [(a row of the setting, seconds, error)], and the error that is chance, 0 where it is not known.

    Overlaps are errors as they are; everything else as its distance from the reference, relative but for a_c, which may be small.
    """
    finest = np.array([row[name] for row in rows if row["law"] == "reference"])
    plain = name == "mean_overlap" or not len(finest)
    target, scale = 0 if plain else finest.mean(), 1 if plain or name == "a_c" else abs(finest.mean())
    settings = {}  # the seeds of each
    for row in rows:
        if row["law"] != "reference":
            settings.setdefault(row["point"].rsplit("/", 1)[0], []).append(row)
    mean = lambda runs, key: np.mean([row[key] for row in runs])
    errors = [(runs[0], mean(runs, "seconds"), max(1e-6, abs(mean(runs, name) - target) / scale)) for runs in settings.values()]
    seeds = max(map(len, settings.values()), default=1)
    chance = 0 if plain or len(finest) < 2 else finest.std(ddof=1) * math.sqrt(1 / seeds + 1 / len(finest)) / scale
    return errors, chance


def ratios(rows):
    """Processor time of springs and clumps over the least of rigid contacts with no larger error, chance aside, for each observable."""
    rows = [row for row in rows if row["status"] == "ok"]
    yield "time over that of rigid contacts | " + " | ".join(TITLES[name] for name in OBSERVED)
    yield "---|" * len(OBSERVED) + "---"
    for eta in ETAS:
        cells = {}
        for name in OBSERVED:
            errors, chance = _errors([row for row in rows if row["eta"] == eta], name)
            for row, seconds, error in errors:
                if row["law"] != "cd":
                    rigid = [t for other, t, e in errors if other["law"] == "cd" and e <= max(error, chance)]
                    cell = f"{seconds / min(rigid):.2g}" if rigid else "not reached"
                    cells.setdefault(f"η = {eta:g}, {row['law']}, k_n/σ₀ = {row['stiffness']:.0e}, {seconds:.2g} s", []).append(cell)
        for setting, line in cells.items():
            yield f"{setting} | " + " | ".join(line)


def _panel(ax, rows, name):
    errors, chance = _errors(rows, name)
    curves = {}
    for row, seconds, error in errors:
        curves.setdefault(_label(row), []).append((seconds, error))
    for label, curve in curves.items():
        color = "k" if "springs" in label else "0.5" if "clumps" in label else "C3" if "nlgs" in label else "C0"
        marker = {"1e-02": "v", "1e-03": "s", "1e-04": "o"}.get(label[-5:], "^" if "springs" in label else "D")
        ax.loglog(*np.array(sorted(curve)).T, marker + "-", color=color, ms=5, lw=0.8, mfc="w" if "nlgs" in label else color, label=label)
    if chance:
        ax.axhspan(1e-6, chance, color="0.9", label="chance (standard error of the difference)")
        ax.set_ylim(bottom=1e-3)
    ax.grid(alpha=0.3)


def _label(row):
    if row["law"] == "cd":
        return f"rigid, {row['solver']}, tolerance {row['tolerance']:.0e}"
    return dict(smooth="springs on RCRs, k_n/σ₀ = 10², 10³ …", stock="YADE's clumps, k_n/σ₀ = 10², 10³ …")[row["law"]]
