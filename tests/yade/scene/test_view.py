"""YADE's 3D view draws Rcrs in a window on a virtual screen, and the session survives.

One session opens the view before it loads rcr, makes a scene and takes pictures.
"""

import shutil
import subprocess

import numpy as np
import pytest
import rcr
from docs.generate.screen import virtual_screen

pytestmark = [
    pytest.mark.skipif(not shutil.which("Xvfb"), reason="needs a virtual screen: the package xvfb"),
    pytest.mark.skipif(not hasattr(rcr, "Gl1_Rcr"), reason="built without OpenGL"),
]

SESSION = """
import os, sys, time, traceback
from PyQt5.QtWidgets import QApplication

def draw(seconds=0.5):
    end = time.time() + seconds
    while time.time() < end:
        QApplication.processEvents()

try:
    from yade import qt
    out = OUT
    view = qt.View()  # open before rcr is there: its renderer has looked for functors already
    draw()
    import rcr
    rough = FrictMat(density=1000, frictionAngle=0.4, young=1e6)
    ids = [O.bodies.append(body) for body in (
        utils.box((1.5, -0.2, 0), (3, 0.2, 0.2), fixed=True, material=rough, color=(0.4, 0.4, 0.4)),
        rcr.particle((0, 0.2), 1, 0.8, 0, rough),
        rcr.particle((3, 0.5), 0.5, 0, 0, rough),
        rcr.particle((0, 0.7), 0.3, 0, 0, rough),
        rcr.particle((3, 2.5), 1, 0.5, 0.5, rough, fixed=True),
    )]
    for id_, color in zip(ids[1:], ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0))):
        O.bodies[id_].shape.color = color
    O.engines = [ForceResetter(), InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Box_Aabb()], verletDist=0.01),
                 InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom(), rcr.Ig2_Box_Rcr_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                                 [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
                 rcr.ContactDynamics(), NewtonIntegrator(gravity=(0, -10, 0), damping=0)]
    O.dt = 1e-3
    O.run(20, True)
    view.axes, view.grid, view.ortho = False, (False, False, False), True
    view.viewDir, view.upVector = (0, 0, -1), (0, 1, 0)
    view.screenSize = (640, 480)
    view.fitAABB((-1.5, -0.7, -0.5), (4.5, 3.7, 0.5))
    renderer = qt.Renderer()
    renderer.bgColor = (0, 0, 0)
    draw(1)

    O.engines += [SnapshotEngine(fileBase=os.path.join(out, "engine-"), iterPeriod=1, deadTimeout=30)]
    O.run(2)
    end = time.time() + 60
    while O.running and time.time() < end:
        draw(0.05)

    def picture(name):  # PNG: the format stays that of the engine
        draw()
        view.saveSnapshot(os.path.join(out, name + ".png"))
        draw()

    picture("plain")
    rcr.Gl1_Rcr.mark = False
    picture("unmarked")
    renderer.wire = True
    picture("wire")
    renderer.wire = False
    renderer.intrPhys = True
    for color in ("force", "type", "mobilization"):
        rcr.Gl1_CdPhys.color = color
        picture(color)
    renderer.intrPhys, renderer.intrGeom = False, True
    picture("points")
    print("lived", O.iter)
except BaseException:
    traceback.print_exc()
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Pictures of one session by name, (480, 640, 3) arrays from 0 to 1."""
    matplotlib = pytest.importorskip("matplotlib.image")
    folder = tmp_path_factory.mktemp("view")
    script = folder / "session.py"
    script.write_text(SESSION.replace("OUT", repr(str(folder))))
    with virtual_screen(folder) as environment:
        session = subprocess.run(["yade", str(script)], capture_output=True, text=True, timeout=300,
                                 env=environment, stdin=subprocess.DEVNULL)
    told = session.stdout + session.stderr
    assert session.returncode == 0 and "lived 22" in session.stdout, told
    pictures = {path.stem: np.array(matplotlib.imread(path)[..., :3])
                for path in folder.glob("*.png")}
    for picture in pictures.values():
        picture[:100, :90] = 0  # the view's own axes
    return pictures


def seen(picture, color):
    """Mask of the pixels of a pure colour, light or dark."""
    high, low = picture[..., [k for k in range(3) if color[k]]], picture[...,
        [k for k in range(3) if not color[k]]]
    return (high.min(axis=-1) > 0.25) & (high.min(axis=-1) > 2 * low.max(axis=-1))


def size(mask):
    """Width and height of a mask [pixels]."""
    rows, columns = np.nonzero(mask)
    return np.ptp(columns) + 1, np.ptp(rows) + 1


def test_grains_have_their_outlines_and_colours(pictures):
    """A long grain of 2 × 0.4 and a disc of 1 × 1 on one scale; areas to the resolution."""
    picture = pictures["unmarked"]
    (long, thin), (width, height) = size(seen(picture, (1, 0, 0))), size(seen(picture, (0, 1, 0)))
    assert width == pytest.approx(height, abs=3) and width > 40
    assert long / width == pytest.approx(2, rel=0.06)
    assert thin / width == pytest.approx(0.4, abs=0.05)
    scale = width  # pixels a metre
    assert seen(picture, (0, 1, 0)).sum() == pytest.approx(np.pi / 4 * scale**2, rel=0.06)
    assert seen(picture, (1, 0, 0)).sum() == pytest.approx((np.pi * 0.2**2 + 4 * 0.8 * 0.2)
                                                           * scale**2, rel=0.08)
    # turned
    assert seen(picture, (1, 1, 0)).sum() == pytest.approx((np.pi * 0.5**2 + 4 * 0.5 * 0.5)
                                                           * scale**2, rel=0.06)


def test_boxes_keep_their_colour(pictures):
    """YADE scales boxes; scaled normals would make them white."""
    picture = pictures["unmarked"]
    rows, columns = np.nonzero(seen(picture, (0, 1, 0)))
    below = picture[rows.max() + 10, int(columns.mean())]
    assert 0.1 < below.min() and below.max() < 0.8


def test_a_mark_shows_rotations(pictures):
    """A dark line to the right end of the disc."""
    changed = np.abs(pictures["plain"] - pictures["unmarked"]).max(axis=-1) > 0.15
    rows, columns = np.nonzero(seen(pictures["unmarked"], (0, 1, 0)))
    inside = changed[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    _, marked = np.nonzero(inside)
    assert len(marked) > 0.3 * np.ptp(columns) and marked.min() > 0.4 * np.ptp(columns)


def test_wire_shows_outlines_only(pictures):
    filled, wire = (seen(pictures[name], (1, 1, 0)) for name in ("unmarked", "wire"))
    assert 0 < wire.sum() < 0.2 * filled.sum()
    assert size(wire) == pytest.approx(size(filled), abs=4)


@pytest.mark.parametrize("name", ["force", "type", "mobilization", "points"])
def test_contacts_are_drawn_on_top(pictures, name):
    changed = np.abs(pictures[name] - pictures["unmarked"]).max(axis=-1) > 0.1
    assert 10 < changed.sum() < 0.2 * changed.size


def test_forces_are_as_thick_as_they_are(pictures):
    """The green disc rests on its lowest point: a line from its centre down, none above."""
    changed = np.abs(pictures["type"] - pictures["unmarked"]).max(axis=-1) > 0.1

    def width(color, below):
        """Width of the line `below` disc heights under the centre [pixels]."""
        rows, columns = np.nonzero(seen(pictures["unmarked"], color))
        row = int(rows.mean() + below * np.ptp(rows))
        return changed[row, columns.min() : columns.max() + 1].sum()

    # Width 2 × 0.2 R f/f_max [m]: discs bear their own weight, the long grain also the blue one's.
    green, blue, red = np.pi * 0.5**2, np.pi * 0.3**2, np.pi * 0.2**2 + 4 * 0.8 * 0.2
    diameter = size(seen(pictures["unmarked"], (0, 1, 0)))[0]
    assert width((0, 1, 0), -0.2) == 0 and width((0, 0, 1), -0.2) == 0
    assert width((0, 1, 0), 0.2) == pytest.approx(0.4 * 0.5 * green / (red + blue) * diameter,
                                                  abs=2)
    assert width((0, 0, 1), 0.2) == pytest.approx(0.4 * 0.3 * blue / (red + blue) * diameter, abs=2)


def test_snapshot_engine_works(pictures):
    names = sorted(name for name in pictures if name.startswith("engine-"))
    assert len(names) == 2
    assert seen(pictures[names[0]], (1, 0, 0)).sum() == pytest.approx(seen(pictures["unmarked"],
        (1, 0, 0)).sum(), rel=0.05)
