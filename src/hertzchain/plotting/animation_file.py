"""The file of an animation, which notebooks show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

# The class of paths of this system, which Python before 3.12 requires as the base.
_SystemPath: Any = type(Path())


class AnimationFile(_SystemPath):  # type: ignore[misc]
    """Path of an animation; at the end of a cell of a notebook, the animation itself."""

    def __repr__(self) -> str:
        return repr(Path(self))

    def _repr_html_(self) -> str | None:
        from ..notebook.animations import animation_html

        return animation_html(Path(self))
