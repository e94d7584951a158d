"""Settings of the site for Sphinx; see build.py."""

import importlib.util
import pathlib
import re

project = "yade-rcr"
author = "the authors of yade-rcr"
package = pathlib.Path(__file__).parents[1] / "py" / "rcr" / "__init__.py"
release = re.search(r'^__version__ = "(.*)"', package.read_text(), re.M)[1]

extensions = ["myst_parser"]
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
