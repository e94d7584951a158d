"""Contact networks: their files, and their observables. Needs NumPy, and h5py for files; not YADE.

Conventions
-----------
* Those of `rcr.table`. The tangent t is the normal n turned by +90°.
* One row is one pair of grains with one or two contact points. Obstacles are always body 2 and
  have negative ids; their branch vectors end at the contact point. The walls of a box are −1 left,
  −2 bottom, −3 right, −4 top. Another obstacle has −5 minus its id in YADE.
* The stress of a grain sums over contact points: two points of a contact add to the moment f⊗r of
  their resultant. Between two grains, this moment and its reaction add up to 0.
* Stress and coordination count all contacts. All other observables count those between grains.
* The ξ-network S(ξ) holds the contacts with f_n ≤ ξ ⟨f_n⟩. Its tensors are divided by the number
  of contacts of the whole network, so that tr F(ξ) = N(ξ)/N.
* The stress axes give the sign of an anisotropy: a = 2 (X₁₁ − X₂₂)/tr X(∞), with axis 1 along σ₁.
"""

import math
import numbers

import numpy as np

from rcr import outlines
from rcr._data import checks, files, network_attributes, network_columns
from rcr._data.network_columns import (  # noqa: F401: part of this module's interface
    BOTTOM, CAP_CAP, CAP_SIDE, LEFT, OBSTACLE, OTHER, RIGHT, SIDE_SIDE, TOP,
)  # fmt: skip
from rcr._data.plain import plain
from rcr.force_statistics import ForceStatistics
from rcr.table import Table
from rcr.xi_networks import cutoffs


def sin_phi(stresses):
    """Return q/p = (σ₁ − σ₂)/(σ₁ + σ₂) of principal stresses (…, 2), σ₂ first [-; eq. qp]."""
    low, high = np.moveaxis(np.asarray(stresses), -1, 0)
    return plain((high - low) / (high + low))


class Network(Table, ForceStatistics):
    """Force-bearing contacts at one time, and the free grains.

    It is a `Table`. `ForceStatistics` has the distributions and correlations of its forces.

    Parameters
    ----------
    particles : dict of arrays
        Columns of `Table.grains` without ``fixed`` and ``color``. Optional are ``clump`` and
        ``shape``, by default −1, and ``center``, by default the position.
    contacts : dict of arrays
        Columns of `Table.contacts`. Optional are ``friction``, by default the attribute, and
        ``point_moments``, ``adhesion`` and ``rolling_moment``, by default 0.
    attributes : dict
        All are optional: ``volume`` area of the region [m²], ``friction`` between grains [-],
        ``cell`` (2, 2) edges of a periodic cell as columns [m], ``cell_velocity`` (2, 2) their
        velocities [m/s], ``time`` [s], ``strain`` [-], ``dt`` [s], ``eta`` [-], ``seed``,
        ``version``. Other attributes are numbers, texts, lists of texts or arrays of numbers.
    shapes : sequence
        `Table.shapes`, or (corners, radius) of each polygon over its R.

    Raises
    ------
    ValueError
        If a column is missing, has the wrong shape, is not finite or cannot be that of a scene; if
        a file cannot hold an attribute.
    """

    def __init__(self, particles, contacts, attributes, shapes=()):
        self.attributes = network_attributes.checked(attributes)
        if "position" in particles:
            none, center = np.full(len(particles["position"]), -1), particles["position"]
            particles = dict(clump=none, shape=none, center=center) | particles
        if "body1" in contacts:
            friction = self.attributes.get("friction", math.nan)
            shape = np.shape(contacts["body1"])
            optional = dict(friction=np.full(shape, friction),
                            point_moments=np.zeros((*shape, 2, 2)),
                            adhesion=np.zeros(shape), rolling_moment=np.zeros(shape))
            contacts = optional | contacts
        self.particles = network_columns.checked("particles", particles)
        self.contacts = network_columns.checked("contacts", contacts)
        self.shapes = outlines.checked(shapes)
        network_columns.check_meaning(self.particles, self.contacts, self.shapes)

    @property
    def grains(self):
        """Columns of the grains, none of which is fixed; see `Table`."""
        count = len(self.particles["id"])
        return self.particles | dict(fixed=np.zeros(count, bool), color=np.full((count, 3), 0.7))

    @property
    def time(self):
        return float(self.attributes.get("time", math.nan))

    @property
    def cell(self):
        return self.attributes.get("cell")

    @property
    def cell_velocity(self):
        return self.attributes.get("cell_velocity")

    def __repr__(self):
        names = ("time", "strain", "eta", "friction", "volume")
        known = {name: self.attributes.get(name) for name in names}
        shown = [f"{k} {v:g}" for k, v in known.items() if isinstance(v, numbers.Real)]
        between = f"{self.between_particles.sum()} of them between grains"
        counts = f"{len(self.particles['id'])} grains, {len(self.contacts['body1'])} contacts"
        return f"<Network: {', '.join([counts, between, *shown])}>"

    @classmethod
    def load(cls, path):
        """Return the network of a file, or a ValueError for damage, an OSError for no access."""
        with files.reading(path, "an HDF5 file"):
            with files.open_hdf5(path) as file:
                groups = ("particles", "contacts")
                if not set(groups) <= set(file):
                    raise ValueError(f"it holds {sorted(file)}; expected the groups {groups}")
                columns = [network_columns.read(file, group, path) for group in groups]
                shapes = network_columns.read(file, "shapes", path) if "shapes" in file else {}
                attributes = {name: value.item() if isinstance(value, np.generic) else value
                              for name, value in file.attrs.items() if name != "stress"}
            return cls(*columns, attributes, outlines.of_columns(shapes) if shapes else ())

    def save(self, path):
        """Save the network to an HDF5 file with a check sum; the write is atomic."""
        from rcr import __version__

        def fill(file):
            groups = dict(particles=dict(self.particles), contacts=dict(self.contacts))
            for name in ("adhesion", "rolling_moment"):
                if not self.contacts[name].any():
                    del groups["contacts"][name]
            if (self.particles["shape"] >= 0).any():
                groups["shapes"] = outlines.columns(self.shapes)
            else:
                del groups["particles"]["shape"]
            for group, columns in groups.items():
                for column, data in columns.items():
                    file.create_dataset(f"{group}/{column}", data=data)
            stress = {"stress": self.stress()} if "volume" in self.attributes else {}
            file.attrs.update({"version": __version__, **self.attributes, **stress})

        files.write(path, files.hdf5(fill))

    @property
    def between_particles(self):
        """Mask of the contacts between grains, (C,) bool."""
        return self.contacts["body2"] >= 0

    def stress(self):
        """Return the stress σ = (1/V) Σ f⊗ℓ over all contacts [eq. sigma].

        It is (2, 2), compression positive [Pa]. At obstacles the sum is over contact points. A
        ValueError reports a network without a volume.
        """
        if "volume" not in self.attributes:
            todo = "give the area of the region [m²]: rcr.contact_network(volume=…)"
            raise ValueError(f"the network has no volume, which the stress needs; {todo}")
        return self._moments() / self.attributes["volume"]

    def _moments(self):
        """Return Σ f⊗ℓ over all contacts, at obstacles over their points, (2, 2) [N]."""
        at_obstacles = self.contacts["point_moments"][~self.between_particles].sum(axis=0)
        pairs = np.einsum("ca,cb->ab", self.contacts["force"], self.contacts["branch"])
        return pairs + at_obstacles

    def stress_axes(self):
        """Return the principal axes of the stress as columns, that of σ₁ first, (2, 2) [-]."""
        return np.linalg.eigh(self._symmetric_moments())[1][:, ::-1]

    def stress_angle(self):
        """Return θσ, the angle from x to the axis of σ₁, in [0, π) [rad]."""
        x, y = self.stress_axes()[:, 0]
        return plain(np.arctan2(y, x) % np.pi)

    def principal_stresses(self):
        """Return σ₂ and σ₁, (2,) [Pa]."""
        stress = self.stress()
        return np.linalg.eigvalsh(0.5 * (stress + stress.T))

    def sin_phi(self):
        """Return q/p of the stress of all contacts, those with obstacles included [-]."""
        return sin_phi(np.linalg.eigvalsh(self._symmetric_moments()))

    def _symmetric_moments(self):
        """Return the symmetric part of Σ f⊗ℓ [N]; a ValueError reports that it has no axes."""
        if not len(self.contacts["body1"]):
            raise ValueError("the network has no contact; its stress has no principal axes")
        moments = self._moments()
        return 0.5 * (moments + moments.T)

    def local_components(self):
        """Return n, t, and (n, t) components of branch and force between grains, (C, 2) each."""
        pick = self.between_particles
        if not pick.any():
            raise ValueError("the network has no contact between grains")
        n = self.contacts["normal"][pick]
        t = np.column_stack([-n[:, 1], n[:, 0]])
        branch, force = self.contacts["branch"][pick], self.contacts["force"][pick]
        frame = np.stack([n, t], axis=1)
        branch, force = (np.einsum("cka,ca->ck", frame, vector) for vector in (branch, force))
        if not force[:, 0].mean() > 0:
            given = f"the mean normal force between grains is {force[:, 0].mean():g}"
            raise ValueError(f"{given}; expected > 0, compression")
        return n, t, branch, force

    def fabric(self, xi=np.inf):
        """Return the fabric tensor F(ξ) = (1/N) Σ_{S(ξ)} n⊗n, N of the whole network [eq. F_xi].

        It is (2, 2) and symmetric, tr F(∞) = 1 [-]; ξ is one cutoff.
        """
        if np.ndim(xi):
            raise checks.error("xi", xi, "one cutoff")
        n, _, _, force = self.local_components()
        pick = force[:, 0] <= cutoffs(xi) * force[:, 0].mean()
        return np.einsum("ca,cb->ab", n[pick], n[pick]) / len(n)

    def anisotropies(self, xi=np.inf):
        """Return the `Anisotropies` (a_c, a_ln, a_lt, a_fn, a_ft) of the ξ-network [-].

        They have the shape of the cutoffs ξ = f_n/⟨f_n⟩ [-] and are positive along σ₁. With t = n
        turned by +90°, an average ⟨f_t⟩ = a sin 2(θ − θσ) has a_ft = −a, and likewise a_lt.
        Source: the paper's equations harmonique and Aniso_values_xi.
        """
        return self.xi_networks().anisotropies(xi)

    def shear_stress_ratio(self, xi=np.inf):
        """Return q(ξ)/p of the contacts between grains [-].

        Contacts with obstacles do not enter, unlike in `sin_phi` and `stress`: at ξ = ∞ it differs
        from `sin_phi` by their share. q(ξ) is the deviator of the partial stress along the axes of
        σ, p that of the whole network.
        """
        return self.xi_networks().shear_stress_ratio(xi)

    def friction_mobilization(self):
        """Return I_m of each contact between grains (`mobilization`), (C,) [-].

        A ValueError reports that no contact between grains has µ > 0, or that one has unknown µ.
        """
        self.local_components()  # raises without contacts between grains
        friction = self.contacts["friction"][self.between_particles]
        if np.isnan(friction).any():
            given = f"{np.isnan(friction).sum()} of {len(friction)} contacts between grains"
            raise ValueError(f"contacts/friction is NaN for {given}; the mobilisation needs a "
                             "coefficient of each: give this column or the attribute friction")
        if not (friction > 0).any():
            given = f"friction = {friction.max():g} between all grains"
            raise ValueError(f"{given}; the mobilisation needs a coefficient > 0")
        return self.mobilization()[self.between_particles]

    def grain_coordination(self):
        """Return the number of contacts of each grain, (N,) int.

        Obstacles are included. Members of a clump have the number of the clump.
        """
        return self.per_grain(np.ones(len(self.contacts["body1"]))).astype(int)

    def coordination(self, count_side_contacts_twice=False):
        """Return the mean number of contacts per grain or clump without rattlers [-].

        Rattlers have fewer than two contacts. They are removed with their contacts until none is
        left. Obstacles are included. `count_side_contacts_twice` counts a contact of two points as
        two, because it has two unknown forces.
        """
        alive, _, total = self.backbone(count_side_contacts_twice)
        return float(total[alive].mean()) if alive.any() else 0.0

    def backbone(self, count_side_contacts_twice=False):
        """Return the network without rattlers; see `coordination`.

        The results are masks of the remaining grains or clumps by id, (largest id + 1,), and of the
        remaining contacts, (C,), and the number of contacts by id.
        """
        double = count_side_contacts_twice & (self.contacts["points"] == 2)
        weight = np.where(double, 2, 1)
        body, (one, two) = self._bodies()
        size, inner = len(body), self.between_particles
        alive = np.zeros(size, dtype=bool)
        alive[body[self.particles["id"]]] = True
        while True:
            kept = alive[one] & (alive[np.maximum(two, 0)] | ~inner)
            ends = np.concatenate([one[kept], two[kept & inner]])
            rattlers = alive & (np.bincount(ends, minlength=size) < 2)
            if not rattlers.any():
                weights = np.concatenate([weight[kept], weight[kept & inner]])
                return alive, kept, np.bincount(ends, weights, size)
            alive &= ~rattlers

    def _bodies(self):
        """Return the id of the clump or grain by id, and those of the bodies of contacts (2, C).

        The second body of a contact with an obstacle has the negative id of the obstacle.
        """
        ids, clump = self.particles["id"], self.particles["clump"]
        body = np.arange(int(max(ids.max(initial=-1), clump.max(initial=-1))) + 1)
        body[ids] = np.where(clump >= 0, clump, ids)
        two = self.contacts["body2"]
        two = np.where(two < 0, two, body[np.maximum(two, 0)])
        return body, np.array([body[self.contacts["body1"]], two])

    def neighbors(self):
        """Return pairs of bodies in contact without rattlers, and their contact points.

        The results are ids of grains, or of clumps, (P, 2) int, those of obstacles negative, and
        the number of points of each pair, (P,). Several members of two clumps can be in contact.
        """
        kept = self.backbone()[1]
        pairs = np.sort(self._bodies()[1][:, kept].T, axis=1)
        pairs, at = np.unique(pairs, axis=0, return_inverse=True)
        points = np.bincount(at.ravel(), self.contacts["points"][kept], len(pairs))
        return pairs, points.astype(int)
