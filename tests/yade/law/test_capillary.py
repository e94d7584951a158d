"""Liquid bridges between rigid grains: closed forms, rupture, history, energy."""

import numpy as np
import pytest
import rcr
from scenes import (ALL_IG2, G, assert_reload_changes_nothing, build, exchange, kinetic,
                    material, set_state, snapshot, solver, steps, weightless)
from yade import O
from yade.wrapper import InteractionLoop, MatchMaker

R, RUPTURE = 0.1, 0.02  # the range of detection of slow discs is 0.002
TIGHT = dict(solver="auto", tolerance=1e-12)


def wet(pull, rupture=RUPTURE, restitution=0.0):
    """Replace the law of the scene by bridges of this force [N] and rupture length [m]."""
    constant = lambda value: MatchMaker(algo="val", val=value)
    ip2 = rcr.Ip2_FrictMat_FrictMat_CdPhys(adhesion=constant(pull),
                                           restitution=constant(restitution))
    law = rcr.Law2_RcrGeom_CdPhys_Capillary(rupture=rupture)
    exchange(InteractionLoop([getattr(rcr, name)() for name in ALL_IG2], [ip2], [law]))


def pair(distance=2 * R, make=weightless, fixed=False, **options):
    """Two discs, the second below the first; the weight of one [N]."""
    m = material(0.5)
    make(rcr.disc((0, 0), R, material=m, fixed=fixed), rcr.disc((0, -distance), R, material=m),
         **{**TIGHT, "dt": 1e-4, **options})
    return O.bodies[1].state.mass * G


def gap():
    return (O.bodies[0].state.pos - O.bodies[1].state.pos).norm() - 2 * R


def bridged():
    return any(i.phys.bridge for i in O.interactions)


def test_a_bridge_holds_a_weight_below_its_force():
    weight = pair(make=build, fixed=True)
    wet((1 + 1e-6) * weight)
    steps(200)
    assert bridged() and abs(gap()) < 1e-9
    assert O.interactions[0, 1].phys.force1[0] == pytest.approx(-weight, rel=1e-9)


def test_a_heavier_weight_falls_and_breaks_the_bridge():
    """a = g − f_c/m up to the rupture length, then g: far beyond the range of detection."""
    share = 0.5
    pull = share * pair(make=build, fixed=True)
    wet(pull)
    disc, seen = O.bodies[1].state, {}
    for _ in range(1300):
        before, width = disc.vel[1], gap()
        O.step()
        reached = width <= RUPTURE
        fall = (before - disc.vel[1]) / O.dt
        assert fall == pytest.approx(G * (1 - share if reached else 1), rel=1e-6)
        assert bridged() == reached
        seen[reached] = width
    assert seen[True] > 0.99 * RUPTURE and seen[False] > 2 * RUPTURE
    assert len(O.interactions) == 0 or not O.interactions[0, 1].isReal
    # v² = 2 (g − f_c/m) d at rupture, then v² grows by 2 g per length
    expected = 2 * G * (gap() - share * RUPTURE)
    assert disc.vel[1] ** 2 == pytest.approx(expected, rel=1e-2)


def test_no_bridge_without_a_contact():
    pair(2 * R + 0.5 * RUPTURE)
    wet(5.0)
    steps(100)
    assert gap() == pytest.approx(0.5 * RUPTURE) and not bridged()
    set_state(1, vel=(0, 1e-1, 0))  # meets the other, and sticks to it
    steps(1200)
    assert bridged() and abs(gap()) < 1e-4 * R
    assert kinetic() == pytest.approx(0.25 * O.bodies[1].state.mass * 1e-2, rel=1e-3)


@pytest.mark.parametrize("share", [0.5, 0.9, 1.1, 2.0])
def test_discs_part_if_their_energy_exceeds_the_work_of_the_bridge(share):
    """The relative motion loses f_c · rupture; both momenta add up to zero."""
    pair(dt=1e-3)
    pull = 2.0
    wet(pull)
    mass, work = O.bodies[0].state.mass, pull * RUPTURE
    O.step()  # a bridge forms
    speed = np.sqrt(share * work / mass)
    set_state(0, vel=(0, speed, 0))
    set_state(1, vel=(0, -speed, 0))
    widest = 0
    for _ in range(3000):
        O.step()
        widest = max(widest, gap())
        assert (O.bodies[0].state.vel + O.bodies[1].state.vel).norm() < 1e-9 * speed
        assert O.bodies[0].state.angVel.norm() < 1e-9
    assert (widest > RUPTURE) == (share > 1) and bridged() == (share < 1)
    if share < 1:
        assert widest == pytest.approx(share * RUPTURE, rel=0.01)
        assert kinetic() < 1e-9 * work and abs(gap()) < 1e-4 * R
    else:
        assert kinetic() == pytest.approx((share - 1) * work, abs=0.01 * work)


def test_a_rebound_within_one_step_makes_a_bridge():
    """The gap exceeds the slop before and after this step."""
    pair(2 * R + 0.2 * RUPTURE, dt=1e-3)
    wet(1e-3, restitution=1.0)
    set_state(1, vel=(0, 5.0, 0))  # 0.25 RUPTURE in a step
    O.step()
    assert O.bodies[0].state.vel[1] > 4 and gap() > 1e-2 * RUPTURE and not bridged()
    O.step()
    assert bridged()


def test_a_late_contact_leaves_the_bridge():
    """A shot disc pushes one end of a bridge onto another disc within a step."""
    m, pull = material(0.0), 5.0
    disc = lambda x: rcr.disc((x, 0), R, material=m)
    rod = rcr.particle((0, 1.5 * R), R, 0.5, material=m)
    weightless(disc(0), rod, disc(-2.1 * R), disc(2 * R + 0.0025), dt=1e-4, **TIGHT)
    wet(pull)
    O.step()
    other = O.bodies[1].state
    other.vel = (0, 1, 0)
    steps(180)
    assert bridged()
    set_state(2, pos=(-2 * R - 1e-4, O.bodies[0].state.pos[1], 0), vel=(60, 0, 0))
    before = other.vel[1]
    O.step()
    assert O.bodies[3].state.vel[0] > 1  # late: its gap exceeds the range of detection
    assert before - other.vel[1] == pytest.approx(pull * O.dt / other.mass, rel=1e-9)


def test_facing_sides_have_two_points():
    """f_c of each point acts at the same distance on both sides, so the rod does not turn."""
    m, pull = material(0.5), 3.0
    weightless(rcr.wall("y", 0, material=m), rcr.particle((0, R / 2), R, 0.5, material=m),
               dt=1e-4, **TIGHT)
    wet(pull)
    O.step()
    set_state(1, vel=(0, 0.1, 0))
    steps(100)
    rod = O.bodies[1].state
    slowed = 0.1 - 100 * O.dt * 2 * pull / rod.mass
    assert rod.vel[1] == pytest.approx(slowed, rel=1e-9) and abs(rod.angVel[2]) < 1e-9


def test_the_energy_closes():
    pull = 0.5 * pair(make=build, fixed=True)
    wet(pull)
    O.trackEnergy = True
    O.step()
    start = O.energy.total()
    steps(1500)
    fallen = kinetic()
    assert O.energy.total() == pytest.approx(start, abs=5e-3 * fallen)
    assert O.energy["impactDissip"] == pytest.approx(pull * RUPTURE, rel=0.01)


def test_the_network_contains_open_bridges():
    pull = 0.5 * pair(make=build, fixed=True)
    wet(pull)
    steps(400)
    assert gap() > 0.1 * RUPTURE
    network = rcr.contact_network()
    np.testing.assert_allclose(np.abs(network.contacts["force"]), [[0, pull]], rtol=1e-9)


def test_a_reload_keeps_open_bridges(tmp_path):
    pair(make=build, fixed=True)
    wet(5.0)
    set_state(1, vel=(0, -0.3, 0))
    steps(100)
    assert bridged() and gap() > 0.1 * RUPTURE
    assert_reload_changes_nothing(tmp_path / "wet.yade",
                                  lambda: (steps(50), snapshot().tobytes(), bridged())[1:])


def test_bridges_cross_the_edge_of_a_periodic_cell():
    m, pull = material(0.5), 2.0
    weightless(rcr.disc((R, 0.5), R, material=m), rcr.disc((1 - R, 0.5), R, material=m),
               cell=1.0, dt=1e-4, **TIGHT)
    wet(pull)
    O.step()
    set_state(0, vel=(0.1, 0, 0))
    steps(100)
    slowed = 100 * O.dt * pull / O.bodies[0].state.mass
    np.testing.assert_allclose([O.bodies[k].state.vel[0] for k in (0, 1)],
                               [0.1 - slowed, slowed], rtol=1e-9)


@pytest.mark.parametrize("rupture", [-1e-3, float("nan"), float("inf")])
def test_wrong_lengths_are_refused(rupture):
    with pytest.raises(ValueError, match="rupture = .*; expected a length"):
        rcr.Law2_RcrGeom_CdPhys_Capillary(rupture=rupture)
