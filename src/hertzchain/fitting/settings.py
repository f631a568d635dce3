"""Settings of a fit: free parameters, priors and starts, from arguments or a chain file."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import (
    InputError,
    InputWarning,
    errors_at,
    short_repr,
    unknown_name_error,
    warn_user,
)
from ..representation import counted
from ..store.chain_files import chain_from, load_chain
from ..store.toml_files import read_toml
from ..traces.places import place_named
from ..traces.signals import Clock
from ..traces.traces import Traces, with_coupling, with_time_offset
from ..validation.numbers import number
from ..validation.objects import check_list, file_path, shown_path
from .names import is_time_offset, parse_name
from .parameters import default_names
from .sensors import SENSOR_KINDS

# Reason of a time offset, in words.
OF_DRIVE: Final = "the start of the drive in the same file"
# Keys of the table [fit] of a chain file: values and meanings.
KEYS: Final[Mapping[str, tuple[str, str]]] = {
    "free": ("list of text", "names of the free parameters; by default, the stiffness, the "
             "velocity, the parameters of the loss, the time offset and the gains of sensors in V"),
    "prior": ("table", "for each name, a value and its standard deviation from other "
              "measurements, `[0.3, 0.003]` or with units"),
    "start": ("table", "for each name, the value from which the fit starts; that of the prior or "
              "of the chain if omitted"),
    "time_offset": ("number, text with a unit, or list", "known time of the data at which the "
                    "simulation begins, for all shots or for each; it is fixed unless "
                    "`time_offset` is in `free`, and the fit then starts from it"),
    "coupling": ("`AC`, `DC` or table", "whether the signals of all sensors, or by name, contain "
                 "the static force (`DC`); by default, this is decided by the level before the "
                 "pulse"),
}  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """Names of free parameters, priors and starts.

    Attributes
    ----------
    free : sequence of str or None
        Names; `None` for the default parameters.
    priors, start : mapping
        Values by name.
    optional : frozenset of str
        Names in priors and start that need not be free: those of a file whose ``free`` an argument
        replaces.
    coupling : str, mapping or None
        AC or DC coupling of all sensors, or by name.
    time_offset : float, str, sequence or None
        Known time offset of all shots, or of each.
    drive : tuple of str and Clock, or None
        File of a measured drive, and the time offset of traces in this file.
    """

    free: Sequence[str] | None = None
    priors: Mapping[str, Any] = field(default_factory=dict)
    start: Mapping[str, Any] = field(default_factory=dict)
    optional: frozenset[str] = frozenset()
    coupling: Any = None
    time_offset: Any = None
    drive: tuple[str, Clock] | None = None

    def updated(
        self, free: Sequence[str] | None, priors: Any, start: Mapping[str, float] | None,
        time_offset: object = None,
    ) -> Settings:  # fmt: skip
        """Settings in which arguments replace those of the file.

        A given time offset replaces the start of time offsets in the file.
        """
        for what, given in (("priors", priors), ("start", start)):
            if given is not None and not isinstance(given, Mapping):
                raise InputError(
                    f"{what} must be a mapping from names of parameters, got {short_repr(given)}"
                )
        given = {*(priors or {}), *(start or {})}
        own = {
            name: value for name, value in self.start.items()
            if time_offset is None or not is_time_offset(name)
        }  # fmt: skip
        return replace(
            self,
            free=self.free if free is None else free,
            priors={**self.priors, **(priors or {})},
            start={**own, **(start or {})},
            optional=frozenset(() if free is None else {*self.priors, *self.start} - given),
        )

    def with_more(self, more: Sequence[str] | None, traces: Traces, chain: Chain) -> Settings:
        """Settings with further free parameters."""
        if more is None:
            return self
        further = check_list("also_free", more, "names")
        usual = default_names(traces, chain) if self.free is None else self.free
        return replace(self, free=[*check_list("free", usual, "names"), *further])

    def timed(self, traces: Traces) -> Traces:
        """Traces with the given time offset, or with that of a drive in the same file."""
        if self.drive is not None:
            file, clock = self.drive
            traces = Traces(tuple(
                replace(shot, clock=clock) if file in shot.files else shot for shot in traces.shots
            ))  # fmt: skip
        return with_time_offset(traces, self.time_offset)


def for_sensors(settings: Settings, traces: Traces) -> Settings:
    """Settings of a chain file without priors and starts of sensors that the traces do not have.

    A file may describe all sensors of an experiment of which only some are fitted.
    """
    unused = [
        name for name in {**settings.priors, **settings.start} if _is_of_other_sensor(name, traces)
    ]
    for name in unused:
        warn_user(
            f"{name!r} of the chain file is not used: the traces have no such sensor", InputWarning
        )
    priors, start = (
        {name: value for name, value in given.items() if name not in unused}
        for given in (settings.priors, settings.start)
    )
    return replace(settings, priors=priors, start=start)


def _is_of_other_sensor(text: str, traces: Traces) -> bool:
    """Whether a parameter belongs to a sensor at a place without a signal."""
    try:
        name = parse_name(text)
        of_sensor = name.key in SENSOR_KINDS and name.item not in ("", "*", *traces.names)
        return of_sensor and place_named(name.item).name == name.item
    except InputError:
        return False  # Names of another form are reported with the free parameters.


def load_experiment(
    traces: Any, chain: Any, load_traces: Callable[..., Traces]
) -> tuple[Traces, tuple[Chain, ...], Settings]:
    """Traces, the chain of each shot, and the settings in the chain file."""
    settings = Settings()
    if isinstance(chain, str | os.PathLike):
        chain, settings = load_chain_and_settings(chain)
    if not isinstance(traces, Traces):
        paths = [traces] if isinstance(traces, str | os.PathLike) else traces
        if not isinstance(paths, list | tuple):
            raise InputError(
                f"traces must be the result of load_traces or paths of CSV files, got "
                f"{short_repr(traces)}"
            )
        traces = load_traces(*paths)
    shots = len(traces.shots)
    chains = (chain,) * shots if isinstance(chain, Chain) else chain
    if not isinstance(chains, list | tuple) or not all(isinstance(c, Chain) for c in chains):
        raise InputError(
            f"chain must be a Chain, a list with one for each shot, or a path, got "
            f"{short_repr(chain)}"
        )
    if len(chains) != shots:
        there = "is 1 shot" if shots == 1 else f"are {shots} shots"
        raise InputError(f"there {there}, but {counted(len(chains), 'chain')}; give one for each")
    for each in chains:
        if each.scaled:
            raise InputError(
                "traces are in SI units, but the chain is in scaled variables; build it with "
                "Chain.from_materials"
            )
    return settings.timed(with_coupling(traces, settings.coupling)), tuple(chains), settings


def load_chain_and_settings(path: str | os.PathLike[str]) -> tuple[Chain, Settings]:
    """Read a chain file that may have a table ``[fit]``."""
    file = file_path("chain file", path)
    if file.suffix.lower() == ".csv":
        return load_chain(path), Settings()
    document = read_toml("chain file", path, "give the path of a TOML or CSV file")
    table = document.pop("fit", {})
    with errors_at(shown_path(path)):
        chain = chain_from(document, file.parent)
        if not isinstance(table, Mapping):
            raise InputError(f"[fit] must be a table, got {short_repr(table)}")
        for key in table:
            if key not in KEYS:
                raise unknown_name_error("key of [fit]", key, KEYS)
        settings = Settings(
            coupling=table.get("coupling"),
            time_offset=table.get("time_offset"),
            drive=_clock_of_drive(document, file.parent),
        ).updated(table.get("free"), table.get("prior"), table.get("start"))
    return chain, settings


def _clock_of_drive(document: Mapping[str, Any], folder: Path) -> tuple[str, Clock] | None:
    """File of a measured drive, and the time offset of traces that were recorded with it."""
    drive = document.get("chain", {}).get("drive", {})
    if "file" not in drive:
        return None
    clock = Clock(number("start", drive.get("start", 0.0), unit="s"), OF_DRIVE)
    return os.path.realpath(folder / drive["file"]), clock
