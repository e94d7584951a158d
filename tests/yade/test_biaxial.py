"""The biaxial test: a balanced isostatic start, walls that feel what the contacts carry, checkpoints, the script's manners."""

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest
from rcr.biaxial import STRESS, Biaxial
from rcr.network import Network
from yade import O

from scenes import closed_points

BALANCED = 5e-5  # mean net force over mean contact force: finer than a study needs, for the laws of a balanced packing
SCRIPT = os.path.join(os.path.dirname(__file__), "..", "..", "scripts", "biaxial.py")


@dataclasses.dataclass
class Packing:
    """A frictionless compaction of 400 particles, made once: its last step, and a checkpoint to go on from."""

    eta: float
    folder: str
    network: Network
    points: list
    net_forces: np.ndarray
    wall_stresses: np.ndarray


@pytest.fixture(scope="module", params=[0.0, 0.5])
def packing(request, tmp_path_factory):
    test = Biaxial.prepare(eta=request.param, particles=400, seed=1)
    test.compact(balanced=BALANCED)
    folder = str(tmp_path_factory.mktemp("packing"))
    test.save(folder)
    net = np.array([O.forces.f(i).norm() for i in test.grains])
    return Packing(request.param, folder, test.network(), closed_points(), net, test.mean_stresses)


def test_frictionless_packing_is_isostatic(packing):
    """Without friction a balanced packing has as many forces as equations: 2 a disc, 3 a long particle, 1 a mobile wall.

    More would need a coincidence. Rattlers have neither. Long particles may have a few less: where one can slide along
    flat sides no contact opens or closes, and such a neutral mode needs no force. Here these are 1.5 % of the equations,
    more than half of them of single particles. In the bulk isostaticity is Z = 4 for discs and 6 for long particles with
    side-side contacts counted twice; the contacts with walls, which count for one particle only, lower both.
    """
    mean = np.mean([point.force for point in packing.points])
    points = [point for point in packing.points if point.force > 1e-3 * mean]  # smaller ones the tolerance leaves undecided
    bearing = {i for point in points for i in point.ids if i < 400}
    equations = (2 if packing.eta == 0 else 3) * len(bearing) + 2
    fewest = 0.99 if packing.eta == 0 else 0.97
    assert fewest * equations <= len(points) <= 1.005 * equations  # 1.005: forces near the threshold
    z, zc = (packing.network.coordination(count_side_contacts_twice=twice) for twice in (False, True))
    bulk = 4 if packing.eta == 0 else 6
    assert bulk - 0.5 < zc < bulk + 0.1, f"Z = {z:.3f}, Zc = {zc:.3f}"


def test_frictionless_packing_is_balanced_and_isotropic(packing):
    """Net forces below 5e-5 of the mean contact force; σ = σ₀ on all walls within 1 %."""
    mean = np.mean([point.force for point in packing.points])
    assert packing.net_forces.mean() < BALANCED * mean
    assert packing.net_forces.max() < 0.02 * mean  # of 400; one that is still settling
    assert packing.wall_stresses == pytest.approx(STRESS, rel=0.01)


def test_contacts_carry_what_the_walls_feel(packing):
    """σ = (1/V) Σ f⊗ℓ over all contacts is the load of the walls: virial theorem, exact in balance."""
    stress = packing.network.stress()
    # Forces out of balance by 1e-3 act over arms of the size of the box, 20 d, with random signs.
    assert np.diag(stress) == pytest.approx(packing.wall_stresses, rel=5e-3)
    assert stress[0, 1] == pytest.approx(stress[1, 0], abs=1e-3 * STRESS)


def test_checkpoint_goes_on_to_the_same_bits(packing, tmp_path):
    """Shear of 4 records, with and without a checkpoint in between."""

    def state(test):
        bodies = [O.bodies[i].state for i in (*test.grains, *test.walls)]
        return np.array([(*s.pos, *s.ori, *s.vel, *s.angVel) for s in bodies])

    test = Biaxial.load(packing.folder)
    for _ in range(4):
        test.shear_record()
    straight, rows = state(test), test.rows

    test = Biaxial.load(packing.folder)
    for _ in range(2):
        test.shear_record()
    test.save(tmp_path)
    test = Biaxial.load(tmp_path)
    for _ in range(2):
        test.shear_record()
    assert np.array_equal(state(test), straight)
    assert [(row["sin_phi"], row["iterations"]) for row in test.rows] == [(row["sin_phi"], row["iterations"]) for row in rows]


def test_walls_stay_smooth_in_shear(packing):
    test = Biaxial.load(packing.folder)
    for _ in range(2):
        test.shear_record()
    friction = {(max(i.id1, i.id2) in test.walls): i.phys.tangensOfFrictionAngle for i in O.interactions if i.isReal}
    assert friction == {True: 0, False: pytest.approx(0.5, rel=1e-15)}
    left, right = (abs(O.forces.f(i)[0]) for i in (test.left, test.right))
    assert left > 0 and right >= 0


def test_network_file_keeps_everything(packing, tmp_path):
    network = packing.network
    path = tmp_path / "network.h5"
    network.save(path)
    again = Network.load(path)
    for group in ("particles", "contacts"):
        for name, column in getattr(network, group).items():
            assert np.array_equal(getattr(again, group)[name], column), name
    assert again.attributes["eta"] == packing.eta and again.attributes["strain"] == again.attributes["friction"] == 0
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--eta", "1"], "eta = 1.0; wanted an elongation 0 ≤ eta < 1"),
        (["--particles", "3"], "particles = 3; wanted at least 10"),
        (["--friction", "-1"], "friction = -1.0; wanted a coefficient ≥ 0"),
        (["--strain", "2"], "--strain 2.0: wanted 0 < strain < 1"),
        (["--solver", "magic"], "solver 'magic' is not known"),
        (["--resume"], "nothing to resume"),
    ],
)
def test_script_refuses_bad_input(arguments, message, tmp_path):
    """One clear line on stderr, a non-zero exit code, nothing written."""
    run = subprocess.run(
        [sys.executable, "-c", "import sys, yade, runpy; sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"]
        + [SCRIPT, "--out", str(tmp_path / "out"), *arguments],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode != 0
    assert message in run.stderr
    assert "Traceback" not in run.stderr
    assert not (tmp_path / "out" / "summary.json").exists()
