"""Files of the page, read once: no path of a request is opened on disk."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Final, NamedTuple

TYPES: Final = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


class StaticFile(NamedTuple):
    """Media type and content."""

    media_type: str
    content: bytes


@cache
def static_files() -> dict[str, StaticFile]:
    """All files by their path on the server, such as ``/js/main.js``."""
    found = dict(_walk(files("hertzchain.app") / "static", "/"))
    found["/"] = found["/index.html"]
    return found


def _walk(folder: Traversable, prefix: str) -> Iterator[tuple[str, StaticFile]]:
    for item in folder.iterdir():
        ending = item.name.rpartition(".")[2]
        if item.is_dir():
            yield from _walk(item, f"{prefix}{item.name}/")
        elif ending in TYPES:
            yield f"{prefix}{item.name}", StaticFile(TYPES[ending], item.read_bytes())
