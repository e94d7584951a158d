"""scripts/campaign: killed runs continue to the same results; errors take one line."""

import fcntl
import json
import os
import pty
import re
import select
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import termios

import pytest
import signals
from common import ended
from forked import SCRIPTS
from rcr.study import progress
from run_contents import campaign_contents, contents, different, start_until_written

CAMPAIGN = f"{SCRIPTS}/campaign"
SMALL = ["--particles", "60", "--etas", "0.5", "--seeds", "2", "--strain", "0.04"]

OUTSIDE = "YADE_RCR_WAY" not in os.environ
needs_environment = pytest.mark.skipif(OUTSIDE, reason="needs the environment of scripts/test")
needs_snakemake = pytest.mark.skipif(
    OUTSIDE or not shutil.which("snakemake"),
    reason="needs the environment of scripts/test and the optional package snakemake")


def campaign(out, *arguments):
    return ended(CAMPAIGN, "--out", out, *arguments, timeout=1800)


def complaint(out, *arguments):
    """The last line on stderr of a campaign that fails."""
    done = ended(CAMPAIGN, "--out", out, *arguments, code=None)
    assert done.returncode, done.stdout
    return done.stderr.strip().splitlines()[-1]


@pytest.mark.slow
@needs_snakemake
def test_killed_campaign_ends_with_the_same_results(tmp_path):
    undisturbed = campaign(tmp_path / "a", *SMALL)
    report = tmp_path / "a" / "report" / "report.html"
    assert undisturbed.stdout.startswith(f"{report}: ") and undisturbed.stdout.count("\n") == 1

    folder = tmp_path / "b" / "runs" / "particles-60-strain-0.04-eta-0.5-seed-2"
    command, silent = [CAMPAIGN, "--out", str(tmp_path / "b"), *SMALL], subprocess.DEVNULL
    for _ in range(3):
        process = start_until_written(folder / "checkpoint.yade.gz", command, stdout=silent,
                                      stderr=silent)
        process.kill()  # Snakemake and the tests must end with it
        process.wait()
    campaign(tmp_path / "b", *SMALL)

    record = json.loads((folder / "run.json").read_text())
    assert len(record["continued"]) >= 2, "no run continued from a checkpoint"
    one, two = (campaign_contents(tmp_path / name) for name in "ab")
    assert not different(one, two) and any(".h5" in name for name in one)


LINES = """\
campaign.py: 3 tests of 60 grains to a strain of 0.02, 0 complete; . at a time, then analysis, .*
campaign.py: η = .*, seed 1: complete( after \\d+ s)?, q/p = 0.\\d+
campaign.py: η = .*, seed 1: complete( after \\d+ s)?, q/p = 0.\\d+
campaign.py: η = .*, seed 1: complete( after \\d+ s)?, q/p = 0.\\d+
campaign.py: analysis: \\d+ s
campaign.py: figures: \\d+ s
campaign.py: report: \\d+ s
"""


@needs_environment
def test_a_test_between_two_updates_has_its_line(tmp_path, capsys, monkeypatch):
    """A very short one is never seen running."""
    monkeypatch.syspath_prepend(f"{SCRIPTS}/lib")
    from campaign_progress import Test

    test = Test("short", tmp_path, 0.1)
    test.update()
    (tmp_path / "summary.json").write_text('{"sin_phi": 0.25, "wall_seconds": 6.7}')
    for _ in range(2):
        test.update()
    assert capsys.readouterr().err == "campaign.py: short: complete after 7 s, q/p = 0.250\n"


@needs_environment
@pytest.mark.parametrize("end", ["complete", "stopped"])
def test_the_time_of_a_resumed_test_is_that_of_all_its_sessions(end, tmp_path, capsys, monkeypatch):
    monkeypatch.syspath_prepend(f"{SCRIPTS}/lib")
    from campaign_progress import Test

    test = Test("resumed", tmp_path, 0.1)
    progress.write(tmp_path, 4000.2, 0.05, 0.5)
    test.update()
    if end == "complete":
        (tmp_path / "summary.json").write_text('{"sin_phi": null, "wall_seconds": 4000.4}')
    progress.remove(tmp_path)
    test.update()
    line = capsys.readouterr().err.splitlines()[-1]
    result = ", q/p = unknown" if end == "complete" else ""
    assert line.endswith(f"campaign.py: resumed: {end} after 4000 s{result}")


@needs_environment
@pytest.mark.parametrize("wide", [90, 0], ids=["wide", "unknown"])
def test_bars_on_a_terminal_of_any_width(tmp_path, monkeypatch, wide):
    """`script` without a terminal, and some editors, give theirs the width 0."""
    monkeypatch.syspath_prepend(f"{SCRIPTS}/lib")
    from campaign_progress import Test

    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 30, wide, 0, 0))
    with open(theirs, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        tests = [Test(name, tmp_path / name, 0.2) for name in ("first", "last")]
        for test in tests:
            test.folder.mkdir()
            progress.write(test.folder, 2.0, 0.1, 0.4)
            test.update()
        for test in tests:
            (test.folder / "summary.json").write_text('{"sin_phi": 0.25, "wall_seconds": 6.7}')
            progress.remove(test.folder)
            test.update()
        shown = b""
        while select.select([ours], [], [], 0)[0]:
            shown += os.read(ours, 1 << 16)
    os.close(ours)
    shown = shown.decode()
    assert f"first: strain 0.100 of 0.2 |{'█' * 9}▌{' ' * 14}| ? left" in shown
    for name in "first", "last":  # from the left edge of the terminal
        before, line, _ = re.sub("\x1b\\[A", "", shown).partition(f"campaign.py: {name}: complete")
        assert line and before[-1] in "\r\n"


@needs_snakemake
def test_a_terminal_shows_each_test_that_runs(tmp_path):
    """Snakemake prints nothing between the bars."""
    few_figures = ["--paper", "cegeo_2012"]
    command = shlex.join([CAMPAIGN, *SMALL, "--particles", "300", *few_figures, "--out",
                          str(tmp_path / "out")])
    shown = ended("script", "-qec", f"stty cols 90; {command}", "/dev/null").stdout
    name = "η = 0.5, seed 2"
    assert f"{name}, compaction … 00:0" in shown and "figures … 00:0" in shown
    bar = rf"{name}: strain 0.0\d\d of 0.04 \|[█▏▎▍▌▋▊▉ ]{{24}}\| (\?|00:\d\d) left"
    assert re.search(bar, shown)
    assert f"campaign.py: {name}: complete after " in shown and "jobs" not in shown


@needs_snakemake
def test_quick_is_the_study_in_small(tmp_path):
    """Three elongations and a report whose verdicts are grey, since the tests are small."""
    done = ended(CAMPAIGN, "--quick", "--particles", "60", "--strain", "0.02", cwd=tmp_path)
    assert done.stdout.startswith("out/quick/report/report.html")
    assert re.fullmatch(LINES, done.stderr), done.stderr
    names = {folder.name.partition("-eta-")[2] for folder in tmp_path.glob("out/quick/runs/*")}
    assert names == {"0-seed-1", "0.4-seed-1", "0.7-seed-1"}
    page = (tmp_path / "out/quick/report/report.html").read_text()
    assert "fewer than 1000 grains" in page
    assert "class='open'" in page and "class='yes'" not in page and "class='no'" not in page


@needs_snakemake
def test_the_default_folder_is_out_campaign(tmp_path):
    for dry_run in ("--dry-run", "-n"):
        ended(CAMPAIGN, *SMALL, "--", dry_run, cwd=tmp_path)
    assert (tmp_path / "out" / "campaign").is_dir()


@needs_snakemake
@pytest.mark.parametrize("options, expected", [
    ("", dict(inertial_number=1e-4, approach=0.1, time_step=0.4, iterations=10_000, friction=0.5)),
    (" --networks 3", dict(networks=3)),
    (" --iterations 500 --time-step 0.05 --friction 0.3",
     dict(iterations=500, time_step=0.05, friction=0.3)),
])  # fmt: skip
def test_options_reach_the_tests(options, expected, tmp_path):
    """A signal stops the campaign once the record of its test is there."""
    named = options.replace(" --", "-").replace(" ", "-")
    record = tmp_path / "runs" / f"particles-60-strain-0.04{named}-eta-0.5-seed-2" / "run.json"
    command, silent = [CAMPAIGN, "--out", tmp_path, *SMALL, *options.split()], subprocess.DEVNULL
    process = start_until_written(record, command, stdout=silent, stderr=silent)
    process.terminate()
    assert process.wait() == 128 + signal.SIGTERM
    parameters = json.loads(record.read_text())["parameters"]
    assert {name: parameters[name] for name in expected} == expected


@needs_snakemake
def test_the_last_line_has_the_reason_of_every_failed_test(tmp_path):
    out = tmp_path / "out"
    line = complaint(out, *SMALL, "--seeds", *"123456789", "--strain", "0.0005")
    for seed in range(1, 10):
        log = out / "runs" / f"particles-60-strain-0.0005-eta-0.5-seed-{seed}" / "log"
        assert f"{log}: biaxial.py: --strain 0.0005: expected at least 0.001" in line
    assert line.endswith("continue with the same command")


@needs_snakemake
def test_the_first_line_counts_the_resumed_tests(tmp_path):
    """Both tests end at once, since the strain is too small."""
    begun = tmp_path / "runs" / "particles-60-strain-0.0005-eta-0.5-seed-2"
    begun.mkdir(parents=True)
    (begun / "checkpoint.yade.gz").touch()
    done = ended(CAMPAIGN, "--out", tmp_path, *SMALL, "--strain", "0.0005", "--seeds", "2,3",
                 "--jobs", "2", code=None)
    assert done.stderr.startswith("campaign.py: 2 tests of 60 grains to a strain of 0.0005, "
                                  "0 complete, 1 resumed; 2 at a time, then")


@needs_snakemake
def test_tests_of_other_constants_are_refused(tmp_path):
    folder = tmp_path / "runs" / "particles-60-strain-0.04-eta-0.5-seed-2"
    folder.mkdir(parents=True)
    (folder / "run.json").write_text(json.dumps(dict(program="biaxial.py", run="", parameters={})))
    (folder / "summary.json").write_text("{}")
    line = complaint(tmp_path, *SMALL)
    assert line == (f"campaign.py: {folder} holds a test of other constants than those of "
                    "rcr.study.protocol; choose another --out, or remove it")


@needs_snakemake
def test_the_last_line_leaves_out_other_campaigns_of_the_folder(tmp_path):
    for name in "runs/particles-60-strain-0.3-eta-0.5-seed-2", "report":
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "log").write_text("an earlier campaign")
    line = complaint(tmp_path, *SMALL, "--", "--unknown-option")
    assert line.startswith("campaign.py: not complete, see above; continue with")


@pytest.mark.slow
@needs_snakemake
def test_a_signal_stops_it_and_it_resumes_to_the_same_bits(tmp_path):
    signals.campaign_resumes(tmp_path, contents)


@needs_environment
@pytest.mark.parametrize("arguments, message", [
    ("--etas 0,1", "expected elongations 0 ≤ ETA < 1"),
    ("--particles 3", "--particles 3: expected at least 10"),
    ("--strain 0", "--strain 0.0: expected 0 < strain < 1"),
    ("--networks 41 --strain 0.04", "give fewer networks or a larger strain"),
    ("--jobs 0", "--jobs 0: expected at least 1"),
    ("--seeds 1,-2", "expected seeds ≥ 0"),
    ("--etas ,", "--etas: expected at least one"),
    ("--etas nan", "expected elongations 0 ≤ ETA < 1"),
    ("--iterations 0", "--iterations 0: expected at least 1"),
    ("--time-step 0", "--time-step 0.0: expected a number > 0, at most 10"),
    ("--friction 0", "--friction 0.0: expected a coefficient > 0, at most 100"),
    ("--shape trimer --etas 0.6", "eta = 0.6 with shape = 'trimer'; expected 0 to 0.5"),
    ("--shape regular", "shape = 'regular' with sides = None; sides belong to the shape 'regular' "
     "alone, which needs them"),
    ("--shape regular --sides 5 --etas 0", "sides determine η; give one of them"),
    ("--shape regular --sides 2", "--sides 2: expected at least 3 and at most 64"),
    ("--shape trimer --etas 0.2 --rolling-friction 0.1",
     "expected shape = 'rcr', or no rolling friction"),
    ("--size-span 0", "--size-span 0.0: expected a ratio R_max/R_min from 1 to 100"),
    ("--qui", "unrecognized arguments: --qui"),
    ("--out=", "--out '': expected a path"),
])  # fmt: skip
def test_refuses_bad_input(arguments, message, tmp_path):
    assert complaint(tmp_path / "out", *arguments.split()).endswith(message)
    assert not (tmp_path / "out").exists()


@needs_snakemake
def test_the_clone_may_have_spaces_in_its_path(tmp_path):
    """Scripts that do nothing take the place of the real ones."""
    scripts, out = tmp_path / "a clone" / "scripts", tmp_path / "out"
    shutil.copytree(f"{SCRIPTS}/lib", scripts / "lib")
    (scripts / "yade-rcr").write_text('#!/bin/sh\nwhile [ "$1" != --out ]; do shift; done\n'
                                      'touch "$2/summary.json"\n')
    (scripts / "network.py").write_text("#!/bin/sh\ncd report\ntouch analysis.json report.html\n")
    for path in scripts.iterdir():
        path.chmod(0o755)
    ended("snakemake", "--snakefile", scripts / "lib" / "campaign.smk", "--directory", out,
          "--cores", "1", "--quiet", "--config", "particles=60", "strain=0.04", "etas=0.5",
          "seeds=2")
    assert (out / "report" / "report.html").exists()


@needs_snakemake
def test_the_report_is_that_of_the_last_campaign(tmp_path):
    """Snakemake does not know a copied folder, nor what options after -- have run."""
    first, copy = tmp_path / "first", tmp_path / "copy"
    small = [*SMALL, "--strain", "0.004", "--networks", "2", "--paper", "cegeo_2012"]  # few figures
    campaign(first, *small, "--seeds", "2,3")
    shutil.copytree(first, copy, ignore=shutil.ignore_patterns(".snakemake"))
    assert "report.html" not in campaign(first, *small, "--", "-np").stdout
    assert "report.html" in campaign(copy, *small).stdout
    runs = json.loads((copy / "report" / "run.json").read_text())["parameters"]["runs"]
    assert [os.path.basename(run["folder"]) for run in runs] == [
        "particles-60-strain-0.004-networks-2-eta-0.5-seed-2"]


@needs_snakemake
def test_other_grains_are_set_against_their_paper(tmp_path):
    """The same command with another paper writes another report."""
    small = ["--particles", "60", "--strain", "0.004", "--networks", "2", "--etas", "0",
             "--rolling-friction", "0,0.1", "--size-span", "3"]
    campaign(tmp_path, *small)
    names = {path.name for path in (tmp_path / "runs").iterdir()}
    assert names == {"particles-60-strain-0.004-networks-2-size-span-3-eta-0-rolling-friction-"
                     f"{rolling}-seed-1" for rolling in ("0", "0.1")}
    page = tmp_path / "report" / "report.html"
    assert "Estrada" in page.read_text() and "η = 0, µ_r = 0.1" in page.read_text()
    assert "complete after" not in campaign(tmp_path, *small, "--paper", "cegeo_2012").stderr
    assert "CEGEO" in page.read_text()


@needs_snakemake
@pytest.mark.parametrize("config, says", [
    (("particles=60", "strain=0.04", "etas=0", "seeds=1", "network=4"), "unknown network"),
    (("strain=0.04", "etas=0", "seeds=1"), "missing particles")])
def test_a_wrong_configuration_is_refused(config, says, tmp_path):
    run = ended("snakemake", "--snakefile", f"{SCRIPTS}/lib/campaign.smk", "--directory", tmp_path,
                "--cores", "1", "-n", "--config", *config, code=1)
    assert f"--config: {says}; expected particles" in run.stdout + run.stderr
