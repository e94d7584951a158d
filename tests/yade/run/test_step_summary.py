"""The summary of a session's steps, at the end of a script and in `rcr.info()`."""

import re

import pytest
import rcr
from forked import program

PILE = """
import rcr
from rcr import *

def pile(sweeps, steps):
    O.reset()
    O.bodies.append(rcr.wall('y', 0, sense=+1))
    O.bodies.append([particle((0, 0.01 + 0.0199 * k), R=0.01, eta=0) for k in range(20)])
    solver = ContactDynamics(maxIterations=sweeps, solver='nlgs')
    O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()]),
                 InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                                 [Ip2_FrictMat_FrictMat_CdPhys()],
                                 [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
                 solver, NewtonIntegrator(gravity=(0, -9.81, 0), damping=0)]
    O.dt = 1e-3
    O.run(steps, True)
    return solver
"""
SPRINGS = """
import rcr
from rcr import *
O.bodies.append([particle((0.03 * k, 0), R=0.01, eta=0) for k in range(2)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Rcr_Aabb()]),
             InteractionLoop([Ig2_Rcr_Rcr_RcrGeom()],
                             [Ip2_FrictMat_FrictMat_FrictPhys(kn=MatchMaker(algo='val', val=1e6))],
                             [Law2_RcrGeom_FrictPhys_CundallStrack()]),
             NewtonIntegrator(damping=0)]
O.dt = 1e-6
O.run(30, True)
"""


def run(folder, text, **settings):
    """stdout of a script, and the lines of this package on stderr."""
    (folder / "scene.py").write_text(text)
    done = program(folder, "-n", "-x", "scene.py", **settings)
    return done.stdout, [line for line in done.stderr.splitlines()
                         if line.startswith(("yade-rcr: ", "scene.py: "))]


def test_the_line_has_the_missed_steps_of_all_scenes(tmp_path):
    """A reset, a saved scene and single steps lose or repeat no step."""
    out, lines = run(tmp_path, PILE + """
one = pile(2, 40)
missed, deepest, error = one.missedSteps, one.deepestOverlap, min(one.errorEstimate, 1)
two = pile(10000, 30)
missed, deepest = missed + two.missedSteps, max(deepest, two.deepestOverlap)
O.saveTmp()
before = two.missedSteps
for step in range(5):
    O.step()
missed += two.missedSteps - before
O.loadTmp()
O.run(5, True)
(three,) = [engine for engine in O.engines if isinstance(engine, ContactDynamics)]
missed += three.missedSteps - before
print("RESULT", missed, max(deepest, three.deepestOverlap), error)
""")
    missed, deepest, error = map(float, re.search("RESULT (.*)", out)[1].split())
    found = re.fullmatch(r"yade-rcr: 80 steps, ([\d.]+) ms a step; (\d+) of 80 did not "
                         r"converge \(([\d.]+) %\), error up to ([\d.]+) %( or more)?; "
                         r"deepest overlap ([\d.e-]+) "
                         r"\(R₁ \+ R₂\)", *lines)
    assert found, lines
    assert 20 <= missed == int(found[2]) and float(found[3]) == pytest.approx(100 * missed / 80, rel=6e-3)
    assert float(found[4]) >= 95 * error > 1
    assert float(found[6]) == pytest.approx(deepest, rel=0.06)  # two digits
    assert 0.001 < float(found[1]) < 100


@pytest.mark.parametrize("code, pattern", [
    (PILE + "pile(10000, 50)", r"50 steps, .* a step; all converged; deepest overlap .*"),
    (SPRINGS, r"30 steps, [\d.]+ ms a step"),
    ("import rcr", None),
    ("import rcr, yade\nO.run(10, True)", None),  # nothing of this package
])
def test_the_line_of_other_scripts(code, pattern, tmp_path):
    _, lines = run(tmp_path, code)
    assert len(lines) == (pattern is not None)
    assert not lines or re.fullmatch("yade-rcr: " + pattern, lines[0]), lines


def test_an_error_that_is_rounding_has_no_digits(tmp_path):
    """Steps miss because a rod that turns by 3 rad intrudes, not because of their error."""
    _, lines = run(tmp_path, """
import rcr
from rcr import *
O.bodies.append([particle((0, 0), R=0.01, eta=0.95),
                 particle((0.013, 0.009), R=0.01, eta=0.95, angle=1.26, angular_velocity=100)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Rcr_Aabb()]),
             InteractionLoop([Ig2_Rcr_Rcr_RcrGeom()], [Ip2_FrictMat_FrictMat_CdPhys()],
                             [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
             ContactDynamics(), NewtonIntegrator(damping=0)]
O.dt = 0.03
O.run(20, True)
""")
    missed = r"\d of 20 did not converge \(\d+ %\), error below 0.01 %; "
    assert re.search(missed, lines[-1]), lines


def test_an_error_is_the_last_line(tmp_path):
    _, lines = run(tmp_path, PILE + """
def main():
    pile(10000, 50)
    raise ValueError("wrong")
rcr.script.run(main)
""", code=1)
    assert lines[0].startswith("yade-rcr: 50 steps") and lines[1:] == ["scene.py: wrong"]


def test_info_has_the_summary(tmp_path):
    out, _ = run(tmp_path, PILE + """
print(1, rcr.info()['steps'])
pile(10000, 50)
print(2, rcr.info()['steps'])
print(3, rcr.info()['steps'])
""")
    assert "1 none\n" in out and "2 50 steps, " in out
    twice = re.search("^2 (.*)\n3 (.*)$", out, re.MULTILINE)
    assert twice[1] == twice[2]
    assert rcr.info()["steps"] is not None
