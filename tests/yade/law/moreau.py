"""A step of Contact Dynamics (Moreau 1988, Jean 1999) for discs and rods (stadiums) in the plane.

The reference shares no code with the plugin.

    v⁺ = v + dt g + M⁻¹ Jᵀ p,  x⁺ = x + dt v⁺
    0 ≤ u_n + b_n ⟂ p_n ≥ 0,   |p_t| ≤ µ p_n opposite to sliding
    b_n = e u_n⁻ if the gap closes within the step, else max(gap, 0)/dt
"""

import collections
import dataclasses

import numpy as np
from kernel.contact_problems import dense, jacobian_times, problem_of, velocity
from oracle import error

MOST_SWEEPS = 20_000
FASTEST = 10  # m/s; gaps that no pair closes within a step are left out


@dataclasses.dataclass
class Body:
    """A disc (half_length 0), rod or wall (radius 0); without inverse mass an obstacle. SI."""

    center: np.ndarray
    angle: float
    half_length: float
    radius: float
    mass: float = np.inf
    inertia: float = np.inf
    velocity: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))

    @property
    def ends(self):
        arm = self.half_length * np.array([np.cos(self.angle), np.sin(self.angle)])
        return [self.center - arm, self.center + arm] if self.half_length else [self.center]

    @property
    def inverse_mass(self):
        return np.array([1 / self.mass, 1 / self.mass, 1 / self.inertia])


Point = collections.namedtuple("Point", "i j position normal gap")  # the normal is from i to j


def foot(x, ends):
    """The point of a core nearest to x."""
    if len(ends) == 1:
        return ends[0]
    along = ends[1] - ends[0]
    return ends[0] + np.clip((x - ends[0]) @ along / (along @ along), 0, 1) * along


def points_of(i, j, one, two):
    """Contact points: each end of each core with the nearest point of the other core."""
    found = []
    pairs = [(foot(end, one.ends), end) for end in two.ends]
    pairs += [(end, foot(end, two.ends)) for end in one.ends]
    for a, b in pairs:
        distance = np.linalg.norm(b - a)
        normal = (b - a) / distance
        middle = 0.5 * (a + one.radius * normal + b - two.radius * normal)
        if all(np.linalg.norm(middle - p.position) > 1e-9 * two.radius for p in found):
            found.append(Point(i, j, middle, normal, distance - one.radius - two.radius))
    return found


def contacts(bodies, reach):
    """Points with gaps below `reach` of all pairs with a body that moves."""
    found = []
    for j, two in enumerate(bodies):
        for i, one in enumerate(bodies[:j]):
            if one.inverse_mass.any() or two.inverse_mass.any():
                found += points_of(i, j, one, two)
    return [p for p in found if p.gap < reach]


def solve_point(w, q, friction):
    """p of one point with Signorini's and Coulomb's law; u = q + W p."""
    if q[0] >= 0:
        return np.zeros(2)
    p = -np.linalg.solve(w, q)
    if abs(p[1]) <= friction * p[0]:
        return p
    slope = np.sign(p[1]) * friction
    normal = -q[0] / (w[0, 0] + slope * w[0, 1])
    return np.array([normal, slope * normal])


def solve(problem, tolerance=1e-10):
    """Velocities (N, 3) after the step, impulses (K, 2), residual of docs/law.md, by Gauss–Seidel.
    ‖p‖ is at least 1e-6 of the impulses that stop all points: grazing impulses are rounding.
    """
    (w, q), mu, p = dense(problem), problem["friction"], problem["impulse"]
    w_nn = np.diag(w)[::2]
    least = max(1e-6 * np.linalg.norm((q[:, 0] - problem["bias"]) / w_nn), 1e-300)
    for sweep in range(MOST_SWEEPS):
        for k in range(len(p)):
            block = w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2]
            u = q[k] + w[2 * k : 2 * k + 2] @ p.ravel()
            p[k] = solve_point(block, u - block @ p[k], mu[k])
        if sweep % 10 == 0:
            u = q + (w @ p.ravel()).reshape(-1, 2)
            residual = np.linalg.norm(error(p, u, mu, w_nn)) / max(np.linalg.norm(p), least)
            if residual <= tolerance:
                return velocity(problem, p), p, residual
    raise RuntimeError(f"not converged after {MOST_SWEEPS} sweeps")


def step(bodies, dt, gravity, friction=0.0, restitution=0.0):
    """Moves the bodies by one step; returns contact points, impulses and residual."""
    points = contacts(bodies, FASTEST * dt)
    before, inverse_mass, center = (np.array([getattr(b, name) for b in bodies])
                                    for name in ("velocity", "inverse_mass", "center"))
    after = before + dt * np.outer(inverse_mass.any(1), [*gravity, 0])
    impulses, residual = np.zeros((0, 2)), 0
    if points:
        i, j, position, normal, gap = map(np.array, zip(*points))
        problem = problem_of("step", inverse_mass, after, np.column_stack([i, j]), normal,
                             position - center[i], position - center[j], friction=friction)
        approach = jacobian_times(problem, before)[:, 0]
        meets = (restitution > 0) & (approach < 0) & (gap + dt * approach < 0)
        problem["bias"] = np.where(meets, restitution * approach, np.maximum(gap, 0) / dt)
        after, impulses, residual = solve(problem)
    for body, v in zip(bodies, after):
        if body.inverse_mass.any():
            body.velocity = v
            body.center = body.center + dt * v[:2]
            body.angle += dt * v[2]
    return points, impulses, residual


def energy(bodies, gravity):
    free = [b for b in bodies if b.inverse_mass.any()]
    kinetic = sum(0.5 * (b.velocity**2 / b.inverse_mass).sum() for b in free)
    return kinetic, -sum(b.mass * np.dot(gravity, b.center) for b in free)
