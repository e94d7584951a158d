#!/usr/bin/env python3
"""Tables of the pages, from the files that were measured. A page names what it wants:

<!-- table: NAME -->
…
<!-- end -->

and this script writes it in between. `--check` writes nothing and ends with 1 where a page is not what it would write.
"""

import argparse
import ast
import csv
import math
import pathlib
import re
import statistics
import sys

DOCS = pathlib.Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path[:0] = [str(ROOT), str(ROOT / "py")]
MARK = re.compile(r"(<!-- table: (\S+) -->\n).*?(<!-- end -->)", re.S)


def table(header, rows):
    cell = lambda text: str(text).replace("|", "\\|")
    return "".join("| " + " | ".join(map(cell, row)) + " |\n" for row in [header, ["---"] * len(header), *rows])


def chart_rows(name):
    with open(DOCS / "results" / "charts" / f"{name}.csv", newline="") as file:
        number = lambda key, cell: cell if key in ("point", "status", "command", "law", "scene", "title", "verdict") else _number(cell)
        return [{key: number(key, cell) for key, cell in row.items()} for row in csv.DictReader(file)]


def _number(cell):
    try:
        return float(cell)
    except ValueError:
        return cell


def ratios(chart, name, function="ratios"):
    """The table that scripts/chart.py prints beside this chart, or another of its module."""
    from benchmarks import charts

    header, _, *lines = (line.split(" | ") for line in getattr(charts.chart(chart), function)(chart_rows(name)))
    return table(header, [[re.sub(r"(\d(?:\.\d+)?)e\+0*(\d+)", lambda m: f"{float(m[0]):g}", cell.strip()) for cell in line] for line in lines])


def scene_module(name):
    """TITLE, PREDICATE, … of a hard scene, read without YADE."""
    told = {}
    for node in ast.parse((ROOT / "benchmarks" / "hard_scenes" / f"{name}.py").read_text()).body:
        if not isinstance(node, ast.Assign):
            continue
        target, value = node.targets[0], node.value
        pairs = zip(target.elts, value.elts) if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) else [(target, value)]
        for name_node, constant in pairs:
            if isinstance(constant, ast.Constant):
                told[name_node.id] = constant.value
            elif isinstance(constant, ast.Attribute) and name_node.id.isupper():  # of another scene
                told[name_node.id] = scene_module(constant.value.id)[constant.attr]
    return told


def hard_scenes():
    cell = {(row["scene"], row["law"], row["dt"]): row for row in chart_rows("d-stability") if row["status"] == "ok"}
    rows = []
    for name in dict.fromkeys(scene for scene, _, _ in cell):
        scene = scene_module(name)
        told = lambda law, dt: f"{row['verdict']} ({row['measured']:.1g})" if (row := cell.get((name, law, dt))) else ""
        rows.append([f"{name[:3].upper().replace('S0', 'S')} {scene['TITLE']}", scene["PREDICATE"], f"{scene['BOUND']:g}", told("cd", 1e-3), told("cd", 1e-2), told("smooth", 1e-4)])
    return table(["scene", "must hold", "bound", "rigid, 1 ms", "rigid, 10 ms", "springs, 0.1 ms"], rows)


def stability():
    """How many scenes hold, drift or blow up."""
    rows = [row for row in chart_rows("d-stability") if row["status"] == "ok"]
    steps = sorted({row["dt"] for row in rows})
    lines = []
    for law, title in (("cd", "rigid contacts"), ("smooth", "springs, E = 10⁸ Pa")):
        counts = lambda dt: [sum(row["law"] == law and row["dt"] == dt and row["verdict"] == verdict for row in rows) for verdict in ("holds", "drifts", "blows up")]
        lines.append([title, *(" / ".join(map(str, counts(dt))) for dt in steps)])
    return table(["hold / drift / blow up at dt =", *(f"{1e3 * dt:g} ms" for dt in steps)], lines)


def cell_against_walls():
    """Means over seeds, with their standard errors, of what scripts/cell_shear.py wrote."""
    with open(DOCS / "results" / "charts" / "cell-shear.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    lines = []
    for eta, geometry in dict.fromkeys((row["eta"], row["geometry"]) for row in rows):
        of = lambda name: [float(row[name]) for row in rows if (row["eta"], row["geometry"]) == (eta, geometry)]
        told = lambda name, digits: f"{statistics.mean(of(name)):.{digits}f} ± {statistics.stdev(of(name)) / len(of(name)) ** 0.5:.{digits}f}"
        lines.append([f"η = {float(eta):g}, {geometry}", told("packing_fraction_initial", 4), told("sin_phi", 3), told("packing_fraction", 4), told("a_c_half", 3), told("a_c_weak", 3)])
    return table(["", "packing fraction at rest", "q/p", "packing fraction in shear", "a_c(ξ = 0.5)", "a_c(ξ = 1)"], lines)


def step_threads():
    """The shortest step of each packing, with one and with two threads, in what scripts/bench_step.py wrote."""
    with open(DOCS / "results" / "charts" / "step-threads.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["way"] == "arrays"]
    lines = []
    for folder in dict.fromkeys(row["folder"] for row in rows):
        of = [row for row in rows if row["folder"] == folder]
        one, two = (min(float(row["ms_least"]) for row in of if row["threads"] == threads) for threads in "12")
        lines.append([of[0]["grains"], f"{float(of[0]['eta']):g}", of[0]["points"], f"{one:.2g}", f"{two:.2g}", f"{one / two:.2f}"])
    return table(["grains", "η", "contact points", "one thread [ms]", "two threads [ms]", "ratio"], lines)


def driven_scenes():
    """The worst of each motion in what benchmarks/driven_scenes.py wrote."""
    with open(DOCS / "results" / "charts" / "driven-scenes.csv", newline="") as file:
        rows = [{key: _number(cell) for key, cell in row.items()} for row in csv.DictReader(file)]
    bound = lambda row: 10 * row["speed"] + (2 * 9.81 * row["fall_rigid"]) ** 0.5
    quotients = [lambda row: row["fastest_rigid"] / bound(row), lambda row: row["force_rigid"] / row["force_springs"], lambda row: row["slowest_rigid"] / row["median_rigid"]]
    lines = []
    for motion in [*dict.fromkeys(row["motion"] for row in rows), "all"]:
        of = [row for row in rows if motion in (row["motion"], "all")]
        broken = [name for row in of for name in str(row["broken"]).split()]
        lines.append([
            motion, len(of), sum(row["yielded_rigid"] > 0 for row in of), *(f"{max(map(quotient, of)):.2g}" for quotient in quotients),
            sum(row["stopped_rigid"] < math.inf for row in of), sum(row["crushed_springs"] < math.inf for row in of),
            ", ".join(f"{name} {broken.count(name)}" for name in dict.fromkeys(broken)) or "none",
        ])  # fmt: skip
    header = ["motion", "scenes", "with contacts that yield", "speed over its bound", "force over that of springs", "slowest step over the median", "guard spoke", "springs crushed", "bounds broken"]
    return table(header, lines)


def examples():
    lines = []
    for script in sorted((ROOT / "examples").glob("*.py")):
        first = ast.get_docstring(ast.parse(script.read_text())).splitlines()[0]
        picture = f"![{script.stem}](pictures/{script.stem}.png)" if (DOCS / "pictures" / f"{script.stem}.png").exists() else ""
        lines.append([f"[`{script.name}`](../examples/{script.name})", first, picture])
    return table(["script", "story", "picture"], lines)


def colors():
    from rcr.plot import CATEGORIES, SCALES

    shown = {name: re.sub(r"\$(.*?)\$", r"\1", scale.label) for name, scale in SCALES.items()}
    return table(["color", "shows"], [[f"`{name}`", text] for name, text in {**shown, **CATEGORIES, "'#e8e4da'": "this or any other colour of Matplotlib"}.items()])


def contact_colors():
    from rcr.plot import CONTACTS

    return table(["contacts", "segments from centre to contact to centre, as thick as the normal force"], [[f"`{name}`", text] for name, text in CONTACTS.items()])


def quantities():
    from rcr.profile import QUANTITIES

    return table(["quantity", "is"], [[f"`{name}`", label.replace("$", "").replace("\\sigma_{xy}", "σ_xy")] for name, (label, *_) in QUANTITIES.items()])


def counterparts():
    """Read without YADE."""
    tree = ast.parse((ROOT / "py" / "rcr" / "_counterparts.py").read_text())
    (known,) = (ast.literal_eval(node.value) for node in tree.body if isinstance(node, ast.Assign))
    return table(["of YADE", "of rcr"], [[", ".join(f"`{name}`" for name in names), re.sub(r"^(\S+)", r"`\1`", counterpart)] for counterpart, names in known.items()])


TABLES = {
    "colors": colors,
    "contact-colors": contact_colors,
    "quantities": quantities,
    "counterparts": counterparts,
    "one-step": lambda: ratios("a", "a-one-step"),
    "deterministic": lambda: ratios("b", "b-deterministic"),
    "biaxial-cost": lambda: ratios("c", "c-biaxial-cost"),
    "hard-scenes": hard_scenes,
    "stability": stability,
    "study": lambda: (DOCS / "results" / "inertial" / "table.md").read_text().rstrip("\n") + "\n",
    "study-quasi-static": lambda: (DOCS / "results" / "quasi-static" / "table.md").read_text().rstrip("\n") + "\n",
    "quasi-static": lambda: ratios("e", "e-quasi-static"),
    "other-steps": lambda: ratios("e", "e-quasi-static", "other_steps"),
    "examples": examples,
    "step-threads": step_threads,
    "cell-against-walls": cell_against_walls,
    "driven-scenes": driven_scenes,
}


def written(text):
    """The page with its tables anew."""
    return MARK.sub(lambda match: match[1] + TABLES[match[2]]() + match[3], text)


def main():
    parser = argparse.ArgumentParser(prog="tables.py", description="Write the tables of the pages from the files that were measured.")
    parser.add_argument("--check", action="store_true", help="write nothing; end with 1 where a table is not that of its files")
    check = parser.parse_args().check
    stale = []
    for page in [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]:
        text = page.read_text()
        if (now := written(text)) != text:
            stale.append(page.name)
            if not check:
                page.write_text(now)
    if check and stale:
        sys.exit(f"tables.py: not the tables of their files: {', '.join(stale)}; run docs/tables.py")


if __name__ == "__main__":
    main()
