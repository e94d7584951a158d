#!/usr/bin/env python3
"""Write the tables of the pages from measured files.

A page names a table, and this script writes it between the marks:

    <!-- table: NAME -->
    …
    <!-- end -->

Run it with YADE:  scripts/lib/run python3 docs/generate/tables.py
`--check` writes nothing and exits with 1 if a page is out of date.
"""

import argparse
import ast
import json
import math
import pathlib
import re
import sys

import numpy as np
import yade  # noqa: F401: rcr loads its plugin into it
from benchmarks import charts, hard_scenes as suite
from rcr._data import files
from rcr._yade.counterparts import COUNTERPARTS
from rcr import papers
from rcr.plot import CATEGORIES, CONTACTS, SCALES
from rcr.profile import QUANTITIES
from rcr.study.criteria import at_xi, is_steady
from rcr.study.protocol import SHAPE_NAMES
from rcr.study.report import HEADER, markdown as table

DOCS = pathlib.Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
MARK = re.compile(r"(<!-- table: (\S+) -->\n).*?(<!-- end -->)", re.S)


def measured(name):
    """Rows (dicts) of a CSV in docs/results/charts that have numbers, which are floats."""
    rows = files.read_table(DOCS / "results" / "charts" / f"{name}.csv", ())
    return [{key: charts.number(cell) for key, cell in row.items()}
            for row in rows if row.get("status", "ok") == "ok"]


def ratios(chart, name, shown=lambda row: True, columns=None, printed="ratios"):
    """Table of a chart, as scripts/chart.py prints it, without rows that are not `shown`.
    `columns`: titles; None: all. `printed`: the function that makes it.
    """
    header, *rows = getattr(charts.chart(chart), printed)(measured(name))
    chosen = [header.index(title) for title in columns or header]
    plain = lambda match: f"{float(match[0]):g}"  # 1e+03 as 1000
    short = lambda cell: re.sub(r"(\d(?:\.\d+)?)e\+0*(\d+)", plain, cell)
    return table([header[k] for k in chosen],
                 [[short(row[k]) for k in chosen] for row in rows if shown(row)])


def quasi_static():
    """The main observables and settings of the packings that have all settings."""
    main = {"sin φ", "I_M", "a_c(ξ = 1)"}
    return ratios("e", "e-quasi-static", lambda row: row[0] in main and row[1].endswith("N = 1000"),
                  ["observable", "elongation, particles", "mean", "I → 0", "I = 1e-3",
                   "1000 sweeps", "dt = 0.1 t₀", "strains 0.3 to 0.5"])


def hard_scenes():
    """Verdicts of every hard scene."""
    runs = {(row["scene"], row["law"], row["dt"]): row for row in measured("d-stability")}

    def result(*key):
        return f"{runs[key]['verdict']} ({runs[key]['measured']:.1g})" if key in runs else ""

    rows = []
    for name in dict.fromkeys(scene for scene, _, _ in runs):
        scene = suite.SCENES[name]
        rows.append([suite.title(name), scene.PREDICATE, f"{scene.BOUND:g}",
                     result(name, "cd", 1e-3), result(name, "cd", 1e-2),
                     result(name, "smooth", 1e-4)])
    header = ["scene", "measure", "bound", "rigid, 1 ms", "rigid, 10 ms", "springs, 0.1 ms"]
    return table(header, rows)


def stability():
    """Numbers of hard scenes that hold, drift or blow up."""
    rows = measured("d-stability")
    steps = sorted({row["dt"] for row in rows})
    lines = []
    for law, title in (("cd", "rigid contacts"), ("smooth", "springs, young = 10⁸ Pa")):
        runs = [row for row in rows if row["law"] == law]
        verdicts = lambda dt: [row["verdict"] for row in runs if row["dt"] == dt]
        counts = lambda dt: map(verdicts(dt).count, ("holds", "drifts", "blows up"))
        lines.append([title, *(" / ".join(map(str, counts(dt))) for dt in steps)])
    return table(["hold / drift / blow up at dt =", *(f"{1e3 * dt:g} ms" for dt in steps)], lines)


def slow_shear():
    """Observables and cost over rate, time step and sweeps, from benchmarks/slow_shear.py."""
    titles = dict(sin_phi="sin φ", scatter="scatter of sin φ", friction_mobilization="I_M",
                  mobilized_fraction="share of I_m > 0.99", beta_n="β_n", a_c="a_c",
                  mean_overlap="mean overlap [d]", max_overlap="largest overlap [d]")
    shown = lambda value: f"{value:.3f}" if abs(value) >= 0.0095 else f"{value:.1g}"
    rows = [[f"{row['eta']:g}", f"{row['sample_inertia']:.0e}", f"{row['time_step']:g}",
             f"{row['iterations']:.0f}", *(("ended by an error",) + ("",) * (len(titles) + 1)
             if row["failed"] else (f"{row['inertial_number']:.1e}", f"{row['steps']:.0f}",
                                    *(shown(row[name]) for name in titles)))]
            for row in measured("slow-shear")]
    return table(["η", "ρ (v W/2h)²/σ₀", "dt/t₀", "sweeps", "I", "steps", *titles.values()], rows)


PLACINGS = dict(layers="in layers", random="at random", sizes="in layers, R_max = 3 R_min",
                loose="in layers, steps as in the paper")


def plus_minus(mean, error):
    return f"{mean:.3f} ± {error:.3f}"


def with_error(row, name):
    return plus_minus(row[name], row[f"{name}_error"])


def fabric():
    """Fabric of packings of discs, from benchmarks/placing.py."""
    names = *(f"amplitude_{k}" for k in (2, 4, 6)), "a_c_min"
    rows = [[PLACINGS[row["case"]], row["contacts"],
             *(with_error(row, name) for name in names), f"{row['xi_min']:.2g}"] for row in measured("fabric")]
    return table(["placing", "contacts", "2θ", "4θ", "6θ", "lowest a_c(ξ)", "at ξ"], rows)


def long_grains():
    """Observables of long grains that are placed differently, from benchmarks/placing.py --eta."""
    titles = dict(beta_n="β_n", weak_fraction="share of weak contacts", a_c_weak="a_c(ξ = 1)",
                  c_f_lr="C(f, ℓ_r)", c_f_l="C(f, ℓ)", half_sum="half-sum over q/p")
    rows = [[PLACINGS[row["case"]], *(with_error(row, name) for name in titles),
             f"{row['xi_a_ln']:.1f}"] for row in measured("long-grains")]
    return table(["placing", *titles.values(), "ξ of the minimum of a_ln"], rows)


def short_grains():
    """Strength and forces of grains of η = 0.1, from benchmarks/placing.py --eta 0.1."""
    titles = dict(q_over_p="q/p", a_c_weak="a_c(ξ = 1)", xi_a_fn="ξ up to which a_fn(ξ) < 0")
    rows = [[PLACINGS[row["case"]], *(with_error(row, name) for name in titles)]
            for row in measured("long-grains-0.1")]
    return table(["placing", *titles.values()], rows)


def compactions():
    """Packing fractions after compactions, from benchmarks/compactions.py."""
    rows = [[SHAPE_NAMES[row["shape"]], f"{row['eta']:g}", with_error(row, "without"),
             with_error(row, "with")] for row in measured("compactions")]
    return table(["shape", "η", "without inertia", "with inertia"], rows)


def sweeps_of_tests():
    """Observables of whole tests over the sweeps a step, from benchmarks/sweeps_of_tests.py."""
    titles = dict(sin_phi="sin φ", friction_mobilization="I_M",
                  mobilized_fraction="share of I_m > 0.99", beta_n="β_n",
                  a_c_half="a_c(ξ = 0.5)", a_c_weak="a_c(ξ = 1)", a_c="a_c",
                  coordination_number="Z")
    rows = [[f"{row['particles']:.0f}", f"{row['eta']:g}", f"{row['iterations']:.0f}",
             *(with_error(row, name) for name in titles),
             f"{row['mean_overlap']:.1g}", f"{row['max_overlap']:.2g}",
             f"{100 * row['missed_fraction']:.0f} %"] for row in measured("sweeps-of-tests")]
    return table(["grains", "η", "sweeps", *titles.values(), "mean overlap [d]",
                  "largest overlap [d]", "missed steps"], rows)


def step_threads():
    """Fastest step of each packing on one and on two threads, from scripts/bench_step.py."""
    groups = {}
    for row in measured("step-threads"):
        if row["way"] == "arrays":
            groups.setdefault(row["folder"], []).append(row)
    lines = []
    for rows in groups.values():
        one, two = (min(row["ms_least"] for row in rows if row["threads"] == threads)
                    for threads in (1, 2))
        first = rows[0]
        lines.append([f"{first['grains']:.0f}", f"{first['eta']:g}", f"{first['points']:.0f}",
                      f"{one:.2g}", f"{two:.2g}", f"{one / two:.2f}"])
    return table(["grains", "η", "contact points", "one thread [ms]", "two threads [ms]", "ratio"],
                 lines)


def parallel():
    """Wall-clock time to a residual by threads, from scripts/bench_solver.py --only parallel."""
    rows, lines = [row for row in measured("parallel")
                   if row["tolerance"] < 1e-2 and row["problem"].startswith("n13000_")], []
    programs = "rcr auto", "rcr nlgs", "Siconos NSGS"
    keys = dict.fromkeys((row["problem"], row["tolerance"], row["threads"]) for row in rows)
    for problem, tolerance, threads in sorted(keys, key=lambda key: (key[0], -key[1], key[2])):
        of = {row["program"]: row for row in rows
              if (row["problem"], row["tolerance"], row["threads"]) == (problem, tolerance, threads)}
        eta = re.match(r"n\d+_e([\d.]+)_", problem)[1]
        cell = lambda name: f"{1e3 * of[name]['seconds']:.3g} ({of[name]['iterations']:.0f})"
        lines.append([eta, f"{tolerance:.0e}", f"{threads:.0f}",
                      *(cell(name) if name in of else "" for name in programs)])
    return table(["η", "residual", "threads", *programs], lines)


def points_of_sides():
    """Side-side contacts as one contact and as four, from benchmarks/points_of_sides.py."""
    rows = measured("points-of-sides")
    observables = {"weak_share": "share of weak contacts", "beta_n": "β_n", "c_f_lr": "C(f, ℓ_r)",
                   "c_f_l": "C(f, ℓ)", "a_c_weak": "a_c(ξ = 1)",
                   "xi_a_ln": "ξ of the minimum of a_ln"}
    lines = []
    for eta in dict.fromkeys(row["eta"] for row in rows if row["eta"] > 0):
        one, four = (next(row for row in rows if row["eta"] == eta and row["points"] == points)
                     for points in (1, 4))
        lines.append([f"{eta:g}", *(f"{one[name]:.2g} → {four[name]:.2g}" for name in observables)])
    return table(["η", *observables.values()], lines)


def meetings():
    """Meetings with intrusions by elongation and path, from benchmarks/meetings.py."""
    rows = measured("meetings")
    shown = lambda row: f"{row['intruding']:.0f} of {row['meetings']:.0f}"
    lines = []
    for eta in dict.fromkeys(row["eta"] for row in rows):
        of = sorted((row for row in rows if row["eta"] == eta), key=lambda row: row["path"])
        at = {row["path"]: shown(row) for row in of}
        lines.append([f"{eta:g}", f"{of[0]['path']:g} R", shown(of[0]),
                      *(at[path] for path in (0.3, 1, 3))])
    return table(["η", "bound", "at the bound", "0.3 R", "R", "3 R"], lines)


def spring_energy():
    """Relative error of the dissipated energy of springs, from benchmarks/spring_energy.py."""
    rows = [[f"{row['share']:g}", *(f"{100 * row[name]:.2g} %" for name in ("bounce", "column"))]
            for row in measured("spring-energy")]
    return table(["dt / `critical_time_step()`", "a disc bounces", "a column collapses"], rows)


def driven_scenes():
    """Largest values of each motion, from benchmarks/driven_scenes.py."""
    rows = measured("driven-scenes")
    ratios = [lambda row: row["force_rigid"] / row["force_springs"],
              lambda row: row["slowest_rigid"] / row["median_rigid"]]
    lines = []
    for motion in [*dict.fromkeys(row["motion"] for row in rows), "all"]:
        chosen = [row for row in rows if motion in (row["motion"], "all")]
        broken = [name for row in chosen for name in str(row["broken"]).split()]
        lines.append([
            motion, len(chosen), sum(row["yielded_rigid"] > 0 for row in chosen),
            *(f"{max(map(ratio, chosen)):.2g}" for ratio in ratios),
            sum(row["stopped_rigid"] < math.inf for row in chosen),
            ", ".join(f"{name.replace('_', ' ')}: {broken.count(name)}" for name in dict.fromkeys(broken))
            or "none"])
    return table(["motion", "scenes", "with contacts that yield", "force over that of springs",
                  "slowest step over the median", "ended by a jam", "conditions violated"], lines)


def published(folder):
    """The analysis.json of a folder of docs/results, with arrays."""
    analysis = json.loads((DOCS / "results" / folder / "analysis.json").read_text())
    for entry in analysis.values():
        entry["value"] = {name: np.array(values, None if name == "shape" else float)
                          for name, values in entry["value"].items() if name != "files"}
    return analysis


def statements(folder, paper=papers.DEFAULT):
    """Statements of a paper against the published tests of a folder of docs/results."""
    return table(HEADER, papers.load(paper).findings(published(folder)))


def study_means():
    """Means of the study with their standard errors."""
    value = {name: entry["value"] for name, entry in published("study").items()}
    mean = lambda of, name: (value[of][name], value[of][f"{name}_error"])
    whole = lambda of, name: np.array(mean(of, name))[..., -1]  # of all contacts
    columns = {
        "sin φ": mean("O1", "sin_phi"), "I_M": mean("O5", "friction_mobilization"),
        "share of I_m > 0.99": mean("O5", "mobilized_fraction"), "β_n": mean("O3", "beta_n"),
        "share of weak contacts": mean("O3", "weak_fraction"), "a_c": whole("O15", "a_c"),
        "a_c(ξ = 1)": at_xi(value["O15"], "a_c"), "a_fn": whole("O17", "a_fn"),
        "a_ft": whole("O17", "a_ft"), "C(f, ℓ_r)": mean("O12", "c_f_lr")}
    rows = [[f"{eta:g}", *("" if np.isnan(means[k]) else plus_minus(means[k], errors[k])
                           for means, errors in columns.values())]
            for k, eta in enumerate(value["O1"]["eta"])]
    return table(["η", *columns], rows)


def stationarity():
    """Change of a_c over the averaged strains of the study."""
    value = published("study")["O15"]["value"]
    columns = (value[name] for name in ("eta", "a_c", "a_c_drift", "a_c_drift_error"))
    rows = [[f"{eta:g}", f"{curve[-1]:.3f}", f"{change:+.3f} ± {error:.3f}",
             "yes" if is_steady(change, error) else "no"]
            for eta, curve, change, error in zip(*columns)]
    return table(["η", "a_c", "change of a_c", "stationary within two errors"], rows)


def examples():
    """Scripts in examples/ with their first lines and pictures."""
    lines = []
    for script in sorted((ROOT / "examples").glob("*.py")):
        first = ast.get_docstring(ast.parse(script.read_text())).splitlines()[0]
        exists = (DOCS / "pictures" / f"{script.stem}.png").exists()
        picture = f"![{script.stem}](pictures/{script.stem}.png)" if exists else ""
        lines.append([f"[`{script.name}`](../examples/{script.name})", first, picture])
    return table(["script", "story", "picture"], lines)


def named(header, texts):
    """Table of names in code type and their texts."""
    return table(header, [[f"`{name}`", text] for name, text in texts.items()])


def colors():
    shown = {name: re.sub(r"\$(.*?)\$", r"\1", scale.label) for name, scale in SCALES.items()}
    any_color = {"'#e8e4da'": "this or any other colour of Matplotlib"}
    return named(["color", "shows"], shown | CATEGORIES | any_color)


def contact_colors():
    shape = "segments from centre to contact to centre"
    return named(["contacts", shape], CONTACTS)


def quantities():
    plain = lambda label: label.replace("$", "").replace("\\sigma_{xy}", "σ_xy")
    texts = {name: plain(label) for name, (label, *_) in QUANTITIES.items()}
    return named(["quantity", "is"], texts)


def counterparts():
    """Classes of YADE and their counterparts."""
    rows = [[", ".join(f"`{name}`" for name in names), re.sub(r"^(\S+)", r"`\1`", counterpart)]
            for counterpart, names in COUNTERPARTS.items()]
    return table(["of YADE", "of rcr"], rows)


TABLES = {
    "one-step": lambda: ratios("a", "a-one-step", lambda row: any(row[1:])),
    "one-step-residual": lambda: ratios("a", "a-one-step", lambda row: float(row[0]) >= 1e-6,
                                        printed="residuals"),
    "one-step-default": lambda: ratios("a", "a-one-step", lambda row: float(row[0]) <= 500,
                                       printed="default_steps"),
    "large-packings": lambda: ratios("j", "j-large-packings", lambda row: row[2] != "cold" and (
        row[3] not in ("nesterov", "nlgs") or row[4] in ("80", "320", "1280", "5120")), columns=[
            "grains", "η", "method", "sweeps", "time [s]", "residual", "estimate", "velocities",
            "forces", "8 × 8 cells", "2 × 2 cells"]),
    "biaxial-steps": lambda: ratios("c", "c-biaxial-cost", printed="true_errors"),
    "estimate": lambda: ratios("g", "g-estimate"),
    "known-forces": lambda: ratios("h", "h-known-forces", lambda row: row[1] in ("nlgs", "auto")),
    "size": lambda: ratios("f", "f-size"),
    "size-true-error": lambda: ratios("f", "f-size", printed="true_errors"),
    "study": lambda: statements("study"),
    "cegeo": lambda: statements("cegeo-2012", "cegeo_2012"),
    "estrada": lambda: statements("estrada-2011", "estrada_2011"),
    "accuracy": lambda: ratios("i", "i-accuracy", columns=[
        "η", "error of a step", "estimate", "sweeps a step", "missed steps", "change of forces",
        "β_n", "a_c(ξ = 0.5)", "a_c(ξ = 1)", "I_M", "sin φ"]),
} | {function.__name__.replace("_", "-"): function for function in (
    colors, contact_colors, quantities, counterparts, hard_scenes, stability, examples,
    quasi_static, slow_shear, step_threads, parallel, points_of_sides, driven_scenes, meetings,
    spring_energy, fabric, long_grains, short_grains, sweeps_of_tests, compactions, stationarity,
    study_means)}


def updated(page):
    """Text of a page with its present tables."""
    return MARK.sub(lambda match: match[1] + TABLES[match[2]]() + match[3], page)


def main():
    parser = argparse.ArgumentParser(prog="tables.py", description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true",
                        help="write nothing; exit with 1 if a page is out of date")
    check = parser.parse_args().check
    stale = []
    for page in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]:
        text = page.read_text()
        if (new := updated(text)) != text:
            stale.append(page.name)
            if not check:
                page.write_text(new)
    if check and stale:
        sys.exit(f"tables.py: out of date: {', '.join(stale)}; run docs/generate/tables.py")


if __name__ == "__main__":
    main()
