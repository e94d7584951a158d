"""Versions, processor, threads and build of this installation."""

import importlib.metadata
import os
import platform
import shutil
import sys

LIBRARIES = ("numpy", "scipy", "matplotlib", "h5py", "meshio", "tqdm")


class Info(dict):
    """A dict that prints as a table."""

    def __str__(self):
        wide = max(map(len, self))
        return "\n".join(f"{name:{wide}}  {value}" for name, value in self.items())

    __repr__ = __str__


def info():
    """Return versions, processor, threads and build for a bug report: a dict that prints well.

    ``lanes`` is the number of contact points that one sweep treats at a time: 16 with AVX-512, 1 on
    x86 without AVX2 and FMA, else 8. ``threads`` is that of the running YADE, ``3D view`` lists the
    classes that draw in it.
    """
    import rcr

    try:
        from rcr import _kernel
    except ImportError:
        _kernel = None
    yade, plugin = sys.modules.get("yade"), sys.modules.get("rcr._plugin")
    view, threads = "not loaded", os.environ.get("OMP_NUM_THREADS", "as many as processors")
    if plugin:
        drawn = [name for name in plugin.classes if name.startswith("Gl1_")]
        view = ", ".join(drawn) or "left out: built without OpenGL"
    if yade:
        threads = sys.modules["yade.wrapper"].Omega().numThreads
    processors = f"{len(os.sched_getaffinity(0))} of {os.cpu_count()} processors"
    return Info({
        "rcr": rcr.__version__, "YADE": yade.config.version if yade else "not loaded",
        "plugin": f"for YADE {plugin.yade_version}" if plugin else "not loaded", "3D view": view,
        "build": _kernel.build if _kernel else "not built",
        "lanes": _kernel.lanes() if _kernel else "not built", "threads": threads,
        "processor": f"{_processor()}, {processors}", "system": platform.platform(),
        "Python": platform.python_version(), **{name: _library(name) for name in LIBRARIES},
        "ffmpeg": shutil.which("ffmpeg") or "not installed: films are GIFs"})


def _library(name):
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _processor():
    try:
        with open("/proc/cpuinfo") as file:
            lines = (line for line in file if line.startswith("model name"))
            return next(lines).split(":", 1)[1].strip()
    except (OSError, StopIteration):
        return platform.machine()
