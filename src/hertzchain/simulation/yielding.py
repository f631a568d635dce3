"""The largest pressure in comparison with yield, and peaks with contacts that yield."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Final, NamedTuple

from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import measure
from .not_yielded import NOT_YIELDED

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..chain.hertz_range import HertzRange
    from ..collision import Array
    from ..validation.objects import Progress
    from .run import Run

# Longest chain for which a further simulation, of contacts with kinks, takes about a second.
MAX_BEADS: Final = 100
# Relative difference up to which peaks are the same, and number of times among which the time of
# first yield is found.
SAME_PEAK: Final = 1e-6
YIELD_TIMES: Final = 4000


class WithYield(NamedTuple):
    """A value with contacts that yield, and the largest overlap / radius of their run.

    A force on a wall may have several pulses, of which each can be the largest, and a later impact
    may exceed a peak so far.
    """

    value: float
    overlap_ratio: float
    several_pulses: bool = False
    so_far: bool = False

    @property
    def outside(self) -> bool:
        """Whether the overlap is outside the range of the law, so that the value is unknown."""
        from ..chain.hertz_ratios import NO_PREDICTION

        return self.overlap_ratio > NO_PREDICTION

    @property
    def caution(self) -> str:
        """Words after a value outside the range of the law; otherwise empty."""
        from ..chain.hertz_ratios import caution_outside_law

        return caution_outside_law(self.overlap_ratio)


UNKNOWN: Final = WithYield(math.nan, math.nan)


def largest_overlap_ratio(chain: Chain, overlaps: Array) -> float:
    """Largest overlap / radius of a chain of materials, from the overlaps of all contacts."""
    import numpy as np

    from ..chain.hertz_ratios import contact_ratios

    return float(np.nan_to_num(contact_ratios(chain, overlaps)[0]).max())


def not_a_prediction(run: Run) -> bool:
    """Whether an overlap is so large that neither Hertz's law nor yield predicts the forces."""
    from ..chain.hertz_ratios import NO_PREDICTION

    chain = run.chain
    if chain.materials is None or chain.units != "SI":
        return False
    return largest_overlap_ratio(chain, run.largest_overlaps) > NO_PREDICTION


def dents_in_words(chain: Chain, overlaps: Array) -> str:
    """Contacts that have yielded and the deepest dent; empty if no law has dents."""
    import numpy as np

    from ..chain.contact_groups import dents, law_yield_ratios
    from ..chain.hertz_ratios import caution_outside_law
    from ..chain.per_contact import contact_name, contacts_in_words

    ratios, found = (each(chain.contact_groups, overlaps) for each in (law_yield_ratios, dents))
    yielded = np.flatnonzero(ratios >= 1.0)
    if not found.any():
        if np.isnan(ratios).all():
            return ""
        at = int(np.nanargmax(ratios))
        place = contact_name(at, chain.beads)
        return f"{NOT_YIELDED}: pressure / yield {ratios[at]:.2g} at {place}"
    at = int(found.argmax())
    factor, unit = (1e6, " um") if chain.units == "SI" else (1.0, "")
    depth = f"{factor * found[at]:.3g}{unit}"
    text = f"deepest dent {depth} at {contact_name(at, chain.beads)}"
    if len(yielded):
        words = contacts_in_words(yielded, chain.beads)
        verb = "has" if len(yielded) == 1 else "have"
        text = f"{words} {verb} yielded; {text}"
    if chain.materials is None or chain.units != "SI":
        return text
    caution = caution_outside_law(largest_overlap_ratio(chain, overlaps))
    return f"{text}, {caution}" if caution else text


def pressures_below_yield(*runs: Run, above: bool = False) -> list[str]:
    """A line with the largest pressure of all runs, if it is known and below its limit.

    With ``above``, that of pressures above the limit, too.
    """
    from ..chain.hertz_range import hertz_range

    if any(run.chain.materials is None or run.chain.units != "SI" for run in runs):
        return []
    found = [hertz_range(run.chain, run.largest_overlaps) for run in runs]
    known = [each for each in found if not math.isnan(each.largest_yield_ratio)]
    if not known:
        return []
    largest = max(known, key=lambda each: each.largest_yield_ratio)
    shown = above or largest.largest_yield_ratio <= 1.0
    return [largest._pressure_line] if shown and largest._pressure_line else []


def remark_on_overlaps(run: Run) -> str:
    """A sentence on contacts that yield, beyond the limit of Hertz's law but not of theirs."""
    from ..chain.hertz_range import hertz_range

    if run.chain.materials is None or run.chain.units != "SI":
        return ""
    return hertz_range(run.chain, run.largest_overlaps)._remark


def unchecked_contacts(chain: Chain) -> dict[int, str]:
    """Materials, by contact, of elastic contacts without a known yield strength."""
    from ..chain.hertz_ratios import bodies_of, linear_springs

    if chain.materials is None or chain.units != "SI":
        return {}
    springs = linear_springs(chain)
    return {
        c: " with ".join(sorted(body.name for body in pair))
        for c, pair in enumerate(itertools.pairwise(bodies_of(chain)))
        if all(body.yield_strength is None for body in pair)
        and chain.contact_stiffness[c] > 0.0
        and not springs[c]
        and not chain.contact_losses[c].yields
    }


def contacts_without_strength(chain: Chain, overlaps: Array) -> list[str]:
    """A line for contacts whose pressure is not checked, from the overlaps of all contacts."""
    from ..chain.hertz_ratios import contact_pressures

    if not (unchecked := unchecked_contacts(chain)):
        return []
    names = " and of ".join(dict.fromkeys(unchecked.values()))
    elastic = any(law.needs_yield_strength for law in chain.contact_losses)
    stay = " and stay elastic" if elastic else ""
    pressures = contact_pressures(chain, overlaps)[1]
    largest = measure(float(pressures[list(unchecked)].max()), "Pa", digits=2)
    return [
        f"contacts of {names} have no known yield strength{stay}; their pressure (up to "
        f"{largest}) is not checked"
    ]


def elastic_springs(chain: Chain) -> list[str]:
    """A line for pads and walls that stay elastic in a chain whose other contacts yield."""
    import numpy as np

    from ..chain.hertz_ratios import springs_of
    from ..chain.laws.elastic import Elastic
    from ..chain.per_contact import contacts_in_words

    laws = chain.contact_losses
    if not any(law.yields for law in laws):
        return []
    elastic = np.array([isinstance(law, Elastic) for law in laws])
    if not len(found := np.flatnonzero(springs_of(chain) & elastic)):
        return []
    verb = "is a spring and stays" if len(found) == 1 else "are springs and stay"
    return [f"{contacts_in_words(found, chain.beads)} {verb} elastic"]


def yields(limits: HertzRange | None) -> bool:
    """Whether elastic contacts exceed the pressure at first yield, if it is known."""
    return limits is not None and limits.largest_yield_ratio > 1.0


def may_dent(limits: HertzRange) -> bool:
    """Whether a contact that exceeds this pressure yields in the `dented_chain`."""
    return bool((limits.may_yield & (limits.yield_ratio > 1.0)).any())


def dented_chain(chain: Chain) -> Chain | None:
    """The chain with `ElasticPlastic` contacts; None if they do not apply to it.

    Walls and pads that are springs remain elastic.
    """
    from ..chain.hertz_ratios import with_yield
    from ..chain.laws.elastic_plastic import ElasticPlastic

    return with_yield(chain, ElasticPlastic()) if chain.lossless else None


def peak_with_yielding_contacts(
    run: Run, progress: Progress | None = None, *, factor: float | None = None
) -> WithYield | None:
    """Peak on the right wall, or on a cap without a wall, of an elastic run that yields.

    `None` if it is not complete, or the force on the cap has had no maximum.  ``factor`` is the
    yield pressure over the yield strength if it is not that of first yield.
    """
    from ..chain.hertz_range import hertz_range
    from ..chain.yield_pressure import with_factor

    chain = run.chain
    if chain.materials is None or chain.units != "SI" or chain.beads > MAX_BEADS:
        return None
    if chain.right_wall is None and not chain._free_cap:
        return None
    if _peak_at_the_end(run) is None:
        return None
    dented = dented_chain(chain)
    if dented is None or not may_dent(hertz_range(chain, run.largest_overlaps)):
        return None
    if factor is not None:
        dented = with_factor(dented, factor)
    with ignore_warnings():  # those of the elastic run are shown
        again = _simulated_again(run, dented, progress)
    return None if again is None else peak_of(again)


def peak_at_pressure(run: Run, factor: float, progress: Progress | None = None) -> WithYield | None:
    """The same peak of a run that yields at an assumed pressure, at another one."""
    from ..chain.yield_pressure import with_factor

    if run.chain.beads > MAX_BEADS:
        return None
    with ignore_warnings():  # those of the run itself are shown
        again = _simulated_again(run, with_factor(run.chain, factor), progress)
    return None if again is None else peak_of(again)


def peak_of(run: Run) -> WithYield | None:
    """The same peak of the run itself, which yields."""
    if (found := _peak_at_the_end(run)) is None:
        return None
    peak, several, so_far = found
    return WithYield(peak, largest_overlap_ratio(run.chain, run.largest_overlaps), several, so_far)


def first_yield_after_peak(run: Run, found: WithYield) -> float | None:
    """Time of first yield, if contacts of an elastic run yield only after its peak.

    `None` if the peak with contacts that yield, which is known, is another one.  Up to this time,
    the elastic run is also that of contacts that yield.
    """
    import numpy as np

    from ..chain.contact_groups import law_yield_ratios
    from .body_force import body_force
    from .budget import overlaps_of
    from .simulate import simulate

    wall = None if run.chain.right_wall is None else run._wall_force("right")
    body = body_force(run) if wall is None else None
    if wall is not None:
        peak, time = wall.peak, wall.peak_time
    elif body is not None:
        peak, time = body.force, body.time
    else:
        return None
    dented = dented_chain(run.chain)
    if dented is None or abs(found.value - peak) > SAME_PEAK * peak:
        return None
    with ignore_warnings():
        again = simulate(run.chain, times=YIELD_TIMES, until=run.end_time, check=False)
    overlaps = overlaps_of(run.chain, again.times, again.positions)
    groups = dented.contact_groups
    late = (
        float(now)
        for now, each in zip(again.times, overlaps, strict=True)
        if np.nanmax(law_yield_ratios(groups, each), initial=0.0) >= 1.0
    )
    first = next(late, None)
    return first if first is not None and first > time else None


def _simulated_again(run: Run, dented: Chain, progress: Progress | None) -> Run | None:
    """A run of the dented chain; `None` if it fails.

    With a cap, it lasts up to the end of the run if this was given.
    """
    from .simulate import simulate

    behind = run.chain.right_wall is None
    given = behind and run.status == "time reached"
    until = run.end_time if given else None
    try:
        return simulate(dented, until=until, times=0, check=False, progress=progress)
    except (InputError, SimulationError):
        return None


def _peak_at_the_end(run: Run) -> tuple[float, bool, bool] | None:
    """Complete peak on the right wall, or largest force on a body; whether others are similar.

    One of several pulses can be the largest.  The last value is whether a later one may be.
    """
    from .body_force import body_force

    if run.chain.right_wall is None:
        found = body_force(run)
        return None if found is None else (found.force, found.later, not found.complete)
    wall = run._wall_force("right")
    return (wall.peak, wall.touches > 1, not wall.proven) if wall.complete else None
