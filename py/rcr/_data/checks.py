"""Checks of arguments. A ValueError names the argument, its value and what is expected.

Needs NumPy.
"""

import numbers
import sys

import numpy as np


def error(name, value, expected):
    """Return the ValueError of an argument."""
    return ValueError(f"{name} = {value!r}; expected {expected}")


def number(name, value, expected="a finite number", valid=lambda v: True):
    """Return `value` as a float, if it is a finite real number and `valid(value)` holds."""
    if isinstance(value, np.floating):
        value = value.item()  # sys.float_info.max overflows in single precision
    real = isinstance(value, numbers.Real) and not isinstance(value, (bool, np.bool_))
    if not real or not abs(value) <= sys.float_info.max or not valid(float(value)):
        raise error(name, value, expected)
    return float(value)


def integer(name, value, expected="a whole number", valid=lambda v: True):
    """Return `value` as an int, if it is an integer of 64 bits and `valid(value)` holds."""
    whole = isinstance(value, numbers.Integral) and not isinstance(value, (bool, np.bool_))
    if not whole or not -(2**63) <= value < 2**63 or not valid(int(value)):
        raise error(name, value, expected)
    return int(value)


def choice(name, value, known):
    """Return `value`, if it is one of the words `known`."""
    if not isinstance(value, str) or value not in known:
        raise error(name, value, f"one of {', '.join(known)}")
    return value


def array(name, value, shape=None):
    """Return `value` as a contiguous array of finite doubles. None in `shape` is any length."""
    value = reals(name, value, shape)
    require(np.isfinite(value), name, value, "finite numbers")
    return value


def reals(name, value, shape=None):
    """Return `value` as a contiguous array of doubles, which may be infinite or NaN."""
    try:
        value = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} does not hold numbers in rows of one length") from None
    if value.dtype.kind not in "iuf" and value.size:
        kind = "complex ones" if value.dtype.kind == "c" else value.dtype
        raise ValueError(f"{name} does not hold numbers, but {kind}; expected real ones")
    fits = shape is None or len(value.shape) == len(shape) and all(
        wanted in (None, given) for wanted, given in zip(shape, value.shape))
    if not fits:
        given = str(tuple("any" if k is None else k for k in shape)).replace("'", "")
        raise ValueError(f"{name} has shape {value.shape}; expected {given}")
    return np.asarray(value, float, order="C")


def rectangle(name, value):
    """Return the lower left and the upper right corner of a rectangle as an array, (2, 2)."""
    corners = array(name, value, (2, 2))
    if not (corners[1] > corners[0]).all():
        raise error(name, value, "the lower left and the upper right corner [m], in this order")
    return corners


def ids(name, value, end, shape):
    """Return `value` as an array of integers of a shape, each from 0 to `end` − 1."""
    value, expected = array(name, value, shape), f"whole numbers from 0 to {end - 1}"
    require((value == np.floor(value)) & (value >= 0) & (value < end), name, value, expected)
    return value.astype(np.int32 if end <= 2**31 else np.int64)


def require(good, name, value, expected):
    """Raise a ValueError that names the first place at which `good` is False."""
    if np.all(good):
        return
    index = np.unravel_index(np.argmin(good), np.shape(good))
    place = ", ".join(map(str, index))
    raise ValueError(f"{name}[{place}] = {value[index]:g}; expected {expected}")
