"""Exact solutions of small contact problems with NumPy, independent of the kernels.

    u = W p + q,  W = J M⁻¹ Jᵀ,  q = J v_free + b_n n
    0 ≤ u_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) for sliding points

Each island is solved alone. Proximal steps make the matrix regular: W + ε D, q − ε D p_ref, with
p_ref ← p. Each step changes the state of points (open, sticking, sliding) until all laws hold.
Dense factorisations leave no errors that vary slowly from point to point.

`unique` compares solutions from two starts: velocities, forces of pairs of bodies and of points.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lu_factor, lu_solve, solve_triangular
from scipy.optimize import nnls
from scipy.sparse import coo_array, diags_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, dijkstra

from rcr import _kernel

OPEN, STICK, SLIDE = 0, 1, 2
# ε [-] and steps with it; smaller ones follow where steps are slow
PROXIMAL = (1e-2, 2), (1e-4, 3), (1e-6, 12), (1e-8, 12), (1e-10, 12)
ROUNDING = 1e-14  # error of the laws without a proximal term, over the largest impulse
LAWS, LAST_STEP = 1e-10, 1e-14  # errors of the laws, and ε p − ε p_ref, over the largest impulse
MOST_ROUGH = 300  # points with friction
TRIES, SWEEPS = 60, 100  # changes of states in a proximal step, sweeps where they cycle
UNIQUE = 1e-4  # distance of two solutions that are the same [-]
TURN, GAP, STABLE = 1e-6, 1e-6, 3e-3  # forces are unique if turns [rad] and gaps change them less
DEPENDENT = 1e-12  # least eigenvalue of W of the normals, for w_nn = 1 [-]
IDLE = 1e-9  # change of velocities over velocities of an island without load [-]
REST = 1e-2  # least scale of velocities, over ‖p‖_w


@dataclass
class Island:
    """Free bodies that contacts connect, and one solution."""

    bodies: np.ndarray  # (nb,) numbers of the free bodies
    points: np.ndarray  # (nc,)
    impulse: np.ndarray  # (nc, 2) [N s]
    slim: bool
    frictional: bool

    def goal(self, accuracy):
        """Largest error of a converged island [-]: docs/law.md."""
        return accuracy * (_kernel.solution_spread if self.frictional and not self.slim else 1)


def jacobian(problem):
    """J (2 nc, 3 nb), rows n₀, t₀, n₁, t₁ …"""
    n, nc = problem["normal"], len(problem["bodies"])
    entries = []
    for row, d in enumerate((n, np.stack([-n[:, 1], n[:, 0]], 1))):
        for side, arm, sign in (0, problem["arm1"], -1), (1, problem["arm2"], 1):
            turn = arm[:, 0] * d[:, 1] - arm[:, 1] * d[:, 0]
            for column, value in enumerate((d[:, 0], d[:, 1], turn)):
                entries.append((2 * np.arange(nc) + row, 3 * problem["bodies"][:, side] + column,
                                sign * value))
    rows, columns, values = map(np.concatenate, zip(*entries))
    return coo_array((values, (rows, columns)), (2 * nc, problem["inverse_mass"].size)).tocsr()


def islands(problem):
    """Exact solutions, [Island or None]: None where no solution was found. Idle islands are left
    out.
    """
    free = problem["inverse_mass"].any(1)
    links = problem["bodies"][free[problem["bodies"]].all(1)].T
    graph = coo_array((np.ones(len(links[0])), links), (len(free), len(free))).tocsr()
    label = connected_components(graph, directed=False)[1]
    of_point = np.where(free[problem["bodies"]], label[problem["bodies"]], -1).max(1)
    found = []
    for k in sorted(set(of_point) - {-1}):
        points, bodies = np.flatnonzero(of_point == k), np.flatnonzero((label == k) & free)
        w, q = _delassus(problem, points)
        friction = problem["friction"][points]
        one = solution(w, q, friction)
        speed = abs(problem["free_velocity"][bodies]).max() + abs(q).max()
        if one is not None and abs(w @ one.ravel()).max() <= IDLE * speed:
            continue
        island = one is not None and Island(
            bodies, points, one, _slim(graph, bodies), bool(friction.any()))
        found.append(island or None)
    return found


def unique(problem, island, given):
    """Names of `distances` that other starts do not change; of forces, those that small changes
    of normals and gaps do not change either.

    Contacts that bear force in the solution or in the `given` impulses (nc, 2) may have dependent
    normals, as in a row that fits between two walls. Tiny gaps then decide on the forces, and on
    velocities with friction.
    """
    if _dependent(problem, island, (given[:, 0] > 0) | (island.impulse[:, 0] > 0)):
        return () if island.frictional else ("velocities",)
    other = _other(problem, island)
    away = {} if other is None else distances(problem, island, other)
    names = {name for name in away if away[name] <= UNIQUE}
    changed = _changed(problem, island.points)
    tries = (from_impulses(changed, island, start) for start in (None, island.impulse))
    turned = next((found for found in tries if found is not None), None)
    away = {} if turned is None else distances(problem, island, turned)
    stable = {name for name in ("points", "pairs") if away.get(name, 1) <= STABLE}
    if not island.frictional:
        names.add("velocities")  # of a convex problem
    return tuple(sorted(names & (stable | {"velocities"})))


def _dependent(problem, island, closed):
    """True if the normals of these points are linearly dependent."""
    w = _delassus(problem, island.points[closed])[0][::2, ::2]
    size = np.sqrt(w.diagonal())
    return len(w) and np.linalg.eigvalsh(w / size / size[:, None])[0] < DEPENDENT


def _changed(problem, points):
    """The problem with other gaps of these points. Without friction, normals and arms turn too:
    with it, turned points of a rod could not stick together.
    """
    rng = np.random.default_rng(2)
    angle = rng.normal(0, TURN, len(points))
    changed = dict(problem, bias=problem["bias"].copy())
    gaps = abs(_delassus(problem, points)[1][:, 0]).max() * GAP
    changed["bias"][points] += gaps * rng.uniform(-1, 1, len(points))
    if problem["friction"][points].any():
        return changed
    for name in "normal", "arm1", "arm2":
        part = problem[name][points]
        moved = part + angle[:, None] * np.stack([-part[:, 1], part[:, 0]], 1)
        changed[name] = problem[name].copy()
        changed[name][points] = moved
    return changed


def _slim(graph, bodies):
    """True if docs/law.md counts the island as a row, column or small one."""
    part = graph[bodies][:, bodies]
    part = ((part + part.T) > 0).astype(float)
    far = breadth_first_order(part, 0, directed=False)[0][-1]
    diameter = int(dijkstra(part, indices=far, unweighted=True).max())
    n, pairs = len(bodies), part.nnz // 2
    return n <= 16 or n <= 6 * diameter or 20 * (pairs + 1 - n) <= n


def distances(problem, island, impulse):
    """Relative distances of impulses (nc, 2) of the island to its solution, {name: error}."""
    points, masses = island.points, problem["inverse_mass"]
    part = {name: problem[name][points] for name in ("bodies", "normal", "arm1", "arm2")}
    j = jacobian(dict(part, inverse_mass=masses))
    own, weight = masses.ravel(), (j.power(2) @ masses.ravel())[::2]
    energy = lambda p: float(np.sqrt((own * (j.T @ p.ravel()) ** 2).sum()))
    size = lambda p: float(np.linalg.norm(p))
    pairs = lambda p: _pair_forces(part, p)
    exact, change = island.impulse, impulse - island.impulse
    load = max(float(np.sqrt((weight[:, None] * p**2).sum())) for p in (exact, impulse))
    scale = max(energy(exact), REST * load)
    return dict(velocities=energy(change) / scale,
                pairs=size(pairs(change)) / size(pairs(exact)),
                points=size(change) / size(exact))


def _pair_forces(part, p):
    """Sums of the impulses of each pair of bodies, (pairs, 2)."""
    n = part["normal"]
    force = p[:, :1] * n + p[:, 1:] * np.stack([-n[:, 1], n[:, 0]], 1)
    _, pair = np.unique(part["bodies"], axis=0, return_inverse=True)
    return np.column_stack([np.bincount(pair.ravel(), force[:, axis]) for axis in (0, 1)])


def from_impulses(problem, island, start):
    """Another solution of the island, from impulses (nc, 2); or None."""
    return solution(*_delassus(problem, island.points), problem["friction"][island.points], start)


def _delassus(problem, points):
    """W (2 nc, 2 nc) and q (nc, 2) with b_n of these points."""
    part = {name: problem[name][points] for name in ("bodies", "normal", "arm1", "arm2")}
    inverse = problem["inverse_mass"]
    j = jacobian(dict(part, inverse_mass=inverse))
    q = (j @ problem["free_velocity"].ravel()).reshape(-1, 2)
    q[:, 0] += problem["bias"][points]
    return (j @ diags_array(inverse.ravel()) @ j.T).toarray(), q


def solution(w, q, friction, start=None):
    """Impulses (nc, 2) that obey the laws, or None; `start`: impulses of the first step.

    Points far from closing are left out, and added where the solution closes them.
    """
    p = np.zeros(q.shape)
    near = q[:, 0] <= 2 * abs(q[:, 0].min(initial=0))
    for _ in range(10):
        if friction[near].any() and near.sum() > MOST_ROUGH:
            return None
        rows = np.repeat(near, 2)
        found = _of_points(w[np.ix_(rows, rows)], q[near], friction[near],
                           None if start is None else start[near])
        if found is None:
            return None
        p[near] = found
        u = (w @ p.ravel())[::2] + q[:, 0]
        closing = ~near & (u < -LAWS * abs(q).max())
        if not closing.any():
            return p
        near |= closing
    return None


def _of_points(w, q, friction, start):
    """The same without leaving out points."""
    nc, rng = len(q), np.random.default_rng(1)
    scale = np.repeat(1 / np.sqrt(w.diagonal()[::2]), 2)
    matrix, load = scale[:, None] * w * scale, scale * q.ravel()
    size = abs(load).max(initial=0)
    if size == 0:
        return np.zeros((nc, 2))
    p = np.zeros((nc, 2)) if start is None else start / scale.reshape(-1, 2)
    closed = np.column_stack([-load[::2], 0 * load[::2]])
    states = _states_of(closed if start is None else p, friction)
    for epsilon, steps in PROXIMAL:
        for _ in range(steps):
            regular = matrix + epsilon * np.eye(2 * nc)
            pulled = load - epsilon * p.ravel()
            found = _with_states(regular, pulled, friction, states, rng)
            if found is None:
                start = (_sweeps if friction.any() else _nnls)(regular, pulled, friction, p)
                found = _with_states(regular, pulled, friction, _states_of(start, friction), rng)
            if found is None:
                return None
            last, (p, *states) = p, found
            largest = max(abs(p).max(), 1e-300)
            if (epsilon * abs(p - last).max() <= LAST_STEP * largest
                    and _violation(matrix, load, friction, p) <= LAWS * max(largest, size)):
                exact = _without_proximal_term(matrix, load, friction, p, states)
                return (p if exact is None else exact) * scale.reshape(-1, 2)
        exact = _without_proximal_term(matrix, load, friction, p, states)
        if exact is not None:
            return exact * scale.reshape(-1, 2)
    return None


def _without_proximal_term(matrix, load, friction, p, states):
    """The impulses of these states, if the matrix is regular and they obey the laws; or None."""
    with warnings.catch_warnings(action="ignore"):
        found = _of_states(matrix, load, friction, *states)
    largest = max(abs(p).max(), 1e-300)
    is_near = abs(found - p).max() <= largest  # False for NaN
    obeys = is_near and _violation(matrix, load, friction, found) <= ROUNDING * largest
    return found if obeys else None


def _states_of(p, friction):
    """States of the points, and directions of sliding, of impulses (nc, 2)."""
    stuck = (friction > 0) & (abs(p[:, 1]) < (1 - 1e-9) * friction * p[:, 0])
    return np.select([p[:, 0] <= 0, stuck], [OPEN, STICK], SLIDE), np.where(p[:, 1] < 0, -1.0, 1.0)


def _nnls(matrix, load, friction, p):
    """Impulses without friction: the active-set method of Lawson and Hanson."""
    factor = np.linalg.cholesky(matrix[::2, ::2])
    target = -solve_triangular(factor, load[::2], lower=True)
    try:
        return np.column_stack([nnls(factor.T, target, maxiter=20 * len(target))[0], 0 * target])
    except RuntimeError:  # too many iterations
        return p


def _sweeps(matrix, load, friction, p):
    """Impulses near the solution: Gauss–Seidel over the points."""
    p, nc = p.copy(), len(p)
    flat, blocks = p.ravel(), matrix.reshape(nc, 2, nc, 2)
    for _ in range(SWEEPS):
        for k in range(nc):
            (nn, nt), (tn, tt) = blocks[k, :, k].tolist()
            n, t = flat[2 * k:2 * k + 2]
            gn, gt = matrix[2 * k:2 * k + 2] @ flat + load[2 * k:2 * k + 2]
            gn, gt = gn - nn * n - nt * t, gt - tn * n - tt * t
            flat[2 * k:2 * k + 2] = _one_point(nn, nt, tt, gn, gt, friction[k])
    return p


def _one_point(nn, nt, tt, gn, gt, friction):
    """Impulse (n, t) of one point with u = W p + g."""
    if gn >= 0:
        return 0, 0
    if friction:
        det = nn * tt - nt * nt
        n, t = (nt * gt - tt * gn) / det, (nt * gn - nn * gt) / det
        if abs(t) <= friction * n:
            return n, t
    sign = friction * (-1 if gt > gn * nt / nn else 1)
    n = -gn / max(nn + nt * sign, 1e-6 * nn)
    return n, sign * n


def _other(problem, island):
    """A solution from a start that differs at random from a solution, within the cones; or None."""
    one, friction = island.impulse, problem["friction"][island.points]
    rng = np.random.default_rng(1)
    size = np.sqrt(_delassus(problem, island.points)[0].diagonal()[::2])
    mean = (size * one[:, 0]).mean() / size
    for change in 1, 0.5, 0.2:
        n = one[:, 0] * (1 + change * rng.uniform(-1, 1, len(one)))
        n += change * mean * rng.random(len(one))
        t = one[:, 1] + change * friction * n * rng.uniform(-1, 1, len(one))
        start = np.column_stack([n, np.clip(t, -friction * n, friction * n)])
        found = from_impulses(problem, island, start)
        if found is not None:
            return found
    return None


def _violation(matrix, load, friction, p):
    """Largest difference of p to its projection p − u onto the laws."""
    u = (matrix @ p.ravel() + load).reshape(-1, 2)
    n = np.maximum(p[:, 0] - u[:, 0], 0)
    t = np.clip(p[:, 1] - u[:, 1], -friction * n, friction * n)
    return max(abs(p[:, 0] - n).max(), abs(p[:, 1] - t).max())


def _with_states(matrix, load, friction, states, rng):
    """Impulses that obey the laws of a regular matrix, with the states of the points; or None.

    All points that break a law change their state. Where that cycles, random ones of them do.
    """
    state, sign = (part.copy() for part in states)
    least, since = len(state) + 1, 0
    diagonal = matrix.diagonal().reshape(-1, 2)
    for _ in range(TRIES):
        p = _of_states(matrix, load, friction, state, sign)
        u = (matrix @ p.ravel() + load).reshape(-1, 2)
        size = abs(p).max() + abs(load).max()
        next_state, next_sign = _next_states(p, u, diagonal, friction, state, sign, 1e-13 * size)
        wrong = np.flatnonzero((next_state != state) | (next_sign != sign))
        if not len(wrong):
            return p, state, sign
        since = 0 if len(wrong) < least else since + 1
        least = min(least, len(wrong))
        if since > 6:
            share = rng.choice([0.5, 0.1, 0])
            keep = rng.random(len(wrong)) < share
            keep[rng.integers(len(wrong))] = True
            wrong = wrong[keep]
        state[wrong], sign[wrong] = next_state[wrong], next_sign[wrong]
    return None


def _next_states(p, u, diagonal, friction, state, sign, rounding):
    """States and directions of sliding that impulses and velocities call for."""
    opens = (state != OPEN) & (p[:, 0] < -rounding)
    closes = (state == OPEN) & (u[:, 0] < -rounding)
    rough, bound = friction > 0, friction * np.maximum(p[:, 0], 0)
    slips = (state == STICK) & (abs(p[:, 1]) > bound + rounding)
    sticks = (state == SLIDE) & rough & (sign * u[:, 1] > rounding)
    next_state = state.copy()
    next_state[closes & rough], next_state[closes & ~rough] = STICK, SLIDE
    next_state[slips], next_state[sticks], next_state[opens] = SLIDE, STICK, OPEN
    return next_state, np.where(slips & ~opens, np.sign(p[:, 1]), sign)


def _of_states(matrix, load, friction, state, sign):
    """Impulses (nc, 2) that keep closed points closed and sticking points at rest."""
    nc, p = len(state), np.zeros(2 * len(state))
    closed, stuck = np.flatnonzero(state != OPEN), np.flatnonzero(state == STICK)
    rows = np.concatenate([2 * closed, 2 * stuck + 1])
    if not len(rows):
        return p.reshape(nc, 2)
    columns = matrix[np.ix_(rows, rows)]
    slides = np.flatnonzero((state[closed] == SLIDE) & (friction[closed] > 0))
    tied = closed[slides]  # their p_t is ±µ p_n
    columns[:, slides] += matrix[np.ix_(rows, 2 * tied + 1)] * (sign * friction)[tied]
    p[rows] = lu_solve(lu_factor(columns, check_finite=False), -load[rows], check_finite=False)
    p[2 * tied + 1] = (sign * friction)[tied] * p[2 * tied]
    return p.reshape(nc, 2)
