"""docs/generate/study.py copies an analysis and prints the numbers of its pages."""

import json
import re

import numpy as np
import pytest

pytest.importorskip("yade")
image = pytest.importorskip("PIL.Image")

from docs.generate import study, tables

SUMMARY = dict(eta=0, missed_fraction=1, missed_mean=0.9, residual_max=1e-4, mean_overlap=1e-4,
               max_overlap=1e-3, inertial_number_final=3e-5, wall_seconds=1800,
               peak_memory_bytes=2**30)


def test_publish_copies_figures_and_compresses_maps(tmp_path):
    analysis, target = tmp_path / "analysis", tmp_path / "study"
    analysis.mkdir()
    (target / "figures").mkdir(parents=True)
    (analysis / "analysis.json").write_text('{"O1": 1}')
    for name, size in ("O1", (640, 480)), ("O6-eta-0.7", (3200, 1000)), ("O99", (10, 10)):
        image.new("RGBA", size, "red").save(analysis / f"{name}.png")
    for name in "O1.png", "O6-eta-0.7.jpg":
        (target / "figures" / name).touch()
    study.publish(analysis, target)
    assert json.loads((target / "analysis.json").read_text()) == {"O1": 1}
    for name, size in ("O1.png", (640, 480)), ("O6-eta-0.7.jpg", (1600, 500)):
        with image.open(target / "figures" / name) as picture:
            assert picture.size == size


def test_numbers_are_those_of_the_analysis():
    analysis = tables.published("study")
    lines = dict(line.split(": ", 1) for line in study.numbers(analysis))
    read = lambda name: [float(number) for number in lines[name].split(", ")]
    fabric = analysis["O15"]["value"]
    assert read("sin φ") == pytest.approx(analysis["O1"]["value"]["sin_phi"], abs=5e-4)
    at_1 = list(np.round(fabric["xi"], 9)).index(1)
    assert read("a_c(1)") == pytest.approx(fabric["a_c"][:, at_1], abs=5e-4)
    lowest = float(re.match(r"\S+", lines["lowest a_c(ξ), discs"])[0])
    assert lowest == pytest.approx(np.nanmin(fabric["a_c"][0]), abs=5e-5)
    # a_c is the amplitude in 2θ of P(θ), whose bins flatten it a little
    assert read("amplitude of P(θ) in 2θ after the compaction") == pytest.approx(
        analysis["O2"]["value"]["a_c"], abs=2e-3)


def test_costs_are_those_of_the_runs():
    tests = [SUMMARY, SUMMARY | dict(wall_seconds=3600), SUMMARY | dict(wall_seconds=5400, eta=0.5)]
    lines = list(study.costs(tests))
    assert "wall time of a run [min]: 30 to 90" in lines
    assert lines[-2:] == ["shortest test of each η [min]: 30, 90", "their sum [h]: 2.00"]
