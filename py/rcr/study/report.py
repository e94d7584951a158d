"""Files of an analysis: tables, pictures and report. Needs NumPy, h5py and Matplotlib."""

import html
import json

from rcr._data.files import jsonable
from rcr._pictures import drawing, html_page
from rcr.plot import packing
from rcr.study import figures, report_text
from rcr.study.analysis import analyse
from rcr.study.claims import AGREES, DIFFERS, NOT_TESTED, findings
from rcr.study.claims.statements import MAPS, nearest
from rcr.study.figures import maps
from rcr.study.figures.captions import CAPTIONS

TITLE = "Force networks of elongated particles"
_RULE = ("A value agrees within its tolerance or two standard errors; a trend must exceed two "
         "standard errors. The small print under each statement is its criterion; measured "
         "values have their elongation η in brackets.")
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
    table = findings(analysis)
    # refuses damaged summaries before the figures are drawn
    lead, material = report_text.lead(runs, analysis, table), report_text.material(runs, analysis)
    with html_page.scratch(out, begin) as folder:
        pictures = {key: [] for key in analysis}
        for key in figures.FIGURES:
            progress(key)
            pictures[key] += drawing.save(figures.draw(key, analysis), folder / key)[:1]
        for key, network in _map_networks(runs):
            progress(f"{key} map")
            stem = folder / f"{key}-eta-{network.attributes['eta']:g}"
            picture = drawing.save(maps.draw(key, network), stem)[0]
            analysis[key]["value"].setdefault("files", []).append(picture.name)
            pictures[key].append(picture)
        progress("report")
        (folder / "analysis.json").write_text(json.dumps(jsonable(analysis), allow_nan=False))
        (folder / "table.md").write_text(markdown(HEADER, table), encoding="utf-8")
        parts = [*(f"<p class='lead'>{sentence}</p>" for sentence in lead),
                 _first_figures(runs, analysis),
                 *_tables(table, report_text.has_small_packing(runs)),
                 f"<h2>Tests and errors</h2><p>{material}</p>", "<h2>Figures</h2>",
                 *(_figure(key, entry, pictures[key]) for key, entry in analysis.items())]
        (folder / "report.html").write_text(html_page.page(TITLE, parts), encoding="utf-8")
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


def _first_figures(runs, analysis):
    """Return the four figures of the first screen, each with a link to its large one."""
    run = max(runs, key=lambda run: run.eta)
    shown = [("O1", "Shear strength against elongation; dashed: the paper."),
             ("O6", f"Contact forces at η = {run.eta:g}: black above the mean, red up to it; the "
              "thicker the larger."),
             ("O3", "How often a normal force of a given size occurs; the mean is 1."),
             ("O15", "Anisotropy of the contacts with forces up to ξ times the mean; positive: "
              "more contacts along the largest stress σ₁.")]
    drawn = {key: figures.draw_small(key, analysis) for key in figures.SMALL}
    drawn["O6"] = packing(run.networks[-1], color="0.88", contacts="force", legend=False).figure
    parts = [f"<figure><a href='#{key}'>{html_page.drawn(drawn[key], key)}</a><figcaption>{text}"
             "</figcaption></figure>" for key, text in shown]
    return f"<div class='four'>{''.join(parts)}</div>"


def _tables(table, small):
    """Return the heading and the tables of tested and, folded away, of other statements."""
    tested = [row for row in table if row.verdict != NOT_TESTED]
    others = [row for row in table if row.verdict == NOT_TESTED]
    parts = [f"<h2>Paper against measured</h2><p>{summary(table)}. {_RULE}</p>",
             f"<table>{_TITLES}{''.join(_row(row, small) for row in tested)}</table>"]
    if others:
        rows = "".join(_row(row, small) for row in others)
        parts.append(f"<details><summary>{len(others)} statements that are not tested, with the "
                     f"reasons</summary><table>{_TITLES}{rows}</table></details>")
    return parts


def _figure(key, entry, pictures):
    paper = f"<br><small>Paper: {html.escape(entry['paper'])}.</small>"
    return html_page.figure(key, pictures, f"<b>{key}</b> {html.escape(CAPTIONS[key])}{paper}")


def summary(table):
    """Return the number of statements that agree, as a sentence."""
    count = report_text.verdicts(table)
    agree = f"{count[AGREES]} of {len(table)} statements agree, {count[DIFFERS]} do not"
    return f"{agree}, {count[NOT_TESTED]} are not tested"


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
