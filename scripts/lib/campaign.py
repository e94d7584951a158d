"""Biaxial tests over elongations and seeds on all processors, then the analysis with every figure of the paper and a report.

A campaign that was stopped, even killed, goes on from its checkpoints when the same command is given again, to the same results.
What follows a lone -- goes to Snakemake.
"""

import argparse
import fcntl
import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent


def numbers(kind):
    """A parser of lists such as 0,0.1,0.2."""

    def parse(text):
        return [kind(word) for word in text.replace(",", " ").split()]

    parse.__name__ = f"list of {kind.__name__}"
    return parse


def arguments():
    words = sys.argv[1:]
    own, extra = (words[: words.index("--")], words[words.index("--") + 1 :]) if "--" in words else (words, [])
    parser = argparse.ArgumentParser(prog="campaign", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=13000, metavar="N", help="grains of each test (default %(default)s)")
    parser.add_argument("--etas", type=numbers(float), nargs="+", metavar="ETA", default=[[0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]],
                        help="elongations, with commas or spaces between them (default 0,0.1,…,0.7)")  # fmt: skip
    parser.add_argument("--seeds", type=numbers(int), nargs="+", metavar="SEED", default=[[1]], help="seeds, likewise (default 1)")
    parser.add_argument("--strain", type=float, default=0.5, metavar="E", help="of the shear (default %(default)s)")
    processors = len(os.sched_getaffinity(0))
    parser.add_argument("--jobs", type=int, default=processors, metavar="N", help="processors to use (default all: %(default)s)")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the runs and the report, made if missing")
    options = parser.parse_args(own)
    options.etas = sorted({eta for part in options.etas for eta in part})
    options.seeds = sorted({seed for part in options.seeds for seed in part})
    for fits, message in (
        (options.particles >= 10, f"--particles {options.particles}: wanted at least 10"),
        (options.etas and all(0 <= eta < 1 for eta in options.etas), f"--etas {options.etas}: wanted elongations 0 ≤ ETA < 1"),
        (options.seeds and all(seed >= 0 for seed in options.seeds), f"--seeds {options.seeds}: wanted seeds ≥ 0"),
        (0 < options.strain < 1, f"--strain {options.strain}: wanted 0 < strain < 1"),
        (options.jobs >= 1, f"--jobs {options.jobs}: wanted at least 1"),
    ):
        if not fits:
            parser.error(message)
    return options, extra


def command(options, extra):
    """Snakemake's. It dies with this process, and its jobs with it; its own lock outlives a kill, ours does not, hence --nolock."""
    threads = max(1, options.jobs // (len(options.etas) * len(options.seeds)))
    config = {
        "particles": options.particles,
        "strain": options.strain,
        "etas": ",".join(f"{eta:g}" for eta in options.etas),
        "seeds": ",".join(map(str, options.seeds)),
        "threads": threads,
    }
    return [
        *("setpriv", "--pdeathsig", "KILL", "snakemake", "--snakefile", str(HERE / "campaign.smk"), "--directory", options.out),
        *("--cores", str(options.jobs), "--scheduler", "greedy", "--keep-going", "--rerun-incomplete", "--nolock", "--quiet", "rules"),
        *("--config", *(f"{name}={value}" for name, value in config.items())),
        *extra,
    ]


def last_line(path):
    return (path.read_text(errors="replace").strip().splitlines() or [""])[-1]


def failure(out):
    """One line on the runs that failed: the last line of each of their logs."""
    failed = [path for path in sorted(out.glob("runs/*/log")) if not (path.parent / "summary.json").exists()]
    reasons = "; ".join(f"{path}: {last_line(path)}" for path in failed)
    what = f": {reasons}; scripts/network.py analyses the tests that are complete" if reasons else ", see above"
    return f"not complete{what}; the same command goes on from here"


def main():
    options, extra = arguments()
    if not shutil.which("snakemake"):
        sys.exit("campaign: the package snakemake is not installed here; install it (apt-get install snakemake) and run this again")
    out = pathlib.Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    with open(out / ".lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sys.exit(f"campaign: another campaign runs in {out}; wait for it or choose another --out")
        run = subprocess.run(command(options, extra), stdout=sys.stderr)
    if run.returncode:
        sys.exit(f"campaign: {failure(out)}")
    if "--dry-run" not in extra:
        print(out / last_line(out / "report" / "log"))


try:
    main()
except OSError as error:
    sys.exit(f"campaign: {error}")
except KeyboardInterrupt:
    sys.exit("campaign: stopped; the same command goes on from here")
