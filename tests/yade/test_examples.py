"""Every example runs alone, at its small size, and leaves a picture."""

import pathlib
import subprocess

import pytest
from matplotlib.image import imread

EXAMPLES = sorted((pathlib.Path(__file__).parents[2] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_example(script, tmp_path):
    out = tmp_path / "out"
    run = subprocess.run(["yade", "-n", "-x", str(script), "--quick", "--out", str(out)], capture_output=True, text=True, timeout=300, cwd=tmp_path)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "Traceback" not in run.stdout + run.stderr
    pictures = list(out.glob("*.png"))
    assert pictures and all(imread(picture)[..., :3].std() > 0.02 for picture in pictures)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
