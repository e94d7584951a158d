"""Lines of code and prose have at most 100 columns."""

import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLUMNS, SHARE = 100, 0.01
SUFFIXES = {".py", ".cpp", ".hpp", ".sh", ".md"}
UNWRAPPED = ("pkg/", "tests/", "benchmarks/peers/", "CHANGELOG.md")  # not checked yet


def tracked():
    """Names of the tracked files of these suffixes; none without git or outside a clone."""
    if not shutil.which("git"):
        return []
    command = ["git", "-C", ROOT, "ls-files"]
    names = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
    return [name for name in names
            if pathlib.Path(name).suffix in SUFFIXES and not name.startswith(UNWRAPPED)]


def wide_lines(text):
    """(number, columns) of each wide line except tables and addresses; a tab has 4 columns."""
    for number, line in enumerate(text.split("\n"), 1):
        columns = len(line.expandtabs(4))
        if columns > COLUMNS and not line.lstrip().startswith("|") and "http" not in line:
            yield number, columns


def test_wide_lines_are_found():
    text = "\n".join(["a" * 101, "| " + "a" * 200, "\t" * 25, "\t" * 26, "http://" + "a" * 100])
    assert list(wide_lines(text)) == [(1, 101), (4, 104)]


@pytest.mark.skipif(not tracked(), reason="needs git and a clone")
def test_lines_have_at_most_100_columns():
    """At most 1 % of the lines of a file, or one line, may be wider."""
    failed = []
    for name in tracked():
        path = ROOT / name
        if not path.exists():
            continue
        text = path.read_text()
        wide = list(wide_lines(text))
        if len(wide) > max(1, SHARE * text.count("\n")):
            number, columns = wide[0]
            failed.append(f"{name}:{number}: {columns} columns, {len(wide)} wide lines in all")
    assert not failed, f"lines over {COLUMNS} columns:\n" + "\n".join(failed)
