"""Quantities of the chains of an ensemble, computed by the elastic kernel or by `simulate`.

Both methods give an `Outcome`: columns with the names of the table of quantities, and the status of
each run.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..chain.hertz_range import hertz_range
from ..collision import Array
from ..errors import InputError
from ..kernels.limits import MIN_HEIGHT
from ..kernels.wall_rule import ROUNDING
from ..pulse.quantities import (
    BODY_QUANTITIES,
    FINAL_QUANTITIES,
    LARGEST_QUANTITIES,
    QUANTITIES,
    SENSOR_QUANTITIES,
    WALL_QUANTITIES,
    Quantity,
)
from ..validation.objects import Progress
from .body_bound import body_bound
from .end_forces import static_forces_around
from .ends_of_runs import ON_WALL, body_of_run, energy_parts, final_of_run, sensors_of_run
from .ensemble_input import is_covered, kernel_input
from .run_end import Status
from .run_message import FAILURES, end_message, follows_first_contact, is_sensitive
from .run_pulse import pulse_of, times_between
from .sensor_force import MANY_TIMES
from .simulate import MAX_RTOL, MIN_RTOL, default_step_limit, simulate, simulate_to_peak
from .wall_bound import RIGHT

# Quantities of the leading pulse that a simulation determines.
PULSE_QUANTITIES: Final = {
    name: each for name, each in QUANTITIES.items() if not each.estimate
}  # fmt: skip
TABLE_QUANTITIES: Final[dict[str, Quantity]] = {
    **PULSE_QUANTITIES, **WALL_QUANTITIES, **BODY_QUANTITIES, **SENSOR_QUANTITIES,
    **FINAL_QUANTITIES, **LARGEST_QUANTITIES,
}  # fmt: skip
# These quantities need no motion after the largest force on the wall and the leading pulse.
UNTIL_PEAK: Final = {
    *PULSE_QUANTITIES, "wall_peak_force", "wall_peak_time", "wall_largest_so_far",
}  # fmt: skip
# The quantity whose chains the kernel for many chains does not integrate.
ALONE: Final = "body_duration"
# Factor of the tolerance for `simulate`, whose method has larger errors at equal tolerance.
TIGHTER: Final = 0.1
# Scratch arrays of the kernel that are not in use, each with its number of gauges; a set has 8 MB.
_SPARE: Final[deque[tuple[int, tuple[Array, ...]]]] = deque(maxlen=16)
_LOCK: Final = threading.Lock()

STATUS: Final[tuple[Status, ...]] = (
    "step limit", "pulse left", "time reached", "wall force complete", "transit limit",
    "nothing more happens", "step limit", "step too small",
)  # fmt: skip


@dataclass(frozen=True)
class Request:
    """Quantities, sensors and options that are the same for all chains."""

    keep: tuple[str, ...]
    sensors: tuple[int, ...]
    until: float | None
    rtol: float
    max_steps: int | None
    # Whether contacts of materials are compared with Hertz's range.
    check_range: bool = True

    @property
    def keeps_largest(self) -> bool:
        """Whether a quantity is requested that follows from the overlaps of the whole run."""
        return any(name in LARGEST_QUANTITIES for name in self.keep)

    def whole_run(self, chain: Chain) -> bool:
        """Whether overlaps after the passage of the leading pulse are requested, too."""
        return self.keeps_largest or (self.check_range and chain.materials is not None)

    def by_kernel(self, chain: Chain) -> bool:
        """Whether the elastic kernel integrates a chain: it records no durations."""
        return is_covered(chain, self.until) and ALONE not in self.keep

    def peak_only(self, chain: Chain) -> bool:
        """Whether a run may end when its largest force on the wall is proven."""
        return UNTIL_PEAK.issuperset(self.keep) and not self.whole_run(chain)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Columns of some chains, and the status of their runs."""

    columns: dict[str, Array]
    status: Sequence[str]
    complete: NDArray[np.bool_]
    sensitive: NDArray[np.bool_]
    overlaps: Array
    reasons: dict[int, str]


def check_member(chain: Chain, request: Request) -> None:
    """Raise `InputError` if a chain lacks a wall or a bead that the quantities require."""
    if chain.right_wall is None and any(name in WALL_QUANTITIES for name in request.keep):
        raise InputError("the right end of this chain is free; add a right_wall")
    if chain.right_wall is not None and any(name in BODY_QUANTITIES for name in request.keep):
        raise InputError(ON_WALL)
    beyond = [bead for bead in request.sensors if bead > chain.beads]
    if beyond:
        raise InputError(f"there is no bead {beyond[0]} with a sensor among {chain.beads}")
    if "yield_ratio" in request.keep and chain.materials is None:
        raise InputError("yield_ratio needs a chain with materials; use Chain.from_materials")


def by_kernel(chains: Sequence[Chain], request: Request, signal: NDArray[np.int64]) -> Outcome:
    """Integrate chains of one kind side by side."""
    from ..kernels import elastic_chains
    from ..kernels import elastic_layout as layout

    kernel: Any = elastic_chains
    peak_only = request.peak_only(chains[0])
    given = kernel_input(chains, request.until, peak_only=peak_only)
    count, beads = len(chains), chains[0].beads
    sensors = [(bead - 1, bead) for bead in request.sensors]
    whole_run = request.whole_run(chains[0])
    contacts = [(contact, contact) for contact in range(beads)] if whole_run else []
    # That of the last contact is the last one.
    places = np.array([(beads, beads), *sensors, *contacts, (beads - 1, beads - 1)])
    records = np.zeros((count, layout.RECORDS, beads))
    summary = np.zeros((count, layout.SUMMARY))
    readings = np.zeros((count, len(places), layout.GAUGE_ROWS))
    limit = request.max_steps or default_step_limit(beads)
    scratch = _scratch(kernel, layout, len(places), beads)
    kernel.follow(
        given.chains, given.numbers, places, request.rtol, float(limit), given.hertz,
        given.walled, given.careful, records, summary, readings, signal, *scratch,
    )  # fmt: skip
    with _LOCK:
        _SPARE.append((len(places), scratch))
    found = _KernelResults(chains, given.chains, records, summary, readings)
    return found.outcome(request)


def _scratch(kernel: Any, layout: Any, gauges: int, beads: int) -> tuple[Array, ...]:
    """Zeros as scratch arrays of the kernel, if possible those of an earlier call."""
    with _LOCK:
        place = next((i for i, (number, _) in enumerate(_SPARE) if number == gauges), None)
        if place is not None:
            _, scratch = _SPARE[place]
            del _SPARE[place]
    if place is None:
        return tuple(kernel.scratch_for(gauges))
    rows, *others = scratch
    # The kernel uses up to seven entries per lane in addition to the beads.
    rows.reshape(-1, layout.ROW)[:, : layout.LANES * (beads + 7)] = 0.0
    for values in others:
        values.fill(0)
    return scratch


def _static_force_on_wall(chain: Chain) -> float:
    loaded = chain.gravity != 0.0 or chain.precompression > 0.0
    return float(chain.static_state.forces[-1]) if loaded else 0.0


class _KernelResults:
    """Results of the kernel for chains of one kind, as quantities."""

    def __init__(
        self, chains: Sequence[Chain], given: Array, records: Array, summary: Array, readings: Array
    ) -> None:
        from ..kernels import elastic_layout

        self.layout: Any = elastic_layout
        self.chains, self.given, self.records = chains, given, records
        self.summary, self.readings = summary, readings

    def outcome(self, request: Request) -> Outcome:
        """The requested quantities."""
        layout, keep = self.layout, request.keep
        found: dict[str, Array] = {}
        if any(name in PULSE_QUANTITIES for name in keep):
            found |= self._pulse()
        if any(name in WALL_QUANTITIES for name in keep):
            found |= self._wall()
        if any(name in SENSOR_QUANTITIES for name in keep):
            found |= self._sensors(request.sensors)
        if any(name in BODY_QUANTITIES for name in keep):
            found |= self._body()
        overlaps = self._overlaps(request)
        found["largest_overlap"] = overlaps[:, 1:-1]
        found["dent"] = np.zeros_like(overlaps[:, 1:-1])  # the contacts are elastic
        if "yield_ratio" in keep:
            pairs = zip(self.chains, overlaps, strict=True)
            found["yield_ratio"] = np.array([largest_yield_ratio(*each) for each in pairs])
        if any(name in FINAL_QUANTITIES for name in keep):
            found |= self._final()
        status = [STATUS[int(code)] for code in self.summary[:, layout.STATUS]]
        reasons = {i: self._failure(i, each) for i, each in enumerate(status) if each in FAILURES}
        complete = self.summary[:, layout.WALL_COMPLETE] > 0.0
        if any(name in BODY_QUANTITIES for name in keep):
            complete = self._body_is_complete(found["body_peak_force"])
        # The kernel integrates only chains without losses.
        sensitive = follows_first_contact(
            self.readings[:, 0, layout.PEAK_TIME], self.summary[:, layout.WALL_FIRST_END]
        )
        columns = {name: found[name] for name in keep}
        return Outcome(columns, status, complete, sensitive, overlaps, reasons)

    def _failure(self, index: int, status: Any) -> str:
        layout, chain = self.layout, self.chains[index]
        peaked = self.records[index, layout.RECORD_PEAK_TIME, 1:] != 0.0
        passed = self.records[index, layout.RECORD_CROSSING, :-1] > 0.0
        time, steps = self.summary[index, [layout.END_TIME, layout.TAKEN]]
        count = 1 + int(np.count_nonzero(peaked & passed))
        return end_message(chain, status, float(time), int(steps), count)

    def _pulse(self) -> dict[str, Array]:
        layout, records = self.layout, self.records
        peak, times = records[:, layout.RECORD_PEAK], records[:, layout.RECORD_PEAK_TIME]
        crossings = records[:, layout.RECORD_CROSSING, :-1]
        overlap = np.where(crossings > 0.0, records[:, layout.RECORD_OVERLAP, :-1], np.nan)
        found = {
            "velocity": np.where(peak != 0.0, peak, np.nan),
            "peak_time": np.where(peak != 0.0, np.maximum(times, 0.0), np.nan),
            "arrival": np.pad(np.where(crossings > 0.0, crossings, np.nan), ((0, 0), (1, 0))),
            "residence": self._residence(crossings),
            "peak_overlap": overlap,
        }
        found["momentum"] = found["velocity"] / self._inverse_masses
        found["energy"] = 0.5 * found["momentum"] * found["velocity"]
        found["peak_force"] = self._force(overlap, slice(1, -1))
        return found

    @property
    def _inverse_masses(self) -> Array:
        masses: Array = self.given[:, self.layout.GIVEN_INVERSE_MASS, :-1]
        return masses

    def _force(self, overlaps: Array, contacts: Any) -> Array:
        stiffness = self.given[:, self.layout.GIVEN_STIFFNESS, contacts]
        exponents = self.given[:, self.layout.GIVEN_EXPONENT, contacts]
        return np.asarray(stiffness * overlaps**exponents)

    def _residence(self, times: Array) -> Array:
        """Residence times as in `hertzchain.simulation.run_pulse`, for struck chains."""
        since = self.records[:, self.layout.RECORD_RESIDENCE, :-1]
        residence = times_between(times, since)
        moving = np.pad(self.given[:, self.layout.START_V, :-1] > 0.0, ((0, 0), (0, 1)))
        first = np.argmin(moving, axis=1)
        undefined = np.arange(residence.shape[1]) < first[:, np.newaxis]
        residence[undefined & (first > 1)[:, np.newaxis]] = np.nan
        return residence

    def _wall(self) -> dict[str, Array]:
        layout, wall = self.layout, self.readings[:, 0]
        done = self.summary[:, layout.WALL_COMPLETE] > 0.0
        peak = np.where(done, wall[:, layout.PEAK], np.nan)
        over = done & (self.summary[:, layout.WALL_SINCE] > 0.0)
        impact = np.where(over, self.summary[:, layout.WALL_IMPACT_IMPULSE], np.nan)
        ended = self.summary[:, layout.WALL_FIRST_END] > 0.0
        first = self.summary[:, layout.WALL_FIRST_IMPULSE]
        static = np.array([_static_force_on_wall(chain) for chain in self.chains])
        excess = impact - static * self.summary[:, layout.WALL_SINCE]
        with np.errstate(divide="ignore", invalid="ignore"):
            duration = excess / (peak - static)
        return {
            "wall_peak_force": peak,
            "wall_peak_time": np.where(done, wall[:, layout.PEAK_TIME], np.nan),
            "wall_largest_so_far": wall[:, layout.PEAK],
            "wall_impulse_of_impact": impact,
            "wall_first_contact_impulse": np.where(ended, first, np.nan),
            "wall_impulse": wall[:, layout.IMPULSE],
            "wall_duration": duration,
        }

    def _body(self) -> dict[str, Array]:
        layout, contact = self.layout, self.readings[:, -1]
        peaked = contact[:, layout.MAXIMA] > 0.0
        force = np.where(peaked, contact[:, layout.PEAK] - contact[:, layout.REST], np.nan)
        return {
            "body_peak_force": force,
            "body_peak_time": np.where(peaked, contact[:, layout.PEAK_TIME], np.nan),
            "body_acceleration": force * self._inverse_masses[:, -1],
        }

    def _body_is_complete(self, peaks: Array) -> Array:
        """Whether no later force on the last body can exceed the largest one."""
        rows = zip(self.chains, *self._final_contacts(), self._final_velocities, strict=True)
        later = np.array([body_bound(chain).later(*row) for chain, *row in rows])
        return np.asarray(later <= (1.0 + ROUNDING) * np.nan_to_num(peaks))

    @property
    def _final_velocities(self) -> Array:
        found: Array = self.records[:, self.layout.FINAL_V]
        return found

    def _final_contacts(self) -> tuple[Array, Array]:
        """Overlaps, negative in open contacts, and stored energies at the end of the runs."""
        moved, at_rest = (
            self.records[:, self.layout.FINAL_X], self.given[:, self.layout.GIVEN_AT_REST]
        )  # fmt: skip
        overlaps = at_rest - np.diff(np.pad(moved, ((0, 0), (1, 1))))
        pressed = np.maximum(overlaps, 0.0)
        exponents = self.given[:, self.layout.GIVEN_EXPONENT]
        return overlaps, self._force(pressed, slice(None)) * pressed / (exponents + 1.0)

    def _sensors(self, beads: Sequence[int]) -> dict[str, Array]:
        layout, sensors = self.layout, self.readings[:, 1 : 1 + len(beads)]
        # The kernel adds only the forces of contacts.
        outside = np.zeros((len(self.chains), len(beads)))
        for i, chain in enumerate(self.chains):
            if chain.held_by == "force":
                outside[i] = [0.5 * static_forces_around(chain, bead) for bead in beads]
        heights = sensors[..., layout.MAXIMUM_0 :: 2] - sensors[..., [layout.REST]]
        largest = sensors[..., layout.PEAK] - sensors[..., layout.REST]
        kept = np.arange(layout.KEPT_MAXIMA) < sensors[..., [layout.MAXIMA]]
        high = kept & (heights > MIN_HEIGHT * largest[..., np.newaxis])
        at = layout.MAXIMUM_0 + 2 * np.argmax(high, axis=-1)[..., np.newaxis]
        there = high.any(axis=-1)
        first, time = (np.take_along_axis(sensors, at + i, axis=-1)[..., 0] for i in (0, 1))
        end = self.summary[:, [layout.END_TIME]]
        return {
            "sensor_first_maximum": np.where(there, first + outside, np.nan),
            "sensor_first_maximum_time": np.where(there, time, np.nan),
            "sensor_largest_so_far": sensors[..., layout.PEAK] + outside,
            "sensor_largest_so_far_time": sensors[..., layout.PEAK_TIME],
            "sensor_impulse": sensors[..., layout.IMPULSE] + outside * end,
        }

    def _final(self) -> dict[str, Array]:
        layout = self.layout
        moved, velocities = self.records[:, layout.FINAL_X], self._final_velocities
        stored = self._final_contacts()[1]
        kinetic = 0.5 * velocities**2 / self._inverse_masses
        static = self.given[:, layout.GIVEN_NOISE].any()
        rest = [chain.static_state.positions for chain in self.chains] if static else 0.0
        return {
            "final_position": moved + rest,
            "final_velocity": velocities,
            "end_time": self.summary[:, layout.END_TIME],
        } | energy_parts(
            kinetic, velocities > 0.0, stored[:, 1:-1].sum(axis=1), stored[:, 0] + stored[:, -1],
            np.zeros(len(moved)),
        )  # fmt: skip

    def _overlaps(self, request: Request) -> Array:
        """Largest overlaps by contact: of the whole run, or of the leading pulse and the wall."""
        layout = self.layout
        overlaps = np.zeros((len(self.chains), self.given.shape[2]))
        overlaps[:, -1:] = self._overlaps_at(self.readings[:, :1, layout.PEAK], slice(-1, None))
        if request.whole_run(self.chains[0]):
            peaks = self.readings[:, 1 + len(request.sensors) : -1, layout.PEAK]
            overlaps[:, :-1] = self._overlaps_at(peaks, slice(0, -1))
        else:
            overlaps[:, 1:-1] = self.records[:, layout.RECORD_OVERLAP, :-1]
        return overlaps

    def _overlaps_at(self, forces: Array, contacts: slice) -> Array:
        """Overlaps that cause forces; 0 where there is no contact."""
        stiffness = self.given[:, self.layout.GIVEN_STIFFNESS, contacts]
        exponents = self.given[:, self.layout.GIVEN_EXPONENT, contacts]
        with np.errstate(divide="ignore", invalid="ignore"):
            found = (forces / stiffness) ** (1.0 / exponents)
        return np.where(stiffness > 0.0, found, 0.0)


def largest_yield_ratio(chain: Chain, overlaps: Array) -> float:
    """Largest ratio of the pressure of a contact to that at first yield; NaN if it is unknown."""
    return hertz_range(chain, overlaps).largest_yield_ratio


def by_simulate(chain: Chain, request: Request, progress: Progress) -> Outcome:
    """Integrate one chain by `simulate`."""
    keep = request.keep
    rtol = min(max(TIGHTER * request.rtol, MIN_RTOL), MAX_RTOL)
    times = MANY_TIMES if any(name in SENSOR_QUANTITIES for name in keep) else 0
    options: dict[str, Any] = {"rtol": rtol, "progress": progress}
    if request.until is None and chain.right_wall is not None and request.peak_only(chain):
        run = simulate_to_peak(chain, max_steps=request.max_steps, **options)
    else:
        run = simulate(
            chain, until=request.until, times=times, max_steps=request.max_steps, **options
        )  # fmt: skip
    found: dict[str, Any] = {}
    if any(name in PULSE_QUANTITIES for name in keep):
        pulse = pulse_of(chain, run._peaks, run._crossings, tails=False)
        found |= {name: pulse.column(name) for name in PULSE_QUANTITIES}
    if any(name in WALL_QUANTITIES for name in keep):
        wall = run._wall_force("right")
        values = {name: getattr(wall, each.attribute) for name, each in WALL_QUANTITIES.items()}
        found |= {name: np.nan if each is None else each for name, each in values.items()}
    if any(name in SENSOR_QUANTITIES for name in keep):
        found |= sensors_of_run(run, request.sensors)
    if any(name in BODY_QUANTITIES for name in keep):
        found |= body_of_run(run)
    if any(name in FINAL_QUANTITIES for name in keep):
        found |= final_of_run(run, options)
    found["largest_overlap"], found["dent"] = run.largest_overlaps[1:-1], run.dents[1:-1]
    if "yield_ratio" in keep:
        found["yield_ratio"] = largest_yield_ratio(chain, run.largest_overlaps)
    columns = {name: np.asarray(found[name], float)[np.newaxis] for name in keep}
    complete = np.array([bool(run._complete[1])])
    sensitive = np.array([is_sensitive(chain, run._walls, RIGHT)])
    overlaps = run.largest_overlaps[np.newaxis]
    return Outcome(columns, [run.status], complete, sensitive, overlaps, {})


def empty_columns(keep: Sequence[str], count: int, beads: int, sensors: int) -> dict[str, Array]:
    """Columns of a table, filled with NaN."""
    return {name: np.full(shape_of(name, count, beads, sensors), np.nan) for name in keep}


def shape_of(name: str, count: int, beads: int, sensors: int) -> tuple[int, ...]:
    """Shape of a column for ``count`` chains."""
    per = TABLE_QUANTITIES[name].per
    if per == "sensor":
        return count, sensors
    if per in ("wall", "run"):
        return (count,)
    return count, beads - (per == "contact")
