"""Functions of YADE that know spheres only: they warn where the scene holds Rcrs, and name what measures these."""

import functools
import sys
import warnings

from yade import export, utils
from yade.wrapper import Omega, Rcr, VTKRecorder

COUNTERPARTS = {
    utils: dict(porosity="rcr.measure.porosity", aabbExtrema="rcr.measure.extent", aabbDim="rcr.measure.extent", bodyStressTensors="rcr.measure.stress_tensors"),
    export: dict(text="rcr.measure.text"),
}


def _warn(name, counterpart):
    if any(isinstance(body.shape, Rcr) for body in Omega().bodies):
        warnings.warn(f"{name} knows spheres only and leaves the Rcrs of this scene out; {counterpart} takes them all", stacklevel=3)


def install():
    """Put the warnings in the place of the functions, also where the running script has imported them by their names."""
    script = vars(sys.modules["__main__"])
    for module, names in COUNTERPARTS.items():
        for name, counterpart in names.items():
            original = getattr(module, name)
            if hasattr(original, "__wrapped__"):  # done by an import of before
                continue
            told = _telling(original, name, counterpart)
            setattr(module, name, told)
            if script.get(name) is original:
                script[name] = told
    if not hasattr(VTKRecorder.__init__, "__wrapped__"):
        VTKRecorder.__init__ = _telling(VTKRecorder.__init__, "VTKRecorder", "rcr.export.VtkSeries")


def _telling(original, name, counterpart):
    @functools.wraps(original)
    def told(*arguments, **options):
        _warn(name, counterpart)
        return original(*arguments, **options)

    return told
