"""Figures, maps, the report and scripts/network.py, on synthetic runs."""

import base64
import html
import json
import os
import pathlib
import re
import shutil
import sys

import numpy as np
import pytest

matplotlib = pytest.importorskip("matplotlib")  # the other tests of the analysis do without

from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from rcr import papers
from rcr._pictures import network_maps as maps
from rcr._pictures.curves import color, plot_xi
from rcr._pictures.polar import xi_color
from rcr.frame import Frame
from rcr.geometry import polygons
from rcr.observables.forces import plot_mobilization
from rcr.observables.packings import plot_strength
from rcr.observables.registry import OBSERVABLES
from rcr.study import analysis, criteria, report, report_text
from rcr.study.report import nearest
from rcr.study.runs import Run

from common import complaint, ended, refused
from synthetic import packing, polygon_areas, write_run

PAPER = papers.load()
STATEMENTS, MAPS = PAPER.statements, PAPER.maps
ETAS = (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
FIGURES = [key for key in PAPER.observables() if OBSERVABLES[key].figure]
SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "network.py"


def network_script(*arguments, code=0):
    """The script as this Python runs it; it must not look for another one."""
    return ended(sys.executable, SCRIPT, *arguments, code=code,
                 env=os.environ | {"YADE_RCR_WAY": "test"})


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    return [write_run(folder / f"{eta}", eta, particles_=100, contacts=400) for eta in (0.0, 0.5)]


@pytest.fixture(scope="module")
def result(folders):
    return analysis.analyse([Run.read(folder) for folder in folders])


@pytest.fixture(scope="module")
def written(folders, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "new"
    return out, network_script(*folders, "--out", out).stdout


@pytest.fixture
def out(written, tmp_path):
    return shutil.copytree(written[0], tmp_path / "out")


def assert_refused(says, *arguments):
    line = complaint(network_script(*arguments, code=1))
    assert line.startswith("network.py: ") and says in line


def test_script_writes_everything(written):
    out, line = written
    assert re.fullmatch(rf"{out}/report.html: \d+ of \d+ statements agree, \d+ do not, \d+ are not "
                        r"tested\n", line)
    content = json.loads((out / "analysis.json").read_text())
    assert list(content) == list(STATEMENTS)
    names = [*FIGURES, *(name.removesuffix(".png") for key in MAPS
                                 for name in content[key]["value"]["files"])]
    pictures = {f"{name}.{suffix}" for name in names for suffix in ("png", "pdf")}
    assert {path.name for path in out.iterdir()} == {
        "analysis.json", "report.html", "table.md", "run.json"} | pictures
    assert content["O2"]["value"]["files"] == ["O2-eta-0.png", "O2-eta-0.5.png"]
    assert set(STATEMENTS) <= {name.split("-")[0] for name in names}


def test_table_and_report_are_complete(written):
    """Rows have six columns, with escaped bars in cells; the report needs no other file."""
    rows = (written[0] / "table.md").read_text().splitlines()
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {7} and len(rows) > 40
    page = (written[0] / "report.html").read_text()
    sources = re.findall(r"""(?:src|href)=['"]([^'"]{1,30})""", page)
    paper = "https://arxiv.org/abs/"
    assert all(source.startswith(("data:image/", "#O", paper)) for source in sources)
    assert {f"id='{key}'" in page for key in STATEMENTS} == {True}
    image = re.search(r"data:image/png;base64,([^']+)", page).group(1)
    assert base64.b64decode(image).startswith(b"\x89PNG")


def test_text_of_the_first_figures_is_legible(written, result):
    """Columns have 270 CSS pixels at a width of 1280: legends of 7 pt take at least 10 of them."""
    first, _ = (written[0] / "report.html").read_text().split("<h2>Paper against measured</h2>")
    images = re.findall("alt='(.*?)' src='data:image/png;base64,([^']+)", first)
    widths = {key: int.from_bytes(base64.b64decode(image)[16:20], "big") for key, image in images}
    assert widths.keys() == {"O1", "O3", "O6", "O15"}
    assert all(270 * 7 / (width / 200 * 72) >= 10 for key, width in widths.items() if key != "O6")
    assert "a_c" not in first
    assert not report.draw("O3", result, PAPER, small=True).axes[0].child_axes  # no inset


def test_the_first_screen_says_what_was_done_and_what_came_out(written):
    """Five sentences and four figures stand before the table; untested statements are folded."""
    page = (written[0] / "report.html").read_text()
    first, rest = page.split("<h2>Paper against measured</h2>")
    sentences = [re.sub("<[^>]*>", "", s) for s in re.findall("<p class='lead'>(.*?)</p>", first)]
    assert len(sentences) == 5 and first.count("<img") == 4
    sheared, paper, outcome, certainty, critical = sentences
    assert sheared.startswith("For each elongation η = 0 and 0.5 (0 is a disc") and (
        "1 random packing (seed) of 100 grains" in sheared and "strains of 0.2 to 0.4" in sheared
        and "an unknown rate" in sheared)
    assert "Azéma and Radjaï, Force chains and contact network topology" in paper
    assert "0.30 at η = 0 and 0.45 at η = 0.5 (paper: 0.30 and 0.45)" in outcome
    assert re.search(r"standard error of sin φ is at most 0\.00\d", certainty)
    assert "fewer than 3 packings" in certainty and "fewer than 1000 grains" in certainty
    assert "critical state" in critical
    shown, folded = rest.split("<details>")
    assert "<td class='open'>not tested" not in shown
    folded, _ = folded.split("</details>")
    verdicts = re.findall("<td class='open'>([^<]*)</td>", folded)
    assert len(verdicts) == 18 and set(verdicts) == {"not tested"}
    assert folded.startswith("<summary>18 statements that are not tested")


def test_every_figure_has_a_caption_that_says_what_it_plots(written):
    page = (written[0] / "report.html").read_text()
    stated = {key for name in papers.names() for key in papers.load(name).statements}
    assert set(OBSERVABLES) == stated and set(PAPER.observables()) == set(STATEMENTS)
    for key, one in ((key, OBSERVABLES[key]) for key in STATEMENTS):
        assert re.search(rf"<b>{key}</b> {re.escape(html.escape(one.caption))}<br>", page), key


@pytest.mark.parametrize("rates, says", [
    ([1e-4, 1e-4], "at an inertial number of 0.0001 (slow; inertia matters from about 1e-3 on)."),
    ([2e-5, 1e-3], "at an inertial number of 2e-05 to 0.001 (inertia matters from about 1e-3 on)."),
    ([None, None], "at an unknown rate.")])
def test_the_rate_is_that_of_the_summaries(folders, result, rates, says):
    runs = [Run.read(folder) for folder in folders]
    for run, rate in zip(runs, rates):
        run.summary = dict(inertial_number=rate)
    assert report_text._sheared(runs, result).endswith(says)


def test_one_elongation_is_not_called_each(folders):
    runs = [Run.read(folders[-1])]
    value = dict(eta=[0.5], seeds=[1], particles=[300])
    first = report_text._sheared(runs, dict(O1=dict(value=value)))
    assert first.startswith("For the elongation η = 0.5, 1 random packing")


def with_approach(run, approach):
    run.record = dict(parameters=dict(approach=approach), run="x")
    return run


@pytest.mark.parametrize("from_strain, approach, drifts, states, says", [
    (0.2, 0.1, [(0.1, 0.05), (-0.1, 0.06)], ["reached", "reached"], "is reached at η = 0 and 0.5"),
    (0.2, 0.1, [(0.1, 0.05), (-0.13, 0.06)], ["reached", "moves"],
     "is not reached at η = 0.5, where the anisotropy a<sub>c</sub> of the contacts still changes, "
     "by −0.13 ± 0.06"),
    (0.1, 0.1, [(0, 0.1), (0, 0.1)], ["reached", "reached"], "is reached"),
    (0.09, 0.1, [(0, 0.1), (0, 0.1)], ["moves", "moves"],
     "is not claimed: the averages begin before the slow part of the test, which begins at a "
     "strain of 0.1"),
    (0.05, 0, [(0, 0.1), (0, 0.1)], ["reached", "reached"], "is reached"),
    (0.2, 0.1, [(np.nan, np.nan), (0.3, 0.1)], ["unknown", "moves"], "is unknown at η = 0"),
])
def test_the_critical_state_is_claimed_only_where_nothing_changes(
        folders, result, from_strain, approach, drifts, states, says):
    runs = [with_approach(Run.read(folder, from_strain=0.1), approach) for folder in folders]
    for run in runs:
        run.from_strain = from_strain
    change, error = np.transpose(drifts)
    value = dict(eta=np.array([0, 0.5]), a_c_drift=change, a_c_drift_error=error)
    given = result | dict(O15=dict(value=value))
    assert list(report_text.critical_states(runs, given).values()) == states
    assert says in report_text._critical(runs, given)


def test_unknown_errors_are_said_to_be_unknown(folders):
    """One network has none: no error of the table may be 0."""
    nan = np.nan
    assert criteria.format_largest([nan, nan]) == criteria.format_errors(nan) == "unknown"
    assert criteria.format_largest([nan, 0.02], "°") == "≤ 0.02°, some unknown"
    assert criteria.format_largest([0.01, 0.02]) == "≤ 0.02"
    runs = [Run.read(folder, from_strain=0.4) for folder in folders]
    for run in runs:
        run.history = None
    table = PAPER.findings(analysis.analyse(runs))
    errors = [row.error for row in table]
    assert not [error for error in errors if "≤ 0" in error and "≤ 0." not in error]
    assert sum("unknown" in error for error in errors) > 10


def contrast_on_white(tint):
    """Contrast ratio of WCAG 2.1 between a colour and white."""
    part = np.array(tint[:3])
    linear = np.where(part <= 0.03928, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return 1.05 / (linear @ [0.2126, 0.7152, 0.0722] + 0.05)


def test_lines_are_legible_on_white():
    """A ratio of 3, which WCAG asks of graphs; yellow has 1.1. Elongations remain distinct."""
    etas = [color(eta) for eta in ETAS]
    for tint in [*etas, color(0.9), *(xi_color(k, 4) for k in range(4))]:
        assert contrast_on_white(tint) >= 3
    distance = [np.linalg.norm(np.subtract(one, two)) for k, one in enumerate(etas)
                for two in etas[:k]]
    assert min(distance) > 0.08


def test_polar_diagrams_of_small_packings_have_wide_bins(folders, tmp_path):
    """400 contacts, 39 % of them below ξ = 0.5: 3 networks 472, at rest 400; 50 a bin."""
    few = analysis.analyse([Run.read(folders[1])])
    assert len(few["O14"]["value"]["theta"]) == len(few["O2"]["value"]["theta"]) == 8
    many = analysis.analyse([Run.read(write_run(tmp_path / "a", 0.5, contacts=6000))])
    assert len(many["O14"]["value"]["theta"]) == 36


def test_one_small_packing_makes_the_verdicts_grey(written):
    """Of discs, and of a second seed whose size the mean hides."""
    made = {(eta, count): Run(pathlib.Path(f"{eta}"), [packing(eta, particles_=count)], 0.0)
            for eta in (0.0, 0.5) for count in (999, 1000, 3000)}
    large, others = made[0.5, 3000], [made[0.0, 1000], made[0.5, 1000]]
    assert not report_text.has_small_packing([large, *others])
    for small in made[0.0, 999], made[0.5, 999]:
        assert report_text.has_small_packing([large, *others, small])
    page = (written[0] / "report.html").read_text()
    assert "fewer than 1000 grains" in page and not re.search("class='(yes|no)'", page)


def test_analysis_of_other_runs_is_refused(out, folders):
    """Maps of an elongation that is no longer there would stay."""
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    for arguments in ([folders[0]], [*folders, "--from-strain", "0.3"]):
        assert_refused("remove it with --overwrite", *arguments, "--out", out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_run_that_has_not_ended_is_told(out, folders, tmp_path):
    """The warning precedes the analysis; here the folder has another one, so nothing is written."""
    going = shutil.copytree(folders[0], tmp_path / "going")
    for parameters, end in ((dict(strain=0.7), ", its end at 0.7"), (dict(), "")):
        record = dict(program="biaxial.py", run="x", parameters=dict(eta=0.0, **parameters))
        (going / "run.json").write_text(json.dumps(record))
        says = f"the run in {going} is not complete: its last network is at a strain of 0.4000{end}"
        done = network_script(going, "--out", out, code=1)
        assert f"network.py: {says}\n" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
def test_analysis_of_other_runs_takes_the_place_of_one(out, folders):
    network_script(folders[0], "--out", out, "--overwrite")
    assert not (out / "O6-eta-0.5.png").exists() and (out / "O6-eta-0.png").exists()


def test_report_counts_missed_tolerances_and_has_the_cost_of_the_tests(folders):
    """Shares of 1 and 3 % of two seeds, errors of 0.2 and 0.4: (1 × 0.2 + 3 × 0.4)/4 = 0.35."""
    runs = [Run.read(folders[1]) for _ in range(2)]
    assert report_text.unconverged_steps(runs).startswith("No summary.json counts")
    assert report_text.cost(runs) == "No summary.json has the cost of its test."
    for run, share, mean, largest, minutes in zip(runs, (0.01, 0.03), (0.2, 0.4), (0.3, 0.9),
                                                  (2, 3)):
        run.summary = dict(missed_fraction=share, missed_mean=mean, missed_max=largest,
                           seed=minutes, wall_seconds=60.0 * minutes,
                           peak_memory_bytes=minutes * 2**29)
    expected = "η = 0.5: 2.0 %, with estimated errors of 0.35 in the mean, 0.9 at most."
    assert expected in report_text.unconverged_steps(runs)
    assert report_text.cost(runs) == (
        "The tests took 5.0 min of wall time in all (2.5 min for each of 2 seeds) and 3.0 min the "
        "longest one; their largest memory was 1.50 GiB.")
    runs[1].summary["seed"] = runs[0].summary["seed"]
    assert "in all and 3.0 min the longest" in report_text.cost(runs)


@pytest.mark.parametrize("name", ["wall_seconds", "missed_fraction", "aspect_ratio"])
def test_a_text_in_a_summary_is_refused_with_its_file_and_name(folders, tmp_path, name):
    folder = shutil.copytree(folders[0], tmp_path / "run")
    numbers = dict.fromkeys(("wall_seconds", "peak_memory_bytes", "missed_fraction", "missed_mean",
                             "missed_max", "aspect_ratio", "sample_inertia"), 1.0)
    (folder / "summary.json").write_text(json.dumps(numbers | {name: "much"}))
    refused(f"run/summary.json: {name} = 'much'; expected a", report.write, [Run.read(folder)],
            tmp_path / "out")
    assert not (tmp_path / "out").exists()


def mark_yielded(folder, strains, out):
    """A copy of a run whose records at these strains have two steps without a solution."""
    shutil.copytree(folder, out)
    header, *lines = (out / "history.csv").read_text().splitlines()
    rows = [f"{line},{2 if float(line.split(',')[0]) in strains else 0}" for line in lines]
    (out / "history.csv").write_text("\n".join([f"{header},yielded_steps", *rows]) + "\n")
    return out


def test_records_and_networks_with_yielded_steps_are_left_out(folders, tmp_path):
    """The critical state has 51 records and networks at strains of 0.2, 0.3 and 0.4."""
    folder = mark_yielded(folders[1], (0.1, 0.4), tmp_path / "marked")
    run, whole = Run.read(folder), Run.read(folder, include_yielded=True)
    assert [network.attributes["strain"] for network in run.networks] == [0.2, 0.3]
    assert len(whole.networks) == 3 and len(whole.history["strain"]) == 101
    assert len(run.history["strain"]) == 99 and len(run.critical_stresses()) == 50
    count = "η = 0.5: 2, in 1 of 51 records, with 1 network(s)"
    assert f"{count}. Their records and networks are left out" in report_text.yielded_steps([run])
    assert f"{count}. Their records and networks count" in report_text.yielded_steps([whole])
    assert report_text.yielded_steps([Run.read(folders[1])]).startswith("No history counts")
    every = mark_yielded(folders[1], (0.2, 0.3, 0.4), tmp_path / "every")
    refused("include them with --include-yielded", Run.read, every)


def test_script_refuses_yielded_records(folders, tmp_path):
    folder = mark_yielded(folders[1], (0.2, 0.3, 0.4), tmp_path / "marked")
    assert_refused("--include-yielded", folder, "--out", tmp_path / "new")


@pytest.mark.slow
def test_script_includes_yielded_records_on_demand(folders, tmp_path):
    folder, new = mark_yielded(folders[1], (0.2, 0.3, 0.4), tmp_path / "marked"), tmp_path / "new"
    network_script(folder, "--include-yielded", "--out", new)
    assert "in 3 of 51 records" in (new / "report.html").read_text()


@pytest.mark.parametrize("case", ["nothing", "empty", "broken", "mixed"])
def test_script_refuses_bad_input(case, folders, tmp_path):
    bad, new = tmp_path / "bad", tmp_path / "new"
    if case != "nothing":
        bad.mkdir()
    if case == "broken":
        (bad / "network-0.1.h5").write_text("no HDF5")
    if case == "mixed":
        packing(0.3, friction=0.2).save(bad / "network-0.1.h5")
    says = "friction = 0.2, 0.5" if case == "mixed" else str(bad)
    assert_refused(says, folders[0], bad, "--out", new)
    assert not new.exists()


def test_plots_draw_into_the_axes_given_and_read_the_file(result):
    """analysis.json has null where the arrays have NaN. An elongation has one colour."""
    ax = Figure().add_subplot()
    for plot, observable in (plot_strength, "O1"), (plot_mobilization, "O5"):
        assert plot(result[observable]["value"], ax) is ax
    again = json.loads(json.dumps(analysis.jsonable(result)))
    for observable in FIGURES:
        assert report.draw(observable, again, PAPER).findobj(Axes), observable
    ax = plot_xi(result["O15"]["value"], "a_c", "a_c", Figure().add_subplot())
    drawn = [to_hex(line.get_color()) for line in ax.lines if line.get_label().startswith(r"$\eta")]
    assert drawn == [to_hex(color(eta)) for eta in (0, 0.5)]
    assert nearest([0, 0.5, 0.7], (0.2, 0.7)) == [0, 0.7]
    assert nearest([0.5], (0, 0.4, 0.7)) == [0.5]


def test_maps_are_a_few_collections():
    """13 000 grains and 26 000 contacts in at most five artists."""
    network = packing(0.5, particles_=13_000, contacts=26_000)
    for plot in (maps.plot_packing, maps.plot_mobilization, maps.plot_nematic, maps.plot_types):
        assert len(plot(network).collections) <= 5


def test_maps_move_a_periodic_packing_into_its_cell():
    """YADE lets grains leave the cell."""
    network = packing(0.5, particles_=50, contacts=200)
    network.attributes["cell"] = np.diag([30.0, 30.0])
    places = lambda: [np.array([path.vertices.mean(axis=0) for path in collection.get_paths()])
                      for collection in maps.plot_types(network).collections]
    before = places()
    particles, contacts = network.particles, network.contacts
    for columns, name in (particles, "position"), (particles, "center"), (contacts, "position"):
        columns[name] = columns[name] + [60, -30]
    for moved, place in zip(places(), before):
        assert moved == pytest.approx(place)


def test_outlines_are_those_of_rounded_cap_rectangles():
    """Vertices have the distance R' from the core; area and extent are those of the shape."""
    p = packing(0.6, particles_=20).particles
    vertices = np.array(polygons(p, points=32)) - p["position"][:, None]
    axis = np.stack([np.cos(p["angle"]), np.sin(p["angle"])], axis=-1)
    along = np.einsum("nka,na->nk", vertices, axis)
    core = np.clip(along, -p["half_length"][:, None], p["half_length"][:, None])
    distance = np.linalg.norm(vertices - core[..., None] * axis[:, None], axis=-1)
    r, a = p["cap_radius"], p["half_length"]
    assert distance - r[:, None] == pytest.approx(np.zeros_like(distance), abs=1e-12)
    assert polygon_areas(vertices) == pytest.approx(np.pi * r**2 + 4 * r * a, rel=0.01)


def test_segments_join_the_right_grains():
    network, turned = (packing(0.5, particles_=50, contacts=100) for _ in range(2))
    turned.particles = {name: column[::-1] for name, column in turned.particles.items()}
    segments = Frame.of(network).segments()
    assert np.array_equal(Frame.of(turned).segments(), segments)
    assert np.array_equal(segments[:, 0], network.particles["position"][network.contacts["body1"]])
