"""Compares a scene with reference values to detect changes of the physics.

The scene is a bed of grains at rest between two walls. The script ends with an error if a value
differs from its reference by more than its tolerance. Copy it to test your own scene.

Run it with YADE:  scripts/yade-rcr -n -x examples/regression.py
Writes DIR/regression.png and DIR/regression.csv.

Make new references:  … regression.py --spread 10
The option repeats the scene with small random displacements of the grains. It prints the mean of
each value, and as its tolerance five standard deviations, but at least the relative tolerance of
the solver. Rounding differs between processors, and falling grains amplify small differences, so
the references are means over the bed.
"""

import math
import random

import numpy as np

import rcr
from rcr import *
from rcr import script

SOLVER = 1e-4  # tolerance of the solver; no value is more accurate
REFERENCE = {  # value, tolerance; printed by --spread
    "load of the walls / weight": (1, 1e-4),
    "height of the centre / R": (8.072, 0.09),
    "solid fraction of the bulk": (0.8129, 0.02),
    "pressure of the bulk / that of a fluid": (0.6999, 0.1),
    "contacts a grain": (2.895, 0.2),
}

spread = dict(type=script.at_least(2), metavar="N", help="repeat N times, print new references")
options = script.options(__doc__, spread=spread)
R = 0.01


def measured(moved=0, seed=0):
    """Return the values of a bed of 150 grains at rest between two walls."""
    O.reset()
    draw, noise = random.Random(8), random.Random(seed)
    rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
    O.bodies.append(rcr.wall("y", 0, +1, material=rough))
    sides = ((0, +1), (21 * R, -1))
    O.bodies.append([rcr.wall("x", x, sense, material=rough) for x, sense in sides])
    for i in range(10):
        for j in range(15):
            x = 2.1 * R * (i + 0.5) + moved * noise.uniform(-1, 1)
            angle = draw.uniform(0, math.pi)
            O.bodies.append(particle((x, 2.1 * R * (j + 0.5)), R, 0.5, angle, rough))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                        [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        ContactDynamics(tolerance=SOLVER),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    ]
    O.dt = 1e-3
    if not rcr.advance(1000, "settling"):
        raise KeyboardInterrupt
    network = rcr.contact_network()
    grains = network.particles
    weight = 9.81 * grains["mass"].sum()
    walls = network.contacts["body2"] < 0
    bulk = rcr.Profile(cells=(1, 1), limits=((3 * R, 2 * R), (18 * R, 14 * R))).compute(network)
    height = np.average(grains["position"][:, 1], weights=grains["mass"])
    return {
        "load of the walls / weight": -network.contacts["force"][walls, 1].sum() / weight,
        "height of the centre / R": height / R,
        "solid fraction of the bulk": bulk.solid_fraction[0, 0],
        "pressure of the bulk / that of a fluid": bulk.pressure[0, 0] / (weight / (21 * R) * 0.5),
        "contacts a grain": network.grain_coordination().mean(),
    }


def reference(values):
    """Return the text "(mean, tolerance)" of repeated values."""
    mean = np.mean(values)
    tolerance = max(5 * np.std(values, ddof=1), SOLVER * abs(mean))
    digits = -math.floor(math.log10(tolerance))  # of the tolerance, which is rounded up
    return f"({mean:.{digits + 1}f}, {math.ceil(tolerance * 10**digits) / 10**digits:g})"


if options.spread:
    runs = [measured(1e-6 * R, seed) for seed in range(options.spread)]
    for name in runs[0]:
        print(f'    "{name}": {reference([run[name] for run in runs])},')
else:
    found = measured()
    rcr.snapshot(options.out / "regression.png", contacts="force")
    wrong = []
    with open(options.out / "regression.csv", "w") as table:
        print("quantity,measured,reference,tolerance", file=table)
        for name, (reference, tolerance) in REFERENCE.items():
            print(f"{name},{found[name]:.6g},{reference},{tolerance}", file=table)
            if not abs(found[name] - reference) <= tolerance:
                wrong.append(f"{name} = {found[name]:.4g}; expected {reference} ± {tolerance}")
    if wrong:
        raise ValueError("; ".join(wrong))
    print(f"all {len(REFERENCE)} values agree with their references")
