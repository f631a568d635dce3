r"""The waves of a run: what passes neighbouring contacts one after another.

Events of neighbouring contacts and of one direction are assigned to each other so that the sum of

.. math:: \left(\frac{\Delta t}{h} - 1\right)^2 + \ln^2\frac{J_{k\pm1}}{J_k}

is least, where :math:`h = 0.66\,J/F` is the time that a solitary wave of this duration takes
from contact to contact; pairs of 4 or more are not linked.  A wave ends where it meets another
or a wall, and a new one begins behind.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.checks import number, whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, InputWarning
from hertzchain.simulation.wave_events import (
    LEAST_SAMPLES,
    WaveEvent,
    check_saved_times,
    events_at,
    largest_force_of,
    times_to_save,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from hertzchain.simulation.run import Run

# Time from contact to contact in durations, in the solitary wave of p = 3/2.
HOP: Final = 0.66
# Bounds of that time for events that may be one wave, in parts of it, and of the cost.
EARLIEST, LATEST = -0.36, 2.86
MOST_COST: Final = 4.0
NAMES: Final = {1: "right", -1: "left"}


@dataclass(frozen=True)
class Wave:
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
        """Contacts it passes, shape (M,)."""
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
        """Momentum at each contact, negative towards bead 1, shape (M,) [scaled, or kg m/s]."""
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
        """Median of `momenta`, negative towards bead 1 [scaled, or kg m/s]."""
        return float(np.median(self.momenta))

    @property
    def energy(self) -> float:
        """Median of `energies` [scaled, or J]."""
        return float(np.median(self.energies))

    @property
    def width(self) -> float:
        """Median of the `widths` that are known, NaN if none is [scaled, or s]."""
        known = self.widths[np.isfinite(self.widths)]
        return float(np.median(known)) if len(known) else np.nan

    @property
    def speed(self) -> float:
        """Mean speed along the track, without sign [radii R_1 per time, or m/s].

        The unit is that of `hertzchain.Pulse.speed`.  A contact is half-way between the centres
        of its beads.
        """
        centres = np.concatenate(([0.0], np.cumsum(self.chain.centre_distances)))
        places = 0.5 * (centres[:-1] + centres[1:])[self.contacts[[0, -1]] - 1]
        return float(abs(places[1] - places[0]) / (self.times[-1] - self.times[0]))

    @property
    def samples(self) -> float:
        """Median number of saved times during the passage of a contact.

        Where a wave becomes shorter along its track, as in forward tapers, the column
        ``samples`` of `to_dataframe` says up to where it is resolved.
        """
        return float(np.median([event.samples for event in self.events]))

    @property
    def resolved(self) -> bool:
        """Whether `samples` is at least 8, so that the medians above are reliable."""
        return self.samples >= LEAST_SAMPLES

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
        first, last = self.events[0], self.events[-1]
        doubt = "" if self.resolved else ", unresolved"
        return (
            f"Wave({NAMES[self.direction]}, contacts {first.contact} to {last.contact}, t = "
            f"{first.time:.4g} to {last.time:.4g}, force {self.amplitude:.4g}, momentum "
            f"{self.momentum:.4g}, energy {self.energy:.4g}{doubt})"
        )


@dataclass(frozen=True, eq=False)
class Waves:
    """The waves of a run, by the time of their first contact.

    ``len``, ``waves[0]`` and loops work as with a list of `Wave`.

    Attributes
    ----------
    chain : Chain
        The chain.
    waves : tuple of Wave
        The waves.
    events : tuple of WaveEvent
        Every force maximum of every contact, by contact and time: those of the waves, those
        where waves meet or are turned round (direction 0), and those that no wave contains.

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
        """The waves that pass a contact, in the order in which they pass it.

        Parameters
        ----------
        contact : int
            Number k of the contact between beads k and k + 1.

        Returns
        -------
        Waves

        Raises
        ------
        InputError
            If there is no such contact.

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
        times = [(wave.times[wave.contacts == k], wave) for wave in self.waves]
        chosen = [(float(when[0]), wave) for when, wave in times if len(when)]
        return self._only([wave for _, wave in sorted(chosen, key=lambda pair: pair[0])])

    def at(self, contact: int) -> tuple[WaveEvent, ...]:
        """Every force maximum of one contact, in order of time.

        Parameters
        ----------
        contact : int
            Number k of the contact; 0 is the left wall's and N the right one's.

        Returns
        -------
        tuple of WaveEvent

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
        k = whole_number("contact", contact, least=0, most=self.chain.beads)
        return tuple(event for event in self.events if event.contact == k)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per wave.

        Returns
        -------
        pandas.DataFrame
            Columns ``direction``, ``first_contact``, ``last_contact``, ``first_time``,
            ``last_time``, ``amplitude``, ``momentum``, ``energy``, ``width``, ``speed`` and
            ``samples``, as in `Wave`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> waves = hc.simulate(hc.Chain.uniform(40), until=45.0).waves()
        >>> waves.to_dataframe().amplitude.round(4).tolist()
        [0.6396]
        """
        import pandas as pd

        return pd.DataFrame([_row(wave) for wave in self.waves], columns=[*COLUMNS])

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the track of every wave, contact against time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; a new figure's if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.simulate(hc.Chain.uniform(40), until=45.0).waves().plot().get_ylabel()
        'contact $k$'
        """
        from hertzchain.plotting.waves import plot_waves

        return plot_waves(self, ax=ax)

    def _only(self, chosen: list[Wave]) -> Waves:
        return replace(self, waves=tuple(chosen))

    def __repr__(self) -> str:
        counts = [
            f"{sum(w.direction == sign for w in self)} {name}" for sign, name in NAMES.items()
        ]
        lines = [f"Waves({self.chain.description}: {', '.join(counts)})"]
        shown = self.waves if len(self) <= 12 else self.waves[:10]
        lines += [f"  {wave}" for wave in shown]
        if len(shown) < len(self):
            lines.append(f"  and {len(self) - len(shown)} more")
        if len(self) > self.chain.beads:
            lines.append("  more waves than contacts: run.energy_flux() may say more")
        return "\n".join(lines)


COLUMNS: Final = (
    "direction", "first_contact", "last_contact", "first_time", "last_time", "amplitude",
    "momentum", "energy", "width", "speed", "samples",
)  # fmt: skip


def _row(wave: Wave) -> tuple[float, ...]:
    first, last = wave.events[0], wave.events[-1]
    return (
        wave.direction, first.contact, last.contact, first.time, last.time, wave.amplitude,
        wave.momentum, wave.energy, wave.width, wave.speed, wave.samples,
    )  # fmt: skip


def find_waves(run: Run, threshold: float = 0.01, min_contacts: int = 3) -> Waves:
    """Find the waves of a run; see `hertzchain.Run.waves`.

    Parameters
    ----------
    run : Run
        A run with saved times.
    threshold : float
        Least force of a maximum, in parts of the largest force of the run.
    min_contacts : int
        Number of contacts that a wave must pass.

    Returns
    -------
    Waves

    Examples
    --------
    >>> import hertzchain as hc
    >>> len(find_waves(hc.simulate(hc.Chain.uniform(30), until=30.0)))
    1
    """
    threshold = number("threshold", threshold, above=0.0, below=1.0)
    least = whole_number("min_contacts", min_contacts, least=2)
    check_saved_times(run)
    floor = threshold * largest_force_of(run)
    events = [events_at(run, k, floor) for k in range(run.chain.beads + 1)]
    every = [event for here in events for event in here]
    tracks = [track for sign in NAMES for track in _tracks(events, sign) if len(track) >= least]
    waves = [Wave(run.chain, track[0].direction, tuple(track)) for track in tracks]
    waves.sort(key=lambda wave: wave.events[0].time)
    _check_resolved(run, waves)
    return Waves(run.chain, tuple(waves), tuple(every))


def _tracks(events: list[list[WaveEvent]], sign: int) -> Iterator[list[WaveEvent]]:
    """Events of one direction, linked from contact to contact."""
    moving = [[event for event in here if event.direction == sign] for here in events][::sign]
    open_tracks: dict[int, list[WaveEvent]] = {}
    for here, there in zip(moving, [*moving[1:], []], strict=True):
        for i, event in enumerate(here):
            open_tracks.setdefault(i, [event])
        following = {}
        for i, j in _links(here, there):
            track = open_tracks.pop(i)
            track.append(there[j])
            following[j] = track
        yield from open_tracks.values()
        open_tracks = following


def _links(here: list[WaveEvent], there: list[WaveEvent]) -> Iterator[tuple[int, int]]:
    """Which events of the next contact continue which of this one."""
    from scipy.optimize import linear_sum_assignment

    if not (here and there):
        return
    time, duration, impulse = (np.array(c)[:, np.newaxis] for c in _columns(here))
    next_time, next_duration, next_impulse = (np.array(c) for c in _columns(there))
    wait = (next_time - time) / (0.5 * HOP * (duration + next_duration))
    cost = (wait - 1.0) ** 2 + np.log(next_impulse / impulse) ** 2
    cost[(wait <= EARLIEST) | (wait >= LATEST) | ~(cost < MOST_COST)] = 1e9
    for i, j in zip(*linear_sum_assignment(cost), strict=True):
        if cost[i, j] < MOST_COST:
            yield int(i), int(j)


def _columns(events: list[WaveEvent]) -> Iterator[tuple[float, ...]]:
    return zip(*((e.time, e.duration, e.impulse) for e in events), strict=True)


def _check_resolved(run: Run, waves: list[Wave]) -> None:
    """Refuse a run in which the strongest wave is not resolved, warn where a weaker one is not."""
    missed = [wave for wave in waves if not wave.resolved]
    if not missed:
        return
    worst = min(wave.samples for wave in missed)
    advice = f"save at least times={times_to_save(run, worst)}"
    strongest = max(waves, key=lambda wave: wave.energy)
    if not strongest.resolved:
        raise InputError(
            "too few saved times to find waves: the strongest has "
            f"{strongest.samples:.3g} while it passes a contact, at least {LEAST_SAMPLES:g} are "
            f"needed; {advice}"
        )
    warnings.warn(
        f"{len(missed)} of {len(waves)} waves have fewer than {LEAST_SAMPLES:g} saved times while "
        f"they pass a contact (least: {worst:.3g}) and are marked as unresolved; {advice}",
        InputWarning,
        stacklevel=4,
    )
