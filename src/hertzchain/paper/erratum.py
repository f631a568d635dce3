"""One contradiction of the paper, with evidence."""

from __future__ import annotations

from dataclasses import dataclass

from ..representation import short

Evidence = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Erratum:
    """A printed statement that contradicts the paper's own equations or the simulation.

    Attributes
    ----------
    place : str
        Place in the paper.
    printed, follows : str
        Printed statement, and the statement that follows from the paper's equations or from
        the simulation.
    evidence : tuple of (str, str)
        Names and values of the computed quantities.
    concerns : tuple of str
        Names of the tables and figures whose content or caption is concerned.
    inference : bool
        Whether the correction is inferred from the numbers instead of following from the
        paper's equations.
    """

    place: str
    printed: str
    follows: str
    evidence: Evidence
    concerns: tuple[str, ...] = ()
    inference: bool = False

    def __repr__(self) -> str:
        return short("Erratum", self.place, f"printed {self.printed}", self.follows)
