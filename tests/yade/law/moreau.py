"""A step of Contact Dynamics (Moreau 1988, Jean 1999) for discs and rods (stadiums) in the plane.

The reference shares no code with the plugin.

    v⁺ = v + dt g + M⁻¹ Jᵀ p,  x⁺ = x + dt v⁺
    0 ≤ u_n + b_n ⟂ p_n ≥ 0,   |p_t| ≤ µ p_n opposite to sliding
    b_n = e u_n⁻ if the gap closes within the step, else max(gap, 0)/dt
"""

import dataclasses

import numpy as np
from natural_map import error

MOST_SWEEPS = 20_000
FASTEST = 10  # m/s; gaps that no pair closes within a step are left out


@dataclasses.dataclass
class Body:
    """A disc (half_length 0) or rod, radius 0: a wall; without inverse mass it is an obstacle. SI.
    """

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


@dataclasses.dataclass
class Point:
    """A contact point of bodies i and j; the normal points from i to j."""

    i: int
    j: int
    position: np.ndarray
    normal: np.ndarray
    gap: float


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


def jacobian(point, bodies):
    """(2, 6): relative velocity (u_n, u_t) of a point from both velocities (v_x, v_y, ω)."""
    n = point.normal
    frame = np.array([n, [-n[1], n[0]]])
    rows = []
    for number, sign in ((point.i, -1), (point.j, 1)):
        r = point.position - bodies[number].center
        rows.append(sign * np.column_stack([frame, frame @ [-r[1], r[0]]]))
    return np.hstack(rows)


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


def solve(bodies, points, velocity, bias, friction, tolerance=1e-10):
    """Velocities (N, 3) after the step, impulses (K, 2), residual of docs/law.md, by Gauss–Seidel.
    ‖p‖ is at least 1e-6 of the impulses that stop all points: grazing impulses are rounding.
    """
    count, p = len(points), np.zeros((len(points), 2))
    j = np.zeros((count, 2, len(bodies), 3))
    for k, point in enumerate(points):
        j[k][:, [point.i, point.j]] = jacobian(point, bodies).reshape(2, 2, 3)
    j = j.reshape(2 * count, 3 * len(bodies))
    minv_jt = np.ravel([b.inverse_mass for b in bodies])[:, None] * j.T
    w, q = j @ minv_jt, (j @ velocity.ravel()).reshape(-1, 2)
    w_nn, mu = np.diag(w)[::2], np.full(count, friction)
    least = max(1e-6 * np.linalg.norm(q[:, 0] / w_nn), 1e-300)
    q = q + np.column_stack([bias, np.zeros(count)])
    for sweep in range(MOST_SWEEPS):
        for k in range(count):
            block = w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2]
            u = q[k] + w[2 * k : 2 * k + 2] @ p.ravel()
            p[k] = solve_point(block, u - block @ p[k], friction)
        if sweep % 10 == 0:
            u = q + (w @ p.ravel()).reshape(-1, 2)
            residual = np.linalg.norm(error(p, u, mu, w_nn)) / max(np.linalg.norm(p), least)
            if residual <= tolerance:
                return velocity + (minv_jt @ p.ravel()).reshape(-1, 3), p, residual
    raise RuntimeError(f"not converged after {MOST_SWEEPS} sweeps")


def step(bodies, dt, gravity, friction=0.0, restitution=0.0):
    """Moves the bodies by one step; returns contact points, impulses and residual."""
    points = contacts(bodies, FASTEST * dt)
    before = np.array([b.velocity for b in bodies])
    moving = np.array([b.inverse_mass.any() for b in bodies])
    free = before + dt * np.outer(moving, [*gravity, 0])
    bias = []
    for p in points:
        approach = jacobian(p, bodies)[0] @ before[[p.i, p.j]].ravel()
        meets = restitution > 0 and approach < 0 and p.gap + dt * approach < 0
        bias.append(restitution * approach if meets else max(p.gap, 0) / dt)
    velocity, impulses, residual = solve(bodies, points, free, bias, friction)
    for body, v in zip(bodies, velocity):
        if body.inverse_mass.any():
            body.velocity = v
            body.center = body.center + dt * v[:2]
            body.angle += dt * v[2]
    return points, impulses, residual


def energy(bodies, gravity):
    free = [b for b in bodies if b.inverse_mass.any()]
    kinetic = sum(0.5 * (b.velocity**2 / b.inverse_mass).sum() for b in free)
    return kinetic, -sum(b.mass * np.dot(gravity, b.center) for b in free)
