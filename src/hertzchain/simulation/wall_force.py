"""The force on a wall over time, its peak, whether the peak is complete, and impulses."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from ..chain.bead_names import Side
from ..chain.chain import Chain
from ..chain.drives import Drive, SineBurst, StepDrive, TableDrive
from ..collision import Array
from ..frozen import Compared
from ..kernels.wall_rule import HELD
from ..representation import counted, measure, short
from ..validation.keywords import checked_methods
from .force_table import force_dataframe
from .run_message import is_sensitive
from .wall_bound import motion_can_escape

if TYPE_CHECKING:
    import pandas as pd

SIDES: Final[tuple[Side, ...]] = ("left", "right")
# Relative difference of times and forces, from rounding.
ROUNDING: Final = 1e-9
# Fraction of the force that may follow, below which the pulse has not reached a wall.
NEGLIGIBLE: Final = 1e-6
# Relative excess of a sufficient time, which messages round.
MARGIN: Final = 0.02


def sensitive_in_words(run: str, place: str = "") -> str:
    """The meaning of a sensitive peak, and how to check it with a run."""
    return (
        f"the largest force{place} occurs after the first contact and may be sensitive to small "
        f"changes, such as another tolerance: check with {run}.horizon()"
    )


@checked_methods
@dataclass(frozen=True, eq=False)
class WallForce(Compared):
    """The force on one wall.

    If the other end of the chain is free and no constant force pushes the beads towards the wall,
    the peak is complete as soon as the conservation of energy and momentum proves that no later
    force exceeds it (`hertzchain.simulation.wall_bound`).  Otherwise it is an estimate: the
    impact has ended, and the motion towards the wall has not been able to exceed the peak for half
    a transit of the pulse since then, but the beads can return, and a later impact may be
    stronger.  Under gravity towards the wall, it suffices that the first beads have rebounded from
    the row, in which at most 5% of the energy remains (`hertzchain.simulation.rebounds`); a peak
    that is complete remains so while they fall back, until a larger force follows.  Between two
    walls the pulse returns repeatedly, and the peak of a run without
    ``until`` is usually that of its first passage.  In a precompressed chain without losses,
    contacts do not open, waves may add up at any later time, and the peak usually remains
    incomplete: use ``largest_so_far``.

    Attributes
    ----------
    side : str
        ``"left"`` or ``"right"``.
    times, force : ndarray, shape (T,)
        Force on the wall at the saved times [scaled, or s and N].  ``force.max()`` is the largest
        of these samples; the largest force is ``peak``, which lies between saved times.  All
        forces include ``static_force``.
    peak, peak_time : float
        Largest force and its time, located within the steps, not among the saved times; NaN if
        the peak is not complete.
    complete : bool
        Whether the peak is complete by the rule above.
    proven : bool
        Whether `bound` holds at all later times.  If so, no later force exceeds a complete peak;
        otherwise a later impact may be stronger.
    sensitive : bool
        Whether the largest force may be sensitive to small changes, such as another tolerance:
        nothing is lost in the chain, and the largest force does not occur in the first contact with
        the wall (the left wall: nor before the pulse reaches the right wall for the second time).
        `hertzchain.Run.horizon` estimates how long the run is predictable.
    reason : str
        Why the peak is not complete, or why the impact has not ended; empty otherwise.
    complete_since : float or None
        End of the impact: time at which the contact opened for the first time since the motion
        towards the wall could not exceed the peak.  Under a static force it need not open: the
        force must fall to 0.1% of the peak, both without the static force.  `None` if the peak is
        not complete or the impact has not ended, as on a soft wall that is still loaded.  The
        motion and the static force are compared 16 times per transit of the pulse, after steps of
        the integration.  Under a static force, this time, ``impulse_of_impact`` and `duration`
        therefore depend on the steps, mostly by less than 1%, and those of `simulate_many` differ
        from those of `simulate`.  Without one, they are exact unless the contact opens close to a
        comparison: the impact then includes one more or one fewer of the pulses behind the peak,
        which changed ``impulse_of_impact`` by up to 40% in random rows.  Compare ``impulse``, which
        does not depend on the end of the impact.
    largest_so_far, largest_so_far_time : float
        Largest force of the run and its time, complete or not.
    bound : float
        Upper bound of all forces after the end of the run: of later maxima or, if it is larger,
        the force at the end.  If it is not ``proven``, beads that move away from the wall and are
        turned back later are not included.
    momentum_on_its_way, energy_on_its_way : float
        Momentum of the motion towards the wall at the end of the run, and energy that can still
        reach the wall [scaled, or N s and J].
    touches : int
        Number of separate contacts with the wall until ``complete_since``, or so far; later
        contacts, with smaller forces, are not counted.  0 if the pulse has not arrived (`reached`):
        forces far in front of a pulse of Hertz contacts are positive, but can be 1e-300 N.
    impulse_of_impact : float
        Impulse on the wall until ``complete_since``; NaN if this is `None`.  It includes that of
        the static force; see ``excess_impulse``.
    first_contact_end, first_contact_impulse : float or None
        End of the first contact, and its impulse; `None` before that.  Pushes by less than 1e-9
        of the momentum are ignored, and by less than 1e-6 with the larger tolerances of
        `simulate_many` and `gradient`.  With a very stiff wall, many short contacts follow.
    impulse : float
        Impulse of the whole run.  It exceeds that of the impact if further beads arrive later,
        as in forward tapers.
    static_force : float
        Force on the wall at rest, of gravity or precompression.
    units : str
        ``"scaled"`` or ``"SI"``.
    """

    side: Side
    times: Array = field(repr=False)
    force: Array = field(repr=False)
    peak: float
    peak_time: float
    complete: bool
    proven: bool
    sensitive: bool
    reason: str
    complete_since: float | None
    largest_so_far: float
    largest_so_far_time: float
    bound: float
    momentum_on_its_way: float
    energy_on_its_way: float
    touches: int
    impulse_of_impact: float
    first_contact_end: float | None
    first_contact_impulse: float | None
    impulse: float
    static_force: float = 0.0
    units: str = "scaled"

    @property
    def excess_impulse(self) -> float:
        """Impulse of the impact without that of the static force [scaled, or N s]."""
        if self.complete_since is None:
            return math.nan
        return self.impulse_of_impact - self.static_force * self.complete_since

    @property
    def step_dependent(self) -> bool:
        """Whether the end of the impact depends on the steps of the integration.

        This is so under a static force, where the contact need not open: ``complete_since`` is then
        known to about 1/16 of the time in which the pulse passes the chain, and
        ``impulse_of_impact`` and `excess_impulse` to about the impulse of the static force in this
        time.  If the largest force is ``sensitive``, they may change more.
        """
        return self.complete_since is not None and self.static_force != 0.0

    @property
    def duration(self) -> float:
        """Impulse / peak of the impact [scaled, or s]; NaN if it has not ended.

        Both are taken without the static force of gravity or precompression.
        This is not the time in contact.  A single contact lasts longer, by a factor of about 1.6
        if its force is a half sine; an impact of several contacts may have a much shorter peak.
        """
        height = self.peak - self.static_force
        return self.excess_impulse / height if height else math.nan

    @property
    def reached(self) -> bool:
        """Whether the pulse has arrived: a force of more than 1e-6 of `bound` has acted."""
        return self.complete or _is_reached(self.largest_so_far, self.bound)

    @property
    def _contacts(self) -> str:
        """Number of contacts with the wall."""
        separate = "contact" if self.touches == 1 else "separate contact"
        return f"{counted(self.touches, separate)} with the wall"

    @property
    def _later(self) -> str:
        """Statement about forces after a complete peak."""
        motion = " in this run" if self.sensitive else ""
        proven = f"no larger force follows{motion}"
        return proven if self.proven else "a later impact may be stronger"

    @property
    def _caution(self) -> str:
        """Statement about the predictability of the largest force; empty if there is none."""
        return sensitive_in_words("run") if self.sensitive else ""

    def __repr__(self) -> str:
        def at(force: float, time: float) -> str:
            return f"{measure(force, 'N', self.units)} at t = {measure(time, 's', self.units)}"

        impulse = f"impulse {measure(self.impulse, 'N s', self.units)} of the whole run"
        ended = self.complete_since is not None
        touches = f"{self._contacts} {'in the impact' if ended else 'so far'}"
        if self.complete:
            known = "" if self.proven else " so far"
            peak = f"peak{known} {at(self.peak, self.peak_time)}; {self._later}"
            impact = self.reason
            if not impact:
                above = " above the static force" if self.static_force else ""
                above += " (its end depends on the steps)" * self.step_dependent
                impact = f"{measure(self.excess_impulse, 'N s', self.units)} of the impact{above}"
            return short(
                "WallForce", f"{self.side} wall", peak, self._caution, f"{impulse}, {impact}",
                touches,
            )  # fmt: skip
        if not self.reached:
            return short("WallForce", f"{self.side} wall", "the pulse has not arrived", self.reason)
        largest = f"largest so far {at(self.largest_so_far, self.largest_so_far_time)}"
        return short(
            "WallForce", f"{self.side} wall", "peak not complete", largest, self.reason,
            self._caution, impulse, touches,
        )  # fmt: skip

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per saved time.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``time``; the column ``force``.  ``attrs["units"]`` has their units ("1":
            scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
        >>> table = hc.simulate(chain, until=30.0, times=11).wall_force().to_dataframe()
        >>> len(table), table.attrs["units"]["force"]
        (11, '1')
        """
        return force_dataframe(self.times, self.force, self.units)

    def _repr_html_(self) -> str:
        from ..notebook.runs import wall_force_html

        return wall_force_html(self)


def wall_force_of(
    side: Side,
    trace: tuple[Array, Array],
    walls: Array,
    completion: Array,
    approaches: Array,
    complete: Array,
    impulses: Array,
    chain: Chain,
) -> WallForce:
    """Determine the force on one wall from the records of a run."""
    from ..kernels import state_layout

    i = SIDES.index(side)
    done, opened = bool(complete[i]), walls[state_layout.FIRST_END, i] > 0.0
    peak, time = (
        float(walls[state_layout.WALL_PEAK, i]),
        float(walls[state_layout.WALL_PEAK_TIME, i]),
    )
    momentum, energy, bound, force = map(float, approaches[:4, i])
    transit, since = map(float, completion[[state_layout.TRANSIT, state_layout.SINCE], i])
    over = transit == 0.0 and float(completion[state_layout.WATCH_START, i]) > 0.0
    proven = over or motion_can_escape(chain, i)
    ended = done and since > 0.0
    # The forces in front of a pulse are positive, and can underflow; they are not contacts.
    reached = done or _is_reached(peak, bound)
    touches = (completion[state_layout.IMPACT_TOUCHES] if ended else walls[state_layout.TOUCHES])[i]
    reason = ""
    if not done:
        waiting = float(completion[state_layout.WATCH_START, i]) == 0.0
        reason = _reason(chain, peak, bound, energy, force, proven, since, transit, waiting)
    elif not ended:
        later = "beads may still reach it"
        reason = f"the impact has not ended: {_loaded(force, chain) if force else later}"
    return WallForce(
        side=side,
        times=trace[0],
        force=trace[1],
        peak=peak if done else math.nan,
        peak_time=time if done else math.nan,
        complete=done,
        proven=proven,
        sensitive=is_sensitive(chain, walls, i),
        reason=reason,
        complete_since=since if ended else None,
        largest_so_far=peak,
        largest_so_far_time=time,
        bound=max(bound, force),  # a falling force can exceed the bound of maxima
        momentum_on_its_way=momentum,
        energy_on_its_way=energy,
        touches=int(touches) if reached else 0,
        impulse_of_impact=float(completion[state_layout.IMPACT_IMPULSE, i]) if ended else math.nan,
        first_contact_end=float(walls[state_layout.FIRST_END, i]) if opened else None,
        first_contact_impulse=float(walls[state_layout.FIRST_IMPULSE, i]) if opened else None,
        impulse=float(impulses[i]),
        static_force=float(chain.static_state.forces[0 if side == "left" else -1]),
        units=chain.units,
    )


def _is_reached(largest: float, bound: float) -> bool:
    """Whether a force exceeds 1e-6 of the bound of later forces."""
    return largest > (NEGLIGIBLE * bound if math.isfinite(bound) else 0.0)


def _reason(
    chain: Chain,
    peak: float,
    bound: float,
    energy: float,
    force: float,
    proven: bool,
    since: float,
    transit: float,
    waiting: bool,
) -> str:
    """Why the peak on a wall is not complete, in words."""
    if waiting and chain.drive is not None:
        return _driving(chain.drive, chain)
    if bound > peak:
        way = "can still reach" if proven else _way(chain)
        joule = measure(1e6 * energy, "uJ") if 0.0 < energy < 1e-3 else measure(energy, "J")
        if chain.units != "SI":
            joule = f"an energy of {energy:.4g}"
        moving = f"{joule} {way} the wall"
        return f"up to {measure(bound, 'N', chain.units)} may follow, because {moving}"
    if not since and not force:
        return "beads may still reach the wall"
    if not since:
        return _loaded(force, chain)
    half, start = (measure(t, "s", chain.units) for t in (0.5 * transit, since))
    return (
        f"the motion towards the wall has been too weak to exceed it since t = {start}, but must "
        f"be so for half a transit ({half})"
    )


def _way(chain: Chain) -> str:
    """Words after an energy of the present motion; with gravity, it includes that of a fall."""
    return "moves or can fall towards" if chain.gravity else "is still travelling towards"


def _loaded(force: float, chain: Chain) -> str:
    return f"the wall is still loaded with {measure(force, 'N', chain.units)}"


def _driving(drive: Drive, chain: Chain) -> str:
    """How a drive continues that has not ended."""
    if math.isfinite(drive.end):
        return f"the drive does not end before t = {measure(drive.end, 's', chain.units)}"
    if isinstance(drive, SineBurst):
        return "the drive does not end"
    last = drive.amplitude if isinstance(drive, StepDrive) else float(drive.values[-1])
    return f"the drive does not end: a force of {measure(last, 'N', chain.units)} remains"


def later_ends(
    side: Side, completion: Array, approaches: Array, chain: Chain
) -> tuple[float, float]:
    """End of a run that suffices if no larger force follows, and latest end without a given one.

    NaN if they are not known.
    """
    from ..kernels import state_layout

    i = SIDES.index(side)
    transit, since = map(float, completion[[state_layout.TRANSIT, state_layout.SINCE], i])
    estimated = since > 0.0 and not motion_can_escape(chain, i)
    enough = since + (1.0 + MARGIN) * HELD * transit if estimated else math.nan
    return enough, float(approaches[-1, i]) if side == "right" else math.nan


def largest_in_words(wall: WallForce, end: float) -> str:
    """Words after the largest force of an incomplete peak: a maximum, or still rising."""
    if wall.largest_so_far_time >= end * (1.0 - ROUNDING):
        return ", where the force is still rising"
    # A static force has no maximum.
    moved = wall.largest_so_far > wall.static_force * (1.0 + ROUNDING)
    return ", a maximum from which the force has fallen" if moved else ""


def incomplete_peak(wall: WallForce, end: float, ends: tuple[float, float], chain: Chain) -> str:
    """State in a sentence why the peak on a wall is not complete; ``ends`` are of `later_ends`."""
    longer, (enough, last) = "simulate for longer", ends
    if enough > end:
        longer += f", until t = {measure(enough, 's', wall.units, digits=6)}"
    elif last > end:
        latest = measure(last, "s", wall.units, digits=4)
        longer += (
            " (without until, a run ends by itself when the peak is complete, at the latest at "
            f"t = {latest})"
        )
    until = measure(end, "s", wall.units, digits=6)
    if not wall.reached:
        found = f"the pulse had not reached the {wall.side} wall at t = {until}"
        return f"{found}, and {wall.reason}; {longer}" if wall.bound else found
    largest = measure(wall.largest_so_far, "N", wall.units, digits=6)
    advice = f"{longer}, or use largest_so_far"
    if chain.lossless and chain.static_state.forces.all():
        advice = (
            "waves in a precompressed chain without losses do not decay: use largest_so_far, or "
            "add a loss"
        )
    if chain.drive is not None and math.isinf(chain.drive.end):
        ending = (
            "let its table end with 0 (end=... of load_drive), or "
            if isinstance(chain.drive, TableDrive)
            else ""
        )
        advice = f"{ending}use largest_so_far"
    return (
        f"the peak of the force on the {wall.side} wall is not complete: the largest until "
        f"t = {until} is {largest}{largest_in_words(wall, end)}; {wall.reason}; {advice}"
    )
