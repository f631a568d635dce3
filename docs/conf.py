"""Configuration of the documentation, which ``make docs`` builds without network access."""

import hashlib
import os
import re
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

from sphinx.util.inspect import TypeAliasForwardRef

HERE = Path(__file__).parent
ARRAY = re.compile(r"\bArray\b")
sys.path.insert(0, os.fspath(HERE))
import bibliography  # noqa: E402
import command_pages  # noqa: E402
import material_table  # noqa: E402
import navigation  # noqa: E402
import reference_pages  # noqa: E402
import schema_tables  # noqa: E402

project = "hertzchain"
author = "The hertzchain developers"
project_copyright = author
version = release = metadata.version("hertzchain")

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx_click",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_generated", "examples", "gallery/*.ipynb", "gallery/*.py"]
templates_path = ["_templates"]
default_role = "py:obj"
# Replace only quotes; two hyphens begin an option and must not become a dash.
smartquotes_action = "q"

myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Types are in the signatures; the docstrings describe them in words.
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
# Shown by name instead of the long unions that they are.
autodoc_type_aliases = {
    "Array": "ndarray", "ArrayLike": "ArrayLike", "MaterialLike": "MaterialLike",
}  # fmt: skip
# Within unions, Sphinx shows the representation of its class of aliases.
TypeAliasForwardRef.__repr__ = lambda self: self.name
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
# One page per object; `reference_pages` provides the names of the members for the templates.
autosummary_context = reference_pages.context()
autosummary_imported_members = False

# Notebooks: scripts in `examples` are executed and become the pages in `gallery`.  A notebook is
# executed again only if it or the package has changed.
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_",
    "within_subsection_order": "FileNameSortKey",
    "backreferences_dir": "gallery/backreferences",
    "doc_module": ("hertzchain",),
    "prefer_full_module": [],
    "abort_on_example_error": True,
    "show_memory": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "image_srcset": ["2x"],
    "image_scrapers": ("gallery_images.scrape",),
    "thumbnail_size": (480, 300),
    "download_all_examples": False,
    "remove_config_comments": True,
    "ignore_repr_types": r"matplotlib",
    "show_signature": False,
}

html_theme = "pydata_sphinx_theme"
html_title = f"hertzchain {version}"
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_copy_source = False
# The index of modules lists internal ones; the pages of the reference have summary tables.
html_domain_indices = False
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
    "pygments_light_style": "a11y-high-contrast-light",
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
    import figures

    folder = HERE / "_generated"
    sources = [
        HERE / f"{name}.py"
        for name in (
            "figures",
            "page_figures",
            "howto_figures",
            "experiment_figures",
            "paper_figures",
            "law_figures",
            "local_rate_figures",
        )
    ]
    # Figures of their tables.
    pages = [HERE / "explanation" / f"{name}.md" for name in ("against_others", "how_fast")]
    digest = package_digest(*sources, *pages)
    names = [folder / f"{name}.svg" for name in figures.FIGURES]
    stamp = folder / "digest.txt"
    if not (all(map(Path.exists, names)) and stamp.exists() and stamp.read_text() == digest):
        figures.draw_all(folder)
        stamp.write_text(digest)


def package_digest(*more: Path, without: tuple[str, ...] = ()) -> str:
    """Digest of the package and of further files: figures are redrawn if it changes."""
    package = HERE.parent / "src" / "hertzchain"
    files = [*sorted(package.rglob("*.py")), *sorted(package.rglob("*.mplstyle"))]
    used = [path for path in files if path.relative_to(package).parts[0] not in without]
    found = hashlib.sha256()
    for path in [*used, *more]:
        found.update(path.read_bytes())
    return found.hexdigest()


def forget_old_notebooks(_: Any) -> None:
    """Execute all notebooks again if the package has changed."""
    gallery = HERE / "gallery"
    gallery.mkdir(exist_ok=True)
    stamp = gallery / "digest.txt"
    # No notebook uses these subpackages.
    digest = package_digest(HERE / "gallery_images.py", without=("app", "cli", "paper"))
    if not (stamp.exists() and stamp.read_text() == digest):
        for path in gallery.glob("*.md5"):
            path.unlink()
        stamp.write_text(digest)


def copy_changelog(_: Any) -> None:
    """Copy the changelog, if there is one, so that it becomes a page."""
    source = HERE.parent / "CHANGELOG.md"
    text = source.read_text("utf-8") if source.exists() else "# Changelog\n\nNone yet.\n"
    (HERE / "_generated" / "changelog.md").write_text(text, "utf-8")


def write_tables(_: Any) -> None:
    """Write the tables that the package contains, from keys of chain files to materials."""
    tables = {"chain_file_keys": schema_tables.chain_file_page(),
              "calibration": schema_tables.calibration_table(),
              "balls": schema_tables.ball_table(),
              "commands": command_pages.command_table(),
              "materials": material_table.material_table(),
              "bibliography": bibliography.bibliography_page()}  # fmt: skip
    for name, text in tables.items():
        page = HERE / "_generated" / f"{name}.md"
        if not page.exists() or page.read_text("utf-8") != text:
            page.write_text(text, "utf-8")


def name_aliases(_: Any, *about: Any) -> tuple[str | None, str | None]:
    """Write the name of the type of arrays where Sphinx does not evaluate annotations."""
    signature, result = about[-2:]
    return tuple(text and ARRAY.sub("ndarray", text) for text in (signature, result))


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
    # Before sphinx-gallery, which has the default priority of 500.
    app.connect("builder-inited", forget_old_notebooks, priority=400)
    app.connect("builder-inited", copy_changelog)
    app.connect("builder-inited", write_tables)
    app.connect("autodoc-process-signature", name_aliases)
    app.connect("sphinx-click-process-description", command_pages.examples_as_blocks)
    app.add_transform(command_pages.PlainQuotes)
    app.connect("doctree-read", strip_blocks)
    # Before the theme, which renders all templates to find empty ones.
    app.connect("html-page-context", navigation.add_navigation, priority=400)
