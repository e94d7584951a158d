"""Films of a run's saved networks or pictures."""

import pathlib
import re

import numpy as np

from rcr._data import checks
from rcr._data.files import PART, atomic_path
from rcr._pictures.drawing import resolution
from rcr._pictures.grain_colors import SCALES
from rcr.frame import Frame
from rcr.plot import packing


def movie(folder, path=None, fps=10, dpi=100, **options):
    """Make a film from the files in a folder; return its path.

    Parameters
    ----------
    folder : path
        Holds networks (``*.h5``), which are drawn in order of time with one scale of colours and
        forces, or pictures of `rcr.snapshot` (``*.png``), in order of name. The film shows all of them: empty
        the folder before another run. A ValueError reports neither kind, both kinds, or pictures of
        different sizes.
    path : path, optional
        ``.gif``, or ``.mp4`` and other formats, for which a ValueError says that ffmpeg is missing;
        by default ``movie.gif`` in the folder.
    fps : float
        Pictures per second, 0.01 to 100.
    dpi : float
        Pixels per inch, 1 to 10000; pictures of networks are up to 7 inches wide.
    **options
        Options of `rcr.plot.packing`, for networks alone.
    """
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from tqdm import tqdm

    expected = "0.01 to 100 pictures per second"
    fps, dpi = checks.number("fps", fps, expected, lambda v: 0.01 <= v <= 100), resolution(dpi)
    folder = pathlib.Path(folder)
    path = folder / "movie.gif" if path is None else pathlib.Path(path)
    kind = PillowWriter if path.suffix == ".gif" else FFMpegWriter
    if not kind.isAvailable():
        needed = "this format needs ffmpeg, which is not installed"
        raise ValueError(f"{path}: {needed}; give a name that ends in .gif")
    networks, pictures = _files(folder, options)
    figure, draw, shots = _networks(networks, options) if networks else _pictures(pictures, dpi)
    writer = kind(fps=fps)
    with atomic_path(path) as partial:
        writer.setup(figure, partial, dpi)
        for shot in tqdm(shots, desc=path.name, unit="picture", delay=5, disable=None):
            draw(shot)
            writer.grab_frame()
        writer.finish()
    return path


def _files(folder, options):
    """Return the networks and the pictures of a folder; one of the lists is empty.

    A ValueError reports neither, both, or options for pictures.
    """
    networks, pictures = (
        sorted((path for path in folder.glob(f"*{suffix}") if not path.name.startswith(PART)),
               key=_natural_order) for suffix in (".h5", ".png"))
    if not networks and not pictures:
        expected = "*.h5 (Network.save) or *.png (rcr.snapshot)"
        raise ValueError(f"{folder} holds no pictures and no networks; expected {expected}")
    if networks and pictures:
        given = f"networks ({networks[0].name}) and pictures ({pictures[0].name})"
        todo = "expected one kind: move the other kind to another folder"
        raise ValueError(f"{folder} holds {given}; {todo}")
    if pictures and options:
        given = f"{folder} holds pictures, but {' and '.join(options)} need networks (*.h5)"
        raise ValueError(f"{given}; expected no options here: give them to rcr.snapshot")
    return networks, pictures


def _natural_order(path):
    """Sort key that puts 9.png before 10.png."""
    parts = re.split(r"(\d+)", path.name)
    return [int(part) if part.isdigit() else part for part in parts]


def _networks(paths, options):
    """Return a figure, a function that draws a Frame into it, and the Frames in order of time."""
    frames = [Frame.of(path) for path in paths]
    frames.sort(key=lambda frame: np.nan_to_num(frame.time))
    limits = options.pop("limits", None)
    if limits is None:
        corners = np.array([frame.extent() for frame in frames])
        limits = np.stack([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])
    color = options.get("color", "orientation")
    scale = SCALES.get(color) if isinstance(color, str) else None
    if scale is not None and scale.range is None and options.get("range") is None:
        values = np.concatenate([scale.values(frame) for frame in frames])
        options["range"] = (values.min(), values.max())
    forces = np.concatenate([frame.normal_force() for frame in frames])
    if options.get("reference_force") is None and (forces > 0).any():
        options["reference_force"] = forces[forces > 0].mean()
    figure = packing(frames[0], limits=limits, **options).figure

    def draw(frame):
        ax = figure.axes[0]
        ax.clear()
        packing(frame, ax=ax, limits=limits, **options | dict(legend=False))

    return figure, draw, frames


def _pictures(paths, dpi):
    """Return a figure of the pictures' size, a function that draws a picture, and the paths."""
    from PIL import Image
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    sizes = []
    for path in paths:
        with Image.open(path) as picture:
            sizes.append(picture.size)
    width, height = sizes[0]
    for path, size in zip(paths, sizes):
        if size != sizes[0]:
            raise ValueError(
                f"{paths[0].name} has {width} × {height} pixels, {path.name} has {size[0]} × "
                f"{size[1]}; expected one size: give the same `limits` to each rcr.snapshot")
    figure = Figure(figsize=(width / dpi, height / dpi))
    ax = figure.add_axes((0, 0, 1, 1))

    def draw(path):
        ax.clear()
        ax.axis("off")
        ax.imshow(imread(path), aspect="auto", interpolation="none")

    return figure, draw, paths
