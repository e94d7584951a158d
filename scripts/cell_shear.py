"""Compaction and shear in a periodic cell without walls; with --walls the biaxial test too.

It prints a table and writes a CSV file. Between walls the packing fraction is measured three
diameters and more away from them, since grains lie looser at a wall. Run it with YADE:

scripts/yade-rcr -n -x scripts/cell_shear.py --etas 0 0.5 --seeds 3 --walls --out cell-shear.csv
"""

import math

import numpy as np
from tqdm import tqdm
from yade.wrapper import Omega

import rcr
from rcr import script
from rcr._data import files
from rcr.study.biaxial import Biaxial
from rcr.study.cell import MODES, CellTest
from rcr.study.protocol import PROTOCOL

O = Omega()

COLUMNS = [
    "geometry", "eta", "seed", "packing_fraction_initial", "sin_phi", "sin_phi_error",
    "packing_fraction", "a_c_half", "a_c_weak",
]  # fmt: skip
HEADINGS = [
    "geometry", "η", "seed", "first packing fraction", "q/p", "packing fraction", "a_c(0.5)",
    "a_c(1)",
]  # fmt: skip
ROW = (
    "| {geometry} | {eta:g} | {seed} | {packing_fraction_initial:.4f} | {sin_phi:.3f} ± "
    "{sin_phi_error:.3f} | {packing_fraction:.4f} | {a_c_half:.3f} | {a_c_weak:.3f} |"
)
STATIONARY = 0.1  # strain at the start of the averages
MIN_STRAIN = 0.15  # strain at the end, at least: five networks for averages
WEAK = 0.5, 1.0  # ξ of a_c_half and a_c_weak
EVERY = 0.01  # strain between two networks
MARGINS = np.linspace(3, 6, 10)  # distances from the walls that packing fractions leave out [d]
MIN_PARTICLES = 400  # grains between walls: a box 20 diameters wide


def arguments():
    """Return the options of the command line."""
    number, integer = script.number(), script.integer()
    strain = script.number(f"{MIN_STRAIN:g} ≤ strain < 1", lambda v: MIN_STRAIN <= v < 1)
    parser = script.Parser(prog="cell_shear.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--etas", type=number, nargs="+", default=[0, 0.5], help="elongations (default 0 0.5)")
    add("--seeds", type=script.at_least(1), default=3,
        help="packings of each elongation (default %(default)s)")
    add("--modes", choices=MODES, nargs="+", default=list(MODES),
        help="of the shear (default: both)")
    add("--walls", action="store_true", help="also make the biaxial test between walls")
    add("--particles", type=integer, default=1000, help="number of grains (default %(default)s)")
    add("--strain", type=strain, default=0.3,
        help=f"at the end (default %(default)s); averages start at {STATIONARY:g}")
    add("--inertial-number", type=number, default=1e-3,
        help="rate times √(m/σ0) (default %(default)s)")
    add("--time-step", type=number, default=0.1, help="over √(m/σ0) (default %(default)s)")
    add("--out", type=script.new_file, default="cell-shear.csv", metavar="FILE",
        help="CSV file (default %(default)s)")
    options = parser.parse_args()
    if options.walls and options.particles < MIN_PARTICLES:
        parser.error(
            f"--walls with --particles {options.particles}: expected at least {MIN_PARTICLES}, "
            "of which some are far from all walls"
        )
    options.rate = dict(inertial_number=options.inertial_number, time_step=options.time_step)
    return options


def average(strain, values):
    """Return the mean from `STATIONARY` on, and its error from means of five parts."""
    late = np.array_split(np.asarray(values)[np.asarray(strain) > STATIONARY], 5)
    means = [part.mean() for part in late]
    return np.mean(means), np.std(means, ddof=1) / math.sqrt(len(means))


def averages(first, strain, sin_phi, packing_fraction, weak):
    """Return a row; `weak` has strain and a_c(ξ) for `WEAK` of each network."""
    a_c_half, a_c_weak = np.mean([a_c for at, a_c in weak if at > STATIONARY], axis=0)
    mean, error = average(strain, sin_phi)
    return dict(
        packing_fraction_initial=first,
        sin_phi=mean,
        sin_phi_error=error,
        packing_fraction=average(strain, packing_fraction)[0],
        a_c_half=a_c_half,
        a_c_weak=a_c_weak,
    )


def in_cell(mode, eta, seed, options):
    """Return the row of a test in a cell."""
    test = CellTest(eta, options.particles, seed, **options.rate)
    test.compact()
    first, weak = test.packing_fraction, []
    with tqdm(desc=f"{mode}, η = {eta:g}", total=options.strain, disable=None) as bar:

        def report(test, row):
            weak.append((row["strain"], rcr.contact_network().anisotropies(WEAK)[0]))
            bar.update(row["strain"] - bar.n)

        rows = test.shear(mode, options.strain, report, EVERY)
    return averages(first, rows["strain"], rows["sin_phi"], rows["packing_fraction"], weak)


def inner_fraction(test):
    """Return the packing fraction away from the walls.

    It is the mean of ten windows, each the grains with centres more than a margin from all walls.
    """
    states = [O.bodies[i].state for i in test.grains]
    at = np.array([(s.pos[0], s.pos[1]) for s in states])
    areas = np.array([s.mass for s in states]) / PROTOCOL.density

    def corner(wall_x, wall_y):
        return np.array([O.bodies[wall_x].state.pos[0], O.bodies[wall_y].state.pos[1]])

    low, high = corner(test.left, test.bottom), corner(test.right, test.top)
    found = []
    for margin in MARGINS * test.diameter:
        inside = ((at > low + margin) & (at < high - margin)).all(axis=1)
        found.append(areas[inside].sum() / np.prod(high - low - 2 * margin))
    return np.mean(found)


def between_walls(eta, seed, options):
    """Return the row of a biaxial test between walls."""
    test = Biaxial.prepare(
        eta=eta, particles=options.particles, seed=seed, threads=1, approach=0, sample_inertia=1,
        **options.rate
    )
    test.compact()
    first, inner, weak = inner_fraction(test), [], []
    while test.strain < options.strain:
        test.shear_record()
        inner.append(inner_fraction(test))
        if test.strain > EVERY * (len(weak) + 1):
            weak.append((test.strain, test.network().anisotropies(WEAK)[0]))
    strain, sin_phi = ([row[name] for row in test.rows] for name in ("strain", "sin_phi"))
    return averages(first, strain, sin_phi, inner, weak)


def main():
    options = arguments()
    table = []
    print("| " + " | ".join(HEADINGS) + " |\n" + "|---" * len(HEADINGS) + "|")
    for eta in options.etas:
        for seed in range(1, options.seeds + 1):
            modes = options.modes
            found = {f"cell, {mode}": in_cell(mode, eta, seed, options) for mode in modes}
            if options.walls:
                found["walls, biaxial"] = between_walls(eta, seed, options)
            for geometry, row in found.items():
                table.append(dict(geometry=geometry, eta=eta, seed=seed, **row))
                print(ROW.format(**table[-1]), flush=True)
    files.write(options.out, files.table(COLUMNS, table))


script.run(main)
