"""Biaxial test of grains of several shapes: loose start, frictionless compaction, shear.

Run it with YADE:

scripts/yade-rcr -n -x scripts/biaxial.py --eta 0.5 --particles 400 --strain 0.3 --out out

It writes DIR/summary.json, DIR/history.csv, DIR/isotropic.h5, DIR/network-*.h5 and DIR/run.json
with the parameters. A test that jams restarts from the older of DIR/state-*.yade.gz
with a smaller time step. --resume continues from DIR/checkpoint.yade.gz. Ctrl-C, SIGTERM and
SIGHUP end the test after a checkpoint; after a SIGKILL the last checkpoint remains.
"""

import glob
import json
import math
import os
import sys
import time

from tqdm import tqdm

from rcr import script
from rcr._data import files, run_folder
from rcr.study import progress
from rcr.study.biaxial import Biaxial
from rcr.study.checkpoint import CHECKPOINT, NETWORKS, STATES, name_at, remove_later, states
from rcr.study.protocol import (DEFAULTS, FREE_PARAMETERS, HALF_RECORD, PROTOCOL, SHAPES,
                                check_networks, check_parameters, quick_averages)
from rcr.study.shear import share_done

BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} % [{elapsed}<{remaining}{postfix}]"
MADE = ["summary.json", CHECKPOINT, STATES, "history.csv", "isotropic.h5", NETWORKS]
OUTPUT = ["strain", "networks", "include_yielded"]  # options that change no record
RATE = "approach", "inertial_number"
RUN_SECONDS = 3.0  # aimed duration of a run of several records
NOTE_SECONDS = 0.2  # least time between two notes of the progress
CHECKPOINT_SECONDS = 60  # between checkpoints; at least 20 times that of writing one


def arguments():
    """Return the options of the command line, after a check of their combination."""
    number, integer = script.number(), script.integer()
    strain = script.number("0 < strain < 1", lambda v: 0 < v < 1)
    parser = script.Parser(prog="biaxial.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--eta", type=number, help="elongation (R - R')/R of circumscribed and inscribed circle, 0 "
        "= disc; not of --shape regular")
    add("--shape", choices=list(SHAPES),
        help="rounded-cap rectangle, regular polygon, truncated triangle, elongated hexagon, or "
        "three overlapping discs")
    add("--sides", type=integer, help="number of sides of --shape regular")
    add("--size-span", type=number, help="largest over smallest radius, uniform in volume fraction")
    add("--particles", type=integer, help="number of grains")
    add("--strain", type=strain, default=0.5, help="strain of the shear, (h0 - h)/h0")
    add("--seed", type=integer, help="seed of sizes, positions and directions")
    add("--friction", type=number, help="between grains during the shear")
    add("--rolling-friction", type=number,
        help="coefficient of rolling resistance between grains during the shear, of --shape rcr")
    add("--inertial-number", type=number, help="rate beyond --approach, times √(m/σ0)")
    add("--time-step", type=number,
        help="time step in √(m/σ0), shorter in quick shear; not of --law smooth")
    add("--approach", type=number,
        help="strain up to which the shear is quicker, with an inertial number of up to "
        f"{PROTOCOL.quick_inertial_number:g}")
    add("--sample-inertia", type=number,
        help="bound of ρ (v W/2h)²/σ0 beyond --approach, with v of the top wall, W and h of the "
        "box; lowers the rate of large samples")
    add("--threads", type=integer, help="threads of the contact solver (default: YADE's -j)")
    add("--tolerance", type=number, help="largest residual of the contact solver")
    add("--iterations", type=integer,
        help="most sweeps of the solver in a step of the shear (default: "
        f"{PROTOCOL.small_iterations} up to {PROTOCOL.small_particles} grains, "
        f"else {PROTOCOL.iterations})")
    add("--solver", help="nlgs, sor, nesterov, exact or auto")
    add("--law", choices=["cd", "smooth"], help="rigid contacts, or springs and dashpots")
    add("--stiffness", type=number, help="kn/σ0 of --law smooth")
    add("--networks", type=script.at_least(1), default=10,
        help="number of networks saved, at equal strains")
    add("--include-yielded", action="store_true",
        help="count records with a step without a solution in the means of summary.json")
    add("--out", type=script.folder, required=True, metavar="DIR",
        help="folder of the results, made if missing")
    add("--resume", action="store_true",
        help="continue from DIR's checkpoint; --strain, --networks, --include-yielded and "
        "--threads may differ")
    add("--overwrite", action="store_true", help="remove the results in DIR")
    parser.set_defaults(**DEFAULTS)
    options = parser.parse_args()
    if options.resume and options.overwrite:
        parser.error("--resume continues the run in DIR, --overwrite removes it: give one of them")
    if options.strain < PROTOCOL.record_strain:
        parser.error(f"--strain {options.strain}: expected at least {PROTOCOL.record_strain:g}, "
                     "the strain of a record of the history")
    check_networks(options.networks, options.strain)
    return options


class Checkpoints:
    """Saves the test at intervals, and when the user ends the script."""

    def __init__(self, test, options, stop):
        self.test, self.folder, self.end, self.stop = test, options.out, options.strain, stop
        self.next, self.noted = time.monotonic() + CHECKPOINT_SECONDS, 0.0

    def save(self, state=False):
        """Write a checkpoint now; keep it as a `state` to which the test may go back."""
        start = time.monotonic()
        self.test.save(self.folder, state)
        end = time.monotonic()
        self.next = end + max(CHECKPOINT_SECONDS, 20 * (end - start))

    def go_back(self, error):
        """Return the test to an earlier strain with a smaller time step, or raise the error."""
        test, stopped = self.test, self.test.strain
        last = test.progress["divisor"] == PROTOCOL.most_divisor
        if test.parameters["law"] != "cd" or last or not states(self.folder, stopped):
            raise error
        test.go_back(self.folder)
        message = (f"biaxial.py: the shear restarts from a strain of {test.strain:.4f} with "
                   f"1/{test.progress['divisor']} of the time step, since it stopped at "
                   f"{stopped:.4f}: {error}")
        tqdm.write(message, file=sys.stderr)
        self.save()
        remove_later(self.folder, test.strain)

    def update(self):
        """Note the progress and write a checkpoint, if due; end the script if the user asked."""
        if time.monotonic() > self.noted + NOTE_SECONDS:
            self.noted, test = time.monotonic(), self.test
            is_sheared = test.progress["phase"] == "shear"
            sheared = (test.strain, share_done(test, self.end)) if is_sheared else ()
            progress.write(self.folder, test.wall_seconds, *sheared)
        if self.stop.asked or time.monotonic() > self.next:
            self.save()
        if self.stop.asked:
            test = self.test
            place = f"a strain of {test.strain:.4f}" if test.rows else "the compaction"
            raise script.Stopped(f"stopped at {place}; continue with --resume", self.stop.number)


def compact(test, options, checkpoints):
    """Compact the packing, with a progress bar, and save its network."""
    with tqdm(desc="compaction", unit=" steps", disable=None) as bar:

        def report(test):
            bar.update()
            fraction, unbalance = test.packing_fraction, test.unbalance
            bar.set_postfix_str(f"packing fraction {fraction:.4f}, net force {unbalance:.1e}")
            if test.progress["phase"] != "shear":  # the last step is saved below
                checkpoints.update()

        test.compact(report)
    test.isotropic.save(os.path.join(options.out, "isotropic.h5"))
    checkpoints.save(state=True)


def shear(test, options, checkpoints):
    """Shear up to the strain; save a network and a checkpoint at equal strains."""
    due = lambda: math.floor((test.strain + HALF_RECORD) * options.networks / options.strain)
    most = 1  # records of a run of about RUN_SECONDS
    start, end = 100 * test.strain, 100 * options.strain
    style = dict(desc="shear", unit="%", disable=None, bar_format=BAR, ncols=progress.columns())
    with tqdm(total=end, initial=start, **style) as bar:
        while not test.has_reached(options.strain):
            saved, began, before = due(), time.monotonic(), len(test.rows)
            try:
                test.shear(most, (saved + 1) * options.strain / options.networks)
            except RuntimeError as error:
                checkpoints.go_back(error)
                continue
            seconds, records = time.monotonic() - began, len(test.rows) - before
            most = max(1, min(2 * records, int(records * RUN_SECONDS / seconds)))
            bar.n, row = 100 * test.strain, test.rows[-1]
            bar.set_postfix_str(f"q/p {row['sin_phi']:.3f}, {row['iterations']} iterations")
            if due() > saved:
                name = name_at(NETWORKS, test.strain)
                test.network().save(os.path.join(options.out, name))
                if test.has_reached(test.progress["failed_strain"]):
                    test.progress["divisor"] = 1
                checkpoints.save(state=True)
            checkpoints.update()


def load(options, parameters):
    """Return the test of the folder's checkpoint; a ValueError if the options do not fit to it."""
    folder, again = options.out, "start again with --overwrite"
    test = Biaxial.load(folder)
    other = run_folder.differing(test.parameters, parameters, FREE_PARAMETERS)
    if other:
        given = f"--resume: the checkpoint in {folder} has {other}"
        raise ValueError(f"{given}; give its options, or {again}")
    record = run_folder.read(folder)
    if record is None or "networks" not in record["parameters"]:
        raise ValueError(f"--resume: {folder} has no run.json of this script; {again}")
    remove_later(folder, test.strain)  # of a part that go_back abandoned before a kill
    networks = record["parameters"]["networks"], len(glob.glob(NETWORKS, root_dir=folder))
    if test.progress["phase"] == "shear" and test.has_reached(options.strain):
        if test.strain > options.strain + HALF_RECORD:
            given = f"--resume: the test in {folder} is at a strain of {test.strain:.4f}"
            beyond = f"beyond --strain {options.strain:g}; give no less than it has"
            raise ValueError(f"{given}, {beyond}, or {again}")
        if options.networks not in networks:  # the record may be of a killed extension
            given = f"--resume: the test in {folder} has reached its strain"
            raise ValueError(f"{given} with --networks {networks[1]}; give that, or {again}")
    test.parameters["threads"] = test.solver.threads = parameters["threads"]
    return test


def write_summary(test, options):
    """Write summary.json and print its line."""
    summary = test.summary(options.include_yielded)
    path = os.path.join(options.out, "summary.json")
    files.write(path, json.dumps(summary, indent=2, allow_nan=False) + "\n")
    ratio = "unknown" if summary["sin_phi"] is None else f"{summary['sin_phi']:.3f}"
    line = f"{path}: q/p = {ratio}, packing fraction {summary['packing_fraction_final']:.3f}"
    if summary["yielded_steps"]:
        left_out = f"{summary['records_left_out']} of {summary['records']} records left out"
        line += f"; {summary['yielded_steps']} steps without a solution, {left_out} of q/p"
    print(line)


def main():
    options = arguments()
    no_parameters = ("out", "resume", "overwrite", *OUTPUT)
    given = {name: value for name, value in vars(options).items() if name not in no_parameters}
    parameters = check_parameters(**given)
    recorded = parameters | dict(protocol=PROTOCOL.identity) | {
        name: getattr(options, name) for name in OUTPUT}
    folder = run_folder.claim_folder(
        options.out, "biaxial.py", recorded, MADE, free=[*FREE_PARAMETERS, *OUTPUT],
        checkpoint=CHECKPOINT, last="summary.json", resume=options.resume,
        overwrite=options.overwrite)
    with script.stoppable() as stop, folder as begin:
        test = load(options, parameters) if options.resume else Biaxial.prepare(**parameters)
        begin()
        warning = quick_averages(options.strain, *(parameters[name] for name in RATE))
        if warning:
            print(f"biaxial.py: {warning}", file=sys.stderr)
        checkpoints = Checkpoints(test, options, stop)
        try:
            if test.progress["phase"] != "shear":
                compact(test, options, checkpoints)
            shear(test, options, checkpoints)
            write_summary(test, options)
        finally:
            progress.remove(options.out)


script.run(main)
