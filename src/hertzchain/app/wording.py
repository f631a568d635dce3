"""Messages of the library in the words of the page."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

# Python expressions in messages, and the choice on the page instead.
WORDINGS: Final = (
    (r"\buse loss=ElasticPlastic\(\)", "choose the loss elastic-plastic"),
    (r"\buse loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
     "choose the loss elastic-plastic with a yield overlap"),
)  # fmt: skip


def on_the_page(message: object) -> str:
    """The message without Python expressions for which the page has a control."""
    text = str(message)
    for expression, words in WORDINGS:
        text = re.sub(expression, words, text)
    return text


def sentences(notes: Iterable[object]) -> str:
    """Different notes, which have no full stop, one after another."""
    return "; ".join(dict.fromkeys(on_the_page(each).rstrip(".") for each in notes if str(each)))


def title(name: str) -> str:
    """Name of a theory on the page, as in `results.js`."""
    words = re.sub("-printed$", ", as printed", name).replace("-", " ")
    return words.replace("bca", "BCA")
