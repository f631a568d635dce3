"""Compile kernels before they are needed: all of them, or those that are needed first."""

from __future__ import annotations

import contextlib
import gc
import json
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Final, NamedTuple

from .chain.chain import Chain
from .chain.laws.dashpot import Dashpot
from .chain.laws.velocity_power import VelocityPower
from .chain.laws.walton_braun import WaltonBraun
from .chain.walls import Wall
from .derivatives.gradient import gradient
from .errors import SimulationError
from .propagation.propagate import propagate, propagate_many
from .simulation.simulate import simulate
from .simulation.simulate_many import simulate_many
from .theory.local_rate import local_rate, local_rate_gradient
from .validation.keywords import checked_arguments
from .validation.numbers import worker_count
from .validation.objects import Progress, callback


class Stage(NamedTuple):
    """Something whose first use compiles kernels; ``general`` if those of general chains."""

    name: str
    run: Callable[[Chain], object]
    general: bool = False


def _walled(chain: Chain, loss: object) -> object:
    return simulate(chain.replace(right_wall=Wall(), loss=loss), rtol=1e-6)


def _heterogeneous(chain: Chain) -> object:
    return propagate(Chain.from_radii([*chain.radii, 2.0 * chain.radii[0], *chain.radii]))


def _other_exponents(chain: Chain) -> object:
    other = Chain.from_radii(chain.radii, exponent=2.0)
    return propagate(other), propagate_many([other] * 4)


def _ensembles(chain: Chain) -> object:
    walled = chain.replace(right_wall=Wall())
    other = Chain.from_radii(chain.radii, exponent=2.0).replace(right_wall=Wall(stiffness=1.0))
    return [simulate_many([each] * 4, keep=["wall_peak_force"]) for each in (walled, other)]


def _all_beads(chain: Chain) -> object:
    return simulate(chain, rtol=1e-6)


def _fixed_steps(chain: Chain) -> object:
    chains = chain, chain.replace(right_wall=Wall())
    return [simulate(each, method="symplectic", until=1.0) for each in chains]


def _gradients(chain: Chain) -> object:
    walled = chain.replace(right_wall=Wall())
    lossy = walled.replace(loss=Dashpot(0.1))
    return gradient(chain, "pulse.velocity@3"), [
        gradient(each, "wall_force.peak") for each in (walled, lossy)
    ]


# Functions that the page of the app needs, in this order: it begins with a chain and a wall.
INTERACTIVE: Final = (
    Stage("walls", lambda chain: _walled(chain, None), general=True),
    Stage("the simulation of the pulse", propagate),
    Stage("the local-rate law", local_rate),
    Stage("the simulation of all beads", _all_beads),
    Stage("losses", lambda chain: _walled(chain, Dashpot(0.1)), general=True),
    Stage("heterogeneous chains", _heterogeneous),
)
# Those that are usually needed first, including the reproduction of the paper.
FIRST: Final = (
    *INTERACTIVE,
    Stage("ensembles of pulses", lambda chain: propagate_many([chain] * 4)),
)
STAGES: Final = (
    *FIRST,
    Stage("contacts with a memory", lambda chain: _walled(chain, WaltonBraun(0.5)), general=True),
    Stage(
        "sticking contacts",
        lambda chain: _walled(chain, VelocityPower(0.2, alpha=0.2)),
        general=True,
    ),
    Stage("pulses of other exponents", _other_exponents),
    Stage("ensembles of whole chains", _ensembles),
    Stage("fixed steps", _fixed_steps),
    Stage("sensitivities", lambda chain: local_rate_gradient(chain, "velocity", bead=3)),
    # Last, so that the process that has compiled general chains takes it.
    Stage("gradients of simulations", _gradients),
)
BEADS: Final = 12
# Thresholds of the garbage collector.  The compiler creates millions of objects that live on, and
# searching them for cycles as often as usual takes 9% of the time, without saving much memory.
RARE_COLLECTIONS: Final = (20_000, 20, 100)


@checked_arguments("warm_up")
def warm_up(*, first: bool = False, progress: Progress | None = None) -> float:
    """Compile all kernels, in two processes side by side.

    Otherwise each function compiles what it needs at its first use. The results are in numba's
    cache: this is needed once per installation, and later takes seconds.

    Parameters
    ----------
    first : bool, optional
        Whether to compile only the kernels that are usually needed first, which takes about half
        of the time: those of pulses, of the local-rate law, and of `simulate` with walls and most
        losses.
    progress : callable, optional
        Called as ``progress(stages_done, stages)``.

    Returns
    -------
    float
        Time that it took [s].

    Raises
    ------
    SimulationError
        If a kernel cannot be compiled.

    Examples
    --------
    >>> import hertzchain as hc
    >>> seconds = hc.warm_up()  # doctest: +SKIP
    """
    callback("progress", progress)
    stages = FIRST if first else STAGES
    began, done, lock = time.perf_counter(), 0, threading.Lock()

    def count() -> None:
        nonlocal done
        with lock:
            done += 1
            if progress is not None:
                progress(done, len(stages))

    # These groups have few functions in common, which are compiled twice.
    groups = [
        [i for i, each in enumerate(stages) if each.general is general] for general in (True, False)
    ]
    if worker_count("workers", None) > 1:
        _compile_beside(groups, count)
    else:
        for group in groups:
            compile_stages(group, count)
    return time.perf_counter() - began


def compile_stages(numbers: Sequence[int], count: Callable[[], object]) -> None:
    """Compile some of the stages in this process."""
    chain = Chain.tapered("backward-exponential", 0.05, beads=BEADS)
    thresholds = gc.get_threshold()
    gc.set_threshold(*RARE_COLLECTIONS)
    try:
        for number in numbers:
            STAGES[number].run(chain)
            count()
    finally:
        gc.set_threshold(*thresholds)


# A process of `multiprocessing` would import the script of a caller, which may have no guard.
PROGRAM: Final = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from hertzchain.warm_start import compile_stages
for number in sys.stdin:
    compile_stages([int(number)], lambda: print(flush=True))
"""


def _start_process() -> subprocess.Popen[str]:
    command = [sys.executable, "-c", PROGRAM, json.dumps(sys.path)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True)


def _compile_beside(groups: Sequence[Sequence[int]], count: Callable[[], None]) -> None:
    """Compile each group of stages in a separate process, which helps another when it is done."""
    waiting = [deque(group) for group in groups]
    running: list[subprocess.Popen[str]] = []
    with ThreadPoolExecutor(len(groups)) as threads:
        try:
            running.extend(_start_process() for _ in groups)
            messages = list(threads.map(
                lambda i, process: _supervise(process, waiting[i:] + waiting[:i], count),
                range(len(running)), running,
            ))  # fmt: skip
        finally:
            _stop(waiting, running)
    failed = [message for message in messages if message]
    if failed:
        raise SimulationError(f"a kernel cannot be compiled: {failed[0]}")


def _supervise(
    process: subprocess.Popen[str], waiting: Sequence[deque[int]], count: Callable[[], None]
) -> str:
    """Let a process compile stages until none waits; returns its last message if it fails."""
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    with process:
        while (number := _next(waiting)) is not None:
            with contextlib.suppress(BrokenPipeError):
                print(number, file=process.stdin, flush=True)
            if not process.stdout.readline():
                _stop(waiting, ())
                break
            count()
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        messages = process.stderr.read().strip().splitlines()
    return "" if process.returncode == 0 else (messages or ["the process was killed"])[-1]


def _stop(waiting: Sequence[deque[int]], running: Sequence[subprocess.Popen[str]]) -> None:
    """Start no further stages, and kill processes."""
    for group in waiting:
        group.clear()
    for process in running:
        process.kill()


def _next(waiting: Sequence[deque[int]]) -> int | None:
    """The first stage of the process's own group, or else the last one of another group."""
    own, *others = waiting
    with contextlib.suppress(IndexError):
        return own.popleft()
    for other in others:
        with contextlib.suppress(IndexError):
            return other.pop()
    return None
