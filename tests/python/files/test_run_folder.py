"""A results folder belongs to one run; only the script's own files are ever removed."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcr._data import files, run_folder

from common import python, refused

PARAMETERS = dict(eta=0.5, seed=1, threads=1)
MADE = ["data-*.txt", "summary.json", "checkpoint"]


def owned(folder, parameters=PARAMETERS, **how):
    return run_folder.claim_folder(folder, "test.py", parameters, MADE, free=["threads"],
                                checkpoint="checkpoint", last="summary.json", **how)


def make(folder, parameters=PARAMETERS, files=("data-1.txt", "checkpoint", "summary.json"), **how):
    with owned(folder, parameters, **how) as begin:
        record = begin()
        for name in files:
            (folder / name).write_text(json.dumps(parameters))
    return record


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_record(tmp_path):
    record = make(tmp_path / "a" / "ü")
    assert run_folder.read(tmp_path / "a" / "ü") == record
    assert record["parameters"] == PARAMETERS and record["program"] == "test.py"
    assert {"version", "commit", "date", "run"} <= set(record)
    assert run_folder.read(tmp_path) is None
    more = make(tmp_path / "b", dict(PARAMETERS, threads=2))
    assert more["run"] == record["run"] != make(tmp_path / "c", dict(PARAMETERS, eta=0.25))["run"]


def test_another_run_is_refused_and_nothing_changes(tmp_path):
    make(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    refused(r"eta = 0.5 \(here 0.4\), seed = 1 \(here 2\); choose another --out, or remove it with "
            "--overwrite", make, tmp_path, dict(PARAMETERS, eta=0.4, seed=2))
    refused("--resume: the run in .* has eta = 0.5", make, tmp_path, dict(PARAMETERS, eta=0.4),
            resume=True)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_overwrite_removes_the_files_of_the_old_run_only(tmp_path):
    make(tmp_path, files=("data-1.txt", "data-2.txt", "mine.txt"))
    make(tmp_path, dict(PARAMETERS, eta=0.4), files=("data-1.txt",), overwrite=True)
    assert names(tmp_path) == ["data-1.txt", "mine.txt", "run.json"]
    assert run_folder.read(tmp_path)["parameters"]["eta"] == 0.4


def test_the_same_run_again(tmp_path):
    """A forgotten --resume or a repeated command loses nothing."""
    make(tmp_path)
    refused("holds this run, complete; continue it with --resume, or start again with --overwrite",
            make, tmp_path)
    assert names(tmp_path) == ["checkpoint", "data-1.txt", "run.json", "summary.json"]
    make(tmp_path, files=("checkpoint",), overwrite=True)
    assert names(tmp_path) == ["checkpoint", "run.json"]
    refused("not complete; continue it with --resume, or start again", make, tmp_path)
    make(tmp_path, files=(), overwrite=True)
    make(tmp_path, files=("data-1.txt",))  # a run killed before its first checkpoint
    make(tmp_path)


def test_an_early_failure_loses_nothing(tmp_path):
    make(tmp_path)
    with pytest.raises(RuntimeError), owned(tmp_path, dict(PARAMETERS, eta=0.4), overwrite=True):
        raise RuntimeError
    assert "data-1.txt" in names(tmp_path) and run_folder.read(tmp_path)["parameters"] == PARAMETERS


def test_resume_keeps_files_and_may_change_free_options(tmp_path):
    first = make(tmp_path, files=("checkpoint",))
    record = make(tmp_path, dict(PARAMETERS, threads=4), files=("summary.json",), resume=True)
    assert names(tmp_path) == ["checkpoint", "run.json", "summary.json"]
    assert record["date"] == first["date"] and record["parameters"]["threads"] == 4
    assert len(record["continued"]) == 1
    # a stop on the way to a larger strain would else leave the summary of the smaller one
    make(tmp_path, files=(), resume=True)
    assert names(tmp_path) == ["checkpoint", "run.json"]


def test_results_of_nobody_or_of_another_script_are_kept(tmp_path):
    (tmp_path / "data-old.txt").touch()
    refused("holds data-old.txt of an unknown run", make, tmp_path)
    make(tmp_path, overwrite=True)
    claim = run_folder.claim_folder(tmp_path, "other.py", {}, ["*"], overwrite=True)
    refused("holds results of test.py; choose another --out", claim.__enter__)
    assert "data-1.txt" in names(tmp_path)


def test_parts_of_a_killed_process_go(tmp_path):
    """Those of another process stay; `atomic_path` has its file in a hidden folder."""
    (tmp_path / ".part-x").touch()
    (tmp_path / ".part-folder").mkdir()
    with files.locked(tmp_path / ".part-of-another"):  # another process is writing it
        make(tmp_path, files=())
        assert names(tmp_path) == [".part-of-another", "run.json"]
    with files.atomic_path(tmp_path / "picture.png") as partial:
        make(tmp_path, files=())
        with open(partial, "w") as file:
            file.write("drawn")
    assert names(tmp_path) == ["picture.png", "run.json"]


def test_two_at_once_are_refused_until_the_first_is_dead(tmp_path):
    code = (
        "import sys; from rcr._data import run_folder\n"
        "with run_folder.claim_folder(sys.argv[1], 'test.py', dict(eta=0.5, seed=1, threads=1), "
        "[]) as begin: begin(); print('in', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", code, tmp_path], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"in\n"
        for how in ({}, dict(resume=True), dict(overwrite=True)):
            refused("another process is writing there", make, tmp_path, **how)
        other.kill()
    make(tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"program": 1, "parameters": {}}',
                                  '{"program": "test.py"}', "\0" * 9, "[" * 100_000])
def test_a_damaged_record_is_named(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    assert "\n" not in refused("run.json: ", make, tmp_path)


def test_what_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        refused("", make, path, error=OSError)


@given(st.dictionaries(st.text(max_size=5),
                       st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.integers(),
                                 st.text(max_size=5)), max_size=4))
def test_equal_parameters_have_equal_identities(parameters):
    backwards = dict(reversed(parameters.items()))
    assert run_folder.identity(parameters) == run_folder.identity(backwards)
    assert run_folder.differing(parameters, json.loads(json.dumps(parameters))) == ""


def test_commit_is_stated_or_asked(monkeypatch):
    run_folder.commit.cache_clear()
    monkeypatch.setenv("YADE_RCR_COMMIT", "abc+")
    assert run_folder.commit() == "abc+"
    run_folder.commit.cache_clear()
    monkeypatch.setitem(os.environ, "PATH", "/none")
    monkeypatch.delenv("YADE_RCR_COMMIT")
    assert run_folder.commit() == "unknown"
    run_folder.commit.cache_clear()


def test_the_commit_of_another_repository_is_not_that_of_the_package(tmp_path):
    """A virtual environment may lie in a clone of another project."""
    site = tmp_path / "venv" / "lib" / "python3" / "site-packages"
    package = pathlib.Path(run_folder.__file__).parents[1]
    shutil.copytree(package, site / "rcr", ignore=shutil.ignore_patterns("*.so"))
    author = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in ["init", "-q"], [*author, "commit", "-q", "--allow-empty", "-m", "other"]:
        subprocess.check_call(["git", "-C", tmp_path, *words])
    variables = {name: value for name, value in os.environ.items() if name != "YADE_RCR_COMMIT"}
    code = "from rcr._data import run_folder; print(run_folder.commit())"
    assert python(code, env=variables | {"PYTHONPATH": str(site)}).stdout == "unknown\n"
