"""Tables of the benchmarks: options, output on the terminal and CSV files."""

import os

import numpy as np

from benchmarks import ROOT
from rcr import script
from rcr._data import files, run_folder
from rcr.statistics import standard_error


PEERS = os.path.join(ROOT, "build", "peers")  # default folder of the programs of other libraries


def add_repeats(parser, repeats, budget=None, runs="runs", run="a run"):
    """Add the options --repeats and --budget with these default values, for these runs."""
    parser.add_argument("--repeats", type=script.at_least(1), default=repeats, metavar="N",
                        help=f"{runs}; the fastest counts")
    if budget:
        seconds = script.number("seconds ≥ 0", lambda v: v >= 0)
        parser.add_argument("--budget", type=seconds, default=budget, metavar="S",
                            help=f"seconds after which {run} is not repeated")


def add_peers(parser, note=""):
    parser.add_argument("--peers", default=PEERS, metavar="DIR",
                        help="folder of the programs of benchmarks/peers (default: build/peers)" + note)


def seeds(text):
    """Return the seeds in a text, separated by commas."""
    return [int(seed) for seed in text.split(",")]


def add_packings(parser, particles, fewest):
    """Add --particles, with its default and least value, and --seeds."""
    parser.add_argument("--particles", type=script.at_least(fewest), default=particles, metavar="N")
    parser.add_argument("--seeds", type=seeds, default="1,2", help="separated by commas")


def tests_and_csv(program, description, name, averages=False):
    """Return the options of a script that makes a CSV of folders of scripts/biaxial.py.

    `averages`: with --from-strain, as scripts/network.py has it.
    """
    parser = script.Parser(prog=program, description=description.splitlines()[0])
    parser.add_argument("folders", nargs="+", metavar="RUNS", help="folders of scripts/biaxial.py")
    parser.add_argument("--out", type=script.new_file, default=name, metavar="FILE", help="CSV")
    if averages:
        parser.add_argument("--from-strain", type=script.strain, metavar="E",
                            help="first strain of the averages (default: half of each test's)")
    return parser.parse_args()


def means(values):
    """Return {name: mean, name_error: standard error} of {name: values of the seeds}."""
    return ({name: float(np.mean(found)) for name, found in values.items()}
            | {f"{name}_error": float(standard_error(found)) for name, found in values.items()})


def store(program, options, columns, measured):
    """Write the tables {name: rows} of `measured(options)` as CSV into --out, and print them."""
    given = {name: value for name, value in vars(options).items()
             if name not in ("out", "overwrite")}
    made = [f"{name}.csv" for name in columns]
    with run_folder.claim_folder(options.out, program, given, made,
                              overwrite=options.overwrite) as begin:
        tables = measured(options)
        begin()
        for name, rows in tables.items():
            files.write(os.path.join(options.out, f"{name}.csv"), files.table(columns[name], rows))
    for name, rows in tables.items():  # last, since a closed pipe ends the script
        _show(name, rows, columns[name])


def _show(title, rows, columns):
    if not rows:
        return
    cells = [list(columns)] + [[_cell(row.get(column)) for column in columns] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    print(f"\n{title}")
    for first, *others in cells:
        line = [first.ljust(widths[0]), *(c.rjust(w) for c, w in zip(others, widths[1:]))]
        print("  ".join(line).rstrip())


def _cell(value):
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
