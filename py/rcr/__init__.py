"""Rounded-cap-rectangle (RCR) grains and nonsmooth Contact Dynamics for YADE.

In a YADE session ``import rcr`` loads the plugin and adds its classes (``rcr.Rcr``,
``rcr.ContactDynamics``, …) and functions that make scenes. Without YADE, ``rcr.Network`` analyses
contact networks and ``rcr.solve`` solves contact problems from files.

Pictures (``rcr.snapshot``, ``rcr.movie``, ``rcr.plot``), files for ParaView (``rcr.export``) and
measures (``rcr.measure``) take the present scene or a saved network. ``from rcr import *`` omits
names that YADE itself has, such as ``rcr.wall``.
"""

import importlib
import os
import re
import sys

from rcr._info import info
from rcr.network import Network
from rcr.problems import solve

__version__ = "0.1.0"

_MODULES = ("export", "measure", "plot", "script")  # imported at first use, because they are slow
_LAZY = dict(snapshot="plot", movie="_pictures.movie", Profile="profile")  # name: its module
_SCENE = dict.fromkeys(  # functions of a YADE session: their modules
    ("clump", "disc", "mobile_wall", "particle", "segment", "wall"), "scene")
_SCENE |= dict.fromkeys(("elongated_hexagon", "from_outline", "polygon", "regular_polygon",
                         "truncated_triangle"), "polygons")
_SCENE |= dict(advance="_yade.advance", contact_network="_yade.scene_network",
               critical_time_step="_yade.time_step", half_step_start="_yade.time_step")
_CLASSES = re.compile(
    "(Bo1|Gl1|Ig2|Ip2|Law2)_.*|Rcr(Geom|FrictPhys)?|RoundedPolygon|(Capillary)?CdPhys|"
    "ContactDynamics|(Cell|Wall)Stress")


def __getattr__(name):
    if name in _MODULES:
        return importlib.import_module(f"rcr.{name}")
    if name in _LAZY:
        return getattr(importlib.import_module(f"rcr.{_LAZY[name]}"), name)
    if "_classes" not in globals() and (name in _SCENE or _CLASSES.fullmatch(name)):
        raise AttributeError(
            f"rcr.{name} needs a YADE session: run the script by yade (in a clone: "
            "scripts/yade-rcr), or import yade before rcr"
        )
    raise AttributeError(f"module 'rcr' has no attribute {name!r}")


__all__ = ["Network", "info", "solve", *_MODULES, *_LAZY]


def _load_plugin():
    """Register the plugin's classes with the running YADE and return them by name."""
    flags = sys.getdlopenflags()
    # YADE finds the classes of plugins by symbols. Lazy: see _plugin in CMakeLists.txt.
    sys.setdlopenflags(os.RTLD_LAZY | os.RTLD_GLOBAL)
    try:
        plugin = importlib.import_module("rcr._plugin")
    except ModuleNotFoundError as error:
        raise ImportError(
            f"rcr in {os.path.dirname(__file__)} has no plugin for YADE, only the analysis; run "
            "scripts/yade-rcr, which builds it and starts YADE with it, or install the plugin, see "
            "docs/installation.md. Without YADE, in plain python3, `import rcr` works."
        ) from error
    finally:
        sys.setdlopenflags(flags)
    if plugin.version_error:
        raise ImportError(plugin.version_error)
    import yade.wrapper

    return {name: getattr(yade.wrapper, name) for name in plugin.classes}


def _names_of_yade():
    """Return the names that YADE gives to scripts or that ``from yade import …`` can import."""
    import pkgutil

    import yade
    from yade import pack, utils

    modules = (module.name for module in pkgutil.iter_modules(yade.__path__))
    return {*dir(yade), *dir(utils), *dir(pack), *modules}


if "yade" in sys.modules:
    _classes = _load_plugin()
    globals().update(_classes)
    for _name, _module in _SCENE.items():
        globals()[_name] = getattr(importlib.import_module(f"rcr.{_module}"), _name)
    from rcr._yade import counterparts as _counterparts, session as _session
    from rcr._yade.last_problem import save_problem

    _classes["ContactDynamics"].save = save_problem
    _counterparts.install()
    _session.guard()
    _session.refuse_unknown_attributes({*_classes.values()})

    __all__ += [*sorted(_classes), *_SCENE]
    __all__ = [name for name in __all__ if name not in _names_of_yade()]
