"""Repeated scenes leak no memory; tests/endurance/soak.py runs for hours."""

import ctypes
import gc
import pathlib
import sys

import numpy as np
import pytest
from yade import O, wrapper

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "endurance"))
import scene_fuzzer  # noqa: E402
import soak  # noqa: E402

SCENES = 25
LOST = 0.5e3  # most bytes a scene; measured 0.1e3, about one contact


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
    soak.run(20)
    O.saveTmp()
    O.loadTmp()
    soak.run(20)
    O.reset()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
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
