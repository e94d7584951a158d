"""Picture of YADE's 3D view: grains at rest between obstacles, and their forces.

Writes view-….png in the current folder. Run it in a session with a view,
`yade docs/generate/view.py`; pictures.py runs it on a virtual screen.
"""

import math
import os
import random
import sys
import time
import traceback

from PyQt5.QtWidgets import QApplication
from yade import qt

from rcr import *

PALETTE = [(0.55, 0.75, 1.0), (1.0, 0.87, 0.5), (0.7, 0.95, 0.7), (1.0, 0.7, 0.62)]


def draw(seconds):
    """Let Qt draw for some seconds."""
    end = time.time() + seconds
    while time.time() < end:
        QApplication.processEvents()


def scene():
    turn = random.Random(4)
    rough = O.materials.append(FrictMat(density=2600, frictionAngle=0.46))
    grey = dict(fixed=True, material=rough, color=(0.55, 0.55, 0.55))
    O.bodies.append([
        box((0, -0.01, 0), (0.15, 0.01, 0.02), **grey),
        box((-0.14, 0.08, 0), (0.01, 0.08, 0.02), **grey),
        box((0.14, 0.08, 0), (0.01, 0.08, 0.02), **grey),
        box((-0.02, 0.02, 0), (0.04, 0.012, 0.02), orientation=Quaternion((0, 0, 1), 0.4), **grey),
    ])
    for k in range(84):
        at = (-0.1125 + 0.025 * (k % 10), 0.065 + 0.025 * (k // 10))
        color = PALETTE[k % 4]
        if k % 4 == 3:
            O.bodies.append(disc(at, 0.009, color=color, material=rough))
        else:
            eta, angle = 0.3 + 0.2 * (k % 3), turn.uniform(0, math.pi)
            O.bodies.append(particle(at, 0.012, eta, angle, rough, color=color))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Sphere_Aabb(), Bo1_Box_Aabb()],
                              verletDist=0.001),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Sphere_Rcr_RcrGeom(),
                         Ig2_Sphere_Sphere_RcrGeom(), Ig2_Box_Rcr_RcrGeom(),
                         Ig2_Box_Sphere_RcrGeom()],
                        [Ip2_FrictMat_FrictMat_CdPhys()],
                        [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        ContactDynamics(tolerance=1e-6),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    ]
    O.dt = 1e-3
    O.run(1500, True)


def picture():
    view = qt.View()
    view.axes, view.grid, view.ortho = False, (False, False, False), True
    view.viewDir, view.upVector = (0, 0, -1), (0, 1, 0)
    view.screenSize = (900, 560)
    view.fitAABB((-0.105, 0.005, -0.02), (0.105, 0.125, 0.02))
    renderer = qt.Renderer()
    renderer.bgColor = (1, 1, 1)
    renderer.intrPhys = True
    draw(1)
    O.engines += [SnapshotEngine(fileBase="view-", iterPeriod=1, deadTimeout=30)]
    O.run(1)
    while O.running:
        draw(0.05)


try:
    scene()
    picture()
    code = 0
except BaseException:
    traceback.print_exc()
    code = 1
sys.stdout.flush()
os._exit(code)  # an open window would keep the session alive
