"""Images of the notebooks: alternative texts, and thumbnails of one panel without letters.

Two comments of a notebook configure them, and do not appear in it:
`# sphinx_gallery_alt_2 = "Forces"` sets the alternative text of its second figure, and
`# sphinx_gallery_thumbnail_panel = (2, 0)` takes the first axes of that figure as thumbnail, by
default those of the first figure.
"""

import copy
import os
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.legend import Legend
from matplotlib.text import Text
from sphinx_gallery.scrapers import matplotlib_scraper

THUMBNAIL = (3.2, 2.0)  # in inches
DPI = 150
ALT = re.compile(r"^( +:alt:).*$", re.MULTILINE)


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures of a block, and return their reStructuredText."""
    settings = block_vars["file_conf"]
    first = len(block_vars["image_path_iterator"]) + 1
    numbers = range(first, first + len(plt.get_fignums()))
    figures = dict(zip(numbers, map(plt.figure, plt.get_fignums()), strict=True))
    wanted, panel = settings.get("thumbnail_panel", (1, 0))
    text = matplotlib_scraper(block, block_vars, gallery_conf)
    if wanted in numbers:
        whole = Path(block_vars["image_path_iterator"].image_path.format(wanted))
        path = whole.with_name(f"{whole.stem}_panel.png")
        _save_panel(figures[wanted], panel, path)
        settings["thumbnail_path"] = os.path.relpath(path, gallery_conf["src_dir"])
    alternatives = iter([settings.get(f"alt_{number}") for number in numbers])

    def replace(found: re.Match[str]) -> str:
        alternative = next(alternatives)
        return found[0] if alternative is None else f"{found[1]} {alternative}"

    return ALT.sub(replace, text)


def _save_panel(figure: Any, panel: int, path: Path) -> None:
    """Save one of the axes of a figure without letters, which thumbnails are too small for."""
    # Later blocks of the notebook may use the figure.
    figure = copy.deepcopy(figure)
    axes = figure.axes[panel]
    for each in figure.axes:
        each.set_visible(each is axes)
    figure.set_layout_engine("none")
    figure.set_size_inches(*THUMBNAIL)
    axes.set_aspect("auto")  # so that maps fill the thumbnail
    axes.set_position((0.02, 0.03, 0.96, 0.94))
    axes.tick_params(which="both", length=0)
    for text in figure.findobj(Text):
        text.set_visible(False)
    for legend in figure.findobj(Legend):
        legend.set_visible(False)
    for line in axes.lines:
        line.set_linewidth(1.8 * line.get_linewidth())
        line.set_markersize(1.3 * line.get_markersize())
    figure.savefig(path, dpi=DPI, bbox_inches=None)
    plt.close(figure)
