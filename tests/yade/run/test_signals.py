"""Signals to scripts: results are written, exit codes and resumed results are right.

The cases are those of tests/endurance/signals.py, here inside the environment.
"""

import pathlib
import subprocess
import sys

import pytest
import signals
from common import wait_until
from forked import SCRIPTS
from run_contents import contents

DATA = pathlib.Path(__file__).parents[2] / "data"
CASES = dict(signals.scene_cases())


@pytest.mark.parametrize("name", CASES)
def test_scene(name, tmp_path):
    CASES[name](tmp_path)


def test_biaxial_test_and_its_analysis(tmp_path):
    signals.biaxial_resumes(tmp_path, contents)


@pytest.mark.parametrize("number", signals.SIGNALS)
def test_a_solver_ends_at_once(number, tmp_path):
    """It is compiled code; these sweeps take hours."""
    sweeps = ["--solver", "nlgs", "--tolerance", "0", "--max-iterations", str(2**31 - 1)]
    command = [sys.executable, f"{SCRIPTS}/solve.py", DATA / "shear-500-eta-0.npz", *sweeps,
               "--out", tmp_path / "solution.npz"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: len(list(pathlib.Path(f"/proc/{process.pid}/task").iterdir())) > 1)
    process.send_signal(number)
    assert process.communicate(timeout=60) == ("", "solve.py: stopped\n")
    assert process.returncode == 128 + number and not any(tmp_path.iterdir())


@pytest.mark.parametrize("number", signals.SIGNALS)
def test_a_chart_ends_at_once(number, tmp_path):
    """It does not wait for the process that computes a point; this point takes hours."""
    command = [sys.executable, f"{SCRIPTS}/chart.py", "--charts", "c", "--particles", "20000",
               "--out", tmp_path]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
    wait_until(children.read_text)
    (child,) = children.read_text().split()
    process.send_signal(number)
    assert process.communicate(timeout=signals.PATIENCE)[1] == "chart.py: stopped\n"
    assert process.returncode == 128 + number and not pathlib.Path(f"/proc/{child}").exists()
