"""Settings of the site for Sphinx; see build.py."""

import importlib.util
import pathlib
import sys

import yade  # noqa: F401: rcr loads its plugin into it
from rcr import __version__ as release

sys.path.insert(0, str(pathlib.Path(__file__).parent / "generate"))
from reference import escaped

DESIGN = pathlib.Path(__file__).parents[1] / "pkg" / "README.md"

project = "yade-rcr"
author = "the authors of yade-rcr"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
autodoc_member_order = "bysource"
autodoc_typehints_format = "fully-qualified"
napoleon_use_rtype = False
myst_heading_anchors = 3
default_role = "code"  # `x` in docstrings
add_module_names = False
toc_object_entries_show_parents = "hide"

exclude_patterns = ["results", "generate"]

themes = "furo", "sphinx_rtd_theme", "alabaster"
html_theme = next(name for name in themes if importlib.util.find_spec(name))
html_title = f"yade-rcr {release}"
html_static_path = ["static"]
html_css_files = ["wide.css"]
html_copy_source = False
html_show_copyright = False


def setup(app):
    def escape(app, what, name, thing, options, lines):
        lines[:] = escaped("\n".join(lines)).splitlines()

    def insert_design(app, page, source):
        if page == "design":
            source[0] = DESIGN.read_text().replace("](../docs/", "](")
        source[0] = source[0].replace("../pkg/README.md", "design.md")

    app.connect("autodoc-process-docstring", escape, priority=400)  # before napoleon
    app.connect("source-read", insert_design)
