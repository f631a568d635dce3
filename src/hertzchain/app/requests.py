"""Checked requests of the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from ..errors import InputError
from ..validation.numbers import number, whole_number
from ..validation.objects import check_bool, check_choice
from .documents import MAX_BEADS

MAX_FRAMES: Final = 600
MAX_SENSORS: Final = 4
MAX_KEY: Final = 64
SLOTS: Final = ("A", "B")
CLOCKS: Final = ("beads", "time")


@dataclass(frozen=True)
class Request:
    """A request for the results of one chain; its document is checked when it is read.

    ``sensors`` are numbers of balls, without the strikers: the same for both chains of a
    comparison.  The last striker is 0.  A run lasts at least until ``run_until``.  ``record`` is
    the key of a measured record, or empty.
    """

    session: str
    slot: str
    number: int
    document: object
    frames: int = 240
    rtol: float = 1e-9
    clock: str = "beads"
    sensors: tuple[int, ...] = ()
    draft: bool = False
    run: bool = True
    run_until: float = 0.0
    record: str = ""

    @classmethod
    def of(cls, given: object) -> Request:
        """Read a request from parsed JSON."""
        if not isinstance(given, Mapping):
            raise InputError("the request must be a JSON object")
        sensors = given.get("sensors", [])
        if not isinstance(sensors, list):
            raise InputError("sensors must be a list of numbers of balls")
        session = given.get("session")
        if not isinstance(session, str) or not 1 <= len(session) <= 64:
            raise InputError("the request has no session")
        return cls(
            session=session,
            slot=check_choice("slot", given.get("slot", "A"), SLOTS),
            number=whole_number("number of the request", given.get("number"), least=0, most=2**53),
            document=given.get("document"),
            frames=whole_number("frames", given.get("frames", 240), least=2, most=MAX_FRAMES),
            rtol=number("rtol", given.get("rtol", 1e-9), least=1e-13, most=1e-6),
            clock=check_choice("clock", given.get("clock", "beads"), CLOCKS),
            sensors=tuple(
                whole_number("sensor", each, least=-MAX_BEADS) for each in sensors[:MAX_SENSORS]
            ),
            draft=check_bool("draft", given.get("draft", False)),
            run=check_bool("run", given.get("run", True)),
            run_until=number("run until", given.get("run_until", 0.0), least=0.0),
            record=_record(given.get("record", "")),
        )

    @property
    def identity(self) -> dict[str, Any]:
        """Values by which the page recognises the answer."""
        return {"slot": self.slot, "number": self.number, "draft": self.draft}


def _record(given: object) -> str:
    if not isinstance(given, str) or len(given) > MAX_KEY:
        raise InputError("record must be the key of a measured record")
    return given
