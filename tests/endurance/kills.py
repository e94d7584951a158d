#!/usr/bin/env python3
"""SIGKILL at random moments: files stay whole, and resumed runs give the same results.

    scripts/lib/run python3 tests/endurance/kills.py writes 1000 runs 50 campaigns 5

writes     kills two processes that write the same files; each file must be one of its versions
runs       kills and resumes scripts/biaxial.py; compares the results of each complete run
campaigns  kills scripts/campaign three times and resumes it; compares runs and analysis
"""

import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

TESTS = pathlib.Path(__file__).resolve().parents[1]
SCRIPTS = TESTS.parent / "scripts"
sys.path[:0] = [str(TESTS), str(TESTS / "python")]

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process that forks has no other threads
import numpy as np
import synthetic
from rcr import problems, script
from rcr._data import files
from rcr.network import Network
from run_contents import campaign_contents, contents, different

# at rest after 255 steps
TEST = ["--eta", "0.5", "--particles", "60", "--seed", "2", "--strain", "0.1", "--networks", "40"]
CAMPAIGN = ["--particles", "60", "--etas", "0.5", "--seeds", "2", "--strain", "0.1"]


def quietly(command, **settings):
    return subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL,
                            stderr=subprocess.PIPE, text=True, **settings)


SIZES = 40, 400  # contacts and rows of the two versions of a file


def problem(version):
    rows = range(2 * SIZES[version])
    return problems.DelassusProblem((rows, rows, [1.0 + version] * len(rows)),
                                    [[-1.0, 0.0]] * SIZES[version], [0.5] * SIZES[version])


def writers(folder):
    """{path: (function that writes a version, function that fails on a damaged file)}."""
    rows = [[dict(x=version)] * size for version, size in enumerate(SIZES)]
    networks = [synthetic.packing(0.5, seed=version, particles_=30, contacts=size)
                for version, size in enumerate(SIZES)]
    steps = [problem(version) for version in (0, 1)]
    solutions = [problems.solve(step, "nlgs") for step in steps]
    contacts = lambda path: SIZES.index(len(Network.load(path).contacts["body1"]))

    def table(path):
        name, version, *more = path.read_text().split()
        assert name == "x" and more == [version] * (SIZES[int(version)] - 1)

    def reaction(path):
        with np.load(path) as file:
            return SIZES.index(len(file["reaction"]))

    return {
        folder / "network-0.1.h5": (lambda path, v: networks[v].save(path), contacts),
        folder / "history.csv": (lambda path, v: files.write(path, files.table(["x"], rows[v])),
                                 table),
        folder / "reaction.npz": (lambda path, v: solutions[v].save(path), reaction),
        folder / "problem.h5": (lambda path, v: problems.save(str(path), steps[v]),
                                lambda path: SIZES.index(problems.load(path).contacts)),
    }


def forked(work):
    """Id of a fork of this process, which does this endless work."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(1)
    return child


def kill_writes(count, folder, rng):
    made = writers(folder)

    def write_all(version):
        for path, (write, _) in made.items():
            write(path, version)

    def write_endlessly():
        while True:
            write_all(1)
            write_all(0)

    def read_all(when):
        for path, (_, read) in made.items():
            try:
                read(path)
            except Exception as error:
                raise SystemExit(f"kills.py: {path.name} was damaged {when}: {error}")

    def check_parts(most):
        parts = [path for path in folder.iterdir() if path not in made]
        if len(parts) > most:
            raise SystemExit(f"kills.py: kills have left {len(parts)} parts of files; wanted at "
                             f"most {most}")

    write_all(0)
    for _ in range(count):
        children = [forked(write_endlessly), forked(write_endlessly)]
        try:
            time.sleep(rng.uniform(0, 0.03))
            read_all("by two writers")
        finally:
            for child in children:
                os.kill(child, signal.SIGKILL)
            ends = [os.waitpid(child, 0)[1] for child in children]
        if not all(map(os.WIFSIGNALED, ends)):
            raise SystemExit("kills.py: a writer has failed before its kill")
        read_all("by a kill")
        check_parts(len(made))
    write_all(0)
    check_parts(0)
    return f"{count} times two SIGKILLs, {len(made)} kinds of files, all whole"


def biaxial(out):
    """Start a biaxial test, or resume it if its folder has a checkpoint."""
    resume = ["--resume"] if (out / "checkpoint.yade.gz").exists() else []
    return quietly(["yade", "-n", "-x", SCRIPTS / "biaxial.py", *TEST, "--out", out, *resume])


def killed_after(process, seconds):
    """True if the process still ran after these seconds and was killed; it alone."""
    try:
        process.wait(seconds)
        return False
    except subprocess.TimeoutExpired:
        process.kill()
        return True


def complete(process):
    errors = process.communicate()[1]
    if process.returncode:
        raise SystemExit(f"kills.py: {process.args[0]} ended with {process.returncode}: "
                         f"{errors.splitlines()[-1:]}")


def same(found, reference, what):
    names = different(found, reference)
    if names:
        raise SystemExit(f"kills.py: a killed {what} differs in {', '.join(names)} from one that "
                         f"was not killed")


def kill_runs(count, folder, rng):
    start = time.monotonic()
    complete(biaxial(folder / "straight"))
    seconds = time.monotonic() - start
    reference, out = contents(folder / "straight"), folder / "killed"
    kills = resumed = ends = 0
    while kills < count or out.exists():
        process = biaxial(out)
        resumed += "--resume" in process.args
        if killed_after(process, rng.uniform(0, seconds) if kills < count else None):
            kills += 1
            process.communicate()
            continue
        complete(process)
        same(contents(out), reference, "run")
        ends += 1
        shutil.rmtree(out)
    return f"{kills} SIGKILLs, {resumed} resumed, {ends} runs ended, all with equal results"


def campaign(out):
    return quietly([SCRIPTS / "campaign", *CAMPAIGN, "--out", out])


def kill_campaigns(count, folder, rng, times=3):
    start = time.monotonic()
    complete(campaign(folder / "straight"))
    seconds = time.monotonic() - start
    reference, kills = campaign_contents(folder / "straight"), 0
    for k in range(count):
        out = folder / f"killed-{k}"
        for _ in range(times):
            process = campaign(out)
            kills += killed_after(process, rng.uniform(0.1, 0.7) * seconds)
            process.communicate()  # Snakemake and the tests must end with it
        complete(campaign(out))
        same(campaign_contents(out), reference, "campaign")
        shutil.rmtree(out)
    return f"{count} campaigns, {kills} SIGKILLs, all with equal results"


KINDS = dict(writes=kill_writes, runs=kill_runs, campaigns=kill_campaigns)


def main(words=None):
    parser = script.Parser(prog="kills.py", description=__doc__)
    parser.add_argument("what", nargs="+", metavar="KIND COUNT",
                        help=f"{', '.join(KINDS)}, each with a count")
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    options = parser.parse_args(words)
    pairs = list(zip(options.what[::2], options.what[1::2]))
    if len(options.what) % 2 or not all(kind in KINDS and count.isdigit() and int(count) > 0
                                        for kind, count in pairs):
        parser.error(f"{' '.join(options.what)}: wanted pairs of one of {', '.join(KINDS)} and a "
                     f"count")
    for kind, count in pairs:
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            told = KINDS[kind](int(count), pathlib.Path(folder), random.Random(options.seed))
        print(f"{kind}: {told} ({time.monotonic() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
