"""HTTP connections that are closed if they are idle."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Final

from uvicorn.protocols.http.h11_impl import H11Protocol

MAX_CONNECTIONS: Final = 64
# Seconds for the header of a request, and for a client that does not read its answer.
PATIENCE: Final = 10.0


class Connection(H11Protocol):
    """A connection that is closed if its client is silent, and rejected if there are too many."""

    def connection_made(self, transport: Any) -> None:
        """Start the timer, or reject the connection."""
        self._silence, self._unread = _Timer(self.loop), _Timer(self.loop)
        super().connection_made(transport)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.abort()
        else:
            self._silence.start(transport.abort)

    def data_received(self, data: bytes) -> None:
        """Stop the timer when the header of a request is complete."""
        super().data_received(data)
        if self.cycle is None or self.cycle.response_complete:
            self._silence.start(self.transport.abort)
        else:
            self._silence.stop()

    def on_response_complete(self) -> None:
        """Leave the idle connection to the keep-alive timer."""
        self._silence.stop()
        super().on_response_complete()

    def pause_writing(self) -> None:
        """Allow the client some time to read."""
        super().pause_writing()
        self._unread.start(self.transport.abort)

    def resume_writing(self) -> None:
        """Stop the timer, because the client has read."""
        self._unread.stop()
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop both timers."""
        self._silence.stop()
        self._unread.stop()
        super().connection_lost(exc)


class _Timer:
    """Calls a function after a time, unless it is stopped; starting it again has no effect."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self.handle: asyncio.TimerHandle | None = None

    def start(self, action: Callable[[], None]) -> None:
        if self.handle is None:
            self.handle = self.loop.call_later(PATIENCE, action)

    def stop(self) -> None:
        if self.handle is not None:
            self.handle.cancel()
        self.handle = None
