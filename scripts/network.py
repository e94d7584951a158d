#!/usr/bin/env python3
"""Analyse the networks of biaxial tests: analysis.json, every figure of the paper, report.html.

Each DIR is a folder of scripts/biaxial.py. Tests of one elongation are seeds, whose contacts are
cumulated; each elongation is a curve of the figures. Needs NumPy, h5py, Matplotlib and tqdm, not
YADE.
"""

import os
import sys

from lib import environment

try:
    from tqdm import tqdm

    from rcr import script
    from rcr._data import run_folder
    from rcr.study import report
    from rcr.study.runs import Run, by_elongation
except ImportError as error:  # continue in the Python of yade-rcr
    environment.reenter(error)

MADE = ["analysis.json", "report.html", "table.md", "O[0-9]*.png", "O[0-9]*.pdf"]


def arguments():
    """Return the options of the command line."""
    strain = script.number("a strain 0 ≤ E < 1", lambda v: 0 <= v < 1)
    parser = script.Parser(prog="network.py", description=__doc__)
    add = parser.add_argument
    add("folders", nargs="+", metavar="DIR", help="folder with network-*.h5")
    script.add_results(parser, "results")
    add("--from-strain", type=strain, metavar="E",
        help="first strain of the averages (default: half of --to-strain)")
    add("--to-strain", type=strain, metavar="E",
        help="last strain of the averages (default: each test's end)")
    add("--include-yielded", action="store_true",
        help="keep records and networks whose record has a step without a solution")
    return parser.parse_args()


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
    names = ("from_strain", "to_strain", "include_yielded")
    selection = {name: getattr(options, name) for name in names}
    runs = [Run.read(folder, **selection) for folder in options.folders]
    for run in runs:
        if run.record and run.summary is None:
            last = run.networks[-1].attributes["strain"]
            end = run.record["parameters"].get("strain")
            aim = "" if end is None else f", its end at {end}"
            print(f"network.py: the run in {run.folder} is not complete: its last network is at a "
                  f"strain of {last:.4f}{aim}", file=sys.stderr)
    by_elongation(runs)  # raises if they do not belong together
    sources = [dict(folder=os.path.abspath(run.folder), run=run.record and run.record["run"])
               for run in runs]
    parameters = dict(selection, runs=sources)
    with run_folder.claim_folder(options.out, "network.py", parameters, MADE,
                              overwrite=options.overwrite) as begin:
        with tqdm(bar_format="{desc} …", leave=False, disable=None) as bar:
            table = report.write(runs, options.out, shown_on(bar), begin)
    print(f"{os.path.join(options.out, 'report.html')}: {report.summary(table)}")


script.run(main)
