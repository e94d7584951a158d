"""Contacts of several networks, pooled with the forces of each over its mean. Needs NumPy."""

import functools

import numpy as np

from rcr import statistics
from rcr._data.network_columns import LEFT, RIGHT, rows
from rcr._data.plain import plain
from rcr.xi_networks import XiNetworks


class Ensemble:
    """Contacts between grains of several networks.

    The networks of a shear test have the attributes eta and friction; a ValueError says that there
    is no network, or that they differ, or have no friction. With `any_scene` they need neither.

    Attributes
    ----------
    eta : float
        The attribute, or with `any_scene` the largest half_length/R of the grains [-].
    fn, ft : (C,) float arrays
        Components of the force over ⟨f_n⟩ of its network [-], t = n turned by +90°.
    ln, lt : (C,) float arrays
        Components of the branch vector over R_max of its network [-].
    reduced_length : (C,) float array
        ℓ_r = ℓ/(R₁ + R₂) [-].
    mobilization : (C,) float array
        I_m = |f_t|/(µ f_n) [-]; with `any_scene` NaN for a network in which it is unknown.
    angle : (C,) float array
        Direction of the normal from x, in [0, π) [rad].
    theta : (C,) float array
        Direction of the normal from the axis of σ₁ of its network, θ − θσ [rad].
    type : (C,) int array
        0 cap-cap, 1 cap-side, 2 side-side.
    across : (C,) float array
        Position of the contact between the left (0) and the right side (1) of its network [-].
    stress_angle : float
        Mean θσ, in [0, π) [rad].
    """

    def __init__(self, networks, any_scene=False):
        if not networks:
            raise ValueError("no networks: an ensemble needs at least one network")
        strange = [network for network in networks if not hasattr(network, "local_components")]
        if strange:
            raise ValueError(
                f"{strange[0]!r:.60} is not a network; expected a result of rcr.Network.load")
        if not any_scene:
            self.eta, _ = (common_value(networks, name) for name in ("eta", "friction"))
        parts = [_contacts(network, any_scene) for network in networks]
        if any_scene:
            self.eta = plain(max((n.particles["half_length"] / n.particles["R"]).max()
                                 for n in networks))
        for name in parts[0]:
            setattr(self, name, np.concatenate([part[name] for part in parts]))
        double_angles = [2 * network.stress_angle() for network in networks]
        mean = np.mean(np.exp(1j * np.array(double_angles)))
        self.stress_angle = plain(0.5 * np.angle(mean) % np.pi)

    def __len__(self):
        return len(self.fn)

    @functools.cached_property
    def xi_networks(self):
        """Partial sums of the cumulated contacts; see `XiNetworks`."""
        return XiNetworks(self.theta, self.ln + 1j * self.lt, self.fn + 1j * self.ft, self.fn)

    @functools.cached_property
    def force(self):
        """Size of each force over ⟨f_n⟩ of its network, (C,) [-]."""
        return np.hypot(self.fn, self.ft)

    @functools.cached_property
    def length(self):
        """Length of each branch vector over R_max of its network, (C,) [-]."""
        return np.hypot(self.ln, self.lt)

    def correlations(self):
        """Return Pearson's coefficients of force and ℓ_r, NaN for discs, and of force and ℓ [-].

        They are NaN if all forces or all lengths are equal.
        """
        c_f_lr = statistics.pearson(self.force, self.reduced_length) if self.eta else np.nan
        return dict(c_f_lr=c_f_lr, c_f_l=statistics.pearson(self.force, self.length))


def common_value(networks, name):
    """Return an attribute that the networks share; a ValueError reports several values or none."""
    found = sorted({round(float(n.attributes.get(name, np.nan)), 9) for n in networks})
    if len(found) > 1 or not np.isfinite(found[0]):
        listed = ", ".join(f"{value:g}" for value in found)
        raise ValueError(f"the networks have {name} = {listed}; expected one value")
    return found[0]


def _contacts(network, any_scene):
    """Return the columns of `Ensemble` for one network."""
    n, _, branch, force = network.local_components()
    pick = network.between_particles
    ids, radius = network.particles["id"], network.particles["R"]
    one, two = (radius[rows(ids, network.contacts[body][pick])] for body in ("body1", "body2"))
    mean, angle = force[:, 0].mean(), np.arctan2(n[:, 1], n[:, 0])
    return dict(fn=force[:, 0] / mean, ft=force[:, 1] / mean, ln=branch[:, 0] / radius.max(),
                lt=branch[:, 1] / radius.max(), reduced_length=np.hypot(*branch.T) / (one + two),
                mobilization=_mobilization(network, pick, any_scene), angle=angle % np.pi,
                theta=angle - network.stress_angle(), type=network.contacts["type"][pick],
                across=_across(network)[pick])


def _mobilization(network, pick, any_scene):
    """Return I_m of each contact between grains, (C,)."""
    friction = network.contacts["friction"][pick]
    if any_scene and not (friction > 0).all():
        return np.full(len(friction), np.nan)
    return network.friction_mobilization()


def _across(network):
    """Return x of each contact over the width; (C,) in [0, 1].

    The width is that between the contacts at the side walls, or between the outermost contacts. In
    a periodic cell, x is along the first edge.
    """
    if "cell" in network.attributes:
        inverse = np.linalg.inv(network.attributes["cell"])
        return network.contacts["position"] @ inverse[0] % 1
    x, body = network.contacts["position"][:, 0], network.contacts["body2"]
    left, right = (x[body == wall].mean() if (body == wall).any() else end
                   for wall, end in ((LEFT, x.min()), (RIGHT, x.max())))
    return np.clip((x - left) / (right - left), 0, 1) if right > left else np.zeros_like(x)
