"""Every class, law and solver against the numbers that it gave before. What has changed on purpose is renewed: `renew.py` shows the differences."""

import json
import pathlib

import pytest

pytest.importorskip("yade", reason="the scenes need YADE")

import cases  # noqa: E402

REFERENCE = json.loads((pathlib.Path(__file__).parent / "reference.json").read_text())
# A run repeats to the last bit on one machine, for all threads and lanes. Another C library or compiler may round otherwise; a perturbation of
# one part in 10^15 of the places grows to less than 1e-7 of these numbers (`renew.py --perturb` prints it).
TOLERANCE = 1e-6


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", cases.CASES)
def test_is_what_it_was(name):
    assert cases.CASES[name]() == pytest.approx(REFERENCE[name], rel=TOLERANCE, abs=1e-12), name


def test_every_case_has_a_reference():
    assert set(REFERENCE) == set(cases.CASES)
