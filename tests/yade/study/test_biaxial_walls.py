"""Walls of the biaxial test: acceleration by the top wall, symmetric side walls under σ₀."""

import dataclasses

import numpy as np
import pytest
import rcr
from rcr.study import checkpoint, records, shear
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL, check_parameters
from rcr.study.records import COUNTERS
from scenes import refused
from yade import O

STRESS = PROTOCOL.confining_stress


class Flow:
    """A packing of a given number of grains that flows homogeneously at a constant area.

    It takes the steps of `shear` without YADE and keeps speed and length of each.
    """

    solver = None
    packing_fraction = 0.8
    time_unit = 0.01

    def __init__(self, particles, aspect=1.0, **parameters):
        self.parameters = check_parameters(particles=particles, **parameters)
        self.grains = range(particles)
        self.area = particles * self.time_unit**2 * STRESS / PROTOCOL.density
        self.height = (self.area / self.packing_fraction / aspect) ** 0.5
        self.progress = dict(COUNTERS, first_height=self.height,
                             packing_fraction_initial=self.packing_fraction)
        self.rows, self.records, self.steps = [], [], []

    @property
    def strain(self):
        return shear.rounded(1 - self.height / self.progress["first_height"])

    @property
    def width(self):
        return self.area / self.packing_fraction / self.height

    def has_reached(self, strain):
        return self.strain >= strain - 0.5e-3

    def step(self, count, times, speeds):
        self.records = []
        for speed in (*speeds,) * times:
            self.steps.append((speed, O.dt, self.width, self.height))
            self.height -= speed * O.dt

    def stresses_of_acceleration(self):
        """Return ρ (v̇/h) W²/8 and ρ 2 ε̇² W²/8 of each step [σ₀], from rest on."""
        speed, dt, width, height = np.transpose(self.steps)
        scale = PROTOCOL.density * self.packing_fraction * width**2 / 8 / STRESS
        change = np.diff(speed, prepend=0) / dt
        return scale * change / height, scale * 2 * (speed / height) ** 2


@pytest.mark.parametrize("aspect", [0.8, 1.3])
@pytest.mark.parametrize("particles, rates", [
    (20, dict()), (1000, dict()), (13_000, dict()), (200_000, dict()),
    (4000, dict(inertial_number=5e-4, sample_inertia=1)), (4000, dict(approach=0)),
    (4000, dict(approach=0.24, time_step=0.05))])
def test_acceleration_takes_less_than_a_hundredth_of_the_stress(particles, rates, aspect):
    """In each step up to a strain of 0.5, also those in which the rate of wide boxes falls."""
    flow = Flow(particles, aspect, **rates)
    shear.shear(flow, np.inf, 0.5)
    assert flow.strain == 0.5 and not flow.rows
    change, steady = flow.stresses_of_acceleration()
    assert np.abs(change).max() < 1.3 * PROTOCOL.acceleration_stress  # dt shrinks in between
    assert np.abs(change + steady).max() < 0.01
    if particles > 20 and rates.get("approach") != 0:  # it brakes as hard as it may
        assert change.min() < -0.5 * PROTOCOL.acceleration_stress
    speed, dt, width, height = np.transpose(flow.steps)
    rate = flow.time_unit * speed / flow.progress["first_height"]
    assert (rate * dt / flow.time_unit <= PROTOCOL.record_strain * (1 + 1e-9)).all()
    slow = height < flow.progress["first_height"] * (1 - flow.parameters["approach"])
    limits = np.minimum(flow.parameters["inertial_number"], [
        shear.largest_rate(flow, 1 - h / flow.progress["first_height"]) for h in height[slow]])
    late = height[slow] < 0.85 * flow.progress["first_height"]
    assert rate[slow][late] == pytest.approx(limits[late], rel=0.01)


def momentum(test):
    """Return momentum and centre of grains and side walls along x, over their mass [d/t₀, d]."""
    bodies = [O.bodies[i].state for i in (*test.grains, test.left, test.right)]
    mass = np.array([s.mass for s in bodies])
    speed, place = (np.array([getattr(s, name)[0] for s in bodies]) for name in ("vel", "pos"))
    mean = lambda of: mass @ of / mass.sum() / test.diameter
    return mean(speed) * test.time_unit, mean(place)


@pytest.mark.parametrize("law", ["cd", "smooth"])
def test_the_packing_spreads_from_its_middle(law):
    """Side walls have equal loads: the centre of all that moves stays, both walls move outwards."""
    test = Biaxial.prepare(eta=0.3, particles=100, seed=1, law=law, iterations=300)
    test.compact(balanced=0.01)
    centre, places = momentum(test)[1], [O.bodies[k].state.pos[0] for k in (test.left, test.right)]
    test.shear(40)
    loads = {e.wall: e.stress for e in O.engines if isinstance(e, rcr.WallStress) and not e.dead}
    assert loads == {test.left: STRESS, test.right: -STRESS}
    masses = {O.bodies[k].state.mass for k in (test.left, test.right)}
    assert len(masses) == 1 and min(masses) > 0
    moved = [O.bodies[k].state.pos[0] - place
             for k, place in zip((test.left, test.right), places)]
    spread = moved[1] - moved[0]
    assert moved[0] < -0.2 * spread < 0 < 0.2 * spread < moved[1]
    assert spread > 0.01 * test.width
    rate, place = momentum(test)
    assert abs(rate) < 1e-12 and abs(place - centre) < 1e-11


def test_both_side_walls_carry_the_confining_stress(monkeypatch):
    """Each wall on its own, in the mean over records."""
    test = Biaxial.prepare(eta=0, particles=100, seed=2, iterations=300)
    stresses, add = [], records._add_record

    def keep(test, observation, width, height):
        stresses.append([abs(observation["forces"][wall][0]) / height
                         for wall in (test.left, test.right)])
        add(test, observation, width, height)

    test.compact(balanced=0.01)
    monkeypatch.setattr(records, "_add_record", keep)
    test.shear(20)
    assert len(stresses) == 20
    assert np.mean(stresses, axis=0) == pytest.approx([STRESS, STRESS], rel=0.02)


def test_checkpoints_of_other_constants_are_refused(tmp_path, monkeypatch):
    test = Biaxial.prepare(eta=0, particles=20, seed=1)
    test.save(tmp_path)
    changed = dataclasses.replace(PROTOCOL, acceleration_stress=0.1)
    monkeypatch.setattr(checkpoint, "PROTOCOL", changed)
    refused("a checkpoint of other constants than those of rcr.study.protocol; start again with "
            "--overwrite", Biaxial.load, tmp_path)
