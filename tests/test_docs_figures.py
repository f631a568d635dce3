"""Figures of the documentation: images of notebooks, and values that pages state."""

import ast
import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

DOCS = Path(__file__).parent.parent / "docs"


@pytest.fixture(autouse=True)
def docs_on_path(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    # Two folders may have modules of the same name.
    for name in ("gallery_images", "experiment_figures"):
        monkeypatch.delitem(sys.modules, name, raising=False)


def test_the_figure_of_the_hammer_shows_the_row_of_the_page():
    import experiment_figures

    page = (DOCS / "how-to" / "hammer.md").read_text("utf-8")
    order = re.search(r"^order: striker[^,]*, (.+)$", page, re.M)[1].split(", ")
    diameters = []
    for part in order:
        count, diameter = re.fullmatch(r"(?:(\d+) x )?([\d.]+ mm) steel-52100", part).groups()
        diameters += int(count or 1) * [diameter]
    assert tuple(diameters) == experiment_figures.DESIGNED


def test_images_of_notebooks_have_their_texts_and_a_panel_as_thumbnail(tmp_path):
    pytest.importorskip("sphinx_gallery")
    import gallery_images
    from sphinx_gallery.scrapers import ImagePathIterator

    paths = ImagePathIterator(tmp_path / "image_{:03}.png")
    settings = {"alt_2": "Forces over time", "thumbnail_panel": (2, 1)}
    block_vars = {"image_path_iterator": paths, "file_conf": settings}
    conf = {"image_srcset": [], "matplotlib_animations": (False, "html"), "compress_images": (),
            "src_dir": str(tmp_path)}  # fmt: skip
    texts = []
    for titles in (["wave"], ["ball 6", "crest"]):
        _, panels = plt.subplots(1, len(titles), squeeze=False)
        for axes, title in zip(panels[0], titles, strict=True):
            axes.set_title(title)
        texts.append(gallery_images.scrape(None, block_vars, conf))
    assert ":alt: wave\n" in texts[0]
    assert ":alt: Forces over time\n" in texts[1]
    assert settings["thumbnail_path"] == "image_002_panel.png"
    # The second panel fills the picture and has no letters: only its frame is dark.
    panel = plt.imread(tmp_path / "image_002_panel.png")[:, :, :3].mean(axis=2)
    assert panel.shape == (300, 480)
    assert (panel[15:-15, 15:-15] == 1.0).all()
    assert (panel < 0.5).any()


def test_alternative_texts_of_images_are_phrases():
    for path in (DOCS / "examples").glob("*.py"):
        text = path.read_text("utf-8")
        for number, alternative in re.findall(r"^# sphinx_gallery_alt_(\d) = (.+)$", text, re.M):
            assert int(number) >= 1
            assert len(ast.literal_eval(alternative)) > 20
