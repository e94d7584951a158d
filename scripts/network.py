#!/usr/bin/env python3
"""Analyse contact networks: analysis.json, figures and report.html.

Folders of scripts/biaxial.py, and networks with the attributes strain, eta, friction and volume,
are shear tests: the observables and figures of the paper, and paper against measured. Tests of one
elongation are seeds, whose contacts are cumulated; each elongation is a curve of the figures.
Networks of any other scene: force distributions, fabric, force chains and maps; each PATH is a
curve. Needs NumPy, h5py, Matplotlib and tqdm, not YADE.
"""

import os
import sys

from lib import environment

try:
    from tqdm import tqdm

    from rcr import papers, script
    from rcr._data import run_folder
    from rcr.force_network import analysis as any_scene, report as force_report
    from rcr.study import report
    from rcr.study.runs import Run, by_kind
except ImportError as error:  # continue in the Python of yade-rcr
    environment.reenter(error)

SELECTION = "from_strain", "to_strain", "include_yielded"  # options of shear tests alone


def arguments():
    """Return the options of the command line."""
    parser = script.Parser(prog="network.py", description=__doc__)
    add = parser.add_argument
    add("paths", nargs="+", metavar="PATH", help="folder with network-*.h5, or a network file")
    script.add_results(parser, "results")
    add("--any-scene", action="store_true",
        help="analyse shear tests too as networks of any scene, without the paper")
    add("--paper", choices=papers.names(), default=papers.DEFAULT,
        help="paper with which shear tests are compared")
    add("--from-strain", type=script.strain, metavar="E",
        help="first strain of the averages of shear tests (default: half of --to-strain)")
    add("--to-strain", type=script.strain, metavar="E",
        help="last strain of the averages of shear tests (default: each test's end)")
    add("--include-yielded", action="store_true",
        help="of shear tests, keep records and networks whose record has a step without a solution")
    return parser.parse_args()


def are_shear_tests(options):
    """Return whether the paths are shear tests; a ValueError reports some that are and some not."""
    if options.any_scene:
        return False
    tests = {path: any_scene.is_shear_test(path) for path in options.paths}
    if len(set(tests.values())) > 1:
        test, other = (next(p for p, found in tests.items() if found is wanted)
                       for wanted in (True, False))
        raise ValueError(f"{test} holds networks of a shear test, with the attributes "
                         f"{', '.join(any_scene.SHEAR_TEST)}, and {other} does not; leave one out, "
                         "or analyse both without the paper: --any-scene")
    return all(tests.values())


def warn_of_incomplete(run):
    """Print that a run is not complete."""
    if run.record and run.summary is None:
        last = run.networks[-1].attributes["strain"]
        end = run.record["parameters"].get("strain")
        aim = "" if end is None else f", its end at {end}"
        print(f"network.py: the run in {run.folder} is not complete: its last network is at a "
              f"strain of {last:.4f}{aim}", file=sys.stderr)


def shear_tests(options):
    """Return the parameters of an analysis of shear tests, its report module and the tests."""
    selection = {name: getattr(options, name) for name in SELECTION}
    paper = papers.load(options.paper)
    runs = [Run.read(folder, **selection, averages=paper.averages) for folder in options.paths]
    for run in runs:
        warn_of_incomplete(run)
    by_kind(runs, paper.compares)  # raises if they do not belong together
    sources = [dict(folder=os.path.abspath(run.folder), run=run.record and run.record["run"])
               for run in runs]
    if options.paper != papers.DEFAULT:
        selection["paper"] = options.paper
    return dict(selection, runs=sources), report, runs


def networks(options):
    """Return the same of networks of any scene."""
    given = [f"--{name.replace('_', '-')}" for name in SELECTION if getattr(options, name)]
    if given:
        raise ValueError(f"{', '.join(given)}: expected shear tests, whose networks have the "
                         f"attributes {', '.join(any_scene.SHEAR_TEST)}; leave it out")
    sets = any_scene.read(options.paths)
    sources = [[os.path.abspath(path) for path in one.paths] for one in sets]
    return dict(networks=sources), force_report, sets


def shown_on(bar):
    """Return a function that shows the next figure on a terminal, and each stage once elsewhere."""
    shown = set()

    def progress(name):
        stage = name if name in ("analysis", "report") else "figures"
        bar.set_description_str(stage if stage == name else f"{stage}, {name}")
        if bar.disable and stage not in shown:
            print(f"network.py: {stage} …", file=sys.stderr, flush=True)
        shown.add(stage)

    return progress


def main():
    options = arguments()
    analyse = shear_tests if are_shear_tests(options) else networks
    parameters, writer, given = analyse(options)
    made = report.MADE + force_report.MADE
    with run_folder.claim_folder(options.out, "network.py", parameters, made,
                                 overwrite=options.overwrite) as begin:
        with tqdm(bar_format="{desc} …", leave=False, disable=None) as bar:
            extra = dict(paper=papers.load(options.paper)) if writer is report else {}
            found = writer.write(given, options.out, shown_on(bar), begin, **extra)
    print(f"{os.path.join(options.out, 'report.html')}: {writer.summary(found)}")


script.run(main)
