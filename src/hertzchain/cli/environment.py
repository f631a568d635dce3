"""Set and check environment variables that Matplotlib and numba read."""

from __future__ import annotations

import os


def prepare_environment() -> None:
    """Select Matplotlib's file backend and check NUMBA_NUM_THREADS."""
    # Commands open no windows, so a backend chosen by the user need not be installed.
    os.environ["MPLBACKEND"] = "agg"
    threads = os.environ.get("NUMBA_NUM_THREADS", "").strip()
    if threads.lstrip("+-").isdigit() and int(threads) < 1:
        from ..errors import InputError

        raise InputError(
            f"the environment variable NUMBA_NUM_THREADS is {threads!r}, but must be a whole "
            "number of at least 1; unset it or set it to 1"
        )
