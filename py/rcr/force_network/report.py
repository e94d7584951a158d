"""Report on force networks of any scene: analysis.json, figures and report.html."""

import html
import json
import math
import re

from rcr._data.files import jsonable
from rcr._pictures import drawing, html_page
from rcr.force_network import figures
from rcr.force_network.analysis import analyse

MADE = ["analysis.json", "report.html", *(f"{name}.p[nd][gf]" for name in (
    "normal-forces", "tangential-forces", "directions", "fabric", "map-*", "chains-*"))]
_ROWS = (  # name, value of the measures of a set, what it is
    ("networks", lambda m: f"{m['networks']}", "saved networks, whose contacts are pooled"),
    ("grains", lambda m: f"{m['grains']:.0f}", "grains of a network"),
    ("contacts", lambda m: f"{m['contacts']}", "contacts between grains, pairs of all networks"),
    ("Z", lambda m: _text(m["coordination_number"]),
     "contacts of a grain, those with obstacles included, without rattlers"),
    ("⟨f_n⟩", lambda m: f"{m['mean_normal_force']:.4g} N/m", "mean normal force between grains"),
    ("weak share", lambda m: _text(m["weak_share"]), "share of contacts with f_n ≤ ⟨f_n⟩"),
    ("α_n", lambda m: _fit(m["normal_force"], "alpha"),
     "exponent of P(f_n) ∝ exp(−α_n f_n/⟨f_n⟩) above the mean"),
    ("β_n", lambda m: _fit(m["normal_force"], "beta"),
     "exponent of P(f_n) ∝ (f_n/⟨f_n⟩)^β_n below the mean"),
    ("α_t, β_t", lambda m: ", ".join(_fit(m["tangential_force"], name) for name in (
        "alpha", "beta")), "the same of |f_t|"),
    ("a_c", lambda m: _text(m["a_c"][-1]), "anisotropy of the contact normals along σ₁"),
    ("a_fn, a_ft", lambda m: f"{_text(m['a_fn'][-1])}, {_text(m['a_ft'][-1])}",
     "anisotropies of normal and tangential forces along σ₁"),
    ("q/p", lambda m: _text(m["q_over_p"][-1]),
     "stress ratio of the contacts between grains; those with obstacles do not count"),
    ("θσ", lambda m: f"{math.degrees(m['stress_angle']):.0f}°", "direction of σ₁ from x"),
    ("I_M", lambda m: _text(m["friction_mobilization"]), "mean of |f_t|/(µ f_n)"),
    ("C(f, ℓ)", lambda m: _text(m["c_f_l"]), "correlation of force and branch length"),
    ("chains", lambda m: _chains(**m["chains"]),
     "force chains of a network; rule: Peters et al. 2005"),
    ("in chains", lambda m: _text(m["chains"]["share"]), "share of the grains with a contact"),
)
_CAPTIONS = {
    "normal-forces": "Probability density of the normal forces between grains over their mean, in "
                     "log-linear and in log-log axes. Lines are the fits: an exponential above the "
                     "mean, a power law from 0.01 to 1 of the mean.",
    "tangential-forces": "The same of the sizes of the tangential forces.",
    "directions": "Left: probability density of the directions of contact normals. Right: mean "
                  "normal force by direction over the mean of all contacts.",
    "fabric": "Anisotropy of the normals, and stress ratio, of the contacts with f_n ≤ ξ ⟨f_n⟩. "
              "Both are over all contacts: at ξ = 1 the weak contacts alone, at large ξ all.",
}


def write(sets, out, progress=lambda name: None, begin=lambda: None):
    """Analyse the `NetworkSet`s; write analysis.json, report.html and the figures to a folder.

    No file is replaced before all files are complete. `progress` is called with "analysis", each
    figure and "report", `begin` before a file is replaced. The function returns the measures.
    """
    progress("analysis")
    measures = analyse(sets)
    with html_page.scratch(out, begin) as folder:
        parts = [f"<p class='lead'>{_lead(measures)}</p>", _table(measures)]
        for name, make in _figures(sets, measures).items():
            progress(name)
            picture = drawing.save(figures.draw(*make), folder / name)[0]
            parts.append(html_page.figure(name, [picture], _caption(name)))
        progress("report")
        (folder / "analysis.json").write_text(json.dumps(jsonable(measures), allow_nan=False))
        page = html_page.page("Force network", parts)
        (folder / "report.html").write_text(page, encoding="utf-8")
    return measures


def _figures(sets, measures):
    """Return {name of a figure: function and its arguments}."""
    made = {"normal-forces": (figures.forces, measures)}
    if any(one["tangential_force"] for one in measures.values()):
        made["tangential-forces"] = figures.forces, measures, "tangential"
    made |= dict(directions=(figures.directions, measures), fabric=(figures.fabric, measures))
    for one in sets:
        name = re.sub(r"[^\w.-]+", "-", one.name)
        made[f"map-{name}"] = figures.map_of, one.networks[-1]
        made[f"chains-{name}"] = figures.chains_of, one.networks[-1]
    return made


def summary(measures):
    """Return the size of the analysis as a sentence part."""
    networks, contacts = (sum(one[name] for one in measures.values()) for name in (
        "networks", "contacts"))
    return f"{networks} network{'s' * (networks > 1)}, {contacts} contacts between grains"


def _lead(measures):
    return (f"{summary(measures)}. Contacts with obstacles count in Z and in the direction of σ₁ "
            "only. Errors are those of the fits. “unknown”: too few contacts, or no coefficient of "
            "friction in the file.")


def _table(measures):
    rows = []
    for title, value, meaning in _ROWS:
        cells = "".join(f"<td>{value(one)}</td>" for one in measures.values())
        rows.append(f"<tr><th>{title}</th>{cells}<td><small>{meaning}</small></td></tr>")
    heads = "".join(f"<th>{html.escape(name)}</th>" for name in measures)
    return f"<table><tr><th></th>{heads}<th></th></tr>{''.join(rows)}</table>"


def _caption(name):
    kind, _, of = name.partition("-")
    if kind == "map":
        return (f"Last network of {html.escape(of)}: normal forces as thickness of segments, red up "
                "to the mean of the contacts drawn, those with obstacles too, and black above.")
    if kind == "chains":
        return (f"Last network of {html.escape(of)}: grains of force chains, coloured by the number "
                "of grains in the chain. These grains have a σ₁ above the mean; the branch "
                "vectors between them are within 45° of their axes of σ₁.")
    return _CAPTIONS[name]


def _text(value):
    text = f"{abs(value):.3g}"
    return "unknown" if math.isnan(value) else f"−{text}" if value < 0 else text


def _chains(count, grains, longest, **_):
    """Return the number of chains and their sizes; the mean of no chain is unknown."""
    sizes = f", with {grains:.3g} grains on average, {longest} at most" if count else ""
    return f"{count:.3g}{sizes}"


def _fit(found, name):
    """Return an exponent with its error, both with the first digit of the error as their last."""
    if found is None or math.isnan(found[name]):
        return "unknown"
    value, error = found[name], found[f"{name}_error"]
    digits = max(0, -math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}".replace("-", "−")
