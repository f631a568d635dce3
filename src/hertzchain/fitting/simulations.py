"""Simulated signals of chains; chains with the same scaled motion are simulated once."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, ModelRangeWarning, SimulationError
from ..recorded_warnings import ignore_warnings, record_warnings
from ..simulation.simulate import simulate
from ..simulation.time_scales import transit_times
from ..traces.places import Place
from ..traces.signals import Signal
from .law_parameters import JUMPING
from .symmetry import Units, similarity_key, units_of

# Tolerance of trial runs.  Their traces are accurate to 5e-9 of the peak, sufficient for finite
# differences.
RTOL: Final = 1e-9
# Saved times per unit of time; a pulse takes several units to pass a bead.
PER_UNIT: Final = 32
# ... and this many times as many where the force jumps.
FINER: Final = 2
# ... and at most this many times as many where later beads are smaller, and pulses shorter.
MAX_FINER: Final = 8.0
MAX_TIMES: Final = 400_000
# Ratio of the duration of a run to that of the data; slower chains then need no new run.
LONGER: Final = 1.12
# Step limit of a trial run, as a multiple of the steps of the first run.
STEP_FACTOR, MIN_STEPS = 50, 20_000
KEPT: Final = 96
# Duration of a nominal simulation, as a multiple of the time in which the pulse passes.
PASSES: Final = 1.5


class Signals(NamedTuple):
    """A key that identifies signals, their spacing in time, and signals (times, places)."""

    key: bytes
    spacing: float
    columns: Array


@dataclass(frozen=True, eq=False)
class Simulated:
    """Signals of a chain on an even grid of times from 0, in SI."""

    units: Units
    spacing: float
    columns: Array
    force: Array

    def scaled_to(self, key: bytes, units: Units) -> Signals:
        """Signals of a chain with the same scaled motion, in other units."""
        factor = np.where(
            self.force, units.force / self.units.force, units.velocity / self.units.velocity
        )
        spacing = self.spacing * units.time / self.units.time
        # In the same units, the signals of such chains are the same.
        label = key + np.array([units.force, units.velocity]).tobytes()
        return Signals(label, spacing, self.columns * factor)


@dataclass(eq=False)
class Simulator:
    """Simulates signals at given places, and caches the latest runs by their scaled motion.

    Attributes
    ----------
    places : sequence of Place
        Places of all sensors.
    progress : callable or None
        Called with the number of simulations after each.
    count : int
        Simulations so far.
    trying : str
        What they try, in a search for causes of residuals.
    """

    places: Sequence[Place]
    progress: Callable[[int], None] | None = None
    count: int = 0
    failed: int = 0
    trying: str = ""
    _steps: int = 0
    _kept: OrderedDict[bytes, Simulated] = field(default_factory=OrderedDict)

    def signals(self, chain: Chain, duration: float) -> Signals:
        """Signals of a chain for at least a duration; simulated if necessary."""
        units = units_of(chain)
        key = similarity_key(chain, units)
        found = self._kept.get(key)
        if found is not None:
            scaled = found.scaled_to(key, units)
            if scaled.spacing * (len(scaled.columns) - 1) >= duration:
                self._kept.move_to_end(key)
                return scaled
        found = self._kept[key] = self._simulate(chain, units, LONGER * duration)
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return found.scaled_to(key, units)

    def column(self, run: Signals, signal: Signal) -> Array:
        """Simulated signal at the place of a measured one."""
        return run.columns[:, [place.name for place in self.places].index(signal.name)]

    def count_one(self, _: int = 0) -> None:
        """Count and report a simulation of this simulator, or of one at other places."""
        self.count += 1
        if self.progress is not None:
            self.progress(self.count)

    def knows(self, chain: Chain) -> bool:
        """Whether a chain with the same scaled motion has been simulated."""
        return similarity_key(chain, units_of(chain)) in self._kept

    def _simulate(self, chain: Chain, units: Units, duration: float) -> Simulated:
        jumps = any(isinstance(law, JUMPING) for law in chain.contact_losses)
        part = PER_UNIT * (FINER if jumps else 1)
        spacing = units.time / part if units.natural else duration / 2000
        spacing /= min(_shortening(chain), max(MAX_TIMES // 2 * spacing / duration, 1.0))
        count = int(np.ceil(duration / spacing)) + 4
        if count > MAX_TIMES:
            raise InputError(
                f"the traces require a simulation of {duration:.3g} s, {count / PER_UNIT:.0f} "
                "contact times, which is too long to fit; check that the times are in the unit of "
                "their header, or cut the traces after the pulse and its first echoes"
            )
        limit = None if not self._steps else max(MIN_STEPS, STEP_FACTOR * self._steps)
        with ignore_warnings():
            run = simulate(
                chain, times=spacing * np.arange(count), rtol=RTOL, max_steps=limit, check=False
            )
        self.count_one()
        if not run.success:
            self.failed += 1
            raise SimulationError(run.message)
        self._steps = self._steps or run.steps
        columns = np.column_stack([place.signal(run) for place in self.places])
        force = np.array([place.quantity == "force" for place in self.places])
        return Simulated(units, spacing, columns, force)


def passing_time(chain: Chain) -> float:
    """A time in which the pulse passes the chain, with a margin; infinite if it is not known.

    The transit times of a driven chain depend on the pieces of its drive, not on the pulse.
    """
    if chain.drive is not None:
        return np.inf
    times = transit_times(chain)
    return PASSES * float(times.sum() + 2.0 * times.max(initial=0.0))


def _shortening(chain: Chain) -> float:
    """Ratio of the time in which a pulse passes the first bead to the shortest such time."""
    times = transit_times(chain)
    first = float(times[min(chain.strikers, len(times) - 1)])
    return min(max(first / float(times.min()), 1.0), MAX_FINER)


def range_notes(chain: Chain, duration: float) -> tuple[str, ...]:
    """Warnings of Hertz's range for one chain, as sentences."""
    with record_warnings() as caught:
        simulate(chain, until=duration, times=2, rtol=RTOL, check=False)
    found: list[Any] = [each for each in caught if type(each) is ModelRangeWarning]
    # The velocity of measured data cannot be reduced any more.
    lower = re.compile(r"reduce the velocity(?: to about (\S+ m/s))?")
    return tuple(
        lower.sub(
            lambda it: f"measure at {f'about {it[1]}' if it[1] else 'a lower velocity'}", text
        )
        for text in map(str, found)
    )
