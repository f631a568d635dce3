"""What a method covers of all that a chain may be."""

from __future__ import annotations

from collections.abc import Sequence

from hertzchain.chain.chain import Chain
from hertzchain.errors import InputError, shown


def check_chain(by: str, chain: object) -> None:
    """Refuse what is no chain.

    Parameters
    ----------
    by : str
        Name of the method.
    chain : Chain
        What was given.

    Raises
    ------
    InputError
        If it is no chain.

    Examples
    --------
    >>> check_chain("simulate", Chain.uniform(20))
    """
    if not isinstance(chain, Chain):
        raise InputError(
            f"{by} takes a Chain, got {shown(chain)}; Chain.from_radii makes one of radii"
        )


def require(chain: Chain, by: str, *, covers: Sequence[str] = (), instead: str = "") -> None:
    """Refuse a chain that has a feature which a method does not cover.

    Parameters
    ----------
    chain : Chain
        The chain.
    by : str
        Name of the method.
    covers : sequence of str
        Names of the features, of `Chain.features`, that it does cover.
    instead : str
        What to use instead.

    Raises
    ------
    InputError
        If there is such a feature; all are named.

    Examples
    --------
    >>> require(Chain.uniform(20), "the BCA")
    """
    check_chain(by, chain)
    others = [name for name in chain.features if name not in covers]
    if others:
        advice = instead or "leave them out"
        if others == ["SI units"]:
            advice = "use Scales.of(chain).to_scaled(chain)"
        raise InputError(
            f"{by} does not cover {' and '.join(others)}, which this chain has "
            f"({chain.description}): {advice}"
        )
