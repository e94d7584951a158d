"""Rigid elongated grains for YADE: rounded-cap rectangles (RCR) and nonsmooth Contact Dynamics.

In a YADE session ``import rcr`` loads the plugin and adds its classes (``rcr.Rcr``, ``rcr.ContactDynamics``, …) and the
scene helpers. In any other Python the analysis, ``rcr.Network``, and the solver of problems from files, ``rcr.solve``, are there.
"""

import os
import sys

from rcr.network import Network
from rcr.problems import solve

__version__ = "0.1.0"
__all__ = ["Network", "solve"]


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
        from rcr import _plugin
    except ModuleNotFoundError as error:
        raise ImportError("the plugin of rcr is not built; run scripts/yade-rcr, which builds it and starts YADE with it") from error
    finally:
        sys.setdlopenflags(flags)
    import yade.wrapper

    return {name: getattr(yade.wrapper, name) for name in _plugin.classes}


if "yade" in sys.modules:
    _classes = _load_plugin()
    globals().update(_classes)
    from rcr import session
    from rcr.scene import clump, contact_network, critical_time_step, disc, mobile_wall, particle, save_problem, wall

    session.guard()

    _classes["ContactDynamics"].save = save_problem

    __all__ += [*sorted(_classes), "clump", "contact_network", "critical_time_step", "disc", "mobile_wall", "particle", "wall"]
