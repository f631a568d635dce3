"""Estimate the gain from a separate step size for each island of touching beads.

A run is divided into pieces.  Beads joined by contacts that are closed at some time within a piece
form an island.  Each island is integrated again separately, from the same state over the same time.
The sum of steps times beads over the islands is the least work of such a method, without the cost
of finding the islands and of beads in free flight.  It is compared with the steps of the whole
chain times the beads of its window (`hertzchain.kernels.active_beads`), as are computing times.

``make benchmark`` prints the table and writes ``benchmark/islands.json``.
"""

from __future__ import annotations

import json
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

import hertzchain as hc
from hertzchain.kernels import active_beads, full_chain, limits, state_layout
from hertzchain.simulation.kernel_input import kernel_chain
from hertzchain.simulation.simulate import DEFAULT_RTOL
from hertzchain.simulation.state import State, contacts_of

# Number of pieces of a run, and number of times per piece at which contacts are checked.
PIECES, MOMENTS = 60, 50
NO_TIMES, NO_STATES = np.empty(0), np.empty((0, 0))


def cases() -> dict[str, tuple[hc.Chain, float]]:
    """Chains, and length of their runs in transits of the pulse."""
    wall = hc.Wall.rigid()
    decorated = hc.Chain.from_radii(np.tile([1.0, 0.3], 50))
    backward = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
    forward = hc.Chain.tapered("forward-exponential", 0.02, beads=100)
    return {
        "decorated, radii 1 and 0.3, 1 transit": (decorated, 1.0),
        "decorated, with a wall, 2 transits": (decorated.replace(right_wall=wall), 2.0),
        "backward, q = 0.05, with a wall, 2 transits": (backward.replace(right_wall=wall), 2.0),
        "forward, q = 0.02, with a wall, 2 transits": (forward.replace(right_wall=wall), 2.0),
        "equal beads, with a wall, 2 transits": (
            hc.Chain.uniform(100).replace(right_wall=wall), 2.0,
        ),
    }  # fmt: skip


def islands(closed: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First bead and bead after the last, for each group joined by closed contacts 0..N."""
    beads = len(closed) - 1
    ends = [0, *(np.flatnonzero(~closed[1:beads]) + 1), beads]
    groups = [(int(a), int(b)) for a, b in pairwise(ends)]
    return [(a, b) for a, b in groups if closed[a : b + 1].any()]


def closed_contacts(chain: hc.Chain, run: hc.Run) -> NDArray[np.bool_]:
    """Mask of contacts, walls included, that are closed at some saved time, shape (N + 1,)."""
    gap = np.zeros(chain.beads + 1)
    gap[[0, -1]] = [np.inf, 0.0 if chain.right_wall is not None else np.inf]
    overlaps = -np.diff(np.pad(run.positions, ((0, 0), (1, 1))), axis=1) - gap
    return (overlaps > 0.0).any(axis=0)


def steps_alone(
    state: State, first: int, end: int, duration: float, fastest: float
) -> tuple[int, float]:
    """Number of steps of beads ``first`` to ``end`` - 1 as an island, and computing time [s]."""
    chain, arrays = state.chain, state.arrays
    equation, beads = kernel_chain(chain), end - first
    plain = len(arrays["y"]) == 2 * chain.beads
    joints = slice(first, end + 1)
    remembered = {name: arrays[name][joints].copy() for name in ("mode", "largest")}
    contacts = contacts_of(remembered, equation)
    ends = np.empty((2, chain.beads + 1))
    if plain:
        part = active_beads.default_part.py_func(equation, first, end)
    else:
        part = active_beads.general_part.py_func(equation, first, end, ends)
    y = np.empty(len(arrays["y"]) - 2 * (chain.beads - beads))
    y[:beads] = arrays["y"][first:end]
    y[beads : 2 * beads] = arrays["y"][chain.beads :][first:end]
    y[2 * beads :] = arrays["y"][2 * chain.beads :]
    # In the whole chain, errors of slow beads are relative to the fastest bead in contact.
    slow = limits.SLOW * fastest / max(float(np.abs(y[beads : 2 * beads]).max()), 1e-300)
    rtol = min(DEFAULT_RTOL * max(1.0, slow), 1e-6)
    clock, counts = np.zeros(state_layout.CLOCK_SIZE), np.zeros(state_layout.COUNTS_SIZE, np.int64)
    clock[state_layout.STEP] = arrays["clock"][state_layout.STEP]
    clock[state_layout.IDLE_UNTIL], counts[state_layout.HIGH] = np.inf, beads
    flights = np.zeros((state_layout.FLIGHT_ROWS, beads))
    rest = (
        False, NO_TIMES, False, NO_STATES, NO_STATES, np.ones((2, beads)),
        np.ones((state_layout.CROSSING_ROWS, beads - 1)),
        np.zeros((state_layout.WALL_ROWS, 2)), np.zeros(beads), np.zeros(full_chain.ROWS * len(y)),
        np.empty((2, beads + 1)), np.zeros((3, beads), np.bool_),
    )  # fmt: skip
    seconds = []
    # The first call takes no step; a loop over all islands would avoid the time of the call.
    for budget in (0, 10**6):
        began = time.process_time()
        full_chain.advance(
            y, clock, counts, part, contacts, flights, duration, False, rtol, budget, 10**9, *rest
        )
        seconds.append(time.process_time() - began)
    return int(counts[state_layout.STEPS]), max(seconds[1] - seconds[0], 0.0)


def count(chain: hc.Chain, transits: float) -> dict[str, float]:
    """Bead steps of the whole chain and of its islands, summed over the pieces of a run."""
    transit = hc.simulate(chain, times=0).end_time if chain.right_wall is None else (
        hc.simulate(chain.replace(right_wall=None), times=0).end_time
    )  # fmt: skip
    state = hc.simulate(chain, until=1e-3 * transit, times=0).state
    now, alone, numbers, seconds_alone = [], [], [], 0.0
    for end in np.linspace(0.0, transits * transit, PIECES + 1)[1:]:
        run = hc.simulate(chain, start=state, times=np.linspace(state.time, end, MOMENTS))
        low, high = beads_in_window(state)
        taken = int(
            run.state.arrays["counts"][state_layout.STEPS]
            - state.arrays["counts"][state_layout.STEPS]
        )
        groups = islands(closed_contacts(chain, run))
        duration = run.state.time - state.time
        speeds = np.abs(state.velocities)
        fastest = max((float(speeds[a:b].max()) for a, b in groups), default=0.0)
        now.append(taken * (high - low))
        for a, b in groups:
            steps, seconds = steps_alone(state, a, b, duration, fastest)
            alone.append((b - a) * steps)
            seconds_alone += seconds
        numbers.append(len(groups))
        state = run.state
    seconds_now = np.inf
    for _ in range(3):
        began = time.process_time()
        hc.simulate(chain, until=transits * transit, times=0)
        seconds_now = min(seconds_now, time.process_time() - began)
    return {
        "bead_steps": sum(now), "bead_steps_alone": sum(alone),
        "ratio": sum(now) / sum(alone), "ratio_of_times": seconds_now / seconds_alone,
        "most_islands": max(numbers),
    }  # fmt: skip


def beads_in_window(state: State) -> tuple[int, int]:
    """First bead of the window, and bead after the last."""
    counts = state.arrays["counts"]
    return int(counts[state_layout.LOW]), int(counts[state_layout.HIGH])


def main() -> None:
    """Count, print and save."""
    console = Console(width=110)
    table = Table(title="bead steps of the window and of its islands")
    for heading in ("", "window", "islands", "ratio", "ratio of times", "largest number"):
        table.add_column(heading, justify="right" if heading else "left")
    found = {name: count(chain, transits) for name, (chain, transits) in cases().items()}
    for name, values in found.items():
        table.add_row(name, *(f"{value:.3g}" for value in values.values()))
    console.print(table)
    target = Path("benchmark") / "islands.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(found, indent=2) + "\n")
    console.print(f"written to {target}")


if __name__ == "__main__":
    main()
