# SPDX-License-Identifier: LGPL-3.0-or-later
"""How Sphinx makes the site: `make docs`."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import inventories  # noqa: E402

project = "fretfe"
author = "The fretfe developers"
copyright = "The fretfe developers"
release = version = installed_version("fretfe")

extensions = ["docstrings", "mathml", "myst_parser", "sphinx.ext.autodoc"]
extensions += ["sphinx.ext.intersphinx", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["demos/**"]

myst_enable_extensions = ["dollarmath"]
myst_dmath_double_inline = False
myst_heading_anchors = 4
suppress_warnings = ["misc.highlighting_failure"]

default_role = "py:obj"
highlight_language = "none"
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_type_aliases = {"Array": "Array", "ArrayLike": "ArrayLike", "Side": "Side"}
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88
intersphinx_mapping = inventories.write(HERE.parents[1] / "build" / "docs" / "inventories")

html_theme = "furo"
html_title = "fretfe"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_search_scorer = str(HERE / "scorer.js")
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": True,
    "light_css_variables": {"color-brand-primary": "#0b5a8a", "color-brand-content": "#0b5a8a"},
    "dark_css_variables": {"color-brand-primary": "#7cc4f0", "color-brand-content": "#7cc4f0"},
}
pygments_style = "default"
