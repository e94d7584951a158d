"""YADE's 3D view draws grains on a virtual screen; view_session.py makes scene and pictures."""

import pathlib
import shutil
import subprocess

import numpy as np
import pytest
import rcr
from docs.generate.screen import virtual_screen
from common import ended
from scenes import environment

pytestmark = [
    pytest.mark.skipif(not shutil.which("Xvfb"), reason="needs a virtual screen: the package xvfb"),
    pytest.mark.skipif(not hasattr(rcr, "Gl1_Rcr"), reason="built without OpenGL"),
]

@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Pictures of one session by name, (480, 640, 3) arrays from 0 to 1."""
    matplotlib = pytest.importorskip("matplotlib.image")
    folder = tmp_path_factory.mktemp("view")
    script = pathlib.Path(__file__).with_name("view_session.py")
    with virtual_screen(folder) as screen:
        variables = screen | dict(PYTHONPATH=environment()["PYTHONPATH"])
        session = ended("yade", script, folder, env=variables, stdin=subprocess.DEVNULL)
    assert "lived 22" in session.stdout, session.stdout + session.stderr
    pictures = {path.stem: np.array(matplotlib.imread(path)[..., :3])
                for path in folder.glob("*.png")}
    for picture in pictures.values():
        picture[:100, :90] = 0  # the view's own axes
    return pictures


def seen(picture, color):
    """Mask of the pixels of a pure colour, light or dark."""
    given = np.array(color, dtype=bool)
    high, low = picture[..., given].min(axis=-1), picture[..., ~given].max(axis=-1)
    return (high > 0.25) & (high > 2 * low)


def difference(one, other, by=0.1):
    """Mask of the pixels in which two pictures differ."""
    return np.abs(one - other).max(axis=-1) > by


def size(mask):
    rows, columns = np.nonzero(mask)
    return np.ptp(columns) + 1, np.ptp(rows) + 1


def test_grains_have_their_outlines_and_colours(pictures):
    """A long grain of 2 × 0.4 and a disc of 1 × 1 on one scale; areas to the resolution."""
    picture = pictures["unmarked"]
    (long, thin), (width, height) = size(seen(picture, (1, 0, 0))), size(seen(picture, (0, 1, 0)))
    assert width == pytest.approx(height, abs=3) and width > 40
    assert long / width == pytest.approx(2, rel=0.06)
    assert thin / width == pytest.approx(0.4, abs=0.05)
    for color, area, error in (((0, 1, 0), np.pi / 4, 0.06),
                               ((1, 0, 0), np.pi * 0.2**2 + 4 * 0.8 * 0.2, 0.08),
                               ((1, 1, 0), np.pi * 0.5**2 + 4 * 0.5 * 0.5, 0.06)):  # turned
        assert seen(picture, color).sum() == pytest.approx(area * width**2, rel=error)
    first = min(name for name in pictures if name.startswith("engine-"))  # of a SnapshotEngine
    found, expected = (seen(one, (1, 0, 0)).sum() for one in (pictures[first], picture))
    assert found == pytest.approx(expected, rel=0.05)
    rows, columns = np.nonzero(seen(picture, (0, 1, 0)))
    below = picture[rows.max() + 10, int(columns.mean())]  # a box, which YADE scales:
    assert 0.1 < below.min() and below.max() < 0.8  # scaled normals would make it white


def test_polygons_have_their_outlines(pictures):
    """A rounded triangle: box and area on the scale of the disc of 1 × 1; a line when wired."""
    metre = size(seen(pictures["unmarked"], (0, 1, 0)))[0]
    found = seen(pictures["unmarked"], (1, 0, 1))
    side, height = 0.6 * np.sqrt(3), 0.6 * 1.5
    assert size(found) == pytest.approx(np.array([height + 0.4, side + 0.4]) * metre, abs=4)
    area = side * height / 2 + 3 * side * 0.2 + np.pi * 0.2**2
    assert found.sum() == pytest.approx(area * metre**2, rel=0.08)
    wire = seen(pictures["wire"], (1, 0, 1))
    assert 0 < wire.sum() < 0.2 * found.sum()
    marked = difference(pictures["plain"], pictures["unmarked"], by=0.15) & found
    assert np.ptp(np.nonzero(marked)[1]) == pytest.approx(0.8 * metre, abs=5)


def test_a_mark_shows_rotations(pictures):
    """A dark line to the right end of the disc."""
    changed = difference(pictures["plain"], pictures["unmarked"], by=0.15)
    rows, columns = np.nonzero(seen(pictures["unmarked"], (0, 1, 0)))
    _, marked = np.nonzero(changed[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1])
    assert len(marked) > 0.3 * np.ptp(columns) and marked.min() > 0.4 * np.ptp(columns)


def test_wire_shows_outlines_only(pictures):
    filled, wire = (seen(pictures[name], (1, 1, 0)) for name in ("unmarked", "wire"))
    assert 0 < wire.sum() < 0.2 * filled.sum()
    assert size(wire) == pytest.approx(size(filled), abs=4)


@pytest.mark.parametrize("name", ["force", "type", "mobilization", "points"])
def test_contacts_are_drawn_on_top(pictures, name):
    changed = difference(pictures[name], pictures["unmarked"])
    assert 10 < changed.sum() < 0.2 * changed.size


def test_forces_are_as_thick_as_they_are(pictures):
    """The green disc rests on its lowest point: a line from its centre down, none above."""
    changed = difference(pictures["type"], pictures["unmarked"])

    def width(color, below):
        """Width of the line `below` disc heights under the centre [pixels]."""
        rows, columns = np.nonzero(seen(pictures["unmarked"], color))
        row = int(rows.mean() + below * np.ptp(rows))
        return changed[row, columns.min() : columns.max() + 1].sum()

    # Width 2 × 0.2 R f/f_max [m]: discs bear their own weight, the long grain also the blue one's.
    green, blue, red = np.pi * 0.5**2, np.pi * 0.3**2, np.pi * 0.2**2 + 4 * 0.8 * 0.2
    diameter = size(seen(pictures["unmarked"], (0, 1, 0)))[0]
    assert width((0, 1, 0), -0.2) == 0 and width((0, 0, 1), -0.2) == 0
    for color, radius, weight in (((0, 1, 0), 0.5, green), ((0, 0, 1), 0.3, blue)):
        expected = 0.4 * radius * weight / (red + blue) * diameter
        assert width(color, 0.2) == pytest.approx(expected, abs=2)
