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
package is imported, cache files that are older than a file of which the function was made are
therefore deleted.
"""

import ast
import os
from contextlib import suppress
from pathlib import Path


def _forget_stale(folder: Path) -> None:
    """Delete cache files that are older than their module or a module that it imports."""
    dates = {each.stem: each.stat().st_mtime for each in folder.glob("*.py")}
    newest = max(dates.values())
    imports: dict[str, set[str]] = {}
    for index in (folder / "__pycache__").glob("*.nbi"):
        # Another process may have deleted the file, or the folder may be read-only.
        with suppress(OSError):
            if (made := index.stat().st_mtime) >= newest:
                continue
            imports = imports or {name: _imports(folder / f"{name}.py") for name in dates}
            module = index.name.partition(".")[0]
            if any(dates.get(name, newest) > made for name in _sources(module, imports)):
                index.unlink()
            else:
                # The next import of the package need not compare it again.
                os.utime(index)


def _imports(source: Path) -> set[str]:
    """Names of the modules of this package that a file imports."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {each.name for each in node.names}
    return found


def _sources(module: str, imports: dict[str, set[str]]) -> set[str]:
    """A module and all modules that it imports, also through others."""
    found, new = set(), {module}
    while new:
        found |= new
        new = set().union(*(imports.get(name, set()) for name in new)) - found
    return found


_forget_stale(Path(__file__).parent)
