"""Rigid elongated grains for YADE: rounded-cap rectangles (RCR) and nonsmooth Contact Dynamics.

In a YADE session ``import rcr`` loads the plugin and adds its classes (``rcr.Rcr``, ``rcr.ContactDynamics``, …) and the
scene helpers. In any other Python the analysis, ``rcr.Network``, and the solver of problems from files, ``rcr.solve``, are there.

Pictures (``rcr.snapshot``, ``rcr.movie``, ``rcr.plot``), files for ParaView (``rcr.export``) and measures (``rcr.measure``) take the present
scene or a saved network. ``from rcr import *`` leaves out names that YADE has itself, such as ``rcr.wall``.
"""

import importlib
import os
import re
import sys

from rcr._info import info
from rcr.network import Network
from rcr.problems import solve

__version__ = "0.1.0"

_MODULES = ("export", "measure", "plot", "script")  # loaded when they are used: the libraries that they need take time
_LAZY = dict(snapshot="plot", movie="plot", Profile="profile")  # name: its module
_SCENE = ("advance", "clump", "contact_network", "critical_time_step", "disc", "half_step_start", "mobile_wall", "particle", "segment", "wall")  # with the classes, those of a session
_CLASSES = re.compile("(Bo1|Gl1|Ig2|Ip2|Law2)_.*|Rcr|RcrGeom|RcrFrictPhys|CdPhys|ContactDynamics|CellStress|WallStress")


def __getattr__(name):
    if name in _MODULES:
        return importlib.import_module(f"rcr.{name}")
    if name in _LAZY:
        return getattr(importlib.import_module(f"rcr.{_LAZY[name]}"), name)
    if "_classes" not in globals() and (name in _SCENE or _CLASSES.fullmatch(name)):
        raise AttributeError(f"rcr.{name} needs a YADE session: run the script by yade (in a clone: scripts/yade-rcr), or import yade before rcr")
    raise AttributeError(f"module 'rcr' has no attribute {name!r}")


__all__ = ["Network", "info", "solve", *_MODULES, *_LAZY]


def _load_plugin():
    """Register the plugin's classes with the running YADE and return them by name.

    Raises
    ------
    ImportError
        If the plugin is not built, or was built for another version of YADE.
    """
    flags = sys.getdlopenflags()
    sys.setdlopenflags(flags | os.RTLD_GLOBAL)  # YADE finds classes of all plugins by their symbols
    try:
        _plugin = importlib.import_module("rcr._plugin")
    except ModuleNotFoundError as error:
        raise ImportError(
            f"rcr in {os.path.dirname(__file__)} has no plugin for YADE, only the analysis; "
            "run scripts/yade-rcr, which builds it and starts YADE with it, or install the plugin, see docs/installation.md. Without YADE, in plain python3, `import rcr` works."
        ) from error
    finally:
        sys.setdlopenflags(flags)
    import yade.wrapper

    return {name: getattr(yade.wrapper, name) for name in _plugin.classes}


def _names_of_yade():
    """Names that a script of YADE has without an import, or by ``from yade import …``."""
    import pkgutil

    import yade
    from yade import pack, utils

    return {*dir(yade), *dir(utils), *dir(pack), *(module.name for module in pkgutil.iter_modules(yade.__path__))}


if "yade" in sys.modules:
    _classes = _load_plugin()
    globals().update(_classes)
    from rcr import _counterparts as counterparts, _session as session
    from rcr._advance import advance
    from rcr.half_step import half_step_start
    from rcr.scene import clump, contact_network, critical_time_step, disc, mobile_wall, particle, save_problem, segment, wall

    _classes["ContactDynamics"].save = save_problem
    counterparts.install()
    session.guard()

    __all__ += [*sorted(_classes), *_SCENE]
    __all__ = [name for name in __all__ if name not in _names_of_yade()]
