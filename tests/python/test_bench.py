"""Benchmarks: their measures are right, and they write their columns on tiny problems."""

import dataclasses
import os
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from rcr import _kernel, problems
from rcr._data.files import read_table
from rcr.network import Network
from scipy.sparse import csc_array

import oracle
import synthetic
from common import answer, complaint, ended, python, refused
from problem_files import npz

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
from benchmarks import bench_solver, measure
from benchmarks import packing as packings
from benchmarks import points_of_sides, true_error


def lattice(count=25, seed=3):
    return problems.BodyProblem(**measure.lattice(count, seed))


def solved(problem, tolerance=1e-10):
    """The problem with its solution as warm start, and the kernels' report."""
    arrays = problem.arrays()
    found = _kernel.solve(**arrays, solver="exact", tolerance=tolerance, max_iterations=100000,
                          accuracy=np.inf)
    return problems.BodyProblem(**{**arrays, "impulse": found["impulse"]}), found


def residual(problem):
    return oracle.residual_of(problem.delassus(), problem.impulse)


# --- what is measured with

def test_residual_by_hand_and_by_the_kernels():
    """One contact, w = 2 along n and t, u = (−1, 0.3), µ = 0.5: p_n = 1/2, friction holds."""
    for tolerance in 1e-2, 1e-5, 1e-9:
        problem, found = solved(lattice(), tolerance)
        # rounding of W p
        assert residual(problem) == pytest.approx(found["residual"], rel=1e-5, abs=1e-13)

    def of(q, p, mu=0.5):
        return oracle.residual(csc_array(2 * np.eye(2)), np.array([q]), np.array([mu]),
                                np.array([p]))

    assert of((-1, 0.3), (0.5, -0.15)) < 1e-15
    # without friction impulse û = (0, 0.3); p − (û + µ|u_t| n)/w = (0.425, −0.15) is in the cone
    assert of((-1, 0.3), (0.5, 0)) == pytest.approx(np.hypot(0.075, 0.15) / 0.5)
    # the contact opens, also without friction and sliding
    assert of((1, -0.3), (0.0, 0)) == of((1, 0), (0.0, 0), mu=0.0) == 0


@pytest.mark.parametrize("times", [1, 2, 3])
def test_the_image_of_a_solution_solves_the_mirrored_problem(times):
    problem, _ = solved(lattice())
    before = residual(problem)
    mirrored = problem
    for _ in range(times):
        mirrored = measure.mirrored(mirrored, change=0)
    assert len(mirrored.inverse_mass) == 2**times * len(problem.inverse_mass)
    assert residual(mirrored) < 10 * before + 1e-14
    assert residual(measure.mirrored(problem)) > 1e-4  # other velocities, another solution
    problem.inverse_mass[-4:] = 1  # without walls
    refused("straight wall", measure.mirrored, problem)


def test_lattice_is_one():
    """Discs of diameter 1 touch their neighbours in shifted rows, and the walls."""
    side, problem = 5, lattice(25)
    row, column = np.divmod(np.arange(25), side)
    centre = np.column_stack([column + 0.5 * (row % 2), np.sqrt(0.75) * row])
    inner = (problem.bodies < 25).all(1)
    a, b = problem.bodies[inner].T
    assert inner.sum() == side * (side - 1) + (side - 1) * (2 * side - 1)
    np.testing.assert_allclose(problem.normal[inner], centre[b] - centre[a], atol=1e-14)
    assert (~inner).sum() == 2 * side + side // 2 + (side + 1) // 2


# --- benchmarks/true_error.py

def on_floor(mass, impulse):
    """Discs of radius 1 that touch a smooth floor (body 0), free velocity 1 m/s downwards."""
    count = len(mass)
    inverse = np.concatenate([np.zeros((1, 3)), np.tile(1 / np.array(mass)[:, None], 3)])
    zeros, vectors = np.zeros(count), np.zeros((count, 2))
    return problems.BodyProblem(
        inverse_mass=inverse, free_velocity=np.where(inverse > 0, [0, -1.0, 0], 0),
        bodies=np.column_stack([0 * zeros, 1 + np.arange(count)]).astype(int),
        normal=vectors + [0, 1], arm1=vectors, arm2=vectors + [0, -1], bias=zeros, friction=zeros,
        impulse=np.column_stack([impulse, zeros])).arrays()


def test_true_error_by_hand():
    """Impulses m v; errors of 0.1 N s at the masses 1 and 4 kg change v by 0.1 and 0.025 m/s."""
    problem = on_floor([1.0, 4.0], [1.1, 4.1])
    found = true_error.true_error(problem, problem["impulse"])
    assert found["velocities"] == pytest.approx(np.sqrt(0.1**2 + 4 * 0.025**2) / np.sqrt(1 + 4))
    assert found["forces"] == pytest.approx(np.sqrt(2 * 0.1**2) / np.sqrt(1 + 16))
    assert true_error.spread(problem)["velocities"] < 1e-9, "one solution"
    problem["free_velocity"] += [3.0, 0, 0]  # another frame
    assert true_error.true_error(problem, problem["impulse"]) == pytest.approx(found)


def test_cells_see_errors_of_one_sign_only():
    """Errors of opposite sign cancel in a cell that contains both grains."""
    problem = on_floor([1.0, 1.0, 1.0], [1.1, 0.9, 1.0])
    position = np.array([[0, 0], [0, 0], [2.0, 0], [8.0, 8.0]])
    cells = lambda: true_error.true_error(problem, problem["impulse"], position)
    assert cells()["cells_2"] < 1e-9 and cells()["cells_8"] == pytest.approx(np.sqrt(0.02 / 3))
    problem["impulse"][1, 0] = 1.1
    # momenta of the cells: 0.2 with the mass 2, and 2 and 1 in the solution
    assert cells()["cells_2"] == pytest.approx(np.sqrt(0.2**2 / 2 / (2**2 / 2 + 1)))


def test_spread_of_a_disc_that_friction_may_hold():
    """Between two rough walls the warm start is a solution that holds; from zero it falls."""
    problem = on_floor([1.0], [10.0]) | dict(friction=np.ones(2))
    for name in "bodies", "arm1":
        problem[name] = np.repeat(problem[name], 2, 0)
    problem["normal"] = np.array([[1.0, 0], [-1.0, 0]])
    problem["arm2"], problem["bias"] = -problem["normal"], np.zeros(2)
    problem["impulse"] = np.array([[10.0, 0.5], [10.0, -0.5]])  # t: upwards, downwards
    assert true_error.true_error(problem, problem["impulse"])["forces"] < 1e-9
    assert true_error.spread(problem)["forces"] == pytest.approx(1)


def test_impulses_without_a_reference_have_no_true_error(monkeypatch):
    """One iteration reaches no solution of a packing."""
    problem = problems.load(ROOT / "tests" / "data" / "shear-500-eta-0.7.npz").arrays()
    assert true_error.true_error(problem, problem["impulse"])["velocities"] > 1e-3
    monkeypatch.setitem(true_error.REFERENCE, "max_iterations", 1)
    assert true_error.true_error(problem, problem["impulse"]) == true_error.spread(problem) == {}


# --- scripts/bench_solver.py

def bench(script, *arguments, out, code=0):
    """A function of a table's name that returns its rows, or for the code None CompletedProcess."""
    done = ended(sys.executable, ROOT / "scripts" / script, *arguments, "--out", out, cwd="/",
                 code=code)
    return done if code is None else lambda table: read_table(out / f"{table}.csv", ())


FAST = ["--repeats", "1", "--budget", "0"]


@pytest.fixture
def files(tmp_path):
    problem, _ = solved(lattice())
    for name, given in dict(small=problem, larger=lattice(64)).items():
        np.savez(tmp_path / name, **npz(given.arrays()))
    problems.save_fclib(tmp_path / "small.h5", problem)
    return tmp_path


def test_bench_solver_writes_its_tables(files):
    names = [files / name for name in ("small.npz", "larger.npz", "small.h5")]
    tables = bench("bench_solver.py", *names, "--mirror", 1, "--warm", "--tolerances", "1e-3",
                   "1e-6", *FAST, out=files / "out")
    assert len(tables("sweeps")) == 4 * 2 * 3 * 2 + 2  # with bodies: solvers, lanes, threads
    rows = tables("tolerances")
    assert {row["problem"] for row in rows} == {"small", "small x2", "larger", "larger x2"}
    for row in rows:
        reported = float(row["residual"])
        assert float(row["residual_numpy"]) == pytest.approx(reported, rel=1e-5, abs=1e-13)
        assert (row["reached"] == "True") == (reported <= float(row["tolerance"]))
        assert float(row["seconds"]) > 0
    assert {(row["solver"], row["start"]) for row in rows if row["reached"] == "True"} >= {
        ("exact", "cold"), ("exact", "warm")}


def test_bench_solver_compares_with_siconos(files):
    found = (1e-3, 10, 2.0, 5e-4), (1e-6, 20, 4.0, 2e-6)
    rows = [dict(zip(("tolerance", "iterations", "seconds", "residual"), row)) for row in found]
    np.save(files / "found.npy", np.zeros((2, 71, 2)))
    siconos = answer(files / "answer", rows=rows, ns=100.0)
    siconos.write_text(siconos.read_text() + f"cp '{files / 'found.npy'}' \"$6\"\n")
    peers = bench("bench_solver.py", files / "small.npz", "--only", "tolerances", "--solvers",
                  "exact", "--tolerances", "1e-3", "1e-6", "--siconos", siconos, *FAST,
                  out=files / "out")("peers")
    assert [row["peer"] for row in peers] == ["Siconos NSGS"] * 2
    assert [row["reached"] for row in peers] == ["True", "False"]


def test_impulses_of_siconos_have_the_residual_that_it_prints(files):
    pytest.importorskip("siconos.numerics", reason="this Python has no Siconos")
    peers = bench("bench_solver.py", files / "small.npz", "--only", "tolerances", "--siconos",
                  sys.executable, *FAST, out=files / "out")("peers")
    assert all(row["reached"] == "True" for row in peers)


def test_bench_solver_compares_threads_with_siconos(files):
    """The first run of the other program that meets a tolerance makes the row."""
    solution = problems.load(files / "small.npz").delassus().impulse
    np.array([0 * solution, solution]).tofile(files / "runs")
    program = answer(files / "siconos_nsgs", iterations=[20, 40], seconds=[1.0, 2.0])
    program.write_text(program.read_text() + f"cp '{files / 'runs'}' \"$2\"\n")
    rows = bench("bench_solver.py", files / "small.npz", "--only", "parallel", "--solvers", "nlgs",
                 "--tolerances", "1e-2", "--peers", files, *FAST, out=files / "out")("parallel")
    assert [(row["program"], row["threads"]) for row in rows] == [
        ("rcr nlgs", "1"), ("Siconos NSGS", "1"), ("rcr nlgs", "2"), ("Siconos NSGS", "2")]
    assert all(float(row["residual"]) <= 1e-2 for row in rows)
    assert rows[1]["iterations"] == "40"


def test_siconos_reads_our_problems(files):
    problem = problems.load(files / "small.npz").delassus()
    (files / "small.dat").write_text(bench_solver.siconos_text(problem))
    read = problems.load(files / "small.dat")
    for name in "row_start", "column", "block", "q", "friction":
        np.testing.assert_allclose(getattr(read, name), getattr(problem, name), atol=1e-15)


@pytest.mark.parametrize("name, options, says", [
    ("none.npz", "", "none.npz"),
    ("small.npz", "--solvers best", "--solvers invalid choice: 'best'"),
    ("small.npz", "--tolerances 2", "--tolerances 2.0: expected numbers between 0 and 1"),
    ("small.npz", "--mirror -1", "--mirror -1: expected at least 0"),
    ("small.npz", "--threads 0", "--threads 0: expected at least 1"),
    ("small.npz", "--repeats 0", "--repeats 0: expected at least 1"),
    ("small.h5", "--only parallel", "small: problems of W and q are solved on one thread"),
    ("small.npz", "--siconos /none/python --only tolerances",
     "/none/python: No such file or directory"),
])
def test_bench_solver_reports_errors_in_a_line(files, name, options, says):
    done = bench("bench_solver.py", files / name, *FAST, *options.split(), out=files / "out",
                 code=None)
    assert says in complaint(done, beside="contact points")
    assert not list((files / "out").glob("*"))


# --- scripts/bench_step.py

@pytest.fixture
def packing(tmp_path):
    """Six moving discs of diameter 1, mass 1 in two rows between walls, under a stress of 1."""
    count, (j, i) = 6, np.divmod(np.arange(6), 3)
    half = np.full(count, 0.5)
    velocity = np.random.default_rng(1).normal(0, 0.05, (count, 3))
    grains = dict(id=np.arange(count), position=np.column_stack([i + 0.5, j + 0.5]), angle=0 * half,
                  R=half, cap_radius=half, half_length=0 * half, mass=2 * half, velocity=velocity)
    faces = (i == 0, -1, (-1, 0)), (j == 0, -2, (0, -1)), (i == 2, -3, (1, 0)), (j == 1, -4, (0, 1))
    rows = [(k, k + 1, 0, (1, 0), 1) for k in (0, 1, 3, 4)]
    rows += [(k, wall, 3, n, 0.5) for at, wall, n in faces for k in np.flatnonzero(at)]
    one, two, kind, normal, length = map(np.array, zip(*rows))
    contacts = dict(body1=one, body2=two, type=kind, normal=normal, branch=length[:, None] * normal,
                    force=normal, position=grains["position"][one] + 0.5 * normal,
                    points=np.ones(len(rows), int))
    Network(grains, contacts, dict(volume=6.0, dt=0.01)).save(tmp_path / "six.h5")
    return tmp_path / "six.h5"


def test_packing_and_its_contacts(packing):
    six = packings.load(str(packing))
    assert (six.grains, six.shape, six.dt) == (6, "discs", 0.01)
    np.testing.assert_allclose(six.force[6:], [[2, 0], [0, 0], [-2, 0], [0, 0]], atol=1e-12)
    problem = six.problem(friction=0.5, alert=1e-3)
    assert problem.contacts == 7 + 10  # between discs; each of two rows touches the walls
    np.testing.assert_allclose(problem.bias, 0, atol=1e-10)
    at_walls = (problem.bodies >= 6).any(1)
    assert at_walls.sum() == 10 and (problem.friction == np.where(at_walls, 0, 0.5)).all()
    table = six.table(skin=1e-3)
    assert table.shape == (10, len(packings.COLUMNS))
    np.testing.assert_allclose(table[:6, 4], 0.501)


def test_bench_step_writes_its_table(packing, tmp_path):
    """A script stands for another library: disc 0 falls on the floor and stops, which is exact."""
    contact = [7, 0, 0, 1, 0.5, 0, 0, -0.5, 0.0, 1.0, 0.0, -0.003]
    before, after = np.zeros((10, 3)), np.zeros((10, 3))
    before[0, 1] = -1
    after[[6, 8], 0] = 0.01 * 2 / np.sqrt(6) * np.array([1, -1])  # pushed: dt, force, mass
    for name in "chipmunk", "box2d", "box2d_v3":
        answer(tmp_path / f"{name}_step", library="Other 1", seconds=[1e-3] * 20,
               contacts=[contact], before=before.tolist(), after=after.tolist())
    ours, others = [], []
    for row in bench("bench_step.py", packing, "--peers", tmp_path, "--repeats", 1,
                     out=tmp_path / "out")("step"):
        (ours if row["library"].startswith("rcr") else others).append(row)
    assert [row["library"] for row in ours] == ["rcr nlgs", "rcr nesterov"] and len(others) == 6
    for row in others:
        assert float(row["residual"]) < 1e-15 and float(row["velocity_error"]) < 1e-15
        assert float(row["velocities"]) < 1e-9 and float(row["forces"]) < 1e-9
        assert float(row["mean_overlap"]) == pytest.approx(0.003 - 0.001) and row["points"] == "1"


@pytest.mark.parametrize("name, library, iterations, rounding, residual", [
    ("chipmunk", "Chipmunk", 2000, 1e-12, 1e-11), ("box2d", "Box2D 2", 2000, 1e-4, 1e-3),
    ("box2d_v3", "Box2D 3", 1, 1e-4, 1),  # soft contacts
])
def test_other_libraries_obey_their_own_impulses(packing, tmp_path, name, library, iterations,
                                                 rounding, residual):
    """Velocities of a library follow from its impulses, and many iterations satisfy its laws."""
    program = ROOT / "build" / "peers" / f"{name}_step"
    if not program.exists():
        pytest.skip(f"{program.name} is not built")
    rows = bench("bench_step.py", packing, "--iterations", iterations, "--repeats", 1,
                 out=tmp_path / "out")("step")
    cold, warm = (row for row in rows if row["library"].startswith(library))
    for row in cold, warm:
        assert float(row["velocity_error"]) < rounding and float(row["residual"]) < residual
        assert float(row["velocities"]) < max(10 * residual, 1e-7)  # `exact` ends at 1e-9
    assert name == "box2d_v3" or int(cold["points"]) == 17


@pytest.mark.parametrize("name, options, says", [
    ("none.h5", "", "none.h5"),
    ("six.txt", "", "expected a network .h5"),
    (".", "", "a checkpoint needs YADE"),
    ("six.h5", "--iterations 0", "--iterations 0: expected at least 1"),
    ("six.h5", "--steps 0", "--steps 0: expected at least 1"),
    ("six.h5", "--friction -1", "--friction -1.0: expected a coefficient ≥ 0"),
])
def test_bench_step_reports_errors_in_a_line(packing, tmp_path, name, options, says):
    (tmp_path / "six.txt").write_text("1 2 3\n")
    done = bench("bench_step.py", tmp_path / name, "--repeats", 1, *options.split(),
                 out=tmp_path / "out", code=None)
    assert says in complaint(done, beside="is left out")


# --- benchmarks/outside.py

def test_commands_run_outside_through_pipes():
    """A server at the other end of two pipes executes the commands after `stay`."""
    script = f"""
import os, sys
sys.path.insert(0, {str(ROOT)!r})
from benchmarks import outside
outside.stay()
os.write(outside.pipes()[1], b'0 ["echo", "of a process that has ended"]\\n')
print(outside.run(["echo", "a b", "ü"]), end="")
for command in ["/none/program"], ["sh", "-c", "echo first; echo why >&2; exit 3"]:
    try:
        outside.run(command)
    except RuntimeError as error:
        print(error)
"""
    done = python(script, env={**os.environ, "PYTHONIOENCODING": "utf-8"})
    expected = ["a b ü", "/none/program: No such file or directory", "sh: why"]
    assert done.stdout.splitlines() == expected, done.stderr


# --- benchmarks/charts

def test_charts_compact_again_under_another_protocol(tmp_path, monkeypatch):
    """A packing is reused as long as the protocol is the same."""
    pytest.importorskip("yade", reason="charts of the biaxial test need YADE")
    from benchmarks import charts
    from benchmarks.charts import biaxial_cost

    fake = mock.Mock()  # a checkpoint is an empty file
    fake.load, test = Path, fake.prepare.return_value
    test.save = lambda folder: (Path(folder) / "checkpoint.yade.gz").touch()
    monkeypatch.setattr(biaxial_cost, "Biaxial", fake)
    options = charts.Options(str(tmp_path), True, 50, "", "", 60)
    first, again = (biaxial_cost.compacted(0.5, 1, options) for _ in range(2))
    assert first == again and test.compact.call_count == 1
    changed = dataclasses.replace(charts.PROTOCOL, balance_tolerance=1e-3)
    monkeypatch.setattr(charts, "PROTOCOL", changed)
    assert biaxial_cost.compacted(0.5, 1, options) != first and test.compact.call_count == 2


def sides(force=8.0):
    """Two rods whose sides touch; the force acts at 3/4 of the shadow, from x = −0.4 to 1."""
    found = synthetic.network(np.array([np.pi / 2]), np.array([[1.0, -0.6]]),
                              np.array([[force, 0.0]]), points=np.array([2]),
                              type=np.array([2]), position=np.array([[0.65, 0.5]]))
    found.particles["position"][1] = (0.6, 1.0)
    found.particles["half_length"][:] = 1.0
    found.attributes["eta"] = 0.5
    return found


def test_force_of_two_sides_splits_between_the_ends_of_the_shadow():
    assert points_of_sides.share_of_first_end(sides()) == pytest.approx([0.75])
    pair, ends, four = (points_of_sides.contacts(sides(), points)[0] for points in (1, 2, 4))
    assert pair == pytest.approx([1.0])  # over the mean force of the pairs
    assert ends == pytest.approx([0.75, 0.25])
    assert four == pytest.approx([0.375, 0.125, 0.375, 0.125])


def test_branch_anisotropy_follows_the_cutoff():
    """Two contacts along σ1, the weak one with the short branch: −1/2 between their forces."""
    xi = points_of_sides.XI
    found = points_of_sides.xi_networks_of(np.array([0.5, 1.5]), np.array([1.0, 3.0]),
                                           np.zeros(2)).anisotropies(xi)[1]
    assert found == pytest.approx(np.where((xi > 0.499) & (xi < 1.499), -0.5, 0))
