"""Fields of the free grains on a grid: solid fraction, velocity, stress, fabric, coordination.

    profile = rcr.Profile(cells=(1, 20)).compute(network)    # 20 layers of a network
    profile.velocity[0, :, 0]                                # v_x(y)
    profile.plot(quantity="pressure")

A grain is spread over its outline, and the moment f⊗ℓ of a contact along its branch vector.
Stress × cell area, summed over the grid, is volume × `Network.stress` for any number of cells.

Needs NumPy; `Profile.plot` needs Matplotlib.
"""

import math

import numpy as np

from rcr import geometry
from rcr._data import checks
from rcr._data.plain import plain
from rcr.frame import Frame

MOST_CELLS = 10**7
SAMPLES = 8  # sample points along and across a grain, and along each half of a branch vector

QUANTITIES = dict(
    solid_fraction=("solid fraction", lambda p: p.solid_fraction, "Blues"),
    velocity_x=("$v_x$ [m/s]", lambda p: p.velocity[..., 0], "coolwarm"),
    velocity_y=("$v_y$ [m/s]", lambda p: p.velocity[..., 1], "coolwarm"),
    speed=("size of the mean velocity [m/s]",
           lambda p: np.hypot(p.velocity[..., 0], p.velocity[..., 1]), "viridis"),
    pressure=("pressure [Pa]", lambda p: p.pressure, "magma_r"),
    shear_stress=(r"$\sigma_{xy}$ [Pa]", lambda p: p.stress[..., 0, 1], "coolwarm"),
    coordination=("contacts per grain", lambda p: p.coordination, "YlGnBu"))


class Profile:
    """Fields on a grid of rectangular cells.

    Parameters
    ----------
    cells : (int, int)
        Number of cells along x and along y. One cell along an axis makes a profile along the other.
    limits : ((float, float), (float, float)), optional
        Lower left and upper right corner [m]; by default the box around the grains of the first
        frame, or the periodic cell. Grains and contacts outside are ignored. In a periodic cell
        the limits span at most the cell, and images count that lie within them.
    """

    def __init__(self, cells=(1, 20), limits=None):
        if np.shape(cells) != (2,):
            raise checks.error("cells", cells, "two numbers, along x and along y")
        self.cells = tuple(checks.integer(f"cells[{k}]", n, "at least 1", lambda v: v >= 1)
                           for k, n in enumerate(cells))
        if math.prod(self.cells) > MOST_CELLS:
            raise checks.error("cells", cells, f"at most {MOST_CELLS} cells")
        self._given = None if limits is None else checks.rectangle("limits", limits)
        self.limits = self._given
        self._sums, self._moments = None, 0

    def __repr__(self):
        grid = f"{self.cells[0]} × {self.cells[1]} cells"
        if self._sums is None:
            return f"<Profile: {grid}, nothing computed yet>"
        (left, bottom), (right, top) = self.limits
        mean = f"mean of {self._moments} moments" if self._moments > 1 else "1 moment"
        return f"<Profile: {grid} from ({left:g}, {bottom:g}) to ({right:g}, {top:g}) m, {mean}>"

    def compute(self, what=None, reset=True):
        """Compute the fields at one time; return the Profile itself.

        `what` is that of `rcr.frame.Frame.of`, None the present scene of YADE. `reset` starts
        again; else the fields are averages over all frames since the last reset. A ValueError says
        that there is no grain, that the first edge of the periodic cell is not along x, or that the
        limits span more than the cell; or see `Frame.check_unchanged`.
        """
        frame = Frame.of(what)
        frame.check_unchanged()
        if frame.cell is not None and frame.cell[1, 0] != 0:
            raise ValueError("the first edge of the periodic cell is ({:g}, {:g}); expected one "
                             "along x, as the grid's".format(*frame.cell[:, 0]))
        first = reset or self._sums is None
        limits = _limits(frame) if first and self._given is None else self.limits
        _check_span(limits, frame)
        if first:
            self.limits, self._sums, self._moments = limits, {}, 0
        self._moments += 1
        self._add_grains(frame)
        self._add_contacts(frame)
        return self

    @property
    def edges(self):
        """Edges of the cells along x (n_x + 1,) and along y (n_y + 1,) [m]."""
        self._sum("area")
        axes = zip(*self.limits, self.cells)
        return tuple(np.linspace(low, high, n + 1) for low, high, n in axes)

    @property
    def centers(self):
        """Centres of the cells along x (n_x,) and along y (n_y,) [m]."""
        return tuple(0.5 * (edges[1:] + edges[:-1]) for edges in self.edges)

    @property
    def cell_area(self):
        """Area of one cell [m²]."""
        x, y = self.edges
        return plain((x[1] - x[0]) * (y[1] - y[0]))

    @property
    def solid_fraction(self):
        """Area of grains over the area of the cell, (n_x, n_y) [-]."""
        return self._sum("area") / self.cell_area

    @property
    def velocity(self):
        """Mean velocity of the mass in each cell, (n_x, n_y, 2) [m/s]; NaN without mass."""
        return _ratio(self._sum("momentum"), self._sum("mass"))

    @property
    def stress(self):
        """Stress of the contacts [Love, Weber], (n_x, n_y, 2, 2), compression positive [Pa]."""
        return self._sum("moments") / self.cell_area

    @property
    def pressure(self):
        """Half the trace of the stress, (n_x, n_y) [Pa]."""
        return 0.5 * np.einsum("xyaa->xy", self.stress)

    @property
    def fabric(self):
        """Mean n⊗n of the contacts between grains, (n_x, n_y, 2, 2), trace 1 [-]; NaN without."""
        return _ratio(self._sum("fabric"), self._sum("contacts"))

    @property
    def coordination(self):
        """Mean number of contacts of a grain, weighted by area, (n_x, n_y) [-]; NaN without."""
        return _ratio(self._sum("ends"), self._sum("area"))

    def plot(self, ax=None, quantity="solid_fraction"):
        """Draw a field: a curve for one cell along an axis, else a map with a colour bar.

        `quantity` is solid_fraction, velocity_x, velocity_y, speed, pressure, shear_stress or
        coordination. The function returns the Axes, by default those of a new Figure.
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
            top = np.nanmax(np.abs(values)) if cmap == "coolwarm" else None
            mesh = ax.pcolormesh(*self.edges, values.T, cmap=cmap, vmin=top and -top, vmax=top)
            ax.set(xlabel="$x$ [m]", ylabel="$y$ [m]", aspect="equal")
            ax.grid(False)  # YADE turns grids on
            ax.figure.colorbar(mesh, ax=ax, label=label)
        return ax

    def _sum(self, name):
        """Return the mean over the frames of a sum over each cell."""
        if self._sums is None:
            raise AttributeError("nothing is computed yet; call compute() first")
        return self._sums[name] / self._moments

    def _add_grains(self, frame):
        free, grains = ~frame.grains["fixed"], frame.free_grains()
        arms, weight = geometry.samples(grains, SAMPLES, frame.shapes)  # (N, K, 2) and (N, K)
        place, drift = self._into_cell(frame, grains["position"][:, None] + arms)
        speed, spin = grains["velocity"][:, None, :2], grains["velocity"][:, None, 2:]
        velocity = speed + spin * np.stack([-arms[..., 1], arms[..., 0]], axis=-1) + drift
        mass = weight * grains["mass"][:, None]
        area = weight * frame.areas()[free][:, None]
        contacts = frame.per_grain(frame.normal_force() > 0)[free][:, None]
        momentum = mass[..., None] * velocity
        self._deposit(place, area=area, mass=mass, momentum=momentum, ends=area * contacts)

    def _add_contacts(self, frame):
        contacts = frame.contacts
        bearing, loaded = frame.normal_force() > 0, (contacts["force"] != 0).any(axis=1)
        free1, free2 = frame.free_ends()
        along = (np.arange(SAMPLES) + 0.5) / SAMPLES
        for free, arm, moments in zip((free1, free2), frame.arms(), frame.moments()):
            pick = loaded & free
            arms = arm[pick]
            points = contacts["position"][pick][:, None] - along[:, None] * arms[:, None]
            place, _ = self._into_cell(frame, points)
            moments = np.broadcast_to(moments[pick, None] / SAMPLES, (*place.shape[:2], 2, 2))
            self._deposit(place, moments=moments)
        inner = bearing & free1 & free2
        n = contacts["normal"][inner]
        place, _ = self._into_cell(frame, contacts["position"][inner])
        self._deposit(place, contacts=np.ones(len(n)), fabric=np.einsum("ca,cb->cab", n, n))

    def _into_cell(self, frame, points):
        """Move points to their images in the rectangle of the periodic cell at the lower limit.

        Return the images and the velocity of the shift.
        """
        if frame.cell is None:
            return points, np.zeros_like(points)
        (width, lean), (_, height) = frame.cell
        (left, bottom), high = self.limits
        up = -np.floor((points[..., 1] - bottom) / height)
        along = -np.floor((points[..., 0] - left + up * lean) / width)
        shift, drift = frame.shifts(np.stack([along, up], axis=-1))
        place = np.maximum(points + shift, self.limits[0])  # rounding errors
        whole = high - self.limits[0] >= np.array([width, height]) * (1 - 1e-9)
        return np.where(whole, np.minimum(place, high), place), drift

    def _deposit(self, place, **values):
        """Add values (…, shape) at places (…, 2) to the sums of their cells."""
        low, high = self.limits
        scaled = (place.reshape(-1, 2) - low) / (high - low)
        cell = np.floor(scaled * self.cells).astype(np.int64) - (scaled == 1)
        inside = ((cell >= 0) & (cell < self.cells)).all(axis=1)
        row = cell[inside, 0] * self.cells[1] + cell[inside, 1]
        count = self.cells[0] * self.cells[1]
        for name, value in values.items():
            shape = value.shape[place.ndim - 1 :]
            columns = value.reshape(len(inside), math.prod(shape))[inside].T
            sums = np.stack([np.bincount(row, column, count) for column in columns], axis=-1)
            self._sums[name] = self._sums.get(name, 0) + sums.reshape(*self.cells, *shape)


def _ratio(sums, counts):
    counts = counts.reshape(*counts.shape, *[1] * (sums.ndim - counts.ndim))
    return np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts > 0)


def _limits(frame):
    """Return the corners of a box around free grains and contacts, or of the periodic cell.

    In a moving scene, contacts are at the time of their forces, before grains moved on.
    """
    if frame.cell is not None:
        return np.array([[0.0, 0.0], [frame.cell[0, 0], frame.cell[1, 1]]])
    grains = frame.free_grains()
    if not len(grains["id"]):
        raise ValueError("the scene holds no free Rcr, Sphere or RoundedPolygon: nothing to compute")
    low, high = geometry.bounds(grains, frame.shapes)
    for free, arm in zip(frame.free_ends(), frame.arms()):
        place = frame.contacts["position"][free]
        places = np.concatenate([place, place - arm[free], [low, high]])
        low, high = places.min(axis=0), places.max(axis=0)
    return np.array([low, high])


def _check_span(limits, frame):
    """Refuse limits that span more than the periodic cell, since parts would stay empty."""
    if frame.cell is None:
        return
    size, span = np.array([frame.cell[0, 0], frame.cell[1, 1]]), limits[1] - limits[0]
    if (span > size * (1 + 1e-9)).any():
        raise ValueError(
            "the limits span {:g} × {:g} m, the periodic cell {:g} × {:g} m; expected limits within "
            "a cell; for a mean over changing cells, those of the smallest".format(*span, *size))
