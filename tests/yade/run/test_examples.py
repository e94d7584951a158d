"""Examples run alone at their small size and leave pictures; batches, regression, Ctrl-C."""

import pathlib
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread

FOLDER = pathlib.Path(__file__).parents[3] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))


def yade(folder, *command, program="yade"):
    return subprocess.run([program, *map(str, command)], capture_output=True, text=True,
                          timeout=300, cwd=folder)


QUICK = ["first_scene"]  # the others take some seconds each


@pytest.mark.parametrize("script",
                         [pytest.param(path, id=path.stem, marks=[pytest.mark.slow]
                                       * (path.stem not in QUICK)) for path in EXAMPLES])
def test_example(script, tmp_path):
    out = tmp_path / "out"
    run = yade(tmp_path, "-n", "-x", script, "--quick", "--out", out)
    assert run.returncode == 0, run.stdout + run.stderr
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
    assert (FOLDER / "batch.table").read_text().split("eta mu\n")[1] == "".join(f"{eta:.1f} {mu}\n"
        for eta, mu in rows)
    (tmp_path / "small.table").write_text("eta mu wide high seconds\n"
                                          + "".join(f"{eta:.1f} {mu} 3 5 0.3\n"
                                                    for eta, mu in rows))
    batch = yade(tmp_path, "-j", 4, "small.table", "batch.py", program="yade-batch")
    assert batch.returncode == 0, batch.stdout + batch.stderr
    assert batch.stdout.count("(exit status 0)") == 4, batch.stdout + batch.stderr
    single = yade(tmp_path, "-n", "-x", "batch.py", "--quick", "--out", "single")
    assert single.returncode == 0, single.stdout + single.stderr
    name = "eta-0.5-mu-0.5.txt"
    assert (tmp_path / "out" / "batch" / name).read_bytes() == (
        tmp_path / "single" / name).read_bytes()
    table = np.genfromtxt(tmp_path / "out" / "batch" / "batch.csv", delimiter=",", names=True)
    assert [(row["eta"], row["mu"]) for row in table] == rows and len(set(table["runout"])) == 4


def test_the_regression_example_reports_differences(tmp_path):
    script = tmp_path / "changed.py"
    text = (FOLDER / "regression.py").read_text()
    assert text.count("math.atan(0.5)") == 1
    script.write_text(text.replace("math.atan(0.5)", "0"))  # without friction
    run = yade(tmp_path, "-n", "-x", script, "--out", "out")
    assert run.returncode == 1 and "expected" in run.stderr, run.stdout + run.stderr


def test_ctrl_c_ends_after_a_whole_step(tmp_path):
    """The first Ctrl-C ends the run, and the script continues after `advance`.

    The velocity is 1 and the time step a power of two, so that sums of any length are exact.
    """
    code = """
import yade
import rcr
from yade.wrapper import *
O = Omega()
O.bodies.append(rcr.particle((0, 0), 0.1, 0.5, velocity=(1, 0)))
O.engines = [ForceResetter(), InsertionSortCollider([rcr.Bo1_Rcr_Aabb()]),
             InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom()], [rcr.Ip2_FrictMat_FrictMat_CdPhys()], [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
             rcr.ContactDynamics(), NewtonIntegrator(damping=0),
             PyRunner(command="print('ready', flush=True)", iterPeriod=100, nDo=2)]  # once
O.dt = 2**-13
rcr.advance(10, "first")
going = rcr.advance(10**9, "for ever")
print("stopped", going, O.bodies[0].state.pos[0] == O.iter * O.dt, O.iter > 10)
"""
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, text=True)
    assert "ready\n" in iter(run.stdout.readline, "")
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert out == "stopped False True True\n", out + err
