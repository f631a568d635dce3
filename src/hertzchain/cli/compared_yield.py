"""Peaks of several chains with contacts that yield, and whether yield reverses their order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from ..representation import listed, measure
from ..simulation.yield_range import depends_on_yield_pressure, same_at_any_pressure
from ..simulation.yielding import MAX_BEADS, may_dent

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..simulation.run import Run
    from ..simulation.yielding import WithYield

    # Peaks at the smallest and at the largest possible yield pressure, of elastic runs that yield.
    Yielding = tuple[WithYield | None, WithYield | None]

# Relative difference up to which peaks are the same, and length of a title in characters.
SAME, TITLE = 1e-6, 110


class AtPressures(NamedTuple):
    """Peaks of a chain at the smallest and at the largest possible yield pressure.

    They are infinite if they are not known, for which ``reason`` has the cause.  ``elastic`` states
    whether the run itself has elastic contacts beyond first yield, so that its own peak is neither
    of them; ``outside``, whether overlaps are beyond the range of the law.
    """

    smallest: float
    largest: float
    elastic: bool = False
    outside: tuple[bool, bool] = (False, False)
    reason: str = ""

    @property
    def both(self) -> tuple[float, float]:
        """Both peaks."""
        return self.smallest, self.largest


def _unknown(reason: str, *, elastic: bool = False) -> AtPressures:
    return AtPressures(math.inf, math.inf, elastic, reason=reason)


def possible_factors() -> tuple[str, str]:
    """The smallest and the largest possible yield pressure over the yield strength, as text."""
    # The command line states its help without numpy.
    from ..chain.materials import FIRST_YIELD, FULLY_PLASTIC

    return f"{FIRST_YIELD:g}", f"{FULLY_PLASTIC:g}"


def has_law_of_yield(run: Run) -> bool:
    """Whether any contact has a law of yield."""
    return any(law.yields for law in run.chain.contact_losses)


def at_pressures(
    run: Run, own: float, other: float, yielding: Yielding, outside: tuple[bool, bool], *,
    at_right_end: bool,
) -> AtPressures:  # fmt: skip
    """Peaks of a run at both yield pressures.

    Those of the run and of that at the largest possible yield pressure are ``own`` and ``other``;
    ``outside`` states whether they are beyond the range of the law.  For an elastic run, only the
    peaks on its right wall or on a cap without a wall are known, ``yielding``.
    """
    from ..chain.hertz_range import hertz_range

    chain = run.chain
    if depends_on_yield_pressure(run):
        return AtPressures(own, other, outside=outside)
    if same_at_any_pressure(run):
        return AtPressures(own, own, outside=(outside[0], outside[0]))
    if has_law_of_yield(run):
        return _unknown("the chain has a yield pressure of its own")
    if chain.materials is None or chain.units != "SI":
        return _unknown("no materials")
    if not chain.lossless or not may_dent(hertz_range(chain, run.largest_overlaps)):
        return _unknown("contacts have a loss without yield")
    low, high = yielding
    if not at_right_end or low is None or high is None:
        return _unknown(_reason(chain, at_right_end=at_right_end), elastic=True)
    return AtPressures(low.value, high.value, elastic=True, outside=(low.outside, high.outside))


def _reason(chain: Chain, *, at_right_end: bool) -> str:
    """The cause of an unknown peak of an elastic chain if its contacts yield."""
    if not at_right_end:
        return "it is known on right walls and caps only"
    if chain.beads > MAX_BEADS:
        return f"more than {MAX_BEADS} beads; add --loss elastic-plastic"
    return "not complete"


def comparison_notes(
    own: Mapping[str, float], at: Mapping[str, AtPressures], lawful: Sequence[str],
    unpredicted: Sequence[str],
) -> list[str]:  # fmt: skip
    """Lines on chains whose peaks cannot be compared, and on an order that yield reverses.

    ``lawful`` are the names of chains whose contacts have a law of yield, ``unpredicted`` those
    whose own peaks are beyond the range of the law.
    """
    elastic = [name for name, each in at.items() if each.elastic]
    if elastic and lawful:
        verb = "is that" if len(elastic) == 1 else "are those"
        return [
            f"the peak{'s' * (len(elastic) > 1)} of {listed(elastic)} {verb} of elastic contacts "
            f"beyond yield, and contacts of {listed(list(lawful))} yield: compare the columns with "
            "a yield pressure, or give all chains the same loss"
        ]
    winners = compared({name: own[name] for name in own if name not in unpredicted})
    reversed_at: dict[tuple[str, ...], list[str]] = {}
    for i, factor in enumerate(possible_factors()):
        values = predicted(at, i)
        found = compared(values) if all_known(values) else ()
        if found and winners and values.keys() >= {*winners} and not {*found} & {*winners}:
            reversed_at.setdefault(found, []).append(factor)
    return [
        f"with contacts that yield at {' and '.join(factors)} times the yield strength, the "
        f"smallest peak is that of {listed(list(names))}, which reverses the comparison"
        for names, factors in reversed_at.items()
    ]


def predicted(at: Mapping[str, AtPressures], i: int) -> dict[str, float]:
    """Peaks at a yield pressure, without those beyond the range of the law."""
    return {name: each.both[i] for name, each in at.items() if not each.outside[i]}


def compared(peaks: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the chains with the smallest known peak; none if there are not two chains."""
    return smallest(peaks) if len(peaks) > 1 else ()


def all_known(peaks: Mapping[str, float]) -> bool:
    """Whether no peak is unknown."""
    return all(map(math.isfinite, peaks.values()))


def smallest(peaks: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the chains with the smallest known peak; none if no peak is known."""
    least = min(peaks.values())
    if not math.isfinite(least):
        return ()
    return tuple(name for name, peak in peaks.items() if peak <= (1.0 + SAME) * least)


def limited_pressure_notes(
    rows: Mapping[str, Mapping[str, str]], runs: Mapping[str, Run]
) -> list[str]:
    """A note beside pressures of contacts that have yielded, which their law limits."""
    dented = any("deepest dent" in rows[name] for name in runs if has_law_of_yield(runs[name]))
    if not dented:
        return []
    return ["pressure/yield is at most 1 with a law of yield; the dents show how far contacts "
            "have yielded"]  # fmt: skip


def figure_title(
    runs: Mapping[str, Run], yielding: Mapping[str, Yielding],
    at: Mapping[str, AtPressures] = MappingProxyType({}),
) -> str:  # fmt: skip
    """Title of a figure: the assumed yield pressure, or that elastic contacts are beyond yield.

    The latter is followed by the peaks if they yield, where there is room; those of all runs at
    both pressures, ``at``, are on a line of their own.
    """
    from ..chain.yield_pressure import YIELD_STATED, assumes_pressure

    lawful = [name for name, run in runs.items() if assumes_pressure(run.chain)]
    elastic, beyond = _beyond_yield(runs, yielding)
    whose = f"{listed(lawful)}: " if 0 < len(lawful) < len(runs) else ""
    law = f"{whose}{YIELD_STATED}" * bool(lawful)
    if (law or beyond) and (peaks := _at_both_pressures(runs, at)):
        # The legend names elastic contacts beside others.
        return f"{law or elastic}\n{peaks}"
    return "; ".join(filter(None, (law, beyond)))


def _at_both_pressures(runs: Mapping[str, Run], at: Mapping[str, AtPressures]) -> str:
    """Peaks of several runs at both yield pressures; empty if one is unknown, or without room."""
    ends = [end for each in at.values() for end in each.both]
    if len(at) < 2 or not all(map(math.isfinite, ends)) or any(any(a.outside) for a in at.values()):
        return ""
    shown = []
    for name, each in at.items():
        low, high = (measure(end, "N", runs[name].chain.units, 3) for end in each.both)
        if low.partition(" ")[2] == high.partition(" ")[2]:
            low = low.partition(" ")[0]
        shown.append(f"{name} {low} and {high}")
    text = f"peaks at {' and '.join(possible_factors())} Y: {', '.join(shown)}"
    return text if len(text) <= TITLE else ""


def beyond_yield(runs: Mapping[str, Run], yielding: Mapping[str, Yielding]) -> str:
    """That elastic contacts are beyond yield, with the peaks if they yield."""
    return _beyond_yield(runs, yielding)[1]


def _beyond_yield(runs: Mapping[str, Run], yielding: Mapping[str, Yielding]) -> tuple[str, str]:
    """The same without and with the peaks."""
    from ..chain.yield_pressure import YIELD_ASSUMED

    peaks = {name: peak for name, (peak, _) in yielding.items() if peak is not None}
    if not peaks:
        return "", ""
    text = (
        "elastic contacts" if len(peaks) == len(runs) else f"{listed([*peaks])}: elastic contacts"
    )
    shown = ", ".join(
        f"{f'{name} ' * (len(runs) > 1)}{measure(peak.value, 'N', runs[name].chain.units, 3)}"
        for name, peak in peaks.items()
    )
    known = not any(peak.outside for peak in peaks.values())
    whole = f"{text}; peak{'s' * (len(runs) > 1)} if {YIELD_ASSUMED}: {shown}"
    beyond = f"{text}, beyond yield"
    return beyond, whole if known and len(whole) <= TITLE else beyond
