"""Papers with which reports compare measurements: each module of this folder defines a `PAPER`."""

import importlib
import pkgutil

DEFAULT = "azema_radjai_2011"


def names():
    """Return the names of all papers."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def load(name=DEFAULT):
    """Return the `rcr.study.paper.Paper` of a name."""
    return importlib.import_module(f"{__name__}.{name}").PAPER
