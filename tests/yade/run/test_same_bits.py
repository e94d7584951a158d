"""A shear test gives the same bits for any threads and lanes, on any processor with FMA."""

import hashlib

import numpy as np
import pytest
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from scenes import python, snapshot
from yade import O
from yade.minieigenHP import Vector3

STEPS = 1000


def shear(folder, threads, lanes):
    """Yield after each step a digest of velocities, contact points and starting impulses."""
    test = Biaxial.load(folder)
    test.solver.threads, test.solver.lanes = threads, lanes
    speed = PROTOCOL.quick_inertial_number / test.time_unit * test.progress["first_height"]
    O.bodies[test.top].state.vel = Vector3(0, -speed, 0)
    O.dt = PROTOCOL.quick_time_step * test.time_unit
    for _ in range(STEPS):
        O.step()
        digest = hashlib.blake2b()
        for column in test.solver._problem().values():
            digest.update(column)
        yield digest.digest()


@pytest.mark.slow
def test_threads_and_lanes_change_no_bit(tmp_path):
    """Velocities, contact points and impulses of each of 1000 steps of shear of 1000 particles."""
    test = Biaxial.prepare(eta=0.5, particles=1000, seed=1, tolerance=1e-3)
    test.compact(balanced=0.05)  # until they carry load
    test.save(tmp_path)
    reference = list(shear(tmp_path, threads=1, lanes=8))
    last = snapshot()
    assert len(set(reference)) == STEPS
    for threads, lanes in ((2, 4), (4, 1)):
        for step, digest in enumerate(shear(tmp_path, threads, lanes)):
            assert digest == reference[step], f"step {step}, {threads} threads, {lanes} lanes"
        assert np.array_equal(snapshot(), last), f"{threads} threads, {lanes} lanes"


SMALL = """
import hashlib
from scenes import *
from rcr.study.biaxial import Biaxial
test = Biaxial.prepare(eta=0.5, particles=60, seed=1, tolerance=1e-3)
test.solver.threads, test.solver.lanes = {threads}, {lanes}
test.compact(balanced=0.05)
for _ in range(3):
    test.shear_record()
print(O.iter, hashlib.blake2b(snapshot()[:, :13].tobytes()).hexdigest())
"""
# Instructions that NumPy and the C library use; `lanes` sets those of the kernels. Without FMA
# sine, cosine and arctangent of the C library differ in the last bit (6 of 10⁴, glibc 2.41).
OLDER = dict(GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX512F,-AVX512VL",
             NPY_DISABLE_CPU_FEATURES="AVX512F AVX512CD AVX512_SKX AVX512_ICL AVX512_SPR AVX2")


@pytest.mark.slow
def test_another_processor_with_fma_changes_no_bit():
    """60 long grains, sheared in two processes, one with fewer instructions and two threads."""
    one, two = (python(SMALL.format(threads=threads, lanes=lanes), **changes).stdout
                for changes, threads, lanes in (({}, 1, 0), (OLDER, 2, 4)))
    assert one.splitlines()[-1] == two.splitlines()[-1]
