"""Fields of a scene's free grains on a grid: solid fraction, velocity, stress, fabric, coordination. Needs NumPy; a plot Matplotlib.

    profile = rcr.Profile(cells=(1, 20)).compute(network)    # 20 layers; any scene, network or file
    profile.velocity[0, :, 0]                                # v_x(y) of them
    profile.plot(quantity="pressure")

A grain is spread over its outline, a contact's f⊗ℓ along its branch vector: sums over the grid are those of the grains and contacts in it,
so stress × area of the cells adds up to volume × `Network.stress`, however fine the grid.
"""

import math

import numpy as np

from rcr import _checks as checks
from rcr.frame import OUTLINE, Frame
from rcr._outlines import half_extents

ACROSS = 8  # sample points across a grain and as many along it, and along each half of a branch vector

QUANTITIES = dict(
    solid_fraction=("solid fraction", lambda p: p.solid_fraction, "Blues"),
    velocity_x=("$v_x$ [m/s]", lambda p: p.velocity[..., 0], "coolwarm"),
    velocity_y=("$v_y$ [m/s]", lambda p: p.velocity[..., 1], "coolwarm"),
    speed=("speed [m/s]", lambda p: np.hypot(p.velocity[..., 0], p.velocity[..., 1]), "viridis"),
    pressure=("pressure [Pa]", lambda p: p.pressure, "magma_r"),
    shear_stress=(r"$\sigma_{xy}$ [Pa]", lambda p: p.stress[..., 0, 1], "coolwarm"),
    coordination=("contacts a grain", lambda p: p.coordination, "YlGnBu"),
)


class Profile:
    """Fields on a grid of rectangles.

    Parameters
    ----------
    cells : (int, int)
        Number of cells along x and along y; a 1 makes a profile along the other axis.
    limits : ((float, float), (float, float)), optional
        Lower left and upper right corner [m]; by default the box around the grains of what is computed first, or the periodic cell. What
        lies outside is left out.

    Raises
    ------
    ValueError
        If a number of cells is not whole and at least 1, or the limits enclose no area.
    """

    def __init__(self, cells=(1, 20), limits=None):
        if np.shape(cells) != (2,):
            raise ValueError(f"cells = {cells!r}; wanted two numbers, along x and along y")
        self.cells = tuple(checks.integer(f"cells[{k}]", n, "at least 1", lambda v: v >= 1) for k, n in enumerate(cells))
        self._given = None if limits is None else checks.array("limits", limits, (2, 2))
        if limits is not None and not (self._given[1] > self._given[0]).all():
            raise ValueError(f"limits = {limits!r}; wanted the lower left and the upper right corner of a rectangle [m]")
        self.limits = self._given
        self._sums = None

    def __repr__(self):
        grid = f"{self.cells[0]} × {self.cells[1]} cells"
        if self._sums is None:
            return f"<Profile: {grid}, nothing computed yet>"
        (left, bottom), (right, top) = self.limits
        return f"<Profile: {grid} from ({left:g}, {bottom:g}) to ({right:g}, {top:g}) m, {'mean of ' * (self._moments > 1)}{self._moments} moment{'s' * (self._moments > 1)}>"

    def compute(self, what=None, reset=True):
        """Fields of one moment.

        Parameters
        ----------
        what : None, Frame, Network or path
            None is the present scene of YADE; see `rcr.frame.Frame.of`.
        reset : bool
            Forget what was computed before; False averages over all moments since.

        Returns
        -------
        Profile
            This one.

        Raises
        ------
        ValueError
            If there is no grain, or the periodic cell's first edge does not lie along x.
        """
        frame = Frame.of(what)
        if reset or self._sums is None:
            self.limits = _limits(frame) if self._given is None else self._given
            self._sums, self._moments = {}, 0
        self._moments += 1
        self._add_grains(frame)
        self._add_contacts(frame)
        return self

    @property
    def edges(self):
        """Edges of the cells along x (n_x + 1,) and along y (n_y + 1,) [m]."""
        self._sum("area")
        return tuple(np.linspace(low, high, n + 1) for low, high, n in zip(*self.limits, self.cells))

    @property
    def centers(self):
        """Centres of the cells along x (n_x,) and along y (n_y,) [m]."""
        return tuple(0.5 * (edges[1:] + edges[:-1]) for edges in self.edges)

    @property
    def cell_area(self):
        """Area of one cell [m²]."""
        x, y = self.edges
        return (x[1] - x[0]) * (y[1] - y[0])

    @property
    def solid_fraction(self):
        """Share of the grains' area in each cell, (n_x, n_y) [-]."""
        return self._sum("area") / self.cell_area

    @property
    def velocity(self):
        """Mean velocity of the mass in each cell, (n_x, n_y, 2) [m/s]; NaN where there is none."""
        return _ratio(self._sum("momentum"), self._sum("mass"))

    @property
    def stress(self):
        """Stress of the contacts in each cell (Love, Weber), (n_x, n_y, 2, 2), compression positive [Pa]."""
        return self._sum("moments") / self.cell_area

    @property
    def pressure(self):
        """Half the trace of the stress, (n_x, n_y) [Pa]."""
        return 0.5 * np.einsum("xyaa->xy", self.stress)

    @property
    def fabric(self):
        """Mean n⊗n of the contacts between grains in each cell, (n_x, n_y, 2, 2), trace 1 [-]; NaN where there is none."""
        return _ratio(self._sum("fabric"), self._sum("contacts"))

    @property
    def coordination(self):
        """Mean number of contacts of the grains in each cell, by their areas, (n_x, n_y) [-]; NaN where there is none."""
        return _ratio(self._sum("ends"), self._sum("area"))

    def plot(self, ax=None, quantity="solid_fraction"):
        """Draw a field: a curve where the grid has one cell along an axis, else a map with its scale of colours.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default Axes in a Figure of their own.
        quantity : str
            One of solid_fraction, velocity_x, velocity_y, speed, pressure, shear_stress, coordination.

        Returns
        -------
        Axes
        """
        label, values, cmap = QUANTITIES[checks.choice("quantity", quantity, QUANTITIES)]
        values = values(self)
        if ax is None:
            from matplotlib.figure import Figure

            ax = Figure(figsize=(3.4, 2.6), layout="constrained").add_subplot()
        x, y = self.centers
        if self.cells[0] == 1:
            ax.plot(values[0], y, "o-")
            ax.set(xlabel=label, ylabel="$y$ [m]")
        elif self.cells[1] == 1:
            ax.plot(x, values[:, 0], "o-")
            ax.set(xlabel="$x$ [m]", ylabel=label)
        else:
            bound = np.nanmax(np.abs(values)) if cmap == "coolwarm" else None
            mesh = ax.pcolormesh(*self.edges, values.T, cmap=cmap, vmin=None if bound is None else -bound, vmax=bound)
            ax.set(xlabel="$x$ [m]", ylabel="$y$ [m]", aspect="equal")
            ax.grid(False)  # YADE turns grids on
            ax.figure.colorbar(mesh, ax=ax, label=label)
        return ax

    def _sum(self, name):
        """Mean over the moments of a sum over each cell."""
        if self._sums is None:
            raise AttributeError("nothing is computed yet; call compute() first")
        return self._sums[name] / self._moments

    def _add_grains(self, frame):
        grains, area = frame.grains, frame.areas()
        free = ~grains["fixed"]
        arms, weight = _samples({name: grains[name][free] for name in OUTLINE})  # (N, K, 2) and shares (N, K)
        place, drift = _inside(frame, grains["position"][free][:, None] + arms)
        speed, spin = grains["velocity"][free][:, None, :2], grains["velocity"][free][:, None, 2:]
        velocity = speed + spin * np.stack([-arms[..., 1], arms[..., 0]], axis=-1) + drift
        mass = weight * grains["mass"][free][:, None]
        area = weight * area[free][:, None]
        self._deposit(place, area=area, mass=mass, momentum=mass[..., None] * velocity, ends=area * frame.per_grain(frame.normal_force() > 0)[free][:, None])

    def _add_contacts(self, frame):
        contacts = frame.contacts
        bearing = frame.normal_force() > 0
        rows = np.append(frame.grains["fixed"], True)
        inner = bearing & ~rows[frame.rows(contacts["body1"])] & ~rows[frame.rows(contacts["body2"])]
        along = (np.arange(ACROSS) + 0.5) / ACROSS
        for body, arm, sign in (("body1", "arm1", 1), ("body2", "arm2", -1)):
            pick = bearing & ~rows[frame.rows(contacts[body])]
            place, _ = _inside(frame, contacts["position"][pick][:, None] - along[:, None] * contacts[arm][pick][:, None])
            moments = sign * np.einsum("ca,cb->cab", contacts["force"][pick], contacts[arm][pick]) / ACROSS
            self._deposit(place, moments=np.broadcast_to(moments[:, None], (*place.shape[:2], 2, 2)))
        n = contacts["normal"][inner]
        place, _ = _inside(frame, contacts["position"][inner])
        self._deposit(place, contacts=np.ones(len(n)), fabric=np.einsum("ca,cb->cab", n, n))

    def _deposit(self, place, **values):
        """Add values (…, shape) at places (…, 2) to the sums of the cells that hold them."""
        low, high = self.limits
        cell = np.floor((place.reshape(-1, 2) - low) / (high - low) * self.cells).astype(np.int64)
        there = ((cell >= 0) & (cell < self.cells)).all(axis=1)
        row = cell[there, 0] * self.cells[1] + cell[there, 1]
        count = self.cells[0] * self.cells[1]
        for name, value in values.items():
            shape = value.shape[place.ndim - 1 :]
            columns = value.reshape(len(there), math.prod(shape))[there].T
            total = np.stack([np.bincount(row, column, count) for column in columns], axis=-1).reshape(*self.cells, *shape)
            self._sums[name] = self._sums.get(name, 0) + total


def _ratio(sums, counts):
    counts = counts.reshape(*counts.shape, *[1] * (sums.ndim - counts.ndim))
    return np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts > 0)


def _limits(frame):
    """Corners of the box around the free grains, or of the periodic cell as a rectangle."""
    if frame.cell is not None:
        return np.array([[0.0, 0.0], [frame.cell[0, 0], frame.cell[1, 1]]])
    grains = {name: frame.grains[name][~frame.grains["fixed"]] for name in OUTLINE}
    if not len(grains["angle"]):
        raise ValueError("the scene holds no free Rcr and no free Sphere: there is nothing to compute")
    reach = np.column_stack([half_extents(grains, axis) for axis in (0, 1)])
    return np.stack([(grains["position"] - reach).min(axis=0), (grains["position"] + reach).max(axis=0)])


def _samples(grains):
    """Points spread evenly over each grain, from its centre (N, K, 2) [m], and the share of the grain that each stands for (N, K)."""
    r, a = (grains[name][:, None] for name in ("cap_radius", "half_length"))
    even = (2 * np.arange(ACROSS) + 1) / ACROSS - 1
    u, v = (c.ravel() for c in np.meshgrid(even, even))
    x, y = u * (a + r), v * r
    inside = np.maximum(np.abs(x) - a, 0) ** 2 + y**2 <= r**2
    turned = (x + 1j * y) * np.exp(1j * grains["angle"])[:, None]
    return np.stack([turned.real, turned.imag], axis=-1), inside / inside.sum(axis=1, keepdims=True)


def _inside(frame, points):
    """Points brought into the rectangle that stands for the periodic cell, and by how much faster their images move (zeros without one)."""
    if frame.cell is None:
        return points, np.zeros_like(points)
    (width, lean), (foot, height) = frame.cell
    if foot != 0:
        raise ValueError(f"the first edge of the periodic cell is ({width:g}, {foot:g}); wanted one along x, as the grid's")
    up = -np.floor(points[..., 1] / height)
    along = -np.floor((points[..., 0] + up * lean) / width)
    turns = np.stack([along, up], axis=-1)
    drift = np.zeros_like(points) if frame.cell_velocity is None else turns @ frame.cell_velocity.T
    return points + turns @ frame.cell.T, drift
