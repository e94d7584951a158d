"""Lines of code and prose have at most 100 columns."""

import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLUMNS, SHARE = 100, 0.01
SUFFIXES = {".py", ".cpp", ".hpp", ".sh", ".md"}
UNWRAPPED = ("pkg/dem/", "benchmarks/peers/")  # macros of classes and peers: counted as a whole


def tracked():
    """Names of the tracked files of these suffixes; none without git or outside a clone."""
    if not shutil.which("git"):
        return []
    command = ["git", "-C", ROOT, "ls-files"]
    names = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
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
    failed, total, lines = [], 0, 0
    for name in tracked():
        path = ROOT / name
        if not path.exists():
            continue
        text = path.read_text()
        wide = list(wide_lines(text))
        total, lines = total + len(wide), lines + text.count("\n")
        if name.startswith(UNWRAPPED):
            continue
        if len(wide) > max(4, SHARE * text.count("\n")):
            number, columns = wide[0]
            failed.append(f"{name}:{number}: {columns} columns, {len(wide)} wide lines in all")
    assert total <= SHARE * lines
    assert not failed, f"lines over {COLUMNS} columns:\n" + "\n".join(failed)
