"""The biaxial test: compaction, shear, records of yielded steps, checkpoints, and the script."""

import dataclasses
import functools
import gzip
import json
import math
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import types

import forked
import numpy as np
import pytest
import rcr
from rcr.network import Network
from rcr.study import checkpoint, compaction
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT, HISTORY_COLUMNS
from rcr.study.protocol import ONE_RATE, PROTOCOL, quick_averages
from rcr.study.runs import Run
from rcr.study.shear import largest_rate
from common import complaint
from run_contents import COST, contents, different, start_until_written
from scenes import refused, set_state, without
from yade import O

STRESS = PROTOCOL.confining_stress
BALANCED = 5e-5  # mean net force over mean contact force; the study needs 2e-3
SCRIPT = "biaxial.py"


def state(test):
    bodies = [O.bodies[i].state for i in (*test.grains, *test.walls)]
    return np.array([(*s.pos, *s.ori, *s.vel, *s.angVel) for s in bodies])


def without_cost(summary):
    return {name: value for name, value in summary.items() if name not in COST}


@dataclasses.dataclass
class Packing:
    """A frictionless compaction of 400 particles: its last step and its checkpoint."""

    eta: float
    folder: str
    network: Network
    points: np.ndarray  # (body 1, body 2, normal force) of each contact point with a force
    net_forces: np.ndarray
    wall_stresses: np.ndarray

    def sheared(self, records, **parameters):
        """The test after records of shear from the checkpoint, with changed parameters."""
        test = Biaxial.load(self.folder)
        test.parameters.update(parameters)
        return shear(test, records)


def shear(test, records):
    for _ in range(records):
        test.shear_record()
    return test


@pytest.fixture(scope="module", params=[0.0, 0.5])
def packing(request, tmp_path_factory):
    test = Biaxial.prepare(eta=request.param, particles=400, seed=1)
    test.compact(balanced=BALANCED)
    folder = str(tmp_path_factory.mktemp("packing"))
    test.save(folder)
    net = np.array([O.forces.f(i).norm() for i in test.grains])
    points = np.array([(i.id1, i.id2, force[0]) for i in O.interactions
                       for force in (i.phys.force1, i.phys.force2)[: i.phys.points]
                       if force[0] > 0])
    return Packing(request.param, folder, test.isotropic, points, net, test.mean_stresses)


# Of speeds and records, which do not depend on the grains.
of_the_control = pytest.mark.parametrize(
    "packing", [0.0, pytest.param(0.5, marks=pytest.mark.slow)], indirect=True)


def test_frictionless_packing_is_isostatic(packing):
    """The number of forces is that of equations: 2 a disc, 3 a long particle, 1 a mobile wall; none
    for rattlers and for motions along flat sides, 1.5 %. Walls lower the coordination number Z.
    """
    equations_of_grain, fewest, bulk = (2, 0.99, 4) if packing.eta == 0 else (3, 0.97, 6)
    force = packing.points[:, 2]
    points = packing.points[force > 1e-3 * force.mean()]  # smaller ones are below the tolerance
    equations = equations_of_grain * np.count_nonzero(np.unique(points[:, :2]) < 400) + 2
    assert fewest * equations <= len(points) <= 1.005 * equations  # forces near the threshold
    assert bulk - 0.5 < packing.network.coordination(count_side_contacts_twice=True) < bulk + 0.1


def test_frictionless_packing_is_balanced_and_isotropic(packing):
    """σ = (1/V) Σ f⊗ℓ over all contacts is the load of the walls, up to the net forces."""
    mean = packing.points[:, 2].mean()
    assert packing.net_forces.mean() < BALANCED * mean
    assert packing.net_forces.max() < 0.02 * mean  # one of 400 grains still settles
    assert packing.wall_stresses == pytest.approx(STRESS, rel=0.01)
    stress = packing.network.stress()
    assert np.diag(stress) == pytest.approx(packing.wall_stresses, rel=5e-3)
    assert stress[0, 1] == pytest.approx(stress[1, 0], abs=1e-3 * STRESS)
    attributes = packing.network.attributes
    assert [attributes[name] for name in ("eta", "strain", "friction")] == [packing.eta, 0, 0]


@pytest.mark.parametrize("approach", [0.1, 0.004])
def test_checkpoint_continues_to_the_same_bits(packing, approach, tmp_path):
    """The wall accelerates, or brakes from a strain of 0.002 on."""
    shown = lambda test: [(row["sin_phi"], row["iterations"]) for row in test.rows]
    test = packing.sheared(4, approach=approach)
    straight, rows = state(test), shown(test)
    before = packing.sheared(2, approach=approach)
    before.save(tmp_path)
    test = shear(Biaxial.load(tmp_path), 2)
    assert np.array_equal(state(test), straight) and shown(test) == rows
    assert (test.progress["rate"] < before.progress["rate"]) == (approach < 0.1)


@of_the_control
def test_records_do_not_depend_on_the_length_of_runs(packing):
    """The wall accelerates in the first 7 of the 24 records."""

    def sheared(records):
        test = Biaxial.load(packing.folder)
        for count in records:
            test.shear(count)
        return test, state(test)

    single, alone = sheared([1] * 24)
    many, together = sheared([20, 4])
    assert np.array_equal(alone, together)
    assert many.rows == single.rows and len(many.rows) == 24
    assert many.progress["rate"] == PROTOCOL.quick_inertial_number
    assert many.progress["iterations"] == single.progress["iterations"]
    assert many.solver.model["array_steps"] > single.solver.model["array_steps"]
    assert without_cost(many.summary()) == without_cost(single.summary())


def test_relaxation_steps_shorten_only_where_the_unbalance_stays():
    """Constant net forces: ever shorter steps, then longer ones. Halving ones: no shorter."""
    window, first = PROTOCOL.unbalance_window, PROTOCOL.displacement_per_unbalance

    def steps(unbalance, intervals=200):
        state = {}
        solvers = (types.SimpleNamespace(unbalancedForce=unbalance(k), largestUnbalancedForce=0.5)
                   for k in range(intervals))
        return [compaction.relaxation_time_step(state, solver) for solver in solvers]

    stuck = steps(lambda k: 0.01)
    before = 2 * window - 1
    assert min(stuck) == 0.1 and stuck[:before] == [max(stuck)] * before
    longest = [b for a, b in zip(stuck, stuck[1:]) if b > a]  # after each restart
    assert longest[0] < max(stuck) and all(b < a for a, b in zip(longest[:3], longest[1:3]))

    falling = lambda k: 0.01 * 0.5 ** (k / window)
    bounds = [min(PROTOCOL.max_grain_displacement, first * falling(k)) for k in range(20)]
    assert steps(falling, 20) == pytest.approx([min(1, math.sqrt(b / 0.5)) for b in bounds])


def test_creep_is_accepted_where_longer_steps_flip_grains():
    """A balanced packing whose wall stresses stay 2 % off σ₀, as one of 13 000 grains did."""
    intervals, reduction = PROTOCOL.creep_intervals, PROTOCOL.displacement_reduction

    def accepted(deviation, **state):
        state = dict(displacement=1.0, **state)
        found = [compaction.accept_creep(state, deviation) for _ in range(intervals)]
        return found, state["displacement"]

    none = [False] * intervals
    assert accepted(0.02) == (none, pytest.approx(reduction**-intervals))  # no flips so far
    assert accepted(0.02, flip_displacement=1.0) == (none[1:] + [True], 1.0)
    assert accepted(0.04, flip_displacement=1.0) == (none, pytest.approx(1 / reduction))


def reports(eta, particles, of, seed=1):
    found = []
    Biaxial.prepare(eta, particles, seed=seed).compact(lambda test: found.append(of(test)))
    return found


@pytest.mark.parametrize("eta", [pytest.param(0.1, marks=pytest.mark.slow), 0.7])
def test_collapse_ends_where_the_grains_carry_the_load(eta):
    """A longer collapse compresses a large packing to tens of σ₀."""
    found = reports(eta, 1000, lambda test: (test.progress["phase"], test.mean_stresses.min()))
    largest = max(stress for phase, stress in found if phase == "collapse")
    assert largest < PROTOCOL.max_collapse_stress * STRESS


def test_compaction_of_discs_finds_few_contact_points():
    """Velocities of the collapse must not give the longer steps that follow 12 points a grain."""
    assert max(reports(0, 1000, lambda test: test.solver.contactPoints)) < 3500


def test_shear_starts_without_grains_that_flip_into_others():
    """A grain flips to and fro in long steps, although the packing is balanced."""
    test = Biaxial.prepare(0.7, 1000, seed=2)
    test.compact()
    assert test.overlaps().max() <= PROTOCOL.largest_overlap
    test.shear(1)
    assert test.solver.deepestOverlap < 2e-3


def test_walls_stay_smooth_in_shear(packing):
    """A packing that has blown up ends the test."""
    test = packing.sheared(2)
    at_walls, between = ([i.phys for i in O.interactions
                          if (max(i.id1, i.id2) in test.walls) == wall] for wall in (True, False))
    assert {phys.tangensOfFrictionAngle for phys in at_walls} == {0}
    assert [phys.tangensOfFrictionAngle for phys in between] == pytest.approx(
        [0.5] * len(between), rel=1e-15)
    assert max(phys.normalForce.norm() for phys in at_walls) > 0
    assert max(phys.shearForce.norm() for phys in at_walls) == 0
    assert max(phys.shearForce.norm() for phys in between) > 0
    O.bodies[test.right].state.pos *= 10  # along x alone: its y is 0
    refused("has blown up by step .* packing fraction 0.0", test.shear_record, error=RuntimeError)


def test_compaction_continues_from_a_checkpoint_to_the_same_bits(tmp_path):
    """One checkpoint in the collapse, one in the relaxation."""

    def leave(test):
        if O.iter == left_at:
            test.save(tmp_path)
            raise KeyboardInterrupt

    seen = reports(0.5, 60, lambda test: (test.progress["phase"], O.iter, state(test)), seed=2)
    steps, straight = seen[-1][1:]
    collapse = sum(phase == "collapse" for phase, *_ in seen)
    for count in (collapse // 2, (collapse + len(seen)) // 2):
        phase, left_at, _ = seen[count - 1]
        refused("", Biaxial.prepare(0.5, 60, seed=2).compact, leave, error=KeyboardInterrupt)
        test = Biaxial.load(tmp_path)
        assert test.progress["phase"] == phase and O.iter == left_at
        test.compact()
        assert O.iter == steps and np.array_equal(state(test), straight)


def test_a_checkpoint_holds_history_and_means(packing, tmp_path):
    """Neither a lost history.csv nor the new order of interactions changes a mean by an ulp."""
    test = packing.sheared(2)
    before, overlaps = without_cost(test.summary()), test.overlaps()
    history = tmp_path / "history.csv"
    assert (np.diff(overlaps) >= 0).all() and len(overlaps) > 400
    test.save(tmp_path)
    text = history.read_text()
    history.write_text("")
    again = Biaxial.load(tmp_path)
    assert again.rows == test.rows and without_cost(again.summary()) == before
    again.save(tmp_path)
    assert history.read_text() == text


def test_damaged_checkpoints_are_refused(packing, tmp_path):
    whole = (pathlib.Path(packing.folder) / CHECKPOINT).read_bytes()
    rng, path, harmless = random.Random(1), tmp_path / CHECKPOINT, 0
    for k in range(60):
        damaged = bytearray(whole)
        if k % 3:
            damaged[rng.randrange(len(whole))] ^= 1 << rng.randrange(8)
        else:
            del damaged[rng.randrange(len(whole)) :]
        path.write_bytes(damaged)
        try:
            Biaxial.load(tmp_path)
            harmless += 1  # in the header of gzip: time, system, flags
        except ValueError as error:
            assert str(error).startswith(f"{path}: ") and "\n" not in str(error)
    assert harmless <= 3
    for content in (b"", gzip.compress(b""), gzip.compress(b"no scene"), b"text"):
        path.write_bytes(content)
        refused(CHECKPOINT, Biaxial.load, tmp_path)
    O.reset()
    O.save(str(path), quiet=True)
    refused("not a checkpoint of a biaxial test", Biaxial.load, tmp_path)


@pytest.mark.parametrize("error", [MemoryError(), RuntimeError("input stream error")])
def test_checkpoints_of_other_versions_are_refused(packing, monkeypatch, error):
    """YADE reads the attributes of a class without their names: others make it ask for memory."""
    def load(*arguments, **options):
        raise error

    monkeypatch.setattr(checkpoint, "O", types.SimpleNamespace(load=load))
    refused("not a scene of this version of yade-rcr and YADE; resume it with the one in run.json",
            Biaxial.load, packing.folder)


@of_the_control
def test_shear_is_fast_up_to_the_strain_approach(packing):
    """Wall speed and time step become those of I = 1e-3; faster tests do not become slower."""
    for own, fast in (((2.5e-4, 0.4), (1e-3, 0.1)), ((2e-3, 0.05), (2e-3, 0.05))):
        test = packing.sheared(0, inertial_number=own[0], time_step=own[1], approach=0.02,
                               sample_inertia=1)
        seen = []
        while test.strain < 0.032 - 1e-6:
            test.shear_record()
            rate = -O.bodies[test.top].state.vel[1] / test.progress["first_height"]
            seen.append((rate * test.time_unit, O.dt / test.time_unit))
        rates = [rate for rate, _ in seen]
        fastest = rates.index(max(rates))
        assert rates[: fastest + 1] == sorted(rates[: fastest + 1])
        if own[0] < fast[0]:
            assert seen[10] == pytest.approx(fast, rel=1e-9)
            assert rates[10:] == sorted(rates[10:], reverse=True)
        assert seen[22:] == [pytest.approx(own, rel=1e-9)] * len(seen[22:]) and len(seen) == 32


def test_summary_has_the_inertia_of_the_sample(packing):
    """ρ (ε̇ W)²/σ₀ = I² N (W/h)(h₀/h)², since t₀² = m/σ₀; along the height (h/W)² times that.

    The width counts from the middle, that is half.
    """
    test = Biaxial.load(packing.folder)
    first = test.height
    predicted = largest_rate(test, 0.01)
    summary = shear(test, 10).summary()
    aspect = test.width / test.height
    expected = PROTOCOL.quick_inertial_number**2 * 400 * aspect * (first / test.height) ** 2
    assert summary["aspect_ratio"] == pytest.approx(aspect, rel=1e-12)
    assert summary["aspect_ratio_initial"] < aspect
    assert summary["sample_inertia"] == pytest.approx(expected / 4, rel=1e-9)
    assert summary["sample_inertia_height"] == pytest.approx(expected / aspect**2, rel=1e-9)
    # at a constant area; the inertia at a given rate is inversely proportional to these squares
    assert largest_rate(test) ** 2 == pytest.approx(predicted**2, rel=0.05)


@of_the_control
@pytest.mark.parametrize("parameters", [
    dict(), dict(approach=0.005, inertial_number=3e-4, time_step=0.3),
    dict(approach=0, inertial_number=7e-4, time_step=0.13)])
def test_records_lie_at_multiples_of_their_strain(packing, parameters):
    """Exactly, with the given time step at most."""
    test = packing.sheared(0, **parameters)
    while not test.has_reached(0.02):
        test.shear_record()
        assert O.dt <= parameters.get("time_step", 0.4) * test.time_unit * (1 + 1e-9)
    assert [row["strain"] for row in test.rows] == [k / 1000 for k in range(1, 21)]
    assert test.strain == test.network().attributes["strain"] == test.summary()["strain"] == 0.02


@of_the_control
def test_the_inertial_number_of_the_summary_is_that_of_its_means(packing):
    """The option is 1e-4; the means up to a strain of 0.02 are those of the quick shear."""
    test = packing.sheared(0)
    assert test.summary()["inertial_number"] is None
    while not test.has_reached(0.02):
        test.shear_record()
    assert test.summary()["inertial_number"] == pytest.approx(1e-3, rel=1e-6)
    mixed = packing.sheared(0, approach=0.015, inertial_number=5e-4, sample_inertia=1)
    while not mixed.has_reached(0.02):
        mixed.shear_record()
    rates = np.array([(one["strain"] - two["strain"], one["time"] - two["time"])
                      for one, two in zip(mixed.rows[1:], mixed.rows)
                      if one["strain"] > 0.0095])
    expected = rates[:, 0].sum() / rates[:, 1].sum() * mixed.time_unit
    assert mixed.summary()["inertial_number"] == pytest.approx(expected, rel=1e-9)
    assert 5e-4 < expected < 7e-4


@pytest.mark.parametrize("strain, approach, rate, says", [
    (0.18, 0.1, 1e-4, "averages are over strains of 0.09 to 0.18, but the shear is slow from 0.1 "
     "on only: they mix several rates; give --strain 0.2 or more, or a smaller --approach"),
    (0.2, 0.1, 1e-4, ""), (0.1, 0, 1e-4, ""), (0.18, 0.1, 1e-3, ""), (0.1, 0.09, 1e-4, "0.05 to")])
def test_averages_of_quick_shear_are_warned_of(strain, approach, rate, says):
    found = quick_averages(strain, approach, rate)
    assert says in found and bool(found) == bool(says)


def test_missed_tolerances_are_counted(packing):
    def load(**settings):
        test = Biaxial.load(packing.folder)
        for name, value in settings.items():
            setattr(test.solver, name, value)
        return test

    test, first = load(maxIterations=2, solver="nlgs"), O.iter
    summary = shear(test, 2).summary()
    steps = O.iter - first
    assert summary["missed_fraction"] == test.progress["missed"] / steps > 0.9
    assert summary["unconverged_steps"] + summary["yielded_steps"] == test.progress["missed"]
    assert sum(row["unconverged_steps"] for row in test.rows) == summary["unconverged_steps"]
    # estimated errors, at most 1; two plain sweeps leave errors far beyond the goal of 0.3
    assert 0.3 < summary["missed_mean"] <= summary["missed_max"] <= 1

    # forces meet the tolerance, velocities do not
    test, first = load(tolerance=0.5, accuracy=1e-9, maxIterations=20, solver="nesterov"), O.iter
    test.shear_record()
    assert test.progress["missed"] == O.iter - first
    assert test.progress["residual_max"] < 0.5 and test.progress["missed_max"] > 30 * 1e-9

    # solutions near which Coulomb friction lets no method come closer miss the default accuracy
    summary = shear(load(maxIterations=100_000, accuracy=math.inf), 1).summary()
    assert {summary[name] for name in ("missed_fraction", "missed_mean", "missed_max",
                                       "unconverged_steps", "yielded_steps")} == {0}


def test_records_with_yielded_steps_are_left_out_of_means(packing):
    test = packing.sheared(8)
    clean = test.summary()
    assert clean["records_left_out"] == clean["yielded_steps"] == 0
    test.rows[-1].update(yielded_steps=3, stress_y=50 * STRESS)
    test.progress["yielded"] = test.progress["missed"] = 3
    marked, all_rows = test.summary(), test.summary(include_yielded=True)
    assert (marked["records_left_out"], marked["yielded_steps"]) == (1, 3)
    change, change_of_all = (abs(s["sin_phi"] - clean["sin_phi"]) for s in (marked, all_rows))
    assert change < 0.1 < change_of_all
    assert [s["last_record_left_out"] for s in (clean, marked, all_rows)] == [False, True, False]
    assert all_rows["records_left_out"] == 0 and all_rows["records"] == marked["records"]
    for row in test.rows:
        row.update(yielded_steps=1)
    assert test.summary()["sin_phi"] is None


def test_a_jam_is_marked_in_the_history(tmp_path):
    """Driven side walls close a packing that cannot give way: its steps have no solution."""
    test = Biaxial.prepare(eta=0, particles=20, seed=1)
    test.compact()
    test.solver.yieldCompliance = 1
    without(rcr.WallStress)
    set_state(test.left, blockedDOFs="xyzXYZ")
    set_state(test.right, blockedDOFs="xyzXYZ", vel=(-0.01 * test.diameter / test.time_unit, 0, 0))
    refused("", test.shear, 20, error=RuntimeError)
    test.save(tmp_path)
    header, *lines = (tmp_path / "history.csv").read_text().splitlines()
    assert header.split(",") == list(HISTORY_COLUMNS)
    yielded = [int(line.split(",")[-1]) for line in lines]
    assert sum(yielded) > 0 and [row["yielded_steps"] for row in test.rows] == yielded


OUT_OF_RANGE = dict(
    eta=[math.nan, 1, "0.5", True, 1j], particles=[9, 10.5, 2**70], seed=[-1, 2**64],
    friction=[math.inf, 1e10], tolerance=[-1e-9, 1], solver=["magic", None, ["auto"]],
    threads=[-1, 10**6], inertial_number=[0, 1e9], time_step=[1e6, -5e-324], law=["springs"],
    stiffness=[0], iterations=[2**31],
)  # fmt: skip


@pytest.mark.parametrize("wrong, match", [
    (dict(law="soft"), "law = 'soft'; expected one of cd, smooth"),
    (dict(law="smooth", stiffness=0), "stiffness = 0; expected a number ≥ 1"),
    (dict(law="cd", stiffness=300), "stiffness = 300 with law = 'cd': the law 'smooth' alone"),
    (dict(law="smooth", time_step=0.2), "time_step = 0.2 with law = 'smooth': the law 'cd' alone"),
    (dict(iterations=0), "iterations = 0; expected a whole number > 0"),
    *(({name: value}, name) for name, values in OUT_OF_RANGE.items() for value in values),
])  # fmt: skip
def test_refused_parameters_leave_the_scene(wrong, match):
    O.reset()
    O.tags["mine"] = "kept"
    refused(match, Biaxial.prepare, **wrong)
    assert O.tags["mine"] == "kept"


SMALL = "--eta 0.5 --particles 60 --seed 2 --strain 0.01 --networks 2".split()
script = functools.partial(forked.yade_script, SCRIPT)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "out"
    done = script(*SMALL, "--out", folder)
    assert "averages are over strains of 0.005 to 0.01, but the shear is slow from" in done.stderr
    return folder


@pytest.fixture
def done(finished, tmp_path):
    shutil.copytree(finished, tmp_path / "out")
    return tmp_path / "out"


def test_script_leaves_an_identity(done):
    record = json.loads((done / "run.json").read_text())
    summary = json.loads((done / "summary.json").read_text())
    assert record["program"] == "biaxial.py"
    assert record["parameters"]["eta"] == 0.5 and record["parameters"]["strain"] == 0.01
    assert {"version", "commit", "date"} <= set(record)
    runs = {Network.load(path).attributes["run"] for path in done.glob("*.h5")}
    assert runs == {record["run"]} == {summary["run"]}
    assert summary["records"] == Run.read(done).yielded.records  # one rule for the second half
    assert summary["peak_memory_bytes"] > 1e7
    assert summary["unconverged_steps"] <= 1 and summary["yielded_steps"] == 0
    assert not list(done.glob(".part-*"))


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("arguments, message", [
    ("--eta 0.4", "eta = 0.5 (here 0.4)"),
    ("--strain 0.02", "strain = 0.01 (here 0.02)"),
    ("--resume --tolerance 1e-3", "tolerance = 0.0001 (here 0.001)"),
    ("--resume --law smooth", "law = cd (here smooth)"),
    ("--resume --overwrite", "give one of them"),
    ("--resume --strain 0.005", "beyond --strain 0.005; give no less than it has"),
    ("--resume --networks 4", "has reached its strain with --networks 2"),
])  # fmt: skip
def test_script_refuses_the_folder_of_another_run(done, arguments, message):
    before = files(done)
    run = forked.run(SCRIPT, *SMALL, *arguments.split(), "--out", done)
    assert message in complaint(run)
    assert files(done) == before


@of_the_control
def test_wide_samples_shear_more_slowly(packing):
    """Beyond `approach`, ρ (ε̇ W/2)²/σ₀ is at its bound, with the packing fraction before."""
    parameters = dict(approach=0.003, inertial_number=1e-3, sample_inertia=2e-5)
    test = packing.sheared(0, **parameters)
    inertias = []
    while test.strain < 0.02:
        slow, fraction = test.strain > 0.003, test.packing_fraction
        test.shear_record()
        inertias += [test.sample_inertia()[0] * test.packing_fraction / fraction] if slow else []
    assert inertias == pytest.approx([2e-5] * len(inertias), rel=1e-6) and len(inertias) > 10
    final = test.summary()["inertial_number_final"]
    one = [row["stress_x"] for row in test.rows]
    test = packing.sheared(0, **parameters)
    test.shear(len(one))
    assert [row["stress_x"] for row in test.rows] == one  # however many records are asked for
    test.shear_record()  # from the rate that the summary had before
    rate = -O.bodies[test.top].state.vel[1] / test.progress["first_height"] * test.time_unit
    assert test.progress["rate"] < rate < final < 0.5 * parameters["inertial_number"]


@pytest.mark.parametrize("option, seed", [("--overwrite", 3), ("--resume", 2)])
def test_networks_of_an_abandoned_part_are_removed(done, option, seed):
    """--resume finds them after a kill between the checkpoint of a restart and their removal."""
    (done / "network-0.9999.h5").touch()
    (done / "notes").touch()
    script(*SMALL, "--seed", seed, option, "--out", done)
    assert not (done / "network-0.9999.h5").exists() and (done / "notes").exists()
    assert {Network.load(path).attributes["seed"] for path in done.glob("*.h5")} == {seed}


def test_resume_needs_the_record_of_the_run(done):
    (done / "run.json").unlink()
    run = script(*SMALL, "--resume", "--out", done, code=1)
    assert "has no run.json of this script" in run.stderr


def test_a_killed_extension_changes_no_networks(done):
    """run.json then has the strain and networks of the extension."""
    record = json.loads((done / "run.json").read_text())
    record["parameters"] |= dict(strain=0.5, networks=7)
    (done / "run.json").write_text(json.dumps(record))
    longer = [*SMALL, "--strain", "0.02", "--resume"]
    for arguments in [*SMALL, "--resume"], [*SMALL, "--resume"], longer, longer:
        script(*arguments, "--out", done)
        assert (done / "summary.json").exists()


def test_needles_pack_loosely_and_have_not_blown_up(tmp_path):
    script("--eta", "0.99", "--particles", "30", "--strain", "0.002", "--networks", "1",
           "--out", tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["packing_fraction_initial"] < 0.5


@pytest.mark.parametrize("particles", [2000, pytest.param(8000, marks=pytest.mark.slow)])
def test_memory_is_linear_in_the_grains(particles, tmp_path):
    """The collapse of discs has the most points. A test of 100 grains has the memory of YADE."""
    def peak(count):
        out = tmp_path / str(count)
        script("--eta", "0", "--particles", count, "--strain", "0.001", "--networks", "1",
               "--out", out)
        return json.loads((out / "summary.json").read_text())["peak_memory_bytes"]

    assert peak(particles) < peak(100) + 18e3 * particles


@pytest.mark.slow
def test_script_continues_to_a_larger_strain(done, tmp_path):
    """The results are those of one run; the number of threads may change."""
    further = [*SMALL, "--strain", "0.02"]
    script(*further, "--threads", "2", "--resume", "--out", done)
    script(*further, "--out", tmp_path / "straight")
    one, two = contents(done), contents(tmp_path / "straight")
    for name in ("history.csv", "network-0.0200.h5"):
        assert one[name] == two[name]


def test_killed_script_continues_to_the_same_results(tmp_path):
    """The last checkpoint remains. tests/yade/run/test_signals.py has the other signals."""
    arguments = [*SMALL, "--strain", "0.04"]
    script(*arguments, "--out", tmp_path / "straight")
    out = tmp_path / "out"
    pipes = dict(stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    for _ in range(2):
        resume = ["--resume"] if (out / CHECKPOINT).exists() else []
        process = start_until_written(
            out / CHECKPOINT, forked.command(SCRIPT, *arguments, *resume, "--out", out), **pipes)
        process.kill()
        errors = process.communicate(timeout=120)[1]
        assert process.returncode in (0, -signal.SIGKILL), errors
    script(*arguments, "--resume", "--out", out)
    assert not different(contents(out), contents(tmp_path / "straight"))


def test_results_do_not_depend_on_the_speed_of_the_machine(tmp_path):
    """Runs of one record, as on a slow machine, and of many records, while the rate falls."""
    arguments = "--eta 0.6 --particles 40 --approach 0.015 --strain 0.03 --networks 1".split()
    slow = "import time; clock = time.monotonic; time.monotonic = lambda: 1e6 * clock()"
    for name, before in dict(slow=slow, fast="").items():
        script(*arguments, "--iterations", 300, "--out", tmp_path / name, before=before)
    assert not different(contents(tmp_path / "slow"), contents(tmp_path / "fast"))


def test_script_with_the_smooth_law(tmp_path):
    script(*SMALL, "--law", "smooth", "--stiffness", "300", "--out", tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["residual_max"] == summary["missed_fraction"] == 0
    assert 0 < summary["mean_overlap"] < 0.1
    rigid = Network.load(tmp_path / "out" / "isotropic.h5")  # before springs replace its contacts
    assert len(rigid.contacts["body1"]) > 30


def test_a_full_disk_leaves_complete_files(done):
    """A limit on the size of files acts as the full disk."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
    before, further = files(done), [*SMALL, "--strain", "0.02", "--resume", "--out", done]
    run = script(*further, preexec_fn=limit, code=1)
    assert "Traceback" not in run.stderr
    assert run.stderr.splitlines()[-1].startswith(f"biaxial.py: {done}")
    assert files(done) | {"run.json": before["run.json"]} == before
    script(*further)


def test_default_settings_solve_nearly_all_steps_of_a_slow_shear():
    """Contacts change before the velocity errors of a step add up to overlaps."""
    test = Biaxial.prepare(eta=0, particles=300, seed=1, **ONE_RATE)
    test.compact()
    test.solver.maxIterations = rcr.ContactDynamics().maxIterations
    before, start = test.solver.missedSteps, O.iter
    while not test.has_reached(0.01):
        test.shear_record()
    assert test.solver.missedSteps - before < 0.1 * (O.iter - start)
    assert test.solver.deepestOverlap < 5e-3
