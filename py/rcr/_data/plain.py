"""Results as Python numbers, which print without the names of NumPy's types. Needs NumPy."""

import numpy as np


def plain(result):
    """Return a number of NumPy, or an array without axes, as one of Python; others as they are.

    Numbers in dicts and tuples count too.
    """
    if isinstance(result, dict):
        return {name: plain(part) for name, part in result.items()}
    if isinstance(result, tuple):
        parts = map(plain, result)
        return type(result)._make(parts) if hasattr(result, "_make") else tuple(parts)
    scalar = isinstance(result, (np.generic, np.ndarray)) and np.ndim(result) == 0
    return result.item() if scalar and result.dtype.kind in "biufc" else result
