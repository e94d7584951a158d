"""Problems from files: they load as written, solutions obey the laws, errors name bad files.

Residuals are recomputed with NumPy from the written reactions on the dense W and q.
"""

import contextlib
import json
import math
import sys
from pathlib import Path

import h5py
import hypothesis
import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import strategies as st
from common import complaint, ended, refused
from damage import put, replace
from oracle import matrix, residual, residual_of
from problem_files import write, write_siconos
from rcr import _kernel, problems, solve

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
# files of Siconos' collection, if present beside the repository
SICONOS = sorted((ROOT.parent / "shared" / "data").glob("*.dat"))
PACKINGS = [DATA / f"shear-500-eta-{eta}.npz" for eta in ("0", "0.7")]


@pytest.fixture
def files(step, tmp_path):
    for name in FILES:
        write(tmp_path / name, step)
    return tmp_path


FILES = ["step.npz", "columns.h5", "rows.h5", "triplets.h5", "dense.dat", "blocks.dat",
         "columns.dat", "triplets.dat"]


@pytest.mark.parametrize("name", FILES)
def test_reading_returns_the_written_data(files, step, name):
    arrays, w, q = step
    problem = problems.load(files / name)
    if name == "step.npz":
        problem = problem.delassus()
    read = matrix(problem).toarray()
    np.testing.assert_allclose(read, w, rtol=0, atol=1e-15 * abs(w).max())  # sums of six terms
    np.testing.assert_allclose(problem.q, q, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(problem.friction, arrays["mu"])


@pytest.mark.parametrize("name", ["step.npz", "columns.h5", "blocks.dat"])
def test_every_solver_satisfies_the_laws(files, step, name, solver):
    arrays, w, q = step
    tolerance = 1e-10 if solver in ("exact", "auto") else 1e-5
    found = solve(files / name, solver, tolerance, 20000)
    recomputed = residual(w, q, arrays["mu"], found.reaction)
    assert found.converged and recomputed <= tolerance * (1 + 1e-6)
    # rounding of the sums in u: 1e-16 of the impulses
    assert recomputed == pytest.approx(found.residual, rel=1e-6, abs=1e-14)
    u = (w @ found.reaction.ravel()).reshape(-1, 2) + q
    if name == "step.npz":
        u[:, 0] -= arrays["bn"]
    np.testing.assert_allclose(found.velocity, u, rtol=0, atol=1e-13)
    assert found.contacts == len(arrays["a"]) and found.seconds > 0


def test_settings_and_warm_starts(files):
    for name in ("step.npz", "rows.h5"):
        assert solve(files / name, "nlgs", 0, 37).iterations == 37
        short = solve(files / name, "exact", 1e-12, 7)
        assert not short.converged and short.iterations <= 7 and short.residual > 1e-12
        for bad, says in (({"solver": "newton"}, "newton"), ({"tolerance": -1}, "tolerance = -1"),
                          ({"max_iterations": 0}, "max_iterations = 0")):
            refused(says, solve, files / name, **bad)
    problem = problems.load(files / "step.npz")
    problem.impulse = solve(problem, "exact", 1e-9).reaction
    problems.save_fclib(files / "warm.h5", problem)
    for again in (problem, files / "warm.h5"):
        assert solve(again, "nesterov", 1e-6, warm=True).iterations == 0
        assert solve(again, "nesterov", 1e-6).iterations > 0


def test_save_fclib_round_trip(files):
    body = problems.load(files / "step.npz")
    for problem in (body, body.delassus()):
        problems.save_fclib(files / "saved.h5", problem)
        read = problems.load(files / "saved.h5")
        for name in ("row_start", "column", "block", "q", "friction", "impulse"):
            np.testing.assert_array_equal(getattr(read, name), getattr(body.delassus(), name),
                                          err_msg=name)
    with h5py.File(files / "saved.h5") as file:  # fields that fclib.h reads
        group = file["fclib_local"]
        assert group["spacedim"][()] == [2] and group["W/nz"][()] == [-2]
        assert group["W/p"].dtype == np.int32
        assert group["W/x"].shape == group["W/i"].shape == tuple(group["W/nzmax"][()])


def test_impulses_do_not_depend_on_the_order_of_contacts(solver):
    """A contact is a pair of bodies; its points keep their order."""
    problem = problems.load(PACKINGS[1])
    pair = np.unique(problem.bodies, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(np.random.default_rng(10).permutation(len(pair))[pair], kind="stable")
    arrays = {name: value if name in ("inverse_mass", "free_velocity") else value[order]
              for name, value in vars(problem).items()}
    settings = dict(solver=solver, max_iterations=100)
    shuffled = solve(problems.BodyProblem(**arrays), **settings).reaction
    np.testing.assert_array_equal(shuffled, solve(problem, **settings).reaction[order])


def test_a_contact_that_no_impulse_can_open_does_not_converge(solver, tmp_path):
    """W_nn = 0: the residual omits the contact. No contacts converge."""
    write_siconos(tmp_path / "none.dat", np.zeros((0, 0)), np.zeros((0, 2)), np.zeros(0), "dense")
    found = solve(tmp_path / "none.dat", solver)
    assert found.contacts == 0 and found.residual == 0 and found.converged
    assert not solve(problems.DelassusProblem(([0], [0], [0.0]), [-1, 0], [0.5]), solver).converged
    assert solve(problems.DelassusProblem(([0], [0], [0.0]), [1, 0], [0.5]), solver).converged
    for bias in (-1, 1):  # the second body moves along x only, the normal is y
        bodies = problems.BodyProblem([[0, 0, 0], [1, 0, 0]], np.zeros((2, 3)), [[0, 1]], [[0, 1]],
                                      [[0, 0]], [[0, 0]], [bias], [0.5], [[0, 0]])
        assert solve(bodies, solver).converged == (bias > 0)


SQUEEZED = [  # a disc between two points that close: u_n1 + u_n2 = −2 for all impulses
    problems.DelassusProblem(
        ([0, 0, 2, 2, 1, 3], [0, 2, 0, 2, 1, 3], [1.0, -1, -1, 1, 1, 1]), [-1, 0, -1, 0], [0, 0]),
    problems.BodyProblem(
        [[1, 1, 1], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [1, 0, 0], [-1, 0, 0]], [[1, 0], [2, 0]],
        [[1, 0], [-1, 0]], np.zeros((2, 2)), np.zeros((2, 2)), [0, 0], [0.5, 0.5],
        np.zeros((2, 2))),
    DATA / "wedge_without_solution.npz",
]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
@pytest.mark.parametrize("problem", SQUEEZED, ids=["W and q", "bodies", "wedge"])
def test_a_problem_without_a_solution_does_not_converge(problem, tolerance, solver):
    """Its impulses grow, and with them the scale of the residual."""
    assert not solve(problem, solver, tolerance=tolerance, max_iterations=100_000).converged


def test_numbers_whose_squares_vanish_are_refused():
    small, smaller = (problems.DelassusProblem(([0, 1], [0, 1], [1.0, 1.0]), [-size, 0], [0.5])
                      for size in (1e-90, 1e-101))
    assert solve(small, "exact").reaction[0] == pytest.approx([1e-90, 0], rel=1e-4)
    refused("the largest velocity is 1e-101; expected at least 1e-100", solve, smaller)


# --- malformed files

def assert_refused(path, says):
    """One line names the file and says what is wrong."""
    error = refused(says, solve, path)
    assert f"{path.name}: " in error and "\n" not in error


@pytest.mark.parametrize("name, change, says", [
    ("mu", None, r"lacks mu; expected the arrays a, b"),
    ("mu", put(3, -0.1), r"mu\[3\] = -0.1; expected µ ≥ 0"),
    ("mu", lambda a: a[:-1], r"mu has shape \(\d+,\); expected \(\d+,\)"),
    ("vfree", put((2, 1), np.nan), r"vfree\[2, 1\] = nan; expected finite"),
    ("a", put(0, 999), r"a\[0\] = 999; expected whole numbers from 0 to 33"),
    ("b", put(1, -1), r"b\[1\] = -1"),
    ("im", put(4, -1.0), r"inverse_mass\[4, 0\] = -1; expected ≥ 0"),
    ("n", put(5, 2.0), r"the length of normal\[5\] = 2.8"),
    ("n", lambda a: np.array([["x"]]), r"n does not hold numbers"),
    ("meta", put(2, 1000.0), r"meta\[2\] = 1000; expected the number of grains"),
    ("b", lambda b: np.append(b[-1], b[:-1]), "expected two different bodies"),
])
def test_refuses_npz(step, tmp_path, name, change, says):
    arrays = dict(step[0])
    array = arrays.pop(name)
    np.savez(tmp_path / "bad.npz", **arrays, **({name: change(array)} if change else {}))
    assert_refused(tmp_path / "bad.npz", says)


@pytest.mark.parametrize("change, says", [
    *((lambda group, name=name: group.pop(name), f"fclib_local lacks {name}")
      for name in ("W/x", "spacedim", "vectors/mu")),
    (replace("spacedim", np.array([3])), "spacedim = 3; expected 2"),
    (replace("W/m", np.array([7])), r"W is 7 × \d+"),
    (replace("W/nz", np.array([-5])), "W/nz = -5; expected −1"),
    (replace("W/p", lambda p: p[:-1]), r"W/p is not \d+ ascending pointers"),
    (replace("W/p", lambda p: p[::-1]), r"W/p is not \d+ ascending pointers"),
    (replace("W/p", put(-1, 10**6)), r"W/p is not \d+ ascending pointers"),
    (replace("W/i", put(2, 10**6)), r"a row of W\[2\] = 1e\+06"),
    (replace("W/x", put(2, np.inf)), r"W\[2\] = inf; expected finite"),
    (replace("W/x", lambda x: -x), r"the diagonal of W\[\d+\] = -.*positive semi-definite"),
    (replace("W/x", put(1, 123.0)), r"W is not symmetric: W\["),
    (replace("vectors/q", lambda q: q[:-2]), r"q has shape"),
    (replace("vectors/q", put(0, np.nan)), r"q\[0, 0\] = nan"),
    (replace("vectors/mu", put(2, -1.0)), r"mu\[2\] = -1; expected µ ≥ 0"),
    (lambda group: group.create_group("V"), "equality constraints"),
    (lambda group: group.file.move("fclib_local", "fclib_global"),
     "no group fclib_local but fclib_global"),
])
def test_refuses_fclib(step, tmp_path, change, says):
    assert_refused(write(tmp_path / "columns.h5", step, change), says)


def test_asymmetry_of_rounded_files_is_accepted(step, tmp_path):
    """Files of Siconos are asymmetric by 1e-10 of the largest entry; 1e-7 is refused."""
    arrays, w, q = step
    off, path = w.copy(), tmp_path / "columns.h5"
    off[0, 1] = w[0, 1] + 1e-10 * abs(w).max()
    found = solve(write(path, (arrays, off, q)), "exact", 1e-9)
    assert residual(off, q, arrays["mu"], found.reaction) < 1e-9 * 1.001
    off[0, 1] = w[0, 1] + 1e-7 * abs(w).max()
    assert_refused(write(path, (arrays, off, q)), "not symmetric")


@pytest.mark.parametrize("old, new, says", [
    ("2\n", "3\n", "dimension = 3; expected 2"),
    ("CSparse", "CSparse 1 : x\nCSparse", "not a line of a sparse matrix"),
    ("nnz: ", "nnz: 1", "its header says 1"),
    ("      0 : ", "      x : ", "line 10 is not a line of a sparse matrix"),
    ("      0 : ", "      0 : nan ", r"W\[0\] = nan; expected finite"),
    ("col 0 ", "col y ", "not a line of a sparse matrix"),
    (" 2.99999999999999989e-01 ", " 0.3x ", "mu holds a word that is not a number"),
    (" 2.99999999999999989e-01 ", " -0.5 ", r"mu\[\d+\] = -0.5; expected µ ≥ 0"),
])
def test_refuses_siconos(step, tmp_path, old, new, says):
    path = write(tmp_path / "columns.dat", step)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert_refused(path, says)


@pytest.mark.parametrize("storage", ["dense", "blocks", "columns", "triplets"])
def test_refuses_any_siconos_file_that_ends_early(step, tmp_path, storage):
    path = write(tmp_path / f"{storage}.dat", step)
    lines = path.read_text().splitlines()
    for keep in np.linspace(0, len(lines) - 1, 15).astype(int):
        path.write_text("\n".join(lines[:keep]))
        assert_refused(path, "")


def test_refuses_other_files(tmp_path):
    for name in ("x.npz", "x.h5", "x.dat"):
        (tmp_path / name).write_text("what is this\n")
        assert_refused(tmp_path / name, "")
    refused("unknown suffix '.mat'; expected one of .npz, .h5, .hdf5, .dat", solve,
            tmp_path / "x.mat")


# --- the script

def run(*arguments, folder="/", code=0):
    return ended(sys.executable, ROOT / "scripts" / "solve.py", *arguments, cwd=folder, code=code)


@pytest.mark.parametrize("name", ["step.npz", "columns.h5", "columns.dat"])
@pytest.mark.parametrize("out", ["found.npz", "found.h5"])
def test_script(files, step, name, out):
    arrays, w, q = step
    done = run(files / name, "--solver", "nesterov", "--tolerance", "1e-5", "--max-iterations",
               "5000", "--out", files / out)
    assert done.stderr == ""
    report = json.loads(done.stdout)
    assert list(report) == ["solver", "contacts", "iterations", "residual", "converged", "seconds"]
    assert report["converged"] is True
    with np.load(files / out) if out.endswith("npz") else h5py.File(files / out) as file:
        reaction, velocity = np.array(file["reaction"]), np.array(file["velocity"])
    assert residual(w, q, arrays["mu"], reaction) == pytest.approx(report["residual"], rel=1e-6)
    assert velocity.shape == reaction.shape == (report["contacts"], 2)
    warm = json.loads(run(files / name, "--solver", "nlgs", "--tolerance", "0", "--max-iterations",
                          "3", "--warm", "--out", files / out).stdout)
    assert warm["iterations"] == 3 and run("--help").stdout


@pytest.mark.parametrize("arguments, says", [
    ("none.npz --out o.npz", "none.npz"),
    ("step.npz --out o.txt", "unknown suffix '.txt'"),
    ("step.npz --out step.npz", "this is the problem itself"),
    ("step.npz --out link.npz", "this is the problem itself"),
    ("step.npz --out folder.npz", "is a folder"),
    ("step.npz --out none/o.npz", "this folder does not exist"),
    ("step.npz --out=", "--out '': expected a path"),
    (". --out o.npz", "unknown suffix"),
    ("folder.npz --out o.npz", "Is a directory"),
    ("step.npz --out o.npz --solver best", "solver = 'best'; expected one of"),
    ("step.npz --out o.npz --tolerance -1", "tolerance = -1"),
    ("step.npz --out o.npz --tolerance nan", "--tolerance nan: expected a finite number"),
    (f"step.npz --out o.npz --max-iterations {'9' * 30}", "--max-iterations 999"),
    (f"step.npz --out o.npz --max-iterations {2**31}", "max_iterations = 2147483648"),
    ("step.npz --out o.npz --max-iterations 1.5",
     "--max-iterations '1.5': expected a whole number"),
])
def test_script_refuses_in_a_line_and_loses_nothing(files, arguments, says):
    """The output never overwrites the problem, by whatever name; a failed solve leaves no file."""
    (files / "link.npz").symlink_to("step.npz")
    (files / "folder.npz").mkdir()
    names, before = sorted(files.iterdir()), (files / "step.npz").read_bytes()
    assert says in complaint(run(*arguments.split(), folder=files, code=None))
    assert sorted(files.iterdir()) == names and (files / "step.npz").read_bytes() == before


def test_numbers_beyond_doubles_are_no_result(files, step):
    """JSON has no number for a residual that is not finite."""
    arrays = dict(step[0], im=step[0]["im"] * 1e300, vfree=step[0]["vfree"] * 1e300)
    np.savez(files / "huge.npz", **arrays)
    done = run(files / "huge.npz", "--solver", "nlgs", "--out", files / "o.npz", code=None)
    assert "not finite" in complaint(done)
    assert not (files / "o.npz").exists()


# --- values from Python: they give a finite result, or one ValueError of one line

@contextlib.contextmanager
def errors_of_one_line():
    try:
        yield
    except ValueError as error:
        assert "\n" not in str(error)


SCALARS = st.one_of(
    st.floats(), st.integers(), st.booleans(), st.none(), st.text(max_size=3), st.complex_numbers(),
    st.sampled_from([5e-324, 1e308, -0.0, 2**31, 2**63, 2**70]))


def one_contact(**changes):
    return dict(inverse_mass=[[1.0, 1, 8], [0, 0, 0]], free_velocity=[[0.1, -0.1, 0.3], [0, 0, 0]],
                bodies=[[0, 1]], normal=[[0.0, -1]], arm1=[[0.1, -0.5]], arm2=[[0.0, 0]],
                bias=[0.0], friction=[0.5], impulse=[[0.0, 0]]) | changes


@hypothesis.given(tolerance=SCALARS, max_iterations=SCALARS,
                  solver=st.one_of(SCALARS, st.sampled_from(_kernel.solver_names())))
def test_settings_are_checked(tolerance, max_iterations, solver):
    # a tolerance of 0 runs all iterations
    hypothesis.assume(not (isinstance(max_iterations, int) and max_iterations > 10**4
                           and tolerance == 0))
    with errors_of_one_line():
        found = solve(problems.BodyProblem(**one_contact()), solver, tolerance, max_iterations)
        assert found.residual >= 0 and np.isfinite(found.reaction).all()


@hypothesis.given(
    name=st.sampled_from(list(one_contact())),
    value=st.one_of(SCALARS, st.lists(SCALARS, max_size=4),
                    st.lists(st.lists(SCALARS, min_size=2, max_size=3), max_size=3),
                    hnp.arrays(hnp.scalar_dtypes(), hnp.array_shapes(max_dims=3, max_side=3))),
)
def test_arrays_of_a_problem_are_checked(name, value):
    with errors_of_one_line():
        problem = problems.BodyProblem(**one_contact(**{name: value}))
        assert all(np.isfinite(array).all() for array in vars(problem).values())
        solve(problem, "nlgs", 1e-4, 10)


@hypothesis.given(
    entries=st.one_of(SCALARS, st.tuples(*[st.lists(SCALARS, max_size=3)] * 3),
                      st.lists(SCALARS, max_size=3)),
    q=st.one_of(SCALARS, st.lists(SCALARS, max_size=4)),
    friction=st.one_of(SCALARS, st.lists(SCALARS, max_size=2)),
    impulse=st.one_of(st.none(), SCALARS, st.lists(SCALARS, max_size=4)),
)
def test_w_and_q_are_checked(entries, q, friction, impulse):
    with errors_of_one_line():
        problem = problems.DelassusProblem(entries, q, friction, impulse)
        assert np.isfinite(problem.block).all() and np.isfinite(problem.q).all()


def test_pairs_of_another_shape_are_not_shuffled():
    """Rows of n and of t, as (2, nc), are no pairs; (nc, 2) and (2 nc,) are."""
    make = lambda q, p: problems.DelassusProblem(([0], [0], [1.0]), q, [0.5] * 3, p)
    pairs = np.arange(6.0).reshape(3, 2)
    for given in pairs, pairs.ravel():
        problem = make(given, given)
        assert (problem.q == pairs).all() and (problem.impulse == pairs).all()
    for shape in (2, 3), (6, 1), (1, 3, 2):
        other = pairs.reshape(shape)
        for name, arrays in (("q", (other, pairs)), ("the warm start", (pairs, other))):
            refused(rf"{name} has shape \({shape[0]}.*\); expected \(3, 2\)", make, *arrays)


def test_imaginary_parts_are_not_lost():
    for name in ("friction", "bias", "normal"):
        refused(f"{name} does not hold numbers, but complex ones", problems.BodyProblem,
                **one_contact(**{name: np.array(one_contact()[name]) + 1j}))
    refused("mu does not hold numbers, but complex", problems.DelassusProblem,
            ([0], [0], [1.0]), [[1.0, 0]], [0.5 + 0j])


# --- problems of others

@pytest.mark.parametrize("solver, tolerance",
                         [("nesterov", 1e-4), ("auto", 1e-8), ("exact", 1e-10)])
@pytest.mark.parametrize("path", [*PACKINGS, *SICONOS], ids=lambda path: path.name)
def test_stored_problems(path, solver, tolerance):
    problem = problems.load(path)
    found = solve(problem, solver, tolerance, 20000)
    recomputed = residual_of(problem.delassus() if path in PACKINGS else problem, found.reaction)
    # rounding: q is about 1e3 times the remaining velocities
    assert found.converged and recomputed <= tolerance + 1e-12
    assert recomputed == pytest.approx(found.residual, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("path, tolerance", zip(PACKINGS, (1e-9, 1e-6)),
                         ids=lambda value: getattr(value, "name", None))
def test_stored_problems_without_their_bodies(path, tolerance):
    """With bodies the stored steps reach 1e-10; without bodies the last one stalls at 2e-7."""
    found = solve(problems.load(path).delassus(), "exact", tolerance, 20000)
    assert found.converged and found.residual <= tolerance


def test_an_infeasible_row_does_not_converge(solver):
    """Every contact of a row of 100 discs between fixed walls should open at 1 m/s."""
    discs = 100
    contacts, row = discs + 1, np.arange(discs + 1)
    masses = np.ones((discs + 2, 3))
    masses[[0, -1]] = 0
    problem = problems.BodyProblem(
        masses, 0 * masses, np.column_stack([row, row + 1]), np.tile([1.0, 0], (contacts, 1)),
        np.zeros((contacts, 2)), np.zeros((contacts, 2)), -np.ones(contacts), np.zeros(contacts),
        np.zeros((contacts, 2)))
    assert not solve(problem, solver).converged


@pytest.mark.parametrize("bodies", [True, False], ids=["bodies", "W and q"])
def test_what_no_impulse_moves_slides_on(bodies, solver):
    """A rail along y, blocked along the normal up to rounding; and two walls that overlap."""
    normal = [[math.cos(math.pi / 2), 1.0], [0.0, 1.0]]
    problem = problems.BodyProblem(
        [[0, 0, 0], [1, 0, 0], [0, 0, 0]], [[0, 0, 0], [0.05, 0, 0], [0, -1, 0]], [[0, 1], [0, 2]],
        normal, np.zeros((2, 2)), np.zeros((2, 2)), [0, 0], [0.5, 0.5], np.zeros((2, 2)))
    found = solve(problem if bodies else problem.delassus(), solver)
    assert found.converged and not found.reaction.any()


def test_arrays_that_were_set_later_are_checked():
    changed = problems.load(PACKINGS[0])
    changed.friction = np.concatenate([[0.9], changed.friction])
    refused("friction has shape", solve, changed, "nlgs")
    refused("friction has shape", changed.delassus)


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "auto"])
def test_a_tolerance_of_zero_runs_all_iterations(solver):
    assert solve(PACKINGS[0], solver, 0, 700).iterations == 700
