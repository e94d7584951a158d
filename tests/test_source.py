"""Sources: short files, lines of at most 100 columns, and kernels free of YADE and Python."""

import ast
import collections
import pathlib
import re
import shutil
import sys

import pytest
from common import ended

ROOT = pathlib.Path(__file__).resolve().parents[1]
PKG = ROOT / "pkg"
CODE = sorted(path for path in PKG.rglob("*") if path.suffix in (".cpp", ".hpp"))
MODULES = sorted((ROOT / "py" / "rcr").rglob("*.py"))
OUTSIDE = re.compile(
    r'#include\s+[<"](core/|lib/|pkg/|boost/|pybind11/|Python\.h|numpy/|dem/|python/)')
COLUMNS, SHARE = 100, 0.01
SUFFIXES = {".py", ".cpp", ".hpp", ".sh", ".md"}
UNWRAPPED = ("pkg/dem/", "benchmarks/peers/")  # macros of classes and peers: counted as a whole


def lines(path):
    return path.read_text().splitlines()


@pytest.mark.parametrize("path", [*CODE, *MODULES], ids=lambda path: str(path.relative_to(ROOT)))
def test_file_is_short(path):
    """At most 350 lines, and 60 lines per function of Python."""
    assert len(lines(path)) <= 350
    tree = ast.parse(path.read_text() if path.suffix == ".py" else "")
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    assert [f.name for f in functions if f.end_lineno - f.lineno >= 60] == []


def test_the_engine_reads_as_the_algorithm():
    assert len(lines(PKG / "dem" / "engine" / "ContactDynamics.cpp")) < 200


def test_kernels_stand_alone():
    kernels = [path for path in CODE if PKG / "kernel" in path.parents]
    assert len(kernels) > 50
    assert not [(path.name, line) for path in kernels for line in lines(path)
                if OUTSIDE.match(line)]


def includes_of_folders():
    """(file, its folder, included folder) of each include of `pkg`."""
    files = {str(path.relative_to(PKG)) for path in CODE}
    for name in sorted(files):
        folder = name.rpartition("/")[0]
        for other in re.findall(r'#include "([^"]+)"', (PKG / name).read_text()):
            # bindings include headers of the kernel by their paths below it
            (found,) = files & {other, f"kernel/{other}", f"{folder}/{other}"}
            yield name, folder, found.rpartition("/")[0]


def test_folders_of_pkg_include_each_other_in_no_circle():
    """A folder includes only folders above it in the table of pkg/README.md."""
    table = re.search(r"^## Layers\n(.*?)^## ", (PKG / "README.md").read_text(), re.M | re.S)[1]
    folders = re.findall(r"^\| `(\S+)` \|", table, re.M)
    assert sorted(folders) == sorted({str(path.parent.relative_to(PKG)) for path in CODE})
    assert [(name, other) for name, folder, other in includes_of_folders()
            if folders.index(other) > folders.index(folder)] == []


def test_headers_of_yade_are_included_in_one_file():
    """An included header that yadeHeaders.hpp lacks would make factories of YADE's classes."""
    including = {path.name for path in CODE for line in lines(path)
                 if re.match(r"#include <(core|lib|pkg)/", line)}
    assert including == {"yadeHeaders.hpp"}


def test_each_type_has_a_name_of_its_own():
    """The linker keeps one of two templates of a name, so two types `Pair` corrupt vectors."""
    names = [found[2] for path in CODE for line in lines(path)
             if (found := re.match(r"(struct|class|enum class) (?:alignas\([^)]*\) )?(\w+)\b[^;]*$",
                                   line))]
    assert len(names) > 60
    assert not [name for name, times in collections.Counter(names).items() if times > 1]


def constant(file, name):
    """Return a constant of a Python file, which is not imported."""
    return next(ast.literal_eval(node.value)
                for node in ast.parse((ROOT / file).read_text()).body
                if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == name)


def test_each_mutant_has_one_place():
    """`scripts/check mutants` finds the places of its mistakes by their text."""
    table = constant("scripts/lib/mutants.py", "TABLE")
    mistakes = [(file, name, before) for file, mistakes in table.items()
                for name, before, _ in mistakes]
    assert len(mistakes) > 70
    assert [(file, name) for file, name, before in mistakes
            if (PKG / "kernel" / file).read_text().count(before) != 1] == []


def test_checks_leave_out_tests_that_exist():
    """A renamed test would run under a sanitizer that cannot serve it."""
    tests = "".join(map(pathlib.Path.read_text, (ROOT / "tests/kernel").rglob("test_*.py")))
    for name in sum(constant("scripts/lib/check.py", "LEFT_OUT").values(), []):
        assert re.search(rf"def test_\w*{name}", tests), name


def tracked():
    """Names of the tracked files of these suffixes; none without git or outside a clone."""
    if not shutil.which("git"):
        return []
    names = ended("git", "-C", ROOT, "ls-files", code=None).stdout.splitlines()
    return [name for name in names if pathlib.Path(name).suffix in SUFFIXES]


def wide_lines(text):
    """(number, columns) of each wide line except tables and addresses; a tab has 4 columns."""
    for number, line in enumerate(text.split("\n"), 1):
        columns = len(line.expandtabs(4))
        if columns > COLUMNS and not line.lstrip(" \t/").startswith("|") and "http" not in line:
            yield number, columns


def test_wide_lines_are_found():
    text = "\n".join(["a" * 101, "| " + "a" * 200, "\t" * 25, "\t" * 26, "http://" + "a" * 100])
    assert list(wide_lines(text)) == [(1, 101), (4, 104)]


@pytest.mark.skipif(not tracked(), reason="needs git and a clone")
def test_lines_have_at_most_100_columns():
    """At most 1 % of all lines may be wider; of a wrapped file, 1 % or four lines."""
    failed, total, count = [], 0, 0
    for name in tracked():
        path = ROOT / name
        if not path.exists():
            continue
        text = path.read_text()
        wide = list(wide_lines(text))
        total, count = total + len(wide), count + text.count("\n")
        if name.startswith(UNWRAPPED):
            continue
        if len(wide) > max(4, SHARE * text.count("\n")):
            number, columns = wide[0]
            failed.append(f"{name}:{number}: {columns} columns, {len(wide)} wide lines in all")
    assert total <= SHARE * count
    assert not failed, f"lines over {COLUMNS} columns:\n" + "\n".join(failed)


def test_kernel_tests_need_no_fixture_from_outside():
    """`scripts/check` runs them without tests/conftest.py, which imports YADE."""
    kernel = ROOT / "tests" / "kernel"
    ended(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
          f"--confcutdir={kernel}", "--setup-plan", kernel)
