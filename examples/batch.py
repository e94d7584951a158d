"""One row of a table of parameters: how far a column of grains runs out, for yade-batch.

Run the table, four rows at a time:   scripts/lib/run yade-batch -j 4 --log @.log examples/batch.table examples/batch.py
Run it once, with the defaults:       scripts/yade-rcr -n -x examples/batch.py
Each run leaves DIR/eta-E-mu-M.txt (root mean square of x against time) and DIR/eta-E-mu-M.yade (its last state), and draws those of all
runs that are there: DIR/batch.png. The table of the results is DIR/batch.csv.
"""

import glob
import math
import os
import random

import numpy as np
from matplotlib.figure import Figure
from yade import plot

readParamsFromTable(eta=0.5, mu=0.5, wide=6, high=16, seconds=1.2, unknownOk=True)  # the defaults are those of a run without a table
from yade.params.table import eta, high, mu, seconds, wide

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)  # yade-batch hands none over: its jobs write into ./batch
if options.quick:
    wide, high, seconds = 3, 5, 0.3
R = 0.01
draw = random.Random(7)
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(mu)))
O.bodies.append(rcr.wall("y", 0, +1, material=rough))
O.bodies.append([particle((2.1 * R * (i + draw.uniform(-0.02, 0.02)), 2.05 * R * (j + 0.5)), R, eta, draw.uniform(0, math.pi), rough)
                 for i in range(wide) for j in range(high)])  # not quite upright: a column of discs would stand
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    PyRunner(command="plot.addData(t=O.time, width=np.std([b.state.pos[0] for b in O.bodies if b.dynamic]))", iterPeriod=20, initRun=True),
]
O.dt = 1e-3
rcr.advance(round(seconds / O.dt), "collapse")

name = os.path.join(options.out, f"eta-{eta}-mu-{mu}")
plot.saveDataTxt(name + ".txt")
O.save(name + ".yade", quiet=True)

# what all runs have left so far; the one that ends last draws everything
rows = []
figure = Figure(figsize=(4, 3), layout="constrained")
ax = figure.add_subplot()
for path in sorted(glob.glob(os.path.join(options.out, "eta-*.txt"))):
    run = np.genfromtxt(path, names=True)
    _, e, _, m = os.path.basename(path).removesuffix(".txt").split("-")
    rows.append((float(e), float(m), run["width"][-1] / run["width"][0]))
    ax.plot(run["t"], run["width"] / run["width"][0], label=f"$\\eta$ = {e}, $\\mu$ = {m}")
ax.set(xlabel="time [s]", ylabel="rms of x over that of the column")
ax.legend(fontsize=7)
with rcr._files.atomic_path(os.path.join(options.out, "batch.png")) as path:  # two jobs may end at once
    figure.savefig(path, dpi=150)
with rcr._files.atomic_path(os.path.join(options.out, "batch.csv")) as path:
    np.savetxt(path, rows, delimiter=",", header="eta,mu,runout", comments="", fmt="%g")
print(f"eta = {eta}, mu = {mu}: the grains spread to {plot.data['width'][-1] / plot.data['width'][0]:.2f} times the width of the column")
waitIfBatch()
