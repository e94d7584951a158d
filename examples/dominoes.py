"""Measures the speed of a wave of falling dominoes.

Each domino is a clump of two upright grains, so that it has two round feet. A push tips the first
one over. The wave reaches a constant speed of about √(g h).

Run it with YADE:  scripts/yade-rcr -n -x examples/dominoes.py
Writes DIR/dominoes.png (four times), DIR/wave.png and DIR/wave.csv (time of each fall).
"""

import math

import numpy as np
from matplotlib.figure import Figure

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
HEIGHT, THICK, GAP = 0.05, 0.01, 0.025  # sizes and distance of the dominoes [m]
COUNT = 8 if options.quick else 30

rough = O.materials.append(FrictMat(density=1000, frictionAngle=math.atan(0.4)))
O.bodies.append(rcr.wall("y", 0, +1, material=rough))


def domino(x):
    """Join two grains side by side; a single grain would fall off its round end."""
    R, cap = 0.5 * HEIGHT, 0.25 * THICK
    upright = dict(R=R, eta=1 - cap / R, angle=math.pi / 2, material=rough, color=(0.9, 0.85, 0.7))
    members = [particle((x + side * cap, R), **upright) for side in (-1, 1)]
    clump, _ = rcr.clump(members)
    return clump


dominoes = [domino(i * GAP) for i in range(COUNT)]
O.bodies[dominoes[0]].state.angVel = (0, 0, -6)  # the push
O.bodies[dominoes[0]].state.vel = (6 * 0.5 * HEIGHT, 0, 0)
fallen = {}  # time at which each domino has turned by 15° [s]


def record():
    for k, id_ in enumerate(dominoes):
        axis = O.bodies[id_].state.ori * Vector3(0, 1, 0)
        if k not in fallen and math.sin(math.radians(15)) < axis[0]:
            fallen[k] = O.time


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * THICK),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-6),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    PyRunner(command="record()", iterPeriod=1),
]
O.dt = 2e-4

figure = Figure(figsize=(7, 4), layout="constrained")
for shot, ax in enumerate(figure.subplots(4, 1)):
    if shot and not rcr.advance(round(0.016 * COUNT / O.dt), "falling"):
        break
    rcr.plot.packing(ax=ax, color="shape",
                     limits=((-HEIGHT, 0), (COUNT * GAP + HEIGHT, 1.4 * HEIGHT)))
    ax.set_title(f"{O.time:.2f} s", loc="left", fontsize=8)
figure.savefig(options.out / "dominoes.png", dpi=150)

if len(fallen) < 4:
    raise SystemExit("stopped before the wave started")
number, time = np.array(sorted(fallen.items())).T
np.savetxt(options.out / "wave.csv", np.column_stack([number * GAP, time]),
           delimiter=",", header="x,t", comments="", fmt="%g")
late = slice(len(number) // 2, None)  # steady part
line = np.polyfit(time[late], number[late] * GAP, 1)
speed = line[0]
figure = Figure(figsize=(4, 3), layout="constrained")
ax = figure.add_subplot()
ax.plot(time, number * GAP, "o", label="falls")
ax.plot(time[late], np.polyval(line, time[late]), label=f"{speed:.2f} m/s")
ax.set(xlabel="time [s]", ylabel="$x$ [m]")
ax.legend()
figure.savefig(options.out / "wave.png", dpi=150)
print(f"{len(fallen)} of {COUNT} dominoes fall; the speed of the wave is {speed:.2f} m/s, "
      f"{speed / math.sqrt(9.81 * HEIGHT):.2f} √(g h)")
