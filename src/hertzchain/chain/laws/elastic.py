"""Contacts without loss."""

from __future__ import annotations

from dataclasses import dataclass

from ...kernels.law_kinds import ELASTIC, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, Loss


@checked_fields
@dataclass(frozen=True)
class Elastic(Loss, name="elastic"):
    r"""No loss: the contact returns all energy.

    .. math:: F = k\,d^{\,p}

    This is the default of a chain.  State it for single contacts or walls of a chain whose other
    contacts have a loss.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Wall(loss=hc.Elastic())
    Wall(own material, loss = Elastic())
    """

    def row(self, exponent: float) -> LawRow:
        return LawRow(ELASTIC)

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        return 1.0
