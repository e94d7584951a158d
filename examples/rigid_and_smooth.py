"""Compares rigid contacts with springs of two stiffnesses.

A column of grains collapses three times from the same places. The scripts of both laws differ in
the functors, the solver and the time step. Rigid contacts take longer steps and leave smaller
overlaps.

Run it with YADE:  scripts/yade-rcr -n -x examples/rigid_and_smooth.py
Writes DIR/rigid_and_smooth.png (heaps, and width against time) and DIR/rigid_and_smooth.csv.
"""

import math
import random
import time

import matplotlib.pyplot as plt
import numpy as np
from yade import plot

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01
WIDE, HIGH, SECONDS = (3, 5, 0.3) if options.quick else (5, 14, 0.8)
LAWS = {"rigid": None, "springs, 1e8 Pa": 1e8, "springs, 1e9 Pa": 1e9}  # young [Pa]


def column(young):
    """Make the column and the engines of one law."""
    O.reset()
    plot.resetData()
    draw = random.Random(6)
    rough = FrictMat(density=2600, frictionAngle=math.atan(0.5), young=young or 1, poisson=0.5)
    O.materials.append(rough)
    O.bodies.append(rcr.wall("y", 0, +1, material=rough))
    places = [(2.05 * R * i, 2.05 * R * (j + 0.5)) for i in range(WIDE) for j in range(HIGH)]
    O.bodies.append([particle(at, R, 0.5, draw.uniform(0, math.pi), rough) for at in places])
    if young is None:
        ip2, law2 = Ip2_FrictMat_FrictMat_CdPhys(), Law2_RcrGeom_CdPhys_SignoriniCoulomb()
        solver = [ContactDynamics(tolerance=1e-4)]
    else:
        ip2 = Ip2_FrictMat_FrictMat_FrictPhys()
        law2, solver = Law2_RcrGeom_FrictPhys_CundallStrack(damping=0.5), []
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()], [ip2], [law2]),
        *solver,
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
        PyRunner(command="record()", virtPeriod=0.01, initRun=True),
    ]
    # springs bound the time step, rigid contacts do not
    O.dt = 1e-3 if young is None else 0.5 * critical_time_step()


def record():
    gaps = [i.geom.gap[k] for i in O.interactions if i.isReal for k in range(i.geom.points)]
    x = [b.state.pos[0] for b in O.bodies if b.dynamic]
    overlap = max(0, -min(gaps, default=0)) / (2 * R)
    plot.addData(t=O.time, width=np.std(x) / R, overlap=overlap)


fig, axes = plt.subplots(2, 2, figsize=(8, 5), layout="constrained")
*axes, curves = axes.flat
rows = []
for (name, young), ax in zip(LAWS.items(), axes):
    column(young)
    began = time.perf_counter()
    complete = rcr.advance(round(SECONDS / O.dt), name)
    took = time.perf_counter() - began
    width, overlap = plot.data["width"][-1], max(plot.data["overlap"])
    rows.append((young or math.inf, O.dt, took, width, overlap))
    print(f"{name}: {O.iter} steps in {took:.1f} s, distance from the middle {width:.1f} R (rms), "
          f"overlaps up to {overlap:.1e} diameters")
    reach = 6 * WIDE * R
    limits = ((WIDE * R - reach, 0), (WIDE * R + reach, 0.5 * reach))
    rcr.plot.packing(ax=ax, limits=limits)
    ax.set_title(name, fontsize=8)
    curves.plot(plot.data["t"], plot.data["width"], label=name)
    if not complete:
        break
curves.set(xlabel="time [s]", ylabel="rms distance from the middle [R]")
curves.legend(fontsize=7)
fig.savefig(options.out / "rigid_and_smooth.png", dpi=150)
np.savetxt(options.out / "rigid_and_smooth.csv", rows, delimiter=",",
           header="young,dt,seconds,width,overlap", comments="", fmt="%g")
