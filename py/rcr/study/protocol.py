"""Constants and parameters of the biaxial test. `check_parameters` needs the kernel, not YADE.

Units
-----
m is the mean mass of a grain, d its mean diameter and σ₀ the confining stress. The time unit is
t₀ = √(m/σ₀), the inertial number I = ε̇ t₀. Every quantity is per unit depth.
"""

import dataclasses
import inspect
import math

from rcr._data import checks, run_folder

FREE_PARAMETERS = ("threads",)  # parameters that do not change the results


@dataclasses.dataclass(frozen=True)
class Protocol:
    """Constants of the biaxial test; `PROTOCOL` holds the defaults.

    The tests of docs/measurements/index.md chose these values, or they set a scale.
    """

    # Grains and load
    smallest_radius: float = 5e-3  # R_min [m]
    density: float = 2600.0  # mass density of grains [kg/m³]
    confining_stress: float = 1e4  # σ₀ on walls that give way [Pa]
    deposited_fraction: float = 0.82  # packing fraction of the deposited circles [-]

    # Collapse: homogeneous contraction until the contacts carry the load
    max_contraction: float = 0.005  # strain of a step, at most [-]
    sparse_points: float = 1.5  # points over grains without contact paths across the box
    max_wall_displacement: float = 0.1  # of a step [d], once contact paths span the box
    max_collapse_stress: float = 4.0  # wall stress that ends the collapse [σ₀]

    # Relaxation: steps of changing length until every grain is balanced
    relaxation_time_steps: tuple = (0.1, 1.0)  # shortest and longest time step [t₀]
    max_grain_displacement: float = 0.1  # of a step, at most [d]
    displacement_per_unbalance: float = 20.0  # first bound of displacement over unbalance [d]
    displacement_reduction: float = 0.6  # factor on that bound if the unbalance stays
    min_displacement_per_unbalance: float = 0.05  # bound that restarts at a larger value [d]
    restart_reduction: float = 0.36  # of that value over the one before [-]
    unbalance_window: int = 5  # unbalances compared with as many earlier ones
    unbalance_decrease: float = 0.8  # ratio of their sums, at most; else grains flip
    relaxation_steps: int = 10  # steps of one length while the unbalance is below `rough_unbalance`
    rough_unbalance: float = 0.03  # unbalance from which on each step has its own length [-]
    drag_ratio: float = 3  # stress deviation over unbalance of a sample held up by drag
    relaxation_tolerance: float = 0.003  # residual of the solver over the unbalance [-]
    balance_tolerance: float = 2e-3  # unbalance at the end [-]: mean net force over contact force
    isotropy_tolerance: float = 1e-2  # deviation of wall stresses at the end [σ₀], at most
    creep_isotropy_tolerance: float = 3e-2  # the same of a balanced packing that creeps [σ₀]
    largest_overlap: float = 1e-3  # of a balanced packing [d]; else its steps get shorter
    creep_intervals: int = 10  # balanced intervals after which a packing counts as creeping
    max_compaction_steps: int = 20_000  # steps after which the compaction fails

    # Shear
    time_step: float = 0.4  # dt [t₀]; at 1.2 contacts of long grains sink in
    inertial_number: float = 1e-4  # I [-]; averages are near their limit I → 0
    sample_inertia: float = 5e-5  # ρ (v W/2h)²/σ₀ at most [-]; I_M and β_n change with the rate
    approach: float = 0.1  # strain up to which the shear is quick [-]
    quick_time_step: float = 0.1  # dt of quick shear, at most [t₀]
    quick_inertial_number: float = 1e-3  # I of quick shear, at least [-]
    acceleration_stress: float = 0.005  # of the packing by the top wall, at most [σ₀]
    iterations: int = 300  # of the solver in a step, at most
    small_iterations: int = 10_000  # the same of small packings (docs/study/biaxial.md)
    small_particles: int = 2000  # grains of a small packing, at most
    yield_compliance: float = 0.01  # `ContactDynamics.yieldCompliance`
    most_divisor: int = 5  # of the time step where the shear is repeated
    record_strain: float = 1e-3  # strain of a record of the history [-]
    fraction_ratios: tuple = (0.5, 1.5)  # packing fraction over its first value; beyond: blown up

    # Springs (law smooth)
    stiffness: float = 1e3  # k_n [σ₀]: mean overlaps of about 1e-3 d
    shear_stiffness: float = 0.8  # k_s over k_n [-]
    viscous_damping: float = 0.3  # damping ratio along normals [-]; the shear has no other damping
    smooth_time_step: float = 0.5  # dt over `rcr.critical_time_step` [-]
    smooth_stride: int = 10  # steps between two readings of the wall stresses

    @property
    def identity(self):
        """Short hash of the constants."""
        return run_folder.identity(dataclasses.asdict(self))


PROTOCOL = Protocol()
REGULAR_HEXAGON = 1 - math.sqrt(0.75)  # η of the regular hexagon
# deviation of a saved strain, at most; the excess decides ties, which rounding would decide else
HALF_RECORD = 0.5 * (1 + 1e-6) * PROTOCOL.record_strain
SHAPES = dict(  # shape of the grains: bounds of η, of all shapes but regular polygons
    rcr=(0, 1), regular=None, truncated=(REGULAR_HEXAGON, 0.5), hexagon=(REGULAR_HEXAGON, 1),
    trimer=(0, 0.5))
SHAPE_NAMES = dict(
    rcr="rounded-cap rectangle", regular="regular polygon", truncated="truncated triangle",
    hexagon="elongated hexagon", trimer="trimer")
ONE_RATE = dict(approach=0, sample_inertia=1)  # parameters of a shear at one rate


def check_networks(networks, strain):
    """Raise ValueError for more networks than records of the history."""
    most = math.floor(strain / PROTOCOL.record_strain + 1e-6)
    if networks > most:
        expected = f"at most {most}, one for each record of {PROTOCOL.record_strain:g}"
        raise ValueError(f"--networks {networks} up to --strain {strain:g}: expected {expected}; "
                         "give fewer networks or a larger strain")


def is_critical(strain, start, end=math.inf):
    """Return whether a strain, or each of an array, is in the critical state, to half a record."""
    return (strain >= start - HALF_RECORD) & (strain <= end + HALF_RECORD)


def critical_start(end, share=0.5):
    """Return the strain at which the critical state starts by default: the second half."""
    return share * end


def quick_averages(strain, approach, inertial_number):
    """Return a warning if the averages of a test up to a strain begin before the slow shear."""
    start = critical_start(strain)
    if start >= approach - HALF_RECORD or inertial_number >= PROTOCOL.quick_inertial_number:
        return ""
    return (f"averages are over strains of {start:g} to {strain:g}, but the shear is slow from "
            f"{approach:g} on only: they mix several rates; give --strain {2 * approach:g} or "
            "more, or a smaller --approach")


def check_parameters(eta=0.5, particles=1000, seed=1, friction=0.5, tolerance=1e-4, solver="auto",
                     threads=0, inertial_number=PROTOCOL.inertial_number,
                     time_step=PROTOCOL.time_step, law="cd", stiffness=PROTOCOL.stiffness,
                     iterations=None, approach=PROTOCOL.approach,
                     sample_inertia=PROTOCOL.sample_inertia, shape="rcr", sides=None, size_span=2,
                     rolling_friction=0):
    """Return the parameters of a test as a dict, after a check of each.

    docs/study/biaxial.md and the help of scripts/biaxial.py describe them. A ValueError reports a
    parameter out of its range, or two that exclude each other.
    """
    parameters = dict(locals())
    from rcr import _kernel

    if iterations is None:
        small = _checked("particles", particles) <= PROTOCOL.small_particles
        parameters["iterations"] = PROTOCOL.small_iterations if small else PROTOCOL.iterations
    for name in _RANGES:
        if name != "sides" or sides is not None:
            parameters[name] = _checked(name, parameters[name])
    checks.choice("law", law, ("cd", "smooth"))
    checks.choice("shape", shape, tuple(SHAPES))
    _check_shape(parameters)
    checks.choice("solver", solver, _kernel.solver_names())
    _check_combination(parameters)
    return parameters


DEFAULTS = {name: p.default for name, p in inspect.signature(check_parameters).parameters.items()}
_RANGES = dict(  # parameter: check, expected value, condition
    eta=(checks.number, "an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1),
    particles=(checks.integer, "at least 10 and at most 10 million", lambda v: 10 <= v <= 10**7),
    seed=(checks.integer, "a whole number ≥ 0", lambda v: v >= 0),
    friction=(checks.number, "a coefficient ≥ 0, at most 100", lambda v: 0 <= v <= 100),
    tolerance=(checks.number, "a residual 0 ≤ tolerance < 1", lambda v: 0 <= v < 1),
    threads=(checks.integer, "0 (as many as YADE uses) to 1024", lambda v: 0 <= v <= 1024),
    inertial_number=(checks.number, "a number > 0", lambda v: v > 0),
    time_step=(checks.number, "a number > 0, at most 10", lambda v: 0 < v <= 10),
    stiffness=(checks.number, "a number ≥ 1, at most 1e9", lambda v: 1 <= v <= 1e9),
    iterations=(checks.integer, "a whole number > 0 of 32 bits", lambda v: 0 < v < 2**31),
    approach=(checks.number, "a strain 0 ≤ approach < 1", lambda v: 0 <= v < 1),
    sample_inertia=(checks.number, "a number > 0, at most 1", lambda v: 0 < v <= 1),
    sides=(checks.integer, "a number of sides from 3 to 64", lambda v: 3 <= v <= 64),
    size_span=(checks.number, "a ratio R_max/R_min from 1 to 100", lambda v: 1 <= v <= 100),
    rolling_friction=(checks.number, "a coefficient ≥ 0, at most 1", lambda v: 0 <= v <= 1),
)


def _checked(name, value):
    """Return a parameter in its type, if it is in its range."""
    check, expected, valid = _RANGES[name]
    return check(name, value, expected, valid)


def regular_eta(sides):
    """Return η = 1 − cos(π/n) of a regular polygon of n sides [-]."""
    return 1 - math.cos(math.pi / sides)


def stored_attributes(parameters):
    """Return the parameters that summary.json and networks contain, without those not given."""
    names = "eta", "seed", "shape", "sides", "size_span", "rolling_friction"
    return {name: parameters[name] for name in names if parameters[name] is not None}


def _check_shape(parameters):
    """Raise ValueError for a shape and parameters that exclude each other; set η of polygons."""
    shape, sides, eta = (parameters[name] for name in ("shape", "sides", "eta"))
    if (shape == "regular") != (sides is not None):
        given = f"shape = {shape!r} with sides = {sides}"
        raise ValueError(f"{given}; sides belong to the shape 'regular' alone, which needs them")
    if shape == "regular":
        own = regular_eta(parameters["sides"])
        if eta not in (DEFAULTS["eta"], own):
            raise ValueError(f"eta = {eta:g} with shape = 'regular': {sides} sides have η = "
                             f"1 − cos(π/{sides}) = {own:.4f}; leave it out")
        parameters["eta"] = own
    elif not SHAPES[shape][0] - 1e-9 <= eta <= SHAPES[shape][1]:
        low, high = SHAPES[shape]
        raise ValueError(f"eta = {eta:g} with shape = {shape!r}; expected {low:.4g} to {high:g}")
    for name, value, of in (("shape", shape, "rcr"), ("law", parameters["law"], "cd")):
        if parameters["rolling_friction"] and value != of:
            raise ValueError(f"rolling_friction = {parameters['rolling_friction']:g} with {name} = "
                             f"{value!r}: expected {name} = {of!r}, or no rolling friction")


def _check_combination(parameters):
    """Raise ValueError for parameters that exclude each other."""
    law, strain = parameters["law"], parameters["inertial_number"] * parameters["time_step"]
    if law == "cd" and not 1e-12 <= strain <= PROTOCOL.record_strain:
        expected = f"at least 1e-12, and at most {PROTOCOL.record_strain:g}, the strain of a record"
        given = f"inertial_number × time_step = {strain:g} is the strain of a step"
        raise ValueError(f"{given}; expected {expected}")
    for name, user in dict(stiffness="smooth", time_step="cd").items():
        if law != user and parameters[name] != getattr(PROTOCOL, name):
            given = f"{name} = {parameters[name]:g} with law = {law!r}"
            raise ValueError(f"{given}: the law {user!r} alone uses it; leave it out")
