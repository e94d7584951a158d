"""Files for ParaView: `vtk` of one moment, `VtkSeries` of a run. Needs NumPy and meshio; a scene needs YADE, a saved network does not.

========================  ==============================================================================================
``NAME-grains.vtu``       a polygon a grain, with its state as cell data
``NAME-contacts.vtu``     two lines a contact, from centre to contact to centre, with its forces as cell data; the normal
                          force is point data too, for the filter Tube
``NAME-obstacles.vtu``    boxes as polygons; facets, walls (as far as the grains reach) and the edge of a periodic cell as lines
``NAME.vtm``              all three of one moment;  ``NAME.pvd`` those of a series, by time
========================  ==============================================================================================

Grains of a periodic cell are brought inside it. Forces are N a metre of depth, stresses Pa, compression positive.
"""

import os
import pathlib
import xml.etree.ElementTree as xml

import numpy as np

from rcr._files import atomic_path
from rcr.frame import Frame
from rcr._outlines import polygons

KINDS = ("box", "facet", "wall", "cell")  # of obstacles, as the column `kind` counts them


def vtk(path, what=None):
    """Write grains, contacts and obstacles.

    Parameters
    ----------
    path : path
        ``NAME.vtm``, to be opened in ParaView; the three files that it names lie beside it.
    what : None, Frame, Network or path
        The present scene of YADE, or what `Frame.of` takes.

    Returns
    -------
    list of pathlib.Path
        The files of grains, contacts and obstacles. Each appears whole or not at all, the index last.

    Raises
    ------
    ValueError
        If the path ends in another suffix; ImportError if meshio is not installed.
    """
    path = pathlib.Path(path)
    if path.suffix != ".vtm":
        raise ValueError(f"{path}: wanted a name that ends in .vtm")
    files = _write(path.with_suffix(""), Frame.of(what))
    root = xml.Element("VTKFile", type="vtkMultiBlockDataSet", version="1.0")
    blocks = xml.SubElement(root, "vtkMultiBlockDataSet")
    for k, file in enumerate(files):
        xml.SubElement(blocks, "DataSet", index=str(k), name=file.stem.rsplit("-", 1)[1], file=file.name)
    _save(root, path)
    return files


class VtkSeries:
    """A time series for ParaView: each `save` adds the present moment and renews ``NAME.pvd``.

    The series is what its folder holds, so it goes on after ``O.save`` and ``O.load``, in the same session or another; moments that
    lie after the one that is saved, those of a run that was gone back on, leave the index. A PyRunner carries all it needs in its text:

    ``PyRunner(command="import rcr; rcr.export.VtkSeries('out').save()", iterPeriod=100)``

    Parameters
    ----------
    folder : path
        Made if it is not there.
    name : str
        First part of the files' names.
    """

    def __init__(self, folder, name="scene"):
        self.folder, self.name = os.fspath(folder), name

    @property
    def index(self):
        """``NAME.pvd``, to be opened in ParaView."""
        return pathlib.Path(self.folder) / f"{self.name}.pvd"

    def moments(self):
        """Time [s] and file of every part in the index, a list of (float, str).

        Raises
        ------
        ValueError
            If the index is no .pvd.
        """
        if not self.index.exists():
            return []
        try:
            return [(float(part.attrib["timestep"]), part.attrib["file"]) for part in xml.parse(self.index).iter("DataSet")]
        except (xml.ParseError, KeyError, ValueError) as error:
            raise ValueError(f"{self.index}: not a series of VtkSeries ({error}); remove it or take another name") from error

    def save(self, what=None):
        """Add a moment, by default that of YADE's present scene; returns the path of the index.

        Raises
        ------
        ValueError
            If the time of the moment is not known.
        """
        frame = Frame.of(what)
        if not np.isfinite(frame.time):
            raise ValueError("a network without the attribute `time` has no place in a series")
        os.makedirs(self.folder, exist_ok=True)
        before = [moment for moment in self.moments() if moment[0] < frame.time]
        number = len({time for time, _ in before})
        files = _write(pathlib.Path(self.folder) / f"{self.name}-{number:06d}", frame)
        root = xml.Element("VTKFile", type="Collection", version="0.1")
        collection = xml.SubElement(root, "Collection")
        for time, file in [*before, *((frame.time, file.name) for file in files)]:
            part = ("grains", "contacts", "obstacles").index(pathlib.Path(file).stem.rsplit("-", 1)[1])
            xml.SubElement(collection, "DataSet", timestep=repr(time), group="", part=str(part), file=file)
        _save(root, self.index)
        return self.index


def _save(root, path):
    xml.indent(root)
    with atomic_path(path) as partial:
        xml.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)


def _write(stem, frame):
    """The three files of a moment."""
    try:
        import meshio
    except ImportError as error:
        raise ImportError("files for ParaView need meshio (Debian: python3-meshio)") from error

    files = []
    for part, mesh in (("grains", _grain_mesh), ("contacts", _contact_mesh), ("obstacles", _obstacle_mesh)):
        files.append(stem.with_name(f"{stem.name}-{part}.vtu"))
        points, cells, *data = mesh(frame)
        with atomic_path(files[-1]) as partial:
            meshio.write(partial, meshio.Mesh(_space(points), cells, *data))
    return files


def _space(plane):
    """Vectors of the plane, or points, with z = 0."""
    plane = np.asarray(plane, float).reshape(-1, 2)
    return np.column_stack([plane, np.zeros(len(plane))])


def _grain_mesh(frame):
    grains = frame.grains
    outline = polygons(grains | dict(position=grains["position"] + frame.wrap(grains["position"])))
    stress = frame.stress_tensors()
    normal = frame.normal_force()
    radius, velocity = frame.radius, grains["velocity"]
    state = {name: grains[name] for name in ("id", "clump", "angle", "half_length", "cap_radius", "mass", "color")}
    state |= dict(
        fixed=grains["fixed"].astype(int), kind=frame.kinds(), R=radius, eta=grains["half_length"] / radius, area=frame.areas(),
        velocity=_space(velocity[:, :2]), speed=np.hypot(velocity[:, 0], velocity[:, 1]), spin=velocity[:, 2], load=frame.per_grain(normal),
        contacts=frame.per_grain((normal > 0).astype(float)).astype(int), pressure=0.5 * (stress[:, 0, 0] + stress[:, 1, 1]),
        stress=stress.reshape(-1, 4),
    )  # fmt: skip
    corners = np.arange(outline.shape[0] * outline.shape[1]).reshape(outline.shape[:2])
    return outline, [("polygon", corners)], {}, {name: [column] for name, column in state.items()}


def _contact_mesh(frame):
    contacts = frame.contacts
    count = len(contacts["body1"])
    lines = frame.segments() + frame.wrap(contacts["position"])[:, None]
    normal = frame.normal_force()
    state = {name: contacts[name] for name in ("body1", "body2", "type", "points", "friction")}
    state |= dict(normal_force=normal, shear_force=_across(contacts), mobilization=frame.mobilization(), force=_space(contacts["force"]), normal=_space(contacts["normal"]))
    first = 3 * np.arange(count)
    cells = np.stack([[first, first + 1], [first + 1, first + 2]]).transpose(2, 0, 1).reshape(-1, 2)
    return lines, [("line", cells)], dict(normal_force=np.repeat(normal, 3)), {name: [np.repeat(column, 2, axis=0)] for name, column in state.items()}


def _across(contacts):
    """f_t along the normal turned by +90°, (C,) [N/m]."""
    (nx, ny), (fx, fy) = contacts["normal"].T, contacts["force"].T
    return nx * fy - ny * fx


def _obstacle_mesh(frame):
    """Cells in the order of lines and quadrangles, each with the id (−1 for the cell) and the index in `KINDS` of its obstacle."""
    low, high = frame.extent()
    lines = [(id_, "facet", ends) for id_, kind, ends in frame.outlines if kind == "facet"]
    for id_, axis, at in zip(*(frame.walls[name] for name in ("id", "axis", "position"))):
        ends = np.stack([low, high])
        ends[:, axis] = at
        lines.append((id_, "wall", ends))
    if frame.cell is not None:
        corners = (frame.cell @ np.array([[0, 1, 1, 0, 0], [0, 0, 1, 1, 0]])).T
        lines += [(-1, "cell", corners[k : k + 2]) for k in range(4)]
    boxes = [(id_, "box", corners) for id_, kind, corners in frame.outlines if kind == "box"]
    points, cells, data, start = [np.empty((0, 2))], [], dict(id=[], kind=[]), 0
    for shape, rows, corners in (("line", lines, 2), ("quad", boxes, 4)):
        if shape == "quad" and not rows:
            continue  # but a file has at least one kind of cells, or VTK refuses it
        points += [vertices for _, _, vertices in rows]
        cells.append((shape, start + np.arange(corners * len(rows)).reshape(-1, corners)))
        data["id"].append(np.array([id_ for id_, _, _ in rows], dtype=int))
        data["kind"].append(np.array([KINDS.index(kind) for _, kind, _ in rows], dtype=int))
        start += corners * len(rows)
    return np.concatenate(points), cells, {}, data
