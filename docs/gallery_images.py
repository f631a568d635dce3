"""Images of the notebooks: alternative texts, and thumbnails of one panel.

Two comments of a notebook configure them, and do not appear in it:
`# sphinx_gallery_alt_2 = "Forces"` sets the alternative text of its second figure, and
`# sphinx_gallery_thumbnail_panel = (2, 0)` takes the first axes of that figure as thumbnail.
"""

import os
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from sphinx_gallery.scrapers import matplotlib_scraper

ALT = re.compile(r"^( +:alt:).*$", re.MULTILINE)


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures of a block, and return their reStructuredText."""
    settings = block_vars["file_conf"]
    first = len(block_vars["image_path_iterator"]) + 1
    numbers = range(first, first + len(plt.get_fignums()))
    wanted, panel = settings.get("thumbnail_panel", (0, 0))
    if wanted in numbers:
        image = Path(block_vars["image_path_iterator"].image_path.format(wanted))
        path = image.with_name(f"{image.stem}_panel.png")
        _save_panel(plt.figure(plt.get_fignums()[wanted - first]), panel, path)
        settings["thumbnail_path"] = os.path.relpath(path, gallery_conf["src_dir"])
    text = matplotlib_scraper(block, block_vars, gallery_conf)
    alternatives = iter([settings.get(f"alt_{number}") for number in numbers])

    def replace(found: re.Match[str]) -> str:
        alternative = next(alternatives)
        return found[0] if alternative is None else f"{found[1]} {alternative}"

    return ALT.sub(replace, text)


def _save_panel(figure: Any, panel: int, path: Path) -> None:
    """Save one of the axes of a figure, with its labels."""
    figure.canvas.draw()
    box = figure.axes[panel].get_tightbbox().padded(4.0)
    figure.savefig(path, bbox_inches=box.transformed(figure.dpi_scale_trans.inverted()), dpi=150)
