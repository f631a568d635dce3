"""The literature: references to cite, as text and as BibTeX."""

from __future__ import annotations

import functools
import textwrap
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Final

from . import __version__

WIDTH: Final = 88
# The entry of this software, as in CITATION.cff.
SOFTWARE_AUTHORS: Final = "The hertzchain developers"
SOFTWARE_TITLE: Final = "hertzchain: impacts on granular chains"
SOFTWARE: Final = f"{SOFTWARE_AUTHORS}, {SOFTWARE_TITLE}, version {__version__}, software."
# Letters that are written in LaTeX, so that every version of BibTeX sorts and prints them.
LATEX: Final = str.maketrans({
    "á": r"{\'a}", "é": r"{\'e}", "ó": r"{\'o}", "ú": r"{\'u}", "ë": r"{\"e}", "ö": r"{\"o}",
    "ø": r"{\o}",
})  # fmt: skip
# Names in titles whose capital letters BibTeX must keep.
NAMES: Final = (
    "Runge", "Kutta", "Nyström", "Hertz", "Hertzian", "Anderson", "Lagrangian", "Boussinesq",
    "Monte", "Carlo", "CMA",
)  # fmt: skip


@dataclass(frozen=True)
class Reference:
    """One article, preprint or book."""

    key: str
    authors: tuple[str, ...]
    title: str
    year: int
    journal: str = ""
    volume: str = ""
    pages: str = ""
    publisher: str = ""
    edition: str = ""
    doi: str = ""
    arxiv: str = ""
    law: str = ""

    @property
    def source(self) -> str:
        """Journal, volume, page and year; or edition, publisher and year."""
        if self.journal:
            return f"{self.journal} {self.volume}, {self.pages} ({self.year})"
        book = f"{self.publisher}, {self.year}" if self.publisher else f"{self.year}"
        return f"{self.edition} ed. ({book})" if self.edition else f"({book})"

    def __str__(self) -> str:
        # A comma between title and source, except before parentheses.
        joint = ", " if self.journal or self.edition else " "
        parts = [*self.authors, f"{self.title}{joint}{self.source}"]
        parts += [f"doi:{self.doi}"] * bool(self.doi) + [f"arXiv:{self.arxiv}"] * bool(self.arxiv)
        return f"{self.law}: " * bool(self.law) + ", ".join(parts) + "."

    def bibtex(self) -> str:
        """The entry of a BibTeX file."""
        kind = "book" if self.publisher else "article" if self.journal else "misc"
        title = self.title
        for name in NAMES:
            for end in (" ", "-"):
                title = title.replace(f"{name}{end}", f"{{{name}}}{end}")
        fields = {
            "author": " and ".join(self.authors), "title": title, "journal": self.journal,
            "volume": self.volume, "pages": self.pages, "publisher": self.publisher,
            "edition": self.edition, "year": str(self.year), "doi": self.doi,
            "eprint": self.arxiv, "archivePrefix": "arXiv" if self.arxiv else "",
        }  # fmt: skip
        return _entry(kind, self.key, fields)


@functools.cache
def topics() -> dict[str, tuple[Reference, ...]]:
    """The references of each topic."""
    source = resources.files(__package__).joinpath("references.toml")
    return {
        topic["title"]: tuple(
            Reference(**{**each, "authors": tuple(each["authors"])}) for each in topic["references"]
        )
        for topic in tomllib.loads(source.read_text("utf-8"))["topic"]
    }


def text() -> str:
    """The entry of this software, and all references by topic, first the paper."""
    parts = [f"This software:\n  {SOFTWARE}"]
    for topic, references in topics().items():
        lines = [f"{topic}:"]
        for each in references:
            lines += textwrap.wrap(
                str(each), WIDTH, initial_indent="  ", subsequent_indent="    ",
                break_long_words=False, break_on_hyphens=False,
            )  # fmt: skip
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def bibtex() -> str:
    """The entries of this software and of all references as a BibTeX file.

    Examples
    --------
    >>> from hertzchain.citations import bibtex
    >>> print(bibtex()[:17])
    @misc{hertzchain,
    """
    entries = [each.bibtex() for references in topics().values() for each in references]
    software = {
        "author": f"{{{SOFTWARE_AUTHORS}}}",
        "title": SOFTWARE_TITLE,
        "note": f"Software, version {__version__}",
    }
    return "\n\n".join([_entry("misc", "hertzchain", software), *entries])


def _entry(kind: str, key: str, fields: dict[str, str]) -> str:
    """An entry of the fields that are not empty; identifiers are not changed."""
    lines = [
        f"  {name} = {{{value if name in ('doi', 'eprint') else value.translate(LATEX)}}},"
        for name, value in fields.items()
        if value
    ]
    return "\n".join([f"@{kind}{{{key},", *lines, "}"])
