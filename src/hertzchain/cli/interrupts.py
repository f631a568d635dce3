"""Exit soon after an interrupt, even while the compiler runs."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import click

from .exit_codes import INTERRUPTED

# Seconds after an interrupt in which the command may end by itself.
GRACE: Final = 1.0


@contextmanager
def exit_soon(message: str) -> Iterator[None]:
    """Write a message at an interrupt, and exit within a second.

    The compiler cannot be interrupted: Python handles a signal only after the compilation of a
    function.  A thread therefore waits for the signal.  What is done must survive a kill.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ended, (source, target) = threading.Event(), os.pipe()
    os.set_blocking(target, False)
    before = signal.set_wakeup_fd(target, warn_on_full_buffer=False)
    watcher = threading.Thread(target=_watch, args=(source, ended, message), daemon=True)
    watcher.start()
    try:
        yield
    except KeyboardInterrupt:
        if not ended.is_set():
            ended.set()
            click.echo(message, err=True)
        raise
    finally:
        ended.set()
        signal.set_wakeup_fd(before)
        os.close(target)
        watcher.join()
        os.close(source)


def _watch(source: int, ended: threading.Event, message: str) -> None:
    """Exit if an interrupt arrives and the command has not ended a second later."""
    while signals := os.read(source, 64):
        if signal.SIGINT in signals and not ended.wait(GRACE):
            ended.set()
            click.echo(message, err=True)
            os._exit(INTERRUPTED)
