"""All compiled code: arrays in, arrays and a status code out.

`full_chain` integrates all beads of a chain, with the forces of `forces`; `narrow_front` and
`wide_front` integrate only the beads around the pulse; `local_rate` evaluates a theory.  Kernels
raise no exceptions and print nothing; callers convert status codes to errors.

Numba caches compiled functions next to these files, but compares the date of a cached function
only with the file of the function itself, not with those of the functions that it calls.  When the
package is imported, cache files that are older than any file here are therefore deleted.
"""

from contextlib import suppress
from pathlib import Path


def _forget_stale(folder: Path) -> None:
    newest = max(source.stat().st_mtime for source in folder.glob("*.py"))
    for index in (folder / "__pycache__").glob("*.nbi"):
        # Another process may have deleted the file, or the folder may be read-only.
        with suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()


_forget_stale(Path(__file__).parent)
