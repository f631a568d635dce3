"""Write a line to standard error while functions are compiled.

The line is written once per wait, after half a second of compiling, and again if a function takes
longer than the line states.  Standard error must be a terminal or the output of a notebook; the
command line always writes it.  The kernels print nothing else.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Final

from numba.core import event

# Seconds of compiling before the line is written.
DELAY: Final = 0.5
# A compilation that begins this many seconds after the previous one is a new wait.
PAUSE: Final = 1.0
# Measured CPU seconds of compiling: usual, and for certain modules and types of arguments.
USUAL: Final = 6
SECONDS: Final = {"full_chain": 10, "GeneralChain": 20}

# Function called with the line instead of `write_line`; set by the command line.
_writers: list[Callable[[str], None]] = []
_installed: list[CompileNotice] = []


class CompileNotice(event.Listener):
    """Listener to numba's compile events, which never overlap because the compiler has a lock."""

    def __init__(
        self,
        write: Callable[[str], None] | None = None,
        *,
        delay: float = DELAY,
        pause: float = PAUSE,
    ) -> None:
        self._write, self._delay, self._pause = write or write_current, delay, pause
        self._lock = threading.Lock()
        self._depth = 0
        # Seconds in the line that was written; 0 if there is none in this wait.
        self._announced = 0
        self.total = 0.0
        self._spent, self._began, self._ended = 0.0, 0.0, -float("inf")
        self._timer: threading.Timer | None = None

    def on_start(self, event: Any) -> None:
        """Start the clock with the outermost function."""
        module = _module_of(event)
        if module is None:
            return
        with self._lock:
            self._depth += 1
            if self._depth > 1:
                return
            self._began = time.monotonic()
            if self._began - self._ended > self._pause:
                self._spent, self._announced = 0.0, 0
            expected = _seconds(event, module)
            # Another line if a function takes longer than announced.
            if expected > self._announced:
                wait = self._delay if self._announced else max(0.0, self._delay - self._spent)
                self._timer = threading.Timer(wait, self._show, (expected,))
                self._timer.daemon = True
                self._timer.start()

    def on_end(self, event: Any) -> None:
        """Stop the clock."""
        if _module_of(event) is None:
            return
        with self._lock:
            self._depth -= 1
            if self._depth > 0:
                return
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None
            self._ended = time.monotonic()
            self._spent += self._ended - self._began
            self.total += self._ended - self._began

    def _show(self, expected: int) -> None:
        with self._lock:
            if self._depth == 0 or expected <= self._announced:
                return
            self._announced = expected
        self._write(f"hertzchain: compiling once, about {expected} s")


def _module_of(event: Any) -> str | None:
    """Name of the module of a compiled function; None if it is outside this package."""
    # Functions created by `exec` may have no module.
    function = getattr(event.data["dispatcher"], "py_func", None)
    package, _, module = (getattr(function, "__module__", None) or "").rpartition(".")
    return module if package == __package__ else None


def _seconds(event: Any, module: str) -> int:
    """Expected duration of a compilation, from the module and the types of the arguments."""
    classes = (getattr(kind, "instance_class", None) for kind in event.data["args"])
    names = [getattr(each, "__name__", "") for each in classes]
    return max((SECONDS[name] for name in (module, *names) if name in SECONDS), default=USUAL)


def send_to(write: Callable[[str], None] | None) -> None:
    """Set the function that is called with the line; None restores `write_line`."""
    _writers[:] = [] if write is None else [write]


def write_current(line: str) -> None:
    """Write a line with the function of the command line, if there is one, or `write_line`."""
    (_writers or [write_line])[-1](line)


def write_line(line: str) -> None:
    """Write a line to standard error, except in worker processes and into pipes and files."""
    stream = sys.stderr
    if multiprocessing.parent_process() is None and _is_read(stream):
        # The terminal may have been closed.
        with contextlib.suppress(OSError, ValueError):
            print(line, file=stream, flush=True)


def _is_read(stream: Any) -> bool:
    """Whether a stream is a terminal or the output of a notebook."""
    # While rich shows a progress bar, it writes lines to standard error above the bar.
    shown = getattr(stream, "rich_proxied_file", stream)
    with contextlib.suppress(AttributeError, ValueError):
        return shown.isatty() or type(shown).__module__.startswith("ipykernel.")
    return False


def seconds_compiled() -> float:
    """Seconds that this process has spent on compiling, completed compilations only."""
    return sum(notice.total for notice in _installed)


def install() -> None:
    """Register the listener with numba."""
    notice = CompileNotice()
    _installed.append(notice)
    event.register("numba:compile", notice)
