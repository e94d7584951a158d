"""A step without a finite solution moves nothing and saves its problem to a file."""

import numpy as np
import pytest
import rcr
from scenes import build, material, snapshot, solver
from yade import O


@pytest.mark.parametrize("method", ["nlgs", "nesterov", "exact", "auto"])
def test_the_problem_is_saved(method, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    light, heavy = (rcr.particle((0, y), 0.1, 0, material=material()) for y in (0.0999, 0.2998))
    light.state.mass, light.state.inertia = 1e-300, (1, 1, 1e-302)
    heavy.state.mass, heavy.state.vel = 1e300, (0, -1e300, 0)
    build(rcr.wall("y", 0, sense=1, material=material()), light, heavy, solver=method,
          tolerance=1e-4)
    before = snapshot()
    with pytest.raises(RuntimeError, match=r"would give body #\d .* Nothing has moved\. Its "
                       r"problem is in (.*); rcr\.solve\('.*', warm=True\) replays it") as told:
        O.step()
    assert np.array_equal(snapshot()[:, :13], before[:, :13])
    path = tmp_path / "not-finite-0.npz"
    assert str(path) in str(told.value)
    problem = rcr.problems.load(path)
    assert problem.contacts == solver().contactPoints
