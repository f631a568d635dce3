"""HTML representation of the file of an animation: the animation itself."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path
from typing import Final

from .drawing import note, page

MEGABYTE: Final = 1e6
# Larger files are not embedded, because notebooks with them open slowly.
MAX_SIZE: Final = 5.0 * MEGABYTE
STYLE: Final = "max-width:100%;background:white"


def animation_html(file: Path) -> str | None:
    """The animation, embedded; `None` if there is no such file."""
    kind = file.suffix.lower()
    if kind not in (".gif", ".mp4") or not file.is_file():
        return None
    size = file.stat().st_size
    if size > MAX_SIZE:
        return page("Animation", file.name, note(
            f"The file has {size / MEGABYTE:.1f} MB and is not shown, because notebooks keep "
            f"animations of at most {MAX_SIZE / MEGABYTE:g} MB; use fewer frames, or open "
            f"{file}."
        ))  # fmt: skip
    content = b64encode(file.read_bytes()).decode()
    title = escape(f"Animation of the beads, {file.name}", quote=True)
    if kind == ".gif":
        shown = f'<img src="data:image/gif;base64,{content}" alt="{title}" style="{STYLE}">'
    else:
        shown = (
            f'<video src="data:video/mp4;base64,{content}" title="{title}" style="{STYLE}" '
            "controls loop muted></video>"
        )
    return page("Animation", f"{file.name}, {_in_words(size)}", shown)


def _in_words(size: int) -> str:
    return f"{size / 1e3:.0f} kB" if size < MEGABYTE else f"{size / MEGABYTE:.1f} MB"
