"""Attributes of a contact network: which values are numbers, and what a file can hold.

Needs NumPy.
"""

import math

import numpy as np

from rcr._data import checks
from rcr._data.plain import plain

LARGEST = 64000  # bytes of an attribute; HDF5 allows 64 kB with its description
_FINITE = "a finite number", math.isfinite
_NUMBERS = dict(  # attribute: expected value, condition
    volume=("the area of the region > 0 [m²]", lambda v: v > 0),
    eta=("an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1),
    friction=("a finite coefficient ≥ 0", lambda v: 0 <= v < math.inf),
    strain=_FINITE, time=_FINITE, dt=_FINITE)


def checked(attributes):
    """Return the attributes, with those of a scene as floats and arrays, after a check of each.

    A ValueError reports a value that a file cannot hold or that cannot be that of a scene.
    """
    found = dict(attributes)
    for name, value in found.items():
        if not isinstance(name, str) or not _is_text(name) or not name:
            raise ValueError(f"an attribute has the name {name!r}; expected a text")
        if name in _NUMBERS:
            found[name] = checks.number(f"the attribute {name}", value, *_NUMBERS[name])
        elif name in ("cell", "cell_velocity"):
            found[name] = checks.array(f"the attribute {name}", value, (2, 2))
        elif name == "stress":
            raise checks.error("the attribute stress", np.asarray(value).tolist(),
                               "another name; files hold Network.stress() under this one")
        elif not _is_storable(value):
            expected = "a number, a text, a list of texts or an array of numbers, below 64 kB"
            raise checks.error(f"the attribute {name}", value, expected)
        else:
            found[name] = plain(value)
    if "cell" in found and np.linalg.matrix_rank(found["cell"]) < 2:
        expected = "edges as columns that span an area [m²]; leave it out without a periodic cell"
        raise checks.error("the attribute cell", found["cell"].tolist(), expected)
    return found


def _is_storable(value):
    """Return whether an attribute of HDF5 can have this value."""
    texts = value if isinstance(value, (list, tuple)) else [value]
    if all(type(text) is str for text in texts):
        return all(map(_is_text, texts)) and sum(len(text.encode()) for text in texts) < LARGEST
    try:
        array = np.asarray(value)
    except ValueError:  # rows of several lengths
        return False
    if isinstance(value, bytes) and b"\0" in value or isinstance(value, np.ma.MaskedArray):
        return False
    known = array.dtype.kind in "biufcSV" or array.dtype.metadata is not None  # texts of h5py
    return known and array.nbytes < LARGEST


def _is_text(text):
    """Return whether a file can hold this text."""
    try:
        return b"\0" not in text.encode()
    except UnicodeEncodeError:  # half a character
        return False
