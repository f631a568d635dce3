"""Measured records that pages show over the simulated forces."""

from __future__ import annotations

import os
import tempfile
import threading
import uuid
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ..errors import InputError
from ..recorded_warnings import ignore_warnings
from ..traces.files import load_traces
from ..traces.traces import Traces

# Size of a file [bytes], and number of records that the server keeps.
MAX_FILE: Final = 20_000_000
MAX_RECORDS: Final = 8


@dataclass(frozen=True)
class Record:
    """One shot of a file, and a sentence about the others."""

    name: str
    traces: Traces
    note: str = ""

    @property
    def balls(self) -> list[int]:
        """Balls with a sensor of the force, without the strikers; the page has sensors in them."""
        places = [signal.place for signal in self.traces.shots[0].signals]
        return [each.number for each in places if (each.body, each.quantity) == ("ball", "force")]


_KEPT: OrderedDict[str, Record] = OrderedDict()
_LOCK: Final = threading.Lock()


def record_of_file(path: str | os.PathLike[str], sensors: Mapping[str, str] | None) -> Record:
    """Read the first shot of a CSV file."""
    with ignore_warnings():
        traces = load_traces(path, sensors=sensors)
    count = len(traces.shots)
    note = f"the first of {count} shots of the file is shown" if count > 1 else ""
    return Record(Path(path).name, Traces(traces.shots[:1]), note)


def keep(record: Record) -> dict[str, Any]:
    """Keep a record; return what the page needs to request it."""
    key = uuid.uuid4().hex
    with _LOCK:
        _KEPT[key] = record
        while len(_KEPT) > MAX_RECORDS:
            _KEPT.popitem(last=False)
    return {"record": key, "name": record.name, "balls": record.balls}


def kept(key: str) -> Record:
    """A record that was kept."""
    with _LOCK:
        found = _KEPT.get(key)
    if found is None:
        raise InputError("the server no longer has the measured data; choose the file again")
    return found


def read_record(given: Any) -> dict[str, Any]:
    """Read and keep a file that the page has opened: its name, text, and places of sensors."""
    texts = given if isinstance(given, Mapping) else {}
    name, text, places = (texts.get(each, "") for each in ("name", "text", "sensors"))
    if not all(isinstance(each, str) for each in (name, text, places)):
        raise InputError("the request must have the name, the text and the sensors of a record")
    # The name is used in messages, which name the file.
    name = Path(name.replace("\\", "/")).name or "record.csv"
    if not name.lower().endswith((".csv", ".txt", ".tsv", ".dat")):
        raise InputError(
            f"{name} is not a CSV file; choose a file of an oscilloscope, such as .csv"
        )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / name
        file.write_text(text, "utf-8")
        try:
            return keep(record_of_file(file, places_in(places)))
        except InputError as error:
            raise InputError(_on_the_page(str(error), folder)) from None


def places_in(text: str) -> dict[str, str] | None:
    """Places of sensors by their columns, from a text such as ``CH1=ball 6, CH2=wall``."""
    found: dict[str, str] = {}
    for part in filter(None, map(str.strip, text.replace(";", ",").split(","))):
        column, _, place = map(str.strip, part.partition("="))
        if not column or not place:
            raise InputError(f"{part!r} names no column and place; write it as in CH1=wall")
        found[column] = place
    return found or None


def _on_the_page(message: str, folder: str) -> str:
    """A message without the temporary folder and with the field of the page."""
    message = message.replace(f"{folder}{os.sep}", "").replace(folder, "")
    head, found, rest = message.partition("give load_traces sensors={")
    if found:
        place, _, more = rest.partition("}")
        column, _, where = place.replace("'", "").partition(": ")
        message = f"{head}enter {column}={where} as the sensors{more}"
    return message
