"""Files for ParaView: `vtk` at one time, `VtkSeries` of a run. Needs NumPy and meshio.

======================  ==========================================================================
``NAME-grains.vtu``     one polygon per grain, with its state as cell data
``NAME-contacts.vtu``   two lines per contact, centre to contact to centre, with its forces as cell
                        data; the normal force is point data too, for the filter Tube
``NAME-obstacles.vtu``  boxes as polygons; facets, walls (as far as the grains reach) and the edge
                        of a periodic cell as lines
``NAME.vtm``            index of the three files; ``NAME.pvd`` is the index of a series
======================  ==========================================================================

Grains of a periodic cell are moved into it. Forces are N per metre of depth, stresses Pa,
compression positive. The mobilization |f_t|/(µ f_n) is NaN if µ is unknown. A scene needs YADE, a
saved network does not.
"""

import os
import pathlib
import xml.etree.ElementTree as xml

import numpy as np

from rcr._data.files import atomic_path
from rcr.frame import Frame
from rcr.geometry import polygons

PARTS = ("grains", "contacts", "obstacles")
OBSTACLE_KINDS = ("box", "facet", "wall", "cell")  # values of the obstacles' column `kind`


def vtk(path, what=None):
    """Write grains, contacts and obstacles at one time; return the paths of their files.

    `path` is ``NAME.vtm``, the file to open in ParaView; the others are beside it. `what` is that
    of `Frame.of`, None the present scene of YADE. Each write is atomic; the index comes last. A
    ValueError reports another suffix, an ImportError that meshio is not installed.
    """
    path = pathlib.Path(path)
    if path.suffix != ".vtm":
        raise ValueError(f"{path}: expected a name that ends in .vtm")
    files = _write(path.with_suffix(""), Frame.of(what))
    rows = [dict(index=str(k), name=part, file=file.name)
            for k, (part, file) in enumerate(zip(PARTS, files))]
    _save_index(path, "vtkMultiBlockDataSet", "1.0", rows)
    return files


class VtkSeries:
    """A time series for ParaView: each `save` adds the present scene and updates ``NAME.pvd``.

    The names of the files begin with `name`. The folder, made if missing, has the state of the
    series, so a run continues it after ``O.save`` and ``O.load``. A `save` removes later times and
    other runs from the index. Runs differ in YADE's ``O.tags['id']``, which has a resolution of one
    second. Networks have no id and count as one run: give the networks of each run their own folder
    or name. A PyRunner needs no variable:

    ``PyRunner(command="import rcr; rcr.export.VtkSeries('out').save()", iterPeriod=100)``
    """

    def __init__(self, folder, name="scene"):
        self.folder, self.name = os.fspath(folder), name

    @property
    def index(self):
        """``NAME.pvd``, the file to open in ParaView."""
        return pathlib.Path(self.folder) / f"{self.name}.pvd"

    def moments(self):
        """Return time [s] and file of each part in the index, [(float, str)], or a ValueError."""
        return self._read()[1]

    def _read(self):
        """Return the run of the index, empty if unknown, and its `moments`."""
        if not self.index.exists():
            return "", []
        try:
            root = xml.parse(self.index).getroot()
            parts = [part.attrib for part in root.iter("DataSet")]
            moments = [(float(part["timestep"]), part["file"]) for part in parts]
            for _, file in moments:
                PARTS.index(_part_of(file))
            return root.get("run", ""), moments
        except (xml.ParseError, KeyError, ValueError) as error:
            given = f"{self.index}: not a series of VtkSeries ({error})"
            raise ValueError(f"{given}; remove it or choose another name") from error

    def save(self, what=None):
        """Add a scene or network of known time, by default YADE's scene; return the index."""
        frame = Frame.of(what)
        if not np.isfinite(frame.time):
            raise ValueError("the network has no attribute `time`, which a series needs")
        os.makedirs(self.folder, exist_ok=True)
        run, moments = self._read()
        before = [moment for moment in moments if moment[0] < frame.time and run == frame.run]
        number = len({time for time, _ in before})
        files = _write(pathlib.Path(self.folder) / f"{self.name}-{number:06d}", frame)
        rows = []
        for time, file in [*before, *((frame.time, file.name) for file in files)]:
            part = PARTS.index(_part_of(file))
            rows.append(dict(timestep=repr(time), group="", part=str(part), file=file))
        _save_index(self.index, "Collection", "0.1", rows, run=frame.run)
        return self.index


def _part_of(file):
    """Return the last word of the name of a file, which is one of `PARTS`."""
    return pathlib.Path(file).stem.rsplit("-", 1)[-1]


def _save_index(path, kind, version, rows, **more):
    """Write the index of files in ParaView's format `kind`, with the attributes of each file.

    `more` are attributes of the index, which ParaView ignores.
    """
    root = xml.Element("VTKFile", type=kind, version=version, **more)
    block = xml.SubElement(root, kind)
    for row in rows:
        xml.SubElement(block, "DataSet", row)
    xml.indent(root)
    with atomic_path(path) as partial:
        xml.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)


def _write(stem, frame):
    """Write the three files of a frame and return their paths."""
    try:
        import meshio
    except ImportError as error:
        raise ImportError("files for ParaView need meshio (Debian: python3-meshio)") from error

    files = []
    for part, mesh in zip(PARTS, (_grain_mesh, _contact_mesh, _obstacle_mesh)):
        files.append(stem.with_name(f"{stem.name}-{part}.vtu"))
        points, cells, *data = mesh(frame)
        with atomic_path(files[-1]) as partial:
            meshio.write(partial, meshio.Mesh(_in_space(points), cells, *data))
    return files


def _in_space(plane):
    """Add z = 0 to points or vectors of the plane."""
    plane = np.asarray(plane, float).reshape(-1, 2)
    return np.column_stack([plane, np.zeros(len(plane))])


def _grain_mesh(frame):
    grains = frame.grains
    at = grains["position"] + frame.wrap(grains["position"])
    outlines = polygons(grains | dict(position=at), frame.shapes)
    stress = frame.grain_stresses()
    normal = frame.normal_force()
    radius, velocity = grains["R"], frame.velocities()
    copied = ("id", "clump", "angle", "half_length", "cap_radius", "mass", "color", "shape")
    state = {name: grains[name] for name in copied} | dict(
        fixed=grains["fixed"].astype(int), kind=frame.kinds(), R=radius,
        eta=grains["half_length"] / radius, area=frame.areas(), velocity=_in_space(velocity[:, :2]),
        speed=np.hypot(velocity[:, 0], velocity[:, 1]), spin=velocity[:, 2],
        load=frame.per_grain(normal),
        contacts=frame.per_grain(normal > 0).astype(int),
        pressure=0.5 * (stress[:, 0, 0] + stress[:, 1, 1]), stress=stress.reshape(-1, 4))
    count = np.array([len(outline) for outline in outlines], int)
    cells, rows, first = [], [], np.cumsum(count) - count
    for corners in np.unique(count) if len(count) else (3,):  # a block has one number of corners
        rows.append(np.flatnonzero(count == corners))
        cells.append(("polygon", first[rows[-1], None] + np.arange(corners)))
    points = np.concatenate([np.empty((0, 2)), *outlines])
    return points, cells, {}, {name: [column[of_block] for of_block in rows]
                               for name, column in state.items()}


def _contact_mesh(frame):
    contacts = frame.contacts
    lines, normal = frame.segments(), frame.normal_force()
    (nx, ny), (fx, fy) = contacts["normal"].T, contacts["force"].T
    copied = ("body1", "body2", "type", "points", "friction")
    state = {name: contacts[name] for name in copied} | dict(
        normal_force=normal, shear_force=nx * fy - ny * fx,  # along the normal turned by +90°
        mobilization=frame.mobilization(), force=_in_space(contacts["force"]),
        normal=_in_space(contacts["normal"]))
    first = 3 * np.arange(len(normal))[:, None]
    cells = [("line", (first + [0, 1, 1, 2]).reshape(-1, 2))]
    cell_data = {name: [np.repeat(column, 2, axis=0)] for name, column in state.items()}
    return lines, cells, dict(normal_force=np.repeat(normal, 3)), cell_data


def _obstacle_lines(frame):
    """Return facets, walls and edges of the cell as (id, kind, ends); the cell has the id −1."""
    low, high = frame.extent()
    lines = [(id_, "facet", ends) for id_, kind, ends in frame.outlines if kind == "facet"]
    for id_, axis, at in zip(*(frame.walls[name] for name in ("id", "axis", "position"))):
        ends = np.stack([low, high])
        ends[:, axis] = at
        lines.append((id_, "wall", ends))
    if frame.cell is not None:
        corners = (frame.cell @ np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]])).T
        lines += [(-1, "cell", corners[k : k + 2]) for k in range(4)]
    return lines


def _obstacle_mesh(frame):
    boxes = [(id_, "box", corners) for id_, kind, corners in frame.outlines if kind == "box"]
    points, cells, data, start = [np.empty((0, 2))], [], dict(id=[], kind=[]), 0
    for shape, rows, corners in (("line", _obstacle_lines(frame), 2), ("quad", boxes, 4)):
        if shape == "quad" and not rows:
            continue  # VTK requires one kind of cells, which may be empty
        points += [vertices for _, _, vertices in rows]
        cells.append((shape, start + np.arange(corners * len(rows)).reshape(-1, corners)))
        data["id"].append(np.array([id_ for id_, _, _ in rows], dtype=int))
        kinds = [OBSTACLE_KINDS.index(kind) for _, kind, _ in rows]
        data["kind"].append(np.array(kinds, dtype=int))
        start += corners * len(rows)
    return np.concatenate(points), cells, {}, data
