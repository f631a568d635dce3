"""Lines on a search for defects: the current trial, other places and the other kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..fitting.defect_scan import DefectScan
    from ..fitting.result import FitResult


def trying(what: str, names: Sequence[str]) -> Callable[[int], str]:
    """Description of a progress bar that names the defect being tried."""
    return lambda done: f"{what}, now {names[done]}" if done < len(names) else what


def other_place(scan: DefectScan, best: FitResult) -> list[str]:
    """A line if the fits choose another place than the scan, in which other parameters adjust."""
    name = best.names[-1]
    if name.partition("[")[2] == scan.best.partition("[")[2]:
        return []
    return [
        f"the fit above has {name}, because fits with one defect at each of the first places have "
        f"the smallest chi2 with it, {best.chi2:.0f}; the scan is less accurate, because the other "
        "parameters adjust only linearly in it"
    ]


def other_kind(scan: DefectScan, fit: FitResult | None, best: FitResult) -> str:
    """A line on a kind of defect that is not the best one."""
    from ..fitting.defect_scan import FOUND, WORDS

    what = WORDS[scan.kind][0].removesuffix(" at each of").removesuffix(" of each of")
    if fit is None:
        return f"{what}, of {scan.names[0]} to {scan.names[-1]}, explains no more than noise would"
    name, other = fit.names[-1], best.names[-1]
    text = f"the best fit with {what} instead, {name}, has chi2 {fit.chi2:.0f}"
    if fit.chi2 + fit._penalty - best.chi2 - best._penalty < FOUND:
        return f"not excluded: {text}, and that with {other} {best.chi2:.0f}"
    return f"rejected: {text}, and that with {other} only {best.chi2:.0f}"
