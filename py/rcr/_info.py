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

    In YADE, ``steps`` summarizes those of this session: time, missed steps and their largest error,
    deepest overlap. ``lanes`` is the number of contact points that one sweep treats at a time: 16
    with AVX-512, 1 on x86 without AVX2 and FMA, else 8. ``threads`` is that of the running YADE,
    ``3D view`` lists the classes that draw in it.
    """
    import rcr

    yade, plugin = sys.modules.get("yade"), sys.modules.get("rcr._plugin")
    facts = Info(rcr=rcr.__version__, YADE=yade.config.version if yade else "not loaded")
    facts["plugin"] = facts["3D view"] = "not loaded"
    if plugin:
        drawn = [name for name in plugin.classes if name.startswith("Gl1_")]
        facts["plugin"] = f"for YADE {plugin.yade_version}"
        facts["3D view"] = ", ".join(drawn) or "left out: built without OpenGL"
    try:
        from rcr import _kernel
    except ImportError:
        facts |= dict(build="not built", lanes="not built")
    else:
        facts |= dict(build=_kernel.build, lanes=_kernel.lane_width(0))
    facts["threads"] = os.environ.get("OMP_NUM_THREADS", "as many as processors")
    if yade:
        facts["threads"] = sys.modules["yade.wrapper"].Omega().numThreads
    if summary := sys.modules.get("rcr._yade.step_summary"):
        facts["steps"] = summary.text() or "none"
    count = f"{len(os.sched_getaffinity(0))} of {os.cpu_count()} processors"
    facts["processor"] = f"{_processor()}, {count}"
    facts["system"], facts["Python"] = platform.platform(), platform.python_version()
    facts |= {name: _library(name) for name in LIBRARIES}
    facts["ffmpeg"] = shutil.which("ffmpeg") or "not installed: films are GIFs"
    return facts


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
