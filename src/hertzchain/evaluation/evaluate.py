"""Compare every theory with the simulation on many tapers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError, ModelRangeWarning, warn_user
from ..propagation.propagate import propagate_many
from ..pulse.pulse import Pulse
from ..recorded_warnings import record_warnings
from ..theory.catalogue import THEORIES, Theory
from ..validation.keywords import checked_arguments
from ..validation.objects import Progress, callback, check_choice, check_list
from .cases import Case, paper_cases, unseen_cases
from .scoreboard import QUANTITIES, Scoreboard


@checked_arguments("scoreboard")
def scoreboard(
    *,
    theories: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> Scoreboard:
    """Compare theories with the simulation on the paper's tapers and on unseen ones.

    Parameters
    ----------
    theories : sequence of str, optional
        Names in `hertzchain.theory.catalogue.THEORIES`.  The default is all theories.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Raises
    ------
    InputError
        If a theory is unknown, or there are none.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.scoreboard(theories=["bca", "modified-bca"])
    Scoreboard(2 theories on 52 chains)
    """
    callback("progress", progress)
    chosen = [*THEORIES] if theories is None else check_list("theories", theories, "names")
    if not chosen:
        raise InputError(
            f"theories must be a list of at least one of {', '.join(THEORIES)}; got an empty one"
        )
    for name in chosen:
        check_choice("theory", name, tuple(THEORIES))
    cases = [*paper_cases(), *unseen_cases()]
    exact = propagate_many([case.chain for case in cases], progress=progress)
    return evaluate(cases, exact, {name: THEORIES[name] for name in chosen})


def evaluate(
    cases: Sequence[Case], exact: Iterable[Pulse], theories: Mapping[str, Theory] = THEORIES
) -> Scoreboard:
    """Compare theories with reference pulses.

    Parameters
    ----------
    cases : sequence of Case
        Chains on which the theories are evaluated.
    exact : iterable of Pulse
        Reference pulse of each chain.
    theories : mapping of str to callable
        Functions from a chain to a pulse, by name.

    Raises
    ------
    InputError
        If a pulse belongs to another chain, or there are no chains or no theories.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.evaluation.evaluate import evaluate
    >>> case = hc.evaluation.Case("equal", "equal", "smooth", hc.Chain.uniform(30))
    >>> evaluate([case], [hc.propagate(case.chain)]).theories[0]
    'bca'
    """
    if not cases or not theories:
        raise InputError("a scoreboard requires at least one chain and one theory")
    shape = len(theories), len(cases), max(case.chain.beads for case in cases)
    errors = {quantity: np.full(shape, np.nan) for quantity in QUANTITIES}
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
    """Pulse of a theory, and whether the theory warned that the chain is outside its range."""
    with record_warnings() as caught:
        pulse = theory(chain)
    outside = [isinstance(each, ModelRangeWarning) for each in caught]
    for each, expected in zip(caught, outside, strict=True):
        if not expected:
            warn_user(str(each), type(each))
    return pulse, any(outside)
