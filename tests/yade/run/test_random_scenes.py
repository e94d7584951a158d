"""The first random scenes of tests/endurance; repeated scenes leak no memory."""

import ctypes
import gc
import pathlib
import sys

import numpy as np
import pytest
import run_fuzzer
import scene_fuzzer
import small_scenes
import soak
import symmetries
from common import ended
from scenes import steps
from yade import O, wrapper

pytestmark = pytest.mark.filterwarnings("ignore:rcr. :UserWarning")  # any of them
FOLDER = pathlib.Path(scene_fuzzer.__file__).parent
SCENES = 25
LOST = 0.5e3  # most bytes a scene; measured 0.1e3, about one contact


@pytest.mark.parametrize("name", ["scene_fuzzer", "run_fuzzer", "symmetries", "truth", "sessions",
                                  "soak", "kills", "large"])
def test_each_script_finds_its_modules_without_pytest(name):
    assert "usage" in ended(sys.executable, FOLDER / f"{name}.py", "--help").stdout


@pytest.mark.parametrize("first", range(0, 100, 10))
def test_each_runs_within_bounds_or_is_refused(first):
    outcomes = {seed: scene_fuzzer.outcome(seed, 40) for seed in range(first, first + 10)}
    assert not {seed: what for seed, what in outcomes.items() if what not in ("ran", "refused")}


# At 500 m/s a contact loses its points for one step. Arrays count it as new then, YADE's engines a
# step before: its iterMadeReal differs, no force does.
OTHER_ITERATION = {12}


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_steps_in_arrays_and_of_engines_give_the_same_bits(first):
    found = {seed: run_fuzzer.difference(run_fuzzer.draw(seed))
             for seed in range(first, first + 10)}
    differ = {seed for seed, (what, _) in found.items() if what != "same"}
    assert differ == OTHER_ITERATION & found.keys(), found
    assert sum(steps for _, steps in found.values()) > 500


def test_a_contact_that_a_step_loses_and_finds_again_keeps_its_friction():
    scene = dict(
        seed=807, law="rigid", periodic=False, count=24, eta=0.6, kinds=["Sphere"], friction=0.8,
        restitution=0.5, gravity=0.0, dt=0.001, solver="nesterov", threads=1, overdamped=False,
        floor="Box", turning=True, speed=0.5, motion="shakers", strength=5.0, blocked=0, violent=2,
        runs=[22], events=[], energy=False)
    assert run_fuzzer.difference(scene)[0] == "same"


@pytest.mark.parametrize("first", range(0, 20, 10))
def test_steps_commute_with_symmetries(first):
    outcomes = {seed: symmetries.outcome(seed) for seed in range(first, first + 10)}
    assert not {seed: what for seed, (what, _) in outcomes.items() if what}
    assert sum(counts.get("compared", 0) for _, counts in outcomes.values()) > 200


@pytest.mark.parametrize("seed", [22325, 30078, 30624, 30940])
def test_scenes_that_once_broke_a_symmetry(seed):
    assert symmetries.outcome(seed)[0] is None


def test_a_transform_that_changes_the_gaps_alone_is_an_error():
    stretch = dict(turn=1.01)
    found = [symmetries.broken(small_scenes.random_scene(seed), stretch) for seed in range(20)]
    assert sum(map(bool, found)) >= 5


class MallInfo(ctypes.Structure):
    """The struct of mallinfo2() in the C library [B]."""

    _fields_ = [(name, ctypes.c_size_t) for name in "arena ordblks smblks hblks hblkhd usmblks "
                "fsmblks uordblks fordblks keepcost".split()]


def allocated():
    """Memory that malloc has given out [B]."""
    gc.collect()
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = MallInfo
    told = mallinfo2()
    return told.uordblks + told.hblkhd


def one_scene(law):
    """Twenty grains and clumps between walls, saved and loaded half-way; always the same scene."""
    rng = np.random.default_rng(7)
    scene = soak.draw(rng) | dict(law=law, dt=1e-3, periodic=False, gradient=None, gravity=9.81,
                                  turning=False, floor="Wall", overdamped=False)
    material = scene_fuzzer.begin(scene)
    soak.container(scene, material)
    for _ in range(20):
        soak.add(scene, material, rng)
    scene_fuzzer.engines(scene)
    steps(20)
    O.saveTmp()
    O.loadTmp()
    steps(20)
    O.reset()


@pytest.mark.slow
@pytest.mark.parametrize("law", ["rigid", "smooth"])
def test_scenes_leave_nothing(law):
    held = {id(o): o for o in gc.get_objects() if isinstance(o, wrapper.Serializable)}
    sizes = []
    for _ in range(2):
        for _ in range(SCENES):
            one_scene(law)
        dropped = soak.let_go(held)
        assert dropped >= 10 * SCENES, "YADE drops its references on engines now: the soak need not"
        sizes.append(allocated())
    lost = (sizes[1] - sizes[0]) / SCENES
    assert lost < LOST, f"{lost:.0f} B a scene"
