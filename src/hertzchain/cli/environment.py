"""Environment variables that other packages read, and that could stop a command."""

from __future__ import annotations

import os


def prepare_environment() -> None:
    """Choose the backend that writes files, and refuse what numba would refuse with a traceback."""
    # Commands open no windows, so that no backend of the user's needs to exist.
    os.environ["MPLBACKEND"] = "agg"
    threads = os.environ.get("NUMBA_NUM_THREADS", "").strip()
    if threads.lstrip("+-").isdigit() and int(threads) < 1:
        from hertzchain.errors import InputError

        raise InputError(
            f"the environment variable NUMBA_NUM_THREADS is {threads!r}: it must be a whole number "
            "of at least 1; unset it, or set it to 1"
        )
