"""Chart f. Cost over the number of grains: a column of discs collapses on a floor.

N discs with radii of 6 to 10 mm are deposited between two walls (`geometry/deposition.hpp`), twice
as high as wide. Without the walls they collapse. A point times 100 steps of 1 ms. Memory is the
peak of the process less its size before the scene. The method `nlgs` is the plain one.
"""

import ctypes
import gc
import math
import pathlib
import time
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from yade.wrapper import Omega

import rcr
from rcr.study.summary import memory

from benchmarks import charts
from benchmarks.hard_scenes import stage

O = Omega()
STEPS = 100
COLUMNS = "particles method seconds bytes sweeps missed points".split()
DEPENDS = ("quick",)
METHODS = dict(auto=("o", "k"), nlgs=("s", "w"))  # marker and filling
PANELS = dict(seconds=("processor time per grain and step [µs]", 1e6), sweeps=("sweeps per step", 1),
              bytes=("memory per grain [kB]", 1e-3))


def points(options):
    """Names particles/method, small ones first."""
    counts = (100, 1000) if options.quick else (10**3, 10**4, 10**5, 10**6)
    return [f"{count}/{method}" for count in counts for method in METHODS]


def _column(count, method):
    """The scene; returns its solver."""
    radii = np.random.default_rng(1).uniform(0.6, 1, count) * stage.R
    centres = rcr._kernel.deposit(radii, math.sqrt(2 * np.sum(radii**2)))
    law = stage.ContactDynamics(dict(solver=method, threads=1, observe=[0]))
    grain = stage.material()
    stage.on_floor(partial(stage.build, law, stage.DT), grain,
                   *(rcr.particle(at, radius, 0, 0, grain) for at, radius in zip(centres, radii)))
    return O.engines[3]


def run(name, options):
    count, method = name.split("/")
    _column(100, method)
    O.run(STEPS, True)  # loads all libraries
    O.reset()
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pathlib.Path("/proc/self/clear_refs").write_text("5")  # VmHWM begins here
    before = memory("VmRSS")
    solver = _column(int(count), method)
    start = time.process_time()
    O.run(STEPS, True)
    seconds = time.process_time() - start
    return [dict(particles=int(count), method=method, seconds=seconds / STEPS / int(count),
                 bytes=(memory("VmHWM") - before) / int(count), points=solver.contactPoints,
                 sweeps=solver.observed()["iterations"] / STEPS,
                 missed=solver.missedSteps / STEPS)]


def _curves(rows):
    """(method, rows of growing size) of every method."""
    rows = sorted((row for row in rows if row["status"] == "ok"), key=lambda row: row["particles"])
    for method in METHODS:
        yield method, [row for row in rows if row["method"] == method]


def _exponent(last, row, name):
    """Exponent of a power law over the number of grains, from the size before.

    NaN if a number is not positive: the memory of a small scene may be below that freed meanwhile.
    """
    ratio = row[name] / last[name] if last[name] > 0 else 0
    grains = row["particles"] / last["particles"]
    return math.log(ratio) / math.log(grains) if ratio > 0 else math.nan


def ratios(rows):
    """Table of all points, with exponents over the number of grains from the size before."""
    yield ["method", "grains", *(f"{label} (exponent)" for label, _ in PANELS.values()),
           "steps that missed the tolerance"]
    for method, curve in _curves(rows):
        for last, row in zip([None, *curve], curve):
            cells = [f"{row[name] * unit:.3g}" + (f" ({_exponent(last, row, name):+.2f})" if last
                                                  else "") for name, (_, unit) in PANELS.items()]
            yield [method, f"{row['particles']:.0f}", *cells, f"{row['missed']:.2f}"]


def plot(rows, options):
    figure = Figure(figsize=(12, 4))
    for ax, (name, (label, unit)) in zip(figure.subplots(1, len(PANELS)), PANELS.items()):
        for method, curve in _curves(rows):
            marker, filling = METHODS[method]
            ax.semilogx([row["particles"] for row in curve], [row[name] * unit for row in curve],
                        f"k{marker}-", mfc=filling, ms=6, lw=1, label=method)
        ax.set(xlabel="grains", ylabel=label, ylim=(0, None))
        ax.grid(alpha=0.3)
    charts.add_legend(figure, ncol=2, bbox_to_anchor=(0.5, 1.02))
    figure.tight_layout(rect=(0, 0, 1, 0.94))
    return figure
