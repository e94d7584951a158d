"""Biaxial tests over elongations and seeds on all processors, then the analysis with every figure of the paper and a report.

A campaign that was stopped, even killed, goes on from its checkpoints when the same command is given again, to the same results.
What follows a lone -- goes to Snakemake.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys

from rcr import _results as results, script

HERE = pathlib.Path(__file__).resolve().parent


def numbers(kind):
    """A parser of lists such as 0,0.1,0.2."""

    def parse(text):
        return [kind(word) for word in text.replace(",", " ").split()]

    return parse


def arguments():
    words = sys.argv[1:]
    own, extra = (words[: words.index("--")], words[words.index("--") + 1 :]) if "--" in words else (words, [])
    parser = script.Parser(prog="campaign", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=script.at_least(10), default=13000, metavar="N", help="grains of each test (default %(default)s)")
    elongation = script.number("elongations 0 ≤ ETA < 1", lambda v: 0 <= v < 1)
    parser.add_argument("--etas", type=numbers(elongation), nargs="+", metavar="ETA", default=[[0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]],
                        help="elongations, with commas or spaces between them (default 0,0.1,…,0.7)")  # fmt: skip
    parser.add_argument("--seeds", type=numbers(script.integer("seeds ≥ 0", lambda v: v >= 0)), nargs="+", metavar="SEED", default=[[1]], help="seeds, likewise (default 1)")
    parser.add_argument("--strain", type=script.number("0 < strain < 1", lambda v: 0 < v < 1), default=0.5, metavar="E", help="of the shear (default %(default)s)")
    parser.add_argument("--networks", type=script.at_least(1), default=10, metavar="N", help="snapshots of each test, at equal strains (default %(default)s)")
    parser.add_argument("--quasi-static", action="store_true", help="shear without inertia, as scripts/biaxial.py --quasi-static: averages hardly know the rate")
    processors = len(os.sched_getaffinity(0))
    parser.add_argument("--jobs", type=script.at_least(1), default=processors, metavar="N", help="processors to use (default all: %(default)s)")
    parser.add_argument("--out", type=script.folder, required=True, metavar="DIR", help="folder of the runs and the report, made if missing")
    options = parser.parse_args(own)
    for name in "etas", "seeds":
        values = sorted({value for part in getattr(options, name) for value in part})
        if not values:
            parser.error(f"--{name}: wanted at least one")
        setattr(options, name, values)
    return options, extra


def command(options, extra):
    """Snakemake's. It dies with this process, and its jobs with it; its own lock outlives a kill, ours does not, hence --nolock."""
    threads = min(1024, max(1, options.jobs // (len(options.etas) * len(options.seeds))))
    config = {
        "particles": options.particles,
        "strain": options.strain,
        "etas": ",".join(repr(eta).removesuffix(".0") for eta in options.etas),
        "seeds": ",".join(map(str, options.seeds)),
        "threads": threads,
        "networks": options.networks,
        "quasi_static": int(options.quasi_static),
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


def check_networks(out, options):
    """Raises ValueError where a run of this campaign is there with another number of networks, which its name does not tell."""
    for path in sorted(out.glob("runs/*/run.json")):
        made = results.read(path.parent)["parameters"]
        same = made["particles"] == options.particles and made["strain"] == options.strain and made["overdamped"] == options.quasi_static
        if same and made["eta"] in options.etas and made["seed"] in options.seeds and made["networks"] != options.networks:
            raise ValueError(f"{path.parent} is made with --networks {made['networks']}, and this is --networks {options.networks}; wanted the same, or another --out")


def main():
    options, extra = arguments()
    if not shutil.which("snakemake"):
        raise RuntimeError("the package snakemake is not installed here; install it (apt-get install snakemake) and run this again")
    out = pathlib.Path(options.out)
    check_networks(out, options)
    parameters = {name: getattr(options, name) for name in ("particles", "etas", "seeds", "strain", "networks", "quasi_static")}
    with results.claim_folder(out, "campaign", parameters, [], free=list(parameters), resume=True) as begin:
        begin()  # one folder may hold several campaigns: the names of its runs tell their parameters
        try:
            run = subprocess.run(command(options, extra), stdout=sys.stderr)
        except KeyboardInterrupt:
            raise script.Stopped("stopped; the same command goes on from here") from None
    if run.returncode:
        raise RuntimeError(failure(out))
    if "--dry-run" not in extra:
        print(out / last_line(out / "report" / "log"))


script.run(main)
