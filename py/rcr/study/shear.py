"""Shear of the biaxial test: the top wall closes at a given rate, σ₀ acts on both side walls.

The top wall moves at the rate ε̇ = I/t₀ of the first height. The strain is (h₀ − h)/h₀. A record
is 0.1 % of strain, ends at a multiple of it and gives a row of the history. Up to the strain
`approach` the shear is quick: I is `Protocol.quick_inertial_number` at most. Beyond it, I is the
smaller one of `inertial_number` and `largest_rate`.

The side walls are free and carry equal forces, and no wall has friction. So the momentum of
grains and side walls along x stays 0, and the packing spreads from its middle.

In the homogeneous flow u = ε̇ (x, −y) at a constant area, a grain at x from the middle accelerates
by (v̇/h + 2 ε̇²) x, with the speed v = ε̇ h of the top wall. The stress in the middle deviates from
that at the walls by

    ρ (v̇/h + 2 ε̇²) W²/8

`largest_slope` bounds its first part, which brakes or accelerates the packing, by
`Protocol.acceleration_stress` σ₀; `largest_rate` bounds the second one.
Needs YADE.
"""

import math

import numpy as np
from yade import utils
from yade.wrapper import Ip2_FrictMat_FrictMat_FrictPhys, MatchMaker, Omega

import rcr
from rcr.network import sin_phi
from rcr.study.compaction import rest, stress_deviation
from rcr.study.protocol import HALF_RECORD, PROTOCOL
from rcr.study.records import COUNTERS, HISTORY_COLUMNS, Springs

O = Omega()


def start(test):
    """Turn a compacted packing into the initial state of the shear."""
    solver, parameters = test.solver, test.parameters
    test.isotropic = test.network()
    test.progress.update(COUNTERS, phase="shear", first_step=O.iter, first_height=test.height,
                         packing_fraction_initial=test.packing_fraction,
                         unbalance_initial=solver.unbalancedForce,
                         stress_deviation_initial=stress_deviation(test))
    solver.tolerance, solver.maxIterations = parameters["tolerance"], parameters["iterations"]
    solver.overdamped = solver.trackMeanStretch = False
    solver.yieldCompliance = PROTOCOL.yield_compliance
    rest()
    _set_friction(test, parameters["friction"], parameters["rolling_friction"])
    _load_side_walls(test)
    if parameters["law"] == "smooth":
        switch_to_springs(test, parameters["stiffness"])


def _load_side_walls(test):
    """Free the left wall under σ₀ and drive the top one."""
    for engine in O.engines:
        if isinstance(engine, rcr.WallStress):
            engine.dead = engine.wall == test.top
    O.bodies[test.left].state.blockedDOFs = O.bodies[test.right].state.blockedDOFs
    O.bodies[test.top].state.blockedDOFs = "xyzXYZ"


def _set_friction(test, friction, rolling):
    """Set both frictions between grains; walls stay smooth."""
    grain = O.materials["grain"]
    grain.frictionAngle = math.atan(friction)  # of contacts that form later
    if rolling:
        loop = utils.typedEngine("InteractionLoop")
        loop.physDispatcher.functors[0].rollingFriction = MatchMaker(
            matches=((grain.id, grain.id, rolling),), algo="val", val=0)
    for i in O.interactions:
        if i.isReal and max(i.id1, i.id2) < test.left:
            i.phys.tangensOfFrictionAngle = friction
            i.phys.rollingFriction = rolling


def switch_to_springs(test, stiffness):
    """Replace rigid contacts by unloaded springs of k_n = `stiffness` σ₀.

    The packing shrinks by about σ₀/k_n until they are loaded.
    """
    O.interactions.clear()
    O.engines = [engine for engine in O.engines if not isinstance(engine, rcr.ContactDynamics)]
    loop = utils.typedEngine("InteractionLoop")
    kn = stiffness * PROTOCOL.confining_stress
    kn, ks = (MatchMaker(algo="val", val=k) for k in (kn, PROTOCOL.shear_stiffness * kn))
    loop.physDispatcher.functors = [Ip2_FrictMat_FrictMat_FrictPhys(kn=kn, ks=ks)]
    damping = PROTOCOL.viscous_damping
    loop.lawDispatcher.functors = [rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=damping)]
    O.dt = PROTOCOL.smooth_time_step * rcr.critical_time_step()
    test.parameters.update(law="smooth", stiffness=stiffness)
    test.solver = Springs()


def share_done(test, end):
    """Return the share of the steps up to the strain `end` that the shear has made, estimated."""
    smooth = O.dt / test.time_unit if test.parameters["law"] == "smooth" else None
    slope = largest_slope(test)

    def steps(first):
        part = (end - first) / 100
        strains = first + part * (np.arange(100) + 0.5)
        rates = [min(math.sqrt(slope * strain), aimed_rate(test, strain)) for strain in strains]
        return sum(part / (rate * (smooth or time_step(test, rate))) for rate in rates)

    return 1 - steps(test.strain) / steps(0.0) if test.strain < end else 1.0


def aimed_rate(test, strain):
    """Return I at a strain, after the acceleration at the start."""
    given, approach = (test.parameters[name] for name in ("inertial_number", "approach"))
    slow = min(given, largest_rate(test, strain))
    quick = max(given, PROTOCOL.quick_inertial_number)
    braking = math.sqrt(largest_slope(test) * max(0, approach - strain))
    return max(slow, min(quick, braking))


def wall_speed(test, rate):
    """Return the speed of the top wall at a rate I [m/s]."""
    return rate / test.time_unit * test.progress["first_height"]


def next_rate(test):
    """Return I at the end of the next record: the aimed one, as far as `largest_slope` lets it."""
    length = next_record(test)
    square, change = test.progress["rate"] ** 2, largest_slope(test) * length
    low, high = math.sqrt(max(0, square - change)), math.sqrt(square + change)
    return min(max(low, aimed_rate(test, rounded(test.strain + length))), high)


def largest_rate(test, strain=None):
    """Return I at which ρ (ε̇ W/2)²/σ₀ has its bound, now or at a strain."""
    width, height = box(test, strain)
    density = PROTOCOL.density * test.packing_fraction
    bound = test.parameters["sample_inertia"] * PROTOCOL.confining_stress
    first = test.progress["first_height"]
    return 2 * test.time_unit * height / (first * width) * math.sqrt(bound / density)


def largest_slope(test):
    """Return the largest |dI²/dε| of an acceleration.

    v̇ = h₀/(2 t₀²) dI²/dε, and ρ W h = N m. The box has the first area, and the height at the
    strain `approach`, where the braking ends, or the present one beyond.
    """
    first = test.progress["first_height"]
    area = test.area / test.progress["packing_fraction_initial"]
    height = min(first * (1 - test.parameters["approach"]), test.height)
    return 16 * PROTOCOL.acceleration_stress * height**3 / (len(test.grains) * area * first)


def box(test, strain=None):
    """Return width and height of the box, now or at a strain with the present area [m]."""
    height = test.height if strain is None else test.progress["first_height"] * (1 - strain)
    return test.area / (test.packing_fraction * height), height


def time_step(test, rate):
    """Return dt/t₀ at a rate I, at most; `Biaxial.go_back` divides it. Springs have their own."""
    given, step = test.parameters["inertial_number"], test.parameters["time_step"]
    shortest = min(step, PROTOCOL.quick_time_step)
    return min(max(step * given / rate, shortest), step) / test.progress["divisor"]


def next_record(test):
    """Return the strain from here to the end of the next record, at a multiple of a record."""
    whole = PROTOCOL.record_strain
    left = (math.floor(test.strain / whole + 0.5) + 1) * whole - test.strain
    return whole if math.isclose(left, whole, rel_tol=1e-6) else left


def step_rates(test, last):
    """Return I of each step of the next record, which ends at the rate `last`; set the time step.

    I changes uniformly in time. It is constant in a record in which it changes by no more than
    `largest_slope` lets it in a step. The time step is the largest up to `time_step` with which
    the record ends at its strain. Springs keep theirs, and I deviates by at most half a step.
    """
    first, length = test.progress["rate"], next_record(test)
    mean = (first + last) / 2
    if isinstance(test.solver, Springs):
        count = max(1, round(length * test.time_unit / (mean * O.dt)))
    else:
        count = max(1, math.ceil(length / (mean * time_step(test, max(first, last))) - 1e-6))
        O.dt = length / (mean * count) * test.time_unit
    step = O.dt / test.time_unit
    if abs(last - first) <= 0.5 * largest_slope(test) * step:
        first = last = mean
    shares = (np.arange(count) + 0.5) / count
    return (first + (last - first) * shares) * (length / (mean * count * step))


def _records_to(test, strain):
    """Return the number of records until the test has reached a strain."""
    left = strain - HALF_RECORD - test.strain
    return max(1, math.ceil(left / PROTOCOL.record_strain - 1e-6))


def _records_at_this_rate(test, most):
    """Return the number of records, at most `most`, with the present rate and the same length."""
    given, whole = test.parameters["inertial_number"], PROTOCOL.record_strain
    rate = test.progress["rate"]
    if next_record(test) != whole or next_rate(test) != rate:
        return 1
    if rate > given:  # the quick one, until the wall brakes
        braking = test.parameters["approach"] - rate**2 / largest_slope(test)
        return max(1, min(most, math.floor((braking - test.strain) / whole - 1e-6)))
    # the margin is for the dilation until then
    return most if given < 0.8 * largest_rate(test, test.strain + most * whole) else 1


def shear(test, records, end=1):
    """Shear by at most `records` records, each of 0.1 % of strain and with a row of the history.

    The shear stops at the first record, of this call, at which the test has reached the strain
    `end`. Records with equal wall speed and time step are one run of YADE, since each run reads
    all bodies once. The results are those of one run per record, to the bit. A packing that has
    blown up raises a RuntimeError.
    """
    while records > 0:
        together = _records_at_this_rate(test, min(records, _records_to(test, end)))
        last = next_rate(test)
        rates = step_rates(test, last)
        try:
            test.step(len(rates), together, wall_speed(test, rates))
        finally:
            for record in test.records:
                test.rows.append(history_row(test, record))
        test.progress["rate"] = last
        records = 0 if test.has_reached(end) else records - together


def rounded(strain):
    """Return a strain without rounding errors, so that records lie exactly at 0.003, 0.004, …"""
    return round(float(strain), 9)


def history_row(test, record):
    """Return the row of the history of a record; a RuntimeError if the packing has blown up."""
    stresses = np.array([record["stress_x"], record["stress_y"]])
    first = test.progress["first_height"]
    fraction = test.area / (record["width"] * record["height"])
    strain = (first - record["height"]) / first
    low, high = PROTOCOL.fraction_ratios
    ratio = fraction / test.progress["packing_fraction_initial"]
    if not (np.isfinite([*stresses, strain]).all() and low < ratio < high):
        shown = " and ".join(f"{s / PROTOCOL.confining_stress:.3g}" for s in stresses)
        raise RuntimeError(
            f"the packing has blown up by step {record['step']}, strain {strain:.4g}: "
            f"packing fraction {fraction:.4g}, stresses of the walls {shown} σ₀; "
            "take a smaller time step, inertial number or tolerance")
    found = record | dict(
        strain=rounded(strain), sin_phi=sin_phi(stresses), packing_fraction=fraction)
    return {name: found[name] for name in HISTORY_COLUMNS}
