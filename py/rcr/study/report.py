"""Tables, pictures and report of an analysis: everything that `scripts/network.py` writes. Needs NumPy, h5py and Matplotlib."""

import base64
import html
import io
import json
import pathlib
import tempfile

import numpy as np
from PIL import Image  # Matplotlib brings it

from rcr import __version__, _files as files
from rcr.study import figures, maps
from rcr.study.analysis import analyse, jsonable
from rcr.study.claims import AGREES, DIFFERS, NOT_TESTED, findings
from rcr.study.paper import MAPS, nearest

_HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Force networks of elongated particles</title><style>
body { font: 15px/1.45 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; width: 100%; font-size: 13px }
th, td { border-top: 1px solid #ccc; padding: 4px 8px; text-align: left; vertical-align: top }
td.yes { background: #dff0d8 } td.no { background: #f6d5d2 } td.open { background: #eee }
small { color: #666 } figure { margin: 2em 0 } img { max-width: 100%; height: auto } img.curve { max-height: 34em }
</style></head><body>
"""
_CLASS = {AGREES: "yes", DIFFERS: "no", NOT_TESTED: "open"}


def write(runs, out, progress=lambda name: None, analysis=None, begin=lambda: None):
    """Analyse runs and write analysis.json, report.html, table.md and every figure as PNG and PDF into a folder.

    All of them are made beside the old ones and take their places at the end.

    Parameters
    ----------
    runs : list of Run
    out : path
        Folder, made if missing.
    progress : callable
        Called with the name of what comes next.
    analysis : dict
        What `rcr.study.analysis.analyse` has found, if it has been called already.
    begin : callable
        Called when everything is made, before it takes its place.

    Returns
    -------
    list of Finding
        The table paper against measured.

    Raises
    ------
    ValueError
        If the runs cannot be analysed together; nothing is written then.
    """
    if analysis is None:
        progress("analysis")
        analysis = analyse(runs)
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
            picture = figures.save(maps.draw(key, network), folder / f"{key}-eta-{network.attributes['eta']:g}")[0]
            analysis[key]["value"].setdefault("files", []).append(picture.name)
            pictures[key].append(picture)
        table = findings(analysis)
        (folder / "analysis.json").write_text(json.dumps(jsonable(analysis), allow_nan=False))
        (folder / "table.md").write_text(markdown(table), encoding="utf-8")
        (folder / "report.html").write_text(_page(runs, analysis, table, pictures), encoding="utf-8")
        begin()
        for path in sorted(folder.iterdir()):
            files.write(out / path.name, path.read_bytes())
    return table


def _map_networks(runs):
    """(observable, its network): the isotropic state for O2, the last snapshot for the others, of the first seed."""
    etas = [run.eta for run in runs]
    for key, wanted in MAPS.items():
        for eta in nearest(etas, wanted):
            run = runs[etas.index(eta)]
            network = run.isotropic if key == "O2" else run.networks[-1]
            if network is not None:
                network.attributes["eta"] = eta
                yield key, network


def _page(runs, analysis, table, pictures):
    parts = [_HEAD, "<h1>Force networks of elongated particles</h1>", f"<p>{_material(runs, analysis)}</p>"]
    parts += ["<h2>Paper against measured</h2>", f"<p>{summary(table)}. {_RULE}</p>", _table(table), "<h2>Figures</h2>"]
    for key, entry in analysis.items():
        images = "".join(_image(path) for path in pictures[key])
        parts.append(f"<figure id='{key}'>{images}<figcaption><b>{key}</b> Paper: {html.escape(entry['paper'])}.</figcaption></figure>")
    return "\n".join([*parts, f"<p><small>yade-rcr {__version__}</small></p></body></html>\n"])


_RULE = (
    "A value agrees within its tolerance or two standard errors, a trend has to exceed two standard errors; errors are those of the"
    " mean over seeds, of fewer than three seeds over snapshots. The small print under each statement is its criterion."
)


def summary(table):
    """How many statements agree, in words."""
    count = {verdict: sum(row.verdict == verdict for row in table) for verdict in _CLASS}
    return f"{count[AGREES]} of {len(table)} statements agree, {count[DIFFERS]} do not, {count[NOT_TESTED]} are not tested"


def _material(runs, analysis):
    value = analysis["O1"]["value"]
    strains = [float(network.attributes["strain"]) for run in runs for network in run.networks]
    rows = zip(value["eta"], value["particles"], value["seeds"], value["snapshots"], value["contacts"])
    listed = "; ".join(f"η = {eta:g}: {n:.0f} particles, {seeds} seed(s), {s} snapshots, {c} contacts" for eta, n, seeds, s, c in rows)
    state = f"Critical state: snapshots at strains from {min(strains):.3f} to {max(strains):.3f}. {listed}."
    return " ".join([state, _drifts(analysis), _boxes(runs), _misses(runs)])


def _drifts(analysis):
    """How far a_c goes on changing over the snapshots."""
    value = analysis["O15"]["value"]
    rows = [(eta, change, error) for eta, change, error in zip(value["eta"], value["a_c_drift"], value["a_c_drift_error"]) if np.isfinite(change)]
    if not rows:
        return "Too few snapshots tell whether a_c is stationary."
    return f"Change of a_c over these strains: {'; '.join(f'η = {eta:g}: {change:+.2f} ± {error:.2f}' for eta, change, error in rows)}."


def _boxes(runs):
    """Shape of the box and inertia of the sample at the ends of the tests, of the runs that tell it."""
    told = [run.summary for run in runs if {"aspect_ratio", "sample_inertia"} <= set(run.summary or ())]
    if not told:
        return "No run tells the shape of its box."
    widths, inertia = ([summary[name] for summary in told] for name in ("aspect_ratio", "sample_inertia"))
    return f"At the end the boxes are {min(widths):.1f} to {max(widths):.1f} times as wide as high, and ρ (ε̇ W)² is at most {max(inertia):.1g} of σ₀."


def _misses(runs):
    """How often and by how much the steps of the shear missed the tolerances of the solver, of the runs that tell it."""
    named = "missed_fraction", "missed_mean", "missed_max"
    told = {}
    for run in runs:
        numbers = [(run.summary or {}).get(name) for name in named]
        if all(isinstance(value, (int, float)) for value in numbers):
            told.setdefault(run.eta, []).append(numbers)
    if not told:
        return "No run tells how many of its steps missed the tolerance of the solver."
    parts = []
    for eta, rows in sorted(told.items()):
        share, mean, largest = zip(*rows)
        if not any(share):
            parts.append(f"η = {eta:g}: none")
            continue
        times = sum(a * b for a, b in zip(share, mean)) / sum(share)
        parts.append(f"η = {eta:g}: {100 * sum(share) / len(share):.1f} %, by a factor of {times:.2g} in the mean, {max(largest):.2g} at most")
    return f"Steps that missed the tolerance of the solver or of its velocities: {'; '.join(parts)}."


def _table(table):
    head = "<tr><th></th><th>Paper</th><th>Measured</th><th>Error</th><th>Verdict</th></tr>"
    return f"<table>{head}{''.join(_row(row) for row in table)}</table>"


def markdown(table):
    """The table for a README."""
    rows = [("", "paper", "measured", "error", "verdict"), ("---",) * 5]
    rows += [(row.observable, row.statement, row.value, row.error, row.verdict) for row in table]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in rows)


def _row(row):
    text = {name: html.escape(getattr(row, name)) for name in ("statement", "criterion", "value", "error", "verdict")}
    return (
        f"<tr><td><a href='#{row.observable}'>{row.observable}</a></td><td>{text['statement']}<br><small>{text['criterion']}</small></td>"
        f"<td>{text['value']}</td><td>{text['error']}</td><td class='{_CLASS[row.verdict]}'>{text['verdict']}</td></tr>"
    )


def _image(path):
    """A picture inside the page; maps, large as PNG, as WebP."""
    kind, data, media = "curve", path.read_bytes(), "png"
    if "-" in path.stem:
        kind, data, media = "map", _webp(path), "webp"
    return f"<img class='{kind}' alt='{path.stem}' src='data:image/{media};base64,{base64.b64encode(data).decode()}'>"


def _webp(path):
    stream = io.BytesIO()
    with Image.open(path) as image:
        image.convert("RGB").save(stream, "webp", quality=80)
    return stream.getvalue()
