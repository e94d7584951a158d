"""Examples, batches and the Python code of each page run; the law of a page compiles."""

import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest
from common import ended
from forked import program as yade
from matplotlib.image import imread, imsave
from scenes import environment

ROOT = pathlib.Path(__file__).resolve().parents[3]
FOLDER, BUILD = ROOT / "examples", ROOT / "build"
EXAMPLES = sorted(FOLDER.glob("*.py"))
PAGES = [page for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
         if "```python\n" in page.read_text()]
QUICK = ["first_scene"]  # the others take some seconds each


@pytest.mark.parametrize("script", [
    pytest.param(path, id=path.stem, marks=[] if path.stem in QUICK else [pytest.mark.slow])
    for path in EXAMPLES])  # fmt: skip
def test_example(script, tmp_path):
    out = tmp_path / "out"
    (out / "film").mkdir(parents=True)
    imsave(out / "film" / "00001.png", np.zeros((9, 9)))  # of an earlier run with other options
    run = yade(tmp_path, "-n", "-x", script, "--quick", "--out", out)
    assert "Traceback" not in run.stdout + run.stderr
    pictures = list(out.glob("*.png"))
    assert pictures and all(imread(picture)[..., :3].std() > 0.02 for picture in pictures)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    for table in out.glob("*.csv"):
        text = table.read_text()
        assert "nan" not in text and len(text.splitlines()) > 1, text


@pytest.mark.slow
def test_the_periodic_cell_bears_its_pressure(tmp_path):
    """Its picture shows forces that last, not the collisions of an instant."""
    yade(tmp_path, "-n", "-x", FOLDER / "periodic_shear.py", "--quick", "--out", tmp_path)
    table = np.genfromtxt(tmp_path / "shear.csv", delimiter=",", names=True)
    normal = table["normal"][table["strain"] > 0.1]
    assert normal.mean() == pytest.approx(1000, rel=0.03) and normal.std() < 0.1 * normal.mean()


@pytest.mark.slow
def test_a_batch_gives_the_results_of_single_runs(tmp_path):
    """Simultaneous jobs give the results of a single run with default parameters."""
    shutil.copy(FOLDER / "batch.py", tmp_path)
    rows = [(0, 0.2), (0, 0.5), (0.5, 0.2), (0.5, 0.5)]
    lines = [f"{eta:.1f} {mu}" for eta, mu in rows]
    assert (FOLDER / "batch.table").read_text().split("eta mu\n")[1].splitlines() == lines
    rows.append((0.5, 1e-5))
    table = ["eta mu", *lines, "0.5 1e-05"]
    (tmp_path / "more.table").write_text("\n".join(table) + "\n")
    batch = yade(tmp_path, "-j", 4, "more.table", "batch.py", name="yade-batch")
    assert batch.stdout.count("(exit status 0)") == 5, batch.stdout + batch.stderr
    yade(tmp_path, "-n", "-x", "batch.py", "--out", "single")
    of_batch, single = tmp_path / "out" / "batch", tmp_path / "single"
    name = "eta-0.5-mu-0.5.txt"
    assert (of_batch / name).read_bytes() == (single / name).read_bytes()
    table = np.genfromtxt(of_batch / "batch.csv", delimiter=",", names=True)
    assert [(row["eta"], row["mu"]) for row in table] == rows and len(set(table["runout"])) == 5


def test_the_regression_example_reports_differences(tmp_path):
    script = tmp_path / "changed.py"
    text = (FOLDER / "regression.py").read_text()
    assert text.count("math.atan(0.5)") == 1
    script.write_text(text.replace("math.atan(0.5)", "0"))  # without friction
    assert "expected" in yade(tmp_path, "-n", "-x", script, "--out", "out", code=1).stderr


def test_references_that_the_regression_example_offers_hold(tmp_path):
    """No tolerance is below that of the solver, and the scene agrees with what is printed."""
    script = tmp_path / "spread.py"
    text = (FOLDER / "regression.py").read_text()
    offered = yade(tmp_path, "-n", "-x", FOLDER / "regression.py", "--spread", 6, "--out", "o").stdout
    lines = re.findall(r'^    ".*": \(.*\),$', offered, re.M)
    values = [(float(value), float(tolerance)) for value, tolerance
              in re.findall(r"\((\S+), (\S+)\),$", offered, re.M)]
    assert len(values) == len(lines) == 5
    assert all(tolerance >= 1e-4 * abs(value) for value, tolerance in values), offered
    pasted = re.sub(r"(?s)(REFERENCE = \{[^\n]*\n).*?(^\})", lambda m: m[1] + "\n".join(lines) + "\n}",
                    text, flags=re.M)
    assert pasted != text
    script.write_text(pasted)
    assert "all 5 values agree" in yade(tmp_path, "-n", "-x", script, "--out", "again").stdout


def test_ctrl_c_ends_after_a_whole_step(tmp_path):
    """The script continues after `advance`; with a power of two as time step all sums are exact."""
    code = """
from scenes import *
from yade.wrapper import PyRunner
weightless(rcr.particle((0, 0), 0.1, 0.5, velocity=(1, 0)), dt=2**-13)
ready = PyRunner(command="print('ready', flush=True)", iterPeriod=100, nDo=2)  # once
O.engines = [*O.engines, ready]
rcr.advance(10, "first")
going = rcr.advance(10**9, "endless")
print("stopped", going, O.bodies[0].state.pos[0] == O.iter * O.dt, O.iter > 10)
"""
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True,
                           stderr=subprocess.PIPE, env=environment())
    assert "ready\n" in iter(run.stdout.readline, "")
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert out == "stopped False True True\n", out + err


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.M | re.S)


def run(page, folder, before="", after=""):
    (folder / "page.py").write_text(before + "\n".join(blocks(page, "python")) + after)
    done = yade(folder, "-n", "-x", "page.py")
    return done.stdout + done.stderr


COUNTED = """
import rcr
from yade.wrapper import Omega
def told(self, reset=Omega.reset):
    for engine in self.engines:
        if isinstance(engine, rcr.ContactDynamics):
            print("missed", engine.missedSteps, "overlap", engine.deepestOverlap, flush=True)
    reset(self)
Omega.reset = told
"""


@pytest.mark.parametrize("page", [page for page in PAGES if page.stem != "extending"],
                         ids=lambda page: page.stem)
def test_page(page, tmp_path):
    """Its code runs without a missed step, a deep overlap or a warning."""
    text = run(page, tmp_path, before=COUNTED, after="\nO.reset()\n")
    assert "Traceback" not in text and "WARN" not in text and "UserWarning" not in text, text
    for missed, overlap in re.findall(r"^missed (\d+) overlap (\S+)$", text, re.M):
        assert int(missed) == 0 and float(overlap) < 0.005


def compile_command(source, folder):
    """The build's compile command of a plugin file, for another source."""
    listed = ended("ninja", "-C", BUILD, "-t", "commands", "_plugin").stdout
    words = shlex.split(next(line for line in listed.splitlines()
                             if "/_plugin.dir/Unity/" in line and " -c " in line))
    words = words[: words.index("-c")] + ["-c", str(source)]
    for option in ("-o", "-MF", "-MT"):
        if option in words:
            words[words.index(option) + 1] = str(folder / f"law{option}")
    return words, folder / "law-o"


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("ninja") or not (BUILD / "build.ninja").exists(),
                    reason="needs the build folder")
def test_laws_of_the_page(tmp_path):
    """Compiled with the build's options and loaded before rcr; the build's files stay."""
    page = ROOT / "docs" / "extending.md"
    laws = blocks(page, "cpp")
    assert all(len(law.splitlines()) < 65 for law in laws)
    names = re.findall(r"Put\s+this\s+into\s+`pkg/dem/contacts/(\w+)\.cpp`", page.read_text())
    assert len(names) == 2 and all("YADE_PLUGIN" in law and f"({name}))" in law
                                   for name, law in zip(names, laws, strict=True))
    source = tmp_path / "laws.cpp"  # one translation unit, as in the build
    source.write_text("\n".join(laws))
    command, compiled = compile_command(source, tmp_path)
    subprocess.run(command, cwd=BUILD, check=True, timeout=3600)
    (plugin,) = (ROOT / "py" / "rcr").glob("_plugin*.so")
    subprocess.run([command[0], "-shared", "-o", tmp_path / "law.so", compiled, plugin,
                    f"-Wl,-rpath,{plugin.parent}"], check=True, timeout=120)
    before = f"import ctypes; ctypes.CDLL('{tmp_path}/law.so', ctypes.RTLD_GLOBAL)\n"
    assert "Traceback" not in run(page, tmp_path, before)
