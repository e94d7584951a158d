"""Session of test_view.py: opens YADE's view, loads rcr, and saves pictures of a scene."""

import os
import sys
import time
import traceback

from PyQt5.QtWidgets import QApplication
from yade import O, utils
from yade import wrapper as w

OUT = sys.argv[1]


def draw(seconds=0.5):
    end = time.time() + seconds
    while time.time() < end:
        QApplication.processEvents()


def make_scene(rcr, scenes):
    rough = w.FrictMat(density=1000, frictionAngle=0.4, young=1e6)
    O.bodies.append([
        utils.box((1.5, -0.2, 0), (3, 0.2, 0.2), fixed=True, material=rough, color=(0.4, 0.4, 0.4)),
        rcr.particle((0, 0.2), 1, 0.8, 0, rough, color=(1, 0, 0)),
        rcr.particle((3, 0.5), 0.5, 0, 0, rough, color=(0, 1, 0)),
        rcr.particle((0, 0.7), 0.3, 0, 0, rough, color=(0, 0, 1)),
        rcr.particle((3, 2.5), 1, 0.5, 0.5, rough, fixed=True, color=(1, 1, 0)),
        rcr.regular_polygon((0.5, 2.5), 0.8, 3, 0.2, material=rough, fixed=True, color=(1, 0, 1)),
    ])  # fmt: skip
    O.engines = scenes.engines(gravity=(0, -10, 0), tolerance=1e-4)
    O.dt = 1e-3
    O.run(20, True)


def save_pictures():
    from yade import qt

    view = qt.View()  # open before rcr is there: its renderer has looked for functors already
    draw()
    import rcr
    import scenes

    make_scene(rcr, scenes)
    view.axes, view.grid, view.ortho = False, (False, False, False), True
    view.viewDir, view.upVector = (0, 0, -1), (0, 1, 0)
    view.screenSize = (640, 480)
    view.fitAABB((-1.5, -0.7, -0.5), (4.5, 3.7, 0.5))
    renderer = qt.Renderer()
    renderer.bgColor = (0, 0, 0)
    draw(1)

    O.engines += [qt.SnapshotEngine(fileBase=os.path.join(OUT, "engine-"), iterPeriod=1,
                                    deadTimeout=30)]
    O.run(2)
    end = time.time() + 60
    while O.running and time.time() < end:
        draw(0.05)

    def picture(name):  # PNG: the format stays that of the engine
        draw()
        view.saveSnapshot(os.path.join(OUT, name + ".png"))
        draw()

    picture("plain")
    rcr.Gl1_Rcr.mark = False
    picture("unmarked")
    renderer.wire = True
    picture("wire")
    renderer.wire, renderer.intrPhys = False, True
    for color in ("force", "type", "mobilization"):
        rcr.Gl1_CdPhys.color = color
        picture(color)
    renderer.intrPhys, renderer.intrGeom = False, True
    picture("points")
    print("lived", O.iter)


try:
    save_pictures()
except BaseException:
    traceback.print_exc()
sys.stdout.flush()
os._exit(0)
