#!/usr/bin/env python3
"""Count each point of two touching sides as a contact, and print what changes in the study.

    scripts/lib/run python3 benchmarks/points_of_sides.py RUNS... --out points-of-sides.csv

RUNS are folders of scripts/biaxial.py. Two sides touch at both ends of their shadow. The position
of their resultant force gives the share of each end. The paper has four points: each end counts
twice, with half of its force. Prints a table and writes it as CSV.
"""

import numpy as np

from benchmarks import tables
from rcr import script
from rcr._data import files
from rcr import statistics
from rcr.ensemble import Ensemble
from rcr.distributions import POWER_RANGE
from rcr.study.runs import Run, by_kind
from rcr.xi_networks import XiNetworks

COLUMNS = "eta points weak_share beta_n c_f_lr c_f_l a_c_weak xi_a_ln".split()
XI = np.arange(0.05, 6.01, 0.05)  # cutoffs of a_ln [-]
NEGLIGIBLE = 1e-6  # of the force of its pair: an end that carries less is no point


def share_of_first_end(network):
    """Share of the force at the first end of the shadow, (C,) in (0, 1); NaN for one point."""
    particles, pick = network.particles, network.between_particles
    contacts = {name: column[pick] for name, column in network.contacts.items()}
    tangent = contacts["normal"] @ [[0, 1], [-1, 0]]
    half_core = (particles["half_length"][:, None]
                 * np.stack([np.cos(particles["angle"]), np.sin(particles["angle"])], 1))
    rows = [np.searchsorted(particles["id"], contacts[body]) for body in ("body1", "body2")]
    centre = [np.sum(particles["position"][row] * tangent, 1) for row in rows]
    reach = [np.abs(np.sum(half_core[row] * tangent, 1)) for row in rows]
    # A pair across the boundary of a periodic cell has no such shadow; biaxial tests have walls.
    first = np.maximum(*(c - r for c, r in zip(centre, reach)))
    last = np.minimum(*(c + r for c, r in zip(centre, reach)))
    place = np.sum(contacts["position"] * tangent, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (last - place) / (last - first)
    both = (contacts["points"] == 2) & (NEGLIGIBLE < share) & (share < 1 - NEGLIGIBLE)
    return np.where(both, share, np.nan)


def contacts(network, points):
    """Contacts with one row a pair (points = 1), or one a point: f_n, |f|, ℓ_r, ℓ, ℓ_n, θ − θσ."""
    e, share = Ensemble([network]), share_of_first_end(network)
    columns = np.array([e.fn, np.hypot(e.fn, e.ft), e.reduced_length, np.hypot(e.ln, e.lt), e.ln,
                        e.theta])
    two = np.isfinite(share) & (points > 1)
    ends = []
    for part in (share[two], 1 - share[two]):
        end = columns[:, two].copy()
        end[:2] *= part / (points / 2)
        ends.append(end)
    return np.concatenate([columns[:, ~two], *ends * (points // 2)], axis=1)


def row(runs, points):
    """Row of the table for one elongation."""
    networks = [network for run in runs for network in run.networks]
    columns = np.concatenate([contacts(network, points) for network in networks], axis=1)
    fn, force, reduced, length, normal_length, theta = columns
    eta, xi_networks = runs[0].eta, xi_networks_of(fn, normal_length, theta)
    return dict(eta=eta, points=points, weak_share=(fn < fn.mean()).mean(),
                beta_n=statistics.power_exponent(fn / fn.mean(), POWER_RANGE)[0],
                c_f_lr=np.nan if eta == 0 else statistics.pearson(force, reduced),
                c_f_l=statistics.pearson(force, length),
                a_c_weak=xi_networks.anisotropies(1)[0],
                xi_a_ln=xi_of_lowest_a_ln(xi_networks))


def xi_of_lowest_a_ln(xi_networks):
    """ξ at which a_ln(ξ) is lowest, up to 6 [-]."""
    return XI[np.argmin(xi_networks.anisotropies(XI).a_ln)]


def xi_networks_of(fn, normal_length, theta):
    """ξ-networks of contacts without tangential components: for a_c, a_ln and a_fn."""
    return XiNetworks(theta, normal_length.astype(complex), fn.astype(complex), fn / fn.mean())


def main():
    options = tables.tests_and_csv("points_of_sides.py", __doc__, "points-of-sides.csv",
                                  averages=True)
    groups = by_kind([Run.read(folder, options.from_strain) for folder in options.folders])
    rows = [row(runs, points) for runs in groups.values() for points in (1, 2, 4)]
    rows = [{name: f"{value:.4g}" for name, value in r.items()} for r in rows]
    files.write(options.out, files.table(COLUMNS, rows))
    for line in [COLUMNS, *(r.values() for r in rows)]:
        print("".join(f"{cell:>12}" for cell in line))


if __name__ == "__main__":
    script.run(main)
