"""Measure the error of the energy that springs dissipate, over the time step.

    scripts/yade-rcr -n -x benchmarks/spring_energy.py --out spring-energy.csv

A disc bounces on a floor without gravity; its dashpot takes part of its kinetic energy. A column of
24 grains collapses; dashpots and friction take the potential energy. `bounce` and `column` are
dissipated energy over lost energy − 1. Prints a table and writes it as CSV.
"""

import math
import random

from yade import wrapper as w
from yade.wrapper import Omega

import rcr
from rcr import script
from rcr._data import files

O = Omega()
SHARES = (0.5, 0.2, 0.1, 0.05)  # of critical_time_step()
COLUMNS = "share damping bounce column".split()
G = 9.81


def build(grains, share, damping, gravity, friction):
    """A scene of springs of grains above a floor."""
    O.reset()
    O.materials.append(w.FrictMat(density=1000, young=1e8, poisson=0.5,
                                  frictionAngle=math.atan(friction)))
    O.bodies.append([rcr.wall("y", 0, 1, material=0), *(make() for make in grains)])
    O.engines = [
        w.ForceResetter(),
        w.InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), w.Bo1_Wall_Aabb(), w.Bo1_Sphere_Aabb()],
                                verletDist=0.01),
        w.InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom(), rcr.Ig2_Wall_Rcr_RcrGeom(),
                           rcr.Ig2_Wall_Sphere_RcrGeom(), rcr.Ig2_Sphere_Rcr_RcrGeom(),
                           rcr.Ig2_Sphere_Sphere_RcrGeom()],
                          [w.Ip2_FrictMat_FrictMat_FrictPhys()],
                          [rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=damping)]),
        w.NewtonIntegrator(gravity=(0, -gravity, 0), damping=0)]
    O.dt = share * rcr.critical_time_step()
    O.trackEnergy = True


def energy(gravity):
    """Kinetic energy, and potential energy at the time of the velocities [J/m]."""
    total = 0
    for state in (b.state for b in O.bodies if b.state.mass > 0):
        height = state.pos[1] - 0.5 * O.dt * state.vel[1]
        total += state.mass * (gravity * height + 0.5 * state.vel.squaredNorm())
        total += 0.5 * state.inertia[2] * state.angVel[2] ** 2
    return total


def error(steps, gravity):
    """Run the scene; return dissipated energy over lost energy − 1."""
    before = energy(gravity)
    O.run(steps, True)
    kept = dict(O.energy.items())
    lost = before - energy(gravity) - kept.get("elastPotential", 0)
    return (kept.get("viscDissip", 0) + kept.get("plastDissip", 0)) / lost - 1


def bounce(share, damping):
    build([lambda: rcr.disc((0, 0.1001), 0.1, 0, velocity=(0, -1))], share, damping, 0, 0)
    return error(round(0.2 / O.dt), 0)


def column(share, damping):
    angles = random.Random(3)
    build([lambda i=i, j=j: rcr.particle((0.22 * i, 0.12 + 0.24 * j), 0.1, 0.5,
                                         angles.uniform(0, 3), 0)
           for i in range(3) for j in range(8)], share, damping, G, 0.5)
    return error(round(1 / O.dt), G)


def main():
    parser = script.Parser(prog="spring_energy.py", description=__doc__.splitlines()[0])
    parser.add_argument("--damping", type=script.number("a fraction ≥ 0", lambda v: v >= 0),
                        default=0.3, metavar="ZETA", help="damping of the springs")
    parser.add_argument("--out", type=script.new_file, default="spring-energy.csv", metavar="FILE",
                        help="CSV")
    options, rows = parser.parse_args(), []
    for share in SHARES:
        rows.append(dict(share=share, damping=options.damping,
                         bounce=f"{bounce(share, options.damping):.3g}",
                         column=f"{column(share, options.damping):.3g}"))
        print(*rows[-1].values(), flush=True)
    files.write(options.out, files.table(COLUMNS, rows))


if __name__ == "__main__":
    script.run(main)
