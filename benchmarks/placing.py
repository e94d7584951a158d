"""Observables of packings of grains that are placed or sized differently.

    scripts/yade-rcr -n -x benchmarks/placing.py --particles 4000 --seeds 1,2 --out placing
    scripts/yade-rcr -n -x benchmarks/placing.py --eta 0.7 --particles 4000 --out placing-0.7

Each case compacts grains and shears them as scripts/biaxial.py does, to a strain of 0.3. A run that
is stopped continues with the same command. Cases:

    layers   circles deposited layer by layer, as in the study
    random   random sequential addition: each circle at a random free place, large ones first
    sizes    layers, with R_max = 3 R_min
    loose    layers, up to η = 0.2; steps of the shear are 0.1 t₀ long and end by the criterion of
             the paper: plain sweeps, until the mean force changes by less than 1e-3
             (`meanForceChange`)

Prints a table and writes it to DIR: means over seeds, errors are standard errors.

fabric.csv
    Of discs. After the compaction, the amplitude of cos k(θ − θ_k) in 2π P(θ), of the contact
    directions θ, is 2 |⟨exp(i k θ)⟩|. In the shear, a_c(ξ) is that of the ξ-networks at strains of
    0.15 to 0.3 [-]. *Inner* contacts are more than `MARGIN` mean diameters away from the walls.
long-grains.csv
    Of other grains: observables at strains of 0.15 to 0.3, the ξ at which a_ln(ξ) is lowest, and
    the last ξ at which a_fn(ξ) is negative. q/p is that of all contacts between grains.
"""

import math
import os

import numpy as np

from benchmarks import tables
from benchmarks.charts.quasi_static import observed
from benchmarks.points_of_sides import XI as WIDE_XI, xi_of_lowest_a_ln
from rcr import script
from rcr._data import files
from rcr.ensemble import Ensemble
from rcr.network import Network
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT
from rcr.study.criteria import last_negative
from rcr.xi_networks import XiNetworks

LOOSE, FIRST, LAST, INTERVAL = 0.45, 0.15, 0.3, 0.01  # packing fraction; strains of networks [-]
MARGIN = 5  # mean diameters
HARMONICS = 2, 4, 6
XI = np.arange(0.2, 1.5, 0.05)  # cutoffs f_n/⟨f_n⟩ [-]
OF_DISCS = *(f"amplitude_{k}" for k in HARMONICS), "a_c_min", "a_c"
OF_LONG_GRAINS = ("beta_n", "weak_fraction", "a_c_weak", "c_f_lr", "c_f_l", "half_sum", "xi_a_ln",
                  "q_over_p", "xi_a_fn")
MOST_LOOSE = 0.2  # η up to which grains whose steps are solved loosely do not sink in too far


def randomly(radii, rng):
    """Centres (N, 2) and width of a square box [m] of circles at random free places."""
    width = math.sqrt(math.pi * np.sum(radii**2) / LOOSE)
    centres = np.empty((len(radii), 2))
    cell, grid = 2 * radii.max(), {}
    for k in np.argsort(-radii, kind="stable"):
        while True:
            at = rng.uniform(radii[k], width - radii[k], 2)
            i, j = (at // cell).astype(int)
            near = [n for x in (i - 1, i, i + 1) for y in (j - 1, j, j + 1)
                    for n in grid.get((x, y), ())]
            if not near or (np.hypot(*(centres[near] - at).T) >= radii[near] + radii[k]).all():
                break
        centres[k] = at
        grid.setdefault((i, j), []).append(k)
    return centres, width


def cases(seed):
    """{case: parameters of Biaxial.prepare}; `shear` has attributes of the solver in the shear."""
    rng = np.random.default_rng(seed)
    return dict(layers={}, random=dict(place=lambda radii: randomly(radii, rng)),
                sizes=dict(size_span=3),
                loose=dict(time_step=0.1, shear=dict(solver="nlgs", meanForceChange=1e-3)))


def sheared(folder, eta, particles, seed, shear=(), **parameters):
    """Networks after the compaction and in the shear of a test, made or continued."""
    os.makedirs(folder, exist_ok=True)
    path = lambda strain: os.path.join(folder, f"{strain:.2f}.h5")
    strains = np.arange(FIRST, LAST + INTERVAL / 2, INTERVAL)
    if not os.path.exists(path(strains[-1])):
        if os.path.exists(os.path.join(folder, CHECKPOINT)):
            test = Biaxial.load(folder)
        else:
            test = Biaxial.prepare(eta, particles, seed, threads=1, **parameters)
            test.compact()
            test.isotropic.save(path(0))
            for name, value in dict(shear).items():
                setattr(test.solver, name, value)
            test.save(folder)
        for strain in strains:
            if os.path.exists(path(strain)):
                continue
            while not test.has_reached(strain):
                test.shear_record()
            test.network().save(path(strain))
            test.save(folder)
    return Network.load(path(0)), [Network.load(path(strain)) for strain in strains]


def _contacts(network, inner):
    """Directions (C,) [rad] and normal forces (C,) of the contacts between grains."""
    normal, _, _, force = network.local_components()
    angle, force = np.arctan2(normal[:, 1], normal[:, 0]), force[:, 0]
    if not inner:
        return angle, force
    place = network.contacts["position"][network.between_particles]
    centres, far = network.particles["position"], MARGIN * 2 * network.mean_radius()
    inside = ((place > centres.min(0) + far) & (place < centres.max(0) - far)).all(1)
    return angle[inside], force[inside]


def amplitudes(network, inner):
    angle, _ = _contacts(network, inner)
    return [2 * abs(np.exp(1j * k * angle).mean()) for k in HARMONICS]


def weak_fabrics(networks, inner):
    """a_c(ξ) at `XI` and at ∞, means over networks."""
    found = []
    for network in networks:
        angle, force = _contacts(network, inner)
        parts = XiNetworks(angle - network.stress_angle(), np.ones(len(angle), complex),
                           force.astype(complex), force / force.mean())
        found.append(parts.anisotropies(np.append(XI, np.inf)).a_c)
    return np.mean(found, axis=0)


def of_discs(tests, inner):
    """Values of `OF_DISCS` of each test, (compacted, sheared), and the ξ of the lowest a_c."""
    first = np.array([amplitudes(compacted, inner) for compacted, _ in tests])
    fabrics = np.array([weak_fabrics(networks, inner) for _, networks in tests])
    lowest = fabrics[:, :-1].mean(0).argmin()
    return [*first.T, fabrics[:, lowest], fabrics[:, -1]], XI[lowest]


def of_long_grains(networks):
    """Values of `OF_LONG_GRAINS` of a test."""
    ensemble = Ensemble(networks)
    parts = ensemble.xi_networks
    found = observed(ensemble) | dict(
        xi_a_ln=xi_of_lowest_a_ln(parts),
        xi_a_fn=last_negative(WIDE_XI, parts.anisotropies(WIDE_XI).a_fn))
    return [found[name] for name in OF_LONG_GRAINS]


def rows(case, tests, about):
    about = dict(case=case, **about)
    if about["eta"] > 0:
        values = [of_long_grains(networks) for _, networks in tests]
        return [about | tables.means(dict(zip(OF_LONG_GRAINS, np.transpose(values))))]
    found = []
    for inner in False, True:
        columns, lowest = of_discs(tests, inner)
        contacts = dict(contacts="inner" if inner else "all", xi_min=lowest)
        found.append(about | contacts | tables.means(dict(zip(OF_DISCS, columns))))
    return found


def main():
    parser = script.Parser(prog="placing.py", description=__doc__.splitlines()[0])
    eta = script.number("an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1)
    parser.add_argument("--eta", type=eta, default=0)
    tables.add_packings(parser, 4000, 500)
    parser.add_argument("--out", type=script.folder, default="placing", metavar="DIR")
    options = parser.parse_args()
    about = dict(eta=options.eta, grains=options.particles, seeds=len(options.seeds))
    table = []
    for case in cases(0):
        if case == "loose" and options.eta > MOST_LOOSE:
            continue
        tests = [sheared(os.path.join(options.out, f"{case}-{seed}"), options.eta,
                         options.particles, seed, **cases(seed)[case]) for seed in options.seeds]
        for one in rows(case, tests, about):
            table.append(one)
            print("  ".join(f"{name} {value:.3g}" if isinstance(value, float) else str(value)
                            for name, value in one.items()), flush=True)
    name = "long-grains.csv" if options.eta > 0 else "fabric.csv"
    files.write(os.path.join(options.out, name), files.table(list(table[0]), table))


script.run(main)
