"""Biaxial test of rounded-cap rectangles: loose start, frictionless isotropic compaction, shear.

Run it with YADE:  scripts/yade-rcr -n -x scripts/biaxial.py --eta 0.5 --particles 400 --strain 0.1 --out out
Writes DIR/summary.json, DIR/history.csv, DIR/isotropic.h5 and DIR/network-*.h5; DIR/checkpoint.yade.gz is for --resume, DIR/run.json tells
whose results these are. Ctrl-C stops it after a checkpoint, a kill at the last one.
"""

import json
import math
import os
import sys
import time

from tqdm import tqdm

from rcr import _files as files, _results as results, script
from rcr.study.biaxial import CHECKPOINT, FREE, INERTIAL_NUMBER, QUASI_STATIC, RECORD, SHEAR_ITERATIONS, STIFFNESS, TIME_STEP, Biaxial, checked

BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} % [{elapsed}<{remaining}{postfix}]"
MADE = ["summary.json", CHECKPOINT, "history.csv", "isotropic.h5", "network-*.h5"]
QUICK = dict(inertial_number=INERTIAL_NUMBER, time_step=TIME_STEP, approach=0.0, overdamped=False)
INERTIA_TOLD = 0.02  # sample inertia over σ₀ at the last strain from which on it is told: the forces at the walls differ by so much
HOW_LONG = ["strain", "networks"]  # how far the test goes and what is saved on the way: no part of what it is
RUN = 3.0  # seconds of one run, of as many records as these are
PAUSE = 60  # seconds between two checkpoints at most, and 20 times as long as one takes at least


def arguments():
    number, whole = script.number(), script.integer()
    parser = script.Parser(prog="biaxial.py", description=__doc__.splitlines()[0])
    parser.add_argument("--eta", type=number, default=0.5, help="elongation (R - R')/R, 0 = disc (default %(default)s)")
    parser.add_argument("--particles", type=whole, default=1000, help="number of grains (default %(default)s)")
    parser.add_argument("--strain", type=script.number("0 < strain < 1", lambda v: 0 < v < 1), default=0.5, help="strain of the shear, (h0 - h)/h0 (default %(default)s)")
    parser.add_argument("--seed", type=whole, default=1, help="of sizes, places and orientations (default %(default)s)")
    parser.add_argument("--friction", type=number, default=0.5, help="between grains during shear (default %(default)s)")
    parser.add_argument("--inertial-number", type=number, help=f"rate of the shear times √(m/σ0) (default {INERTIAL_NUMBER:g})")
    parser.add_argument("--time-step", type=number, help=f"of the shear, over √(m/σ0); the smooth law's follows from its stiffness (default {TIME_STEP:g})")
    parser.add_argument("--approach", type=number, help=f"strain up to which the shear is made at {INERTIAL_NUMBER:g} if --inertial-number is lower (default 0)")
    parser.add_argument("--overdamped", action="store_true", default=None, help="shear without inertia: each step of the strain I dt/t0 starts from rest")
    slow = " ".join(f"--{name.replace('_', '-')}" + f" {value:g}" * (value is not True) for name, value in QUASI_STATIC.items())
    parser.add_argument("--quasi-static", action="store_true", help=f"shear as slowly as averages need that do not know the rate: {slow}")
    parser.add_argument("--threads", type=whole, default=0, help="of the contact solver (default: as YADE's -j)")
    parser.add_argument("--tolerance", type=number, default=1e-4, help="residual of the contact solver (default %(default)s)")
    parser.add_argument("--iterations", type=whole, default=SHEAR_ITERATIONS, help="of the solver in a step of the shear at most (default %(default)s)")
    parser.add_argument("--solver", default="auto", help="nlgs, sor, nesterov, exact or auto (default %(default)s)")
    parser.add_argument("--law", choices=["cd", "smooth"], default="cd", help="rigid contacts, or springs and dashpots (default %(default)s)")
    parser.add_argument("--stiffness", type=number, default=STIFFNESS, help="kn/σ0 of the smooth law (default %(default)s)")
    parser.add_argument("--networks", type=script.at_least(1), default=10, help="number of networks saved, at equal strains (default %(default)s)")
    parser.add_argument("--out", type=script.folder, required=True, metavar="DIR", help="folder of the results, made if missing")
    parser.add_argument("--resume", action="store_true", help="go on from DIR's checkpoint; --strain, --networks and --threads may be others than before")
    parser.add_argument("--overwrite", action="store_true", help="remove the results that are in DIR")
    options = parser.parse_args()
    if options.resume and options.overwrite:
        parser.error("--resume goes on with the run in DIR, --overwrite removes it: wanted one of them")
    for name, value in (QUICK | QUASI_STATIC if options.quasi_static else QUICK).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    if options.approach >= options.strain:
        parser.error(f"--approach {options.approach:g}: wanted less than --strain {options.strain:g}; --approach 0 shears slowly from the start")
    if options.strain < RECORD:
        parser.error(f"--strain {options.strain}: wanted at least {RECORD:g}, that of a record of the history")
    return options


class Checkpoints:
    """When the test is saved, besides at its networks: every minute, and where the user asks for the end."""

    def __init__(self, test, folder, stop):
        self.test, self.folder, self.stop = test, folder, stop
        self.next = time.monotonic() + PAUSE

    def save(self):
        start = time.monotonic()
        self.test.save(self.folder)
        end = time.monotonic()
        self.next = end + max(PAUSE, 20 * (end - start))

    def pause(self):
        """After every step of the compaction and every record of the shear: what is saved here goes on to the same bits."""
        if self.stop.asked or time.monotonic() > self.next:
            self.save()
        if self.stop.asked:
            at = f"a strain of {self.test.strain:.4f}" if self.test.rows else "the compaction"
            raise script.Stopped(f"stopped at {at}; --resume goes on from there")


def compact(test, options, checkpoints):
    with tqdm(desc="compaction", unit=" steps", disable=None) as bar:

        def report(test):
            bar.update()
            bar.set_postfix_str(f"packing fraction {test.packing_fraction:.4f}, net force {test.unbalance:.1e}")
            if test.progress["phase"] != "shear":  # its last step is saved below, with its network
                checkpoints.pause()

        test.compact(report)
    test.isotropic.save(os.path.join(options.out, "isotropic.h5"))
    checkpoints.save()


def tell_inertia(test, strain):
    """A line on stderr where the sample will be too wide for its rate."""
    share = test.sample_inertia(strain)[0]
    if share > INERTIA_TOLD:
        fits = test.parameters["inertial_number"] * math.sqrt(0.5 * INERTIA_TOLD / share)
        tqdm.write(
            f"biaxial.py: at a strain of {strain:g} the inertia of the sample, ρ (ε̇ W)², is {share:.2g} of the confining stress, by which the fixed side"
            f" wall feels more than the free one; --inertial-number {fits:.1g} makes it {100 * 0.5 * INERTIA_TOLD:g} %",
            file=sys.stderr,
        )


def shear(test, options, checkpoints):
    """Records of 0.1 % of strain up to the strain asked for, a network and a checkpoint at equal strains."""
    tell_inertia(test, options.strain)
    due = lambda: math.floor((test.strain + 0.5 * RECORD) * options.networks / options.strain)
    most = 1  # records of a run, which takes some `RUN`
    with tqdm(desc="shear", total=100 * options.strain, initial=100 * test.strain, unit="%", disable=None, bar_format=BAR) as bar:
        while test.strain < options.strain - 0.5 * RECORD:
            saved, began = due(), time.monotonic()
            left = (saved + 1) * options.strain / options.networks - 0.5 * RECORD - test.strain
            records = max(1, min(most, math.ceil(left / test.strain_a_record - 1e-6)))
            test.shear(records)
            most = max(1, min(2 * records, int(records * RUN / (time.monotonic() - began))))
            bar.n = 100 * test.strain
            bar.set_postfix_str(f"q/p {test.rows[-1]['sin_phi']:.3f}, {test.rows[-1]['iterations']} iterations")
            if due() > saved:
                test.network().save(os.path.join(options.out, f"network-{test.strain:.4f}.h5"))
                checkpoints.save()
            checkpoints.pause()


def load(options, parameters):
    """The test of the folder's checkpoint, refused if its parameters are others."""
    test = Biaxial.load(options.out)
    other = results.differing(test.parameters, parameters, FREE)
    if other:
        raise ValueError(f"--resume: the checkpoint in {options.out} has {other}; give its options, or start anew with --overwrite")
    made = results.read(options.out)["parameters"]["networks"]
    if test.progress["phase"] == "shear" and test.strain > options.strain - 0.5 * RECORD:
        if test.strain > options.strain + 0.5 * RECORD:
            raise ValueError(f"--resume: the test in {options.out} is at a strain of {test.strain:.4f}, beyond --strain {options.strain:g}; give no less than it has, or start anew with --overwrite")
        if options.networks != made:
            raise ValueError(f"--resume: the test in {options.out} has reached its strain with --networks {made}; give that, or start anew with --overwrite")
    test.parameters["threads"] = test.solver.threads = parameters["threads"]
    return test


def main():
    options = arguments()
    parameters = checked(**{name: value for name, value in vars(options).items() if name not in ("out", "resume", "overwrite", "quasi_static", *HOW_LONG)})
    told = dict(parameters, strain=options.strain, networks=options.networks)
    how = dict(free=[*FREE, *HOW_LONG], checkpoint=CHECKPOINT, last="summary.json", resume=options.resume, overwrite=options.overwrite)
    with script.stoppable() as stop, results.claim_folder(options.out, "biaxial.py", told, MADE, **how) as begin:
        test = load(options, parameters) if options.resume else Biaxial.prepare(**parameters)
        begin()
        checkpoints = Checkpoints(test, options.out, stop)
        if test.progress["phase"] != "shear":
            compact(test, options, checkpoints)
        shear(test, options, checkpoints)
        summary = test.summary()
        path = os.path.join(options.out, "summary.json")
        files.write(path, json.dumps(summary, indent=2, allow_nan=False) + "\n")
    print(f"{path}: q/p = {summary['sin_phi']:.3f}, packing fraction {summary['packing_fraction_final']:.3f}")


script.run(main)
