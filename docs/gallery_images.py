"""Images of the notebooks: alternative texts, and thumbnails of one panel.

Two comments of a notebook configure them, and do not appear in it:
`# sphinx_gallery_alt_2 = "Forces"` sets the alternative text of its second figure, and
`# sphinx_gallery_thumbnail_panel = (2, 0)` takes the first axes of that figure as thumbnail.
"""

import io
import os
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from PIL import Image
from sphinx_gallery.scrapers import matplotlib_scraper

DPI = 150
ALT = re.compile(r"^( +:alt:).*$", re.MULTILINE)


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures of a block, and return their reStructuredText."""
    settings = block_vars["file_conf"]
    first = len(block_vars["image_path_iterator"]) + 1
    numbers = range(first, first + len(plt.get_fignums()))
    wanted, panel = settings.get("thumbnail_panel", (0, 0))
    if wanted in numbers:
        whole = Path(block_vars["image_path_iterator"].image_path.format(wanted))
        path = whole.with_name(f"{whole.stem}_panel.png")
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
    image = io.BytesIO()
    figure.savefig(image, dpi=DPI)
    # Cut out of the image: with ``bbox_inches``, the layout would change.
    inches = figure.axes[panel].get_tightbbox().padded(4.0).extents / figure.dpi
    left, bottom, right, top = DPI * inches
    height = DPI * figure.get_figheight()
    with Image.open(image) as whole:
        box = (max(0.0, left), max(0.0, height - top), min(whole.width, right), height - bottom)
        whole.crop(tuple(map(round, box))).save(path)
