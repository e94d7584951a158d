"""Packings for benchmarks of steps: a table for other libraries, a contact problem for our solver.

Units: the mean diameter, the mean mass and the second. A wall is the half plane behind a point of
its face.
"""

from dataclasses import dataclass

import numpy as np

WALL_NORMALS = np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])  # left, bottom, right, top
COLUMNS = ("x y angle half_length radius mass inertia vx vy omega"
           " force_x force_y normal_x normal_y").split()


@dataclass
class Packing:
    """N grains and the walls left, bottom, right, top."""

    pose: np.ndarray  # (N + 4, 3) x, y, angle; walls: a point of the face
    stadium: np.ndarray  # (N, 2) half length and cap radius
    mass: np.ndarray  # (N + 4,); 0 = prescribed motion
    inertia: np.ndarray  # (N,)
    velocity: np.ndarray  # (N + 4, 3) at the start of the step
    force: np.ndarray  # (N + 4, 2)
    dt: float

    @property
    def grains(self):
        return len(self.stadium)

    @property
    def inverse_mass(self):
        """(N + 4, 3) along x, along y, about z; the side walls move along x only."""
        inverse = np.divide(1, self.mass, out=np.zeros(len(self.mass)), where=self.mass > 0)
        result = np.column_stack([inverse, inverse, np.append(1 / self.inertia, np.zeros(4))])
        result[self.grains :, 1] = 0
        return result

    @property
    def shape(self):
        return "long" if (self.stadium[:, 0] > 0).any() else "discs"

    def table(self, skin):
        """Input of the step programs: a row a body, see `COLUMNS`; grains grow by `skin`."""
        pad = lambda values, width: np.concatenate([values, np.zeros((4, width))])
        normals = np.concatenate([np.zeros((self.grains, 2)), WALL_NORMALS])
        stadium, inertia = pad(self.stadium + [0, skin], 2), pad(self.inertia[:, None], 1)
        return np.column_stack(
            [self.pose, stadium, self.mass, inertia, self.velocity, self.force, normals])

    def free_velocity(self, before):
        """Velocities without impulses, (N + 4, 3)."""
        return before + self.dt * self.inverse_mass * np.column_stack(
            [self.force, np.zeros(len(self.force))])

    def problem(self, friction, alert):
        """Contact problem of the step, cold: gaps up to `alert`, at walls up to half of it."""
        from rcr import _kernel as kernel
        from rcr.problems import BodyProblem
        from scipy.spatial import cKDTree

        centre, reach = self.pose[: self.grains, :2], self.stadium.sum(1)
        pairs = cKDTree(centre).query_pairs(2 * reach.max() + alert, output_type="ndarray")
        distance = np.hypot(*(centre[pairs[:, 0]] - centre[pairs[:, 1]]).T)
        pairs = pairs[distance < reach[pairs].sum(1) + alert]
        pairs = pairs[np.lexsort(pairs.T[::-1])].reshape(-1, 2)
        pose = np.ascontiguousarray(self.pose[: self.grains])
        i, j = pairs.T
        at = kernel.overlap_stadiums(self.stadium[i], pose[i], self.stadium[j], pose[j], alert)
        found, grains = [(pairs, at, friction)], np.arange(self.grains)
        for wall, normal in enumerate(WALL_NORMALS, self.grains):
            face, normals = (np.tile(v, (self.grains, 1)) for v in (self.pose[wall, :2], normal))
            at = kernel.overlap_wall(face, normals, self.stadium, pose, alert / 2)
            found.append((np.column_stack([np.full(self.grains, wall), grains]), at, 0.0))
        rows = []
        for ids, manifold, coefficient in found:
            there = np.arange(2) < manifold["count"][:, None]
            columns = (manifold[name][there] for name in ("position", "normal", "gap"))
            bodies, mu = np.repeat(ids[:, None], 2, 1)[there], np.full(there.sum(), coefficient)
            rows.append((bodies, *columns, mu))
        bodies, position, normal, gap, mu = map(np.concatenate, zip(*rows))
        arm1, arm2 = (position - self.pose[bodies[:, side], :2] for side in (0, 1))
        return BodyProblem(self.inverse_mass, self.free_velocity(self.velocity), bodies, normal,
                           np.where((bodies[:, :1] < self.grains), arm1, 0), arm2,
                           np.maximum(gap, 0) / self.dt, mu, np.zeros((len(mu), 2)))


def load(path):
    """Packing of a network: walls lie at their contacts, the stress loads the side walls."""
    from rcr import Network
    from rcr import _kernel as kernel

    if not path.endswith((".h5", ".hdf5")):
        raise ValueError(f"{path}: expected a network .h5")
    network = Network.load(path)
    p, c, count = network.particles, network.contacts, len(network.particles["id"])
    stadium = np.column_stack([p["half_length"], p["cap_radius"]])
    pose = np.concatenate([np.column_stack([p["position"], p["angle"]]), np.zeros((4, 3))])
    for wall in range(4):
        touching = c["position"][c["body2"] == -1 - wall]
        if not len(touching):
            raise ValueError(
                f"{path}: no grain touches wall {-1 - wall}; give a packing between four walls")
        pose[count + wall, wall % 2] = touching[:, wall % 2].mean()
    side = p["mass"].sum() / np.sqrt(count)
    mass = np.append(p["mass"], [side, 0, side, 0])
    inertia = p["mass"] * [kernel.polar_moment(*s) / kernel.area(*s) for s in stadium]
    velocity, force = np.concatenate([p["velocity"], np.zeros((4, 3))]), np.zeros((count + 4, 2))
    height = pose[count + 3, 1] - pose[count + 1, 1]
    force[[count, count + 2], 0] = network.stress()[0, 0] * height * np.array([1, -1])
    length, unit = 2 * stadium.sum(1).mean(), p["mass"].mean()
    per_length = np.array([1 / length, 1 / length, 1])
    return Packing(pose=pose * per_length, stadium=stadium / length, mass=mass / unit,
                   inertia=inertia / (unit * length**2), velocity=velocity * per_length,
                   force=force / (unit * length), dt=float(network.attributes["dt"]))
