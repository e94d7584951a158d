"""Charts of error against time and of stability, drawn by scripts/chart.py.

Each module of this package is a chart:

    points(options)             names of its points, in the order of their runs
    run(name, options)          rows (dicts) of one point; most have one
    plot(rows, options)         the figure
    ratios(rows)                rows of a table that compares methods (not in d), from rows with
                                numbers; `TABLES` names further tables
    COLUMNS                     columns of the CSV between `point` and `command`
    DEPENDS                     names of the `Options` that its numbers depend on

`status` is 'ok', or the reason why a row has no numbers. Times are processor time of one thread.
"""

import contextlib
import dataclasses
import importlib
import os

from rcr._data import files
from rcr.study.protocol import PROTOCOL

GIVEN_UP = "given up after "  # status of a point that reached its time limit; seconds follow
NAMES = dict(a="one_step", b="deterministic", c="biaxial_cost", d="stability", e="quasi_static",
             f="size", g="estimate", h="known_forces", i="accuracy", j="large_packings")
TABLES = "ratios", "residuals", "default_steps", "true_errors"  # functions of tables
SOLVERS = "nlgs", "sor", "nesterov", "exact", "auto"
COLORS = dict(zip((*SOLVERS, "Siconos NSGS", "Chipmunk", "Box2D"),
                  "C0 C9 C1 C3 k C2 C4 C5".split()))  # of methods and programs


@dataclasses.dataclass(frozen=True)
class Options:
    """Options of scripts/chart.py."""

    out: str
    quick: bool
    particles: int  # grains of the biaxial tests of chart c
    siconos: str  # a Python with Siconos; '' for none
    peers: str  # folder of chipmunk_step and box2d_step
    limit: float  # time limit of a point [s]

    @property
    def protocol(self):
        """Short hash of the constants of the biaxial test."""
        return PROTOCOL.identity


def chart(letter):
    return importlib.import_module(f"{__name__}.{NAMES[letter]}")


def settings(letter, options):
    """Settings that the numbers of a chart depend on, as text; part of the key of a row."""
    return ", ".join(f"{name} = {getattr(options, name)}" for name in chart(letter).DEPENDS)


def folder(kind, name, options):
    """Folder of files that later calls use again, unless the protocol of the test has changed."""
    return os.path.join(options.out, kind, f"{name}-{options.protocol}")


def settled(status, limit, retry=False):
    """True for a point with numbers; without `retry` also one that failed or had this limit."""
    if status.startswith(GIVEN_UP) and float(status.removeprefix(GIVEN_UP).split()[0]) < limit:
        return False
    return status == "ok" or not retry


class Table:
    """CSV of a chart, written after each point; rows of other `settings` stay, None is all."""

    def __init__(self, path, columns, settings=None):
        self.path, self.settings = path, settings
        self.columns = ["point", "settings", "status", *columns, "command"]
        self.all = self._read() if os.path.exists(path) else []

    def _read(self):
        with files.reading(self.path, "a table of a chart"):
            return [dict(settings="") | {name: number(cell) for name, cell in row.items()}
                    for row in files.read_table(self.path, ("point", "status"))]

    @property
    def rows(self):
        return [row for row in self.all if self.settings in (None, row["settings"])]

    def has(self, point, counts=lambda status: True):
        """True if the point has a row whose status satisfies `counts`."""
        return any(row["point"] == point and counts(row["status"]) for row in self.rows)

    def put(self, point, rows):
        """Replace the rows of a point, also those of another protocol, and write the file."""
        settings = self.settings or ""
        scope = lambda text: text.partition(", protocol")[0]
        others = [row for row in self.all
                  if (row["point"], scope(row["settings"])) != (point, scope(settings))]
        self.all = others + [dict(row, settings=settings) for row in rows]
        files.write(self.path, files.table(self.columns, self.all))


def number(cell):
    """A cell of a CSV as an int or a float, or as its text if it is no number."""
    for kind in int, float:
        with contextlib.suppress(ValueError):
            return kind(cell)
    return cell


def add_legend(figure, **style):
    """Add a legend of the lines of all panels above them, each label once."""
    handles = {label: handle for ax in figure.axes
               for handle, label in zip(*ax.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="upper center", **style)
