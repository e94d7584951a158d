"""Compaction and shear in a periodic cell, without walls, and, if asked, the biaxial test between walls beside it; table and CSV.

Between walls the packing fraction is that of the inside, 3 diameters and more away from them: grains lie looser at a wall.

Run it with YADE:  scripts/yade-rcr -n -x scripts/cell_shear.py --etas 0 0.5 --seeds 3 --walls --out cell-shear.csv
"""

import math

import numpy as np
from tqdm import tqdm

import rcr
from rcr import _files as files, script
from rcr.study.biaxial import DENSITY, QUASI_STATIC, Biaxial, O
from rcr.study.cell import MODES, CellTest

COLUMNS = "geometry eta seed packing_fraction_initial sin_phi sin_phi_error packing_fraction a_c_half a_c_weak".split()
STATIONARY = 0.1  # strain from which averages are taken
WEAK = 0.5, 1.0  # ξ of a_c_half and a_c_weak
EVERY = 0.01  # strain between two networks
FEWEST_BETWEEN_WALLS = 400  # grains in a box 20 diameters wide: up to 6 from each wall are left out


def arguments():
    number, whole = script.number(), script.integer()
    parser = script.Parser(prog="cell_shear.py", description=__doc__.splitlines()[0])
    parser.add_argument("--etas", type=number, nargs="+", default=[0, 0.5], help="elongations (default 0 0.5)")
    parser.add_argument("--seeds", type=script.at_least(1), default=3, help="packings of each (default %(default)s)")
    parser.add_argument("--modes", choices=MODES, nargs="+", default=list(MODES), help="of the shear (default: both)")
    parser.add_argument("--walls", action="store_true", help="the biaxial test between walls, too")
    parser.add_argument("--particles", type=whole, default=1000, help="number of grains (default %(default)s)")
    parser.add_argument("--strain", type=script.number("0.15 ≤ strain < 1", lambda v: STATIONARY + 5 * EVERY <= v < 1), default=0.3, help="at the end (default %(default)s); averages from 0.1 on")
    parser.add_argument("--inertial-number", type=number, default=1e-3, help="rate times √(m/σ0) (default %(default)s)")
    parser.add_argument("--time-step", type=number, default=0.1, help="over √(m/σ0) (default %(default)s)")
    slow = " ".join(f"--{name.replace('_', '-')} {value:g}" for name, value in QUASI_STATIC.items() if name != "overdamped")
    parser.add_argument("--quasi-static", action="store_true", help=f"shear without inertia, with {slow}")
    parser.add_argument("--out", type=script.new_file, default="cell-shear.csv", metavar="FILE", help="CSV (default %(default)s)")
    options = parser.parse_args()
    if options.walls and options.particles < FEWEST_BETWEEN_WALLS:
        parser.error(f"--walls with --particles {options.particles}: wanted at least {FEWEST_BETWEEN_WALLS}, of which some are far from all walls")
    if options.quasi_static:
        vars(options).update(QUASI_STATIC)
    options.pace = dict(inertial_number=options.inertial_number, time_step=options.time_step, overdamped=options.quasi_static)
    return options


def average(strain, values):
    """Mean from `STATIONARY` on, and its error from means over a fifth of the values each."""
    late = np.array_split(np.asarray(values)[np.asarray(strain) > STATIONARY], 5)
    means = [part.mean() for part in late]
    return np.mean(means), np.std(means, ddof=1) / math.sqrt(len(means))


def told(first, strain, sin_phi, packing_fraction, weak):
    """A row; `weak`: strain and a_c(ξ) for `WEAK` of each network."""
    late = [a_c for at, a_c in weak if at > STATIONARY]
    return dict(
        packing_fraction_initial=first, **dict(zip(("sin_phi", "sin_phi_error"), average(strain, sin_phi))),
        packing_fraction=average(strain, packing_fraction)[0], **dict(zip(("a_c_half", "a_c_weak"), np.mean(late, axis=0))),
    )  # fmt: skip


def in_cell(mode, eta, seed, options):
    test = CellTest(eta, options.particles, seed, **options.pace)
    test.compact()
    first, weak = test.packing_fraction, []
    with tqdm(desc=f"{mode}, η = {eta:g}", total=options.strain, disable=None) as bar:

        def look(test, row):
            weak.append((row["strain"], rcr.contact_network().anisotropies(WEAK)[0]))
            bar.update(row["strain"] - bar.n)

        rows = test.shear(mode, options.strain, look, EVERY)
    return told(first, rows["strain"], rows["sin_phi"], rows["packing_fraction"], weak)


def inner_fraction(test):
    """Packing fraction away from the walls: grains with their centres in windows that end 3 to 6 diameters before them, the mean of ten."""
    states = [O.bodies[i].state for i in test.grains]
    at, areas = np.array([(s.pos[0], s.pos[1]) for s in states]), np.array([s.mass for s in states]) / DENSITY
    low = np.array([O.bodies[test.left].state.pos[0], O.bodies[test.bottom].state.pos[1]])
    high = np.array([O.bodies[test.right].state.pos[0], O.bodies[test.top].state.pos[1]])
    found = []
    for margin in np.linspace(3, 6, 10) * test.diameter:
        inside = ((at > low + margin) & (at < high - margin)).all(axis=1)
        found.append(areas[inside].sum() / np.prod(high - low - 2 * margin))
    return np.mean(found)


def between_walls(eta, seed, options):
    test = Biaxial.prepare(eta=eta, particles=options.particles, seed=seed, threads=1, **options.pace)
    test.compact()
    first, inner, weak = inner_fraction(test), [], []
    while test.strain < options.strain:
        test.shear_record()
        inner.append(inner_fraction(test))
        if test.strain > EVERY * (len(weak) + 1):
            weak.append((test.strain, test.network().anisotropies(WEAK)[0]))
    column = lambda name: [row[name] for row in test.rows]
    return told(first, column("strain"), column("sin_phi"), inner, weak)


def main():
    options = arguments()
    table = []
    print("| geometry | η | seed | packing fraction at first | q/p | packing fraction | a_c(0.5) | a_c(1) |\n" + "|---" * 8 + "|")
    for eta in options.etas:
        for seed in range(1, options.seeds + 1):
            found = {f"cell, {mode}": in_cell(mode, eta, seed, options) for mode in options.modes}
            if options.walls:
                found["walls, biaxial"] = between_walls(eta, seed, options)
            for geometry, row in found.items():
                table.append(dict(geometry=geometry, eta=eta, seed=seed, **row))
                print("| {geometry} | {eta:g} | {seed} | {packing_fraction_initial:.4f} | {sin_phi:.3f} ± {sin_phi_error:.3f} | {packing_fraction:.4f} | {a_c_half:.3f} | {a_c_weak:.3f} |".format(**table[-1]), flush=True)
    files.write(options.out, files.table(COLUMNS, table))


script.run(main)
