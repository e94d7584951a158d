"""True error of impulses that solve a one-step problem, and the spread of its solutions.

Solutions of a problem with friction differ. The true error of impulses p is their distance to the
solution p* that `exact` reaches when it starts from p:

    velocities   ‖v(p) − v(p*)‖_M / ‖v(p*) − v_free‖_M,  ‖v‖_M² = Σ m |v|² + I ω²
    forces       ‖p − p*‖ / ‖p*‖
    cells k × k  the same of the momenta of the grains of each cell, ‖P‖² = Σ |P|²/m over cells

The *spread* is the distance between the solutions from the warm start and from zero impulses.
Problems are dicts of arrays, as `BodyProblem.arrays()` returns them. All results are relative [-].
"""

import numpy as np

from oracle import generalised
from rcr import _kernel as kernel

REFERENCE = dict(solver="exact", tolerance=1e-9, max_iterations=200_000, accuracy=np.inf)
WORST_REFERENCE = 1e-7  # largest residual of a reference [-]
CELLS = 8, 2  # cells along an edge
TITLES = dict(velocities="velocities", forces="forces") | {
    f"cells_{k}": f"{k} × {k} cells" for k in CELLS}


def velocity_change(problem, impulse):
    """M⁻¹ Jᵀ p, (nb, 3) [m/s, m/s, 1/s]."""
    geometry = [problem[name] for name in ("bodies", "normal", "arm1", "arm2")]
    return problem["inverse_mass"] * generalised(*geometry, impulse, len(problem["inverse_mass"]))


def solution(problem, start):
    """Impulses (nc, 2) that `exact` reaches from `start`; None if its residual stays too large."""
    found = kernel.solve(**dict(problem, impulse=start), **REFERENCE)
    return found["impulse"] if found["residual"] <= WORST_REFERENCE else None


def swept(problem, start):
    """Solve that `auto` reaches from `start`: the reference of packings too large for `exact`."""
    return kernel.solve(**dict(problem, impulse=start), **dict(REFERENCE, solver="auto"))


def distance(problem, impulse, reference, position=None):
    """Distance of impulses to a reference, {name of `TITLES`: relative error}.

    `position`: (nb, 2) centres of the bodies; None leaves out the cells.
    """
    change = velocity_change(problem, reference)
    error = velocity_change(problem, impulse) - change
    mass = _masses(problem)
    found = dict(velocities=_ratio(_norm(error, mass), _norm(change, mass)),
                 forces=_ratio(np.linalg.norm(impulse - reference), np.linalg.norm(reference)))
    if position is not None:
        for k in CELLS:
            found[f"cells_{k}"] = _ratio(*(_cell_norm(problem, v, position, k)
                                           for v in (error, change)))
    return found


def true_error(problem, impulse, position=None):
    """Distance of impulses to the solution that `exact` reaches from them; {} without one."""
    reference = solution(problem, impulse)
    return {} if reference is None else distance(problem, impulse, reference, position)


def spread(problem, position=None):
    """Distance between the solutions from the problem's impulses and from zero; {} without one."""
    warm, cold = (solution(problem, start)
                  for start in (problem["impulse"], np.zeros_like(problem["impulse"])))
    return {} if warm is None or cold is None else distance(problem, cold, warm, position)


def _masses(problem):
    inverse = problem["inverse_mass"]
    return np.divide(1, inverse, out=np.zeros(inverse.shape), where=inverse > 0)


def _norm(velocity, mass):
    return float(np.sqrt((mass * velocity**2).sum()))


def _ratio(size, scale):
    return float(size / scale) if scale > 0 else float(0 if size == 0 else np.inf)


def _cell_norm(problem, velocity, position, k):
    """√Σ |P|²/m of the momenta P of the grains in k × k cells of their bounding box."""
    grains = (problem["inverse_mass"] > 0).all(1)
    place = position[grains]
    cell = (k * (place - place.min(0)) / np.maximum(np.ptp(place, axis=0), 1e-300)).astype(int)
    x, y = np.minimum(cell, k - 1).T
    total = lambda values: np.bincount(k * x + y, values, k * k)
    mass = 1 / problem["inverse_mass"][grains, 0]
    cells = total(mass)
    momenta = [total(mass * velocity[grains, axis]) for axis in (0, 1)]
    return float(np.sqrt(sum((p[cells > 0] ** 2 / cells[cells > 0]).sum() for p in momenta)))
