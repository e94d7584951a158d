"""The test in a periodic cell: stresses at rest and in shear, and a saved scene."""

import numpy as np
import pytest
from rcr.study.protocol import PROTOCOL
from rcr.study.cell import CellTest
from yade import O


def test_cell_is_isotropic_at_rest_and_keeps_its_stress_in_shear():
    test = CellTest(eta=0.3, particles=100, seed=3)
    test.compact()
    stress = test.stress / PROTOCOL.confining_stress
    assert (
        np.diag(stress) == pytest.approx([1, 1], abs=0.05) and abs(stress - stress.T).max() < 0.05
    )
    assert (
        abs(stress[0, 1]) < 0.1
    )  # what holds it is the packing: no friction, and nothing presses along the diagonal
    assert 0.8 < test.packing_fraction < 0.95
    rows = test.shear("biaxial", 0.05, every=0.005)
    assert rows["strain"][-1] == pytest.approx(0.05, abs=1e-3) and len(rows["strain"]) == 10
    overlap = max(
        -i.geom.gap[k] / (i.geom.refR1 + i.geom.refR2)
        for i in O.interactions
        if i.isReal
        for k in range(i.geom.points)
    )
    assert test.solver.yieldedSteps == 0 and overlap < 5e-3
    assert 0.2 < rows["sin_phi"].mean() < 0.7
    lateral = rows["pressure"] * (
        1 - rows["sin_phi"]
    )  # the smaller principal stress is the pressed one
    assert lateral.mean() == pytest.approx(1, abs=0.1)


def test_saved_cell_goes_on_to_the_same_bits(tmp_path):
    test = CellTest(eta=0, particles=120)
    test.compact()
    test.shear("simple", 0.005, every=0.005)
    O.save(str(tmp_path / "cell.yade"))
    state = lambda: [(*b.state.pos, *b.state.vel, *b.state.angVel) for b in O.bodies] + [
        tuple(O.cell.hSize.row(k)) for k in range(3)
    ]
    O.run(50, True)
    first = state()
    O.load(str(tmp_path / "cell.yade"))
    O.run(50, True)
    assert state() == first


@pytest.mark.parametrize(
    "wrong, says",
    [
        (dict(eta=1), "eta = 1; expected an elongation"),
        (dict(particles=99), "particles = 99; expected at least 100"),
        (dict(inertial_number=0), "inertial_number = 0; expected a finite number > 0"),
    ],
)
def test_wrong_parameters_are_refused(wrong, says):
    with pytest.raises(ValueError, match=says):
        CellTest(**wrong)
