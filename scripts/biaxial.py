"""Biaxial test of rounded-cap rectangles: loose start, frictionless isotropic compaction, shear.

Run it with YADE:  scripts/yade-rcr -n -x scripts/biaxial.py --eta 0.5 --particles 400 --strain 0.1 --out out
Writes DIR/summary.json, DIR/history.csv, DIR/isotropic.h5 and DIR/network-*.h5; DIR/checkpoint.yade.gz is for --resume.
"""

import argparse
import json
import os
import sys

from tqdm import tqdm

from rcr.biaxial import INERTIAL_NUMBER, RECORD, SHEAR_ITERATIONS, STIFFNESS, TIME_STEP, Biaxial

BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} % [{elapsed}<{remaining}{postfix}]"


def arguments():
    parser = argparse.ArgumentParser(prog="biaxial.py", description=__doc__.splitlines()[0])
    parser.add_argument("--eta", type=float, default=0.5, help="elongation (R - R')/R, 0 = disc (default %(default)s)")
    parser.add_argument("--particles", type=int, default=1000, help="number of grains (default %(default)s)")
    parser.add_argument("--strain", type=float, default=0.5, help="strain of the shear, (h0 - h)/h0 (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of sizes, places and orientations (default %(default)s)")
    parser.add_argument("--friction", type=float, default=0.5, help="between grains during shear (default %(default)s)")
    parser.add_argument("--inertial-number", type=float, default=INERTIAL_NUMBER, help="rate of the shear times √(m/σ0) (default %(default)s)")
    parser.add_argument("--time-step", type=float, default=TIME_STEP, help="of the shear, over √(m/σ0); the smooth law's follows from its stiffness (default %(default)s)")
    parser.add_argument("--threads", type=int, default=0, help="of the contact solver (default: as YADE's -j)")
    parser.add_argument("--tolerance", type=float, default=1e-4, help="residual of the contact solver (default %(default)s)")
    parser.add_argument("--iterations", type=int, default=SHEAR_ITERATIONS, help="of the solver in a step of the shear at most (default %(default)s)")
    parser.add_argument("--solver", default="auto", help="nlgs, sor, nesterov, exact or auto (default %(default)s)")
    parser.add_argument("--law", choices=["cd", "smooth"], default="cd", help="rigid contacts, or springs and dashpots (default %(default)s)")
    parser.add_argument("--stiffness", type=float, default=STIFFNESS, help="kn/σ0 of the smooth law (default %(default)s)")
    parser.add_argument("--networks", type=int, default=10, help="number of networks saved, at equal strains (default %(default)s)")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the results, made if missing")
    parser.add_argument("--resume", action="store_true", help="go on from DIR's checkpoint")
    options = parser.parse_args()
    if not 0 < options.strain < 1:
        parser.error(f"--strain {options.strain}: wanted 0 < strain < 1")
    if options.networks < 1:
        parser.error(f"--networks {options.networks}: wanted at least 1")
    return options


def compact(test, options):
    with tqdm(desc="compaction", unit=" steps", disable=None) as bar:

        def report(test):
            bar.update()
            bar.set_postfix_str(f"packing fraction {test.packing_fraction:.4f}, net force {test.solver.unbalance:.1e}")

        test.compact(report)
    test.network().save(os.path.join(options.out, "isotropic.h5"))
    test.save(options.out)


def shear(test, options):
    """Records of 0.1 % of strain up to the strain asked for, a network and a checkpoint at equal strains."""
    saved = int(test.strain * options.networks / options.strain + 0.5)
    with tqdm(desc="shear", total=100 * options.strain, initial=100 * test.strain, unit="%", disable=None, bar_format=BAR) as bar:
        while test.strain < options.strain - 0.5 * RECORD:
            test.shear_record()
            bar.n = 100 * test.strain
            bar.set_postfix_str(f"q/p {test.rows[-1]['sin_phi']:.3f}, {test.rows[-1]['iterations']} iterations")
            if test.strain >= (saved + 1) * options.strain / options.networks - 0.5 * RECORD:
                saved += 1
                test.network().save(os.path.join(options.out, f"network-{test.strain:.4f}.h5"))
                test.save(options.out)


def main():
    options = arguments()
    os.makedirs(options.out, exist_ok=True)
    if options.resume:
        test = Biaxial.load(options.out)
    else:
        test = Biaxial.prepare(
            options.eta,
            options.particles,
            options.seed,
            options.friction,
            options.tolerance,
            options.solver,
            options.threads,
            options.inertial_number,
            options.time_step,
            options.law,
            options.stiffness,
            options.iterations,
        )
    if test.progress["phase"] != "shear":
        compact(test, options)
    shear(test, options)
    summary = test.summary()
    path = os.path.join(options.out, "summary.json")
    with open(path + ".part", "w") as file:
        json.dump(summary, file, indent=2)
    os.replace(path + ".part", path)
    print(f"{path}: q/p = {summary['sin_phi']:.3f}, packing fraction {summary['packing_fraction_final']:.3f}")


try:
    main()
except (ValueError, RuntimeError, OSError) as error:
    print(f"biaxial.py: {error}", file=sys.stderr)
    os._exit(1)  # YADE's own exit would forget the code
