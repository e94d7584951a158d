"""The observables O1 to O18 of the paper, from runs of the biaxial test. Needs NumPy, not YADE.

Rules
-----
* The contacts of all snapshots of an elongation are cumulated, of all seeds too, each snapshot's forces over its own ⟨f_n⟩.
  ``NAME_error`` is the standard error over the seeds if there are three or more, else over the snapshots: their standard deviation over
  √(number), unknown of one. Snapshots of one test share its packing, so that errors over few seeds are too small rather than too large.
* Exponents are maximum-likelihood fits: α to the forces above the mean, β to those from `POWER_RANGE` of it up to it. Their
  ``_fit_error`` is that of the fit, and ``_half`` the β found up to half of the mean: how much the range matters.
* Angular functions ⟨·⟩(θ, ξ) are means over the contacts of S(ξ) with a normal near θ, least-squares fitted by the paper's forms;
  tangential components are along n turned by −90° there, the sense in which ⟨f_t⟩ = ⟨f_n⟩ a_ft sin 2(θ − θσ) with a_ft > 0.
* ``a_c_drift`` is how far a_c goes on changing over the snapshots' strains: the critical state of sin φ is not that of the fabric.
* ``strip_force`` compares the normal forces of contacts between grains in vertical strips from wall to wall.
* sin φ is that of the mean stresses of the walls over the history, not the mean of sin φ: stresses of a large packing fluctuate by its
  inertia, and then the latter is too small. ``sin_phi_std`` is the scatter of records; ``sin_phi_network`` is the mean of the snapshots.
"""

import dataclasses

import numpy as np

from rcr.study import statistics
from rcr.study.ensemble import Ensemble
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE, sin_phi
from rcr.study.paper import MAPS, STATEMENTS
from rcr.study.runs import by_elongation

POWER_RANGE = 0.01  # of the mean: below it forces are as small as the solver's tolerance leaves them undecided
WINDOW = 0.01  # of strain, over which stresses are averaged for the curve of sin φ
STRIPS = 5  # from wall to wall, in which forces are compared
SEEDS = 3  # from so many seeds on errors are over them
BLOCKS = 5  # of a history, each longer than the correlation of sin φ, for its standard error
ISOTROPIC = ("a_c", "contacts", "order", "packing_fraction", "coordination_number", "coordination_number_twice")
NAMES = ("a_c", "a_ln", "a_lt", "a_fn", "a_ft")


@dataclasses.dataclass(frozen=True)
class Grids:
    """Classes and cutoffs shared by all elongations; edges unless said otherwise."""

    force: np.ndarray  # of f/⟨f⟩: geometric below the mean, 0.25 wide above
    mobilization: np.ndarray  # of I_m
    reduced_length: np.ndarray  # of ℓ_r
    length: np.ndarray  # of ℓ/R_max
    theta: np.ndarray  # of the angle of normals [rad]
    strip: np.ndarray  # of the place between the side walls
    strain: np.ndarray  # values of the strain
    xi: np.ndarray  # values of ξ, the last one beyond every force
    xi_polar: np.ndarray  # values of ξ of the angular functions, likewise

    @classmethod
    def of(cls, ensembles, strain):
        """Grids that hold every force of the ensembles, up to a strain."""
        top = float(np.ceil(max(max(e.fn.max(), over_mean(np.abs(e.ft)).max()) for e in ensembles)))
        shortest = 1 - max(e.eta for e in ensembles)
        steps = int(np.ceil((1 - shortest) / 0.01 - 1e-9)) or 1
        return cls(
            force=np.append(np.geomspace(1e-3, 1, 25), np.arange(1.25, top + 0.125, 0.25)),
            mobilization=np.linspace(0, 1, 21),
            reduced_length=1 + 0.01 * np.arange(-steps, 1),
            length=np.arange(np.floor(shortest / 0.05 + 1e-9), 41) * 0.05,
            theta=np.linspace(0, np.pi, 37),
            strip=np.linspace(0, 1, STRIPS + 1),
            strain=np.linspace(0, strain, 201),
            xi=np.append(np.arange(0, min(8, top), 0.05), top),
            xi_polar=np.array([0.5, 1, 2, top]),
        )

    def values(self):
        """The values and the middles of classes, by their names in analysis.json."""
        middles = {name: statistics.centres(getattr(self, name)) for name in ("mobilization", "reduced_length", "length", "theta", "strip")}
        middle = np.where(self.force[1:] <= 1, np.sqrt(self.force[1:] * self.force[:-1]), statistics.centres(self.force))
        return middles | dict(force=middle, strain=self.strain, xi=self.xi, xi_polar=self.xi_polar)


# --- one ensemble -------------------------------------------------------------------------------------------------------


def over_mean(force):
    """f/⟨f⟩; zeros stay zeros."""
    mean = force.mean()
    return force / mean if mean > 0 else force


def force_distribution(force, edges, suffix):
    """Density of f/⟨f⟩ and its exponents α above and β below the mean [paper, eqs. strong_fn, strong_ft]."""
    force = over_mean(force)
    alpha, alpha_error = statistics.exponential_rate(force)
    beta, beta_error = statistics.power_exponent(force, POWER_RANGE)
    half, _ = statistics.power_exponent(force, POWER_RANGE, 0.5)
    return {
        "pdf": statistics.density(force, edges),
        f"alpha_{suffix}": alpha,
        f"alpha_{suffix}_fit_error": alpha_error,
        f"beta_{suffix}": beta,
        f"beta_{suffix}_fit_error": beta_error,
        f"beta_{suffix}_half": half,
    }


def normal_forces(e, grids):
    return force_distribution(e.fn, grids.force, "n") | dict(weak_fraction=np.mean(e.fn < 1))


def tangential_forces(e, grids):
    return force_distribution(np.abs(e.ft), grids.force, "t")


def mean_mobilization(e, grids):
    weak = e.fn < 1
    full = e.mobilization > 0.99
    return dict(
        friction_mobilization=e.mobilization.mean(),
        mobilized_fraction=np.mean(full),
        mobilized_weak_share=np.mean(weak[full]) if full.any() else np.nan,
    )


def strip_forces(e, grids):
    """Mean normal force in vertical strips over that of the snapshot: 1 everywhere where the sample knows neither inertia nor its walls."""
    return dict(strip_force=statistics.class_means(e.across, e.fn, grids.strip))


def mobilization_by_force(e, grids):
    return dict(i_mf=statistics.class_means(e.fn, e.mobilization, grids.force))


def mobilization_distribution(e, grids):
    return dict(pdf=statistics.density(np.minimum(e.mobilization, 1), grids.mobilization))


def _reduced_length(e):
    """ℓ_r within its range: overlaps and gaps of rigid grains leave it by 1e-4 and less."""
    return np.clip(e.reduced_length, 1 - e.eta + 1e-9, 1 - 1e-9)


def length_distribution(e, grids):
    return dict(pdf=statistics.density(_reduced_length(e), grids.reduced_length))


def _force_and_length(e):
    return np.hypot(e.fn, e.ft), np.hypot(e.ln, e.lt)


def contact_types(e, grids):
    """Shares of cap-cap, cap-side and side-side contacts [-]."""
    return {f"fraction_{name}": np.mean(e.type == code) for name, code in (("cc", CAP_CAP), ("cs", CAP_SIDE), ("ss", SIDE_SIDE))}


def correlations(e, grids):
    """C(f, ℓ_r), which discs have not, and C(f, ℓ), of the whole force f over its mean."""
    force, length = _force_and_length(e)
    c_f_lr = np.nan if e.eta == 0 else statistics.pearson(force, e.reduced_length)
    return dict(c_f_lr=c_f_lr, c_f_l=statistics.pearson(force, length))


def force_by_length(e, grids):
    force, length = _force_and_length(e)
    force = force / force.mean()
    return dict(
        f_l_r=statistics.class_means(_reduced_length(e), force, grids.reduced_length),
        f_l=statistics.class_means(length, force, grids.length),
    )


def angular_function(e, grids, value, form):
    """Means of a column of contacts by the direction of their normals, for each ξ, and their fit.

    Returns
    -------
    (function, mean, amplitude) : (ξ, θ), (ξ,) and (ξ,) arrays
        The fit is mean + amplitude cos 2(θ − θσ) if `form` is np.cos, amplitude sin 2(θ − θσ) if it is np.sin.
    """
    function, fits = [], []
    for xi in grids.xi_polar:
        pick = e.fn <= xi
        wave = form(2 * e.theta[pick])
        constant = np.full_like(wave, form is np.cos)
        function.append(statistics.class_means(e.angle[pick], value[pick], grids.theta))
        fits.append(np.linalg.lstsq(np.column_stack([constant, wave]), value[pick], rcond=None)[0])
    return np.array(function), *np.array(fits).T


def contact_directions(e, grids):
    """P(θ, ξ), each of integral 1 over [0, π], with the amplitude and the axis of its Fourier fit (1 + a cos 2(θ − θ_c))/π."""
    picks = [e.fn <= xi for xi in grids.xi_polar]
    moments = np.array([2 * np.mean(np.exp(2j * e.theta[pick])) if pick.any() else np.nan for pick in picks])
    return dict(
        pdf=np.array([statistics.density(e.angle[pick], grids.theta) if pick.any() else np.nan * grids.theta[1:] for pick in picks]),
        amplitude=moments.real,
        off_axis=0.5 * np.angle(moments),
        theta_sigma=e.stress_angle,
    )


def contact_anisotropy(e, grids):
    return dict(a_c=e.xi_networks().anisotropies(grids.xi)[0])


def branch_anisotropies(e, grids):
    return _anisotropies(e, grids, "l", e.ln, e.lt, slice(1, 3))


def force_anisotropies(e, grids):
    return _anisotropies(e, grids, "f", e.fn, e.ft, slice(3, 5))


def _anisotropies(e, grids, vector, normal, tangential, which):
    scale = normal.mean()
    along, mean, along_amplitude = angular_function(e, grids, normal / scale, np.cos)
    across, _, across_amplitude = angular_function(e, grids, -tangential / scale, np.sin)
    names = (f"{vector}_n", f"{vector}_n_mean", f"{vector}_n_amplitude", f"{vector}_t", f"{vector}_t_amplitude")
    functions = dict(zip(names, (along, mean, along_amplitude, across, across_amplitude)))
    return dict(zip(NAMES[which], e.xi_networks().anisotropies(grids.xi)[which])) | functions


def shear_stress(e, grids):
    """q(ξ)/p, the half-sum, their difference, and what makes it: κ q(ξ)/p = half-sum + cross products exactly."""
    xi_networks = e.xi_networks()
    ratio, half_sum = xi_networks.shear_stress_ratio(grids.xi), 0.5 * np.sum(xi_networks.anisotropies(grids.xi), axis=0)
    neglected = dict(cross_products=xi_networks.cross_products(grids.xi), pressure_factor=xi_networks.pressure_factor())
    return dict(q_over_p=ratio, half_sum=half_sum, closure=half_sum - ratio) | neglected


MEASURES = dict(  # of one ensemble, and the grids that belong to its arrays by their names in analysis.json
    O3=(normal_forces, dict(f_n="force")),
    O4=(tangential_forces, dict(f_t="force")),
    O5=(mean_mobilization, {}),
    O6=(strip_forces, dict(strip="strip")),
    O7=(mobilization_by_force, dict(f_n="force")),
    O8=(mobilization_distribution, dict(i_m="mobilization")),
    O10=(length_distribution, dict(l_r="reduced_length")),
    O11=(contact_types, {}),
    O12=(correlations, {}),
    O13=(force_by_length, dict(l_r="reduced_length", l="length")),
    O14=(contact_directions, dict(theta="theta", xi="xi_polar")),
    O15=(contact_anisotropy, dict(xi="xi")),
    O16=(branch_anisotropies, dict(xi="xi", xi_polar="xi_polar", theta="theta")),
    O17=(force_anisotropies, dict(xi="xi", xi_polar="xi_polar", theta="theta")),
    O18=(shear_stress, dict(xi="xi")),
)


def with_errors(parts):
    """{name: whole, name_error: standard error} of measures: the first of the cumulated contacts, the others of snapshots."""
    whole, *snapshots = parts
    values = {}
    for name, value in whole.items():
        values[name] = value
        if not name.endswith("_fit_error"):
            values[f"{name}_error"] = standard_error([snapshot[name] for snapshot in snapshots])
    return values


def standard_error(values):
    """Standard deviation over the first axis over √(number), of those that are finite; NaN of fewer than two."""
    values = np.asarray(values, dtype=float)
    finite = np.isfinite(values)
    count = finite.sum(axis=0)
    mean = np.where(finite, values, 0).sum(axis=0) / np.maximum(count, 1)
    squares = np.where(finite, values - mean, 0) ** 2
    return np.where(count > 1, np.sqrt(squares.sum(axis=0) / np.maximum(count - 1, 1) / np.maximum(count, 1)), np.nan)


def samples(runs):
    """Ensembles that errors are taken over: one a seed where there are `SEEDS` or more, since those are independent, else one a snapshot."""
    if len(runs) >= SEEDS:
        return [Ensemble(run.networks) for run in runs]
    return [Ensemble([network]) for run in runs for network in run.networks]


def measures(ensemble, grids, parts=None):
    """{observable: {name: value and error}} of one ensemble; errors over its `parts`, by default its snapshots."""
    parts = ensemble.snapshots() if parts is None else parts
    return {key: with_errors([measure(e, grids) for e in (ensemble, *parts)]) for key, (measure, _) in MEASURES.items()}


# --- runs ---------------------------------------------------------------------------------------------------------------


def along_strain(history, strain):
    """sin φ of the wall stresses averaged over `WINDOW` about each strain; NaN where there is no record."""
    near = np.abs(history["strain"] - strain[:, None]) <= WINDOW / 2
    count = np.where(near.any(axis=1), near.sum(axis=1), np.nan)
    return sin_phi(np.column_stack([near @ history["stress_x"] / count, near @ history["stress_y"] / count]))


def strength(runs, ensemble, grids):
    """sin φ of the critical state and along the strain, of the runs of one elongation."""
    late = [run.critical_stresses() for run in runs]
    blocks = [sin_phi(block.mean(axis=0)) for stresses in late for block in np.array_split(stresses, min(BLOCKS, len(stresses)))]
    histories = [run.history for run in runs if run.history is not None]
    curves = [along_strain(history, grids.strain) for history in histories]
    return dict(
        sin_phi=np.mean([sin_phi(stresses.mean(axis=0)) for stresses in late]),
        sin_phi_std=sin_phi(np.concatenate(late)).std(),
        sin_phi_error=standard_error(blocks),
        sin_phi_network=ensemble.sin_phi(),
        sin_phi_network_error=standard_error([part.sin_phi() for part in ensemble.snapshots()]),
        sin_phi_strain=np.mean(curves, axis=0) if curves else np.full_like(grids.strain, np.nan),
        snapshots=len(ensemble.snapshots()),
        contacts=len(ensemble),
        particles=np.mean([len(run.networks[0].particles["id"]) for run in runs]),
        seeds=len(runs),
    )


def drift(runs):
    """Change of a_c over the strains of the snapshots, by a straight line with one slope for all seeds; NaN of fewer than three snapshots."""
    series = [(np.array([network.attributes["strain"] for network in run.networks]), [network.anisotropies()[0] for network in run.networks]) for run in runs]
    x = np.concatenate([strain - strain.mean() for strain, _ in series])
    y = np.concatenate([values - np.mean(values) for _, values in series])
    left = len(x) - len(series) - 1
    if left < 1 or not x.any():
        return dict(a_c_drift=np.nan, a_c_drift_error=np.nan)
    slope = x @ y / (x @ x)
    error = np.sqrt(np.sum((y - slope * x) ** 2) / left / (x @ x))
    strains = np.concatenate([strain for strain, _ in series])
    return dict(a_c_drift=slope * np.ptp(strains), a_c_drift_error=error * np.ptp(strains))


def compaction(runs, grids):
    """Isotropic state: directions of contacts and particles, density, coordination; NaN of a run without isotropic.h5."""
    states = [isotropic(run.isotropic, grids) for run in runs if run.isotropic is not None]
    if not states:
        states = [dict.fromkeys(ISOTROPIC, np.nan) | dict(pdf=np.full(len(grids.theta) - 1, np.nan))]
    mean = {name: np.mean([state[name] for state in states], axis=0) for name in states[0]}
    return mean | dict(a_c_error=np.sqrt(2 / mean["contacts"] / len(states)))


def isotropic(network, grids):
    """Of one packing; `order` is |⟨e^{2iφ}⟩| of the long axes, `a_c` that of the normals by size, ± √(2/C) of independent ones."""
    n = network.contacts["normal"][network.between_particles]
    angle = np.arctan2(n[:, 1], n[:, 0])
    p = network.particles
    area = np.pi * p["cap_radius"] ** 2 + 4 * p["cap_radius"] * p["half_length"]
    return dict(
        pdf=statistics.density(angle % np.pi, grids.theta),
        a_c=2 * np.abs(np.mean(np.exp(2j * angle))),
        contacts=len(n),
        order=np.abs(np.mean(np.exp(2j * p["angle"]))) if network.attributes.get("eta", 1) else np.nan,
        packing_fraction=area.sum() / network.attributes["volume"],
        coordination_number=network.coordination(),
        coordination_number_twice=network.coordination(count_side_contacts_twice=True),
    )


def analyse(runs):
    """Every observable of runs, as analysis.json holds it.

    Parameters
    ----------
    runs : list of Run
        Those of the same elongation are cumulated.

    Returns
    -------
    dict
        ``O1`` … ``O18``, each {value: {name: array, elongation first}, paper: statement, unit}. Maps name no pictures yet.

    Raises
    ------
    ValueError
        If there is no run, or they differ in friction, or have none.
    """
    if not runs:
        raise ValueError("no runs: the analysis needs at least one folder")
    groups = by_elongation(runs)
    ensembles = {eta: Ensemble([network for run in group for network in run.networks]) for eta, group in groups.items()}
    last = max(float(run.networks[-1].attributes["strain"]) for run in runs)
    grids = Grids.of(ensembles.values(), last)
    named = grids.values()
    results = {eta: measures(e, grids, samples(groups[eta])) for eta, e in ensembles.items()}
    eta = np.array(list(groups))

    def stacked(rows, axes):
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return dict(eta=eta) | {name: named[grid] for name, grid in axes.items()} | columns

    values = {key: stacked([results[e][key] for e in groups], axes) for key, (_, axes) in MEASURES.items()}
    values["O1"] = stacked([strength(groups[e], ensembles[e], grids) for e in groups], dict(strain="strain"))
    values["O2"] = stacked([compaction(groups[e], grids) for e in groups], dict(theta="theta"))
    values["O15"] |= stacked([drift(groups[e]) for e in groups], {})
    values |= {key: dict(eta=eta) for key in MAPS if key not in values}
    for key in ("O3", "O4"):
        values[key] |= dict(power_range=np.array([POWER_RANGE, 1.0]), exponential_range=np.array([1.0, grids.xi[-1]]))
    return {key: dict(value=values[key], paper=paper, unit=unit) for key, (paper, unit) in STATEMENTS.items()}


def jsonable(item):
    """Arrays as lists, what is not finite as None, so that the file is strict JSON."""
    if isinstance(item, dict):
        return {key: jsonable(value) for key, value in item.items()}
    if isinstance(item, (list, tuple, np.ndarray)):
        return [jsonable(value) for value in (item.tolist() if isinstance(item, np.ndarray) else item)]
    if isinstance(item, (float, np.floating)):
        return float(item) if np.isfinite(item) else None
    return item.item() if isinstance(item, np.generic) else item
