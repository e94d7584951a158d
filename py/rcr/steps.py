"""Time steps of grains in NumPy arrays, without YADE."""

from rcr._kernel import GrainSteps

__all__ = ["GrainSteps"]
