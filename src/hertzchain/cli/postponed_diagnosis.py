"""A diagnosis of which most is done after the fit is printed, or after a search for defects."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import click

from .interrupts import exit_soon
from .output import show_json
from .progress import progress_bar
from .wording import on_command_line
from .wrapped_text import show_text

if TYPE_CHECKING:
    from ..fitting.causes import Refit
    from ..fitting.result import FitResult
    from ..validation.objects import Progress

LOOKING: Final = (
    "looking for the cause: zeros and gains of sensors, gaps, odd balls, losses, ... (Ctrl-C keeps "
    "the fit above)"
)
STOPPED: Final = "the search for the cause was stopped; the fit and its files are complete"


class PostponedDiagnosis:
    """The part of a diagnosis that takes long, and so follows the fit or a search for defects."""

    def __init__(self) -> None:
        self._start: Mapping[str, float] | None = None

    def quickly(self, result: FitResult, start: Mapping[str, float], refit: Refit) -> FitResult:
        """The result with advice that is found quickly: on misread data or a different row."""
        from ..fitting.diagnosis import quickly_diagnosed

        found, more = quickly_diagnosed(result, start, refit)
        self._start = start if more else None
        return found

    @property
    def left(self) -> bool:
        """Whether a part of the diagnosis is left."""
        return self._start is not None

    def diagnosed(self, result: FitResult, progress: Progress | None = None) -> FitResult:
        """The result with the rest of its diagnosis, if anything is left of it."""
        from ..fitting.diagnosis import diagnosed
        from ..fitting.fit import fitted

        if self._start is None:
            return result
        simulator = result.model.simulator
        before = simulator.count
        if progress is not None:
            simulator.progress = lambda done: progress(done - before, 0)
        try:
            found = diagnosed(result, self._start, fitted)
        finally:
            simulator.progress, simulator.trying = None, ""
        # A cause of the data or the row explains contradictions to priors, too.
        return replace(found, without_priors=()) if found.explained else found


def _trying(what: str) -> str:
    return f"trying {what}; " if what else ""


def cause_of_misfit(
    result: FitResult, document: dict[str, Any], postponed: PostponedDiagnosis, *, as_json: bool
) -> FitResult:  # fmt: skip
    """The result with the rest of its diagnosis; at an interrupt, its fit is kept."""
    try:
        with nullcontext() if as_json else exit_soon(STOPPED):
            click.echo(f"\n{LOOKING}", err=True)
            simulator = result.model.simulator
            with progress_bar(
                lambda _: f"{_trying(simulator.trying)}simulations of the search", counted=False
            ) as progress:
                return postponed.diagnosed(result, progress)
    except KeyboardInterrupt:
        if as_json:
            show_json(document)
        raise


def add_advice(
    result: FitResult, document: dict[str, Any], *, first: FitResult, as_json: bool
) -> None:
    """Print the advice that the summary lacks, or replace that of the document."""
    if "fit_with_best_law" in document:
        document["fit_with_best_law"] = result.as_dict()
    else:
        document |= result.as_dict()
    more = [each for each in result.advice if each not in first.advice]
    if more and not as_json:
        show_text(on_command_line("\n".join(("", *more))))
