"""The page of the app in a notebook."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.resources import files
from typing import Any

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..errors import InputError, SimulationError
from ..validation.json_types import finite
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number
from .about import about
from .documents import chain_of, document_of_chain, document_of_toml
from .exports import export
from .latest import Latest
from .records import read_record
from .requests import Request
from .results import Cancelled, results
from .saved_page import embedded_page

# Sends a message to the page: a mapping, and buffers.
Send = Callable[[Mapping[str, Any], list[bytes]], None]


@checked_arguments("explore")
def explore(chain: Chain | None = None, *, height: int = 900) -> Any:
    """Show a chain in a notebook, with the controls and views of ``hertzchain app``.

    Results are computed in the kernel of the notebook.  The page requires neither a network nor a
    port.

    Parameters
    ----------
    chain : Chain, optional
        Chain to begin with, of at most 2000 beads; by default a row of steel balls.
    height : int
        Height of the output, in pixels from 300 to 4000.

    Returns
    -------
    anywidget.AnyWidget
        A widget whose attributes ``chain`` and ``other`` are the chains that the page shows at
        present; ``other`` is None if there is only one.  ``hertzchain.propagate(widget.chain)``
        returns the numbers on the page.

    Raises
    ------
    InputError
        If an argument is out of range, or the package anywidget is not installed.

    Examples
    --------
    >>> import hertzchain as hc
    >>> view = hc.explore(hc.Chain.uniform(20))  # doctest: +SKIP
    >>> view.chain  # doctest: +SKIP
    Chain(uniform, 20 beads)
    """
    height = whole_number("height", height, least=300, most=4000)
    document = None
    if chain is not None:
        require_chain("explore", chain)
        # The page changes radii, which then do not have the scatter of the chain.
        document = document_of_chain(chain.replace(scatter=None))
    return _widget_class()(document, height)


class Conversation:
    """Answers to the messages of one page; independent of the notebook."""

    def __init__(self, document: object, send: Send) -> None:
        self.documents = {"A": document, "B": None}
        self.send = send
        self.latest = Latest()
        self.closing = threading.Event()
        self.pool = ThreadPoolExecutor(2, "hertzchain-explore")

    def receive(self, content: Mapping[str, Any]) -> None:
        """Answer a message; results are computed in a thread."""
        number, kind, body = (content.get(name) for name in ("id", "type", "body"))
        if kind == "state" and isinstance(body, Mapping):
            self.documents = {"A": body.get("A"), "B": body.get("B")}
            self.send({"id": number, "done": True}, [])
        elif kind == "results":
            try:
                wanted = Request.of(body)
            except InputError as error:
                self.send({"id": number, "done": True, "error": str(error)}, [])
                return
            # Registered before a thread is free, so that older requests that occupy it stop.
            out_of_date = self.latest.begin(wanted.session, wanted.slot, wanted.number)
            self.pool.submit(
                self._answer, number, kind, wanted, lambda: out_of_date() or self.closing.is_set()
            )
        elif kind in ("read", "record", "export"):
            self.pool.submit(self._answer, number, kind, body, self.closing.is_set)

    def close(self) -> None:
        """Stop all simulations."""
        self.closing.set()
        self.pool.shutdown(wait=False, cancel_futures=True)

    def _answer(self, number: Any, kind: str, body: Any, stop: Callable[[], bool]) -> None:
        last: dict[str, Any] = {"id": number, "done": True}
        buffers: list[bytes] = []
        try:
            if stop():
                raise Cancelled
            if kind == "results":
                for part in results(body, stop):
                    self.send({"id": number}, [part.pack()])
            elif kind == "read":
                last["document"] = document_of_toml(body)
            elif kind == "record":
                last |= read_record(body)
            else:
                file = export(body, stop)
                last |= {"name": file.name, "media_type": file.media_type}
                buffers = [file.content]
        except (InputError, SimulationError) as error:
            last["error"] = str(error)
        except Cancelled:
            last["error"] = "cancelled"
        self.send(last, buffers)


@cache
def _widget_class() -> Any:
    """The class of widgets, which exists only if anywidget is installed."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise InputError(
            "explore requires the package anywidget; install it with pip install "
            "'.[notebook]' in the folder of the source code, or use hertzchain app"
        ) from None

    class Explorer(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """A frame with the page, which exchanges messages with this object."""

        _esm = (files("hertzchain.app") / "notebook_frame.js").read_text("utf-8")
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int().tag(sync=True)

        def __init__(self, document: object, height: int) -> None:
            stored = {"kind": "notebook", "about": finite(about(document))}
            first = stored["about"]["document"]
            self.conversation = Conversation(first, self._send_message)
            super().__init__(page=embedded_page(stored).decode(), height=height)
            self.on_msg(lambda _, content, __: self.conversation.receive(content))

        def close(self) -> None:
            """Stop all simulations and remove the page."""
            self.conversation.close()
            super().close()

        def _send_message(self, content: Mapping[str, Any], buffers: list[bytes]) -> None:
            self.send({"content": dict(content)}, buffers)

        @property
        def chain(self) -> Chain:
            """The chain on the page, or chain A."""
            return chain_of(self.conversation.documents["A"])

        @property
        def other(self) -> Chain | None:
            """Chain B, if there is one."""
            document = self.conversation.documents["B"]
            return None if document is None else chain_of(document)

    return Explorer
