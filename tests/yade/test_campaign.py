"""scripts/campaign: runs that are killed go on to the same results, and what is wrong is said in one line."""

import json
import os
import shutil
import subprocess
import time

import pytest
from run_contents import contents, different

CAMPAIGN = os.path.join(os.path.dirname(__file__), "..", "..", "scripts", "campaign")
SMALL = ["--particles", "60", "--etas", "0.5", "--seeds", "2", "--strain", "0.04"]  # at rest after 255 steps

needs_snakemake = pytest.mark.skipif(not shutil.which("snakemake"), reason="the optional package snakemake is not installed")
needs_environment = pytest.mark.skipif("YADE_RCR_WAY" not in os.environ, reason="wants the environment of scripts/test")


def campaign(out, *arguments):
    return subprocess.run([CAMPAIGN, "--out", str(out), *arguments], capture_output=True, text=True, timeout=1800)


@pytest.mark.slow
@needs_snakemake
@needs_environment
def test_killed_campaign_ends_with_the_same_results(tmp_path):
    undisturbed = campaign(tmp_path / "a", *SMALL)
    assert undisturbed.returncode == 0, undisturbed.stderr
    assert undisturbed.stdout.startswith(f"{tmp_path / 'a' / 'report' / 'report.html'}: ") and undisturbed.stdout.count("\n") == 1

    checkpoint = tmp_path / "b" / "runs" / "particles-60-strain-0.04-eta-0.5-seed-2" / "checkpoint.yade.gz"
    saved = lambda: checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
    for _ in range(3):
        before = saved()
        process = subprocess.Popen([CAMPAIGN, "--out", str(tmp_path / "b"), *SMALL], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while process.poll() is None and saved() == before:
            time.sleep(0.01)
        process.kill()  # it alone: Snakemake and the tests have to end with it
        process.wait()
    again = campaign(tmp_path / "b", *SMALL)
    assert again.returncode == 0, again.stderr

    record = json.loads((checkpoint.parent / "run.json").read_text())
    assert len(record["continued"]) >= 2, "no run went on from a checkpoint"
    one, two = (contents(checkpoint.parent.parents[2] / name / "runs" / checkpoint.parent.name) for name in "ab")
    assert not different(one, two) and any(".h5" in name for name in one)
    assert json.loads((tmp_path / "a/report/analysis.json").read_text()) == json.loads((tmp_path / "b/report/analysis.json").read_text())


@pytest.mark.slow
@needs_snakemake
@needs_environment
def test_quasi_static_is_handed_to_the_tests(tmp_path):
    run = campaign(tmp_path / "out", *SMALL, "--quasi-static", "--strain", "0.004")
    assert run.returncode == 0, run.stderr
    (folder,) = (tmp_path / "out" / "runs").iterdir()
    assert folder.name == "particles-60-strain-0.004-quasi-static-eta-0.5-seed-2"
    assert json.loads((folder / "run.json").read_text())["parameters"]["overdamped"] is True


@needs_snakemake
@needs_environment
def test_the_reason_of_a_failed_test_is_the_campaigns(tmp_path):
    run = campaign(tmp_path / "out", *SMALL, "--strain", "0.0005")
    assert run.returncode != 0
    assert "--strain 0.0005: expected at least 0.001" in run.stderr.strip().splitlines()[-1]


@needs_environment
@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--etas", "0,1"], "expected elongations 0 ≤ ETA < 1"),
        (["--particles", "3"], "--particles 3: expected at least 10"),
        (["--strain", "0"], "--strain 0.0: expected 0 < strain < 1"),
        (["--jobs", "0"], "--jobs 0: expected at least 1"),
        (["--seeds", "1,-2"], "expected seeds ≥ 0"),
        (["--etas", ","], "--etas: wanted at least one"),
        (["--etas", "nan"], "expected elongations 0 ≤ ETA < 1"),
        (["--out", ""], "--out '': expected a path"),
    ],
)
def test_refuses_bad_input(arguments, message, tmp_path):
    run = campaign(tmp_path / "out", *arguments)
    assert run.returncode != 0
    assert run.stderr.strip().splitlines()[-1].endswith(message)
    assert not (tmp_path / "out").exists()


@needs_snakemake
@needs_environment
def test_another_number_of_networks_is_refused(tmp_path):
    """The names of the runs do not tell it: complete ones stayed as they were, without a word."""
    assert campaign(tmp_path / "out", *SMALL, "--strain", "0.004", "--networks", "2").returncode == 0
    again = campaign(tmp_path / "out", *SMALL, "--strain", "0.004", "--networks", "3")
    assert again.returncode != 0 and "is made with --networks 2, and this is --networks 3; wanted the same, or another --out" in again.stderr
    assert campaign(tmp_path / "out", *SMALL, "--strain", "0.004", "--networks", "2").returncode == 0
