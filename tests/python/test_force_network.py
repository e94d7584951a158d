"""Networks of any scene: scripts/network.py, its files, and the measures of `rcr.force_network`."""

import json
import os
import pathlib
import re
import sys

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from rcr.force_network import analysis
from rcr.network import Network

from common import complaint, ended, refused
from synthetic import packing, write_run

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "network.py"
FIGURES = ["normal-forces", "tangential-forces", "directions", "fabric"]


def network_script(*arguments, code=0):
    """The script as this Python runs it; it must not look for another one."""
    return ended(sys.executable, SCRIPT, *arguments, code=code,
                 env=os.environ | {"YADE_RCR_WAY": "test"})


def bare(**options):
    """A network with nothing but grains and contacts: no attribute, and no µ."""
    made = packing(0.5, **options)
    contacts = made.contacts | dict(friction=np.full(len(made.contacts["body1"]), np.nan))
    return Network(made.particles, contacts, {})


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("heap")
    for k in (0, 1):
        bare(seed=k).save(folder / f"network-{k}.h5")
    return folder


@pytest.fixture(scope="module")
def written(files, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "new"
    return out, network_script(files, files / "network-0.h5", "--out", out).stdout


def test_networks_without_attributes_are_analysed(written, files):
    out, line = written
    assert line == f"{out}/report.html: 3 networks, 6000 contacts between grains\n"
    content = json.loads((out / "analysis.json").read_text())
    names = [files.name, "network-0"]
    assert list(content) == names
    pictures = [*FIGURES, *(f"{kind}-{name}" for name in names for kind in ("map", "chains"))]
    assert {path.name for path in out.iterdir()} == {"analysis.json", "report.html", "run.json"} | {
        f"{name}.{suffix}" for name in pictures for suffix in ("png", "pdf")}
    page = (out / "report.html").read_text()
    assert "Azéma" not in page and "statement" not in page and "η =" not in page
    assert len(re.findall("<img", page)) == len(pictures)


def test_measures_are_those_of_network(written, files):
    """One network: the methods of `Network`. Two: their contacts together."""
    content = json.loads((written[0] / "analysis.json").read_text())
    pooled, one = content.values()
    network = Network.load(files / "network-0.h5")
    assert one["weak_share"] == network.weak_share()
    assert [one["normal_force"][name] for name in network.exponents()._fields] == pytest.approx(
        list(network.exponents()))
    assert one["tangential_force"]["alpha"] == pytest.approx(network.exponents("tangential").alpha)
    assert [one[name][-1] for name in network.anisotropies()._fields] == pytest.approx(
        list(network.anisotropies()))
    assert one["q_over_p"][-1] == pytest.approx(network.shear_stress_ratio())
    assert np.array(one["fabric"]) == pytest.approx(network.fabric())
    assert (one["c_f_l"], one["c_f_lr"]) == pytest.approx((network.c_f_l(), network.c_f_lr()))
    assert one["directions"]["pdf"] == pytest.approx(list(network.polar_distributions().pdf))
    assert one["chains"]["share"] == pytest.approx(network.force_chains().share)
    assert one["friction_mobilization"] is None  # µ is unknown
    other = Network.load(files / "network-1.h5")
    assert pooled["weak_share"] == pytest.approx(
        np.mean([network.weak_share(), other.weak_share()]))
    assert pooled["contacts"] == 4000 and one["contacts"] == 2000


def test_numbers_of_the_table_are_readable(written):
    """Fits end with the first digit of their error; negative numbers have a minus sign."""
    out, _ = written
    page = (out / "report.html").read_text()
    cells = dict(re.findall(r"<tr><th>(.*?)</th><td>(.*?)</td>", page))
    one = next(iter(json.loads((out / "analysis.json").read_text()).values()))
    for name, key in ("α_n", "alpha"), ("β_n", "beta"):
        value, error = re.fullmatch(r"(−?\d\.\d+) ± (0\.0*[1-9])", cells[name]).groups()
        assert len(value.lstrip("−")) == len(error)
        fitted = one["normal_force"][key], one["normal_force"][f"{key}_error"]
        assert float(value.replace("−", "-")) == pytest.approx(fitted[0], abs=fitted[1])
    share = float(cells["C(f, ℓ)"].replace("−", "-"))
    assert share == pytest.approx(one["c_f_l"], rel=5e-3) and "-" not in cells["C(f, ℓ)"]
    assert re.fullmatch(r"[\d.]+, with [\d.]+ grains on average, \d+ at most", cells["chains"])


def test_what_is_unknown_is_said(written, tmp_path):
    page = (written[0] / "report.html").read_text()
    assert re.search(r"<th>I_M</th><td>unknown</td>", page)
    few = bare(particles_=10, contacts=5)
    few.contacts["force"] = 2.0 * few.contacts["normal"]  # equal forces without a tangential part
    few.save(tmp_path / "few.h5")
    network_script(tmp_path / "few.h5", "--out", tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<th>α_n</th><td>unknown</td>" in page
    assert not (tmp_path / "out" / "tangential-forces.png").exists()
    assert json.loads((tmp_path / "out" / "analysis.json").read_text())["few"][
        "tangential_force"] is None


def test_shear_tests_and_other_networks_do_not_mix(tmp_path):
    test, files = write_run(tmp_path / "test", 0.5, particles_=50, contacts=200), tmp_path / "heap"
    files.mkdir()
    for k in (0, 1):
        bare(particles_=50, contacts=100, seed=k).save(files / f"network-{k}.h5")
    line = complaint(network_script(test, files, "--out", tmp_path / "out", code=1))
    assert "strain, eta, friction, volume" in line and "--any-scene" in line
    done = network_script(test, files, "--any-scene", "--out", tmp_path / "out")
    assert "6 networks, 1000 contacts" in done.stdout
    line = complaint(network_script(files, "--from-strain", "0.1", "--out", tmp_path / "o", code=1))
    assert "--from-strain: expected shear tests" in line


def test_a_folder_of_a_biaxial_test_stays_one(tmp_path):
    """A network without an attribute in its folder is an error, not another kind of analysis."""
    folder = write_run(tmp_path / "test", 0.5, particles_=50, contacts=200)
    (folder / "run.json").write_text(json.dumps(dict(program="biaxial.py", run="x", parameters={})))
    bare(particles_=50, contacts=200).save(folder / "network-0.0100.h5")
    line = complaint(network_script(folder, "--out", tmp_path / "out", code=1))
    assert "network-0.0100.h5 is a network without the attribute strain" in line


def test_unusable_paths_are_refused(tmp_path):
    refused("is neither a file nor a folder", analysis.read, [tmp_path / "nothing"])
    refused(r"has no network-\*.h5", analysis.read, [tmp_path])
    loose = bare(contacts=5)
    loose.contacts = {name: column[:0] for name, column in loose.contacts.items()}
    loose.save(tmp_path / "network-0.h5")
    refused("network-0.h5 has no contact between grains", analysis.read, [tmp_path])


def test_sets_of_equal_names_are_kept_apart(tmp_path):
    for folder in "a", "b":
        (tmp_path / folder / "heap").mkdir(parents=True)
        bare(contacts=20).save(tmp_path / folder / "heap" / "network-0.h5")
    sets = analysis.read([tmp_path / "a" / "heap", tmp_path / "b" / "heap"])
    assert [one.name for one in sets] == ["heap", "heap (2)"]
