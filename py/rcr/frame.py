"""Grains, contacts, obstacles and cell of a scene or a saved network. Needs NumPy.

Pictures, files for ParaView and measures start from `Frame.of`. `rcr.table` has the conventions.
"""

import os

import numpy as np

from rcr.network import Network
from rcr.table import KINDS, Table  # noqa: F401: part of this module's interface


class Frame(Table):
    """The `Table` of the present scene of YADE, or of these attributes.

    ``R``, ``center`` and ``shape`` of the grains have defaults: the sum of cap radius and half
    length, the position, and −1. ``adhesion`` and ``rolling_moment`` of the contacts are
    0 by default.
    """

    def __init__(self, grains, contacts, **attributes):
        radius = grains["half_length"] + grains["cap_radius"]
        shape = np.full(len(radius), -1)
        self.grains = dict(R=radius, center=grains["position"], shape=shape) | grains
        none = np.zeros(len(contacts["body1"]))
        self.contacts = dict(adhesion=none, rolling_moment=none) | contacts
        vars(self).update(attributes)

    @classmethod
    def of(cls, what=None):
        """Return the Frame of YADE's present scene (None), or a Frame, a Network or its file.

        None outside YADE raises a ValueError, another type a TypeError.
        """
        if what is None:
            return cls.of_scene()
        if isinstance(what, (str, os.PathLike)):
            what = Network.load(what)
        if isinstance(what, Table):
            return what
        expected = "None (the present scene of YADE), a Frame, a Network or the path of one"
        raise TypeError(f"{type(what).__name__} given; expected {expected}")

    @classmethod
    def of_scene(cls):
        """Return the Frame of YADE's present scene."""
        try:
            from rcr._yade import scene_arrays
        except ImportError as error:
            todo = "give a rcr.Network or the path of one"
            raise ValueError(f"no scene: this Python runs without YADE; {todo}") from error
        return cls(**scene_arrays.read())
