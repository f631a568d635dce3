"""Compute quantities with exact or published values and compare them.

Each `Case` states the expected value, the tolerance, the source and the origin of the value.
Values from "two integrations" were computed by SciPy's DOP853 at rtol 1e-13 and, for the
travelling wave, by fixed-point iteration of its integral equation (J. M. English, R. L. Pego,
Proc. Amer. Math. Soc. 133, 1763, 2005, doi:10.1090/S0002-9939-05-07851-2).  Neither shares
code with `hertzchain.simulate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .. import __version__
from ..errors import InputError
from ..representation import short
from ..store.results import SCHEMA_VERSION
from ..validation.keywords import checked_arguments
from ..validation.objects import Progress, callback, check_choice, check_list
from .case import ORIGINS, Case, forget_shared
from .cases import cases


@dataclass(frozen=True)
class Verdict:
    """A case and the computed value.

    Attributes
    ----------
    case : Case
        Case with the expected value.
    ours : float
        Computed value.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.verification.case import Case
    >>> verdict = hc.Verdict(Case("a group", "one", 1.0, 0.1, "by definition", lambda: 1.05), 1.05)
    >>> verdict.agrees, round(verdict.difference, 2)
    (True, 0.05)
    """

    case: Case
    ours: float

    @property
    def difference(self) -> float:
        """Computed value minus expected value."""
        return self.ours - self.case.expected

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance."""
        return abs(self.difference) <= self.case.tolerance

    def __repr__(self) -> str:
        agrees = "agrees" if self.agrees else "does not agree"
        known = f"{self.case.expected:.10g} within {self.case.tolerance:.2g}"
        about = f"{self.case.group}, {self.case.name}"
        return short("Verdict", about, f"{self.ours:.10g}, expected {known}", agrees)


@checked_arguments("verify")
def verify(
    groups: Sequence[str] | None = None, *, progress: Progress | None = None
) -> list[Verdict]:
    """Compute all quantities with exact or published values.

    Parameters
    ----------
    groups : sequence of str, optional
        Names of groups of cases.  The default is all groups.
    progress : callable, optional
        Called as ``progress(cases_done, cases)``.

    Returns
    -------
    list of Verdict
        One verdict per case.

    Raises
    ------
    InputError
        If a group is unknown.

    Examples
    --------
    >>> import hertzchain as hc
    >>> all(verdict.agrees for verdict in hc.verify(["restitution"]))
    True
    """
    every = cases()
    known = list(dict.fromkeys(case.group for case in every))
    callback("progress", progress)
    if groups is not None:
        groups = check_list("groups", groups, "names")
    if groups is not None and not groups:
        raise InputError(f"groups must contain at least one of {', '.join(known)}")
    for group in groups or ():
        check_choice("group of cases", group, known)
    chosen = [case for case in every if groups is None or case.group in groups]
    verdicts = []
    for done, case in enumerate(chosen, start=1):
        verdicts.append(Verdict(case, float(case.compute())))
        if progress is not None:
            progress(done, len(chosen))
    forget_shared()
    return verdicts


def as_dict(verdicts: Sequence[Verdict]) -> dict[str, object]:
    """Convert verdicts to a dictionary of JSON types.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Any verdicts.

    Returns
    -------
    dict
        Number of agreeing cases, and one entry per case.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.verification.verify import as_dict
    >>> as_dict(hc.verify(["restitution"]))["agreeing"]
    17
    """
    return {
        "schema_version": SCHEMA_VERSION,
        "hertzchain_version": __version__,
        "agreeing": sum(verdict.agrees for verdict in verdicts),
        "origins": ORIGINS,
        "cases": [
            {
                "group": verdict.case.group,
                "name": verdict.case.name,
                "expected": verdict.case.expected,
                "ours": verdict.ours,
                "tolerance": verdict.case.tolerance,
                "agrees": verdict.agrees,
                "source": verdict.case.source,
                "origin": verdict.case.origin,
            }
            for verdict in verdicts
        ],
    }
