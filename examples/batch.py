"""Runs a table of parameters with yade-batch, each row as one scene.

A column of grains collapses on a floor. The table varies the elongation and the friction. The
script draws the run-out of all finished rows.

Run the table, four rows at a time:
    scripts/lib/run yade-batch -j 4 --log @.log examples/batch.table examples/batch.py
Run one row with the default parameters:
    scripts/yade-rcr -n -x examples/batch.py
Each run writes DIR/eta-E-mu-M.txt (root mean square of x against time) and DIR/eta-E-mu-M.yade
(last state). DIR/batch.png and DIR/batch.csv hold the results of all finished runs.
"""

import math
import random
import sys

import numpy as np
from matplotlib.figure import Figure
from yade import plot

# default parameters of a run without a table
readParamsFromTable(eta=0.5, mu=0.5)
from yade.params.table import eta, mu

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)  # yade-batch passes no options: its jobs write to out/batch
wide, high, seconds = (3, 5, 0.3) if options.quick else (6, 16, 1.2)
R = 0.01
draw = random.Random(7)
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(mu)))
O.bodies.append(rcr.wall("y", 0, +1, material=rough))
for i in range(wide):
    for j in range(high):
        x = 2.1 * R * (i + draw.uniform(-0.02, 0.02))  # an exact column of discs would stand
        angle = draw.uniform(0, math.pi)
        O.bodies.append(particle((x, 2.05 * R * (j + 0.5)), R, eta, angle, rough))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    PyRunner(command="record()", iterPeriod=20, initRun=True),
]
O.dt = 1e-3


def record():
    width = np.std([b.state.pos[0] for b in O.bodies if b.dynamic])
    plot.addData(t=O.time, width=width)


if not rcr.advance(round(seconds / O.dt), "collapse"):
    sys.exit("batch.py: stopped; this row has no result")

# atomic writes, because several jobs write and read at the same time
name = f"eta-{eta}-mu-{mu}"
with script.atomic_path(options.out / f"{name}.txt") as path:
    plot.saveDataTxt(path)
O.save(str(options.out / f"{name}.yade"), quiet=True)


def draw_runs(paths):
    """Draw the finished runs and save their run-outs."""
    rows = []
    figure = Figure(figsize=(4, 3), layout="constrained")
    ax = figure.add_subplot()
    for path in paths:
        run = np.genfromtxt(path, names=True)
        e, m = path.stem.removeprefix("eta-").split("-mu-")
        rows.append((float(e), float(m), run["width"][-1] / run["width"][0]))
        ax.plot(run["t"], run["width"] / run["width"][0], label=f"$\\eta$ = {e}, $\\mu$ = {m}")
    ax.set(xlabel="time [s]", ylabel="rms of x over that of the column")
    ax.legend(fontsize=7)
    with script.atomic_path(options.out / "batch.png") as path:
        figure.savefig(path, dpi=150)
    with script.atomic_path(options.out / "batch.csv") as path:
        np.savetxt(path, rows, delimiter=",", header="eta,mu,runout", comments="", fmt="%g")


drawn = []
while drawn != (finished := sorted(options.out.glob("eta-*.txt"))):
    draw_runs(finished)
    drawn = finished  # and again if another job has finished in the meantime
ratio = plot.data["width"][-1] / plot.data["width"][0]
print(f"eta = {eta}, mu = {mu}: the grains spread to {ratio:.2f} times the width of the column")
waitIfBatch()
