"""Malformed problems of W and q are refused with the row at fault."""

import numpy as np
import pytest
from rcr import _kernel


def arrays():
    """Three contacts; the first two are coupled."""
    return dict(row_start=[0, 2, 4, 5], column=[0, 1, 0, 1, 2],
                block=np.tile([1.0, 0, 0, 1], (5, 1)), free_velocity=np.zeros((3, 2)),
                friction=np.zeros(3), impulse=np.zeros((3, 2)))


def put(name, index, value):
    array = arrays()[name]
    array[index] = value
    return {name: array}


def rows(row_start, column):
    return dict(row_start=row_start, column=column, block=np.ones((len(column), 4)))


@pytest.mark.parametrize("changes, says", [
    (dict(column=[1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
    (dict(column=[0, 1, 0, 1, 3]), "row 2 of W: columns are out of range or order"),
    (dict(column=[-1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
    (rows([0, 2, 3, 4], [0, 1, 1, 2]), r"block \(0, 1\) of W has no mirror image"),
    (rows([0, 1, 3, 4], [0, 0, 1, 2]), r"block \(1, 0\) of W has no mirror image"),
    (rows([0, 3, 4, 6], [0, 1, 2, 1, 0, 2]), r"block \(0, 1\) of W has no mirror image"),
    (rows([0, 2, 3, 4], [0, 1, 0, 2]), "row 1 of W has no diagonal block"),
    (dict(row_start=[0, 4, 2, 5]), "the rows of W do not fit its 5 blocks"),
    (dict(row_start=[0, 2, 4, 4]), "the rows of W do not fit its 5 blocks"),
    (put("block", (3, 2), np.nan), r"block \(1, 1\) of W is not finite"),
    (put("block", (4, 0), -1), "W has a negative diagonal at contact 2"),
    (put("free_velocity", (1, 0), np.inf), "contact 1: q or the impulse is not finite"),
    (put("impulse", (2, 1), np.nan), "contact 2: q or the impulse is not finite"),
    (put("friction", 1, -0.5), "contact 1: µ = -0.5; expected µ ≥ 0"),
    (put("friction", 0, np.inf), "contact 0: µ = inf; expected µ ≥ 0"),
    (dict(solver="newton"), "solver 'newton' is not known"),
    (dict(column=[0, 1, 0, 1, 2.5]), "column holds float64"),
    (dict(row_start=[0, 2, 4, 2**32 + 5]), "row_start holds 4294967301"),
])
def test_refuses(changes, says):
    _kernel.solve_delassus(**arrays())
    with pytest.raises(ValueError, match=says):
        _kernel.solve_delassus(**arrays() | changes)
