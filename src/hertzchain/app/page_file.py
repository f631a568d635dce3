"""The page of the app in a file: one or two chains with their results."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Final

from ..chain.bead_names import bead_number, wall_number
from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..errors import InputError
from ..recorded_warnings import record_warnings
from ..store.writing import write_bytes
from ..validation.keywords import checked_arguments
from ..validation.numbers import number
from ..validation.objects import check_list, file_path
from .documents import chain_of, document_of_chain
from .exports import page_with_results
from .requests import MAX_SENSORS

ENDING: Final = ".html"


@checked_arguments("save_page")
def save_page(
    chain: Chain,
    path: str | os.PathLike[str],
    *,
    other: Chain | None = None,
    sensors: Iterable[int | str] = (),
    until: float | str | None = None,
) -> None:
    """Save a page that shows a chain and its results, and needs neither Python nor a network.

    It is the page of ``hertzchain app``: the animation, the leading pulse with all theories, the
    map of velocities or forces, the forces on walls and in sensors, and the energy over time.  If
    the chain is at rest, nothing moves, and only the spectrum has a meaning.

    Parameters
    ----------
    chain : Chain
        The chain, of at most 2000 beads.
    path : path-like
        File to write, ``.html``; an existing file is replaced when the new one is complete.
    other : Chain, optional
        A second chain in the same units, with which the first one is compared.
    sensors : iterable of int or str
        Up to four beads of ``chain`` with sensors, as numbers or names such as ``"ball 4"``; in
        ``other``, the same balls, counted without the strikers.
    until : float or str, optional
        Time > 0 until which the runs last at least [scaled, or s; also with a unit, ``"2 ms"``].
        By default, they end when the peak on the wall is complete or, without a wall, when the
        last bead has separated.

    Raises
    ------
    InputError
        If an argument is out of range, or the file cannot be written.
    SimulationError
        If a run fails, or takes longer than 20 s.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "pulse.html"
    ...     hc.save_page(hc.Chain.uniform(20), file)
    ...     file.stat().st_size > 100_000
    True
    """
    require_chain("save_page", chain)
    if other is not None:
        require_chain("save_page", other)
    compared = None if other is None else document_of_chain(other)
    write_page(document_of_chain(chain), compared, sensors, path, until=until)


def write_page(
    document: Mapping[str, Any],
    other: Mapping[str, Any] | None,
    sensors: Iterable[int | str],
    path: str | os.PathLike[str],
    names: Mapping[str, str] | None = None,
    *,
    until: float | str | None = None,
    record: Mapping[str, Any] | None = None,
) -> None:
    """`save_page` for documents, which keep the units and names of their chain files."""
    file = file_path("path", path)
    if file.suffix != ENDING:
        raise InputError(f"path must end in {ENDING}, got {os.fspath(path)!r}")
    view = first_view(document, other, sensors, until, record)
    shown = view["view"]
    given = {
        "document": document, "other": other, "sensors": shown["sensors"],
        "run_until": shown["until"], "view": view, "record": view["record"].get("record", ""),
    }  # fmt: skip
    with record_warnings():
        content = page_with_results(given, lambda: False, names)
    write_bytes(file, content)


def first_view(
    document: Mapping[str, Any],
    other: Mapping[str, Any] | None,
    sensors: Iterable[int | str],
    until: float | str | None = None,
    record: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Chain B, choices of the views and measured data with which a page begins.

    If there are sensors, there are also sensors in the balls of the data.
    """
    chain = chain_of(document)
    if other is not None and chain_of(other).units != chain.units:
        raise InputError("the two chains must both be in SI units, or both be scaled")
    beads = check_list("sensors", sensors, "numbers or names of beads, such as 5 or 'ball 4'")
    if len(beads) > MAX_SENSORS:
        raise InputError(f"a page shows up to {MAX_SENSORS} sensors, got {len(beads)}")
    # Forces on walls, such as a load cell, are always shown.
    inside = [each for each in beads if wall_number(chain, each) is None]
    balls = [bead_number(chain, each, "bead with a sensor") - chain.strikers for each in inside]
    errors = "theories" if other is None else "difference"
    end = 0.0 if until is None else number("until", until, unit=chain._unit("s"), above=0.0)
    measured = dict(record or {})
    balls = list(dict.fromkeys((*balls, *measured.get("balls", ()))))[:MAX_SENSORS]
    view = {"sensors": balls, "errors": errors, "until": end}
    return {"B": other, "view": view, "record": measured}
