"""Files of an analysis: tables, pictures and report. Needs NumPy, h5py and Matplotlib."""

import html
import json

import matplotlib

from rcr import papers
from rcr._data.files import jsonable
from rcr._pictures import drawing, html_page, network_maps
from rcr.observables.registry import OBSERVABLES
from rcr.plot import packing
from rcr.study import report_text
from rcr.study.analysis import analyse
from rcr.study.paper import AGREES, DIFFERS, NOT_TESTED

TITLE = "Force networks of elongated particles"
MADE = ["table.md", *(f"{key}{rest}" for key in OBSERVABLES for rest in (".p[nd][gf]", "-eta-*"))]
_RULE = ("A value agrees within its tolerance or two standard errors; a trend must exceed two "
         "standard errors. The small print under each statement is its criterion; measured "
         "values have their elongation η in brackets.")
_FIRST_SIZE = 0.72  # of a figure of the first screen, over that of its page: legible text
HEADER = "", "paper", "agrees if", "measured", "error", "verdict"
_TITLES = "<tr><th></th><th>Paper</th><th>Measured</th><th>Error</th><th>Verdict</th></tr>"
_CLASS = {AGREES: "yes", DIFFERS: "no", NOT_TESTED: "open"}


def write(runs, out, progress=lambda name: None, begin=lambda: None, paper=None):
    """Analyse runs; write analysis.json, report.html, table.md and all figures to a folder.

    Figures are PNG and PDF. No file is replaced before all files are complete. `progress` is called
    with "analysis", each figure and "report", `begin` before a file is replaced. The function
    returns the table paper against measured, a list of `Finding`. Runs that cannot be analysed
    together raise a ValueError. `paper` is by default `rcr.papers.DEFAULT`.
    """
    progress("analysis")
    paper = papers.load() if paper is None else paper
    analysis = analyse(runs, paper)
    table = paper.findings(analysis)
    # refuses damaged summaries before the figures are drawn
    lead = report_text.lead(runs, analysis, table, paper)
    material = report_text.material(runs, analysis)
    with html_page.scratch(out, begin) as folder:
        pictures = {key: [] for key in analysis}
        for key in analysis:
            shown = key in paper.statements or not paper.compares
            if OBSERVABLES[key].figure and shown:
                progress(key)
                pictures[key] += drawing.save(draw(key, analysis, paper), folder / key)[:1]
        for key, network in _map_networks(runs, paper):
            progress(f"{key} map")
            stem = folder / f"{key}-eta-{network.attributes['eta']:g}"
            picture = drawing.save(network_maps.draw(network, *OBSERVABLES[key].map), stem)[0]
            analysis[key]["value"].setdefault("files", []).append(picture.name)
            pictures[key].append(picture)
        progress("report")
        (folder / "analysis.json").write_text(json.dumps(jsonable(analysis), allow_nan=False))
        (folder / "table.md").write_text(markdown(HEADER, table), encoding="utf-8")
        parts = [*(f"<p class='lead'>{sentence}</p>" for sentence in lead),
                 _first_figures(runs, analysis, paper),
                 *_tables(table, report_text.has_small_packing(runs)),
                 f"<h2>Tests and errors</h2><p>{material}</p>", "<h2>Figures</h2>",
                 *(_figure(key, entry, pictures[key]) for key, entry in analysis.items()
                   if pictures[key])]
        (folder / "report.html").write_text(html_page.page(TITLE, parts), encoding="utf-8")
    return table


def draw(key, analysis, paper, small=False):
    """Return the figure of an observable of a result of `analyse`, or its `small` one."""
    one = OBSERVABLES[key]
    with matplotlib.rc_context(drawing.STYLE):
        figure = one.small if small and one.small else one.figure
        return figure(analysis[key]["value"], analysis, paper)


def nearest(etas, targets):
    """Return the elongations nearest to the targets, each once, rising."""
    return sorted({min(etas, key=lambda eta: abs(eta - target)) for target in targets})


def _map_networks(runs, paper):
    """Yield each map's observable and network of a first seed: isotropic (O2) or last."""
    etas = [run.eta for run in runs]
    for key in paper.observables():
        for eta in nearest(etas, paper.maps.get(key, etas if OBSERVABLES[key].map else ())):
            run = runs[etas.index(eta)]
            network = run.isotropic if key == "O2" else run.networks[-1]
            if network is not None:
                yield key, network


def _first_figures(runs, analysis, paper):
    """Return the figures of the first screen, each with a link to its large one."""
    run, parts = max(runs, key=lambda run: run.eta), []
    for key, text in paper.first:
        if key == "map":
            key, text = "O6", text.format(run.eta)
            axes = packing(run.networks[-1], color="0.88", contacts="force", legend=False)
            figure = axes.figure
        else:
            figure = draw(key, analysis, paper, small=True)
            figure.set_size_inches(_FIRST_SIZE * figure.get_size_inches())
        parts.append(f"<figure><a href='#{key}'>{html_page.drawn(figure, key)}</a><figcaption>"
                     f"{text}</figcaption></figure>")
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
    said = entry["paper"] and f"<br><small>Paper: {html.escape(entry['paper'])}.</small>"
    caption = f"<b>{key}</b> {html.escape(OBSERVABLES[key].caption)}{said}"
    return html_page.figure(key, pictures, caption)


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
