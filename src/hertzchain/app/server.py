"""The server of the app: the page, streams of results, and files to save.

The page is served before the modules of the library are imported:
`hertzchain.app.background_import` imports them, and only functions that answer import them here.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Final

from starlette.applications import Starlette
from starlette.requests import Request as HttpRequest
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..errors import InputError, SimulationError
from . import background_import
from .first_results import FirstResults
from .guard import HEADERS, Guard
from .latest import Latest
from .static_files import static_files
from .warm_up import WarmUp

if TYPE_CHECKING:
    from .requests import Request

MAX_BODY: Final = 300_000
# Seconds for the body of a request.
PATIENCE: Final = 10.0
# Number of simultaneous simulations; further ones wait, and those out of date are not started.
WORKERS: Final = 2
# Seconds between two looks at the state of the compilation.
PAUSE: Final = 0.1


class RejectedError(Exception):
    """A request that is not answered: HTTP status and reason."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


class App:
    """State of the server: access control, running requests, compiled functions."""

    def __init__(
        self, port: int, document: object = None, warm_up: WarmUp | None = None,
        view: object = None,
    ) -> None:  # fmt: skip
        self.guard = Guard(port)
        self.port = port
        self.document, self.view = document, view
        self.first = FirstResults(document, view)
        self.latest = Latest()
        self.closing = threading.Event()
        self.warm_up = WarmUp(()) if warm_up is None else warm_up
        self.pool = ThreadPoolExecutor(WORKERS, "hertzchain-app")
        routes = [
            Route("/api/about", self.about, methods=["GET"]),
            Route("/api/results", self.results, methods=["POST"]),
            Route("/api/chain", self.chain, methods=["POST"]),
            Route("/api/record", self.record, methods=["POST"]),
            Route("/api/export", self.export, methods=["POST"]),
            Route("/{path:path}", self.page, methods=["GET"]),
        ]
        inner = Starlette(routes=routes, exception_handlers={RejectedError: _reject})
        self.asgi: ASGIApp = _Guarded(inner, self.guard)

    @property
    def address(self) -> str:
        """Address to open, with the token."""
        return f"http://127.0.0.1:{self.port}/?token={self.guard.token}"

    async def page(self, request: HttpRequest) -> Response:
        """A file of the page."""
        found = static_files().get(request.url.path)
        if found is None:
            raise RejectedError(404, "not found")
        content = self.first.page if request.url.path == "/" else found.content
        return Response(content, media_type=found.media_type)

    async def about(self, _: HttpRequest) -> Response:
        """Schema, materials, gallery, and the initial chain."""
        await _loaded()
        from ..validation.json_types import finite
        from .about import about

        loop = asyncio.get_running_loop()
        found = await loop.run_in_executor(None, about, self.document, self.view)
        return JSONResponse(finite(found))

    async def chain(self, request: HttpRequest) -> Response:
        """The document of a chain file that the page has opened."""
        body = await _body(request)
        await _loaded()
        from .documents import document_of_toml

        try:
            document = document_of_toml(body.decode())
        except UnicodeDecodeError:
            return JSONResponse({"error": "this file is not UTF-8 text"})
        except InputError as error:
            return JSONResponse({"error": str(error)})
        return JSONResponse({"document": document})

    async def record(self, request: HttpRequest) -> Response:
        """The key of a measured record that the page has opened."""
        await _loaded()
        from .records import MAX_FILE, read_record

        given = await _json(request, MAX_FILE)
        work = asyncio.get_running_loop().run_in_executor(None, read_record, given)
        try:
            return JSONResponse(await work)
        except InputError as error:
            return JSONResponse({"error": str(error)})

    async def export(self, request: HttpRequest) -> Response:
        """A file to save."""
        given = await _json(request)
        await _loaded()
        from .exports import export
        from .results import Cancelled

        work = asyncio.get_running_loop().run_in_executor(
            self.pool, export, given, self.closing.is_set
        )
        try:
            file = await work
        except (InputError, SimulationError) as error:
            raise RejectedError(422, str(error)) from None
        except Cancelled:
            raise RejectedError(503, "the server is closing") from None
        disposition = f'attachment; filename="{file.name}"'
        return Response(
            file.content, media_type=file.media_type, headers={"content-disposition": disposition}
        )

    async def results(self, request: HttpRequest) -> Response:
        """A stream of binary messages with the results of a chain."""
        given = await _json(request)
        await _loaded()
        from .requests import Request

        try:
            wanted = Request.of(given)
        except InputError as error:
            raise RejectedError(400, str(error)) from None
        out_of_date = self.latest.begin(wanted.session, wanted.slot, wanted.number)
        gone = threading.Event()

        def stop() -> bool:
            return gone.is_set() or out_of_date() or self.closing.is_set()

        parts = self._computed(lambda put: self._compute(wanted, stop, put), gone)
        return StreamingResponse(parts, media_type="application/octet-stream")

    def _compute(
        self, wanted: Request, stop: Callable[[], bool], put: Callable[[bytes], None]
    ) -> None:
        """Compute the messages in a thread."""
        from .messages import Part
        from .results import results

        if stop():
            put(Part({"part": "cancelled", **wanted.identity}).pack())
            return
        self._put_status(wanted, put)
        features: list[str] = []
        for part in results(wanted, stop):
            put(part.pack())
            kind = part.header["part"]
            if kind == "beads":
                features = part.header["features"]
            if self.warm_up.pending():
                self._put_status(wanted, put)
                self.warm_up.wait(kind, features, stop)
            if stop() and kind in ("beads", "pulse"):
                put(Part({"part": "cancelled", **wanted.identity}).pack())
                return

    def _put_status(self, wanted: Request, put: Callable[[bytes], None]) -> None:
        from .messages import Part

        status = {"part": "status", **wanted.identity, "pending": self.warm_up.pending()}
        put(Part(status).pack())

    async def _computed(
        self, compute: Callable[[Callable[[bytes], None]], None], gone: threading.Event
    ) -> AsyncIterator[bytes]:
        """Messages in the order in which a thread computes them."""
        loop, ready = asyncio.get_running_loop(), asyncio.Queue[bytes | None]()

        def put(raw: bytes | None) -> None:
            # The loop is closed if the server stops first.
            if not loop.is_closed():
                loop.call_soon_threadsafe(ready.put_nowait, raw)

        def work() -> None:
            try:
                compute(put)
            finally:
                put(None)

        future = loop.run_in_executor(self.pool, work)
        try:
            while (raw := await ready.get()) is not None:
                yield raw
            await future
        finally:
            gone.set()

    def prepare(self) -> None:
        """Add the first results to the page when everything is compiled."""
        while self.warm_up.pending():
            if self.closing.wait(PAUSE):
                return
        self.first.compute(self.closing.is_set)

    def close(self) -> None:
        """Stop all simulations."""
        self.closing.set()
        self.pool.shutdown(wait=False, cancel_futures=True)


def _reject(_: HttpRequest, error: Exception) -> Response:
    assert isinstance(error, RejectedError)
    return PlainTextResponse(str(error), error.status, {"connection": "close"})


async def _loaded() -> None:
    """Wait until the library is imported, without blocking other requests."""
    if not background_import.LOADED.is_set():
        await asyncio.get_running_loop().run_in_executor(None, background_import.load)


async def _body(request: HttpRequest, most: int = MAX_BODY) -> bytes:
    """Read the body of a request; reject it if it is too long or too slow."""
    body = bytearray()
    try:
        async with asyncio.timeout(PATIENCE):
            async for chunk in request.stream():
                body += chunk
                if len(body) > most:
                    raise RejectedError(413, f"a request has at most {most} bytes")
    except TimeoutError:
        raise RejectedError(408, f"the request took longer than {PATIENCE:g} s") from None
    return bytes(body)


async def _json(request: HttpRequest, most: int = MAX_BODY) -> dict[str, Any]:
    # Another content type could be sent by a form of another site, without a preflight request.
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        raise RejectedError(415, "the content type must be application/json")
    try:
        given = json.loads(await _body(request, most), parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise RejectedError(400, "the request is not valid JSON") from None
    if not isinstance(given, dict):
        raise RejectedError(400, "the request must be a JSON object")
    return given


def _no_constant(name: str) -> None:
    raise ValueError(name)


class _Guarded:
    """Checks each request, exchanges the token for a cookie, and adds headers."""

    def __init__(self, app: ASGIApp, guard: Guard) -> None:
        self.app, self.guard = app, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] != "http":
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                added = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
                message["headers"] = [*message["headers"], *added]
            await send(message)

        request = HttpRequest(scope)
        await self._answer(request)(scope, receive, send_with_headers)

    def _answer(self, request: HttpRequest) -> ASGIApp:
        token = request.query_params.get("token")
        known_host = request.headers.get("host", "") in self.guard.hosts
        if request.method == "GET" and token and known_host and self.guard.is_token(token):
            # The token leaves the address: a copied link must not contain it.
            headers = {"location": "/", "set-cookie": self.guard.set_cookie}
            return Response(status_code=303, headers=headers)
        api = request.url.path.startswith("/api/")
        if refusal := self.guard.refusal(request.headers, api=api):
            return PlainTextResponse(refusal, 403, {"connection": "close"})
        return self.app
