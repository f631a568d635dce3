"""Check a state before the compiled loop uses its entries as indices."""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..validation.objects import check_type
from .drive_pieces import drive_pieces
from .kernel_input import initial_state
from .state import State, new_state, same_motion

# A time may be rounded when a state is converted to other units.
ROUNDING = 1e-12


def check_start(chain: Chain, start: State) -> None:
    """Check that a state belongs to the chain and is a state."""
    check_type("start", start, State, "run.state is one")
    if not same_motion(chain, start.chain):
        raise InputError(
            f"start is a state of another chain ({start.chain.description}); "
            "give simulate the chain of that run"
        )
    check_state(start)


def check_state(state: State) -> None:
    """Compare the arrays of a state with those of a new state of its chain."""
    start = initial_state(state.chain)
    beads = state.chain.beads
    expected = new_state(state.chain, start[:beads], start[beads:]).arrays
    found = state.arrays
    if found.keys() != expected.keys():
        names = ", ".join(sorted(found.keys() ^ expected.keys()))
        raise InputError(f"its arrays are not the arrays of a state: {names}")
    for name, fresh in expected.items():
        _check_layout(name, found[name], fresh)
        # A value that does not exist yet is stored as in a new state, for example as infinity.
        if fresh.dtype.kind == "f" and not _finite_or_absent(found[name], fresh).all():
            raise InputError(f"its array {name!r} has values that are not finite")
    _check_numbers(state)


def _finite_or_absent(values: Array, fresh: Array) -> Array:
    return np.asarray(
        np.isfinite(values) | (values == fresh) | (np.isnan(values) & np.isnan(fresh))
    )


def _check_layout(name: str, found: object, fresh: Array) -> None:
    layout = (getattr(found, "dtype", None), getattr(found, "shape", None))
    if not isinstance(found, np.ndarray) or layout != (fresh.dtype, fresh.shape):
        raise InputError(
            f"its array {name!r} has type and shape {layout[0]}, {layout[1]} instead of "
            f"{fresh.dtype}, {fresh.shape}"
        )


def _check_numbers(state: State) -> None:
    """Check numbers that are used as indices, and the consistency of times."""
    from ..kernels import contact_law, state_layout

    counts, clock, beads = state.arrays["counts"], state.arrays["clock"], state.chain.beads
    pieces, _ = drive_pieces(state.chain.drive)
    most = np.full(len(counts), np.iinfo(np.int64).max // 2)
    least = np.zeros(len(counts), np.int64)
    most[[state_layout.PEAKS, state_layout.CROSSINGS]] = beads - 1
    least[state_layout.LAST_CROSSING], most[state_layout.LAST_CROSSING] = -1, beads - 2
    most[state_layout.SEGMENT] = len(pieces) - 1
    most[state_layout.LOW] = max(counts[state_layout.HIGH], 0) - 1
    least[state_layout.HIGH], most[state_layout.HIGH] = 1, beads
    most[state_layout.LEFT_BY_PULSE] = beads - 1
    for place in np.flatnonzero((counts < least) | (counts > most)):
        raise InputError(
            f"entry {place + 1} of its array 'counts' is {counts[place]}, but must be from "
            f"{least[place]} to {most[place]}"
        )
    modes = (contact_law.RELEASED, contact_law.LOADED, contact_law.STUCK)
    if not np.isin(state.arrays["mode"], modes).all():
        raise InputError("its array 'mode' has invalid values")
    time, step = clock[state_layout.TIME], clock[state_layout.STEP]
    if time < 0.0 or step <= 0.0:
        raise InputError(f"its time {time:g} or its step {step:g} is negative, or the step is 0")
    segment = int(counts[state_layout.SEGMENT])
    begin, end = np.append(pieces, np.inf)[segment : segment + 2]
    if not begin * (1.0 - ROUNDING) <= time <= end * (1.0 + ROUNDING):
        raise InputError(f"its time {time:g} is not in piece {segment + 1} of the drive")
