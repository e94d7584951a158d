"""Registry of observables; bins, errors and values of all of them. Needs NumPy.

`NAME_error` is the standard error of a value over parts of the contacts, see `rcr.study.analysis`.
"""

import dataclasses
import math
import types
from collections.abc import Callable

import numpy as np

from rcr import distributions, statistics
from rcr._data.plain import plain
from rcr.distributions import over_mean

SLACK = 0.01  # of the ranges of ℓ_r and ℓ/R_max, which overlaps and gaps exceed
POLAR_CUTOFFS = 0.5, 1, 2  # ξ of the angular functions, beside infinity
SAMPLE_STRIPS = 5  # vertical strips from wall to wall
DIRECTIONS = ("off_axis", "theta_sigma")  # angles with the period π
OBSERVABLES = {}  # by key


@dataclasses.dataclass(frozen=True)
class Observable:
    """An observable of all elongations; `register` has the attributes."""

    caption: str
    measure: Callable = None
    axes: dict = types.MappingProxyType({})
    of_runs: Callable = None
    figure: Callable = None
    small: Callable = None
    map: tuple = None
    claims: tuple = ()
    unit: str = "-"


def register(key, caption, *arguments, **attributes):
    """Register an observable, which the analysis and the reports then contain.

    Parameters
    ----------
    key : str
        Name in analysis.json and of the files of its figure, such as "O3".
    caption : str
        What figure and map show.
    measure : callable, optional
        Function of an `Ensemble` of contacts and the `Grids` that returns {name: number or array}.
        The analysis adds NAME_error to each, except to those that end in _fit_error. Values of too
        few contacts are NaN.
    axes : dict, optional
        {name in analysis.json: name of a grid of `Grids`, or an array of values}: what the axes of
        the arrays are.
    of_runs : callable, optional
        Function of the `Run`s of an elongation, their `Ensemble` and the `Grids` that returns
        further values and their errors, from histories, grains or isotropic states.
    figure, small : callable, optional
        Functions of value, analysis and paper that return a Figure: `rcr._pictures.curves.plain`
        makes them of functions that draw into Axes. `small` is for the first screen of a report.
    map : tuple, optional
        Function that draws a network, marks of its legend, whether it has a scale of orientations.
    claims : sequence of (statement, criterion, test), optional
        Rows of the table of each report: two texts, and a test as in `rcr.study.criteria`. Those of
        a paper stand in `rcr.papers`.
    unit : str
    """
    if key in OBSERVABLES:
        raise ValueError(f"the observable {key} exists; choose another key")
    OBSERVABLES[key] = Observable(caption, *arguments, **attributes)


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
        least = min(e.length.min() for e in ensembles)
        least = least if least < shortest - SLACK else shortest
        steps = int(np.ceil((1 - shortest) / 0.01 - 1e-9)) or 1
        return cls(
            force=np.append(np.geomspace(1e-3, 1, 25), np.arange(1.25, top + 0.125, 0.25)),
            mobilization=np.linspace(0, 1, 21), reduced_length=1 + 0.01 * np.arange(-steps, 1),
            length=np.arange(np.floor(least / 0.05 + 1e-9), 41) * 0.05,
            theta=np.linspace(0, np.pi, angles + 1), strip=np.linspace(0, 1, SAMPLE_STRIPS + 1),
            strain=np.linspace(0, strain, 201), xi=np.append(np.arange(0, min(8, top), 0.05), top),
            xi_polar=np.array([*POLAR_CUTOFFS, top]))

    def values(self, grid):
        """Return the values or the centres of bins of a grid, given by its name, or as values."""
        if not isinstance(grid, str):
            return np.asarray(grid)
        edges = getattr(self, grid)
        if grid in ("strain", "xi", "xi_polar"):
            return edges
        middle = statistics.centres(edges)
        geometric = (grid == "force") & (edges[1:] <= 1)
        return np.where(geometric, np.sqrt(edges[1:] * edges[:-1]), middle)


def with_errors(parts):
    """Return {name: value of the first part, name_error: standard error of the other parts}."""
    whole, *others = parts
    values = {}
    for name, value in whole.items():
        values[name] = value
        if not name.endswith("_fit_error"):
            samples = [other[name] for other in others]
            if name in DIRECTIONS:
                samples = [0.5 * np.angle(np.exp(2j * (sample - value))) for sample in samples]
            values[f"{name}_error"] = statistics.standard_error(samples)
    return plain(values)


def measures(ensemble, grids, parts, keys=None):
    """Return {observable: {name: value, or error over the ensembles `parts`}}, by default of all."""
    ones = {key: OBSERVABLES[key] for key in keys or OBSERVABLES}
    functions = {key: one.measure for key, one in ones.items() if one.measure}
    found = [{key: measure(e, grids) for key, measure in functions.items()}
             for e in (ensemble, *parts)]
    return {key: with_errors([values[key] for values in found]) for key in functions}
