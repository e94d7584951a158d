"""Notes on the study: closures that are exact, variants with known answers, a page with its pictures."""

import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

matplotlib = pytest.importorskip("matplotlib")

from rcr import network
from rcr.network import SIDE_SIDE, Network
from rcr.study import notes
from rcr.study.ensemble import Ensemble
from rcr.study.runs import Run, by_elongation

import synthetic
from synthetic import packing, random_network, write_run

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "study_notes.py"


def test_products_and_correlations_close_the_half_sum():
    """κ q/p = half-sum + X to rounding for any network; X of a packing without correlations is that of the angular means alone."""
    for made in (random_network(), packing(0.5, contacts=50_000)):
        made.attributes.update(eta=0.5)
        e = Ensemble([made])
        xi = e.xi_networks()
        means, correlations = notes.products(e)
        assert 0.5 * sum(xi.anisotropies()) + means + correlations == pytest.approx(xi.pressure_factor() * xi.shear_stress_ratio(), abs=1e-12)
        assert means + correlations == pytest.approx(xi.cross_products(), abs=1e-12)
    # C = 50 000, standard deviations of force and branch of about 1.1 and 0.2: X of fluctuations is 0 ± 1.1 × 0.2/√(2 C)
    assert abs(correlations) < 4 * 1.1 * 0.2 / np.sqrt(100_000)


def test_a_side_contact_as_two_points_has_half_of_the_force():
    """Side-side contacts at ℓ_r = 0.5 of force 1.5, others at 0.75 and 1 of forces 1.25 and 1, on one line: C = −1; as points those of 0.75 at 0.5, twice."""
    kind = np.arange(1000) % 4  # 0 and 1 are side-side
    force, length = np.choose(kind, [1.5, 1.5, 1.25, 1.0]), np.choose(kind, [0.5, 0.5, 0.75, 1.0])
    made = packing(0.5, contacts=1000)
    n = made.contacts["normal"]
    columns = dict(type=np.where(kind < 2, SIDE_SIDE, 0), force=force[:, None] * n, branch=2 * length[:, None] * n)
    whole, points, without = notes.correlation_variants(Ensemble([Network(made.particles, made.contacts | columns, made.attributes)]))
    assert (whole, without) == pytest.approx((-1, -1), abs=1e-9)
    covariance = np.cov([0.5, 0.75, 1.0], [0.75, 1.25, 1.0], aweights=[1000, 250, 250])
    assert points == pytest.approx(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]), abs=1e-9) and points > 0.5


def test_a_power_law_has_one_exponent_whatever_the_range():
    """Density ∝ x^β up to 1.5: β at every upper end; one that bends from x^0 to x^−0.8 at 0.5 has less and less."""
    rng = np.random.default_rng(4)
    power = 1.5 * rng.uniform(size=400_000) ** (1 / 0.6)  # β = −0.4
    low, high = rng.uniform(0, 0.5, 100_000), (0.5**0.2 + (1.5**0.2 - 0.5**0.2) * rng.uniform(size=100_000)) ** 5
    straight, bent = notes.exponents_by_range([power, np.concatenate([low, high])])
    assert straight == pytest.approx(-0.4, abs=0.02)
    assert bent[3] == pytest.approx(0, abs=0.02) and (np.diff(bent[4:]) < 0).all()


def lying(**more):
    """A stadium whose side lies on the bottom, and contacts of the same grain with other walls: {wall: (position, normal)}."""
    places = dict(BOTTOM=((0, -1), (0, -1))) | more
    count = len(places)
    position, normal = np.array(list(places.values()), dtype=float).transpose(1, 0, 2)
    columns = dict(
        body1=np.zeros(count, int), body2=[getattr(network, name) for name in places], type=np.full(count, 3), normal=normal, branch=position,
        force=normal, position=position, points=[2] + [1] * (count - 1),
    )  # fmt: skip
    grains = synthetic.particles(1) | dict(R=np.full(1, 2.0), half_length=np.ones(1))
    return Network(grains, columns, {})


def test_neutral_modes_of_a_grain_between_walls():
    """A side on the ground lets a grain slide, a cap against the left wall holds it, one against the right wall slides with that."""
    assert notes.neutral_modes(lying()) == (1, 1, 0)
    assert notes.neutral_modes(lying(LEFT=((-2, 0), (-1, 0)))) == (0, 0, 0)
    assert notes.neutral_modes(lying(RIGHT=((2, 0), (1, 0)))) == (1, 1, pytest.approx(0))


def test_neutral_modes_count_a_constraint_once():
    """Two contacts that hold the same: no motion, and a contact more than degrees of freedom."""
    assert notes.neutral_modes(lying(LEFT=((-2, 0), (-1, 0)), OTHER=((-2, 0), (-1, 0))))[:2] == (0, -1)


def test_shares_of_the_length_anisotropy_add_up():
    made = packing(0.5, contacts=5000)
    made.attributes.update(eta=0.5)
    e, xi = Ensemble([made]), np.array([0.5, 1, 3])
    sides = np.arange(len(e)) % 3 == 0
    whole = notes.length_anisotropy(e, xi, np.ones(len(e), dtype=bool))
    assert notes.length_anisotropy(e, xi, sides) + notes.length_anisotropy(e, xi, ~sides) == pytest.approx(whole, abs=1e-12)
    assert whole[-1] == pytest.approx(2 * np.mean((e.ln / e.ln.mean() - 1) * np.cos(2 * e.theta) * (e.fn <= 3)), abs=1e-12)


def test_force_by_length_tells_types_apart():
    """Side-side contacts twice as strong, forces equal within a type: their means are 2 and 1 over that of all in every class."""
    made = packing(0.5, contacts=3000)
    n, sides = made.contacts["normal"], np.arange(3000) % 2 == 0
    columns = dict(type=np.where(sides, SIDE_SIDE, 0), force=np.where(sides, 2, 1)[:, None] * n, branch=np.linspace(1, 2, 3000)[:, None] * n)
    e = Ensemble([Network(made.particles, made.contacts | columns, made.attributes)])
    length = np.hypot(e.ln, e.lt)
    whole, of_sides, rest = notes.force_by_length(e, np.linspace(length.min(), length.max() * (1 + 1e-9), 5))
    assert whole == pytest.approx(1, abs=0.01) and of_sides == pytest.approx(4 / 3) and rest == pytest.approx(2 / 3)


def test_speed_of_the_free_wall():
    """W = A/(φ h): with φ = φ₀ (1 − ε)^k the speed over ε̇ W is 1 + k; with a constant packing fraction 1."""
    strain = np.linspace(0, 0.5, 501)
    for k in (0.0, 0.3):
        middle, speed = notes.wall_speed(dict(strain=strain, packing_fraction=0.8 * (1 - strain) ** k))
        assert speed == pytest.approx(1 + k, abs=1e-5) and len(middle) == 500


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Runs at two rates, as points of chart e are named."""
    folder, made = tmp_path_factory.mktemp("runs"), {}
    for rate, seed in (("1e-3", 1), ("1e-4", 2)):
        made[rate] = [write_run(folder / f"{eta}-1000-{rate}-0.4-300-1", eta, seed, particles_=100, contacts=600) for eta in (0.0, 0.5)]
        for run in made[rate]:
            rows = [f"{strain},1,2,{0.8 + 0.01 * (-1) ** k}" for k, strain in enumerate(np.linspace(0, 0.4, 101))]
            (run / "history.csv").write_text("\n".join(["strain,stress_x,stress_y,packing_fraction", *rows]) + "\n")
    return made


def test_page_has_a_picture_and_a_text_for_each_note(folders, tmp_path):
    command = [sys.executable, SCRIPT, *folders["1e-4"], "--against", *folders["1e-3"], "--out", tmp_path]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300, env=os.environ | {"YADE_RCR_WAY": "test"})
    assert run.returncode == 0, run.stderr
    page = (tmp_path / "study-notes.md").read_text()
    pictures = re.findall(r"\]\((.*?)\)", page)
    assert len(pictures) == len(notes._NOTES) == page.count("\n## ")
    assert all((tmp_path / picture).read_bytes().startswith(b"\x89PNG") for picture in pictures)
    assert "I = 0.0001" in page and "I = 0.001" in page and "nan" not in page


def test_notes_that_the_runs_cannot_tell_are_left_out(folders):
    groups = by_elongation([Run.read(folder) for folder in folders["1e-4"][1:]])
    assert [made.name for made in notes.notes(groups, {})] == [
        "half-sum", "force-and-length", "sides-once-or-twice", "neutral", "force-by-type", "length-peak", "longest-branches", "weak-fabric",
    ]  # fmt: skip
