"""Charts of error against time, and where methods hold: what scripts/chart.py draws.

Each module of this package is a chart:

    TITLE                       of the figure
    points(options)             names of its points, in the order in which they are run
    run(name, options)          the rows (dicts) of one point; most have one
    plot(rows, options)         the figure
    ratios(rows)                lines of a table of what is compared, where something is (a and c)
    COLUMNS                     of the CSV, after `point` and before `command`

A row whose `status` is not 'ok' says why it has no numbers. Times are processor time of one thread.
"""

import csv
import dataclasses
import importlib
import os
import time

NAMES = dict(a="one_step", b="deterministic", c="biaxial_cost", d="stability")


@dataclasses.dataclass(frozen=True)
class Options:
    """Of scripts/chart.py."""

    out: str
    quick: bool
    particles: int  # of the biaxial tests of chart c
    siconos: str  # a Python that has it; '' for none
    peers: str  # folder of the programs chipmunk_step and box2d_step
    limit: float  # seconds that one point may take


def chart(letter):
    """The module of a chart."""
    return importlib.import_module(f"{__name__}.{NAMES[letter]}")


class Table:
    """The CSV of a chart: grows by a point's rows at a time, so that an interrupted run goes on where it stopped."""

    def __init__(self, path, columns):
        self.path, self.columns, self.rows = path, ["point", "status", *columns, "command"], []
        if os.path.exists(path):
            with open(path, newline="") as file:
                self.rows = [{name: _value(cell) for name, cell in row.items()} for row in csv.DictReader(file)]

    def has(self, point):
        return any(row["point"] == point for row in self.rows)

    def put(self, point, rows):
        """The rows of a point, in the place of those that it had."""
        self.rows = [row for row in self.rows if row["point"] != point] + rows
        with open(self.path + ".part", "w", newline="") as file:
            writer = csv.DictWriter(file, self.columns, extrasaction="ignore")
            writer.writeheader()
            writer.writerows(self.rows)
        os.replace(self.path + ".part", self.path)


def _value(cell):
    try:
        return float(cell)
    except ValueError:
        return cell


def least_time(repeats, work):
    """Result of `work()` and its least processor time in so many runs [s]."""
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        seconds.append(time.process_time() - start)
    return result, min(seconds)
