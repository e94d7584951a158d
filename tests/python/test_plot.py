"""Pictures and films of networks, without YADE and without a display."""

import sys
from unittest import mock

import numpy as np
import pytest
import rcr

matplotlib = pytest.importorskip("matplotlib")

import matplotlib.animation

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.image import imread
from rcr import plot
from rcr._pictures import drawing
from rcr._pictures.grain_colors import KIND_COLORS
from rcr.frame import Frame
from rcr.geometry import polygons

from common import python, refused
from synthetic import packing


def frame(count=3, **columns):
    """Grains in a row, a diameter of 2 apart, without contacts."""
    grains = dict(
        id=np.arange(count), clump=np.full(count, -1), fixed=np.zeros(count, bool),
        position=np.column_stack([2.0 * np.arange(count), np.zeros(count)]),
        angle=np.zeros(count), half_length=np.full(count, 0.5), cap_radius=np.full(count, 0.5),
        mass=np.ones(count), velocity=np.zeros((count, 3)),
        color=np.tile([0.1, 0.2, 0.3], (count, 1)))
    return Frame(grains | columns, contacts(0))


def contacts(count, **columns):
    along_x = np.tile([1.0, 0], (count, 1))
    places = along_x + np.column_stack([2.0 * np.arange(count), np.zeros(count)])
    return dict(body1=np.arange(count), body2=np.arange(count) + 1, type=np.zeros(count, int),
                points=np.ones(count, int), friction=np.full(count, 0.5), position=places,
                normal=along_x, force=along_x, branch=2 * along_x,
                point_moments=np.zeros((count, 2, 2))) | columns


def pressed(count, *forces, **columns):
    row = frame(count)
    row.contacts = contacts(len(forces), force=np.outer(forces, [1, 0]), **columns)
    return row


def grains_of(ax):
    return next(c for c in ax.collections if isinstance(c, PolyCollection))


def forces_of(ax):
    return [c for c in ax.collections if isinstance(c, LineCollection)]


def test_a_picture_needs_neither_a_display_nor_pyplot(tmp_path):
    packing(0.5).save(tmp_path / "network.h5")
    code = f"""
import sys, rcr.plot
rcr.plot.snapshot({str(tmp_path / "a.png")!r}, {str(tmp_path / "network.h5")!r}, contacts="force")
sys.exit("matplotlib.pyplot" in sys.modules or "yade" in sys.modules)
"""
    python(code, env={"PATH": "/usr/bin", "PYTHONPATH": ":".join(sys.path)})
    assert imread(tmp_path / "a.png").std() > 0.1


def test_grains_stand_where_they_are():
    """Pixels at the centres show grains, pixels between them the background."""
    ax = plot.packing(frame(3), color="red", legend=False)
    canvas = FigureCanvasAgg(ax.figure)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba()) / 255

    def pixel(x, y):
        column, row = ax.transData.transform((x, y))
        return picture[-1 - int(row), int(column), :3]

    for k in range(3):
        assert pixel(2 * k, 0) == pytest.approx([1, 0, 0], abs=0.01)  # 8 bits a colour
        assert pixel(2 * k + 0.8, 0.45) == pytest.approx([1, 1, 1], abs=0.01)  # beside the cap


colors_of = lambda scene, **options: grains_of(plot.packing(scene, **options)).get_facecolor()


def test_orientations_repeat_after_half_a_turn():
    around = frame(3, angle=np.array([0.3, 0.3 + np.pi, 0.3 - 5 * np.pi]))
    assert np.ptp(colors_of(around), axis=0) == pytest.approx(0, abs=1e-6)  # of 256 steps
    assert colors_of(frame(1, half_length=np.zeros(1)))[0] == pytest.approx(to_rgba(drawing.GRAIN))


@pytest.mark.parametrize("color", [*plot.SCALES, *plot.CATEGORIES, "0.5", "tab:blue"])
def test_every_name_of_a_colour(color):
    assert len(colors_of(packing(0.5), color=color)) == 200


@pytest.mark.parametrize("grains, options, colors", [
    pytest.param({}, dict(color=np.array([1.0, 2.0, np.nan]), cmap="gray", range=(1, 2)),
                 ["black", "white", drawing.GRAIN], id="numbers of the user"),
    pytest.param({}, dict(color=[0.0, 0.5, 1.0], cmap="gray"), ["0", "0.5", "1"],
                 id="three numbers for three grains are no colour"),
    pytest.param(dict(fixed=np.array([False, True, True])), dict(color="red"),
                 ["red", drawing.OBSTACLE, drawing.OBSTACLE], id="fixed grains are grey"),
    pytest.param(dict(half_length=np.array([0.5, 0, 0.5]), clump=np.array([-1, -1, 0])),
                 dict(color="type"), KIND_COLORS[:3], id="kinds of grains"),
])
def test_colours_of_grains(grains, options, colors):
    found = colors_of(frame(3, **grains), **options)
    assert found == pytest.approx(np.array(list(map(to_rgba, colors))), abs=0.01)  # 256 greys


def test_speed_load_and_pressure_of_a_grain():
    """Three discs in a row under a force of 7: the middle one bears 14, the stress is F·2r/A."""
    moving = frame(2, velocity=np.array([[3.0, 4.0, 100.0], [0, 0, 0]]))
    assert plot.SCALES["speed"].values(moving) == pytest.approx([5, 0])  # of the centre
    row = pressed(3, 7.0, 7.0)
    row.grains |= dict(half_length=np.zeros(3), cap_radius=np.ones(3))
    assert plot.SCALES["load"].values(row) == pytest.approx([7, 14, 7])
    assert plot.SCALES["pressure"].values(row)[1] == pytest.approx(0.5 * 7 * 2 / np.pi)
    assert plot.SCALES["contacts"].values(row) == pytest.approx([1, 2, 1])


def test_segments_are_as_thick_as_their_force_and_equal_forces_have_one_colour():
    """Rounding must not matter: 0.1 three times has the mean 0.10000000000000002."""
    lines = forces_of(plot.packing(pressed(4, 1.0, 2.0, 3.0), contacts="type"))
    widths = np.sort(np.concatenate([c.get_linewidths() for c in lines]))
    assert widths / widths[0] == pytest.approx([1, 2, 3])
    row = pressed(4, 0.1, 0.1 + 1e-9, 0.1 - 1e-9)
    assert len([c for c in forces_of(plot.packing(row, contacts="force")) if c.get_paths()]) == 1


def widths_of(ax):
    """Widths of the force lines, thinnest first [m]."""
    widths = np.concatenate([c.get_linewidths() for c in forces_of(ax) if c.get_paths()])
    return np.sort(widths) / drawing.points_a_metre(ax)


@pytest.mark.parametrize("eta", [0, 0.7, 0.95])
def test_force_lines_do_not_hide_needles(eta):
    """The widest line covers 40 % of the thickness 2R′ of a grain, one of the mean force 8 %.

    Lines of the mean force have at least 0.2 pt, here 24 % of the needles of 2R′ = 0.1.
    """
    row = pressed(30, *[1.0] * 27, 30.0, 2.0)
    row.grains |= dict(half_length=np.full(30, eta), cap_radius=np.full(30, 1 - eta))
    ax = plot.packing(row, contacts="force")
    thickness, mean = 2 * (1 - eta), 59 / 29
    least = 0.2 / drawing.points_a_metre(ax) / thickness
    assert grains_of(ax).get_linewidths()[0] <= 0.08 * thickness * drawing.points_a_metre(ax)
    shown = widths_of(ax) / thickness
    assert shown[0] == pytest.approx(max(0.08, least) / mean) and (eta < 0.9) == (least < 0.08)
    assert shown[-1] == pytest.approx(0.4)


def test_the_width_of_force_lines_is_an_option():
    row = pressed(4, 1.0, 2.0, 3.0)
    shown = widths_of(plot.packing(row, contacts="type", force_width=0.2))
    assert shown == pytest.approx(0.2 * 2 * 0.5 * np.array([0.5, 1, 1.5]))
    fixed = widths_of(plot.packing(row, contacts="type", force_width=0.2, reference_force=1))
    assert fixed == pytest.approx(0.2 * np.array([1, 2, 3]))
    black = forces_of(plot.packing(row, contacts="force", reference_force=2.5))[1]
    assert len(black.get_paths()) == 1
    for name in "force_width", "reference_force":
        for bad in 0, -1, np.nan, "wide":
            refused(f"{name} = ", plot.packing, row, contacts="force", **{name: bad})


def test_lines_of_many_small_grains_do_not_fade():
    ax = plot.packing(pressed(3000, *[1.0] * 2999), contacts="force")
    assert widths_of(ax) * drawing.points_a_metre(ax) == pytest.approx(0.2)


def texts_of(figure):
    return [text.get_text() for text in figure.texts]


@pytest.mark.parametrize("limits, length", [(((0, 0), (20, 10)), 2), (((0, 0), (4, 20)), 1),
                                            (((0, 0), (2e-3, 1e-3)), 2e-4)])
def test_the_length_scale_is_true(limits, length):
    figure = (ax := plot.packing(packing(0.5), limits=limits)).figure
    FigureCanvasAgg(figure).draw()
    assert f"{length:g} m" in texts_of(figure)
    (bar,) = [line for line in figure.findobj(matplotlib.lines.Line2D)
              if line.get_marker() == "|" and line.axes is None]
    pixels = bar.get_transform().transform(bar.get_xydata())[:, 0]
    assert np.ptp(ax.transData.inverted().transform(np.c_[pixels, pixels])[:, 0]) == pytest.approx(
        length, rel=1e-6)


def test_the_key_of_forces_has_their_mean():
    """Forces 1, 2 and 6 N/m; the lines of the key have the widths of 3 and 9 N/m."""
    row = pressed(4, 1.0, 2.0, 6.0)
    ax = plot.packing(row, contacts="force")
    assert {r"up to $\langle f_n\rangle$ = 3 N/m", "above, here 9 N/m"} <= set(texts_of(ax.figure))
    shown = [line.get_linewidth() for line in ax.figure.artists
             if line.get_color() in (drawing.WEAK, drawing.STRONG)]
    width = widths_of(ax)[0] * drawing.points_a_metre(ax)  # of 1 N/m
    assert shown == pytest.approx([3 * width, 9 * width])
    typed = plot.packing(row, contacts="type", reference_force=12.0)
    assert "$f_n$ = 12 N/m" in texts_of(typed.figure)
    assert not any("N/m" in text for text in texts_of(plot.packing(row).figure))
    assert not plot.packing(row, contacts="force", legend=False).figure.texts


@pytest.mark.parametrize("count", [1, 2, 10, 200])
def test_lines_cover_no_grain_and_stay_in_the_picture(count):
    """Outlines of few large grains: at most 1/20 of the radius, no thicker than the margin."""
    row = pressed(count, *[1.0] * (count - 1))
    row.walls = dict(id=np.array([99]), axis=np.array([1]), position=np.array([-0.5]))
    ax = plot.packing(row, contacts="type" if count > 1 else None)
    grains, point = grains_of(ax), drawing.points_a_metre(ax)
    assert grains.get_linewidths()[0] <= min(0.05 * point, 1.5)
    margin = point * (-1 - ax.get_xlim()[0])  # visible part of the first grain
    assert max(grains.get_linewidths()[0], ax.lines[0].get_linewidth()) / 2 < margin
    assert all(forces.get_linewidths()[0] <= 4 for forces in forces_of(ax))


@pytest.mark.parametrize("wide", [True, False], ids=["wide", "narrow"])
@pytest.mark.parametrize("contacts", [None, *plot.CONTACTS])
@pytest.mark.parametrize("color", [*plot.SCALES, "type"])
def test_texts_of_the_foot_do_not_overlap(color, contacts, wide):
    """No text overlaps another, the grains or the edge; no scale overlaps a text."""
    network = packing(0.5, particles_=100, contacts=200)
    network.particles["velocity"] = np.random.default_rng(1).normal(size=(100, 3))
    ax = plot.packing(network, color=color, contacts=contacts,
                      limits=((0, 0), (20, 10) if wide else (4, 20)))
    figure = ax.figure
    FigureCanvasAgg(figure).draw()
    picture, *scales = figure.axes
    ticks = [tick.label1 for scale in scales for tick in scale.xaxis.get_major_ticks()
             if scale.get_xlim()[0] <= tick.get_loc() <= scale.get_xlim()[1]]
    texts = [*figure.texts, *ticks, *(text for key in figure.legends for text in key.get_texts())]
    boxes = [artist.get_window_extent() for artist in (*texts, picture, *scales)]
    names = [text.get_text() for text in texts] + ["picture"] + ["scale"] * len(scales)
    assert len(names) > 1
    overlaps = [(one, two) for k, one in enumerate(names) for j, two in enumerate(names[:k])
                if boxes[k].overlaps(boxes[j])]
    assert not overlaps
    # half a pixel
    outside = [name for name, box in zip(names, boxes) if box.x0 < -0.5 or box.y0 < -0.5
               or box.x1 > figure.bbox.x1 + 0.5]
    assert not outside


@pytest.mark.parametrize("speed, power", [(4.5e-9, "10^{−9}"), (4.5e7, "10^{7}"), (0.3, None)])
def test_the_label_of_a_scale_has_its_power(speed, power):
    """Without its power, grains at rest to rounding seem to move at 4 m/s."""
    row = frame(3, velocity=np.array([[0, 0, 0], [speed / 2, 0, 0], [speed, 0, 0]]))
    texts = texts_of(plot.packing(row, color="speed", contacts=None).figure)
    (text,) = [text for text in texts if text.startswith("speed")]
    assert power in text if power else "10" not in text


@pytest.mark.parametrize("slow, fast", [(0.1162, 0.1362), (0.02, 0.23), (1, 1.0004), (0, 9e3)])
def test_the_numbers_of_a_scale_do_not_overlap(slow, fast):
    """Grains on a shaken plate have nearly one speed, whose numbers have many digits."""
    row = frame(2, velocity=np.array([[slow, 0, 0], [fast, 0, 0]]))
    figure = plot.packing(row, color="speed", contacts=None).figure
    FigureCanvasAgg(figure).draw()
    scale = figure.axes[1]
    boxes = [tick.label1.get_window_extent() for tick in scale.xaxis.get_major_ticks()
             if scale.get_xlim()[0] <= tick.get_loc() <= scale.get_xlim()[1]]
    assert len(boxes) >= 2
    assert all(right.x0 - left.x1 > 0.5 * left.height for left, right in zip(boxes, boxes[1:]))


def test_obstacles_are_in_the_picture_but_do_not_fill_it():
    scene = frame(3)
    floor = np.array([[-1e3, -2], [1e3, -2], [1e3, -1], [-1e3, -1]])
    scene.outlines = [(7, "box", floor), (8, "facet", np.array([[0.0, 2.0], [1.0, 3.0]]))]
    scene.walls = dict(id=np.array([9]), axis=np.array([0]), position=np.array([-1.5]))
    (left, bottom), (right, top) = scene.extent()
    # grains reach from −1 to 5, half of that on each side
    assert (left, right) == (-4, 8) and top == 3 and bottom == -2
    ax = plot.packing(scene)
    assert len(ax.lines) == 1 and list(ax.lines[0].get_xdata()) == [-1.5, -1.5]
    assert len(ax.collections) == 3


def ring(radius, count=60):
    """Corners of a drum, (count, 2, 2): its facets."""
    angle = 2 * np.pi * np.arange(count + 1) / count
    corners = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([corners[:-1], corners[1:]], axis=1)


@pytest.mark.parametrize("grains, radius", [(1, 40), (3, 45), (20, 60)])
def test_a_drum_is_whole_whatever_it_holds(grains, radius):
    """Facets, boxes or fixed discs of a drum are in the picture, grains lie at its foot."""
    place = np.column_stack([2.0 * np.arange(grains), np.full(grains, 0.7 - radius)])
    place[:, 0] -= grains - 1
    drum = frame(grains, position=place)
    drum.outlines = [(k, "facet", ends) for k, ends in enumerate(ring(radius))]
    whole = pytest.approx(radius * np.array([[-1, -1], [1, 1]]), rel=1e-9)
    assert drum.extent() == whole
    drum.outlines = [(k, "box", np.concatenate([ends, 0.99 * ends[::-1]]))
                     for k, ends in enumerate(ring(radius))]
    assert drum.extent() == whole
    inner = 10 * 2**0.5  # a square of 400 grains and a ring of 20 fixed discs around it
    cells = np.stack(np.meshgrid(*2 * [np.linspace(-10, 10, 20)]), axis=-1).reshape(-1, 2)
    place = np.concatenate([cells, 2.5 * inner * np.array(ring(1, 20)[:, 0])])
    scene = frame(420, position=place, fixed=np.arange(420) >= 400)
    assert scene.extent() == pytest.approx(2.5 * inner * np.array([[-1, -1], [1, 1]]), abs=1)


@pytest.mark.parametrize("at, top", [(5, 5), (50, 0.5)])
def test_a_wall_that_is_out_of_the_picture_does_not_extend_it(at, top):
    scene = frame(6)
    scene.walls = dict(id=np.array([9]), axis=np.array([1]), position=np.array([float(at)]))
    assert scene.extent()[1, 1] == top


def test_an_obstacle_beyond_the_size_of_the_grains_is_cut():
    """The limits: 50 diameters for few grains, four times their size for many."""
    few, many = frame(3), frame(200)
    for scene, size in ((few, 100), (many, 1600)):
        low, high = scene.extent()
        reach = 0.5 * (high - low).max()
        assert np.diff(scene.extent()[:, 0]) * 4 <= size
        for end, whole in ((low[0] + 0.99 * size, True), (low[0] + 1.01 * size, False)):
            scene.outlines = [(999, "facet", np.array([[0.0, 0.0], [end, 0.0]]))]
            assert scene.extent()[1, 0] == (end if whole else high[0] + reach)


def test_a_stray_grain_does_not_make_the_others_dots():
    place = np.column_stack([2.0 * (np.arange(200) % 20), 2.0 * (np.arange(200) // 20)])
    place[7] = [500, -300]
    (left, bottom), (right, top) = frame(200, position=place).extent()
    assert (left, right) == (-1, 39) and (bottom, top) == (-0.5, 18.5)
    both = frame(2, position=np.array([[0.0, 0], [500, -300]]))
    assert np.diff(both.extent(), axis=0)[0] == pytest.approx([502, 301])


def test_a_cell_shows_grains_inside_and_their_images():
    """A grain across a corner has three images; one outside by a period is drawn inside."""
    cell = frame(2, position=np.array([[9.9, 9.9], [-5.0, 25.0]]))
    cell.cell = np.array([[10.0, 0], [0, 10.0]])
    _, inside, images = (c for c in plot.packing(cell).collections if isinstance(c, PolyCollection))
    centres = lambda c: np.array([path.vertices[:-1].mean(axis=0) for path in c.get_paths()])
    assert centres(inside) == pytest.approx(np.array([[9.9, 9.9], [5, 5]]))
    found = sorted(map(tuple, np.round(centres(images), 9)))
    assert found == [(-0.1, -0.1), (-0.1, 9.9), (9.9, -0.1)]


def test_images_in_a_sheared_cell():
    scene = frame(40, position=np.random.default_rng(5).uniform(0, 30, (40, 2)))
    scene.cell = np.array([[10.0, 4.0], [0.5, 8.0]])
    at = scene.grains["position"] + scene.wrap(scene.grains["position"])
    rows, shifts = plot._images(scene, at)
    found = {(row, *np.round(np.linalg.solve(scene.cell, shift)).astype(int))
             for row, shift in zip(rows, shifts)}
    inverse = np.linalg.inv(scene.cell)
    for row, outline in enumerate(polygons(scene.grains | dict(position=at))):
        for step in np.ndindex(3, 3):
            i, j = np.array(step) - 1
            inside = (outline + scene.cell @ [i, j]) @ inverse.T
            if (i or j) and ((inside > 0) & (inside < 1)).all(axis=1).any():
                assert (row, i, j) in found


def test_users_axes_are_kept_and_get_no_legend():
    figure = Figure()
    ax = figure.add_subplot()
    assert plot.packing(frame(3), ax=ax, contacts="type") is ax
    assert len(figure.axes) == 1 and not figure.legends


@pytest.mark.parametrize("scene, options, error, says", [
    (frame(3), dict(color="sped"), ValueError, "orientation"),
    (frame(3), dict(color=[1, 2]), ValueError, "each of the 3 grains"),
    (frame(3), dict(contacts="forces"), ValueError, "expected None, 'force', 'type', 'mob"),
    (pressed(3, 1, 1, friction=np.array([np.nan, 1])), dict(contacts="mobilization"), ValueError,
     "µ is NaN for 1 of 2 contacts with a force; .*the attribute friction, or choose 'force'"),
    (frame(3), dict(color="speed", cmap="nope"), ValueError,
     "cmap = 'nope'; expected a Colormap or the name of one, such as 'viridis'"),
    (frame(3), dict(range=(1, 2, 3)), ValueError, r"range has shape \(3,\); expected \(2,\)"),
    (frame(3), dict(range=(1, 0)), ValueError, r"range = \(1, 0\); expected .*smaller one first"),
    *((frame(3), dict(color=color, range=(0, 1), cmap="Blues"), ValueError,
       r"range = \(0, 1\) and cmap = 'Blues', but .* has no scale; expected orientation, speed")
      for color in ("type", "shape", "red")),
    (frame(0), {}, ValueError, "nothing to draw"),
    (3, {}, TypeError, "Network"),
])
def test_what_is_refused(tmp_path, scene, options, error, says):
    refused(says, plot.packing, scene, error=error, **options)
    refused("picture format", plot.snapshot, tmp_path / "a.xyz", frame(1))
    refused("dpi = nan; expected 1 to 10000", plot.snapshot, tmp_path / "a.png", frame(1), np.nan)
    assert not list(tmp_path.iterdir())


# --- films

def moments_of(path):
    """Grey values (h, w) of the moments of a film."""
    from PIL import Image, ImageSequence

    with Image.open(path) as film:
        return [np.asarray(moment.convert("L")) for moment in ImageSequence.Iterator(film)]


@pytest.mark.parametrize("names, timed", [(["b", "a", "c"], True), (["2", "9", "10"], False)])
def test_film_of_networks(tmp_path, names, timed):
    """Frames in the order of time or names, to one scale: a grain moves right as in the film."""
    for k, name in enumerate(names):
        network = packing(0.5, particles_=5, contacts=20, seed=0)
        network.particles["position"] = np.tile([1.0 + 4.0 * k, 2.0], (5, 1))
        network.attributes |= dict(time=float(k)) if timed else {}
        network.save(tmp_path / f"network-{name}.h5")
    path = rcr.movie(tmp_path, color="black", legend=False)
    assert path.name == "movie.gif"
    middles = [np.nonzero(grey < 50)[1].mean() for grey in moments_of(path)]
    assert len(middles) == 3
    assert np.diff(middles) == pytest.approx(np.diff(middles)[0], rel=0.05)
    assert middles[0] < middles[1]


def test_a_film_has_one_scale_of_forces(tmp_path, monkeypatch):
    """The second network has three times the forces of the first: ½ and 3/2 of the film's mean."""
    for k in (1, 3):
        network = packing(0.5, particles_=20, contacts=50, seed=1)
        network.contacts["force"] = k * network.contacts["force"]
        network.attributes["time"] = float(k)
        network.save(tmp_path / f"network-{k}.h5")
    drawn = []
    add = drawing.add_forces
    monkeypatch.setattr(drawing, "add_forces", lambda ax, lines, force, scale: drawn.append(
        force.mean() / scale.force) or add(ax, lines, force, scale))
    rcr.movie(tmp_path, contacts="force", dpi=30)
    assert drawn[-2:] == pytest.approx([0.5, 1.5])


def test_defaults_of_a_film_may_be_given(tmp_path):
    for k in (1, 2):
        network = packing(0.5, particles_=5, contacts=20)
        network.particles["velocity"][:, 0] = k * np.arange(1, 6)
        network.save(tmp_path / f"network-{k}.h5")
    given = dict(color="speed", range=None, limits=None, legend=True)
    one, two = (rcr.movie(tmp_path, tmp_path / f"{len(options)}.gif", **options)
                for options in (dict(color="speed"), given))
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("files, options, says", [
    ("", {}, "no pictures and no networks"),
    (".part-1.png .part-1.h5", {}, "no pictures and no networks"),  # of killed processes
    ("a.h5 1.png", {}, r"networks \(a.h5\) and pictures \(1.png\); expected one kind"),
    ("1.png", dict(color="speed", contacts=None),
     "holds pictures, but color and contacts need networks .*give them to rcr.snapshot"),
    *(("1.png", dict(fps=fps), f"fps = {fps!r}; expected 0.01 to 100 pictures per second")
      for fps in (0, -1, "10", np.nan, 1e-3)),
    ("1.png", dict(dpi=np.nan), "dpi = nan; expected 1 to 10000 pixels per inch"),
])
def test_which_films_are_refused(tmp_path, files, options, says):
    for name in files.split():
        (tmp_path / name).touch()
    refused(says, rcr.movie, tmp_path, **options)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(files.split())


def test_film_of_pictures(tmp_path):
    (tmp_path / ".part-p8.png").touch()  # of a killed process
    for k in (10, 9):
        plot.snapshot(tmp_path / f"p{k}.png", frame(3), color="black" if k == 9 else "white",
                      legend=False, dpi=30)
    nine, ten = moments_of(rcr.movie(tmp_path, tmp_path / "film.gif"))
    assert nine.mean() < ten.mean() - 50


def test_a_film_needs_pictures_of_one_size(tmp_path):
    for k, width in ((8, 1), (9, 1), (10, 2), (11, 3)):
        plot.snapshot(tmp_path / f"p{k}.png", frame(3), limits=((-1, -1), (width, 1)), dpi=30,
                      color="black" if k == 9 else "white")
    refused("p8.png has .* pixels, p10.png has .*; expected one size: give the same `limits`",
            rcr.movie, tmp_path)
    assert not list(tmp_path.glob("*.gif"))
    for k in (10, 11):
        (tmp_path / f"p{k}.png").unlink()
    assert len(moments_of(rcr.movie(tmp_path))) == 2


def test_a_failed_film_leaves_nothing(tmp_path, monkeypatch):
    packing(0.5).save(tmp_path / "network.h5")
    monkeypatch.setattr(matplotlib.animation.FFMpegWriter, "isAvailable", lambda: False)
    refused("ffmpeg, which is not installed", rcr.movie, tmp_path, tmp_path / "a.mp4")
    monkeypatch.setattr(matplotlib.animation.PillowWriter, "grab_frame",
                        mock.Mock(side_effect=KeyboardInterrupt))
    refused("", rcr.movie, tmp_path, error=KeyboardInterrupt)
    assert [p.name for p in tmp_path.iterdir()] == ["network.h5"]


@pytest.mark.skipif(not matplotlib.animation.FFMpegWriter.isAvailable(),
                    reason="ffmpeg is not installed")
def test_film_by_ffmpeg(tmp_path):
    packing(0.5).save(tmp_path / "network.h5")
    assert rcr.movie(tmp_path, tmp_path / "a.mp4").stat().st_size > 1000


@pytest.mark.parametrize("count", [16, 13_000])
def test_a_picture_has_few_artists_at_any_number_of_grains(count):
    """An artist for each grain would take minutes at 13 000 grains; collections take a second."""
    dense = packing(0.5, particles_=count, contacts=2 * count)
    assert len(plot.packing(dense, contacts="force").get_children()) < 30
