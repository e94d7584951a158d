"""Shear of the biaxial test: the top wall closes at a given rate, σ₀ acts on the right wall.

The top wall moves at the rate ε̇ = I/t₀ of the first height. The strain is (h₀ − h)/h₀. A record
is 0.1 % of strain and gives a row of the history; after the ramp it ends at a multiple of this
strain. Up to the strain `approach` the shear is quick:
`Protocol.quick_inertial_number`. Beyond `approach`, the rate falls within `Protocol.slowing_strain`
until ρ (v W/h)² ≤ `sample_inertia` σ₀ (v: speed of the top wall).
Needs YADE.
"""

import math

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
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
    for engine in O.engines:
        if isinstance(engine, rcr.WallStress) and engine.wall == test.top:
            engine.dead = True
    O.bodies[test.top].state.blockedDOFs = "xyzXYZ"
    if parameters["law"] == "smooth":
        switch_to_springs(test, parameters["stiffness"])
    else:
        O.dt = rate_and_step(test)[1] * test.time_unit


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


def is_approaching(test, strain=None):
    """Return whether the test, or a strain, has not reached the strain `approach`."""
    strain = test.strain if strain is None else strain
    return strain < test.parameters["approach"] - HALF_RECORD


def share_done(test, end):
    """Return the share of the steps up to the strain `end` that the shear has made, estimated."""
    smooth = O.dt / test.time_unit if test.parameters["law"] == "smooth" else None

    def steps(first):
        strains = np.linspace(first, end, 101)[:-1]
        rates = [rate_and_step(test, strain) for strain in strains]
        return sum((end - first) / 100 / (rate * (smooth or step)) for rate, step in rates)

    return 1 - steps(test.strain) / steps(0.0) if test.strain < end else 1.0


def rate_and_step(test, strain=None):
    """Return I and dt/t₀ of the shear, now or at a strain; `Biaxial.go_back` divides dt.

    Beyond the strain `approach`, I falls exponentially with the strain to its final value, or to
    the bound of the sample's inertia.
    """
    given, step = test.parameters["inertial_number"], test.parameters["time_step"]
    quick = max(given, PROTOCOL.quick_inertial_number)
    shortest = min(step, PROTOCOL.quick_time_step)
    if is_approaching(test, strain):
        return quick, shortest / test.progress["divisor"]
    slow = min(given, largest_rate(test, strain))
    rate = slow * (quick / slow) ** (1 - _slowed(test, strain))
    step = min(max(step * given / rate, shortest), step)
    return rate, step / test.progress["divisor"]


def _slowed(test, strain=None):
    """Return how far the rate has fallen beyond the strain `approach`, from 0 to 1."""
    beyond = (test.strain if strain is None else strain) - test.parameters["approach"]
    return min(1, max(0, beyond) / PROTOCOL.slowing_strain) if test.parameters["approach"] else 1


def largest_rate(test, strain=None):
    """Return I at which ρ (ε̇ W)²/σ₀ has its bound, now or at a strain."""
    width, height = box(test, strain)
    density = PROTOCOL.density * test.packing_fraction
    bound = test.parameters["sample_inertia"] * PROTOCOL.confining_stress
    first = test.progress["first_height"]
    return test.time_unit * height / (first * width) * math.sqrt(bound / density)


def box(test, strain=None):
    """Return width and height of the box, now or at a strain with the present area [m]."""
    height = test.height if strain is None else test.progress["first_height"] * (1 - strain)
    return test.area / (test.packing_fraction * height), height


def top_speed(test):
    """Return the present speed of the top wall after the ramp [m/s]."""
    return rate_and_step(test)[0] / test.time_unit * test.progress["first_height"]


def steps_per_record(test):
    """Return the number of steps of a record of `Protocol.record_strain`, of the ramp or later."""
    rate, step = rate_and_step(test)
    if isinstance(test.solver, Springs):
        step = O.dt / test.time_unit
    return max(1, math.ceil(PROTOCOL.record_strain / (rate * step) - 1e-6))


def next_record(test):
    """Return the strain of the next record after the ramp, which ends at a multiple of it.

    The first record after the ramp has 0.5 to 1.5 times `Protocol.record_strain`.
    """
    whole = PROTOCOL.record_strain
    left = (math.floor(test.strain / whole + 0.5) + 1) * whole - test.strain
    return whole if math.isclose(left, whole, rel_tol=1e-6) else left


def _steps(test, ramp):
    """Return the number of steps of the next record; set the time step.

    The time step is the largest up to that of `rate_and_step` with which a record ends at its
    strain. Springs keep theirs and end within half a step.
    """
    if ramp < 1:
        return steps_per_record(test)
    (rate, step), strain = rate_and_step(test), next_record(test)
    if isinstance(test.solver, Springs):
        return max(1, round(strain * test.time_unit / (rate * O.dt)))
    count = max(1, math.ceil(strain / (rate * step) - 1e-6))
    O.dt = strain / (rate * count) * test.time_unit
    return count


def _records_to(test, strain):
    """Return the number of records until the test has reached a strain."""
    left = strain - HALF_RECORD - test.strain
    return max(1, math.ceil(left / PROTOCOL.record_strain - 1e-6))


def _records_at_this_speed(test, most):
    """Return the number of records, at most `most`, with the same speed and length."""
    if next_record(test) != PROTOCOL.record_strain:
        return 1
    if is_approaching(test):
        return min(most, _records_to(test, test.parameters["approach"]))
    if _slowed(test) < 1:
        return 1
    end = test.strain + most * PROTOCOL.record_strain
    # the margin is for the dilation until then
    return most if test.parameters["inertial_number"] < 0.8 * largest_rate(test, end) else 1


def shear(test, records, end=1):
    """Shear by at most `records` records, each of 0.1 % of strain and with a row of the history.

    The shear stops at the first record, of this call, at which the test has reached the strain
    `end`. Records with equal wall speed and time step are one run of YADE, since each run reads
    all bodies once. The results are those of one run per record, to the bit. A packing that has
    blown up raises a RuntimeError.
    """
    solver, top = test.solver, O.bodies[test.top].state
    while records > 0:
        ramp = min(1, max(test.strain, PROTOCOL.record_strain / 10) / PROTOCOL.ramp_strain)
        top.vel = Vector3(0, -ramp * top_speed(test), 0)
        if not isinstance(solver, Springs):
            O.dt = rate_and_step(test)[1] * test.time_unit
        most = min(records, _records_to(test, end))
        together = _records_at_this_speed(test, most) if ramp == 1 else 1
        try:
            test.step(_steps(test, ramp), together)
        finally:
            for record in test.records:
                test.rows.append(history_row(test, record))
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
    found = record | dict(strain=rounded(strain), sin_phi=sin_phi(stresses), packing_fraction=fraction)
    return {name: found[name] for name in HISTORY_COLUMNS}
