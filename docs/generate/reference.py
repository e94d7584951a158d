#!/usr/bin/env python3
"""Write the pages of docs/reference: classes of the plugin, and Python modules for autodoc.

Run it with YADE:  scripts/lib/run python3 docs/generate/reference.py
"""

import functools
import pathlib
import re
import shutil
import textwrap

OUT = pathlib.Path(__file__).resolve().parents[1] / "reference"
MODULES = {
    "rcr": "Scenes and steps",
    "rcr.scene": "Bodies",
    "rcr.polygons": "Polygons",
    "rcr.plot": "Pictures",
    "rcr.export": "Files for ParaView",
    "rcr.measure": "Measures",
    "rcr.network": "Contact networks",
    "rcr.force_statistics": "Forces of a network",
    "rcr.distributions": "Distributions of forces and directions",
    "rcr.force_chains": "Force chains",
    "rcr.profile": "Fields on a grid",
    "rcr.frame": "A scene as arrays",
    "rcr.table": "Columns of grains and contacts",
    "rcr.outlines": "Outlines of polygons",
    "rcr.xi_networks": "ξ-networks",
    "rcr.problems": "Contact problems in files",
    "rcr.script": "Options of scripts",
    "rcr.study.biaxial": "The biaxial test",
    "rcr.study.protocol": "Constants of the biaxial test",
    "rcr.study.analysis": "Observables of the study",
    "rcr.observables.registry": "Registry of observables",
    "rcr.observables.packings": "Shear strength and isotropic packings",
    "rcr.observables.forces": "Forces and friction",
    "rcr.observables.branches": "Branch vectors and contact types",
    "rcr.observables.xi_networks": "Observables of ξ-networks",
    "rcr.ensemble": "Pooled networks",
    "rcr.force_network.analysis": "Force networks of any scene",
    "rcr.study.paper": "Statements of a paper",
}
# Headings and the first words of their classes; other classes are engines.
KINDS = {
    "Shapes and bounds": ("Rcr", "RoundedPolygon", "Bo1"),
    "Geometry of contacts": ("RcrGeom", "Ig2"),
    "Laws": ("CdPhys", "RcrFrictPhys", "Ip2", "Law2"),
    "Drawing": ("Gl1",),
}
READONLY = 2  # YADE's Attr::readonly
indented = functools.partial(textwrap.indent, prefix="   ")


def heading(text, line):
    return f"{text}\n{line * len(text)}\n"


def escaped(text):
    """Escape signs of reStructuredText outside literals."""
    parts = re.split(r"(``.*?``|`[^`]*`)", text, flags=re.S)
    escape = lambda part: re.sub(
        r"(^\s*\* )|([|*])", lambda m: m[1] or "\\" + m[2], part, flags=re.M)
    return "".join(part if k % 2 else escape(part) for k, part in enumerate(parts))


def from_yade(text, classes):
    """Docstring of YADE with references and formulas in the syntax of Sphinx."""

    def reference(match):
        shown, target = re.fullmatch(r"(.*?)(?:<(.*)>)?", match[1], re.S).groups()
        target = target or shown
        if target.split(".")[0] not in classes:
            return f"``{shown}``"
        return f":py:{'attr' if '.' in target else 'class'}:`{shown} <{target}>`"

    prose = lambda part: re.sub(r":yref:`([^`]*)`", reference, escaped(part))
    parts = re.split(r"(\$.*?\$)", text, flags=re.S)
    formula = lambda part: f":math:`{part[1:-1]}`"
    return "".join(formula(part) if k % 2 else prose(part) for k, part in enumerate(parts))


def attribute(name, doc, classes):
    marks = dict(re.findall(r":(ydefault|yattrtype|yattrflags):`([^`]*)`", doc))
    text = re.sub(r"\s*:(ydefault|yattrtype|yattrflags):`[^`]*`", "", doc).strip()
    head = f".. py:attribute:: {name}\n"
    if marks:
        head += f"   :type: {marks['yattrtype'].split('::')[-1]}\n"
        if int(marks["yattrflags"]) & READONLY:
            text += " (read only)"
        elif marks["ydefault"]:
            head += f"   :value: {marks['ydefault']}\n"
    return head + "\n" + indented(from_yade(text, classes))


def yade_class(cls, classes):
    base = cls.__bases__[0].__name__
    about, *static = re.split(r"\.\. ystaticattr:: ", cls.__doc__ or "")
    lines = [f".. py:class:: {cls.__name__}\n",
             indented(f"Base: ``{base}``. {from_yade(about.strip(), classes)}") + "\n"]
    for text in static:
        pattern = r"\w+\.(\w+)\(=(.*?)\)\s*(.*?)\s*"
        name, value, about = re.fullmatch(pattern, text, re.S).groups()
        head = f".. py:attribute:: {name}\n   :value: {value}\n\n"
        lines.append(indented(head + indented(from_yade(about, classes))))
    for name, value in sorted(vars(cls).items()):
        if isinstance(value, property) and value.__doc__:
            lines.append(indented(attribute(name, value.__doc__, classes)))
    return "\n".join(lines) + "\n"


def yade_page():
    import yade  # noqa: F401: rcr loads its plugin into it

    import rcr
    from rcr import _plugin

    classes = {name: getattr(rcr, name) for name in _plugin.classes}
    page = [heading("Classes of YADE", "="), "Classes that ``import rcr`` adds to YADE. "
            "``O.save`` and ``O.load`` keep their attributes.\n"]
    kind = {word: title for title, words in KINDS.items() for word in words}
    for title in ["Engines", *KINDS]:
        page.append("\n" + heading(title, "-"))
        page += [yade_class(classes[name], classes) for name in sorted(classes)
                 if kind.get(name.split("_")[0], "Engines") == title]
    return "\n".join(page)


SESSION = "advance contact_network critical_time_step half_step_start info movie".split()


def python_page(name, title):
    """Page of a module for autodoc; that of `rcr` has the functions that no other page has."""
    page = [heading(f"{title}: {name}", "="), f".. automodule:: {name}"]
    if name == "rcr":
        page += ["", *(f".. autofunction:: rcr.{function}" for function in SESSION)]
    else:
        page += ["   :members:"]
    return "\n".join(page) + "\n"


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir()
    pages = {"yade": yade_page()}
    pages |= {name: python_page(name, title) for name, title in MODULES.items()}
    contents = heading("Reference", "=") + "\nMade from the docstrings of classes and functions.\n"
    contents += "\n.. toctree::\n   :maxdepth: 1\n\n" + indented("\n".join(pages)) + "\n"
    for name, text in {"index": contents, **pages}.items():
        (OUT / f"{name}.rst").write_text(text)


if __name__ == "__main__":
    main()
