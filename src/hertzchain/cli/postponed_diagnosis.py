"""A diagnosis of which most is done only after a search for defects, if that finds nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..fitting.causes import Refit
    from ..fitting.result import FitResult


class PostponedDiagnosis:
    """The part of a diagnosis that follows a search for defects, because it takes as long."""

    def __init__(self) -> None:
        self._start: Mapping[str, float] | None = None

    def quickly(self, result: FitResult, start: Mapping[str, float], refit: Refit) -> FitResult:
        """The result with advice that is found quickly: on misread data or a different row."""
        from ..fitting.diagnosis import quickly_diagnosed

        found, more = quickly_diagnosed(result, start, refit)
        self._start = start if more else None
        return found

    def diagnosed(self, result: FitResult) -> FitResult:
        """The result with the rest of its diagnosis, if anything is left of it."""
        from ..fitting.diagnosis import diagnosed
        from ..fitting.fit import fitted

        return result if self._start is None else diagnosed(result, self._start, fitted)
