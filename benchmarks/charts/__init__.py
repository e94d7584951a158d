"""Charts of error against time, and where methods hold: what scripts/chart.py draws.

Each module of this package is a chart:

    TITLE                       of the figure
    points(options)             names of its points, in the order in which they are run
    run(name, options)          the rows (dicts) of one point; most have one
    plot(rows, options)         the figure
    ratios(rows)                lines of a table of what is compared, where something is (not d)
    COLUMNS                     of the CSV, after `point` and before `command`
    DEPENDS                     names of the `Options` that its numbers depend on

A row whose `status` is not 'ok' says why it has no numbers. Times are processor time of one thread.
"""

import csv
import dataclasses
import importlib
import os
import time

from rcr import _files as files

GIVEN_UP = "given up after "  # begins the status of a point that took too long; its seconds follow
NAMES = dict(a="one_step", b="deterministic", c="biaxial_cost", d="stability", e="quasi_static")


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


def settings(letter, options):
    """What the numbers of a chart depend on, in words: rows of other settings are other rows, whatever the name of their point."""
    return ", ".join(f"{name} = {getattr(options, name)}" for name in chart(letter).DEPENDS)


def settled(status, limit, retry=False):
    """Whether a point with this status is not to be run again: it has numbers, or did not get them within `limit` seconds.

    One that failed otherwise is settled too, as a finding; `retry` runs every point without numbers again.
    """
    if status.startswith(GIVEN_UP) and float(status.removeprefix(GIVEN_UP).split()[0]) < limit:
        return False
    return status == "ok" or not retry


class Table:
    """The CSV of a chart: grows by a point's rows at a time, so that an interrupted run goes on where it stopped.

    Parameters
    ----------
    path : path
        Read if it exists.
    columns : list of str
        Of the chart.
    settings : str
        Of the rows that count here; those of others stay in the file as they are. None: all count.

    Raises
    ------
    ValueError
        If the file is damaged.
    """

    def __init__(self, path, columns, settings=None):
        self.path, self.settings = path, settings
        self.columns = ["point", "settings", "status", *columns, "command"]
        self.all = self._read() if os.path.exists(path) else []

    def _read(self):
        with files.reading(self.path, "a table of a chart"), open(self.path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, strict=True)
            lacking = [name for name in ("point", "status") if name not in (reader.fieldnames or ())]
            if lacking:
                raise ValueError(f"lacks the column {' and '.join(lacking)}; remove it to make it anew")
            rows = []
            for row in reader:
                if None in row or None in row.values():
                    raise ValueError(f"line {reader.line_num} has not the {len(reader.fieldnames)} cells of the header")
                rows.append({"settings": ""} | {name: _value(name, cell) for name, cell in row.items()})
            return rows

    @property
    def rows(self):
        """Those of these settings."""
        return [row for row in self.all if self.settings in (None, row["settings"])]

    def has(self, point, counts=lambda status: True):
        """Whether the point has rows with a status that counts."""
        return any(row["point"] == point and counts(row["status"]) for row in self.rows)

    def put(self, point, rows):
        """The rows of a point, in the place of those that it had."""
        settings = self.settings or ""
        others = [row for row in self.all if (row["point"], row["settings"]) != (point, settings)]
        self.all = others + [dict(row, settings=settings) for row in rows]
        files.write(self.path, files.table(self.columns, self.all))


_WORDS = {"point", "settings", "status", "command"}


def _value(name, cell):
    if name in _WORDS:
        return cell
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
