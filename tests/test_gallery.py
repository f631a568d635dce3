"""The notebooks of the gallery; the build of the documentation executes them."""

import ast
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"
NOTEBOOKS = sorted((DOCS / "examples").glob("*.py"))


def test_there_are_at_least_twelve_notebooks():
    assert len(NOTEBOOKS) >= 12
    assert [path.name[:2] for path in NOTEBOOKS] == [
        f"{number:02}" for number in range(1, len(NOTEBOOKS) + 1)
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_begins_with_a_question_and_ends_with_an_answer(path):
    text = path.read_text("utf-8")
    title = ast.get_docstring(ast.parse(text)).strip().splitlines()[0]
    assert title.endswith("?")
    blocks = text.split("\n# %%\n")
    headings = re.findall(r"^# (.+)\n# -+$", text, re.M)
    assert headings[-1] == "Answer"
    # Its numbers are computed by the last cell, and figures show what is behind them.
    assert blocks[-1].startswith("# Answer\n# ------\n")
    assert "print(" in blocks[-1]
    assert re.search(r"plt\.subplots|\.plot\(", text)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_code_of_a_notebook_fits_into_its_box(path):
    """Wider lines are cut off at the right edge of the page; text is wrapped."""
    text = path.read_text("utf-8")
    first = ast.parse(text).body[0].end_lineno
    lines = enumerate(text.splitlines(), start=1)
    assert not [n for n, line in lines if n > first and line[:1] != "#" and len(line) > 95]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_links_of_a_notebook_lead_to_pages(path):
    for target in re.findall(r":doc:`(/[\w/-]+)`", path.read_text("utf-8")):
        assert (DOCS / f"{target[1:]}.md").exists()
