"""Files of an analysis: tables, pictures and report. Needs NumPy, h5py and Matplotlib."""

import base64
import html
import io
import json
import pathlib
import tempfile

import numpy as np
from PIL import Image  # Matplotlib brings it

from rcr import __version__
from rcr._data import checks, files
from rcr.study import figures
from rcr.study.analysis import analyse, jsonable
from rcr.study.claims import AGREES, DIFFERS, NOT_TESTED, findings
from rcr.study.claims.statements import MAPS, nearest
from rcr.study.figures import maps
from rcr.study.runs import group_by_eta

_HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<title>Force networks of elongated particles</title><style>
body { font: 15px/1.45 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; width: 100%; font-size: 13px }
th, td { border-top: 1px solid #ccc; padding: 4px 8px; text-align: left; vertical-align: top }
td.yes { background: #dff0d8 } td.no { background: #f6d5d2 } td.open { background: #eee }
small { color: #666 } figure { margin: 2em 0 }
img { max-width: 100%; height: auto } img.curve { max-height: 34em }
</style></head><body>
"""
FEWEST = 1000  # grains from which on the verdicts of the table mean something
_SMALL = (f"A test has fewer than {FEWEST} grains. The figures show what the study measures, but "
          "the verdicts below are grey: chance and walls decide many of them. ")
_RULE = ("A value agrees within its tolerance or two standard errors. A trend must exceed two "
         "standard errors. Errors are those over seeds, or over networks with fewer than three "
         "seeds. The small print under each statement is its criterion.")
HEADER = "", "paper", "agrees if", "measured", "error", "verdict"
_TITLES = "<tr><th></th><th>Paper</th><th>Measured</th><th>Error</th><th>Verdict</th></tr>"
_CLASS = {AGREES: "yes", DIFFERS: "no", NOT_TESTED: "open"}


def write(runs, out, progress=lambda name: None, begin=lambda: None):
    """Analyse runs; write analysis.json, report.html, table.md and all figures to a folder.

    Figures are PNG and PDF. No file is replaced before all files are complete. `progress` is called
    with "analysis", each figure and "report", `begin` before a file is replaced. The function
    returns the table paper against measured, a list of `Finding`. Runs that cannot be analysed
    together raise a ValueError.
    """
    progress("analysis")
    analysis = analyse(runs)
    material = _material(runs, analysis)  # refuses damaged summaries before the figures are drawn
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=files.PART, dir=out) as scratch:
        folder = pathlib.Path(scratch)
        pictures = {key: [] for key in analysis}
        for key in figures.FIGURES:
            progress(key)
            pictures[key] += figures.save(figures.draw(key, analysis), folder / key)[:1]
        for key, network in _map_networks(runs):
            progress(f"{key} map")
            stem = folder / f"{key}-eta-{network.attributes['eta']:g}"
            picture = figures.save(maps.draw(key, network), stem)[0]
            analysis[key]["value"].setdefault("files", []).append(picture.name)
            pictures[key].append(picture)
        progress("report")
        table = findings(analysis)
        (folder / "analysis.json").write_text(json.dumps(jsonable(analysis), allow_nan=False))
        (folder / "table.md").write_text(markdown(HEADER, table), encoding="utf-8")
        page = _page(material, has_small_packing(runs), analysis, table, pictures)
        (folder / "report.html").write_text(page, encoding="utf-8")
        begin()
        for path in sorted(folder.iterdir()):
            files.write(out / path.name, path.read_bytes())
    return table


def _map_networks(runs):
    """Yield each map's observable and network of a first seed: isotropic (O2) or last."""
    etas = [run.eta for run in runs]
    for key, targets in MAPS.items():
        for eta in nearest(etas, targets):
            run = runs[etas.index(eta)]
            network = run.isotropic if key == "O2" else run.networks[-1]
            if network is not None:
                yield key, network


def has_small_packing(runs):
    """Return whether a packing is too small for verdicts."""
    return min(len(run.networks[0].particles["id"]) for run in runs) < FEWEST


def _page(material, small, analysis, table, pictures):
    rows = "".join(_row(row, small) for row in table)
    parts = [_HEAD, "<h1>Force networks of elongated particles</h1>",
             f"<p>{material}</p>", "<h2>Paper against measured</h2>",
             f"<p>{_SMALL if small else ''}{summary(table)}. {_RULE}</p>",
             f"<table>{_TITLES}{rows}</table>", "<h2>Figures</h2>"]
    for key, entry in analysis.items():
        images = "".join(_image(path) for path in pictures[key])
        caption = f"<b>{key}</b> Paper: {html.escape(entry['paper'])}."
        parts.append(f"<figure id='{key}'>{images}<figcaption>{caption}</figcaption></figure>")
    return "\n".join([*parts, f"<p><small>yade-rcr {__version__}</small></p></body></html>\n"])


def summary(table):
    """Return the number of statements that agree, as a sentence."""
    count = {verdict: sum(row.verdict == verdict for row in table) for verdict in _CLASS}
    agree = f"{count[AGREES]} of {len(table)} statements agree, {count[DIFFERS]} do not"
    return f"{agree}, {count[NOT_TESTED]} are not tested"


def _material(runs, analysis):
    """Describe the runs: size, drift, boxes, and errors of the solver."""
    value = analysis["O1"]["value"]
    strains = [float(network.attributes["strain"]) for run in runs for network in run.networks]
    columns = ("eta", "particles", "seeds", "networks", "contacts")
    form = "η = {:g}: {:.0f} particles, {} seed(s), {} networks, {} contacts"
    listed = "; ".join(form.format(*row) for row in zip(*(value[name] for name in columns)))
    window = f"{min(strains):.3f} to {max(strains):.3f}"
    state = f"Critical state: networks at strains from {window}. {listed}."
    return " ".join([state, _drifts(analysis), _boxes(runs), unconverged_steps(runs),
                     yielded_steps(runs), cost(runs)])


def _drifts(analysis):
    """Describe the change of a_c over the networks."""
    value = analysis["O15"]["value"]
    columns = zip(value["eta"], value["a_c_drift"], value["a_c_drift_error"])
    rows = [row for row in columns if np.isfinite(row[1])]
    if not rows:
        return "The change of a_c over the strain is unknown: there are too few networks."
    listed = "; ".join(f"η = {eta:g}: {change:+.2f} ± {error:.2f}" for eta, change, error in rows)
    return f"Change of a_c over these strains: {listed}."


def _boxes(runs):
    """Describe the shape of the box and the inertia of the sample at the ends of the tests."""
    rows = _of_summaries(runs, "aspect_ratio", "sample_inertia")
    if not rows:
        return "No summary.json has the shape of the box."
    widths, inertia = zip(*rows)
    return (f"At the end the boxes are {min(widths):.1f} to {max(widths):.1f} times as wide as "
            f"high, and ρ (ε̇ W)² is at most {max(inertia):.1g} of σ₀.")


def cost(runs):
    """Describe the wall time and the memory of the tests."""
    rows = _of_summaries(runs, "wall_seconds", "peak_memory_bytes")
    if not rows:
        return "No summary.json has the cost of its test."
    seconds, memory = zip(*rows)
    return (f"The tests took {sum(seconds) / 60:.1f} min of wall time in all and "
            f"{max(seconds) / 60:.1f} min the longest one; their largest memory was "
            f"{max(memory) / 2**30:.2f} GiB.")


def _of_summaries(runs, *names):
    """Return these numbers of each run whose summary has all of them, [(number, …)]."""
    rows = [tuple(_of_summary(run, name) for name in names) for run in runs]
    return [row for row in rows if None not in row]


def _of_summary(run, name):
    """Return a number of a summary, None if it is missing."""
    value = (run.summary or {}).get(name)
    where = f"{run.folder / 'summary.json'}: {name}"
    return None if value is None else checks.number(where, value)


def unconverged_steps(runs):
    """Describe the steps of the shear that missed the tolerances of the solver."""
    parts = []
    for eta, group in group_by_eta(runs).items():
        rows = _of_summaries(group, "missed_fraction", "missed_mean", "missed_max")
        if not rows:
            continue
        share, mean, largest = zip(*rows)
        text = "none"
        if any(share):
            factor = sum(a * b for a, b in zip(share, mean)) / sum(share)
            text = (f"{100 * sum(share) / len(share):.1f} %, by a factor of {factor:.2g} in the "
                    f"mean, {max(largest):.2g} at most")
        parts.append(f"η = {eta:g}: {text}")
    if not parts:
        return "No summary.json counts the steps that missed the tolerance of the solver."
    return f"Steps that missed a tolerance of the solver: {'; '.join(parts)}."


def yielded_steps(runs):
    """Describe the steps without a solution in the critical state."""
    known = [run for run in runs if run.yielded is not None]
    if not known:
        return "No history counts the steps without a solution."
    parts = []
    for eta, group in group_by_eta(known).items():
        steps, marked, records, networks, _ = map(sum, zip(*(run.yielded for run in group)))
        text = f"η = {eta:g}: {steps}"
        if steps:
            text += f", in {marked} of {records} records, with {networks} network(s)"
        parts.append(text)
    included = any(run.yielded.included for run in known)
    use = "count in the means" if included else "are left out of the means"
    marked = any(run.yielded.steps for run in known)
    end = f" Their records and networks {use}." if marked else ""
    return f"Steps without a solution: {'; '.join(parts)}.{end}"


def markdown(header, rows):
    """Return a table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    escaped = ([str(cell).replace("|", "\\|") for cell in line] for line in lines)
    return "".join("| " + " | ".join(line) + " |\n" for line in escaped)


def _row(row, grey):
    observable, statement, criterion, value, error, verdict = map(html.escape, row)
    link = f"<a href='#{observable}'>{observable}</a>"
    said = f"{statement}<br><small>{criterion}</small>"
    shade = "open" if grey else _CLASS[row.verdict]
    cells = "".join(f"<td>{cell}</td>" for cell in (link, said, value, error))
    return f"<tr>{cells}<td class='{shade}'>{verdict}</td></tr>"


def _image(path):
    """Return a picture as HTML; maps as WebP, since their PNG is large."""
    kind, data, media = "curve", path.read_bytes(), "png"
    if "-" in path.stem:
        kind, media, stream = "map", "webp", io.BytesIO()
        Image.open(path).convert("RGB").save(stream, "webp", quality=80)
        data = stream.getvalue()
    source = f"data:image/{media};base64,{base64.b64encode(data).decode()}"
    return f"<img class='{kind}' alt='{path.stem}' src='{source}'>"
