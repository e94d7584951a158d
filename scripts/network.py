#!/usr/bin/env python3
"""Analyse the networks of biaxial tests: analysis.json, every figure of the paper as PNG and PDF, and report.html.

Each DIR is a folder written by scripts/biaxial.py. Tests of the same elongation are seeds and are cumulated; different elongations
are the curves of each figure. Needs Python with NumPy, h5py and Matplotlib, not YADE.
"""

import argparse
import os
import sys

from lib import environment

try:
    from rcr import report
    from rcr.runs import Run
except ImportError as error:  # not for this Python: in the environment of yade-rcr there is one that fits
    environment.reenter(error)


def arguments():
    parser = argparse.ArgumentParser(prog="network.py", description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folder with network-*.h5")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the results, made if missing")
    parser.add_argument("--from-strain", type=float, metavar="E", help="start of the critical state (default: half of each test's last strain)")
    return parser.parse_args()


def show(name):
    """One line on a terminal that says what is being made."""
    if sys.stderr.isatty():
        print(f"\r\033[K{name} …" if name else "\r\033[K", end="", file=sys.stderr, flush=True)


def main():
    options = arguments()
    runs = [Run.read(folder, options.from_strain) for folder in options.folders]
    table = report.write(runs, options.out, show)
    show("")
    print(f"{os.path.join(options.out, 'report.html')}: {report.summary(table)}")


try:
    main()
except (ValueError, OSError) as error:
    sys.exit(f"network.py: {error}")
