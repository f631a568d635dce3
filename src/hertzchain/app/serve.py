"""Start the server and open the page."""

from __future__ import annotations

import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Callable
from typing import Any, Final

import uvicorn

from .connection import Connection
from .server import App
from .warm_up import WarmUp

# Ports that are tried after the requested one.
MORE_PORTS: Final = 20


def bind(port: int) -> socket.socket:
    """A socket on the loopback address, at the port or, if it is taken, the next free one."""
    for each in (*range(port, min(port + MORE_PORTS, 65535) + 1), 0):
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if sys.platform != "win32":
            # Otherwise a port could not be used again for a minute after a server has stopped.
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(("127.0.0.1", each))
        except OSError:
            listener.close()
            continue
        listener.listen(128)
        return listener
    raise AssertionError  # Port 0 is always free.


class RunningServer:
    """A server and the address of its page."""

    def __init__(
        self, port: int, document: object = None, *, warm_up: bool = True, view: object = None
    ) -> None:
        self.socket = bind(port)
        self.port: int = self.socket.getsockname()[1]
        self.app = App(self.port, document, WarmUp() if warm_up else None, view)
        self._prepares = warm_up
        config = uvicorn.Config(
            self.app.asgi, http=Connection, ws="none", lifespan="off", log_config=None,
            access_log=False, server_header=False, date_header=False, timeout_keep_alive=30,
            timeout_graceful_shutdown=1, h11_max_incomplete_event_size=16_384,
        )  # fmt: skip
        self.server = uvicorn.Server(config)

    @property
    def address(self) -> str:
        """Address to open, with the token."""
        return self.app.address

    def run(self, ready: Callable[[], Any] | None = None) -> None:
        """Serve until interrupted."""
        # Connections are queued from the beginning, so the page can be opened before it is served.
        timer = threading.Timer(0.05, ready) if ready is not None else None
        if timer is not None:
            timer.start()
        self.app.warm_up.start()
        if self._prepares:
            threading.Thread(target=self.app.prepare, daemon=True).start()
        try:
            self.server.run(sockets=[self.socket])
        finally:
            self.close()

    def start(self) -> threading.Thread:
        """Serve in a thread, until `stop`."""
        thread = threading.Thread(target=self.run, daemon=True)
        thread.start()
        while not self.server.started and thread.is_alive():
            time.sleep(0.01)
        return thread

    def stop(self) -> None:
        """Stop a server that runs in a thread."""
        self.server.should_exit = True
        self.close()

    def close(self) -> None:
        """Stop all simulations."""
        self.app.close()


def open_browser(address: str) -> bool:
    """Open the page; False if there is no browser."""
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False
