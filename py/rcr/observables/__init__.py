"""Observables of the reports: each module of this folder registers some. Needs NumPy, not YADE.

A module defines functions of the contacts and calls `registry.register` for each observable; see
docs/extending.md. Every module of the folder is imported.
"""

import importlib
import pkgutil

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
