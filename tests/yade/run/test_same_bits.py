"""A shear test gives the same bits for any threads and lanes, on any processor with FMA."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from yade import O
from yade.minieigenHP import Vector3

STEPS = 1000
RUNS = [(1, 8), (2, 4), (4, 1)]  # (threads, lanes)
ENTRIES = [f"state.{name}[{k}]" for name, size in (("pos", 3), ("ori", 4), ("vel", 3),
                                                   ("angVel", 3)) for k in range(size)]


@pytest.fixture(scope="module")
def packing(tmp_path_factory):
    """Checkpoint of 1000 long particles, compacted until they carry load, before shear."""
    test = Biaxial.prepare(eta=0.5, particles=1000, seed=1, tolerance=1e-3)
    test.compact(balanced=0.05)
    folder = str(tmp_path_factory.mktemp("packing"))
    test.save(folder)
    return folder


def shear(folder, threads, lanes, steps):
    """Yield after each step a digest of velocities, contact points and starting impulses."""
    test = Biaxial.load(folder)
    test.solver.threads, test.solver.lanes = threads, lanes
    speed = PROTOCOL.quick_inertial_number / test.time_unit * test.progress["first_height"]
    O.bodies[test.top].state.vel = Vector3(0, -speed, 0)
    for _ in range(steps):
        O.step()
        digest = hashlib.blake2b()
        for column in test.solver._problem().values():
            digest.update(column)
        yield digest.digest()


def bodies():
    """Positions, orientations and velocities of the bodies, as ENTRIES; (bodies, 13)."""
    return np.array([(*b.state.pos, *b.state.ori, *b.state.vel, *b.state.angVel) for b in O.bodies])


def state_after(folder, threads, lanes, steps):
    for _ in shear(folder, threads, lanes, steps):
        pass
    return bodies()


@pytest.mark.slow
def test_threads_and_lanes_change_no_bit(packing):
    """1000 steps of shear of 1000 particles (η = 0.5, friction 0.5, 5 % of strain), compared step
    by step.

    Three runs take 1, 2 and 4 threads and 8, 4 and 1 lanes. The contact problems of all steps hold
    velocities, contact points and impulses of the step before; at the end the positions are
    compared too. Threads that share a processor also vary the order of work. test_session.py
    varies YADE's own threads.
    """
    first, *others = RUNS
    reference = list(shear(packing, *first, STEPS))
    last = bodies()
    assert len(set(reference)) == STEPS
    for run in others:
        for step, digest in enumerate(shear(packing, *run, STEPS)):
            if digest != reference[step]:
                pytest.fail(difference(packing, first, run, step))
        assert np.array_equal(bodies(), last), difference(packing, first, run, STEPS)


def difference(folder, first, second, step):
    """The first step with a different result and a body that shows it, from two more runs."""
    one, two = (state_after(folder, *run, step) for run in (first, second))
    different = np.flatnonzero((one != two).any(axis=1))
    where = f"first in step {step} of {STEPS}: "
    if not len(different):
        where = f"in step {step + 1} of {STEPS}, of equal bodies: "
        one, two = (state_after(folder, *run, step + 1) for run in (first, second))
        different = np.flatnonzero((one != two).any(axis=1))
    runs = " and ".join("{} threads with {} lanes".format(*run) for run in (first, second))
    if not len(different):
        return f"{runs} differ {where}the forces of contacts alone"
    body = int(different[0])
    entry = int(np.flatnonzero(one[body] != two[body])[0])
    values = f"{ENTRIES[entry]} = {one[body, entry].item()} and {two[body, entry].item()}"
    return f"{runs} differ {where}body #{body} with {values} ({len(different)} bodies in all)"


SMALL = """if True:
    import hashlib, sys
    import numpy as np
    import yade, rcr
    from rcr.study.biaxial import Biaxial
    from yade import O
    test = Biaxial.prepare(eta=0.5, particles=60, seed=1, tolerance=1e-3)
    test.solver.threads, test.solver.lanes = map(int, sys.argv[1:])
    test.compact(balanced=0.05)
    for _ in range(3):
        test.shear_record()
    state = np.array([(*b.state.pos, *b.state.ori, *b.state.vel, *b.state.angVel) for b in O.bodies])
    print(O.iter, hashlib.blake2b(state.tobytes()).hexdigest())
"""
# Instructions that NumPy and the C library use; `lanes` sets those of the kernels. A processor
# without FMA is left out: there sine, cosine and arctangent of the C library differ in the last bit
# (6 of 10⁴ results, glibc 2.41).
OLDER = dict(GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX512F,-AVX512VL",
             NPY_DISABLE_CPU_FEATURES="AVX512F AVX512CD AVX512_SKX AVX512_ICL AVX512_SPR AVX2")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_another_processor_with_fma_changes_no_bit():
    """60 long grains, sheared in two processes, one with fewer instructions and two threads."""
    told = []
    for changes, threads, lanes in (({}, 1, 0), (OLDER, 2, 4)):
        command = [sys.executable, "-c", SMALL, str(threads), str(lanes)]
        done = subprocess.run(command, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
                              | changes, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        told.append(done.stdout.splitlines()[-1])
    assert told[0] == told[1]
