"""Shears long grains in a periodic cell without walls.

The cell shrinks, then a velocity gradient shears it under a constant pressure across the flow: its
height follows the grains. The script records stresses, solid fraction, and orientation and order of
the long axes against the shear strain. It averages the velocity profile.

Run it with YADE:  scripts/yade-rcr -n -x examples/periodic_shear.py
Writes DIR/cell.png, DIR/shear.png (stresses and orientation against strain), DIR/velocity.png, and
DIR/shear.csv.
"""

import math
import random

import matplotlib.pyplot as plt
import numpy as np
from yade import plot

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R, ETA = 0.01, 0.5
SIDE, STRAIN = (7, 0.5) if options.quick else (14, 3.0)  # grains along an edge, shear strain
RATE = 1.0  # shear rate [1/s]
DENSE = 0.74  # solid fraction at the end of the compression, below jamming
PRESSURE = 1000  # σ_yy during the shear [Pa]: an inertial number of about 0.03

draw = random.Random(4)
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.3)))
O.periodic = True
loose = 2.2 * R * SIDE
O.cell.setBox(loose, loose, 10 * R)
O.cell.flipFlippable = True  # a cell sheared by more than half its width flips
for i in range(SIDE):
    for j in range(SIDE):
        place, size = (2.2 * R * (i + 0.5), 2.2 * R * (j + 0.5)), draw.uniform(0.7, 1) * R
        O.bodies.append(particle(place, size, ETA, draw.uniform(0, math.pi), rough))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb()], verletDist=0.1 * R, allowBiggerThanPeriod=True),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom()], [Ip2_FrictMat_FrictMat_CdPhys()],
                    [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    CellStress(stress=(math.nan, math.nan), label="load"),  # velGrad alone moves the cell
    ContactDynamics(),
    NewtonIntegrator(damping=0),
    PyRunner(command="record()", iterPeriod=20, dead=True, label="recorder"),
]
O.dt = 1e-3

def record():
    """Store stresses (compression positive), and mean direction and order of the long axes."""
    network = rcr.contact_network()  # its volume is that of the cell
    stress = network.stress()
    mean = np.exp(2j * network.particles["angle"]).mean()  # an axis has no direction, hence 2
    plot.addData(strain=RATE * (O.time - start), shear=-stress[0, 1], normal=stress[1, 1],
                 solid=1 - rcr.measure.porosity(), axis=math.degrees(0.5 * np.angle(mean)),
                 order=abs(mean))
    flow.compute(reset=False)


# compression: the area of the cell falls as exp(−2 squeeze t)
squeeze = 1.0
filled = 1 - rcr.measure.porosity()
O.cell.velGrad = Matrix3(-squeeze, 0, 0, 0, -squeeze, 0, 0, 0, 0)
steps = round(0.5 * math.log(DENSE / filled) / squeeze / O.dt)
complete = rcr.advance(steps, "compression")

# shear: the height of the cell changes; the profile lies in the cell at all times
part = 0.8 * np.array(O.cell.size)[:2]
flow = rcr.Profile(cells=(1, 10), limits=((0, 0), part))
start = O.time
recorder.dead = False
load.stress = (math.nan, PRESSURE)
O.cell.velGrad = Matrix3(0, RATE, 0, 0, 0, 0, 0, 0, 0)
complete = complete and rcr.advance(round(STRAIN / RATE / O.dt), "shear")

rcr.snapshot(options.out / "cell.png", contacts="force")
if not plot.data:
    raise SystemExit("stopped before the shear")
data = {name: np.array(column) for name, column in plot.data.items()}
np.savetxt(options.out / "shear.csv", np.column_stack(list(data.values())),
           delimiter=",", header=",".join(data), comments="", fmt="%g")
fig, (left, right) = plt.subplots(1, 2, figsize=(7, 2.8), layout="constrained")
left.plot(data["strain"], data["shear"], label=r"$-\sigma_{xy}$")
left.plot(data["strain"], data["normal"], label=r"$\sigma_{yy}$")
left.set(xlabel="shear strain", ylabel="stress [Pa]")
left.legend()
right.plot(data["strain"], data["axis"], label="mean axis from $x$ [°]")
right.plot(data["strain"], 100 * data["order"], label="order [%]")
right.set(xlabel="shear strain")
right.legend()
fig.savefig(options.out / "shear.png", dpi=150)
ax = flow.plot(quantity="velocity_x")
ax.axline((0, 0), slope=1 / RATE, color="0.5", lw=0.8, zorder=0)  # the mean field
ax.figure.savefig(options.out / "velocity.png", dpi=150)
late = data["strain"] > 0.5 * data["strain"][-1]
mean = {name: column[late].mean() for name, column in data.items()}
print(f"solid fraction {mean['solid']:.3f}, "
      f"stress ratio {mean['shear'] / mean['normal']:.2f}, "
      f"long axes at {mean['axis']:.0f}° from the flow, order {mean['order']:.2f}")
