"""Numbers of small scenes of every class, law and solver: {case: {quantity: number}}."""

import math
import pathlib
import sys

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "endurance"))

import numpy as np
import scene_fuzzer  # imports YADE before rcr
import rcr
from rcr.study.biaxial import Biaxial
from yade import O

TIME = 0.2  # simulated time until the grains rest [s]
SOLVERS = ["nlgs", "sor", "nesterov", "exact", "auto"]
PLAIN = dict(
    law="rigid", periodic=False, count=12, eta=0.6, friction=0.3, restitution=0.0, gravity=98.1,
    dt=1e-3, solver="auto", threads=1, overdamped=False,
    kinds=["Rcr", "Sphere", "Rcr", "clump"] * 3, floor="Wall", turning=False, speed=1.0,
    energy=True, gradient=None,
)  # fmt: skip
CELL = dict(periodic=True, gravity=0.0, gradient=[-0.3, 0.5, 0.0, -0.3], homoDeform=2, width=2.4,
            count=24, kinds=["Rcr", "Sphere", "Rcr", "clump"] * 6, speed=3.0)

SCENES = {
    **{f"rigid, {solver}": dict(solver=solver) for solver in SOLVERS},
    **{f"rigid, floor {floor}": dict(floor=floor) for floor in ("Wall", "Box", "Facet", "Rcr")},
    **{f"smooth, floor {floor}": dict(law="smooth", floor=floor)
       for floor in ("Wall", "Box", "Facet", "Rcr")},
    **{f"rigid, all {kind}": dict(kinds=[kind] * 12) for kind in ("Rcr", "Sphere", "clump")},
    "rigid, turning box": dict(turning=True),
    "rigid, restitution": dict(restitution=0.5),
    "rigid, frictionless": dict(friction=0.0),
    "rigid, overdamped": dict(overdamped=True),
    "rigid, cell": CELL,
    "smooth, cell": dict(law="smooth", **CELL),
}


def scene(**changes):
    """Means of grains, forces and energies of a scene of the fuzzer after TIME."""
    scene_fuzzer.build({**PLAIN, **changes}, np.random.default_rng(1))
    O.run(round(TIME / O.dt), True)
    grains = [b for b in O.bodies if not b.isClumpMember and b.state.blockedDOFs == "zXY"]
    mean = lambda of: float(np.mean([of(b.state) for b in grains]))
    solver = scene_fuzzer.solver()
    told = dict(
        x=mean(lambda s: s.pos[0]), y=mean(lambda s: s.pos[1]),
        turned=mean(lambda s: abs(2 * math.atan2(s.ori[2], s.ori[3]))),
        energy=math.fsum(0.5 * b.state.mass * b.state.vel.squaredNorm() + 0.5 * b.state.inertia[2]
                         * b.state.angVel[2] ** 2 for b in grains),
        force=math.fsum(i.phys.normalForce.norm() for i in O.interactions),
        plastic=O.energy["plastDissip"] if "plastDissip" in O.energy.keys() else 0.0,
    )  # fmt: skip
    return told | (dict(points=solver.contactPoints, overlap=solver.deepestOverlap) if solver
                   else {})


def stored(name, solver):
    """The solution of a packing under shear from a cold start; its forces depend on the solver."""
    tolerance = 1e-8 if solver in ("exact", "auto") else 1e-3
    solution = rcr.solve(str(TESTS / "data" / name), solver=solver, tolerance=tolerance,
                         max_iterations=20000)
    return dict(normal=float(solution.reaction[:, 0].sum()),
                tangential=float(abs(solution.reaction[:, 1]).sum()),
                closed=int((solution.reaction[:, 0] > 0).sum()))


def biaxial(law):
    """A biaxial test of 60 grains to 1 % of strain: walls, networks and their stress."""
    test = Biaxial.prepare(eta=0.5, particles=60, seed=1, law=law, threads=1, iterations=300)
    test.compact(balanced=0.01)
    compact = test.packing_fraction
    while test.strain < 0.01:
        test.shear_record()
    network = test.network()
    stress, fabric = network.stress(), network.fabric()
    return dict(compact=compact, packing_fraction=test.packing_fraction, width=test.width,
                contacts=len(network.contacts["body1"]),
                pressure=float(np.trace(stress)) / 2, fabric=float(fabric[1, 1]))  # fmt: skip


CASES = {
    **{name: lambda changes=changes: scene(**changes) for name, changes in SCENES.items()},
    **{f"{name}, {solver}": lambda name=name, solver=solver: stored(name, solver)
       for name in ("shear-500-eta-0.npz", "shear-500-eta-0.7.npz") for solver in SOLVERS},
    "biaxial, cd": lambda: biaxial("cd"),
    "biaxial, smooth": lambda: biaxial("smooth"),
}  # fmt: skip
