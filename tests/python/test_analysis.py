"""The observables of synthetic runs with known distributions: values, errors and shapes."""

import json
import pathlib
import time

import numpy as np
import pytest
import scipy.integrate
from rcr import papers, statistics
from rcr.observables import forces, packings, registry, xi_networks
from rcr.study import analysis, paper as claims
from rcr.ensemble import Ensemble
from rcr.network import LEFT, RIGHT, Network
from rcr.study.runs import Run

from common import refused
from synthetic import packing, write_run

PAPER = papers.load()
CONTRACT = [  # observable, names of grids, names of arrays over elongation and these grids
    ("O1", "", "sin_phi sin_phi_std"), ("O3", "f_n", "pdf"), ("O4", "f_t", "pdf"),
    ("O3", "", "alpha_n beta_n weak_fraction"), ("O4", "", "alpha_t beta_t"),
    ("O5", "", "friction_mobilization"),
    ("O6", "strip", "strip_force"), ("O7", "f_n", "i_mf"), ("O8", "i_m", "pdf"),
    ("O10", "l_r", "pdf"), ("O12", "", "c_f_lr c_f_l"), ("O13", "l_r", "f_l_r"),
    ("O13", "l", "f_l"), ("O14", "xi theta", "pdf"), ("O15", "xi", "a_c"),
    ("O16", "xi", "a_ln a_lt"), ("O17", "xi", "a_fn a_ft"), ("O18", "xi", "q_over_p half_sum"),
]  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    return [Run.read(write_run(folder / f"{eta}-{seed}", eta, seed))
            for eta, seed in ((0.5, 1), (0.0, 1), (0.5, 2))]


@pytest.fixture(scope="module")
def result(runs):
    return analysis.analyse(runs)


@pytest.mark.parametrize("observable, grids, names", CONTRACT)
def test_arrays_have_the_shapes_of_the_contract(result, observable, grids, names):
    value = result[observable]["value"]
    assert value["eta"].tolist() == [0, 0.5]
    shape = (2, *(len(value[grid]) for grid in grids.split()))
    for name in names.split():
        assert value[name].shape == shape, name
        assert name == "sin_phi_std" or value[f"{name}_error"].shape == shape, name


def test_every_observable_is_there_with_a_reason_and_the_file_is_strict_json(result):
    assert list(result) == list(PAPER.statements) == [f"O{k}" for k in range(1, 19)]
    assert all(set(entry) == {"value", "paper", "unit"} and "eta" in entry["value"]
               for entry in result.values())
    again = json.loads(json.dumps(analysis.jsonable(result), allow_nan=False))
    assert again["O12"]["value"]["c_f_lr"][0] is None  # discs have no ℓ_r
    assert np.array_equal(again["O15"]["value"]["a_c"], result["O15"]["value"]["a_c"])
    table = PAPER.findings(result)
    assert {row.observable for row in table} == set(PAPER.statements)
    assert all(row.statement and row.criterion and row.value for row in table)
    assert {row.verdict for row in table} <= {claims.AGREES, claims.DIFFERS, claims.NOT_TESTED}


def strains_of(run):
    return [network.attributes["strain"] for network in run.networks]


def test_seeds_are_cumulated_and_only_the_critical_state_counts(result, runs):
    """Networks at strains of 0.1, 0.2, 0.3, 0.4: the critical state starts at 0.2."""
    assert [len(run.networks) for run in runs] == [3, 3, 3]
    value = result["O1"]["value"]
    assert value["seeds"].tolist() == [1, 2] and value["networks"].tolist() == [3, 6]
    assert value["contacts"].tolist() == [6000, 12000]
    assert value["sin_phi"] == pytest.approx([0.30, 0.45], abs=0.001)
    assert value["sin_phi_std"] == pytest.approx([0.01, 0.01], rel=0.01)
    assert strains_of(Run.read(runs[0].folder, from_strain=0.35)) == [0.4]
    earlier = Run.read(runs[0].folder, to_strain=0.3)  # from half of it on
    assert strains_of(earlier) == [0.2, 0.3]
    assert (earlier.is_critical(earlier.history["strain"]).sum()
            == len(earlier.critical_stresses()) < len(runs[0].critical_stresses()))


def test_known_distributions_are_recovered(result):
    """η = 0.5, 12 000 contacts, exponential forces about ⟨f_n⟩(θ): values within 4 errors.

    a_c = 0.2, a_fn = 0.3, a_ft = 0.1. A moment of C contacts has the error √(2/C) = 0.013, and √2
    times that with exponential forces. Forces are a mixture of exponentials of means 1 ± 0.3: α_n
    is within 0.1 of 1, the weak fraction within 0.02 of 1 − 1/e. The cross product a_c a_fn/2 in
    tr χ(∞) changes a_fn by up to 10 %.
    """
    values = {key: {name: np.asarray(array)[1] for name, array in entry["value"].items()
                    if len(np.shape(array)) and len(array) == 2}
              for key, entry in result.items()}
    errors = lambda variance: 4 * np.sqrt(variance / 12000)
    forces = {name: values["O17"][name][-1]
              for name in ("a_fn", "f_n_amplitude", "f_n_mean", "f_t_amplitude")}
    assert values["O15"]["a_c"][-1] == pytest.approx(0.2, abs=errors(2))
    assert forces["a_fn"] == pytest.approx(0.3, abs=errors(4) + 0.03)
    assert forces["f_n_amplitude"] / forces["f_n_mean"] == pytest.approx(0.3, abs=errors(4))
    assert forces["f_t_amplitude"] == pytest.approx(0.1, abs=errors(1))
    assert values["O14"]["amplitude"][-1] == pytest.approx(0.2, abs=errors(2))
    assert values["O14"]["theta_sigma"] == pytest.approx(np.pi / 2, abs=0.03)
    assert values["O3"]["alpha_n"] == pytest.approx(1, abs=0.1)
    # of e^{−x} on [0.01, 1] the fit finds the power law of the same mean logarithm
    x, integral = np.geomspace(0.01, 1, 10_001), scipy.integrate.trapezoid
    mean = integral(np.log(1 / x) * np.exp(-x), x) / integral(np.exp(-x), x) / np.log(100)
    beta_n = statistics._root_of_mean(mean) / np.log(100) - 1
    assert values["O3"]["beta_n"] == pytest.approx(beta_n, abs=0.1)
    assert values["O3"]["weak_fraction"] == pytest.approx(1 - np.exp(-1), abs=0.02)


def test_densities_and_networks_add_up(result):
    """Densities have the integral 1; the half-sum is q(∞)/p up to the cross products."""
    for key, width in ("O8", 0.05), ("O14", np.pi / 36), ("O10", 0.01):
        assert result[key]["value"]["pdf"].sum(axis=-1) * width == pytest.approx(1, abs=1e-9), key
    v = result["O18"]["value"]
    assert v["half_sum"] - v["q_over_p"] == pytest.approx(v["closure"], abs=1e-15)
    assert np.abs(v["closure"][:, -1]) == pytest.approx(0, abs=0.05)
    assert (v["q_over_p"][:, 0] == 0).all() and (v["q_over_p_error"][:, -1] > 0).all()


def test_standard_error_is_that_of_repeated_sampling():
    """a_c of S networks of C contacts has the error √(2/(S C)), estimated to 1/√(2 S) = 16 %."""
    networks = [packing(0.5, seed=k) for k in range(20)]
    ensemble, parts = Ensemble(networks), [Ensemble([network]) for network in networks]
    grids = registry.Grids.of([ensemble], 0.4)
    error = registry.measures(ensemble, grids, parts)["O15"]["a_c_error"][-1]
    assert error == pytest.approx(np.sqrt(2 / (20 * 2000)), rel=0.5)
    single = registry.measures(parts[0], grids, parts[:1])["O15"]
    assert np.isnan(single["a_c_error"]).all()  # of one network it is unknown
    error = statistics.standard_error([[1.0, np.nan], [3.0, np.nan], [np.nan, 5.0]])
    assert error[0] == pytest.approx(1) and np.isnan(error[1])  # without unknown values


def test_forces_in_strips_from_wall_to_wall():
    """Forces fall by half from the left wall, x = −5, to the right one, x = 25, where contacts with
    them mark the ends of the sample; other contacts are in [0, 30].
    """
    made = packing(0.5, contacts=20_000, a_fn=0, a_ft=0)
    columns = {name: column.copy() for name, column in made.contacts.items()}
    x = np.clip(columns["position"][:, 0], 0, 25)
    columns["position"][:, 0] = x
    columns["force"] *= (1 - 0.5 * (x + 5) / 30)[:, None]
    columns["body2"][:2], columns["type"][:2] = (LEFT, RIGHT), 3
    columns["position"][:2, 0] = -5, 25
    ensemble = Ensemble([Network(made.particles, columns, made.attributes)])
    grids = registry.Grids.of([ensemble], 0.4)
    found = forces.strip_forces(ensemble, grids)["strip_force"]
    inside, middle = x[2:], np.array([0, 0.3, 0.5, 0.7, 0.9])
    edges = -5 + 30 * grids.strip
    middle[0] = (inside[inside < edges[1]].mean() + 5) / 30
    mean = 1 - 0.5 * (inside.mean() + 5) / 30
    # exponential forces: an error of the mean of 1/√C
    assert found == pytest.approx((1 - 0.5 * middle) / mean, abs=4 / np.sqrt(20_000 / 6))
    few = Ensemble([packing(0.5, contacts=20)])
    assert np.isnan(forces.strip_forces(few, grids)["strip_force"]).any()


def test_drift_of_the_fabric():
    """a_c rises by 0.3 between strains of 0.2 and 0.5, in two seeds of different levels."""

    strains = np.linspace(0.2, 0.5, 7)

    def run(level, seed):
        networks = [packing(0.5, seed=100 * seed + k, strain=strain, a_c=level + strain, a_fn=0,
                            a_ft=0) for k, strain in enumerate(strains)]
        return Run(folder=None, networks=networks, from_strain=0.2)

    found = xi_networks.drift([run(0.0, 1), run(0.2, 2)], None, None)
    # √(2/C) of a moment, over the spread of the strains
    expected = 0.3 * np.sqrt(2 / 2000) / np.sqrt(14 * np.var(strains))
    assert found["a_c_drift_error"] == pytest.approx(expected, rel=0.5)
    assert found["a_c_drift"] == pytest.approx(0.3, abs=4 * found["a_c_drift_error"])
    seeds = [run(0.1 * k, k + 1) for k in range(3)]
    slopes = [xi_networks.drift([seed], None, None)["a_c_drift"] for seed in seeds]
    found = xi_networks.drift(seeds, None, None)
    assert found["a_c_drift"] == pytest.approx(np.mean(slopes))
    assert found["a_c_drift_error"] == pytest.approx(np.std(slopes, ddof=1) / np.sqrt(3))
    short = run(0.0, 1)
    short.networks = short.networks[:2]
    assert np.isnan(xi_networks.drift([short], None, None)["a_c_drift"])


def test_errors_are_over_seeds_where_there_are_three(tmp_path):
    """Seeds with a_c = 0.1, 0.2 and 0.3: three have the error 0.1/√3, two that of networks."""
    runs = [Run(tmp_path / str(k),
                [packing(0.5, seed=10 * k + j, a_c=0.1 * k, a_fn=0, a_ft=0, contacts=8000)
                 for j in range(4)], 0.2) for k in (1, 2, 3)]
    for count, expected in ((3, 0.1 / np.sqrt(3)),
                            (2, np.std([0.1] * 4 + [0.2] * 4, ddof=1) / np.sqrt(8))):
        value = analysis.analyse(runs[:count])["O15"]["value"]
        # moments of 8000 contacts: 0.016 each
        assert value["a_c_error"][0, -1] == pytest.approx(expected, rel=0.25)
        assert value["a_c"][0, -1] == pytest.approx(0.05 * (count + 1), abs=0.02)


def test_rotated_runs_are_analysed_alike():
    """Their directions change, and no anisotropy."""
    upright, tilted = (Ensemble([packing(0.5, axis=axis, contacts=20_000)])
                       for axis in (np.pi / 2, np.pi / 2 + 0.4))
    assert tilted.stress_angle - upright.stress_angle == pytest.approx(0.4, abs=0.05)
    expected = upright.xi_networks.anisotropies()
    assert tilted.xi_networks.anisotropies() == pytest.approx(expected, abs=0.05)


def test_large_packings_are_analysed_in_vectors():
    """All observables of 13 000 particles take about as long as a loop of 10⁷ additions."""
    networks = [packing(0.5, particles_=13_000, contacts=26_000)]
    start = time.process_time()
    sum(k for k in range(10**7))
    between = time.process_time()
    ensemble = Ensemble(networks)
    registry.measures(ensemble, registry.Grids.of([ensemble], 0.4), [ensemble])
    assert time.process_time() - between < 10 * (between - start)


# --- errors

def test_bad_runs_are_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    refused("has no network-\\*.h5", Run.read, tmp_path / "empty")
    refused("no runs", analysis.analyse, [])
    run = Run.read(write_run(tmp_path / "a", 0.5))
    refused("no network at a strain from 0.9 to 0.4; they are at 0.1000 to 0.4000", Run.read,
            tmp_path / "a", from_strain=0.9)
    slippery, smooth = (Run.read(write_run(tmp_path / name, 0.5, friction=friction))
                        for name, friction in (("b", 0.3), ("c", 0.0)))
    refused("friction = 0.3, 0.5; expected one value", analysis.analyse, [run, slippery])
    refused("friction = 0", analysis.analyse, [smooth])
    packing(0.3).save(tmp_path / "a" / "network-0.5000.h5")
    refused("eta = 0.3, 0.5; expected one", lambda: analysis.analyse([Run.read(tmp_path / "a")]))
    for folder, file, name in (("b", "network-0.6.h5", "strain"), ("c", "isotropic.h5", "volume")):
        bare = packing(0.5)
        del bare.attributes[name]
        bare.save(tmp_path / folder / file)
        refused(f"{file} is a network without the attribute {name}", Run.read, tmp_path / folder)
    wrong = packing(0.5)
    for eta in 0.4, 0.6:
        wrong.attributes["eta"] = eta
        wrong.save(tmp_path / "b" / "network-0.6.h5")
        refused(f"0.6.h5 has eta = {eta} and grains with half_length/R up to 0.5; expected equal",
                Run.read, tmp_path / "b")
    refused("no networks", Ensemble, [])


def without_contacts(network):
    columns = {name: column[:0] for name, column in network.contacts.items()}
    return Network(network.particles, columns, network.attributes)


@pytest.mark.parametrize("name", ["network-0.4000.h5", "isotropic.h5"])
def test_networks_without_contacts_are_refused(tmp_path, name):
    path = write_run(tmp_path / "a", 0.5, contacts=60) / name
    empty = without_contacts(Network.load(path))
    empty.save(path)
    refused(f"{name} has no contact between grains; expected", Run.read, path.parent)
    refused("no contact between grains", Ensemble, [empty])


def _of(change, network):
    """Return the network with other forces, or with half of its contacts at walls."""
    n = network.contacts["normal"]
    t = np.column_stack([-n[:, 1], n[:, 0]])
    fn = np.einsum("ca,ca->c", network.contacts["force"], n)[:, None]
    forces = dict(frictionless=fn * n, equal=n, mobilised=fn * (n + 0.5 * t))
    network.contacts["force"] = forces.get(change, network.contacts["force"])
    if change == "walls":
        network.contacts["body2"][1::2] = -1
    return network


def measured(network):
    ensemble = Ensemble([network])
    grids = registry.Grids.of([ensemble], 0.4)
    return ensemble, grids, registry.measures(ensemble, grids, [ensemble])


def test_angular_functions_without_contacts_are_unknown():
    """Equal forces: no contact is below half the mean."""
    found = measured(_of("equal", packing(0.5, contacts=60)))[2]["O17"]
    for name in "f_n_mean", "f_n_amplitude", "f_t_amplitude":
        assert np.isnan(found[name][0]) and np.isfinite(found[name][2:]).all()


def of_lengths(network, lengths):
    branch = network.contacts["branch"]
    branch *= (np.broadcast_to(lengths, len(branch)) / np.hypot(*branch.T))[:, None]
    return network


@pytest.mark.parametrize("least, first", [(0.5, 0.5), (0.496, 0.5), (0.15, 0.15)])
def test_the_bins_of_lengths_hold_small_grains(least, first):
    """They start at 1 − η = 0.5, up to overlaps, or at the least ℓ/R_max of smaller grains."""
    assert measured(of_lengths(packing(0.5), least))[1].length[[0, -1]] == pytest.approx([first, 2])


def test_contacts_outside_the_range_of_lengths_are_left_out():
    """Branches of clumps; overlaps count as contacts at the end of the range."""
    ensemble, _, found = measured(of_lengths(packing(0.5, contacts=60),
                                             2 * np.repeat([0.3, 0.498, 1.3], 20)))
    assert found["O10"]["pdf"] == pytest.approx([100] + 49 * [0])
    mean = np.hypot(ensemble.fn, ensemble.ft)
    assert found["O13"]["f_l_r"][0] == pytest.approx(mean[20:40].mean() / mean.mean())


def test_strips_of_a_periodic_cell_do_not_depend_on_images():
    network = packing(0.5, contacts=60)
    network.attributes["cell"] = np.array([[30.0, 5], [0, 30]])
    before = Ensemble([network]).across
    network.contacts["position"] += np.outer(np.arange(60) % 3 - 1, [35, 30])
    assert Ensemble([network]).across == pytest.approx(before)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("change", ["none", "frictionless", "equal", "mobilised", "walls"])
@pytest.mark.parametrize("particles, contacts", [(2, 1), (3, 2), (10, 15), (30, 60)])
def test_tiny_packings_are_analysed(particles, contacts, change):
    """From one contact on there is no error and no warning; NaN enters no verdict."""
    for etas in ([0.0], [0.5], [0.0, 0.2, 0.5, 0.7]):
        runs = []
        for k, eta in enumerate(etas):
            networks = [_of(change, packing(eta, seed=3 * k + j, particles_=particles,
                                            contacts=contacts, strain=0.1 * (j + 1)))
                        for j in range(1 + k % 2)]
            runs.append(Run(pathlib.Path(f"/{k}"), networks, 0.0))
        result = analysis.analyse(runs)
        table = PAPER.findings(result)
        json.dumps(analysis.jsonable(result), allow_nan=False)
        assert not [row for row in table
                    if row.verdict != claims.NOT_TESTED and "nan" in row.value + row.error]


def record_of(folder, eta=0.5, **parameters):
    """The run of a folder with these parameters in run.json."""
    run = dict(program="biaxial.py", run=json.dumps(parameters),
               parameters=dict(eta=eta, **parameters))
    (folder / "run.json").write_text(json.dumps(run))
    return Run.read(folder)


def test_runs_that_are_no_seeds_are_refused(tmp_path):
    """A run given twice, other parameters than the seed, networks of two runs in a folder."""
    folders = [write_run(tmp_path / name, 0.5, seed, strains=(0.1, 0.2))
               for name, seed in (("a", 1), ("b", 2))]
    (tmp_path / "link").symlink_to("a")
    for again in (folders[0], tmp_path / "link", tmp_path / "b" / ".." / "a"):
        refused("is given twice", analysis.analyse, [Run.read(folders[0]), Run.read(again)])
    first = record_of(folders[0], tolerance=1e-4)
    analysis.analyse([first, record_of(folders[1], tolerance=1e-4, threads=2)])
    refused(r"a has tolerance = 0.0001 \(.*b 0.001\); expected runs that differ in their seed",
            analysis.analyse, [first, record_of(folders[1], tolerance=1e-3)])
    refused("hold the same run", analysis.analyse, [first, record_of(folders[1], tolerance=1e-4)])
    text = (folders[1] / "run.json").read_text()
    (folders[1] / "run.json").write_text(text.replace('"eta": 0.5', '"eta": 0.4'))
    refused("has eta = 0.5, .*run.json 0.4: the folder mixes two runs", Run.read, folders[1])
    copies = [Run.read(write_run(tmp_path / name, 0.5, 1, (0.1, 0.2))) for name in "cd"]
    refused("d and .*c hold networks of the same packing", analysis.analyse, copies)


def test_elongations_measured_in_different_ways_are_refused(tmp_path):
    """A trend needs the same law, rate and window; size, end and cap of sweeps may differ."""
    disc, grain = (write_run(tmp_path / name, eta, particles_=20, contacts=200)
                   for name, eta in (("disc", 0), ("grain", 0.5)))
    first = record_of(disc, 0, law="cd", iterations=300, particles=13000, threads=1, strain=0.4)
    for name, value in dict(law="smooth", inertial_number=1e-3, tolerance=1e-2).items():
        refused(f"disc has {name} = .* \\(.*grain {value}\\); expected tests that differ in",
                analysis.analyse, [first, record_of(grain, **dict(law="cd") | {name: value})])
    same = record_of(grain, law="cd", iterations=9, particles=20, threads=2, strain=0.5)
    analysis.analyse([first, same])
    own = write_run(tmp_path / "own", 0.5, strains=(0.1, 0.29, 0.39), contacts=200)
    analysis.analyse([first, Run.read(own)])  # networks of a user, saved at about the same strains
    shorter = Run.read(own, to_strain=0.29)
    refused("disc and .*own have averages over strains of 0.2 to 0.4 and 0.145 to 0.29; give both "
            "--from-strain and --to-strain", analysis.analyse, [first, shorter])


def test_mixed_networks_are_refused(tmp_path):
    folder = write_run(tmp_path / "a", 0.5, strains=(0.1, 0.2))
    other = packing(0.5, strain=0.3)
    for length in ("R", "cap_radius", "half_length"):
        other.particles[length] *= 1.01
    other.save(folder / "network-0.3000.h5")
    refused("network-0.3000.h5 and network-0.1000.h5 hold different grains: the folder mixes",
            Run.read, folder)
    for strain in 0.1, 0.2:
        packing(0.5, strain=strain).save(folder / "network-0.3000.h5")
        refused(f"network-{strain:.4f}.h5 have the same strain", Run.read, folder)
    folder = write_run(tmp_path / "b", 0.5)
    for eta, grains, says in ((0.0, 200, "have eta = 0, 0.5"),
                              (0.5, 199, "isotropic.h5 and .* hold different grains")):
        packing(eta, particles_=grains, strain=0, friction=0).save(folder / "isotropic.h5")
        refused(says, Run.read, folder)


HEADER = "strain,stress_x,stress_y\n"


@pytest.mark.parametrize("text, says", [
    ("", ": lacks the column strain and stress_x and stress_y"),
    (HEADER, ": holds no record"),
    (HEADER + "0.1,1,2\n0.2,abc,2\n", ": line 3: stress_x = 'abc'; expected a number"),
    (HEADER + "0.1,1,2\n0.2,1,nan\n", ": line 3: stress_y = nan; expected a finite number"),
    (HEADER + "0.1,1,2\n0.2,1\n", ": line 3: stress_y = None; expected a number"),
    (HEADER + "0.1,1,2\n0.1,1,2\n", r": the strain\[1\] = 0.1; expected more than"),
    *((rows, " ends at a strain of 0...60 and the networks at 0.4000; expected records up to there")
      for rows in (80, 30)),  # up to 0.316 or 0.116; the critical state is from 0.2 to 0.4
])
def test_bad_histories_are_refused(tmp_path, text, says):
    path = write_run(tmp_path / "a", 0.5) / "history.csv"
    whole = path.read_text().splitlines()
    path.write_text(text if isinstance(text, str) else "\n".join(whole[: text + 1]))
    refused(f"history.csv{says}", Run.read, path.parent)


# --- verdicts

def rows(result, observable, start=""):
    return [row for row in PAPER.findings(result)
            if row.observable == observable and row.statement.startswith(start)]


def changed(result, observable, **arrays):
    entry = result[observable]
    return result | {observable: entry | dict(value=entry["value"] | arrays)}


def test_verdicts_follow_the_data(result):
    (row,) = rows(result, "O1")
    assert row.verdict == claims.AGREES
    off = changed(result, "O1", sin_phi=np.array([0.30, 0.52]), sin_phi_error=np.full(2, 0.01))
    (row,) = rows(off, "O1")
    assert row.verdict == claims.DIFFERS and "off at η = 0.5" in row.value
    within = changed(off, "O1", sin_phi_error=np.array([0.01, 0.04]))  # two errors
    (row,) = rows(within, "O1")
    assert row.verdict == claims.AGREES
    weak = {row.verdict for row in rows(result, "O3", "share")}
    assert weak == {claims.NOT_TESTED}  # no run of η = 0.7
    pdf = result["O8"]["value"]["pdf"].copy()
    pdf[0, 3] = np.nan  # a class without a number
    (row,) = rows(changed(result, "O8", pdf=pdf), "O8", "discs")
    assert row.verdict == claims.NOT_TESTED and row.value == "too few contacts"
    tight = changed(result, "O18", closure=np.zeros_like(result["O18"]["value"]["closure"]))
    assert rows(tight, "O18", "half-sum")[0].verdict == claims.AGREES
    wide = changed(result, "O18", closure=0.2 + tight["O18"]["value"]["closure"])
    assert rows(wide, "O18", "half-sum")[0].verdict == claims.DIFFERS


def seeds_of(ratios):
    """Runs of one elongation whose walls bear sin φ = `ratios`."""
    made = []
    for seed, ratio in enumerate(ratios):
        stresses = np.full(20, 1 - ratio), np.full(20, 1 + ratio)
        history = dict(strain=np.linspace(0.2, 0.4, 20), stress_x=stresses[0], stress_y=stresses[1])
        network = packing(0.5, seed=seed, contacts=200)
        made.append(Run(pathlib.Path(f"{seed}"), [network], 0.2, 0.4, None, history, None, None))
    return made


def test_sin_phi_of_three_seeds():
    """0.40, 0.45 and 0.50 scatter by 0.05; the curve continues where two seeds end."""
    runs = seeds_of((0.40, 0.45, 0.50))
    value = analysis.analyse(runs)["O1"]["value"]
    assert value["sin_phi"] == pytest.approx(0.45)
    assert value["sin_phi_error"] == pytest.approx(0.05 / np.sqrt(3))
    for run in runs[:2]:
        run.history = {name: column[:10] for name, column in run.history.items()}
    assert analysis.analyse(runs)["O1"]["value"]["sin_phi_strain"][0, -1] == pytest.approx(0.5)


def test_the_packing_fraction_counts_overlaps_in_a_clump_once():
    one, two = (packing(0.5, particles_=20, contacts=60) for _ in range(2))
    two.particles["clump"][:2] = 99
    for name in "position", "angle":
        two.particles[name][:2] = 0
    grids = registry.Grids.of([Ensemble([one])], 0.4)
    apart, joined = (packings.isotropic(n, grids)["packing_fraction"] for n in (one, two))
    assert joined == pytest.approx(19 / 20 * apart, rel=1e-5)


def test_many_isotropic_seeds_are_isotropic():
    """|a_c| of ten packings of 700 contacts falls as that of 7000 contacts."""
    states = [packing(0.5, seed=seed, contacts=700, a_c=0, a_fn=0) for seed in range(10)]
    runs = seeds_of([0.4] * 10)
    for run, state in zip(runs, states):
        run.isotropic = state
    value = analysis.analyse(runs)["O2"]["value"]
    assert value["a_c"][0] < 3 * value["a_c_error"][0] == pytest.approx(3 * np.sqrt(2 / 7000))


def test_major_stress_may_be_along_either_axis(tmp_path):
    """Axes at ±89° and ±88° are within 2° of 90°."""
    angles = np.radians([89, -89, 88, -88])
    parts = [dict(off_axis=np.pi / 2), *(dict(off_axis=angle) for angle in angles)]
    assert registry.with_errors(parts)["off_axis_error"] < np.radians(1)
    folder = write_run(tmp_path / "run", 0.5, axis=0)
    text = (folder / "history.csv").read_text().replace("stress_x,stress_y", "stress_y,stress_x")
    (folder / "history.csv").write_text(text)
    sin_phi = analysis.analyse([Run.read(folder)])["O1"]["value"]["sin_phi"]
    assert sin_phi == pytest.approx(0.45, abs=0.01)


def test_the_critical_state_decides_along_which_axis_the_major_stress_is(tmp_path):
    """Before it, σ_x is 9 times σ_y. Walls of an oblique test do not bear σ₁ and σ₂."""
    folder = write_run(tmp_path / "run", 0.5)
    header, *lines = (folder / "history.csv").read_text().splitlines()
    early = [f"{line.split(',')[0]},9,1" for line in lines[:40]]
    (folder / "history.csv").write_text("\n".join([header, *early, *lines[40:]]))
    assert (packings.sin_phi(Run.read(folder).critical_stresses()) > 0.4).all()
    oblique = write_run(tmp_path / "oblique", 0.5, axis=np.pi / 3)
    refused("oblique/history.csv has the stresses along x and y; .* at (59|60|61)° to x; expected "
            "at most 20° to x or y: remove history.csv to take", Run.read, oblique)
    (oblique / "history.csv").unlink()
    assert Run.read(oblique).history is None


def test_the_network_at_the_edge_of_the_window_counts(tmp_path):
    """It is saved within half a record of its strain."""
    run = Run.read(write_run(tmp_path / "run", 0.5, strains=(0.1, 0.1996, 0.3, 0.4)))
    assert strains_of(run) == [0.1996, 0.3, 0.4]
    run = Run.read(run.folder, from_strain=0.2, to_strain=0.2996)
    assert strains_of(run) == [0.1996, 0.3]


def test_another_sign_window_or_program_is_refused(tmp_path):
    """Compression negative, averages over other strains of a second seed, run.json of a script."""
    one, two = (write_run(tmp_path / name, 0.5, seed) for name, seed in (("a", 1), ("b", 2)))
    history = "strain,stress_x,stress_y\n" + "".join(f"{k / 50},-1e4,-2e4\n" for k in range(25))
    (one / "history.csv").write_text(history)
    refused("stress_x \\+ stress_y.* = -30000; expected > 0, compression positive", Run.read, one)
    (one / "history.csv").write_text(history.replace("-", ""))
    assert Run.read(one).to_strain == Run.read(one).networks[-1].attributes["strain"]
    shorter = Run.read(two, to_strain=0.2)
    refused("averages over strains of .* give both --from-strain and --to-strain",
            analysis.analyse, [Run.read(one), shorter])
    (two / "run.json").write_text(json.dumps(dict(program="other.py", run="1", parameters={})))
    refused("is of other.py; expected a folder of scripts/biaxial.py", Run.read, two)
