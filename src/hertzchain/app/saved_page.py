"""The page in one HTML file: with its results, for use without Python, or for a notebook."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Mapping
from typing import Any, Final

from .about import about
from .static_files import static_files

# Modules are embedded as data: addresses, which cannot import relative to themselves; names in an
# import map can.
PREFIX: Final = "hertzchain/"
POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)


def saved_page(given: Mapping[str, Any], parts: bytes, heading: str) -> bytes:
    """The page with the messages of its requests, and the state of its views."""
    page = embedded_page(
        {
            "kind": "saved",
            "about": about(given.get("document"), given.get("view")),
            "parts": base64.b64encode(parts).decode(),
        }
    )
    title = f"<title>{html.escape(heading)} – hertzchain</title>"
    return re.sub(rb"<title>.*?</title>", lambda _: title.encode(), page, count=1)


def embedded_page(stored: Mapping[str, Any]) -> bytes:
    """The page in one file, with the data that `host.js` reads."""
    files = static_files()
    text = files["/index.html"].content.decode()
    modules = {
        PREFIX + path.removeprefix("/js/"): _data_address(file.content.decode())
        for path, file in files.items()
        if path.startswith("/js/")
    }
    style = files["/app.css"].content.decode()
    icon = base64.b64encode(files["/icon.svg"].content).decode()
    head = (
        f'<meta http-equiv="content-security-policy" content="{POLICY}">'
        f"<style>{style}</style>"
        f'<script type="importmap">{as_json({"imports": modules})}</script>'
        f'<script type="application/json" id="embedded">{as_json(stored)}</script>'
        f'<script type="module">import "{PREFIX}main.js";</script>'
    )
    loaded = r"<(link|script)\b[^>]*(stylesheet|main\.js)[^>]*>(</script>)?"
    text = re.sub(loaded, "", text)
    text = text.replace("/icon.svg", f"data:image/svg+xml;base64,{icon}")
    return text.replace("</head>", f"{head}</head>", 1).encode()


def as_json(item: Any) -> str:
    """JSON for an element of a page."""
    # Escaped: no text within can end the element.
    return json.dumps(item, allow_nan=False).replace("<", "\\u003c")


def _data_address(source: str) -> str:
    source = re.sub(r'(from|import) "\./([\w-]+\.js)"', rf'\1 "{PREFIX}\2"', source)
    encoded = base64.b64encode(source.encode()).decode()
    return f"data:text/javascript;base64,{encoded}"
