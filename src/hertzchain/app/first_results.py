"""The page with the results of its first chains, for the first picture without a request."""

from __future__ import annotations

import base64
import time
from collections.abc import Callable
from typing import Any, Final

from . import background_import
from .static_files import static_files

# Seconds of the computation, and size of the results [bytes], up to which they are embedded.
MAX_TIME: Final = 20.0
MAX_SIZE: Final = 2_000_000


class FirstResults:
    """The page that is served first: with the results of its chains once they are known."""

    def __init__(self, document: object, view: object) -> None:
        self.document, self.view = document, view
        self.page = static_files()["/"].content

    def compute(self, stop: Callable[[], bool]) -> None:
        """Add the results to the page, unless ``stop()``, an error or the limits prevent it."""
        background_import.load()
        from ..errors import InputError
        from ..validation.json_types import finite
        from .about import about
        from .requests import Request
        from .results import results
        from .saved_page import as_json

        begin, found = time.monotonic(), finite(about(self.document, self.view))
        raw, slots = b"", []

        def late() -> bool:
            return stop() or time.monotonic() - begin > MAX_TIME

        for slot, request in _requests(found).items():
            try:
                checked = Request.of({"session": "first", "number": 0, "slot": slot, **request})
            except InputError:
                return
            slots.append(slot)
            for part in results(checked, late):
                raw += part.pack()
                if part.header["part"] in ("error", "cancelled") or len(raw) > MAX_SIZE:
                    return
        parts = base64.b64encode(raw).decode()
        text = as_json({"about": found, "slots": slots, "parts": parts})
        script = f'<script type="application/json" id="first">{text}</script></head>'
        self.page = self.page.replace(b"</head>", script.encode(), 1)


def _requests(about: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The first requests of the page by slot, as `page.js` and `requests.js` make them."""
    view = about["view"] or {}
    record = view.get("record") or {}
    shown, document = view.get("view") or {}, about["document"]
    sensors = shown.get("sensors", about["sensors"])
    if sensors is None:
        sensors = [int(document["chain"].get("beads", 2) / 2 + 0.5)]
    common = {
        "frames": 320, "rtol": 1e-9, "clock": shown.get("clock", "beads"), "sensors": sensors,
        "run_until": shown.get("until", 0.0), "record": record.get("record", ""),
    }  # fmt: skip
    documents = {"A": document, "B": view.get("B")}
    return {slot: {"document": each, **common} for slot, each in documents.items() if each}
