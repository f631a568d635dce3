"""HTML representation of a laboratory sheet: its predictions."""

from __future__ import annotations

from ..sheets.pages import predictions
from ..sheets.sheet import LabSheet
from .drawing import note, page, table


def sheet_html(sheet: LabSheet) -> str:
    """Table of the predictions, with a note on limits of Hertz's law."""
    found = predictions(sheet)
    notes = [note(each) for each in sheet.warnings]
    return page(
        "LabSheet", sheet.title, table(found.heads, found.rows, numeric=True), *notes,
        note(f"{found.caption}. The method save writes the whole sheet to a file."),
    )  # fmt: skip
