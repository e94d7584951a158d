#!/usr/bin/env python3
"""Analyse the networks of biaxial tests: analysis.json, every figure of the paper as PNG and PDF, and report.html.

Each DIR is a folder written by scripts/biaxial.py. Tests of the same elongation are seeds and are cumulated; different elongations
are the curves of each figure. Needs Python with NumPy, h5py and Matplotlib, not YADE.
"""

import os
import sys

from lib import environment

try:
    from rcr import _results as results, script
    from rcr.study import report
    from rcr.study.analysis import analyse
    from rcr.study.runs import Run
except ImportError as error:  # not for this Python: in the environment of yade-rcr there is one that fits
    environment.reenter(error)

MADE = ["analysis.json", "report.html", "table.md", "O[0-9]*.png", "O[0-9]*.pdf"]


def arguments():
    parser = script.Parser(prog="network.py", description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folder with network-*.h5")
    script.add_results(parser, "results")
    script.add_window(parser)
    return parser.parse_args()


def show(name):
    """One line on a terminal that says what is being made."""
    if sys.stderr.isatty():
        print(f"\r\033[K{name} …" if name else "\r\033[K", end="", file=sys.stderr, flush=True)


def tell_incomplete(run):
    """A line on stderr where a run has not reached the end of its strain."""
    if run.record and run.summary is None:
        reached, wanted = run.networks[-1].attributes["strain"], run.record["parameters"]["strain"]
        print(f"network.py: the run in {run.folder} is not complete: its last network is at a strain of {reached:.4f}, its end at {wanted:g}", file=sys.stderr)


def main():
    options = arguments()
    runs = [Run.read(folder, options.from_strain, options.to_strain) for folder in options.folders]
    for run in runs:
        tell_incomplete(run)
    of = [dict(folder=os.path.abspath(run.folder), run=run.record and run.record["run"]) for run in runs]
    parameters = dict(runs=of, from_strain=options.from_strain, to_strain=options.to_strain)
    show("analysis")
    found = analyse(runs)
    with results.claim_folder(options.out, "network.py", parameters, MADE, overwrite=options.overwrite) as begin:
        table = report.write(runs, options.out, show, found, begin)
    show("")
    print(f"{os.path.join(options.out, 'report.html')}: {report.summary(table)}")


script.run(main)
