"""Count the meetings of two grains in which these intrude, over the length of their paths.

    scripts/yade-rcr -n -x benchmarks/meetings.py --out meetings.csv

Grains intrude if their overlap exceeds the cap radius at some instant of a step. The step has then
not converged. Two equal grains approach at random angles, speeds and spins, with restitution 0 and
friction 0 or 0.5. Prints a table and writes it as CSV.
"""

import math

import numpy as np
from yade import wrapper as w
from yade.wrapper import Omega

import rcr
from rcr import script
from rcr._data import files

O = Omega()
ETAS = (0, 0.3, 0.6, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999)
PATHS = (0.3, 1, 3)  # of the fastest surface point in a step [R]
CAPS = 10  # of the rule, beside 0.3 R [R′]
DT = 1e-3
COLUMNS = "eta path meetings intruding".split()


def place(seed, eta, path):
    """Set up two grains of R = 1 m that meet; surface points move by up to `path` in a step [m]."""
    rng = np.random.default_rng(seed)
    way = rng.uniform(0, 2 * math.pi)
    along = np.array((math.cos(way), math.sin(way)))
    aside = 0.4 * rng.uniform(-1, 1) * np.array((-along[1], along[0]))
    center = 0.5 * (2 + path * rng.uniform(0, 1)) * along + aside
    O.reset()
    O.dt = DT
    O.materials.append(w.FrictMat(density=1000, frictionAngle=math.atan(rng.choice([0, 0.5]))))
    O.bodies.append([rcr.particle(tuple(-sign * center), 1, eta, rng.uniform(0, math.pi),
                                  velocity=tuple(sign * rng.uniform(0.25, 0.5) * path / DT * along),
                                  angular_velocity=rng.uniform(-0.5, 0.5) * path / DT, material=0)
                     for sign in (1, -1)])
    O.engines = [
        w.ForceResetter(), w.InsertionSortCollider([rcr.Bo1_Rcr_Aabb()], verletDist=0.01),
        w.InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                          [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        rcr.ContactDynamics(tolerance=1e-8), w.NewtonIntegrator(damping=0)]
    return int(4 / path) + 4  # steps of the meeting


def intrudes(seed, eta, path):
    """Run one meeting; return whether a step of it has not converged."""
    O.run(place(seed, eta, path), True)
    return O.engines[3].missedSteps > 0


def main():
    parser = script.Parser(prog="meetings.py", description=__doc__.splitlines()[0])
    parser.add_argument("--meetings", type=script.at_least(1), default=200, metavar="N",
                        help="meetings of each elongation and path")
    parser.add_argument("--out", type=script.new_file, default="meetings.csv", metavar="FILE",
                        help="CSV")
    options, rows = parser.parse_args(), []
    for eta in ETAS:
        for path in sorted({min(PATHS[0], CAPS * (1 - eta)), *PATHS}):
            found = sum(intrudes(seed, eta, path) for seed in range(options.meetings))
            rows.append(dict(eta=eta, path=f"{path:.3g}", meetings=options.meetings,
                             intruding=found))
            print(*rows[-1].values(), flush=True)
    files.write(options.out, files.table(COLUMNS, rows))


if __name__ == "__main__":
    script.run(main)
