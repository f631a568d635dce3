"""Results of one chain as messages, in the order in which they become available."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import loading_forces
from ..chain.description import sizes_in_words
from ..chain.drawn_bodies import (
    body_centres,
    half_heights,
    half_widths,
    pad_contacts,
)
from ..chain.hertz_range import hertz_range
from ..collision import Array
from ..errors import InputError, SimulationError
from ..notebook.drawing import axis_unit, engineering
from ..propagation.propagate import propagate
from ..pulse.notes import OUT_OF_ORDER, out_of_order
from ..pulse.pulse import Pulse
from ..recorded_warnings import record_warnings
from ..simulation.run import Run
from ..simulation.run_message import NOT_STRUCK
from ..simulation.time_scales import is_static
from ..theory.catalogue import THEORIES
from ..theory.effective_chain import effective_chain
from ..theory.spectrum import spectrum
from .documents import chain_of, checked_as_toml
from .force_curves import (
    coarse_frames,
    drive_in_words,
    force_at,
    peaks_at,
    places_of,
    run_for_forces,
)
from .messages import Part, columns_as_int16
from .record_curves import record_curves
from .records import kept
from .requests import Request
from .shown_run import motion
from .shown_times import pulse_of
from .wording import chain_in_words, on_the_page, sentences, warnings_on_the_page
from .yield_notes import assumption_note, yield_notes

MAX_SECONDS: Final = 20.0
# Theories with compiled functions, which are evaluated after the others.
COMPILED: Final = ("local-rate",)
# The budget of a longer chain takes as long as a draft of its motion.
MAX_BEADS_OF_DRAFT_BUDGET: Final = 300
AT_REST: Final = (
    f"nothing moves, because {NOT_STRUCK}; the spectrum shows the frequencies at which the chain "
    "can oscillate"
)
# Bands beyond which they are neither listed nor drawn, and phases at which they are drawn.
MAX_BANDS: Final = 6
PHASES: Final = 41
OVER_STATIC: Final = (
    "Excess over the static state: without the energy that is stored at rest, and without the "
    "work of the static forces"
)

Stop = Callable[[], bool]


class Cancelled(Exception):
    """A newer request has arrived."""


def results(request: Request, stop: Stop) -> Iterator[Part]:
    """Messages with the results of a chain: ``beads``, ``pulse`` and ``run``; or ``error``.

    ``stop`` is called during simulations; if it returns true, the last message is ``cancelled``.
    """
    identity = request.identity
    try:
        yield from _results(request, stop)
    except Cancelled:
        yield Part({"part": "cancelled", **identity})
    except (InputError, SimulationError) as error:
        yield Part({"part": "error", **identity, "message": on_the_page(error)})


def _results(request: Request, stop: Stop) -> Iterator[Part]:
    began, identity = time.perf_counter(), request.identity
    with record_warnings() as warned:
        chain = chain_of(request.document)
        table = _Theories(chain)
        table.add([name for name in THEORIES if name not in COMPILED])
        table.add_effective_chain()
    before = warnings_on_the_page(warned)
    yield Part(
        {"part": "beads", **identity, **_description(chain), "theories": table.header,
         "chain_file": checked_as_toml(request.document),
         "warnings": before, "seconds": time.perf_counter() - began},
        _bead_arrays(chain) | table.arrays,
    )  # fmt: skip
    began = time.perf_counter()
    with record_warnings():
        exact, refusal = _propagated(chain)
        compiled = _Theories(chain)
        compiled.add(COMPILED)
    if exact is not None:
        yield _pulse_part(request, exact, compiled, began)
    if exact is not None and not request.run:
        return
    began = time.perf_counter()
    if stop():
        raise Cancelled
    progress = limited(stop)
    with record_warnings():
        run, whole, warned = motion(chain, exact, request, progress)
        if exact is None:
            pulse = pulse_of(run)
            note = refusal if pulse is None else ""
            yield _pulse_part(request, pulse, compiled, began, note)
        if request.run:
            found = [AT_REST] if is_static(chain) else []
            found += _not_repeated(before, warnings_on_the_page(warned))
            if not request.draft:
                found += [*yield_notes(whole), *map(on_the_page, whole.notes)]
                found += [*map(on_the_page, _unfinished_impact(run, whole))]
            forces = run
            if not request.draft:
                places = [*places_of(chain, request.sensors).values()]
                forces, note = run_for_forces(run, places, request.rtol, progress)
                found += [note] if note else []
            took = time.perf_counter() - began
            yield _run_part(run, whole, forces, request, found, took, progress)


def _not_repeated(before: list[str], found: list[str]) -> list[str]:
    """Warnings of a run, after those of its chain about other limits: "pressure / yield is ..."."""
    limits = {each.partition(" is ")[0] for each in found}
    rest = [each for each in before if each.partition(" is ")[0] not in limits]
    return list(dict.fromkeys((*rest, *found)))


def _description(chain: Chain) -> dict[str, Any]:
    walls = ("left wall", "right wall")
    return {
        "description": chain_in_words(chain), "beads": chain.beads, "units": chain.units,
        "features": list(chain.features), "strikers": chain.strikers,
        "walls": [name.removesuffix(" wall") for name in walls if name in chain.features],
        "pads": pad_contacts(chain),
        "kinds": [[name, _sizes(chain, beads)] for name, beads in _kinds(chain).items()],
    }  # fmt: skip


def _sizes(chain: Chain, beads: list[int]) -> str:
    """Diameters of some beads in words; flat strikers have none."""
    faces = chain.face_radii[beads]
    known = faces[np.isfinite(faces)]
    return sizes_in_words(known) if len(known) else "flat"


def _kinds(chain: Chain) -> dict[str, list[int]]:
    """Beads of each material, counted from 0; none if there is only one."""
    found: dict[str, list[int]] = {}
    for bead, material in enumerate(chain.materials or ()):
        found.setdefault(material.name, []).append(bead)
    return found if len(found) > 1 else {}


def _bead_arrays(chain: Chain) -> dict[str, Array]:
    kinds = np.zeros(chain.beads, np.int16)
    for number, beads in enumerate(_kinds(chain).values()):
        kinds[beads] = number
    return {"radii": chain.face_radii, "masses": chain.masses, "centres": body_centres(chain),
            "widths": half_widths(chain), "heights": half_heights(chain),
            "kinds": kinds}  # fmt: skip


class _Theories:
    """Predictions of theories, and reasons why others do not support the chain."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.header: dict[str, dict[str, str]] = {}
        self.arrays: dict[str, Array] = {}

    def add(self, names: Any) -> None:
        """Evaluate theories of the catalogue."""
        for name in names:
            with record_warnings() as warned:
                try:
                    pulse = THEORIES[name](self.chain)
                except InputError as error:
                    self.header[name] = {"refusal": on_the_page(error)}
                    continue
            self.header[name] = {"note": sentences(warnings_on_the_page(warned))}
            self.arrays |= pulse_arrays(name, pulse)

    def add_effective_chain(self) -> None:
        """Evaluate the large beads of a decorated chain; nothing for other chains."""
        with record_warnings() as warned:
            try:
                effective = effective_chain(self.chain).bca()
            except InputError:
                return
        self.header["effective-chain"] = {"note": sentences(warnings_on_the_page(warned))}
        for name in ("velocity", "arrival"):
            values = np.full(self.chain.beads, np.nan)
            values[effective.bead - 1] = getattr(effective, name)
            self.arrays[f"effective-chain.{name}"] = values


def pulse_arrays(name: str, pulse: Pulse) -> dict[str, Array]:
    """All quantities of a pulse, with the name of the method before them."""
    return {f"{name}.{quantity}": values for quantity, values in pulse.columns().items()}


def _propagated(chain: Chain) -> tuple[Pulse | None, str]:
    """The pulse by `propagate`, or the reason why it does not support the chain."""
    try:
        return propagate(chain), ""
    except (InputError, SimulationError) as error:
        return None, str(error)


def _pulse_part(
    request: Request, exact: Pulse | None, compiled: _Theories, began: float, note: str = ""
) -> Part:
    arrays, unordered = dict(compiled.arrays), ""
    if exact is not None:
        arrays |= pulse_arrays("exact", exact)
        note = sentences([note, *_with_quantities(exact.notes)])
        unordered = OUT_OF_ORDER if out_of_order(exact.residence) else ""
    header = {
        "part": "pulse", **request.identity, "theories": compiled.header,
        "method": exact.method if exact is not None else None, "note": note,
        "table_note": unordered, "seconds": time.perf_counter() - began,
    }  # fmt: skip
    return Part(header, arrays)


def _with_quantities(notes: Mapping[str, str]) -> list[str]:
    """Different notes, each after the quantities whose values it explains."""
    found: dict[str, list[str]] = {}
    for quantity, note in notes.items():
        found.setdefault(note, []).append(quantity.replace("_", " "))
    return [f"{', '.join(names)}: {note}" for note, names in found.items()]


def limited(stop: Stop) -> Callable[..., None]:
    """A callback for ``progress`` that ends a run if it is out of date or takes too long."""
    began: float | None = None

    def progress(*_: int) -> None:
        nonlocal began
        if stop():
            raise Cancelled
        # The first call comes after the compilation, which does not count.
        began = time.perf_counter() if began is None else began
        if time.perf_counter() - began > MAX_SECONDS:
            raise SimulationError(
                f"this run takes longer than {MAX_SECONDS:g} s, the limit of the app; use "
                "hertzchain simulate, or a shorter chain"
            )

    return progress


def _run_part(
    run: Run, whole: Run, forces: Run, request: Request, warnings: list[str], took: float,
    progress: Callable[..., None],
) -> Part:  # fmt: skip
    began, chain = time.perf_counter(), run.chain
    arrays: dict[str, Any] = {"times": run.times, "forces.times": forces.times}
    # The motion of a chain at rest is one of rounding errors.
    moves = not is_static(chain)
    arrays |= columns_as_int16("velocities", run.velocities * moves)
    arrays |= columns_as_int16("forces", run.forces)
    peaks = {}
    colours = {ball + chain.strikers: f"sensor{i}" for i, ball in enumerate(request.sensors)}
    for name, place in places_of(chain, request.sensors).items():
        arrays[f"force.{name}"] = force_at(forces, place)
        found = peaks_at(forces, whole, place, None if request.draft else progress)
        peaks[name] = {"name": colours.get(place), **found}
    if chain.drive is not None and chain.drive.of == "force":
        arrays["force.drive"] = chain.drive.value(forces.times)
        peaks["drive"] = drive_in_words(chain.drive, run.end_time)
    if run.success and not run._still_closed:
        arrays["final"] = run.velocities[-1]
    if not request.draft or chain.beads <= MAX_BEADS_OF_DRAFT_BUDGET:
        arrays |= _budget_arrays(run, moves)
    arrays |= _of_contacts(whole, forces)
    modes = {} if request.draft else _spectrum(chain, arrays)
    measured = _measured(run, request, arrays, progress)
    header = {
        "part": "run", **request.identity, "message": _end(run), "success": run.success,
        "peaks": peaks, "energy_drift": run.energy_drift,
        "warnings": warnings + assumption_note(chain, peaks),
        "closed": run._still_closed, "over_static": OVER_STATIC if has_static_forces(chain) else "",
        "coarse": "" if request.draft else coarse_frames(run), "record": measured,
        "seconds": {"simulate": took, "pack": time.perf_counter() - began}, **modes,
    }  # fmt: skip
    return Part(header, arrays)


def _measured(
    run: Run, request: Request, arrays: dict[str, Any], progress: Callable[..., None]
) -> dict[str, Any] | None:
    """Add the curves of a measured record, and describe them; drafts have none."""
    if request.draft or not request.record:
        return None
    try:
        record = kept(request.record)
        if run.chain.scaled:
            raise InputError(
                "measured data are in SI units, but this chain is in scaled variables; choose a "
                "material"
            )
    except InputError as error:
        return {"curves": [], "notes": [str(error)], "aligned": False}
    header, found = record_curves(run.chain, record, run.end_time, progress)
    arrays |= found
    return {**header, "notes": [on_the_page(each) for each in header["notes"]]}


def _end(run: Run) -> str:
    """How the run ended; its end time is the choice of the page, not a request of the user."""
    text = run.message
    if run.status == "time reached":
        text = f"the run ends at t = {engineering(run.end_time, 's', run.chain.units)}"
    # A drive keeps contacts closed.
    closed = run._still_closed if run.chain.drive is None else ""
    return f"{text}, with {closed}" if closed else text


def _unfinished_impact(run: Run, whole: Run) -> list[str]:
    """Sentence about an impact on the right wall that has not ended at the end of the run."""
    if run.chain.right_wall is None or not run.success:
        return []
    end = engineering(run.end_time, "s", run.chain.units)
    if run._wall_force("right").largest_so_far == 0.0:
        return [f"the run ends at t = {end}, before a bead reaches the right wall"]
    wall = whole._wall_force("right")
    if wall.complete_since is None:
        what = "" if wall.complete else "the peak on the right wall is not complete: "
        return [f"the run ends at t = {end}; {what}{wall.reason}"]
    if run.end_time < wall.complete_since:
        return [f"the run ends at t = {end}, before the impact on the right wall has ended"]
    return []


def has_static_forces(chain: Chain) -> bool:
    """Whether precompression or gravity stores energy in the contacts."""
    return bool(np.any(chain.static_state.overlaps > 0.0))


def _budget_arrays(run: Run, moves: bool) -> dict[str, Any]:
    """Excess energy and momentum by location, without locations where there is none."""
    budget = run.budget().over_static()
    parts = (("energy", budget.energy), ("momentum", budget.momentum))
    return {
        f"{of}.{name}": values.astype(np.float32)
        for of, items in parts
        for name, values in items.items()
        if moves and values.any()
    }


def _of_contacts(run: Run, forces: Run) -> dict[str, Any]:
    """Largest forces of contacts 1 to N in the whole run, pressures over yield, and dents.

    Contact N is the one with the right wall.  Pressures are omitted if no yield strength is known,
    and dents if there are none.
    """
    chain, overlaps = run.chain, run.largest_overlaps
    # Where the overlap is largest, its rate is 0; losses may cause a larger force before.
    largest = loading_forces(chain.contact_groups, overlaps)
    for each in (run, forces):
        largest = np.maximum(largest, each.forces.max(axis=0, initial=0.0))
    if chain.right_wall is not None:
        largest[-1] = run._wall_force("right").largest_so_far
    largest[chain.contact_stiffness == 0.0] = np.nan
    found = {"largest_force": largest}
    if chain.units == "SI" and chain.materials is not None:
        limits = hertz_range(chain, overlaps)
        found["yield_ratio"] = np.fmax(limits.yield_ratio, limits.law_yield_ratio)
    found["dent"] = run.dents
    return {
        name: values[1:].astype(np.float32)
        for name, values in found.items()
        if np.nan_to_num(values[1:]).any()
    }


def _spectrum(chain: Chain, arrays: dict[str, Any]) -> dict[str, Any]:
    """Add frequencies of small oscillations and plane waves; return texts about them."""
    try:
        modes = spectrum(chain)
    except InputError as error:
        return {"spectrum": on_the_page(error).rstrip(".")}
    arrays["modes.frequency"] = modes.frequencies
    try:
        edges = modes.band_edges()
    except InputError:
        # Only chains that repeat have bands.
        return {}
    arrays["modes.gaps"] = modes.gaps()
    text = f"Sound speed {engineering(modes.sound_speed, 'm/s', chain.units)}"
    if len(edges) <= MAX_BANDS:
        arrays["modes.waves"] = modes.bands(np.linspace(0.0, np.pi, PHASES)).T
        factor, unit = axis_unit(edges, "Hz", chain.units)
        listed = ", ".join(f"{factor * low:.4g} to {factor * high:.4g}" for low, high in edges)
        text += f"; bands of an infinite chain with the same cell: {listed} {unit[2:-1]}".rstrip()
    return {"bands": text, "phases": PHASES}
