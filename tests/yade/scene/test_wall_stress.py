"""Mobile walls: the direction of their motion under WallStress, and walls that meet."""

import math

import pytest
import rcr
import yade.utils
from scenes import G, assert_refused, build, material, solver, steps, warns, weightless
from yade import O


def pressed_wall(side, stress, end=1, mass=2.0):
    """A wall at x = side under a stress, between walls 3 m apart; without a mass it is fixed."""
    wall = rcr.mobile_wall("x", side, mass) if mass else rcr.wall("x", side)
    weightless(rcr.wall("y", 0), rcr.wall("y", 3.0), wall,
               before=[rcr.WallStress(wall=2, start=0, end=end, stress=stress)])


@pytest.mark.parametrize("side", [0, 2])
@pytest.mark.parametrize("stress", [-50.0, 50.0])
def test_sign_of_the_stress(side, stress):
    """The wall moves by ½ (3 σ/m) t², up to the leapfrog's dt/t."""
    pressed_wall(side, stress)
    steps(100)
    way = O.bodies[2].state.pos[0] - side
    assert way == pytest.approx(0.5 * 3 * stress / 2 * 0.1**2, rel=0.011)


@pytest.mark.parametrize("lid", [yade.utils.box((0, 1.1, 0), (1.5, 0.1, 0.1), fixed=True),
                                 rcr.segment((-1.5, 1), (1.5, 1))], ids=["box", "segment"])
def test_a_lid_that_is_no_wall_is_pressed_by_a_permanent_force(lid):
    """The floor bears σ W and the weight of the lid and two grains (docs/obstacles.md)."""
    lid.state.mass, lid.state.blockedDOFs = 2.0, "xzXYZ"
    m = material(0)
    grains = [rcr.particle((x, 0.5), 0.5, 0, material=m) for x in (-1, 1)]
    floor, *_, plate = build(rcr.wall("y", 0, material=m), *grains, lid, dt=1e-3)
    O.forces.setPermF(plate, (0, -100 * 3, 0))
    steps(20)
    weight = (2 + sum(b.state.mass for b in grains)) * G
    assert -O.forces.f(floor)[1] == pytest.approx(300 + weight, rel=1e-9)  # rounding


@pytest.mark.parametrize("options, match", [
    *((dict(stress=stress), f"WallStress.stress = {stress:g}; expected a finite stress")
      for stress in (math.nan, math.inf)),
    (dict(end=0), "WallStress.start and WallStress.end are both 0, so that the pressed length is 0"),
    (dict(mass=0), "WallStress.wall = 2 is held along x, so that no stress moves it; take "
     "rcr.mobile_wall"),
])
def test_faults_of_a_wall_under_stress(options, match):
    """A dead engine has none."""
    pressed_wall(2, **dict(stress=-10) | options)
    assert_refused(match)
    O.engines[3].dead = True
    O.step()


BEHIND = "body #3 lies behind a wall, body #0"


def falling_wall(height, senses, masks=(1, 1), **options):
    """A mobile wall falls from this height towards a fixed one, beside a grain at rest."""
    m = material(0.5)
    floor, lid = rcr.wall("y", 0, senses[0], material=m), rcr.mobile_wall("y", height, 2, senses[1])
    floor.mask, lid.mask = masks
    floor.mask |= 4
    build(floor, lid, rcr.wall("y", -1, 1, material=m),
          rcr.particle((0, -0.9), 0.1, 0.5, material=m, mask=4), dt=1e-3, tolerance=1e-4)


@pytest.mark.parametrize("arrays", [True, False])
@pytest.mark.parametrize("height, senses", [(0.3, (1, -1)), (0.3, (0, 0)), (0.3, (1, 1)),
                                            (0.0, (1, -1))])
def test_a_mobile_wall_does_not_fall_through_another_one(height, senses, arrays):
    """It falls freely: the step before it crosses the wall, up to rounding, is the last one."""
    falling_wall(height, senses)
    solver().arrays = arrays
    # the grain below the floor; a floor that bears on both sides has no side behind it
    behind = warns(BEHIND, when=senses[0])
    with behind, pytest.raises(RuntimeError,
                               match="would move bodies #0 and #1, two walls, through"):
        O.run(400, True)
    speed = 1.001 * math.sqrt(2 * G * height) + 2 * G * O.dt
    assert 0 <= O.bodies[1].state.pos[1] <= speed * O.dt


def test_walls_that_may_cross():
    """Those of other masks, and driven ones."""
    falling_wall(0.3, (1, -1), masks=(1, 2))
    with warns(BEHIND):
        O.run(400, True)
    assert O.bodies[1].state.pos[1] < -0.1
    falling_wall(0.3, (1, -1))
    O.bodies[1].state.blockedDOFs, O.bodies[1].state.vel = "xyzXYZ", (0, -1, 0)
    with warns(BEHIND):
        O.run(400, True)
    assert O.bodies[1].state.pos[1] == pytest.approx(-0.1)
