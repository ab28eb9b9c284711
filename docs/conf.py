"""Sphinx settings of the manual. Everything that a page needs is in the built folder: no network."""

import re
from importlib.metadata import version as version_of

project = "inertialcal"
author = "the inertialcal developers"
version = release = version_of("inertialcal")

extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc"]
source_suffix = {".rst": "restructuredtext", ".md": "markdown"}
exclude_patterns = ["build"]
suppress_warnings: list[str] = []
nitpicky = False

myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc states type, shape and unit of each argument
numpydoc_show_class_members = False
autosummary_generate = False
numpydoc_xref_param_type = False

html_theme = "furo"
html_title = f"inertialcal {version}"
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
html_static_path = ["style"]
html_css_files = ["custom.css"]


def setup(app):
    """Connect what is adapted here."""
    app.connect("autodoc-process-docstring", references_as_list, priority=100)  # before numpydoc


def references_as_list(app, what, name, obj, options, lines):
    """Turn citations into plain text: a function may cite the references of its module."""
    for i, line in enumerate(lines):
        lines[i] = re.sub(r"^(\s*)\.\. \[(\d+)\] ", r"\1\2. ", re.sub(r"\[(\d+)\]_", r"[\1]", line))
