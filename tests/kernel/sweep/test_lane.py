"""Lanes: each operation is that of IEEE 754 at any width; records pass registers unchanged."""

import math

import numpy as np
import pytest
from rcr import _kernel

LANES = [1, 4, 8, 0]
SPECIAL = [0.0, -0.0, 1.0, -1.0, 1e-310, -1e-310, 1e300, -1e300, np.inf, -np.inf, np.nan, np.pi]


def fma(a, b, c):
    try:
        return math.fma(a, b, c)
    except (OverflowError, ValueError):  # the plain result is infinite or NaN, too
        with np.errstate(all="ignore"):
            return float(np.float64(a) * np.float64(b) + np.float64(c))


OPERATIONS = {
    "add": lambda a, b, c: a + b,
    "subtract": lambda a, b, c: a - b,
    "multiply": lambda a, b, c: a * b,
    "divide": lambda a, b, c: a / b,
    "add_product": lambda a, b, c: np.float64(fma(float(b), float(c), float(a))),
    "subtract_product": lambda a, b, c: np.float64(fma(-float(b), float(c), float(a))),
    "min": lambda a, b, c: a if a < b else b,
    "max": lambda a, b, c: a if a > b else b,
    "abs": lambda a, b, c: np.abs(a),
    "copy_sign": lambda a, b, c: np.copysign(a, b),
    "select": lambda a, b, c: b if a <= b else c,
    "zero_where": lambda a, b, c: np.float64(0) if a <= b else c,
}


def operands(seed):
    """Sixteen triples: ordinary numbers, some equal, some special."""
    rng = np.random.default_rng(seed)
    numbers = rng.normal(0, 1, (3, 16)) * 10.0 ** rng.integers(-8, 8, (3, 16))
    special = rng.random((3, 16)) < 0.4
    numbers[special] = rng.choice(SPECIAL, special.sum())
    same = rng.random(16) < 0.2
    numbers[1, same] = numbers[0, same]
    return numbers


def bits(values):
    """Bits as integers. All NaNs are equal: sign and payload depend on the processor."""
    values = np.where(np.isnan(values), np.nan, values)
    return values.view(np.int64)


@pytest.mark.skipif(not hasattr(math, "fma"), reason="Python 3.13 has the reference")
@pytest.mark.parametrize("lanes", LANES)
@pytest.mark.parametrize("operation", OPERATIONS)
def test_operation_on_every_number(operation, lanes):
    for seed in range(200):
        a, b, c = operands(seed)
        with np.errstate(all="ignore"):
            expected = np.array([OPERATIONS[operation](*triple) for triple in zip(a, b, c)])
        found = _kernel.apply_lanes(lanes, operation, a, b, c)
        wrong = bits(found) != bits(expected)
        assert not wrong.any(), (f"seed {seed}: {operation}{a[wrong], b[wrong], c[wrong]} = "
                                 f"{found[wrong]}, expected {expected[wrong]}")


def test_a_product_with_its_sum_is_rounded_once():
    """(1 + ε)(1 − ε) − 1 = −ε² vanishes if the product is rounded first."""
    e = 2.0**-30
    numbers = [np.full(16, number) for number in (-1.0, 1 + e, 1 - e)]
    for lanes in LANES:
        assert (_kernel.apply_lanes(lanes, "add_product", *numbers) == -(e**2)).all()


@pytest.mark.parametrize("lanes", LANES)
@pytest.mark.parametrize("whole", [True, False])
def test_records_move_unchanged(lanes, whole):
    size = 2 if whole else 1
    for seed in range(50):
        rng = np.random.default_rng(seed)
        records = rng.normal(0, 1, (100, 2))
        places = rng.permutation(100 // size) * size
        source, target = places[:16], places[16:32]
        expected = records.copy()
        for half in range(size):
            expected[target + half] = records[source + half]
        np.testing.assert_array_equal(_kernel.move_lanes(lanes, whole, records, source, target),
                                      expected, err_msg=f"seed {seed}")


def test_widths():
    """The width is the given one, or less if the processor has less; 8 lanes are two registers."""
    width = {lanes: _kernel.lane_width(lanes) for lanes in LANES}
    assert width[1] == 1 and width[4] in (1, 4) and width[8] in (1, 8, 16) and width[0] == width[8]
