"""Biaxial tests over kinds of grains and seeds on all processors, then their analysis and report.

After a stop or a kill the same command continues from the checkpoints, to the same results.
Options after a lone -- go to Snakemake.
"""

import itertools
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

import campaign_runs
from campaign_progress import Progress, Test, show
from rcr import papers, script
from rcr._data import run_folder
from rcr.study.protocol import PROTOCOL, SHAPES, check_networks, check_parameters

HERE = pathlib.Path(__file__).resolve().parent
CONTINUE = "continue with the same command"
UNKNOWN = "not complete, see above"  # the reason is in the messages of Snakemake
QUICK = dict(particles=300, etas=[[0, 0.4, 0.7]], strain=0.3, networks=6, out="out/quick")
FREE = ("particles", "etas", "sides", "rolling_friction", "seeds", "strain", "paper",
        *campaign_runs.OPTIONAL)


def numbers(kind):
    """Return a parser of lists such as 0,0.1,0.2."""
    return lambda text: [kind(word) for word in text.replace(",", " ").split()]


def arguments():
    """Return the options of the command line and those for Snakemake."""
    parser = script.Parser(prog="campaign", description=__doc__)
    elongation = script.number("elongations 0 ≤ ETA < 1", lambda v: 0 <= v < 1)
    seed = script.integer("seeds ≥ 0", lambda v: v >= 0)
    strain = script.number("0 < strain < 1", lambda v: 0 < v < 1)
    positive = script.number("a number > 0, at most 10", lambda v: 0 < v <= 10)
    friction = script.number("a coefficient > 0, at most 100", lambda v: 0 < v <= 100)
    span = script.number("a ratio R_max/R_min from 1 to 100", lambda v: 1 <= v <= 100)
    rolling = script.number("coefficients of rolling resistance from 0 to 1", lambda v: 0 <= v <= 1)
    processors = len(os.sched_getaffinity(0))
    add = parser.add_argument
    add("--quick", action="store_true",
        help=f"the study in small, a minute or two: {QUICK['particles']} grains, elongations "
        f"{', '.join(map(str, QUICK['etas'][0]))}, strain {QUICK['strain']}, {QUICK['networks']} "
        "networks, unless other options say otherwise")
    add("--particles", type=script.at_least(10), default=13000, metavar="N",
        help="grains of each test")
    add("--etas", type=numbers(elongation), nargs="+", metavar="ETA",
        default=[[0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]],
        help="elongations, separated by commas or spaces (default: 0,0.1,…,0.7)")
    add("--shape", choices=list(SHAPES), help="of the grains, as in scripts/biaxial.py")
    add("--sides", type=numbers(script.at_least(3, 64)), nargs="+", metavar="N", default=[],
        help="numbers of sides of --shape regular, instead of --etas")
    add("--rolling-friction", type=numbers(rolling), nargs="+", metavar="MU_R", default=[],
        help="coefficients of rolling resistance between grains, each for every elongation")
    add("--size-span", type=span, metavar="R",
        help="largest over smallest radius (default: that of scripts/biaxial.py)")
    add("--paper", choices=papers.names(),
        help="paper of the report (default: the one with such grains)")
    add("--seeds", type=numbers(seed), nargs="+", metavar="SEED", default=[[1]],
        help="seeds, separated likewise (default: 1)")
    add("--strain", type=strain, default=0.5, metavar="E", help="of the shear")
    add("--networks", type=script.at_least(1), metavar="N",
        help="networks of each test, at equal strains (default: that of scripts/biaxial.py, with "
        f"--quick {QUICK['networks']})")
    add("--iterations", type=script.at_least(1), metavar="N",
        help="most sweeps of the solver in a step of the shear (default: that of "
        "scripts/biaxial.py)")
    add("--time-step", type=positive, metavar="DT",
        help="of the shear, over √(m/σ0) (default: that of scripts/biaxial.py)")
    add("--friction", type=friction, metavar="MU",
        help="between grains during the shear (default: that of scripts/biaxial.py)")
    add("--jobs", type=script.at_least(1), default=processors, metavar="N",
        help="processors to use")
    add("--out", type=script.folder, default="out/campaign", metavar="DIR",
        help="folder of the runs and the report, made if missing (default: %(default)s, with "
        f"--quick {QUICK['out']})")
    words = [*sys.argv[1:], "--"]
    words, extra = words[: words.index("--")], words[words.index("--") + 1 : -1]
    if "--quick" in words:
        parser.set_defaults(**QUICK)
    options = parser.parse_args(words)
    if options.sides:
        if "--etas" in words:
            parser.error("--sides and --etas: sides determine η; give one of them")
        options.etas = []
    for name in "etas", "sides", "rolling_friction", "seeds":
        values = sorted({value for part in getattr(options, name) for value in part})
        if not values and name in ("seeds", "sides" if options.sides else "etas"):
            parser.error(f"--{name}: expected at least one")
        setattr(options, name, values)
    if options.networks is not None:
        check_networks(options.networks, options.strain)
    options.paper = options.paper or paper_of(options)
    return options, extra


def paper_of(options):
    """Return the name of the paper with grains like those of a campaign."""
    if options.sides or any(options.rolling_friction):
        return "estrada_2011"
    return papers.DEFAULT if options.shape in (None, "rcr") else "cegeo_2012"


def text(value):
    """Return a number or a word as the names of runs contain it."""
    return value if isinstance(value, str) else repr(value).removesuffix(".0")


def configuration(options):
    """Return the configuration of campaign.smk."""
    lists = {name: getattr(options, name) for name in (*campaign_runs.LISTS, "seeds")}
    tests = math.prod(len(values) for values in lists.values() if values)
    config = dict(particles=options.particles, strain=options.strain,
                  threads=min(1024, max(1, options.jobs // tests)))
    config |= {name: ",".join(map(text, values)) for name, values in lists.items() if values}
    given = {name: getattr(options, name) for name in campaign_runs.OPTIONAL}
    config |= {name: text(value) for name, value in given.items() if value is not None}
    return config | (dict(paper=options.paper) if options.paper != papers.DEFAULT else {})


def check_cases(options):
    """Raise a ValueError if scripts/biaxial.py refuses a test."""
    shared = {name: getattr(options, name) for name in ("shape", "size_span")}
    shared = {name: value for name, value in shared.items() if value is not None}
    kinds = [dict(eta=eta) for eta in options.etas] + [dict(sides=n) for n in options.sides]
    for kind, rolling in itertools.product(kinds, options.rolling_friction or [0]):
        check_parameters(**kind, **shared, rolling_friction=rolling)


def command(options, config, extra):
    """Return the command of Snakemake.

    It ends with this process, and its jobs with it. Its own lock outlives a kill, that of the
    folder does not: hence --nolock.
    """
    return ["setpriv", "--pdeathsig", "KILL", "snakemake", "--directory", options.out,
            "--snakefile", str(HERE / "campaign.smk"), "--cores", str(options.jobs),
            "--scheduler", "greedy", "--keep-going", "--rerun-incomplete", "--nolock",
            "--quiet", "rules", "--config", *(f"{name}={value}" for name, value in config.items()),
            *extra]


def run_snakemake(words, progress, stop):
    """Run Snakemake, and show the progress; return its exit code and its messages.

    Snakemake and the tests have a session of their own. If the user stops the campaign, they get
    the signal of Ctrl-C: Snakemake starts no further test, and the tests write their checkpoints.
    Without `progress`, the messages go to stderr.
    """
    told = False
    with tempfile.TemporaryFile("w+") as messages:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, start_new_session=True,
                                   stdout=messages if progress else sys.stderr,
                                   stderr=messages if progress else None)
        while True:
            if stop.asked and not told:
                show("stopping: the tests write their checkpoints …")
                os.killpg(process.pid, signal.SIGINT)
                told = True
            try:
                code = process.wait(timeout=0.5)
                messages.seek(0)
                return code, messages.read()
            except subprocess.TimeoutExpired:
                if progress:
                    progress.update()


def last_line(path):
    return (path.read_text(errors="replace").strip().splitlines() or [""])[-1]


def failure(out, folders):
    """Return one line with the reason of each failed run: the last line of its log."""
    missing = [folder for folder in folders if not (folder / "summary.json").exists()]
    if not missing and not (out / "report" / "report.html").exists():
        missing = [out / "report"]
    logs = [folder / "log" for folder in missing if (folder / "log").exists()]
    reasons = "; ".join(f"{path.resolve()}: {last_line(path)}" for path in logs)
    todo = "; scripts/network.py analyses the tests that are complete"
    return f"{f'not complete: {reasons}{todo}' if reasons else UNKNOWN}; {CONTINUE}"


def announce(tests, options, threads):
    """Print what will run."""
    left = sum(not test.is_complete for test in tests)
    begun = sum(test.has_checkpoint and not test.is_complete for test in tests)
    resumed = f", {begun} resumed" if begun else ""
    at_once = min(left, options.jobs // threads)
    count = f"{len(tests)} test{'s' if len(tests) > 1 else ''}"
    show(f"{count} of {options.particles} grains to a strain of {options.strain:g}, "
         f"{len(tests) - left} complete{resumed}; {at_once} at a time, then analysis, figures, "
         "report")


def check_protocol(folders):
    """Raise a ValueError if a folder holds a test of other constants."""
    for folder in folders:
        record = run_folder.read(folder)
        if record and record["parameters"].get("protocol") != PROTOCOL.identity:
            raise ValueError(f"{folder} holds a test of other constants than those of "
                             "rcr.study.protocol; choose another --out, or remove it")


def is_report_of(out, folders, paper):
    """Return whether the report in a folder is that of these runs, no others, and of the paper."""
    record = run_folder.read(out / "report")
    parameters = record["parameters"] if record else {}
    names = [pathlib.Path(run["folder"]).name for run in parameters.get("runs", [])]
    same_paper = parameters.get("paper", papers.DEFAULT) == paper
    return sorted(names) == sorted(folder.name for folder in folders) and same_paper


def main():
    options, extra = arguments()
    if not shutil.which("snakemake"):
        todo = "install it (apt-get install snakemake) and run this command again"
        raise RuntimeError(f"the package snakemake is not installed; {todo}")
    out, config = pathlib.Path(options.out), configuration(options)
    check_cases(options)
    tests = [Test(f"{campaign_runs.label(case)}, seed {seed}",
                  out / "runs" / campaign_runs.run_name(config, case, seed), options.strain)
             for case in campaign_runs.cases(config) for seed in options.seeds]
    folders = [test.folder for test in tests]
    check_protocol(folders)
    parameters = {name: getattr(options, name) for name in FREE}
    claim = dict(free=list(FREE), resume=True)  # one folder may hold several campaigns
    claimed = run_folder.claim_folder(out, "campaign", parameters, [], **claim)
    with script.stoppable() as stop, claimed as begin:
        begin()
        if not extra and not is_report_of(out, folders, options.paper):
            (out / "report" / "analysis.json").unlink(missing_ok=True)
        words = command(options, config, extra)
        if extra:  # show what Snakemake says of them
            failed, messages = run_snakemake(words, None, stop)
        else:
            announce(tests, options, config["threads"])
            with Progress(tests, out / "report" / "log") as progress:
                failed, messages = run_snakemake(words, progress, stop)
    if stop.asked and failed:
        raise script.Stopped(f"stopped; {CONTINUE}", stop.number)
    if failed:
        reasons = failure(out, folders)
        if reasons.startswith(UNKNOWN):
            sys.stderr.write(messages)
        sys.exit(reasons)  # in full: script.run shortens the messages of exceptions
    log = out / "report" / "log"
    if not {"-n", "--dry-run", "--dryrun"} & set(extra) and is_report_of(out, folders, options.paper):
        print(out / last_line(log))  # else nothing ran


script.run(main)
