"""All compiled code: arrays in, arrays and a status code out.

`full_chain` steps the beads of a whole chain, with the forces of `forces`; `front` and
`wide_front` follow the pulse alone; `local_rate` is a theory.  Nothing here raises or prints;
the callers turn status codes into errors.

Numba keeps what it compiled beside these files and, of a function and those that it calls,
looks at the date of the caller's file alone.  Whatever was compiled before any file here
changed is therefore thrown away when they are loaded.
"""

from contextlib import suppress
from pathlib import Path


def _forget_stale(folder: Path) -> None:
    newest = max(source.stat().st_mtime for source in folder.glob("*.py"))
    for index in (folder / "__pycache__").glob("*.nbi"):
        # Another process may be faster, or the folder not ours to write.
        with suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()


_forget_stale(Path(__file__).parent)
