"""The site of the documentation: `make docs` builds it in docs/_build/html."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "python"))  # the checkout, whatever is installed

import lidardraft

project = "lidardraft"
author = "the lidardraft authors"
copyright = "the lidardraft authors"
release = lidardraft.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinxarg.ext"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "lidardraft"
html_show_copyright = html_show_sourcelink = html_copy_source = False
pygments_style = "friendly"
highlight_language = "text"
smartquotes = False  # `--option` stays as it is

myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

default_role = "code"  # docstrings write `name`
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
