"""Warnings of YADE's functions for spheres in scenes with other grains.

Each names the function to use.
"""

import functools
import sys
import warnings

import yade.wrapper
from yade import export, utils
from yade.wrapper import Omega, Rcr, RoundedPolygon

from rcr._yade.scene_arrays import GRAINS

COUNTERPARTS = {  # function of rcr: functions of yade.utils and yade.export, and classes
    "rcr.particle (new grains)": ["growParticle", "growParticles"],
    "rcr.measure.porosity": ["porosity", "voxelPorosity", "voidratio2D"],
    "rcr.measure.areas": ["getSpheresVolume", "getSpheresVolume2D", "psd"],
    "rcr.measure.extent": ["aabbExtrema", "aabbDim"],
    "rcr.measure.stress_tensors": ["bodyStressTensors"],
    "rcr.measure.write_table": ["text", "textExt", "textClumps"],
    "rcr.contact_network(volume=…).stress()": ["getStress", "normalShearStressTensors"],
    "rcr.contact_network(volume=…).fabric()": ["fabricTensor"],
    "rcr.contact_network(volume=…).coordination()": ["avgNumInteractions"],
    "rcr.contact_network(volume=…).particles['mass']": ["getSpheresMass"],
    "rcr.Profile": [
        "getDepthProfiles", "getDepthProfiles_center", "getSlicedProfiles", "getStressProfile",
        "getStressProfile_contact",
    ],
    "rcr.critical_time_step (springs; rigid contacts have no such bound)": [
        "PWaveTimeStep", "RayleighWaveTimeStep",
    ],
    "ContactDynamics.deepestOverlap": ["maxOverlapRatio"],
    "rcr.export.vtk": ["VTKExporter"],
    "rcr.export.VtkSeries": ["VTKRecorder"],
}  # fmt: skip

_OTHER = {Rcr: "Rcrs", RoundedPolygon: "polygons"}  # grains that are no spheres


def install():
    """Add the warnings, also to names that the running script has already imported."""
    script = vars(sys.modules["__main__"])
    for counterpart, names in COUNTERPARTS.items():
        for name in names:
            holder = next((h for h in (utils, export) if hasattr(h, name)), yade.wrapper)
            original = getattr(holder, name, None)
            if original is None:
                continue  # this version of YADE lacks it
            if isinstance(original, type):
                original.__init__ = _warning(original.__init__, name, counterpart)
                continue
            warning = _warning(original, name, counterpart)
            setattr(holder, name, warning)
            if script.get(name) is original:
                script[name] = warning


def _warning(original, name, counterpart):
    """Return a function that warns in scenes with Rcrs or polygons and calls `original`."""
    if hasattr(original, "__wrapped__"):  # an earlier import has added the warning
        return original
    fault = "is written for spheres and wrong for the {} of this scene"
    fault_of = _fault_of_stress if name == "getStress" else lambda *_, **__: fault

    @functools.wraps(original)
    def wrapped(*arguments, **options):
        shapes = {type(body.shape) for body in Omega().bodies}
        if grains := [text for shape, text in _OTHER.items() if shape in shapes]:
            if found := fault_of(*arguments, **options).format(" and ".join(grains)):
                warnings.warn(f"rcr: {name} {found}; use {counterpart}", stacklevel=2)
        return original(*arguments, **options)

    return wrapped


def _fault_of_stress(volume=0):
    """Return what is wrong with YADE's getStress in this scene, '' if it is right.

    It multiplies each force by the vector between the positions of the two bodies. This vector is
    the branch vector of two free grains, but not of walls and of members of clumps.
    """
    O = Omega()
    for body in O.bodies:
        grain = isinstance(body.shape, GRAINS) and not body.isClumpMember
        if not grain or {"x", "y", "Z"}.issubset(body.state.blockedDOFs):
            return "is wrong for contacts with obstacles and members of clumps"
    if volume > 0:
        return ""
    if not O.periodic:
        return "without a volume takes that of the spheres"
    if O.cell.hSize[2, 2] != 1:
        return "without a volume divides by the depth of the cell along z"
    return ""
