"""One-step contact problems and their solution.

    u = J v,  v = v_free + M⁻¹ Jᵀ p        with bodies:     BodyProblem
    u = W p + q                            without bodies:  DelassusProblem

    W = J M⁻¹ Jᵀ,  q = J v_free + b_n n
    0 ≤ u_n + b_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) for sliding contacts

Without bodies b_n is 0, since q contains it.

========  =======================================================================================
``.npz``  BodyProblem: arrays a, b, n, ra, rb, bn, mu, p0, im, iI, vfree, meta; with adhesion and
          rolling resistance also pull, rolling_friction, rolling_length, rolling_impulse
``.h5``   FCLIB, group ``fclib_local``: spacedim = 2, W (m, n, nz, nzmax, p, i, x), vectors/q,
          vectors/mu; warm start ``guesses/1/r``. Compressed columns (nz = −1), compressed rows
          (−2) or triplets (their number)
``.dat``  Siconos, 2D: dimension, contacts, matrix (dense, blocks or CSparse), q, µ
========  =======================================================================================

A malformed file raises a ValueError of one line. The module needs NumPy, h5py for ``.h5`` and the
compiled kernels for `solve`; it does not need YADE.
"""

import os
from dataclasses import dataclass, fields

import numpy as np

from rcr._data import checks, files
from rcr._data.problem import BodyProblem, DelassusProblem
from rcr._data.problem_files import load, npz, result_suffix, save, save_fclib

__all__ = ["BodyProblem", "DelassusProblem", "Solution", "load", "result_suffix", "save",
           "save_fclib", "solve"]  # fmt: skip


_SLOWEST = 1e-100  # [m/s]


@dataclass
class Solution:
    """Result of `solve`."""

    solver: str
    contacts: int
    iterations: int
    residual: float  # natural map, relative [-]
    converged: bool  # residual within the tolerance, and no sign that the problem has no solution
    seconds: float  # of the solver alone
    reaction: np.ndarray  # (nc, 2) impulses, local (n, t)
    velocity: np.ndarray  # (nc, 2) without b_n for a BodyProblem, else u = W p + q; local (n, t)
    rolling: np.ndarray | None = None  # (nc,) rolling impulses [N s]; None: no rolling friction

    def scalars(self):
        """Return the results without arrays, {name: value}."""
        return {field.name: getattr(self, field.name) for field in fields(self)[:6]}

    def save(self, path):
        """Save reaction, velocity and rolling as ``.npz`` or ``.h5``; the write is atomic."""
        arrays = dict(reaction=self.reaction, velocity=self.velocity)
        if self.rolling is not None:
            arrays["rolling"] = self.rolling

        def fill(file):
            for name, values in arrays.items():
                file[name] = values
            file.attrs.update(self.scalars())

        if result_suffix(path) == ".npz":
            image = npz(np.savez, **arrays)
        else:
            image = files.hdf5(fill)
        files.write(path, image)


def solve(problem, solver="auto", tolerance=1e-4, max_iterations=10000, warm=False):
    """Solve a one-step contact problem; return a `Solution`.

    A ValueError reports a malformed problem, an unknown solver, a setting outside its range, or a
    result that is not finite, an ImportError kernels that are not compiled.

    Parameters
    ----------
    problem : path, BodyProblem or DelassusProblem
        `load` reads a path.
    solver : str
        nlgs (plain Gauss–Seidel), sor (over-relaxed), nesterov (accelerated), exact or auto.
        Without bodies, exact and auto run as nesterov.
    tolerance : float
        Residual at which the solver stops [-]; 0 runs all iterations, or until `exact` reaches 0.
    max_iterations : int
        Largest number of sweeps and of iterations of the exact solver. An exact iteration is a
        proximal step or a pivot; auto counts it as 20 sweeps in islands of up to 1000 points.
    warm : bool
        Start from the problem's impulses instead of zeros.
    """
    try:
        from rcr import _kernel
    except ImportError as error:
        raise ImportError(
            f"rcr in {os.path.dirname(__file__)} has no kernels, only the analysis: the solver has "
            "to be compiled, with a C++ compiler and SuiteSparse (libsuitesparse-dev); from the "
            "sources: pip install . --config-settings=cmake.define.RCR_PLUGIN=OFF") from error
    checks.choice("solver", solver, _kernel.solver_names())
    tolerance = checks.number("tolerance", tolerance, "a residual ≥ 0", lambda v: v >= 0)
    expected = "at least 1 and at most 2147483647"
    sweeps = checks.integer("max_iterations", max_iterations, expected, lambda v: 1 <= v < 2**31)
    settings = dict(solver=solver, tolerance=tolerance, max_iterations=sweeps)
    if not isinstance(problem, (BodyProblem, DelassusProblem)):
        problem = load(problem)
    bodies = isinstance(problem, BodyProblem)
    given = (problem.free_velocity, problem.bias) if bodies else (problem.q,)
    fastest = max(abs(velocity).max(initial=0) for velocity in given)
    if 0 < fastest < _SLOWEST:
        raise ValueError(f"the largest velocity is {fastest:g}; expected at least {_SLOWEST:g}, "
                         "since squares of smaller numbers vanish: choose other units")
    if bodies:
        found = _solve_bodies(problem, warm, settings)
    else:
        start = problem.impulse if warm else np.zeros((problem.contacts, 2))
        w = problem.row_start, problem.column, problem.block.reshape(-1, 4)
        found = _kernel.solve_delassus(*w, problem.q, problem.friction, start, **settings)
    names = ("iterations", "residual", "converged", "seconds", "impulse", "relative_velocity")
    results = [found[name] for name in names]
    if not all(np.isfinite(result).all() for result in results):
        raise ValueError(f"the result of solver {solver!r} is not finite: masses, velocities or "
                         "entries of W differ too much in size")
    return Solution(solver, problem.contacts, *results, found.get("rolling_impulse"))


def _solve_bodies(problem, warm, settings):
    """Return the results of the kernels for a BodyProblem, with points in its order."""
    from rcr import _kernel

    arguments, order = problem.arrays(), problem.order()
    for name in () if warm else {"impulse", "rolling_impulse"} & arguments.keys():
        arguments[name] = np.zeros_like(arguments[name])
    found = _kernel.solve(**arguments, **settings)
    for name in {"impulse", "relative_velocity", "rolling_impulse"} & found.keys():
        found[name][order] = found[name].copy()
    return found
