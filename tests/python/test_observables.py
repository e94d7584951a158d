"""A further observable and a second paper: each is one entry, and no other file knows it."""

import json
import pathlib
import re

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from rcr import papers
from rcr.observables import registry
from rcr.study import analysis, report
from rcr.study.paper import AGREES, DIFFERS, Paper
from rcr.study.runs import Run

from common import refused
from synthetic import write_run

ROOT = pathlib.Path(__file__).parents[2]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    return [Run.read(write_run(folder / f"{eta}", eta, particles_=100, contacts=400))
            for eta in (0.0, 0.5)]


@pytest.fixture
def registered():
    before = dict(registry.OBSERVABLES)
    yield registry.register
    registry.OBSERVABLES.clear()
    registry.OBSERVABLES.update(before)


def other_paper():
    paper = Paper(about="Other.", statements=dict(O3="weak contacts are half"), maps={}, first=[],
                  averages=0.25)
    paper.claim("O3", "half of the contacts are weak", "within 0.01 at η = 0.5", etas=0.5)(
        lambda v: (abs(v["weak_fraction"] - 0.5) <= 0.01, f"{v['weak_fraction']:.2f}", ""))
    return paper


def test_the_observable_of_the_page_is_in_the_report(runs, registered, tmp_path):
    """Forces are a mixture of exponentials: (1 + 0.3 cos)² has the mean 1.045, so 1/2.09."""
    text = (ROOT / "docs" / "extending.md").read_text()
    (code,) = [code for code in re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
               if "register(" in code]
    assert len(code.splitlines()) <= 30
    exec(code, {})
    table = report.write(runs, tmp_path / "out", paper=other_paper())
    entry = json.loads((tmp_path / "out" / "analysis.json").read_text())["participation"]
    assert entry["value"]["participation"] == pytest.approx([0.5 / 1.045] * 2, abs=0.05)
    assert np.shape(entry["value"]["participation_error"]) == (2,) and entry["paper"] == ""
    (row,) = [row for row in table if row.observable == "participation"]
    assert row.verdict == AGREES and row == table[-1] != table[0]
    page = (tmp_path / "out" / "report.html").read_text()
    (figure,) = re.findall(r"<figure id='participation'>(.*?)</figure>", page)
    assert "<img" in figure and "Paper:" not in figure
    assert (tmp_path / "out" / "participation.pdf").exists()


def test_axes_are_bins_or_values(runs, registered):
    registered("pair", "Two shares.", lambda e, grids: dict(
        share=np.array([np.mean(e.fn < 1), np.mean(e.fn < 2)]),
        mean=np.ones(len(grids.theta) - 1)), dict(below=[1, 2], theta="theta"))
    value = analysis.analyse(runs)["pair"]["value"]
    assert value["below"].tolist() == [1, 2] and value["share"].shape == (2, 2)
    assert value["mean"].shape == (2, len(value["theta"]))
    refused("the observable pair exists; choose another", registered, "pair", "Again.")


def test_a_second_paper_is_a_report_of_its_own(runs, tmp_path):
    """It has its statements, and those observables alone that it or the sentences mention."""
    (row,) = report.write(runs, tmp_path / "out", paper=other_paper())
    assert row.observable == "O3" and row.verdict == DIFFERS
    found = json.loads((tmp_path / "out" / "analysis.json").read_text())
    assert list(found) == ["O3", "O1", "O15"] and found["O1"]["paper"] == ""
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Other." in page and "Azéma" not in page and "(paper:" not in page
    longer = Run.read(runs[0].folder, averages=0.25)
    assert min(network.attributes["strain"] for network in longer.networks) == 0.1
    assert papers.DEFAULT in papers.names()


def test_statements_about_missing_observables_are_left_out(runs):
    """As those of an older analysis.json."""
    found = analysis.analyse(runs)
    del found["O15"]
    left = {row.observable for row in papers.load().findings(found)}
    assert left == set(papers.load().statements) - {"O15"}
