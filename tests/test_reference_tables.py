"""Tables of the documentation that are generated, and widths of tables in its pages."""

import re
from pathlib import Path

import command_pages
import material_table
import pytest

import hertzchain as hc
from hertzchain.cli import cli

# Columns of a block of code in a window of 1200 px.
WIDEST = 90
DOCS = Path(__file__).parents[1] / "docs"
# Rows of at least four columns that are separated by two or more spaces.
ROW = re.compile(r"^ *\S+(?: \S+)*(?: {2,}\S+(?: \S+)*){3,}$")


def test_table_of_commands_links_every_command_once():
    table = command_pages.command_table()
    assert re.findall(r'href="#hertzchain-([\w-]+)"', table) == list(cli.commands)
    assert all(len(row.split(" | ")) == 3 for row in table.splitlines()[2:])


def test_examples_of_commands_become_blocks_with_the_same_lines():
    lines = [
        "Text.",
        "",
        "| Examples:",
        "|   hertzchain app",
        '|       --speed "1 m/s"',
        "",
        "End.",
    ]
    command_pages.examples_as_blocks(None, None, lines)
    assert lines == [
        "Text.", "", "", "Examples:", "", ".. code-block:: sh", "",
        "   hertzchain app", '       --speed "1 m/s"', "", "End.",
    ]  # fmt: skip


def test_table_of_materials_has_the_numbers_and_sources_of_the_catalogue():
    rows = [row.strip("| ").split(" | ") for row in material_table.material_table().splitlines()]
    found = {name: cells for name, *cells in rows[2:]}
    assert list(found) == list(hc.catalogue())
    assert found["brass"][:4] == ["8530", "101", "0.35", "434"]
    assert found["brass"][-1] == hc.material("brass").source
    assert found["glass"][3] == ""


@pytest.mark.parametrize("page", sorted(DOCS.glob("*/*.md")), ids=lambda page: page.stem)
def test_rows_of_printed_tables_fit_on_pages(page):
    text = page.read_text("utf-8")
    blocks = re.findall(r"^```(?:console|python|pycon)\n(.*?)^```", text, re.M | re.S)
    lines = [line for block in blocks for line in block.splitlines()]
    code = (">>> ", "... ")
    rows = [line for line in lines if ROW.match(line) and not line.startswith(code)]
    wide = [row for row in rows if len(row) > WIDEST]
    assert not wide
