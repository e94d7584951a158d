"""Contact network of a scene: its file, and what is measured on it. Needs NumPy, and h5py for files; not YADE.

Conventions
-----------
* The force of a contact acts on body 2 from body 1, the branch vector runs from the centre of 1 to the centre of 2, the
  normal n from 1 to 2, the tangent t is n turned by +90°. Compression is positive.
* One row is one pair of particles, whatever the number of its contact points; obstacles are body 2 with a negative id, and the
  branch vector then ends at the contact point. The four walls of a box are −1 left, −2 bottom, −3 right, −4 top, any other obstacle
  −5 minus its id in YADE.
* A clump moves as one: branch vectors run between centres of mass of clumps, and contacts of its members are counted together.
* The stress counts all contacts, obstacles too; every other observable counts those between particles.
* The ξ-network S(ξ) holds the contacts with f_n ≤ ξ ⟨f_n⟩. Its tensors are divided by the number of contacts of the whole
  network, so that they add up: tr F(ξ) = N(ξ)/N.
* An anisotropy is signed by the axes of the total stress: a = 2 (X₁₁ − X₂₂)/tr X(∞), axis 1 being that of σ₁.
"""

import math
import numbers

import numpy as np

from rcr import _checks as checks, _files as files
from rcr.xi_networks import XiNetworks, cutoffs

LEFT, BOTTOM, RIGHT, TOP, OTHER = -1, -2, -3, -4, -5  # the obstacle #k of YADE is OTHER − k
CAP_CAP, CAP_SIDE, SIDE_SIDE, WALL = range(4)

COMPLEX = np.array([1, 1j])  # components (n, t) as n + i t
_PARTICLES = dict(id=(), position=(2,), angle=(), R=(), cap_radius=(), half_length=(), mass=(), velocity=(3,), clump=(), center=(2,))
_WHOLE = {"id", "body1", "body2", "type", "points", "clump"}
_CONTACTS = dict(body1=(), body2=(), type=(), normal=(2,), branch=(2,), force=(2,), position=(2,), points=(), friction=())


def _checked(group, arrays, columns):
    """The columns of a group with their shapes checked, as arrays: whole numbers as they are, others in doubles."""
    missing = sorted(set(columns) - set(arrays))
    if missing:
        raise ValueError(f"group {group!r} lacks {', '.join(missing)}; wanted {', '.join(columns)}")
    arrays = {name: np.asarray(arrays[name]) for name in columns}
    first = arrays[next(iter(columns))]
    if first.ndim != 1:
        raise ValueError(f"{group}/{next(iter(columns))} has shape {first.shape}; wanted (rows,)")
    for name, shape in columns.items():
        checked = checks.reals(f"{group}/{name}", arrays[name], (len(first), *shape))
        if name == "friction":
            checks.every(np.isnan(checked) | (checked >= 0), f"{group}/{name}", checked, "a coefficient ≥ 0, or NaN where it is not known")
        elif not np.isfinite(checked).all():
            raise ValueError(f"{group}/{name} holds a number that is not finite")
        if name in _WHOLE:
            checks.every(checked == np.floor(checked), f"{group}/{name}", checked, "whole numbers")
            checked = arrays[name].astype(np.int64)
        arrays[name] = checked
    return arrays


def _check_meaning(particles, contacts, attributes):
    """ValueError unless the columns are those of a scene: ids that exist, unit normals, grains with a size, forces that push."""
    ids = particles["id"]
    for name in ("R", "cap_radius", "mass"):
        checks.every(particles[name] > 0, f"particles/{name}", particles[name], "> 0")
    checks.every(particles["half_length"] >= 0, "particles/half_length", particles["half_length"], "≥ 0")
    unique, count = np.unique(ids, return_counts=True)
    if (count > 1).any() or (ids < 0).any():
        raise ValueError(f"particles/id holds {unique[(count > 1) | (unique < 0)][0]} {count.max()} times; wanted ids ≥ 0, each once")
    one, two = contacts["body1"], contacts["body2"]
    checks.every(np.isin(one, ids), "contacts/body1", one, "the id of a particle")
    checks.every((two < 0) | np.isin(two, ids), "contacts/body2", two, "the id of a particle, or a negative one of a wall")
    checks.every(one != two, "contacts/body2", two, "another body than body 1")
    checks.every(~np.isin(particles["clump"], ids) & (particles["clump"] >= -1), "particles/clump", particles["clump"], "−1, or an id that no particle has")
    checks.every((contacts["type"] >= CAP_CAP) & (contacts["type"] <= WALL), "contacts/type", contacts["type"], "0 to 3")
    checks.every((contacts["type"] == WALL) == (two < 0), "contacts/type", contacts["type"], f"{WALL} where body 2 is an obstacle, and only there")
    checks.every((contacts["points"] == 1) | (contacts["points"] == 2), "contacts/points", contacts["points"], "1 or 2")
    tips = particles["half_length"] + particles["cap_radius"]
    checks.every(abs(particles["R"] - tips) <= 1e-6 * tips, "particles/R", particles["R"], "half_length + cap_radius")
    length = np.hypot(*contacts["normal"].T)
    checks.every(abs(length - 1) < 1e-6, "the length of contacts/normal", length, "1")
    normal_force = np.einsum("ca,ca->c", contacts["force"], contacts["normal"])
    if len(length) and not normal_force.mean() > 0:
        raise ValueError(f"the mean normal force is {normal_force.mean():g}; wanted > 0, compression")
    for name, fits in dict(strain=math.isfinite, eta=lambda v: 0 <= v < 1, friction=lambda v: 0 <= v < math.inf, volume=math.isfinite).items():
        if name in attributes:
            checks.number(f"the attribute {name}", attributes[name], "a finite number in its range", fits)


def sin_phi(stresses):
    """q/p = (σ₁ − σ₂)/(σ₁ + σ₂) of stresses (…, 2), σ₂ first [-; paper, eq. qp]."""
    low, high = np.moveaxis(np.asarray(stresses), -1, 0)
    return (high - low) / (high + low)


def _columns(file, group, path):
    if not hasattr(file[group], "items"):
        raise ValueError(f"{group} is no group of columns")
    columns = {}
    for name, data in file[group].items():
        if getattr(data, "shape", None) is None:
            raise ValueError(f"{group}/{name} is no column")
        files.check_size(f"{group}/{name}", data.nbytes, path)
        columns[name] = data[()]
    return columns


class Network:
    """Force-bearing contacts of one snapshot.

    Parameters
    ----------
    particles : dict of arrays
        ``id`` (N,), ``position`` (N, 2) [m], ``angle`` (N,) [rad], ``R`` (N,), ``cap_radius`` (N,), ``half_length`` (N,) [m],
        ``mass`` (N,) [kg/m], ``velocity`` (N, 3) [m/s, m/s, 1/s]. Optional: ``clump`` (N,) id of the clump or −1, ``center`` (N, 2) [m]
        of mass of the clump; by default −1 and the position.
    contacts : dict of arrays
        ``body1``, ``body2`` (C,) ids, ``type`` (C,) 0 cc, 1 cs, 2 ss, 3 wall, ``normal`` (C, 2), ``branch`` (C, 2) [m],
        ``force`` (C, 2) [N/m], ``position`` (C, 2) [m] the point of application, ``points`` (C,) 1 or 2. Optional: ``friction`` (C,) µ, NaN
        where it is not known; by default the attribute.
    attributes : dict
        All optional: ``volume`` [m²] of the region, ``friction`` [-] between particles, ``cell`` (2, 2) edges of a periodic cell as columns
        [m], ``cell_velocity`` (2, 2) theirs [m/s], and what the snapshot is of: ``time`` [s], ``strain`` [-], ``dt`` [s], ``eta`` [-],
        ``seed``, ``version``.

    Raises
    ------
    ValueError
        If a column is missing, has the wrong shape or is not finite.
    """

    def __init__(self, particles, contacts, attributes):
        self.attributes = dict(attributes)
        if "volume" in self.attributes:
            checks.number("volume", self.attributes["volume"], "the area of the region > 0 [m²]", lambda v: v > 0)
        for name in {"cell", "cell_velocity"} & set(self.attributes):
            self.attributes[name] = checks.array(name, self.attributes[name], (2, 2))
        if "position" in particles:
            particles = dict(clump=np.full(len(particles["position"]), -1), center=particles["position"]) | particles
        if "body1" in contacts:
            contacts = dict(friction=np.full(np.shape(contacts["body1"]), self.attributes.get("friction", math.nan))) | contacts
        self.particles = _checked("particles", particles, _PARTICLES)
        self.contacts = _checked("contacts", contacts, _CONTACTS)

    def __repr__(self):
        told = {name: value for name in ("time", "strain", "eta", "friction", "volume") if isinstance(value := self.attributes.get(name), numbers.Real)}
        counts = f"{len(self.particles['id'])} grains, {len(self.contacts['body1'])} contacts, {self.between_particles.sum()} of them between grains"
        return f"<Network: {', '.join([counts, *(f'{name} {value:g}' for name, value in told.items())])}>"

    @classmethod
    def load(cls, path):
        """Network from a file ``network-*.h5``.

        Raises
        ------
        ValueError
            If the file is no such network; OSError if it cannot be read.
        """
        import h5py

        with files.reading(path, "an HDF5 file"):
            files.check_seal(path)
            with h5py.File(path, "r") as file:
                if not {"particles", "contacts"} <= set(file):
                    raise ValueError(f"it holds {sorted(file)}; wanted the groups particles and contacts")
                groups = [_columns(file, group, path) for group in ("particles", "contacts")]
                attributes = {k: v.item() if isinstance(v, np.generic) else v for k, v in file.attrs.items() if k != "stress"}
            network = cls(*groups, attributes)
            _check_meaning(network.particles, network.contacts, network.attributes)
            return network

    def save(self, path):
        """Write the network to `path`: whole or not at all, with a check sum at its end."""
        from rcr import __version__

        def fill(file):
            for group, columns in (("particles", self.particles), ("contacts", self.contacts)):
                for column, data in columns.items():
                    file.create_dataset(f"{group}/{column}", data=data)
            file.attrs.update({"version": __version__, **self.attributes, **({"stress": self.stress()} if "volume" in self.attributes else {})})

        files.write(path, files.hdf5(fill))

    @property
    def between_particles(self):
        """Mask of the contacts between particles, (C,) bool."""
        return self.contacts["body2"] >= 0

    def stress(self):
        """Stress tensor σ = (1/V) Σ f⊗ℓ over all contacts [paper, eq. sigma]; (2, 2), compression positive [Pa].

        Raises
        ------
        ValueError
            If the network has no volume.
        """
        if "volume" not in self.attributes:
            raise ValueError("the network has no volume, which the stress is the mean of; give the area of the region [m²], rcr.contact_network(volume=…)")
        return self._moments() / self.attributes["volume"]

    def _moments(self):
        """Σ f⊗ℓ over all contacts, (2, 2) [N]."""
        return np.einsum("ca,cb->ab", self.contacts["force"], self.contacts["branch"])

    def stress_axes(self):
        """Principal axes of the stress as columns, that of σ₁ first; (2, 2) [-]."""
        moments = self._moments()
        return np.linalg.eigh(0.5 * (moments + moments.T))[1][:, ::-1]

    def stress_angle(self):
        """θσ, the angle of the axis of σ₁ from x, in [0, π) [rad]."""
        x, y = self.stress_axes()[:, 0]
        return np.arctan2(y, x) % np.pi

    def principal_stresses(self):
        """σ₂ and σ₁, (2,) [Pa]."""
        stress = self.stress()
        return np.linalg.eigvalsh(0.5 * (stress + stress.T))

    def sin_phi(self):
        """q/p of the whole stress [-]."""
        moments = self._moments()
        return sin_phi(np.linalg.eigvalsh(0.5 * (moments + moments.T)))

    def local_components(self):
        """Of the contacts between particles: n (C, 2), and (n, t) components of branch and force, (C, 2) each."""
        pick = self.between_particles
        if not pick.any():
            raise ValueError("the network has no contact between particles")
        n = self.contacts["normal"][pick]
        t = np.column_stack([-n[:, 1], n[:, 0]])
        branch, force = self.contacts["branch"][pick], self.contacts["force"][pick]
        frame = np.stack([n, t], axis=1)
        return n, t, np.einsum("cka,ca->ck", frame, branch), np.einsum("cka,ca->ck", frame, force)

    def xi_networks(self):
        """Partial sums over the contacts between particles, for any ξ; see `rcr.xi_networks.XiNetworks`."""
        n, _, branch, force = self.local_components()
        theta = np.arctan2(n[:, 1], n[:, 0]) - self.stress_angle()
        return XiNetworks(theta, branch @ COMPLEX, force @ COMPLEX, force[:, 0] / force[:, 0].mean())

    def fabric(self, xi=np.inf):
        """Fabric tensor F(ξ) = (1/N) Σ_{S(ξ)} n⊗n, N of the whole network [paper, eq. F_xi]; (2, 2), tr F(∞) = 1 [-]."""
        if np.ndim(xi):
            raise ValueError(f"xi = {xi!r}; wanted one cutoff")
        n, _, _, force = self.local_components()
        pick = force[:, 0] <= cutoffs(xi) * force[:, 0].mean()
        return np.einsum("ca,cb->ab", n[pick], n[pick]) / len(n)

    def anisotropies(self, xi=np.inf):
        """Anisotropies of contacts, branch vectors and forces of the ξ-network [-; paper, eqs. harmonique, Aniso_values_xi].

        Parameters
        ----------
        xi : float or array
            Cutoffs f_n/⟨f_n⟩ [-]; an array costs no more than a number.

        Returns
        -------
        (a_c, a_ln, a_lt, a_fn, a_ft) : floats, or arrays of the shape of ξ
            Positive along σ₁. With t = n turned by +90° an average ⟨f_t⟩ = a sin 2(θ − θσ) is a_ft = −a, and so for a_lt.
        """
        return self.xi_networks().anisotropies(xi)

    def shear_stress_ratio(self, xi=np.inf):
        """q(ξ)/p: deviator of the partial stress along the axes of σ over the whole p, contacts between particles [-]."""
        return self.xi_networks().shear_stress_ratio(xi)

    def force_pdf(self, bins=50):
        """Probability density of f_n/⟨f_n⟩ between particles, in logarithmic classes.

        Returns
        -------
        f : (bins,) float array
            Centres of the classes, f_n/⟨f_n⟩ [-].
        pdf : (bins,) float array
            Density; Σ pdf Δf = share of contacts within the classes.
        """
        bins = checks.integer("bins", bins, "at least 1", lambda v: 1 <= v <= 10**6)
        force = self.local_components()[3][:, 0]
        force = force / force.mean()
        edges = np.geomspace(max(force.min(), 1e-4), force.max() * (1 + 1e-12), bins + 1)
        count, _ = np.histogram(force, edges)
        return np.sqrt(edges[1:] * edges[:-1]), count / (np.diff(edges) * len(force))

    def friction_mobilization(self):
        """I_m = |f_t|/(µ f_n) of each contact between particles, µ that of the contact, 0 where it has none; (C,) [-].

        Raises
        ------
        ValueError
            If no contact between particles has a friction coefficient > 0.
        """
        force = self.local_components()[3]
        friction = self.contacts["friction"][self.between_particles]
        if not (friction > 0).any():
            raise ValueError(f"friction = {friction.max():g} between all particles; the mobilisation needs a coefficient > 0")
        limit = friction * force[:, 0]
        return np.divide(np.abs(force[:, 1]), limit, out=np.zeros_like(limit), where=friction > 0)

    def grain_stresses(self):
        """Mean stress in each particle by the moments of its contact forces (Love, Weber); (N, 2, 2), compression positive [Pa].

        See `rcr.frame.Frame.stress_tensors`. Times the areas of the particles over the volume, the sum is `stress`.
        """
        return self._frame().stress_tensors()

    def grain_coordination(self):
        """Number of contacts of each particle, obstacles included; those of a clump have the number of the whole, (N,) int."""
        return self._frame().per_grain(np.ones(len(self.contacts["body1"]))).astype(int)

    def _frame(self):
        from rcr.frame import Frame  # which reads networks

        return Frame.of_network(self)

    def coordination(self, count_side_contacts_twice=False):
        """Mean number of contacts a particle or clump, obstacles included, of those with at least two [-].

        Rattlers, particles with fewer than two contacts, are removed together with their contacts until none is left.
        `count_side_contacts_twice` counts a side-side contact, which takes two unknowns, as two.
        """
        alive, _, total = self.backbone(count_side_contacts_twice)
        return float(total[alive].mean()) if alive.any() else 0.0

    def backbone(self, count_side_contacts_twice=False):
        """What is left without rattlers, as `coordination` removes them.

        Returns
        -------
        alive, kept, total : (largest id + 1,) bool, (C,) bool and (largest id + 1,) int arrays
            Whether a particle, or a clump, is left, by its id; whether a contact is; number of contacts by id.
        """
        ids, clump = self.particles["id"], self.particles["clump"]
        weight = np.where(count_side_contacts_twice & (self.contacts["points"] == 2), 2, 1)
        size = int(max(ids.max(initial=-1), clump.max(initial=-1))) + 1
        moves_with = np.arange(size)
        moves_with[ids] = np.where(clump >= 0, clump, ids)
        alive = np.zeros(size, dtype=bool)
        alive[moves_with[ids]] = True
        inner = self.between_particles
        one, two = moves_with[self.contacts["body1"]], moves_with[np.where(inner, self.contacts["body2"], 0)]
        while True:
            kept = alive[one] & (alive[two] | ~inner)
            total = np.bincount(one[kept], weights=weight[kept], minlength=size)
            total += np.bincount(two[kept & inner], weights=weight[kept & inner], minlength=size)
            rattlers = alive & (total < 2)
            if not rattlers.any():
                return alive, kept, total
            alive &= ~rattlers
