"""Films of a run's saved networks or pictures."""

import pathlib
import re

import numpy as np

from rcr._data.files import atomic_path
from rcr._pictures.grain_colors import SCALES
from rcr.frame import Frame
from rcr.plot import packing


def movie(folder, path=None, fps=10, dpi=100, **options):
    """Make a film from the files in a folder.

    Parameters
    ----------
    folder : path
        Holds networks (``*.h5``), which are drawn in order of time with one scale of colours, or
        pictures of `rcr.snapshot` (``*.png``), in order of name.
    path : path, optional
        ``.gif``, or ``.mp4`` and other formats if ffmpeg is installed; by default ``movie.gif`` in
        the folder.
    fps : float
        Pictures per second.
    dpi : float
        Pixels per inch; pictures of networks are up to 7 inches wide.
    **options
        Options of `rcr.plot.packing`, for networks.

    Returns
    -------
    pathlib.Path
        The film.

    Raises
    ------
    ValueError
        If the folder holds neither networks nor pictures, or the format needs ffmpeg.
    """
    folder = pathlib.Path(folder)
    path = folder / "movie.gif" if path is None else pathlib.Path(path)
    writer = _writer(path, fps)
    networks = list(folder.glob("*.h5"))
    pictures = sorted(folder.glob("*.png"), key=_natural_order)
    if networks:
        figure, shots = _film_networks(networks, options)
    elif pictures:
        figure, shots = _film_pictures(pictures, dpi)
    else:
        expected = "*.h5 (Network.save) or *.png (rcr.snapshot)"
        raise ValueError(f"{folder} holds no snapshots; expected {expected}")
    from tqdm import tqdm

    with atomic_path(path) as partial:
        writer.setup(figure, partial, dpi)
        for shot in tqdm(shots, desc=path.name, unit="picture", delay=5, disable=None):
            shot()
            writer.grab_frame()
        writer.finish()
    return path


def _natural_order(path):
    """Sort key that puts 9.png before 10.png."""
    parts = re.split(r"(\d+)", path.name)
    return [int(part) if part.isdigit() else part for part in parts]


def _writer(path, fps):
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if path.suffix == ".gif":
        return PillowWriter(fps=fps)
    if not FFMpegWriter.isAvailable():
        needed = "this format needs ffmpeg, which is not installed"
        raise ValueError(f"{path}: {needed}; give a name that ends in .gif")
    return FFMpegWriter(fps=fps)


def _film_networks(paths, options):
    """Return a figure, and one drawing function per network, with common limits and colours."""
    frames = [Frame.of(path) for path in sorted(paths, key=_natural_order)]
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
    figure = packing(frames[0], limits=limits, **options).figure

    def draw(frame):
        ax = figure.axes[0]
        ax.clear()
        packing(frame, ax=ax, limits=limits, **options | dict(legend=False))

    return figure, [lambda frame=frame: draw(frame) for frame in frames]


def _film_pictures(paths, dpi):
    """Return a figure of the size of the first picture, and one drawing function per picture."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    height, width = imread(paths[0]).shape[:2]
    figure = Figure(figsize=(width / dpi, height / dpi))
    ax = figure.add_axes((0, 0, 1, 1))

    def draw(path):
        ax.clear()
        ax.axis("off")
        ax.imshow(imread(path), aspect="auto", interpolation="none")

    return figure, [lambda path=path: draw(path) for path in paths]
