"""Write lines to standard error during a long run that nothing else reports."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from ..validation.objects import Progress

# Seconds before the first line, and between two lines.
INTERVAL: Final = 5.0


def simulated_seconds() -> float:
    """Time without that of compiling, of which another line informs."""
    from ..kernels.compile_notice import seconds_compiled

    return time.monotonic() - seconds_compiled()


def slow_run_notice(
    write: Callable[[str], None] | None = None, clock: Callable[[], float] = simulated_seconds
) -> Progress:
    """Progress function that writes to a terminal or notebook, at most once per interval.

    The first line also states what shortens a run.
    """
    begin = clock()
    last, advice = begin, "; a larger rtol or a smaller until shortens the run"

    def report(passed: int, beads: int) -> None:
        nonlocal last, advice
        now = clock()
        if now - last < INTERVAL:
            return
        last = now
        from ..kernels.compile_notice import write_line

        part = "all beads" if passed == beads else f"{passed} of {beads} beads"
        (write or write_line)(
            f"hertzchain: simulating for {now - begin:.0f} s; the pulse has passed {part}{advice}"
        )
        advice = ""

    return report
