"""Observables O3 to O18, without the map O9, of one elongation. Needs NumPy, not YADE.

* Exponents are those of `rcr.distributions.exponents`. ``_fit_error`` is the error of the fit.
  ``_tenth`` is β fitted from a tenth of the mean on, which shows the effect of the range.
* Angular functions ⟨·⟩(θ, ξ) are means over the contacts of S(ξ) with a normal near θ. The paper's
  forms are fitted by least squares. Tangential components are along n turned by −90°: then
  ⟨f_t⟩ = ⟨f_n⟩ a_ft sin 2(θ − θσ) with a_ft > 0.
* ``strip_force`` and ``strip_stress`` compare normal forces and σ_xx between grains in vertical
  strips from wall to wall.
"""

import dataclasses
import functools
import math

import numpy as np

from rcr import distributions, statistics
from rcr.distributions import over_mean
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE

SLACK = 0.01  # of the ranges of ℓ_r and ℓ/R_max, which overlaps and gaps exceed
POLAR_CUTOFFS = 0.5, 1, 2  # ξ of the angular functions, beside infinity
SAMPLE_STRIPS = 5  # vertical strips from wall to wall
AXES = ("off_axis", "theta_sigma")  # angles with the period π


@dataclasses.dataclass(frozen=True, eq=False)
class Grids:
    """Bins and cutoffs of all elongations; edges of bins unless stated otherwise."""

    force: np.ndarray  # of f/⟨f⟩: geometric below the mean, 0.25 wide above
    mobilization: np.ndarray  # of I_m
    reduced_length: np.ndarray  # of ℓ_r
    length: np.ndarray  # of ℓ/R_max
    theta: np.ndarray  # of the angle of normals [rad]
    strip: np.ndarray  # of the position between the side walls
    strain: np.ndarray  # values of the strain
    xi: np.ndarray  # values of ξ, the last one beyond every force
    xi_polar: np.ndarray  # the same of the angular functions

    @classmethod
    def of(cls, ensembles, strain, contacts=math.inf):
        """Return grids that contain every force of the ensembles, up to a strain.

        `contacts` is the smallest number of contacts of other functions of θ; small packings have
        wide bins of θ.
        """
        contacts = min(contacts, *(int(e.xi_networks.count(POLAR_CUTOFFS[0])) for e in ensembles))
        angles = distributions.angular_bins(contacts)
        top = float(np.ceil(max(max(e.fn.max(), over_mean(np.abs(e.ft)).max()) for e in ensembles)))
        shortest = 1 - max(e.eta for e in ensembles)
        least = min(np.hypot(e.ln, e.lt).min() for e in ensembles)
        least = least if least < shortest - SLACK else shortest
        steps = int(np.ceil((1 - shortest) / 0.01 - 1e-9)) or 1
        return cls(
            force=np.append(np.geomspace(1e-3, 1, 25), np.arange(1.25, top + 0.125, 0.25)),
            mobilization=np.linspace(0, 1, 21), reduced_length=1 + 0.01 * np.arange(-steps, 1),
            length=np.arange(np.floor(least / 0.05 + 1e-9), 41) * 0.05,
            theta=np.linspace(0, np.pi, angles + 1), strip=np.linspace(0, 1, SAMPLE_STRIPS + 1),
            strain=np.linspace(0, strain, 201), xi=np.append(np.arange(0, min(8, top), 0.05), top),
            xi_polar=np.array([*POLAR_CUTOFFS, top]))

    def values(self):
        """Return values and centres of bins, by their names in analysis.json."""
        names = ("mobilization", "reduced_length", "length", "theta", "strip")
        middles = {name: statistics.centres(getattr(self, name)) for name in names}
        middle = np.where(self.force[1:] <= 1, np.sqrt(self.force[1:] * self.force[:-1]),
                          statistics.centres(self.force))
        return middles | dict(force=middle, strain=self.strain, xi=self.xi, xi_polar=self.xi_polar)


def force_distribution(force, edges, suffix):
    """Return the density of f/⟨f⟩, α above and β below the mean [eqs. strong_fn, strong_ft]."""
    force = over_mean(force)
    fit, tenth = distributions.exponents(force), distributions.exponents(force, 0.1)
    return {"pdf": statistics.density(force, edges), f"alpha_{suffix}": fit.alpha,
            f"alpha_{suffix}_fit_error": fit.alpha_error, f"beta_{suffix}": fit.beta,
            f"beta_{suffix}_fit_error": fit.beta_error, f"beta_{suffix}_tenth": tenth.beta}


def mean_mobilization(e, grids):
    """Return the mean of I_m, the share of contacts with I_m > 0.99, and their weak share."""
    weak = e.fn < 1
    full = e.mobilization > 0.99
    return dict(friction_mobilization=e.mobilization.mean(), mobilized_fraction=np.mean(full),
                mobilized_weak_share=np.mean(weak[full]) if full.any() else np.nan)


def strip_forces(e, grids):
    """Return mean normal force and σ_xx in vertical strips over the means of the network.

    σ_xx is 1 in a sample without inertia; contacts with the walls are left out.
    """
    f_x, l_x = (n * np.cos(e.angle) - t * np.sin(e.angle) for n, t in ((e.fn, e.ft), (e.ln, e.lt)))
    stress = np.histogram(e.across, grids.strip, weights=f_x * l_x)[0]
    return dict(strip_force=statistics.bin_means(e.across, e.fn, grids.strip),
                strip_stress=stress / stress.mean())


def _reduced_length(e):
    """Return ℓ_r clipped to its range, and the mask of its contacts, (C,) bool.

    The mask leaves out contacts that exceed the range by more than `SLACK`, as those of clumps.
    """
    low, high = 1 - e.eta, 1
    pick = (e.reduced_length > low - SLACK) & (e.reduced_length < high + SLACK)
    return np.clip(e.reduced_length[pick], low + 1e-9, high - 1e-9), pick


def _force_and_length(e):
    return np.hypot(e.fn, e.ft), np.hypot(e.ln, e.lt)


def correlations(e, grids):
    """Return C(f, ℓ_r), NaN for discs, and C(f, ℓ); f is the size of the force."""
    force, length = _force_and_length(e)
    c_f_lr = np.nan if e.eta == 0 else statistics.pearson(force, e.reduced_length)
    return dict(c_f_lr=c_f_lr, c_f_l=statistics.pearson(force, length))


def force_by_length(e, grids):
    """Return the mean force by bins of ℓ_r and ℓ."""
    force, length = _force_and_length(e)
    force = force / force.mean()
    reduced_length, pick = _reduced_length(e)
    return dict(f_l_r=statistics.bin_means(reduced_length, force[pick], grids.reduced_length),
                f_l=statistics.bin_means(length, force, grids.length))


def angular_function(e, grids, value, form):
    """Return means of a column of contacts by the direction of their normals, and their fit.

    Returns the means (ξ, θ), then mean and amplitude (ξ,) of the fit: mean + amplitude
    cos 2(θ − θσ) if `form` is np.cos, or amplitude sin 2(θ − θσ) if it is np.sin; NaN without any
    contact.
    """
    function, fits = [], []
    for xi in grids.xi_polar:
        pick = e.fn <= xi
        wave = form(2 * e.theta[pick])
        constant = np.full_like(wave, form is np.cos)
        function.append(statistics.bin_means(e.angle[pick], value[pick], grids.theta))
        fit = np.linalg.lstsq(np.column_stack([constant, wave]), value[pick], rcond=None)[0]
        fits.append(fit if pick.any() else np.full(2, np.nan))
    return np.array(function), *np.array(fits).T


def contact_directions(e, grids):
    """Return P(θ, ξ), with integral 1 over [0, π], and its Fourier fit (1 + a cos 2(θ − θ_c))/π.

    ``amplitude`` is a cos 2 ``off_axis``, ``off_axis`` is θ_c − θσ [rad].
    """
    picks = [e.fn <= xi for xi in grids.xi_polar]
    pdf = np.array([statistics.density(e.angle[pick], grids.theta) for pick in picks])
    waves = [np.exp(2j * e.theta[pick]) for pick in picks]
    moments = np.array([2 * np.mean(wave) if len(wave) else np.nan for wave in waves])
    return dict(pdf=pdf, amplitude=moments.real, off_axis=0.5 * np.angle(moments),
                theta_sigma=e.stress_angle)


@functools.lru_cache(maxsize=1)
def anisotropies(e, grids):
    """Return {name: anisotropy (ξ,)} of `Anisotropies`."""
    return e.xi_networks.anisotropies(grids.xi)._asdict()


def vector_anisotropies(e, grids, vector):
    """Return anisotropies and angular functions of branch vectors ("l") or forces ("f")."""
    normal, tangential = (getattr(e, f"{vector}{component}") for component in "nt")
    scale = normal.mean()
    along, mean, along_amplitude = angular_function(e, grids, normal / scale, np.cos)
    across, _, across_amplitude = angular_function(e, grids, -tangential / scale, np.sin)
    values = {name: value for name, value in anisotropies(e, grids).items() if vector in name}
    functions = dict(n=along, n_mean=mean, n_amplitude=along_amplitude, t=across,
                     t_amplitude=across_amplitude)
    return values | {f"{vector}_{name}": value for name, value in functions.items()}


def shear_stress(e, grids):
    """Return q(ξ)/p, the half-sum of the anisotropies, and their difference.

    κ q(ξ)/p = half-sum + cross products exactly, with the pressure factor κ.
    """
    ratio = e.xi_networks.shear_stress_ratio(grids.xi)
    half_sum = 0.5 * np.sum(list(anisotropies(e, grids).values()), axis=0)
    return dict(q_over_p=ratio, half_sum=half_sum, closure=half_sum - ratio,
                cross_products=e.xi_networks.cross_products(grids.xi),
                pressure_factor=e.xi_networks.pressure_factor())


VECTOR_AXES = dict(xi="xi", xi_polar="xi_polar", theta="theta")
MEASURES = dict(  # observable: (function, {name in analysis.json: grid of its arrays})
    O3=(lambda e, grids: force_distribution(e.fn, grids.force, "n")
        | dict(weak_fraction=np.mean(e.fn < 1)), dict(f_n="force")),
    O4=(lambda e, grids: force_distribution(np.abs(e.ft), grids.force, "t"), dict(f_t="force")),
    O5=(mean_mobilization, {}),
    O6=(strip_forces, dict(strip="strip")),
    O7=(lambda e, grids: dict(i_mf=statistics.bin_means(e.fn, e.mobilization, grids.force)),
        dict(f_n="force")),
    O8=(lambda e, grids: dict(
        pdf=statistics.density(np.minimum(e.mobilization, 1), grids.mobilization)),
        dict(i_m="mobilization")),
    O10=(lambda e, grids: dict(pdf=statistics.density(_reduced_length(e)[0], grids.reduced_length)),
         dict(l_r="reduced_length")),
    O11=(lambda e, grids: dict(
        fraction_cc=np.mean(e.type == CAP_CAP), fraction_cs=np.mean(e.type == CAP_SIDE),
        fraction_ss=np.mean(e.type == SIDE_SIDE)), {}),
    O12=(correlations, {}),
    O13=(force_by_length, dict(l_r="reduced_length", l="length")),
    O14=(contact_directions, dict(theta="theta", xi="xi_polar")),
    O15=(lambda e, grids: dict(a_c=anisotropies(e, grids)["a_c"]), dict(xi="xi")),
    O16=(functools.partial(vector_anisotropies, vector="l"), VECTOR_AXES),
    O17=(functools.partial(vector_anisotropies, vector="f"), VECTOR_AXES),
    O18=(shear_stress, dict(xi="xi")),
)


def with_errors(parts):
    """Return {name: value of the first part, name_error: standard error of the other parts}."""
    whole, *others = parts
    values = {}
    for name, value in whole.items():
        values[name] = value
        if not name.endswith("_fit_error"):
            samples = [other[name] for other in others]
            if name in AXES:
                samples = [0.5 * np.angle(np.exp(2j * (sample - value))) for sample in samples]
            values[f"{name}_error"] = statistics.standard_error(samples)
    return values


def measures(ensemble, grids, parts):
    """Return {observable: {name: value, or error over the ensembles `parts`}}."""
    found = [{key: measure(e, grids) for key, (measure, _) in MEASURES.items()}
             for e in (ensemble, *parts)]
    return {key: with_errors([values[key] for values in found]) for key in MEASURES}
