"""Travelling waves: a single wave, and all waves of a run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputWarning, warn_user
from ..frozen import Compared
from ..representation import NO_BREAK, counted, folded, measure, short, wrapped
from ..validation.keywords import checked_methods
from ..validation.numbers import contact_number, whole_number
from .unlisted_energy import ADVICE, NO_WAVE, UNLISTED, unlisted_in_words
from .wave_events import WaveEvent
from .wave_samples import MIN_SAMPLES, SHORTEST

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

DIRECTIONS: Final = {1: "right", -1: "left"}
# Relative difference between the start and the end of a track from which both values are shown,
# and that of other quantities of the same wave.
SAME, SIMILAR = 0.2, 0.05
TRANSPORTED: Final = ("amplitude", "momentum", "energy")
PLURALS: Final = {"amplitude": "amplitudes", "momentum": "momenta", "energy": "energies",
                  "width": "widths"}  # fmt: skip


@checked_methods
@dataclass(frozen=True, eq=False)
class Wave(Compared):
    """One travelling wave.

    Attributes
    ----------
    chain : Chain
        The chain.
    direction : int
        1 towards bead N ("right"), -1 towards bead 1 ("left").
    events : tuple of WaveEvent
        Its passage of each contact, in order of time; see
        `hertzchain.simulation.wave_events.WaveEvent`.

    Notes
    -----
    ``amplitude``, ``momentum``, ``energy``, ``width`` and ``speed`` are medians over the contacts.
    They describe a wave in equal beads.  In tapers and beyond interfaces a wave changes along its
    track: ``repr`` then shows the medians of the first and of the last third of the contacts, and
    `to_dataframe` has the values of all contacts.

    Examples
    --------
    >>> import hertzchain as hc
    >>> wave = hc.simulate(hc.Chain.uniform(40), until=45.0).waves()[0]
    >>> round(wave.momentum, 4), round(wave.energy, 4), round(wave.amplitude, 4)
    (1.1383, 0.4968, 0.6396)
    """

    chain: Chain
    direction: int
    events: tuple[WaveEvent, ...]

    @cached_property
    def contacts(self) -> Array:
        """Contacts that the wave passes, shape (M,)."""
        return np.array([event.contact for event in self.events])

    @cached_property
    def times(self) -> Array:
        """Times of the force maxima, shape (M,) [scaled, or s]."""
        return np.array([event.time for event in self.events])

    @cached_property
    def amplitudes(self) -> Array:
        """Largest forces beyond the static ones, shape (M,) [scaled, or N]."""
        return np.array([event.amplitude for event in self.events])

    @cached_property
    def momenta(self) -> Array:
        """Momentum at each contact, negative towards bead 1, shape (M,) [scaled, or N s]."""
        return np.array([event.momentum for event in self.events])

    @cached_property
    def energies(self) -> Array:
        """Energy at each contact, shape (M,) [scaled, or J]."""
        return np.array([event.energy for event in self.events])

    @cached_property
    def widths(self) -> Array:
        """Full widths at half maximum of the forces in time, shape (M,) [scaled, or s].

        NaN where the force does not fall to half of its maximum on both sides.
        """
        return np.array([event.width for event in self.events])

    @property
    def amplitude(self) -> float:
        """Median of `amplitudes` [scaled, or N]."""
        return float(np.median(self.amplitudes))

    @property
    def momentum(self) -> float:
        """Median of `momenta`, negative towards bead 1 [scaled, or N s].

        Events that are `WaveEvent.merged` count only if all are.
        """
        return float(np.median(self.momenta[self._counted]))

    @property
    def energy(self) -> float:
        """Median of `energies`, of the same events as `momentum` [scaled, or J]."""
        return float(np.median(self.energies[self._counted]))

    @property
    def _counted(self) -> NDArray[np.bool_]:
        separated = np.array([not event.merged for event in self.events])
        return separated if separated.any() else ~separated

    def _ends(self, name: str) -> tuple[float, float]:
        """Medians of a quantity over the first and the last third; of all, if they are short."""
        values = getattr(self, PLURALS[name])
        known = values[np.isfinite(values) & (self._counted | (name in ("amplitude", "width")))]
        third = len(known) // 3
        if third < 2:
            return (getattr(self, name),) * 2
        return float(np.median(known[:third])), float(np.median(known[-third:]))

    def _along(self, name: str) -> tuple[float, ...]:
        """Median of a quantity, or those of the first and the last third if the wave changes."""
        ends = self._ends(name)
        changes = any(_differ(*self._ends(each), SAME) for each in (*TRANSPORTED, name))
        return ends if changes and _differ(*ends, SIMILAR) else (getattr(self, name),)

    @property
    def width(self) -> float:
        """Median of the known `widths`, in time; NaN if none is known [scaled, or s]."""
        known = self.widths[np.isfinite(self.widths)]
        return float(np.median(known)) if len(known) else np.nan

    @property
    def speed(self) -> float:
        """Median speed from contact to contact, without sign [radii R_1 per time, or m/s].

        The unit is that of `hertzchain.Pulse.speed`.  A contact is half-way between the centres
        of its beads.
        """
        centres = np.concatenate(([0.0], np.cumsum(self.chain.centre_distances)))
        places = 0.5 * (centres[:-1] + centres[1:])[self.contacts - 1]
        return float(np.median(np.abs(np.diff(places) / np.diff(self.times))))

    @property
    def samples(self) -> float:
        """Number of saved times during the passage of a contact.

        It is the smaller median of the first and of the last third of the contacts; of all, if a
        third has fewer than 3.  If a wave becomes shorter along its track, as in forward tapers,
        the column ``samples`` of `to_dataframe` shows up to which contact it is resolved.
        """
        each = [event.samples for event in self.events]
        third = len(each) // 3
        parts = [each] if third < SHORTEST else [each[:third], each[-third:]]
        return float(min(np.median(part) for part in parts))

    @property
    def resolved(self) -> bool:
        """Whether `samples` is at least 8, which makes all medians above reliable."""
        return self.samples >= MIN_SAMPLES

    @property
    def merged(self) -> bool:
        """Whether `momentum` and `energy` may include waves that have not separated from this one.

        This is so if most of its events are `WaveEvent.merged`.
        """
        return bool(np.median([event.merged for event in self.events]) > 0.0)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per contact.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``contact``; columns ``time``, ``amplitude``, ``momentum``, ``energy``,
            ``width`` and ``samples``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> wave = hc.simulate(hc.Chain.uniform(40), until=45.0).waves()[0]
        >>> round(float(wave.to_dataframe().time.loc[20]), 3)
        23.976
        """
        import pandas as pd

        columns = {
            "time": self.times, "amplitude": self.amplitudes, "momentum": self.momenta,
            "energy": self.energies, "width": self.widths,
            "samples": [event.samples for event in self.events],
        }  # fmt: skip
        return pd.DataFrame(columns, index=pd.Index(self.contacts, name="contact"))

    def __repr__(self) -> str:
        first, last, units = self.events[0], self.events[-1], self.chain.units
        facts = {"force": ("amplitude", "N"), "momentum": ("momentum", "N s"),
                 "energy": ("energy", "J")}  # fmt: skip
        values = ", ".join(
            f"{word} {' to '.join(measure(each, unit, units) for each in self._along(name))}"
            for word, (name, unit) in facts.items()
        )
        doubt = ", merged" * self.merged + ", unresolved" * (not self.resolved)
        return wrapped(
            f"Wave({DIRECTIONS[self.direction]}, contacts {first.contact} to {last.contact}, t = "
            f"{measure(first.time, 's', units)} to {measure(last.time, 's', units)}, {values}"
            f"{doubt})"
        )

    def _repr_html_(self) -> str:
        from ..notebook.waves import wave_html

        return wave_html(self)


@checked_methods
@dataclass(frozen=True, eq=False)
class Waves(Compared):
    """The waves of a run, ordered by the time at their first contact.

    ``len``, ``waves[0]`` and loops work as with a list of `Wave`.

    Attributes
    ----------
    chain : Chain
        The chain.
    waves : tuple of Wave
        The waves.
    events : tuple of WaveEvent
        Every force maximum of every contact, ordered by contact and time: maxima of the waves,
        maxima where waves meet or are reflected (direction 0), and maxima that belong to no wave.
    unlisted_energy : ndarray, shape (N - 1,)
        Part of the energy that passed contact k between beads k and k + 1, in either direction,
        that is in no wave of the whole list: that of maxima which could not be linked, of waves
        below ``threshold``, of rarefactions, and where waves meet; 0 where little energy passed.

    Examples
    --------
    Two equal beads as strikers make two waves:

    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.uniform(60).struck_by(count=2), until=60.0, times=2000)
    >>> [round(wave.amplitude, 4) for wave in run.waves().passing(40)]
    [0.8376, 0.3847]
    """

    chain: Chain
    waves: tuple[Wave, ...]
    events: tuple[WaveEvent, ...]
    unlisted_energy: Array

    def __len__(self) -> int:
        return len(self.waves)

    def __getitem__(self, index: int) -> Wave:
        return self.waves[index]

    def __iter__(self) -> Iterator[Wave]:
        return iter(self.waves)

    @property
    def right(self) -> Waves:
        """The waves towards bead N."""
        return self._only([wave for wave in self.waves if wave.direction > 0])

    @property
    def left(self) -> Waves:
        """The waves towards bead 1."""
        return self._only([wave for wave in self.waves if wave.direction < 0])

    def passing(self, contact: int) -> Waves:
        """The waves that pass a contact, in order of time.

        Parameters
        ----------
        contact : int
            Number k of the contact between beads k and k + 1.

        Raises
        ------
        InputError
            If there is no such contact.

        Warns
        -----
        InputWarning
            If more than half of the energy that passed the contact is in no listed wave.

        Examples
        --------
        A wave and its reflection from a wall:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall.rigid())
        >>> waves = hc.simulate(chain, until=60.0, times=1000).waves()
        >>> [wave.direction for wave in waves.passing(20)][:2]
        [1, -1]
        """
        k = whole_number("contact", contact, least=1, most=self.chain.beads - 1)
        if (share := float(self.unlisted_energy[k - 1])) > UNLISTED:
            warn_user(NO_WAVE.format(share, k) + ADVICE, InputWarning)
        times = [(wave.times[wave.contacts == k], wave) for wave in self.waves]
        chosen = [(float(when[0]), wave) for when, wave in times if len(when)]
        return self._only([wave for _, wave in sorted(chosen, key=lambda pair: pair[0])])

    def at(self, contact: int) -> tuple[WaveEvent, ...]:
        """Every force maximum of one contact, in order of time.

        Parameters
        ----------
        contact : int
            Number k of the contact; 0 is the contact with the left wall, N with the right wall.

        Raises
        ------
        InputError
            If there is no such contact.

        Examples
        --------
        >>> import hertzchain as hc
        >>> waves = hc.simulate(hc.Chain.uniform(40), until=45.0).waves()
        >>> [event.direction for event in waves.at(20)]
        [1]
        """
        k = contact_number(contact, self.chain.beads)
        return tuple(event for event in self.events if event.contact == k)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per wave.

        Returns
        -------
        pandas.DataFrame
            Columns ``direction``, ``first_contact``, ``last_contact``, ``first_time``,
            ``last_time``, ``amplitude``, ``momentum``, ``energy``, ``width``, ``speed`` and
            ``samples``, as in `Wave`, and ``first_amplitude``, ``last_amplitude``,
            ``first_momentum``, ``last_momentum``, ``first_energy`` and ``last_energy``: medians
            over the first and over the last third of the contacts, which differ in tapers and
            beyond interfaces.

        Examples
        --------
        >>> import hertzchain as hc
        >>> waves = hc.simulate(hc.Chain.uniform(40), until=45.0).waves()
        >>> waves.to_dataframe().amplitude.round(4).tolist()
        [0.6396]
        """
        import pandas as pd

        names = [f"{end}_{name}" for name in TRANSPORTED for end in ("first", "last")]
        return pd.DataFrame([_row(wave) for wave in self.waves], columns=[*COLUMNS, *names])

    def plot(self, *, legend: bool = True, ax: Axes | None = None) -> Axes:
        """Plot the track of every wave: contact against time.

        Parameters
        ----------
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.  By default, a new figure is created.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.simulate(hc.Chain.uniform(40), until=45.0).waves().plot().get_ylabel()
        'contact $k$'
        """
        from ..plotting.waves import plot_waves

        return plot_waves(self, legend=legend, ax=ax)

    def _only(self, chosen: list[Wave]) -> Waves:
        return replace(self, waves=tuple(chosen))

    @property
    def _unlisted(self) -> str:
        return unlisted_in_words(self.unlisted_energy)

    def _heading(self) -> str:
        right, left = (sum(w.direction == sign for w in self) for sign in DIRECTIONS)
        counts = f"{counted(right, 'wave')} to the right, {left} to the left"
        return f"{self.chain.description}; {counts}"

    def __repr__(self) -> str:
        if not len(self):
            return short("Waves", self._heading(), self._unlisted)
        strongest = max(self, key=lambda wave: wave.energy)
        units = self.chain.units
        return short(
            "Waves",
            self._heading(),
            f"the strongest {DIRECTIONS[strongest.direction]}, force "
            f"{measure(strongest.amplitude, 'N', units)}, momentum "
            f"{measure(strongest.momentum, 'N s', units)}",
            "print() lists them",
            self._unlisted,
        )

    def _repr_html_(self) -> str:
        from ..notebook.waves import waves_html

        return waves_html(self)

    def __str__(self) -> str:
        shown = self.waves if len(self) <= 12 else self.waves[:10]
        lines = [f"Waves({self._heading()})", *(f"  {' '.join(repr(w).split())}" for w in shown)]
        if len(shown) < len(self):
            lines.append(f"  and {len(self) - len(shown)} more")
        if len(self) > self.chain.beads:
            lines.append("  more waves than contacts: run.energy_flux() may show more")
        lines += [f"  {self._unlisted}"] if self._unlisted else []
        # Lines are broken only between properties of a wave.
        return folded(re.sub(r"(?<=[^, ]) ", NO_BREAK, "\n".join(lines)), below=6)


def _differ(first: float, last: float, most: float) -> bool:
    return abs(first - last) > most * max(abs(first), abs(last))


COLUMNS: Final = (
    "direction", "first_contact", "last_contact", "first_time", "last_time", "amplitude",
    "momentum", "energy", "width", "speed", "samples",
)  # fmt: skip


def _row(wave: Wave) -> tuple[float, ...]:
    first, last = wave.events[0], wave.events[-1]
    return (
        wave.direction, first.contact, last.contact, first.time, last.time, wave.amplitude,
        wave.momentum, wave.energy, wave.width, wave.speed, wave.samples,
        *(end for name in TRANSPORTED for end in wave._ends(name)),
    )  # fmt: skip
