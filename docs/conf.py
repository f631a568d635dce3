"""Configuration of the documentation, which ``make docs`` builds without network access."""

import os
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent

project = "hertzchain"
author = "The hertzchain developers"
project_copyright = author
version = release = metadata.version("hertzchain")

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx_click",
]
exclude_patterns = ["_build", "_generated"]
templates_path = ["_templates"]
default_role = "py:obj"
# Replace only quotes; two hyphens begin an option and must not become a dash.
smartquotes_action = "q"

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# The docstrings state the types; signatures are easier to read without them.
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False

html_theme = "pydata_sphinx_theme"
html_title = f"hertzchain {version}"
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_copy_source = False
html_show_sourcelink = False
html_sidebars = {"**": ["nav.html"]}
html_theme_options = {
    "navbar_center": [],
    "navbar_persistent": [],
    "navbar_end": ["search-button-field", "theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
    "pygments_light_style": "friendly",
}
# Without its menu, MathJax loads no further files.
mathjax3_config = {"options": {"enableMenu": False}, "svg": {"scale": 0.92}}
mathjax_path = "tex-svg.js"


def use_local_mathjax(_: Any, config: Any) -> None:
    """Use one file of MathJax 3 from an installed package."""
    mathjax = metadata.distribution("sphinx-mathjax-offline")
    script = mathjax.locate_file("sphinx-mathjax-offline/static/mathjax/tex-svg.js")
    config.html_static_path.append(os.fspath(script))


def draw_figures(_: Any) -> None:
    """Draw the figures of the pages."""
    import matplotlib as mpl

    mpl.use("agg")
    sys.path.insert(0, os.fspath(HERE))
    import figures

    figures.draw_all(HERE / "_generated")


def copy_changelog(_: Any) -> None:
    """Copy the changelog, if there is one, so that it becomes a page."""
    source = HERE.parent / "CHANGELOG.md"
    text = source.read_text("utf-8") if source.exists() else "# Changelog\n\nNone yet.\n"
    (HERE / "_generated" / "changelog.md").write_text(text, "utf-8")


def strip_blocks(_: Any, doctree: Any) -> None:
    """Remove the empty last line of code blocks, which only doctests need."""
    from docutils import nodes

    for block in doctree.findall(nodes.literal_block):
        text = block.astext().rstrip("\n")
        block[:] = [nodes.Text(text)]
        block.rawsource = text


def setup(app: Any) -> None:
    """Register the functions above."""
    app.connect("config-inited", use_local_mathjax)
    app.connect("builder-inited", draw_figures)
    app.connect("builder-inited", copy_changelog)
    app.connect("doctree-read", strip_blocks)
