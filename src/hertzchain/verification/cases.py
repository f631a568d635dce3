"""All quantities with exact or published values, topic by topic."""

from __future__ import annotations

from hertzchain.verification import collisions, ends, linear_waves, tapers, unequal_beads, waves
from hertzchain.verification.case import Case


def cases() -> list[Case]:
    """All cases, group by group.

    Returns
    -------
    list of Case

    Examples
    --------
    >>> len(cases()) > 100
    True
    """
    return [
        *waves.cases(), *ends.cases(), *unequal_beads.cases(), *tapers.cases(),
        *linear_waves.cases(), *collisions.cases(),
    ]  # fmt: skip
