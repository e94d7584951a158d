"""Functions of YADE that know spheres only: they warn where the scene holds Rcrs, and name what measures these."""

import functools
import sys
import warnings

import yade.wrapper
from yade import export, utils
from yade.wrapper import Omega, Rcr

COUNTERPARTS = {  # what to take: functions of yade.utils and yade.export, and classes, in its place
    "rcr.measure.porosity": ["porosity", "voxelPorosity", "voidratio2D"],
    "rcr.measure.areas": ["getSpheresVolume", "getSpheresVolume2D", "psd"],
    "rcr.measure.extent": ["aabbExtrema", "aabbDim"],
    "rcr.measure.stress_tensors": ["bodyStressTensors"],
    "rcr.measure.text": ["text", "textExt", "textClumps"],
    "rcr.contact_network(volume=…).stress()": ["getStress", "normalShearStressTensors"],
    "rcr.contact_network(volume=…).fabric()": ["fabricTensor"],
    "rcr.contact_network(volume=…).coordination()": ["avgNumInteractions"],
    "rcr.contact_network(volume=…).particles['mass']": ["getSpheresMass"],
    "rcr.Profile": ["getDepthProfiles", "getDepthProfiles_center", "getSlicedProfiles", "getStressProfile", "getStressProfile_contact"],
    "rcr.critical_time_step (springs; rigid contacts have no such bound)": ["PWaveTimeStep", "RayleighWaveTimeStep"],
    "ContactDynamics.deepestOverlap": ["maxOverlapRatio"],
    "rcr.export.vtk": ["VTKExporter"],
    "rcr.export.VtkSeries": ["VTKRecorder"],
}


def install():
    """Put the warnings in the place of the functions, also where the running script has imported them by their names."""
    script = vars(sys.modules["__main__"])
    for counterpart, names in COUNTERPARTS.items():
        for name in names:
            holder = next((holder for holder in (utils, export) if hasattr(holder, name)), yade.wrapper)
            original = getattr(holder, name)
            if isinstance(original, type):
                original.__init__ = _telling(original.__init__, name, counterpart)
                continue
            setattr(holder, name, _telling(original, name, counterpart))
            if script.get(name) is original:
                script[name] = getattr(holder, name)


def _telling(original, name, counterpart):
    if hasattr(original, "__wrapped__"):  # by an import of before
        return original

    @functools.wraps(original)
    def told(*arguments, **options):
        if any(isinstance(body.shape, Rcr) for body in Omega().bodies):
            warnings.warn(f"{name} is written for spheres and misjudges the Rcrs of this scene; take {counterpart}", stacklevel=2)
        return original(*arguments, **options)

    return told
