"""Checks, limits and TOML text of the chain files that the page sends."""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import InputError
from ..store.chain_as_toml import chain_document
from ..store.chain_files import chain_from, load_chain
from ..store.chain_schema import SECTIONS, with_usual_names
from ..store.toml_files import parse_toml, toml_key, toml_text

MAX_BEADS: Final = 2_000
# Keys that hold a path, such as that of a CSV file.
FILE_KEYS: Final = frozenset(
    key.name
    for section in SECTIONS.values()
    for key in (*section.keys, *(each for keys in section.variants.values() for each in keys))
    if key.kind == "file"
)


def chain_of(document: object) -> Chain:
    """Build the chain that a document of the page describes."""
    if not isinstance(document, Mapping):
        raise InputError("the request has no chain file; reload the page")
    if any(_files([document.get("chain")])):
        raise InputError(
            "a chain that is opened on the page cannot refer to files; start hertzchain app with "
            "the chain file"
        )
    _check_size(document.get("chain"))
    chain = chain_from(with_infinity(document))
    _check_beads(chain.beads)
    return chain


def _files(item: Any) -> Iterator[str]:
    """Keys that refer to files, at any depth."""
    if isinstance(item, Mapping):
        yield from FILE_KEYS.intersection(item)
    for value in item.values() if isinstance(item, Mapping) else item:
        if isinstance(value, Mapping | list | tuple):
            yield from _files(value)


def _check_size(table: Any) -> None:
    """Reject long chains before any array is allocated."""
    if not isinstance(table, Mapping):
        return
    cell = table.get("cell", table.get("cell_diameters"))
    cells = len(cell) if isinstance(cell, list) else 1
    counts = {"beads": 1, "cells": cells}
    for key, each in counts.items():
        if isinstance(table.get(key), int):
            _check_beads(table[key] * each)
    for name, key in (("decorated", "between"), ("struck_by", "count")):
        entries = table.get(name, [])
        for entry in entries if isinstance(entries, list) else [entries]:
            if isinstance(entry, Mapping) and isinstance(entry.get(key), int):
                _check_beads(entry[key])


def _check_beads(beads: int) -> None:
    if beads > MAX_BEADS:
        raise InputError(
            f"the app shows at most {MAX_BEADS} beads, got {beads}; use hertzchain simulate"
        )


def document_of_toml(text: str) -> dict[str, Any]:
    """Parse the text of a chain file that the page has opened."""
    document = parse_toml("this file", text)
    chain_of(document)
    return _of_chain(document)


def document_of_file(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a chain file on disk; data of files to which it refers are included."""
    chain = load_chain(path)
    _check_beads(chain.beads)
    if Path(path).suffix.lower() != ".csv":
        document = _of_chain(tomllib.loads(Path(path).read_text("utf-8-sig")))
        if not any(_files(document)):
            return document
    return document_of_chain(chain)


def _of_chain(document: Mapping[str, Any]) -> dict[str, Any]:
    """The tables that describe the chain, not those of a fit or a design."""
    document = with_usual_names(document)
    return as_json({name: document[name] for name in ("chain", "materials") if name in document})


def document_of_chain(chain: Chain) -> dict[str, Any]:
    """The chain as a document; raises `InputError` if the page cannot show it."""
    _check_beads(chain.beads)
    document = as_json(chain_document(chain))
    chain_of(document)
    return document


def document_as_toml(given: object) -> str:
    """Check a document, and write it as the text of a chain file."""
    chain_of(given)
    return checked_as_toml(given)


def checked_as_toml(given: object) -> str:
    """`document_as_toml` without its check."""
    document = with_infinity(given)
    lines = ["[chain]"]
    lines += [f"{toml_key(key)} = {toml_text(value)}" for key, value in document["chain"].items()]
    for name, entry in document.get("materials", {}).items():
        lines += ["", f"[materials.{toml_key(name)}]"]
        lines += [f"{toml_key(key)} = {toml_text(value)}" for key, value in entry.items()]
    return "\n".join(lines) + "\n"


def with_infinity(item: Any) -> Any:
    """The item with the number instead of the text "inf", which represents it in JSON."""
    if isinstance(item, Mapping):
        return {name: with_infinity(value) for name, value in item.items()}
    if isinstance(item, list):
        return [with_infinity(value) for value in item]
    return math.inf if item == "inf" else item


def as_json(item: Any) -> Any:
    """The item with text for infinite numbers."""
    if isinstance(item, Mapping):
        return {name: as_json(value) for name, value in item.items()}
    if isinstance(item, list):
        return [as_json(value) for value in item]
    if item == math.inf:
        return "inf"
    if isinstance(item, str | int) or (isinstance(item, float) and math.isfinite(item)):
        return item
    raise InputError(f"the app cannot show the value {item} of this chain file")
