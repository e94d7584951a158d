"""Examples run alone at their small size and leave pictures; batches, regression, Ctrl-C."""

import pathlib
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread
from scenes import environment

FOLDER = pathlib.Path(__file__).parents[3] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))


QUICK = ["first_scene"]  # the others take some seconds each


def yade(folder, *command, program="yade", code=0):
    """The ended process of a program, which must return this code."""
    run = subprocess.run([program, *map(str, command)], capture_output=True, text=True, timeout=300,
                         cwd=folder)
    assert run.returncode == code, run.stdout + run.stderr
    return run


@pytest.mark.parametrize("script", [
    pytest.param(path, id=path.stem, marks=[] if path.stem in QUICK else [pytest.mark.slow])
    for path in EXAMPLES])  # fmt: skip
def test_example(script, tmp_path):
    out = tmp_path / "out"
    run = yade(tmp_path, "-n", "-x", script, "--quick", "--out", out)
    assert "Traceback" not in run.stdout + run.stderr
    pictures = list(out.glob("*.png"))
    assert pictures and all(imread(picture)[..., :3].std() > 0.02 for picture in pictures)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    for table in out.glob("*.csv"):
        text = table.read_text()
        assert "nan" not in text and len(text.splitlines()) > 1, text


@pytest.mark.slow
def test_a_batch_gives_the_results_of_single_runs(tmp_path):
    """Four jobs at the same time give what a single run with default parameters gives."""
    shutil.copy(FOLDER / "batch.py", tmp_path)
    rows = [(0, 0.2), (0, 0.5), (0.5, 0.2), (0.5, 0.5)]
    lines = [f"{eta:.1f} {mu}" for eta, mu in rows]
    assert (FOLDER / "batch.table").read_text().split("eta mu\n")[1].splitlines() == lines
    small = ["eta mu wide high seconds", *(f"{line} 3 5 0.3" for line in lines)]
    (tmp_path / "small.table").write_text("\n".join(small) + "\n")
    batch = yade(tmp_path, "-j", 4, "small.table", "batch.py", program="yade-batch")
    assert batch.stdout.count("(exit status 0)") == 4, batch.stdout + batch.stderr
    yade(tmp_path, "-n", "-x", "batch.py", "--quick", "--out", "single")
    of_batch, single = tmp_path / "out" / "batch", tmp_path / "single"
    name = "eta-0.5-mu-0.5.txt"
    assert (of_batch / name).read_bytes() == (single / name).read_bytes()
    table = np.genfromtxt(of_batch / "batch.csv", delimiter=",", names=True)
    assert [(row["eta"], row["mu"]) for row in table] == rows and len(set(table["runout"])) == 4


def test_the_regression_example_reports_differences(tmp_path):
    script = tmp_path / "changed.py"
    text = (FOLDER / "regression.py").read_text()
    assert text.count("math.atan(0.5)") == 1
    script.write_text(text.replace("math.atan(0.5)", "0"))  # without friction
    assert "expected" in yade(tmp_path, "-n", "-x", script, "--out", "out", code=1).stderr


def test_ctrl_c_ends_after_a_whole_step(tmp_path):
    """The first Ctrl-C ends the run, and the script continues after `advance`.

    The velocity is 1 and the time step a power of two, so that sums of any length are exact.
    """
    code = """
from scenes import *
from yade.wrapper import PyRunner
build(rcr.particle((0, 0), 0.1, 0.5, velocity=(1, 0)), gravity=(0, 0, 0), dt=2**-13)
ready = PyRunner(command="print('ready', flush=True)", iterPeriod=100, nDo=2)  # once
O.engines = [*O.engines, ready]
rcr.advance(10, "first")
going = rcr.advance(10**9, "for ever")
print("stopped", going, O.bodies[0].state.pos[0] == O.iter * O.dt, O.iter > 10)
"""
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True,
                           stderr=subprocess.PIPE, env=environment())
    assert "ready\n" in iter(run.stdout.readline, "")
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert out == "stopped False True True\n", out + err
