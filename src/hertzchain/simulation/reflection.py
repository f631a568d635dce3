"""Reflection and transmission of a wave by a wall, an interface or a defect."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from ..chain.chain import Chain
from ..errors import IncompleteWarning, InputWarning, warn_user
from ..frozen import Compared
from ..representation import counted, measure, short
from ..validation.keywords import checked_methods
from .wave_events import WaveEvent

if TYPE_CHECKING:
    import pandas as pd

# An error of the balance above this fraction of the incident energy is part of the representation.
SHOWN: Final = 1e-3
# Differences of coefficients of energy between neighbouring contacts that are shown.
WIDE: Final = 5e-3
# Momentum that may be on its way to a contact, relative to the momentum counted there and, at
# least, to the incident momentum: slow beads behind a pulse carry some of it for a long time.
SLOW, LEAST_SLOW = 0.1, 0.02
# The same, above which it is part of the representation.
SHOWN_SLOW, LEAST_SHOWN = 0.01, 0.002
# Energy that may be on its way to a contact, relative to the energy counted there and, at least,
# to the incident energy: slow beads behind a pulse have a few times 1e-4 for a long time.
COMING, LEAST = 0.05, 5e-4
# Number of contacts over which a wave extends.
WIDTH: Final = 5


@checked_methods
@dataclass(frozen=True, eq=False)
class Reflection(Compared):
    r"""Reflected and transmitted waves, and coefficients, of an object between two contacts.

    With impulses J and works W of the wave events at the contacts ``before`` and ``after``,

    .. math:: R = \frac{\sum |W_\text{reflected}|}{W_\text{incident}}, \qquad
              T = \frac{\sum |W_\text{transmitted}|}{W_\text{incident}},

    and likewise with J for momentum.

    Attributes
    ----------
    chain : Chain
        The chain.
    before, after : int
        The contacts on both sides of the object.
    incident : WaveEvent
        The first wave at ``before`` that runs towards ``after``.
    reflected : tuple of WaveEvent
        Waves that passed ``before`` later in the opposite direction, until ``until``.
    transmitted : tuple of WaveEvent
        Waves that passed ``after`` in the direction of the incident wave, until ``until``.
    until : float
        Time up to which events are counted [scaled, or s]: the requested time, the end of the
        run, or the time at which another wave entered from outside.
    disturbed : bool
        Whether another wave entered from outside, and ended the count, before the requested time
        or the end of the run.
    kept_energy : float
        Net energy that flowed in between the two contacts from the beginning of the incident
        wave until ``until``, relative to the incident energy: it is still there, or was lost.
    stored_energy : float
        The part of ``kept_energy`` that is still there, as motion of the beads and compression of
        the contacts between the two; the rest was lost.
    separated_energy : float
        The part of ``stored_energy`` of beads that have separated and fly away from a free end,
        so that it does not return to one of the contacts.
    missing_momentum : float
        Impulse of the forces at ``before`` or ``after`` (that with the larger part) that no wave
        has, relative to the incident momentum: of forces that do not rise to a maximum, for
        example.
    entered_energy : float
        Energy of weak waves that entered from outside and did not end the count, relative to the
        incident energy: of at most 5% in total before the incident wave had left, and waves of
        less than 1% each at any time.  It leaves with the counted waves, which limits the error of
        the coefficients of energy to this size.
    energy_on_its_way : tuple of float
        Energy of the beads between the contacts that move towards ``before`` and towards
        ``after`` at ``until``, relative to the incident energy.  Where it exceeds 5% of
        `reflected_energy` or `transmitted_energy`, the coefficient is printed with it, such as
        ``0.0000 (up to 0.0235 more)``: the wave has not passed the contact yet.
    momentum_on_its_way : tuple of float
        Momentum of the beads between the contacts that move towards ``before`` and towards
        ``after`` at ``until``, relative to the incident momentum.  If it exceeds 10% of
        `reflected_momentum` or `transmitted_momentum`, these are not complete, and reading them
        issues an `IncompleteWarning`, or an `InputWarning` if another wave ended the count.
    nearby_energy : tuple of float
        Smallest and largest coefficient R of energy at the 6 contacts in front of ``before``, or
        at those beyond it if only their median agrees with R.  In dimers, weak waves that meet
        the reflected one change R from contact to contact.  NaN if it is not known, as in chains
        with losses.

    Examples
    --------
    A wave that reaches beads of twice the radius:

    >>> import hertzchain as hc
    >>> import numpy as np
    >>> radii = np.where(np.arange(120) < 60, 1.0, 2.0)
    >>> run = hc.simulate(hc.Chain.from_radii(radii), until=140.0, times=1500)
    >>> found = run.reflection(50, 75)
    >>> round(found.reflected_energy, 3), round(found.transmitted_energy, 3)
    (0.523, 0.476)
    """

    chain: Chain
    before: int
    after: int
    incident: WaveEvent
    reflected: tuple[WaveEvent, ...]
    transmitted: tuple[WaveEvent, ...]
    until: float
    disturbed: bool
    kept_energy: float
    stored_energy: float = 0.0
    separated_energy: float = 0.0
    missing_momentum: float = 0.0
    entered_energy: float = 0.0
    energy_on_its_way: tuple[float, float] = (0.0, 0.0)
    momentum_on_its_way: tuple[float, float] = (0.0, 0.0)
    nearby_energy: tuple[float, float] = (math.nan, math.nan)

    @property
    def reflected_energy(self) -> float:
        """Coefficient R of energy."""
        return sum(event.energy for event in self.reflected) / self.incident.energy

    @property
    def transmitted_energy(self) -> float:
        """Coefficient T of energy; 0 where ``after`` is a wall or a free end."""
        return sum(event.energy for event in self.transmitted) / self.incident.energy

    @property
    def reflected_momentum(self) -> float:
        """Reflected momentum relative to the incident momentum, positive."""
        self._warn_incomplete("reflected")
        return self._momenta["reflected"]

    @property
    def transmitted_momentum(self) -> float:
        """Transmitted momentum relative to the incident momentum."""
        self._warn_incomplete("transmitted")
        return self._momenta["transmitted"]

    @property
    def kept_momentum(self) -> float:
        """Momentum that has not left in a wave, 1 + reflected - transmitted momentum.

        It is negative if the beads left behind move back on the whole; where ``after`` is a wall,
        it includes the momentum given to the wall.  Slow waves and beads
        carry much momentum but little energy, so that momenta converge much later than energies:
        state ``until`` with them.
        """
        return 1.0 + self._momenta["reflected"] - self._momenta["transmitted"]

    @property
    def reflected_force(self) -> float:
        """Largest force of the reflected waves, relative to the incident wave."""
        return max((e.amplitude for e in self.reflected), default=0.0) / self.incident.amplitude

    @property
    def transmitted_force(self) -> float:
        """Largest force of the transmitted waves, relative to the incident wave."""
        return max((e.amplitude for e in self.transmitted), default=0.0) / self.incident.amplitude

    @property
    def late_energy(self) -> tuple[float, float]:
        """Parts of R and T that were counted in the last third of the time.

        The time begins when the incident wave has passed ``before``.  Where a part and
        ``entered_energy`` are large, the coefficient depends on ``until``: in a dimer, for
        example, the pulse sheds weak waves that follow it and are reflected, too.  A part is 0 if
        the strongest wave itself passed in this time.
        """
        begin = self.until - (self.until - self.incident.end) / 3.0
        return (
            _counted_since(begin, self.reflected) / self.incident.energy,
            _counted_since(begin, self.transmitted) / self.incident.energy,
        )

    @property
    def unexplained_energy(self) -> float:
        """Error of the balance, 1 + ``entered_energy`` - R - T - ``kept_energy``.

        It differs from 0 if other waves were between the contacts, or passed one of them together
        with a counted wave; the coefficients are then not those of one wave.
        """
        left = self.reflected_energy + self.transmitted_energy + self.kept_energy
        return 1.0 + self.entered_energy - left

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per wave.

        Returns
        -------
        pandas.DataFrame
            Columns ``part`` (``"incident"``, ``"reflected"`` or ``"transmitted"``), ``contact``,
            ``time``, ``amplitude``, ``momentum``, ``energy``, ``width`` and ``samples``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall.rigid())
        >>> found = hc.simulate(chain, until=80.0, times=800).reflection(25, 40)
        >>> found.to_dataframe()["part"].unique().tolist()
        ['incident', 'reflected']
        """
        import pandas as pd

        parts = {"incident": (self.incident,), "reflected": self.reflected,
                 "transmitted": self.transmitted}  # fmt: skip
        columns = ("contact", "time", "amplitude", "momentum", "energy", "width", "samples")
        rows = [
            {"part": part, **{name: getattr(event, name) for name in columns}}
            for part, events in parts.items() for event in events
        ]  # fmt: skip
        return pd.DataFrame(rows)

    @property
    def _momenta(self) -> dict[str, float]:
        """Coefficients of momentum, complete or not."""
        parts = {"reflected": self.reflected, "transmitted": self.transmitted}
        return {
            name: sum(event.impulse for event in events) / self.incident.impulse
            for name, events in parts.items()
        }

    def _energy_coming(self, part: str) -> float:
        """Energy on its way to the contact of a part, if it is relevant; 0 otherwise."""
        coming = self.energy_on_its_way[part == "transmitted"]
        least = max(COMING * self._energies[part], LEAST)
        # Weak waves that entered in front of the object leave it as well.
        return coming if coming > least + self.entered_energy else 0.0

    @property
    def _energies(self) -> dict[str, float]:
        return {"reflected": self.reflected_energy, "transmitted": self.transmitted_energy}

    def _energy_in_words(self, part: str) -> str:
        """Such as ``0.5227`` or, of waves that have not passed, ``0.0000 (up to 0.0235 more)``."""
        more = self._energy_coming(part)
        return f"{self._energies[part]:z.4f}" + (f" (up to {more:.4f} more)" if more else "")

    def _coming(self, part: str, relative: float = SLOW, least: float = LEAST_SLOW) -> float:
        """Momentum on its way to the contact of a part, if it is relevant; 0 otherwise."""
        coming = self.momentum_on_its_way[part == "transmitted"]
        return coming if coming > max(relative * self._momenta[part], least) else 0.0

    def _warn_incomplete(self, part: str) -> None:
        """Warn if beads still carry a relevant momentum towards the contact."""
        if not (coming := self._coming(part)):
            return
        later = "simulate for longer, or state until and kept_momentum with it"
        if self.disturbed:
            later = "another wave enters then; choose contacts nearer to the object between them"
        warn_user(
            f"the {part} momentum, {self._momenta[part]:.4f}, is not complete: beads between the "
            f"contacts still carry {coming:.4f} of the incident momentum towards contact "
            f"{self.after if part == 'transmitted' else self.before} at t = "
            f"{measure(self.until, 's', self.chain.units, 6)}; {later}",
            InputWarning if self.disturbed else IncompleteWarning,
        )

    def _momentum_in_words(self, part: str) -> str:
        """Such as ``0.7641 (not complete)`` or ``1.6309 (up to 0.0911 more)``."""
        more = self._coming(part, SHOWN_SLOW, LEAST_SHOWN)
        state = f" (up to {more:.4f} more)" if more else ""
        state = " (not complete)" if self._coming(part) else state
        return f"{self._momenta[part]:z.4f}{state}"

    @property
    def _nearby(self) -> str:
        """Range of R at neighbouring contacts, if it is wide or does not include that here.

        Where waves overlap, it is not a range of the coefficient.
        """
        (low, high), here = self.nearby_energy, self.reflected_energy
        if self.overlapping or not max(high, here) - min(low, here) > WIDE:
            return ""
        return f" ({low:.4f} to {high:.4f} at neighbouring contacts)"

    @property
    def overlapping(self) -> bool:
        """Whether waves overlap at the contacts, which are too near to each other or to the end.

        They should be at least 10 contacts apart, and 5 from a wall or the end; the coefficients
        are not those of separate waves otherwise.
        """
        return bool(self._overlap)

    @property
    def _overlap(self) -> str:
        """Why a wave is longer than the distance from the contacts to what reflects it, or ''."""
        chain, first, second = self.chain, self.before, self.after
        least, inside = least_distance(chain, second), second not in (0, chain.beads)
        if abs(second - first) < least:
            sides = f", {WIDTH} on each side of the reflecting object" if inside else ""
            return (
                f"contacts {first} and {second} are {abs(second - first)} apart, but a wave "
                f"extends over about {WIDTH}: incident and reflected waves overlap there; choose "
                f"contacts at least {least} apart{sides}"
            )
        near = min(second, chain.beads - second)
        if 0 < near < WIDTH:
            end, wall = (0, chain.left_wall) if second < WIDTH else (chain.beads, chain.right_wall)
            return (
                f"contact {second} is {near} from the end of the chain, whose reflection meets "
                f"the waves there; choose one at least {WIDTH} from the end"
                + (f", or that of the wall itself, {end}" if wall else "")
            )
        return ""

    @property
    def _separated(self) -> str:
        shown = f" ({self.separated_energy:.4f} in beads that have separated)"
        return shown if self.separated_energy > SHOWN else ""

    @property
    def _unexplained(self) -> str:
        shown = f", unexplained {self.unexplained_energy:z.4f}"
        return shown if abs(self.unexplained_energy) > SHOWN else ""

    def _repr_html_(self) -> str:
        from ..notebook.waves import reflection_html

        return reflection_html(self)

    @property
    def _wall(self) -> bool:
        """Whether ``after`` is the contact with a wall."""
        walls = {0: self.chain.left_wall, self.chain.beads: self.chain.right_wall}
        return walls.get(self.after) is not None

    @property
    def _words(self) -> list[str]:
        """The contacts, the energy kept, the reflected and transmitted waves, the momentum kept."""
        ended = "another wave entered" if self.disturbed else "nothing else entered"
        if self.entered_energy > SHOWN:
            ended = f"waves with energy {self.entered_energy:.4f} entered"
        end, near = measure(self.until, "s", self.chain.units), self._nearby
        passed = f"{self.reflected_energy:z.4f}{near}"
        reflected = passed if near else self._energy_in_words("reflected")
        return [
            f"contacts {self.before} to {self.after}, until t = {end}, {ended}",
            f"energy kept {self.kept_energy:z.4f}{self._separated}{self._unexplained}",
            f"reflected energy {reflected}, "
            f"momentum {self._momentum_in_words('reflected')}, "
            f"{counted(len(self.reflected), 'wave')}"
            f"{'; the waves overlap' if self.overlapping else ''}",
            f"transmitted energy {self._energy_in_words('transmitted')}, "
            f"momentum {self._momentum_in_words('transmitted')}, "
            f"{counted(len(self.transmitted), 'wave')}",
            f"momentum kept {self.kept_momentum:z.4f}{' (wall included)' if self._wall else ''}",
        ]

    def __repr__(self) -> str:
        return short("Reflection", *self._words)


def least_distance(chain: Chain, after: int) -> int:
    """Distance between the two contacts at which waves at one of them pass completely."""
    return WIDTH if after in (0, chain.beads) else 2 * WIDTH


def _counted_since(begin: float, waves: tuple[WaveEvent, ...]) -> float:
    """Energy of the waves after a time; 0 if the strongest one is among them."""
    strongest = max(waves, key=lambda event: event.energy, default=None)
    if strongest is None or strongest.time > begin:
        return 0.0
    return sum(event.energy for event in waves if event.time > begin)
