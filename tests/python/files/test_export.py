"""Files for ParaView, read back: areas, positions, forces, obstacles, series."""

import xml.etree.ElementTree as xml

import numpy as np
import pytest

meshio = pytest.importorskip("meshio")
pytest.importorskip("matplotlib")

from rcr import export
from rcr._pictures import grain_colors
from rcr.export import OBSTACLE_KINDS, VtkSeries, vtk
from rcr.frame import Frame

from common import refused
from synthetic import packing, polygon_areas


def data(mesh, name):
    return mesh.cell_data[name][0]


def test_areas_and_state_come_back(tmp_path):
    """Polygons have 24 corners: their areas are those of stadiums with 11 sin(π/11) for π."""
    network = packing(0.6)
    grains = meshio.read(vtk(tmp_path / "pile.vtm", network)[0])
    p = network.particles
    r, a = p["cap_radius"], p["half_length"]
    corners = grains.points[grains.cells_dict["polygon"]]
    area = 11 * np.sin(np.pi / 11) * r**2 + 4 * a * r
    assert polygon_areas(corners[..., :2]) == pytest.approx(area, rel=1e-12)
    assert data(grains, "area") == pytest.approx(np.pi * r**2 + 4 * a * r, rel=1e-14)
    centres = corners.mean(axis=1)
    assert centres[:, :2] == pytest.approx(p["position"], abs=1e-9) and not centres[:, 2].any()
    for name in ("id", "angle", "half_length", "mass"):
        assert np.array_equal(data(grains, name), p[name])
    assert data(grains, "velocity").shape == (200, 3)
    frame = Frame.of(network)
    assert data(grains, "stress") == pytest.approx(frame.grain_stresses().reshape(-1, 4))


def test_contacts_are_lines_with_forces(tmp_path):
    network = packing(0.6)
    network.contacts["friction"][7] = np.nan
    contacts = meshio.read(vtk(tmp_path / "pile.vtm", network)[1])
    lines = contacts.points[contacts.cells_dict["line"]][..., :2]
    assert lines.shape == (2 * len(network.contacts["body1"]), 2, 2)
    assert lines[0::2, 0] == pytest.approx(network.particles["position"][network.contacts["body1"]])
    assert lines[0::2, 1] == pytest.approx(network.contacts["position"])
    assert np.array_equal(lines[0::2, 1], lines[1::2, 0])
    assert lines[1::2, 1] - lines[0::2, 0] == pytest.approx(network.contacts["branch"])
    force = data(contacts, "force")[::2, :2]
    assert np.array_equal(force, network.contacts["force"])
    normal = (force * network.contacts["normal"]).sum(axis=1)
    assert data(contacts, "normal_force")[::2] == pytest.approx(normal)
    shear2 = (force**2).sum(axis=1) - normal**2
    assert data(contacts, "shear_force")[::2] ** 2 == pytest.approx(shear2, abs=1e-9)
    mobilization = np.sqrt(abs(shear2)) / (0.5 * normal)
    mobilization[7] = np.nan
    assert data(contacts, "mobilization")[::2] == pytest.approx(mobilization, nan_ok=True)
    assert contacts.point_data["normal_force"] == pytest.approx(np.repeat(normal, 3))


def scene(time=0.0, **attributes):
    made = packing(0.5)
    return Frame(made.grains, made.contacts, time=time, **attributes)


def test_obstacles(tmp_path):
    frame = scene()
    frame.outlines = [(7, "box", np.array([[0.0, 0], [2, 0], [2, 1], [0, 1]])),
                      (8, "facet", np.array([[0.0, 0], [3, 4]]))]
    frame.walls = dict(id=np.array([9]), axis=np.array([1]), position=np.array([-1.0]))
    frame.cell = np.array([[40.0, 5], [0, 40]])
    obstacles = meshio.read(vtk(tmp_path / "o.vtm", frame)[2])
    lines, quads = (obstacles.points[obstacles.cells_dict[kind]][..., :2]
                    for kind in ("line", "quad"))
    kinds = [[OBSTACLE_KINDS[k] for k in column] for column in obstacles.cell_data["kind"]]
    assert kinds == [["facet", "wall", "cell", "cell", "cell", "cell"], ["box"]]
    assert [list(column) for column in obstacles.cell_data["id"]] == [[8, 9, -1, -1, -1, -1], [7]]
    assert np.linalg.norm(lines[0, 1] - lines[0, 0]) == pytest.approx(5)
    assert (lines[1, :, 1] == -1).all()
    assert lines[2:, 0] == pytest.approx(np.array([[0, 0], [40, 0], [45, 40], [5, 40]]))
    assert quads[0] == pytest.approx(np.array([[0, 0], [2, 0], [2, 1], [0, 1]]))


def test_grains_have_the_velocity_of_their_image_in_a_sheared_cell(tmp_path):
    """The upper edge moves at 3 along x: images a period below are slower by 3."""
    frame = scene()
    frame.cell, frame.cell_velocity = np.diag([40.0, 40]), np.array([[0, 3.0], [0, 0]])
    frame.grains["velocity"] = np.tile([5.0, 1, 0.2], (200, 1))
    speed = grain_colors.SCALES["speed"].values(frame)
    frame.grains["position"][::2] += [0, 40]
    frame.grains["velocity"][::2, 0] += 3
    grains = meshio.read(vtk(tmp_path / "pile.vtm", frame)[0])
    assert data(grains, "velocity") == pytest.approx(np.tile([5, 1, 0], (200, 1)))
    assert data(grains, "speed") == pytest.approx(speed)
    assert grain_colors.SCALES["speed"].values(frame) == pytest.approx(speed)


def test_index_names_the_three_files(tmp_path):
    files = vtk(tmp_path / "pile.vtm", packing(0.5))
    parts = list(xml.parse(tmp_path / "pile.vtm").iter("DataSet"))
    assert [p.attrib["name"] for p in parts] == ["grains", "contacts", "obstacles"]
    assert [tmp_path / p.attrib["file"] for p in parts] == list(files)
    refused("ends in .vtm", vtk, tmp_path / "pile.vtk", packing(0.5))
    # without contacts and obstacles; VTK requires the element Cells even without cells, and meshio
    # reads no empty file
    frame = scene()
    frame.contacts = {name: column[:0] for name, column in frame.contacts.items()}
    files = vtk(tmp_path / "a.vtm", frame)
    pieces = [next(xml.parse(file).iter("Piece")).attrib for file in files]
    counts = [(int(piece["NumberOfPoints"]), int(piece["NumberOfCells"])) for piece in pieces]
    assert counts == [(24 * 200, 200), (0, 0), (0, 0)]
    assert all("<Cells>" in file.read_text() for file in files)


def test_a_failed_write_leaves_nothing(tmp_path, monkeypatch):
    def stop(file, *_):
        open(file, "w").close()
        raise KeyboardInterrupt

    monkeypatch.setattr(meshio, "write", stop)
    refused("", vtk, tmp_path / "a.vtm", scene(), error=KeyboardInterrupt)
    assert not list(tmp_path.iterdir())


# --- series

def test_series_grows_and_its_files_are_there(tmp_path):
    series = VtkSeries(tmp_path / "out")
    for time in (0.0, 0.1, 0.3):
        series.save(scene(time))
    moments = VtkSeries(tmp_path / "out").moments()
    assert [time for time, _ in moments] == [0, 0, 0, 0.1, 0.1, 0.1, 0.3, 0.3, 0.3]
    assert len({file for _, file in moments}) == 9
    assert all((tmp_path / "out" / file).exists() for _, file in moments)
    parts = [part.attrib["part"] for part in xml.parse(series.index).iter("DataSet")]
    assert parts == 3 * ["0", "1", "2"]
    for time in (0.4, 0.15, 0.25):  # a run loaded at 0.15 replaces its later files
        VtkSeries(tmp_path / "out").save(scene(time))
    assert [time for time, _ in VtkSeries(tmp_path / "out").moments()[::3]] == [0, 0.1, 0.15, 0.25]


def test_a_new_run_starts_a_new_series(tmp_path):
    """The second run replaces the index of the first, networks that of a scene."""
    def times(*frames):
        for frame in frames:
            series.save(frame)
        return [time for time, _ in series.moments()[::3]]

    series, network = VtkSeries(tmp_path), packing(0.5)
    assert times(*(scene(time, run="a") for time in (0.1, 0.2))) == [0.1, 0.2]
    assert times(scene(0.15, run="b")) == [0.15]
    assert times(scene(0.25, run="b")) == [0.15, 0.25]
    network.attributes["time"] = 0.4
    assert times(network) == [0.4] and times(scene(0.5)) == [0.4, 0.5]


def test_a_series_rejects_files_out_of_order(tmp_path):
    refused("time", VtkSeries(tmp_path).save, packing(0.5))
    (tmp_path / "scene.pvd").write_text("<VTKFile><Coll")
    refused("not a series", VtkSeries(tmp_path).save, scene())


def test_without_meshio_it_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "meshio", None)
    refused("python3-meshio", export.vtk, tmp_path / "a.vtm", scene(), error=ImportError)
