"""Notebooks are stored without outputs and run without an error, as in Jupyter."""

import importlib.util
import json
import os
import pathlib

import common
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
# last cell of each notebook, by its variables
CHECKS = dict(
    first_scene="""
assert abs(-O.forces.f(floor)[1] / weight - 1) < 0.01  # at rest the floor carries the weight
assert solver.missedSteps < 10
""",
    force_network="""
import rcr
assert 0.5 < rcr.Network.load("heap.h5").weak_share() < 0.8  # about 0.6 in disordered packings
assert len(chains.grains) > 0
""",
    shear_strength="""
assert all(abs(test[-1]["strain"] - 0.08) < 1e-3 for test in histories.values())
strength = [result["sin_phi"] for result in results.values()]
assert 0.1 < strength[0] < 0.4 and strength[-1] > strength[0] + 0.1  # long grains are stronger
""")
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
HAS_JUPYTER = all(map(importlib.util.find_spec, ("nbclient", "ipykernel")))


def read(path):
    notebook = json.loads(path.read_text())
    return notebook, [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def figures(cells):
    """Number of cells that show a figure."""
    return sum("plt.subplots" in text or text.rstrip().endswith(".figure")
               for text in ("".join(cell["source"]) for cell in cells))


def run_by_jupyter(path, folder):
    """Run a notebook and its checks by the kernel that it names; return its pictures."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(CHECKS[path.stem]))
    resources = {"metadata": {"path": folder}}
    nbclient.NotebookClient(notebook, timeout=100, resources=resources).execute()
    return [output for cell in notebook.cells if cell.cell_type == "code"
            for output in cell.outputs if "image/png" in output.get("data", {})]


def run_by_python(path, folder):
    """Run the cells of a notebook, without commands of Jupyter, and its checks."""
    lines = "\n".join("".join(cell["source"]) for cell in read(path)[1]).splitlines()
    code = "\n".join(line for line in lines if not line.startswith("%")) + CHECKS[path.stem]
    common.python(code, cwd=folder, env=os.environ | {"MPLBACKEND": "agg"})


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_stored_without_outputs(path):
    notebook, code = read(path)
    assert code and not any(cell["outputs"] or cell["execution_count"] for cell in code)
    assert notebook["metadata"]["kernelspec"]["name"] == "yade"
    wide = [line for cell in notebook["cells"] for line in "".join(cell["source"]).split("\n")
            if len(line) > 100]
    assert not wide


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, monkeypatch):
    """Without Jupyter's libraries, plain Python runs the cells."""
    if HAS_JUPYTER:
        monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")  # else jupyter_core warns
        monkeypatch.setenv("JUPYTER_PATH", str(ROOT / "scripts" / "lib" / "jupyter"))
        monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
        assert len(run_by_jupyter(path, str(tmp_path))) == figures(read(path)[1])
    else:
        run_by_python(path, tmp_path)


def test_every_notebook_has_a_check():
    assert [path.stem for path in NOTEBOOKS] == sorted(CHECKS)
