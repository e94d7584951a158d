"""Every class, law and solver against the numbers that it gave before. What has changed on purpose is renewed: `renew.py` shows the differences."""

import json
import pathlib

import pytest

pytest.importorskip("yade", reason="the scenes need YADE")

import cases  # noqa: E402

REFERENCE = json.loads((pathlib.Path(__file__).parent / "reference.json").read_text())
# A run repeats to the last bit on one machine, for all threads and lanes. Another C library or
# compiler may round otherwise: grains moved by
# 10^-15 of their places (`renew.py --perturb`) change forces, which are of one step and of shocks
# that pass, by up to 5e-5, and all else by 1e-6.
FORCE, ELSE = 1e-3, 1e-5


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", cases.CASES)
def test_is_what_it_was(name):
    found = cases.CASES[name]()
    assert found.keys() == REFERENCE[name].keys()
    for quantity, value in found.items():
        assert value == pytest.approx(REFERENCE[name][quantity], rel=FORCE if quantity == "force"
                                      else ELSE, abs=1e-12), quantity


def test_every_case_has_a_reference():
    assert set(REFERENCE) == set(cases.CASES)
