"""Columns of grains and contacts, and what follows from them. Needs NumPy.

`rcr.frame.Frame` is the table of a scene, `rcr.Network` that of its force-bearing contacts.
Everything is in the plane z = 0 and per unit depth.

Conventions
-----------
* A grain is a body of the shape `Rcr`, `RoundedPolygon` or `Sphere` (a disc in the plane). Members
  of a clump are grains with the id of the clump. An obstacle is a `Wall`, `Box` or `Facet`; a grain
  with prescribed motion is `fixed`.
* R is the circumscribed radius and R′ the inscribed radius about the centre, that of a cap. Every
  grain has the elongation η = (R − R′)/R.
* A contact force acts on body 2 from body 1. The normal points from 1 to 2. Compression is
  positive. An obstacle is body 2, and so is a fixed grain in contact with a free one.
* A clump moves as one body. Lever arms and branch vectors of its members start at its centre of
  mass. Sums and stresses of its members are those of the clump.
* A step moves the bodies after its forces, so positions of contacts, lever arms and centres of mass
  belong to an earlier time than those of a scene's grains; they differ by dt times a velocity.
"""

import math

import numpy as np

from rcr import geometry
from rcr._data.network_columns import rows

KINDS = ("rcr", "disc", "clumped", "fixed", "polygon")
# Largest size of a picture that shows an obstacle whole
MOST_GRAINS = 4  # over the size of the grains, as they lie at the foot of a drum [-]
MOST_DIAMETERS = 50  # over the mean diameter of the grains, for few of them in a drum [-]
NO_WALLS = dict(id=np.empty(0, int), axis=np.empty(0, int), position=np.empty(0))


class Table:
    """Grains and contacts at one time, obstacles and a periodic cell.

    Attributes
    ----------
    grains : dict of arrays
        ``id`` (N,), ``clump`` (N,) id of the clump or −1, ``fixed`` (N,) bool, ``position`` (N, 2)
        [m], ``center`` (N, 2) centre of mass of the grain or its clump at the time of the forces
        [m], ``angle`` (N,) from x to the long axis, or of the corners of a polygon [rad], ``R``
        (N,), ``cap_radius`` (N,) R′, ``half_length`` (N,) R − R′ [m], ``shape`` (N,) row in
        `shapes`, −1 without a polygon, ``mass`` (N,) [kg/m], ``velocity`` (N, 3)
        [m/s, m/s, 1/s], ``color`` (N, 3) in YADE's view.
    contacts : dict of arrays
        ``body1``, ``body2``, ``type`` (C,) 0 cap-cap, 1 cap-side, 2 side-side, 3 with an obstacle
        or fixed grain; a corner of a polygon is a cap. ``points`` (C,) 1 or 2, ``position`` (C, 2)
        of the resultant [m], ``normal`` (C, 2), ``force`` (C, 2) [N/m], ``branch`` (C, 2) from the
        centre of body 1 to that of body 2, at an obstacle to the position [m], ``friction`` (C,) µ
        or NaN if unknown, ``point_moments`` (C, 2, 2) Σ f ⊗ (x − position) over the contact points
        x [N], ``adhesion`` (C,) pull of all points [N/m], ``rolling_moment`` (C,) on body 2 [N].
    shapes : list of `rcr.outlines.Outline`
        Outlines of polygons, over their R.
    walls : dict of arrays
        ``id``, ``axis`` 0 or 1 of the normal, ``position`` along it [m].
    outlines : list of (id, kind, (k, 2) array)
        Corners of boxes ("box") and ends of facets ("facet") [m].
    cell : (2, 2) array or None
        Edges of the periodic cell as columns [m].
    time : float
        Time [s], NaN if unknown.
    cell_velocity : (2, 2) array or None
        Velocities of the edges [m/s]: differences of velocity between a grain and its images.
    change : str
        What a script has changed since the last step, so that centres are wrong; empty: nothing.
    run : str
        Id of YADE's scene, ``O.tags['id']``, which ``O.save`` keeps; empty if unknown.
    """

    shapes, walls, outlines, change, run = (), NO_WALLS, (), "", ""
    cell = cell_velocity = None
    time = math.nan

    def rows(self, ids):
        """Return the rows of the grains with these ids, −1 for other ids."""
        return rows(self.grains["id"], ids)

    def free_ends(self):
        """Return masks of the contacts whose body 1 and whose body 2 is a free grain, (2, C)."""
        free = np.append(~self.grains["fixed"], False)  # the last row is for obstacles
        return np.array([free[self.rows(self.contacts[body])] for body in ("body1", "body2")])

    def free_grains(self):
        """Return the columns of the grains without prescribed motion."""
        free = ~self.grains["fixed"]
        return {name: column[free] for name, column in self.grains.items()}

    def mean_radius(self):
        """Return ⟨R⟩ of the free grains, or of all grains if none is free [m]."""
        return self._mean(self.grains["R"])

    def mean_cap_radius(self):
        """Return ⟨R′⟩ of the free grains, or of all grains if none is free [m]."""
        return self._mean(self.grains["cap_radius"])

    def _mean(self, values):
        free = ~self.grains["fixed"]
        if not len(free):
            return math.nan
        return float(values[free if free.any() else slice(None)].mean())

    def areas(self):
        """Return the area of each grain, (N,) [m²].

        Members of a clump share the area of their union in proportion to their own areas.
        """
        own, clump = geometry.areas(self.grains, self.shapes), self.grains["clump"]
        for number in np.unique(clump[clump >= 0]):
            members = clump == number
            clumped = {name: column[members] for name, column in self.grains.items()}
            union, _, _ = geometry.union(clumped, self.shapes)
            own[members] *= union / own[members].sum()
        return own

    def kinds(self):
        """Return the index of each grain in `KINDS`, (N,)."""
        disc = (self.grains["half_length"] == 0).astype(int)
        single = np.where(self.grains["shape"] >= 0, 4, disc)
        free = np.where(self.grains["clump"] >= 0, 2, single)
        return np.where(self.grains["fixed"], 3, free)

    def normal_force(self):
        """Return f_n of each contact, (C,) [N/m]."""
        return np.einsum("ca,ca->c", self.contacts["force"], self.contacts["normal"])

    def mobilization(self):
        """Return |f_t|/(µ (f_n + f_a)) of each contact with the pull f_a of adhesion, (C,) [-].

        It is NaN if µ is unknown, else 0 without force or friction.
        """
        normal, n, force = self.normal_force(), self.contacts["normal"], self.contacts["force"]
        tangential = np.abs(force[:, 1] * n[:, 0] - force[:, 0] * n[:, 1])
        limit = self.contacts["friction"] * (normal + self.contacts["adhesion"])
        other = np.where(np.isnan(limit), np.nan, 0.0)
        return np.divide(tangential, limit, out=other, where=limit > 0)

    def per_grain(self, values):
        """Return the sum of contact values (C,) over the contacts of each grain, (N,)."""
        return self._sums(values, values)

    def check_unchanged(self):
        """Raise ValueError if a script has changed O.dt, a velocity or a place since the last step.

        They give the positions at which the forces acted.
        """
        if self.change:
            raise ValueError(
                f"{self.change} in the last step, which gives the positions of its forces; take "
                "networks, profiles and stresses before you change it, or after a further step; in "
                "an engine, after NewtonIntegrator")

    def arms(self):
        """Return the lever arms of body 1 and body 2, from the centre to the position, (2, C, 2).

        They are 0 for obstacles [m].
        """
        first, second = (self.rows(self.contacts[body]) for body in ("body1", "body2"))
        one = self.contacts["position"] - self.grains["center"][first]
        return np.array([one, np.where(second[:, None] >= 0, one - self.contacts["branch"], 0.0)])

    def moments(self):
        """Return Σ f ⊗ r of each contact for body 1 and for body 2, (C, 2, 2) each [N].

        The sum is over the points of the contact, with the force f that the body exerts and the
        arm r from its centre of mass. The moment for an obstacle has no meaning.
        """
        one, two = (np.einsum("ca,cb->cab", self.contacts["force"], arm)
                    + self.contacts["point_moments"] for arm in self.arms())
        return one, -two

    def grain_stresses(self):
        """Return the mean stress in each grain, (N, 2, 2), compression positive [Pa].

        σ = (1/A) Σ f ⊗ r over its contact points [Love, Weber], with the force f that the grain
        exerts and the arm r from its centre. Weight and inertia do not enter. Multiplied by `areas`
        and divided by the volume, the sum over all grains is `Network.stress`.
        """
        self.check_unchanged()
        areas = self._clump_sums(self.areas())
        return self._sums(*self.moments()) / areas[:, None, None]

    def _sums(self, of_body1, of_body2):
        """Return the sums of values (C, …) of contacts over the contacts of each grain, (N, …)."""
        sums = np.zeros((len(self.grains["id"]), *of_body1.shape[1:]))
        for body, values in (("body1", of_body1), ("body2", of_body2)):
            at = self.rows(self.contacts[body])
            np.add.at(sums, at[at >= 0], values[at >= 0])
        return self._clump_sums(sums)

    def _clump_sums(self, values):
        """Replace the values (N, …) of a clump's members by their sum; return all values."""
        member = self.grains["clump"] >= 0
        clumps, group = np.unique(self.grains["clump"][member], return_inverse=True)
        sums = np.zeros((len(clumps), *values.shape[1:]))
        np.add.at(sums, group, values[member])
        values[member] = sums[group]
        return values

    def wrap(self, points):
        """Return the shifts that move points into the periodic cell, (n, 2) [m]; 0 without one."""
        return self._wrapping(points)[0]

    def velocities(self):
        """Return the velocity of each grain's image in the periodic cell, (N, 3)."""
        velocity = self.grains["velocity"].copy()
        velocity[:, :2] += self._wrapping(self.grains["position"])[1]
        return velocity

    def _wrapping(self, points):
        """Return shifts into the periodic cell [m] and their velocities [m/s], (n, 2) each."""
        points = np.asarray(points, float)
        if self.cell is None:
            return np.zeros_like(points), np.zeros_like(points)
        return self.shifts(-np.floor(points @ np.linalg.inv(self.cell).T))

    def shifts(self, turns):
        """Return shifts by edges of the periodic cell [m] and their velocities [m/s], (…, 2)."""
        velocity = np.zeros((2, 2)) if self.cell_velocity is None else self.cell_velocity
        return turns @ self.cell.T, turns @ velocity.T

    def segments(self):
        """Return the polyline centre 1, contact, centre 2 of each contact, (C, 3, 2) [m].

        The contact point replaces the centre of an obstacle. It is within the periodic cell.
        """
        (arm1, arm2), place = self.arms(), self.contacts["position"]
        place = place + self.wrap(place)
        return np.stack([place - arm1, place, place - arm2], axis=1)

    def extent(self):
        """Return the lower left and upper right corner of a picture of the frame, (2, 2) [m].

        The picture shows the periodic cell and the grains. Grains are left out that are farther
        than half the size of the box of 98 % of the grains from that box. A box, a facet or a fixed
        grain is shown whole if the picture is then at most `MOST_GRAINS` times as large, or
        `MOST_DIAMETERS` mean diameters. Longer boxes and facets extend it by at most half its size,
        walls only if they are at most this far away.
        """
        grains, near = self._grain_boxes()
        corners = [*grains[:, near]]
        if self.cell is not None:
            corners.append((self.cell @ np.array([[0, 1, 0, 1], [0, 0, 1, 1]])).T)
        obstacles = [(shape.min(axis=0), shape.max(axis=0)) for _, _, shape in self.outlines]
        obstacles = np.array(obstacles).reshape(-1, 2, 2).swapaxes(0, 1)
        choices = map(np.concatenate, (corners, obstacles, np.zeros((1, 1, 2))))
        corners = next(points for points in choices if len(points))
        low, high = corners.min(axis=0), corners.max(axis=0)
        size, middle = (high - low).max(), 0.5 * (low + high)
        most = np.fmax(MOST_GRAINS * size, 2 * MOST_DIAMETERS * self.mean_radius())

        def fits(box):
            return (np.maximum(high, box[1]) - np.minimum(low, box[0]) <= most).all(axis=-1)

        def clipped(points):
            return np.clip(points, low - size / 2, high + size / 2)

        fixed = self.grains["fixed"] & fits(grains)
        obstacles = np.where(fits(obstacles)[:, None], obstacles, clipped(obstacles))
        walls = [np.where([axis == 0, axis == 1], at, middle)
                 for axis, at in zip(self.walls["axis"], self.walls["position"])]
        walls = np.array(walls).reshape(-1, 2)
        walls = walls[(walls == clipped(walls)).all(axis=1)]
        shown = np.concatenate([corners, *grains[:, fixed], *obstacles, walls])
        return np.stack([shown.min(axis=0), shown.max(axis=0)])

    def _grain_boxes(self):
        """Return corners of the grains' boxes, (2, N, 2), and a mask of those near the others."""
        if not len(self.grains["id"]):
            return np.empty((2, 0, 2)), np.empty(0, bool)
        place = self.grains["position"] + self.wrap(self.grains["position"])
        low, high = np.quantile(place, (0.01, 0.99), axis=0)
        size = 0.5 * (high - low) + 0.5 * (high - low).max() + 2 * self.mean_radius()
        near = (np.abs(place - 0.5 * (low + high)) <= size).all(axis=1)
        return geometry.boxes(self.grains | dict(position=place), self.shapes), near
