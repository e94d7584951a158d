"""Values at the border of the package: ValueError with what was given and what is wanted. Needs NumPy."""

import math
import numbers

import numpy as np


def number(name, value, wanted="a finite number", fits=lambda v: True):
    """`value` as a float.

    Parameters
    ----------
    name : str
    value : object
    wanted : str
        In words.
    fits : callable
        Whether a finite float is in its range.

    Raises
    ------
    ValueError
        If it is no finite real number, or does not fit.
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real) or not _finite(value) or not fits(float(value)):
        raise ValueError(f"{name} = {value!r}; wanted {wanted}")
    return float(value)


def integer(name, value, wanted="a whole number", fits=lambda v: True):
    """`value` as an int of 64 bits; parameters and errors as of `number`."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Integral) or not -(2**63) <= value < 2**63 or not fits(int(value)):
        raise ValueError(f"{name} = {value!r}; wanted {wanted}")
    return int(value)


def flag(name, value):
    """`value` if it is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name} = {value!r}; wanted True or False")
    return bool(value)


def choice(name, value, known):
    """`value` if it is one of the words `known`."""
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} = {value!r}; wanted one of {', '.join(known)}")
    return value


def array(name, value, shape=None):
    """`value` in doubles, contiguous; None in `shape` is any length.

    Raises
    ------
    ValueError
        If it holds something else than real numbers, has another shape, or a number is not finite.
    """
    value = reals(name, value, shape)
    every(np.isfinite(value), name, value, "finite numbers")
    return value


def reals(name, value, shape=None):
    """The same, infinite ones and NaN too."""
    try:
        value = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} does not hold numbers in rows of one length") from None
    if value.dtype.kind not in "iuf" and value.size:
        raise ValueError(f"{name} does not hold numbers, but {'complex ones' if value.dtype.kind == 'c' else value.dtype}; wanted real ones")
    if shape is not None and (value.ndim != len(shape) or any(k is not None and k != n for k, n in zip(shape, value.shape))):
        given = str(tuple("any" if k is None else k for k in shape)).replace("'", "")
        raise ValueError(f"{name} has shape {value.shape}; wanted {given}")
    return np.asarray(value, float, order="C")


def ids(name, value, end):
    """`value` in integers; ValueError if one is not whole, negative or not below `end`."""
    value = np.asarray(value)
    if value.dtype.kind not in "iuf" and value.size:
        raise ValueError(f"{name} does not hold numbers, but {value.dtype}; wanted whole numbers from 0 to {end - 1}")
    every((value == np.floor(value)) & (value >= 0) & (value < end), name, value, f"whole numbers from 0 to {end - 1}")
    return value.astype(np.int32 if end <= 2**31 else np.int64)


def every(good, name, value, wanted):
    """ValueError that names the first place where `good` does not hold."""
    if np.all(good):
        return
    index = np.unravel_index(np.argmin(good), np.shape(good))
    raise ValueError(f"{name}[{', '.join(map(str, index))}] = {value[index]:g}; wanted {wanted}")


def _finite(value):
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond all floats
        return False
