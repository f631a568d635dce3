"""The field's own tests: quantities with exact or published values, computed anew.

`verify` runs them all.  Each `Case` says what is expected, how far from it a result may
be, where the number is from and how it was obtained.  Numbers "of two integrations" were
found by SciPy's DOP853 at rtol 1e-13 and, for the travelling wave, by the fixed point of its
integral equation (J. M. English, R. L. Pego, Proc. Amer. Math. Soc. 133, 1763, 2005,
doi:10.1090/S0002-9939-05-07851-2); neither shares anything with `hertzchain.simulate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hertzchain import __version__
from hertzchain.arguments import callback, listed, one_of
from hertzchain.errors import InputError
from hertzchain.simulation.simulate import Progress
from hertzchain.verification.case import ORIGINS, Case, forget_shared
from hertzchain.verification.cases import cases


@dataclass(frozen=True)
class Verdict:
    """A case and our value.

    Attributes
    ----------
    case : Case
        The case.
    ours : float
        Our value.

    Examples
    --------
    >>> verdict = Verdict(Case("a group", "one", 1.0, 0.1, "by definition", lambda: 1.05), 1.05)
    >>> verdict.agrees, round(verdict.difference, 2)
    (True, 0.05)
    """

    case: Case
    ours: float

    @property
    def difference(self) -> float:
        """Ours less the expected value."""
        return self.ours - self.case.expected

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance."""
        return abs(self.difference) <= self.case.tolerance


def verify(
    groups: Sequence[str] | None = None, *, progress: Progress | None = None
) -> list[Verdict]:
    """Compute every quantity that has an exact or published value.

    Parameters
    ----------
    groups : sequence of str, optional
        Names of groups of cases; all by default.
    progress : callable, optional
        Called as ``progress(cases_done, cases)``.

    Returns
    -------
    list of Verdict

    Raises
    ------
    InputError
        For an unknown group.

    Examples
    --------
    >>> all(verdict.agrees for verdict in verify(["restitution"]))
    True
    """
    every = cases()
    known = list(dict.fromkeys(case.group for case in every))
    callback("progress", progress)
    if groups is not None:
        groups = listed("groups", groups, "names")
    if groups is not None and not groups:
        raise InputError(f"name groups of cases to verify, of {', '.join(known)}")
    for group in groups or ():
        one_of("group of cases", group, known)
    chosen = [case for case in every if groups is None or case.group in groups]
    verdicts = []
    for done, case in enumerate(chosen, start=1):
        verdicts.append(Verdict(case, float(case.compute())))
        if progress is not None:
            progress(done, len(chosen))
    forget_shared()
    return verdicts


def as_dict(verdicts: Sequence[Verdict]) -> dict[str, object]:
    """Verdicts as plain data, for JSON and reports.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Any verdicts.

    Returns
    -------
    dict

    Examples
    --------
    >>> as_dict(verify(["restitution"]))["agreeing"]
    17
    """
    return {
        "schema_version": 1,
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
