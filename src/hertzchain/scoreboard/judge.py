"""Hold every theory against the integration, on many tapers."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.errors import InputError, ModelRangeWarning, unknown_name
from hertzchain.propagation.propagate import propagate_many
from hertzchain.pulse.pulse import Pulse
from hertzchain.scoreboard.cases import Case, paper_cases, unseen_cases
from hertzchain.scoreboard.scoreboard import JUDGED, Scoreboard
from hertzchain.theory.catalogue import THEORIES, Theory


def scoreboard(
    *,
    theories: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Scoreboard:
    """Hold theories against the integration, on the paper's tapers and on unseen ones.

    Parameters
    ----------
    theories : sequence of str, optional
        Names in `hertzchain.theory.catalogue.THEORIES`; all by default.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    Scoreboard

    Raises
    ------
    InputError
        For an unknown theory, or none.

    Examples
    --------
    >>> scoreboard(theories=["bca", "modified-bca"])
    Scoreboard(2 theories on 52 chains)
    """
    chosen = tuple(THEORIES) if theories is None else tuple(theories)
    if isinstance(theories, str) or not chosen:
        raise InputError(f"name theories in a list, of {', '.join(THEORIES)}; got {theories!r}")
    for name in chosen:
        if name not in THEORIES:
            raise unknown_name("theory", name, THEORIES)
    cases = [*paper_cases(), *unseen_cases()]
    exact = propagate_many([case.chain for case in cases], progress=progress)
    return judge(cases, exact, {name: THEORIES[name] for name in chosen})


def judge(
    cases: Sequence[Case], exact: Iterable[Pulse], theories: Mapping[str, Theory] = THEORIES
) -> Scoreboard:
    """Hold theories against pulses that are taken for the truth.

    Parameters
    ----------
    cases : sequence of Case
        Chains to judge on.
    exact : iterable of Pulse
        The true pulse of each.
    theories : mapping of str to callable
        Functions from a chain to a pulse, by name.

    Returns
    -------
    Scoreboard

    Raises
    ------
    InputError
        If a pulse is not one of the chain it stands beside, or there are none.

    Examples
    --------
    >>> import hertzchain as hc
    >>> case = Case("equal", "equal", "smooth", Chain.uniform(30))
    >>> judge([case], [hc.propagate(case.chain)]).theories[0]
    'bca'
    """
    if not cases or not theories:
        raise InputError("a scoreboard needs at least one chain and one theory")
    shape = len(theories), len(cases), max(case.chain.beads for case in cases)
    errors = {quantity: np.full(shape, np.nan) for quantity in JUDGED}
    warned, refusals, estimates = np.zeros(shape[:2], bool), {}, np.full(shape, np.nan)
    for c, (case, reference) in enumerate(zip(cases, exact, strict=True)):
        for t, (name, theory) in enumerate(theories.items()):
            try:
                pulse, warned[t, c] = _predicted(theory, case.chain)
            except InputError as error:
                refusals[name, case.name] = str(error)
                continue
            if pulse.velocity_error is not None:
                estimates[t, c, : case.last_bead] = pulse.velocity_error[: case.last_bead]
            comparison = pulse.compare(reference)
            for quantity in comparison.quantities:
                if quantity in errors:
                    counted = comparison.errors(quantity)[: case.last_bead]
                    errors[quantity][t, c, : case.last_bead] = counted
    return Scoreboard(tuple(cases), tuple(theories), errors, warned, refusals, estimates)


def _predicted(theory: Theory, chain: Chain) -> tuple[Pulse, bool]:
    """A theory's pulse, and whether it warned that the chain is outside its range."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pulse = theory(chain)
    outside = [issubclass(item.category, ModelRangeWarning) for item in caught]
    for item, expected in zip(caught, outside, strict=True):
        if not expected:
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
    return pulse, any(outside)
