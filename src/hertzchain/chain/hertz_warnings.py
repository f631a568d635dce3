"""Warnings about chains outside the range of Hertz's law."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from numpy.typing import ArrayLike

from ..errors import ModelRangeWarning, warn_user
from .chain import Chain
from .hertz_range import HertzRange, hertz_range

# Methods of which a chain can have the loss `ElasticPlastic`; "" are functions without a label.
WITH_YIELD: Final = ("", "simulation", "gradient")


def warn_outside_hertz(
    chain: Chain, overlaps: ArrayLike | None = None, later: str = "", *, method: str = ""
) -> None:
    """Issue a warning for each limit of Hertz's law that a chain in SI units exceeds.

    Parameters
    ----------
    chain : Chain
        Any chain; there is no warning if it has no materials.
    overlaps : array_like, optional
        Largest overlap of each contact, as for `hertz_range`.
    later : str
        Words to add if larger overlaps may follow.
    method : str
        Name of the method that gave the overlaps, such as ``"BCA"``, if those of others differ.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.chain.hertz_warnings import warn_outside_hertz
    >>> warn_outside_hertz(hc.Chain.uniform(3), [0.1, 0.1])
    """
    if chain.units == "SI" and chain.materials is not None:
        for violation in violations_of(method, hertz_range(chain, overlaps)):
            more = f"; {later}" * bool(later and "/ sound" not in violation)
            warn_user(f"{method}{': ' * bool(method)}{violation}{more}", ModelRangeWarning)


def violations_of(method: str, found: HertzRange) -> tuple[str, ...]:
    """Violations, with advice to simulate contacts that yield if the method cannot."""
    return (
        found.violations if method in WITH_YIELD else found._violations("use simulate with loss=")
    )


def warn_outside_static(chain: Chain, *, linear: bool = False) -> None:
    """Issue a warning for each limit of Hertz's law that the static forces alone exceed.

    Parameters
    ----------
    chain : Chain
        Any chain; there is no warning if it has no materials.
    linear : bool
        Whether the motion is linearised, for which contacts cannot have a law with yield.
    """
    if chain.units == "SI" and chain.materials is not None and chain.static_state.forces.any():
        at_rest = replace(hertz_range(chain, chain.static_state.overlaps), speed_ratio=0.0)
        for violation in at_rest._violations("") if linear else at_rest.violations:
            warn_user(violation, ModelRangeWarning)
