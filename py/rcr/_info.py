"""Versions, processor, threads and build of this installation, for bug reports."""

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
    """Versions, processor, threads and build of this session.

    Returns
    -------
    dict
        Prints as a table. ``lanes`` are the contact points, in doubles, that the sweeps take at a time on this processor: 16 with AVX-512,
        1 on one of x86 without AVX2 and FMA, else 8. ``threads`` are those of the running YADE, ``3D view`` the classes that draw in it.
    """
    import rcr

    told = Info(rcr=rcr.__version__)
    told["YADE"] = _yade_version()
    told["plugin"], told["3D view"] = _plugin_facts()
    told |= _kernel_facts()
    told["threads"] = _threads()
    told["processor"] = f"{_processor()}, {len(os.sched_getaffinity(0))} of {os.cpu_count()} processors"
    told["system"] = platform.platform()
    told["Python"] = platform.python_version()
    told |= {name: _library(name) for name in LIBRARIES}
    told["ffmpeg"] = shutil.which("ffmpeg") or "not installed: films are GIFs"
    return told


def _library(name):
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _yade_version():
    return sys.modules["yade"].config.version if "yade" in sys.modules else "not loaded"


def _plugin_facts():
    """For which YADE the plugin was built, and its classes of the 3D view."""
    plugin = sys.modules.get("rcr._plugin")
    if plugin is None:
        return "not loaded", "not loaded"
    drawn = [name for name in plugin.classes if name.startswith("Gl1_")]
    return f"for YADE {plugin.yade_version}", ", ".join(drawn) or "left out: built without OpenGL"


def _kernel_facts():
    try:
        from rcr import _kernel
    except ImportError:
        return dict(build="not built", lanes="not built")
    return dict(build=_kernel.build, lanes=_kernel.lanes())


def _threads():
    if "yade" not in sys.modules:
        return os.environ.get("OMP_NUM_THREADS", "as many as processors")
    from yade.wrapper import Omega

    return Omega().numThreads


def _processor():
    try:
        with open("/proc/cpuinfo") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()
