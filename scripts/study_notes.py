#!/usr/bin/env python3
"""Write docs/study-notes.md: small studies of what does not agree with the paper, from runs of scripts/biaxial.py, each with its figure.

Needs Python with NumPy, h5py and Matplotlib, not YADE.
"""

import pathlib

from lib import environment

try:
    from rcr import script
    from rcr.study import notes
    from rcr.study.runs import Run, by_elongation
except ImportError as error:  # not for this Python: in the environment of yade-rcr there is one that fits
    environment.reenter(error)


def main():
    parser = script.Parser(prog="study_notes.py", description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folder with network-*.h5")
    parser.add_argument("--against", nargs="+", default=[], metavar="DIR", help="folders of runs at another rate, to be set against them")
    script.add_window(parser)
    parser.add_argument("--out", type=script.folder, required=True, metavar="DIR", help="folder of study-notes.md, made if missing")
    options = parser.parse_args()
    groups = [by_elongation([Run.read(folder, options.from_strain, options.to_strain) for folder in folders]) if folders else {} for folders in (options.folders, options.against)]
    print(notes.write(*groups, pathlib.Path(options.out)))


script.run(main)
