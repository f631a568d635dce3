"""Compiled functions, which take arrays and return arrays and a status code.

==========================  ====================================================================
module                      contents
==========================  ====================================================================
`full_chain`                adaptive integration of all moving beads of one chain (`simulate`)
`symplectic`                the same with fixed steps
`elastic_chains`            integration of several elastic chains side by side (`simulate_many`)
`narrow_window`,            integration of the beads around the leading pulse (`propagate`), in a
`wide_window`               window that moves with it
`adjoint_forward`,          integration that stores its steps, and the derivatives of its results
`adjoint_reverse`
`contact_law`, `forces`     force and stored energy of one contact; forces on all beads
`local_rate`                the local-rate theory
==========================  ====================================================================

Kernels raise no exceptions and print nothing; callers convert status codes to errors.

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
