"""Measures of force networks of any scene. Needs NumPy and h5py, not YADE.

A set is one saved network, or the networks of a folder. The contacts of a set are pooled, with the
forces of each network over its mean. Directions and signs are those of `rcr.network`. Measures
that need what a network does not have are NaN, for example the friction mobilisation without µ.
"""

import pathlib
import typing

import numpy as np

from rcr import distributions
from rcr._data import files, run_folder
from rcr.ensemble import Ensemble
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE, Network

XI = np.append(np.arange(0, 6.01, 0.1), np.inf)  # cutoffs of the functions of ξ
SHEAR_TEST = "strain", "eta", "friction", "volume"  # attributes of the networks of a shear test


class NetworkSet(typing.NamedTuple):
    """Networks whose contacts are pooled."""

    name: str
    paths: list
    networks: list


def paths_of(given):
    """Return the network files of a path: a file itself, or network-*.h5 of a folder."""
    path = pathlib.Path(files.path_of("a network", given))
    if path.is_file():
        return [path]
    expected = "expected the file of a network, or a folder with network-*.h5"
    if not path.is_dir():
        raise ValueError(f"{path} is neither a file nor a folder; {expected}")
    found = sorted(path.glob("network-*.h5"))
    if not found:
        raise ValueError(f"{path} has no network-*.h5; {expected}")
    return found


def is_shear_test(path):
    """Return whether a path is a folder of biaxial.py, or its first network has `SHEAR_TEST`."""
    if not pathlib.Path(path).is_dir():
        return False
    record = run_folder.read(path)
    if record and record["program"] == "biaxial.py":
        return True
    return set(SHEAR_TEST) <= set(Network.load(paths_of(path)[0]).attributes)


def read(given):
    """Return the `NetworkSet` of each path; a ValueError reports one without a usable network."""
    sets = []
    for path in given:
        found = paths_of(path)
        networks = [Network.load(file) for file in found]
        for file, network in zip(found, networks):
            if not network.between_particles.any():
                raise ValueError(f"{file} has no contact between grains; expected a network that "
                                 "bears a load: leave it out, or save it after a step")
        sets.append(NetworkSet(_name(path, [s.name for s in sets]), found, networks))
    return sets


def _name(path, taken):
    """Return the name of a set: that of its file or folder, with a number if it is taken."""
    stem = pathlib.Path(path).resolve().stem
    same = sum(name == stem or name.startswith(f"{stem} (") for name in taken)
    return f"{stem} ({same + 1})" if same else stem


def analyse(sets):
    """Return {name of a set: its measures} as analysis.json holds them; see docs/force-network.md.
    """
    return {one.name: measures(one) for one in sets}


def measures(one):
    """Return the measures of a `NetworkSet`, {name: number, list or array}."""
    networks, e = one.networks, Ensemble(one.networks, any_scene=True)
    known = np.isfinite(e.mobilization)
    branch, force = np.column_stack([e.ln, e.lt]), np.column_stack([e.fn, e.ft])
    mean, correlations = lambda values: float(np.mean([*values])), e.correlations()
    types = zip(("cc", "cs", "ss"), (CAP_CAP, CAP_SIDE, SIDE_SIDE))
    return dict(
        files=[str(path) for path in one.paths], networks=len(networks), contacts=len(e),
        grains=mean(len(n.particles["id"]) for n in networks),
        coordination_number=mean(n.coordination() for n in networks),
        mean_normal_force=mean(n.local_components()[3][:, 0].mean() for n in networks),
        **{f"fraction_{name}": float(np.mean(e.type == kind)) for name, kind in types},
        weak_share=e.xi_networks.fraction(1),
        friction_mobilization=float(e.mobilization[known].mean()) if known.any() else np.nan,
        c_f_l=correlations["c_f_l"], c_f_lr=correlations["c_f_lr"],
        normal_force=_forces(e.fn), tangential_force=_forces(np.abs(e.ft)),
        fabric=np.mean([n.fabric() for n in networks], axis=0), stress_angle=e.stress_angle,
        **_xi_functions(e), directions=distributions.polar(e.angle, branch, force)._asdict(),
        chains=_chains(networks))


def _forces(force):
    """Return density and exponents of a component; None without any such force."""
    if not force.any():
        return None
    scaled = force / force.mean()
    pdf = distributions.force_pdf(scaled, _bins(len(scaled)))
    return dict(edges=pdf.edges, force=pdf.force, pdf=pdf.pdf,
                **distributions.exponents(scaled)._asdict())


def _bins(contacts):
    """Return the number of bins of forces: 50, or fewer for few contacts."""
    return int(np.clip(np.sqrt(contacts), 8, 50))


def _xi_functions(e):
    """Return anisotropies and q(ξ)/p over the cutoffs; the last one includes all contacts."""
    values = e.xi_networks.anisotropies(XI)._asdict()
    return dict(xi=XI, **values, q_over_p=e.xi_networks.shear_stress_ratio(XI))


def _chains(networks):
    """Return share, number and size of the force chains, means of the networks."""
    found = [network.force_chains() for network in networks]
    sizes = np.concatenate([chains.grains for chains in found])
    return dict(share=float(np.mean([chains.share for chains in found])),
                count=len(sizes) / len(found), grains=float(sizes.mean()) if len(sizes) else np.nan,
                longest=int(sizes.max(initial=0)))
