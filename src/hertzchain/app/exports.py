"""Files that the page offers: chain file, Python script, tables, figures, saved page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..propagation.propagate import propagate
from ..pulse.pulse import Pulse
from ..pulse.quantities import QUANTITIES
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..sweeps.methods import record_warnings
from ..theory.catalogue import THEORIES
from ..validation.numbers import number
from ..validation.objects import check_choice
from .documents import chain_of, document_as_toml
from .requests import Request
from .results import Stop, limited, motion, results
from .saved_page import saved_page

FORMATS: Final[Mapping[str, str]] = {
    "svg": "image/svg+xml",
    "pdf": "application/pdf",
    "png": "image/png",
}
FIGURES: Final = ("chain", "pulse", "map", "forces", "budget")
FRAMES: Final = 400
# A figure ends a little after the time at which the peak on the wall is known to be complete.
PAST_THE_END: Final = 1.01

# Matplotlib's list of open figures belongs to the whole process.
_figures = threading.Lock()


@dataclass(frozen=True)
class Export:
    """A file: name, media type and content."""

    name: str
    media_type: str
    content: bytes


def export(given: Mapping[str, Any], stop: Stop) -> Export:
    """The file that a request of the page describes."""
    kind = check_choice("kind of export", given.get("kind"), (*EXPORTS, "figure"))
    with record_warnings():
        if kind == "figure":
            return _figure(given, stop)
        return EXPORTS[kind](given, stop)


def _toml(given: Mapping[str, Any], _: Stop) -> Export:
    text = document_as_toml(given.get("document"))
    return Export("chain.toml", "application/toml", text.encode())


def _python(given: Mapping[str, Any], _: Stop) -> Export:
    """A script that computes the numbers of the page."""
    chain = chain_of(given.get("document"))
    text = document_as_toml(given.get("document"))
    literal = "'''" if "'''" not in text and "\\" not in text else None
    source = f"{literal}\\\n{text}{literal}" if literal else repr(text)
    lines = [
        f'"""{chain.description.replace(chr(34), chr(39))}."""'.replace("\\", "/"),
        "", "import tempfile", "from pathlib import Path", "", "import hertzchain as hc", "",
        f"CHAIN = {source}", "", "with tempfile.TemporaryDirectory() as folder:",
        '    file = Path(folder) / "chain.toml"', '    file.write_text(CHAIN, "utf-8")',
        "    chain = hc.load_chain(file)",
    ]  # fmt: skip
    end = given.get("until")
    until = "" if end is None else f"until={number('until', end, above=0.0)!r}, "
    lines += [f"run = hc.simulate(chain, {until}rtol=1e-9)"]
    exact = "hc.propagate(chain)" if _supported(chain) else "run.pulse()"
    lines += [f"pulse = {exact}", "print(pulse)"]
    lines += ["print(run.wall_force())"] if chain.right_wall is not None else []
    lines += [f"print(run.sensor_force({k}))" for k in _sensors(chain, given.get("sensors"))]
    lines += [""]
    return Export("chain.py", "text/x-python", "\n".join(lines).encode())


def _supported(chain: Chain) -> bool:
    """Whether `propagate` supports the chain."""
    try:
        propagate(chain)
    except (InputError, SimulationError):
        return False
    return True


def _csv(given: Mapping[str, Any], stop: Stop) -> Export:
    """All pulses, one row per bead, with all digits."""
    chain = chain_of(given.get("document"))
    pulses, _ = _pulses(chain, stop)
    unit = {each: f" [{QUANTITIES[each].unit}]" if not chain.scaled else "" for each in QUANTITIES}
    head = ["bead", "radius [m]" if not chain.scaled else "radius"]
    columns: list[Any] = [range(1, chain.beads + 1), chain.radii]
    for name, pulse in pulses.items():
        for quantity, values in pulse.columns().items():
            head.append(f"{quantity} ({name}){unit[quantity]}")
            columns.append(np.concatenate([values, [np.nan] * (chain.beads - len(values))]))
    rows = (
        ",".join("" if value != value else repr(value) for value in row)
        for row in zip(*(np.asarray(each).tolist() for each in columns), strict=True)
    )
    text = "\n".join([",".join(head), *rows, ""])
    return Export("pulse.csv", "text/csv; charset=utf-8", text.encode())


def _pulses(chain: Chain, stop: Stop) -> tuple[dict[str, Pulse], Run | None]:
    """The simulated pulse and those of all theories that support the chain."""
    found: dict[str, Pulse] = {}
    run = None
    try:
        found["simulation"] = propagate(chain)
    except (InputError, SimulationError):
        run = _run(chain, None, stop)
        found["simulation"] = run.pulse()
    for name, theory in THEORIES.items():
        try:
            found[name] = theory(chain)
        except InputError:
            continue
    return found, run


def _run(chain: Chain, exact: Pulse | None, stop: Stop) -> Run:
    """The run of the page at equally spaced times, until the peak on the wall is complete."""
    request = Request("figure", "A", 0, None, frames=FRAMES, clock="time")
    progress = limited(stop)
    run, whole, _ = motion(chain, exact, request, progress)
    if whole is run:
        return run
    times = np.linspace(0.0, PAST_THE_END * whole.end_time, FRAMES)
    return simulate(chain, times=times, rtol=request.rtol, check=False, progress=progress)


def _figure(given: Mapping[str, Any], stop: Stop) -> Export:
    """A figure of the library, as SVG, PDF or PNG."""
    kind = check_choice("figure", given.get("figure"), FIGURES)
    form = check_choice("format", given.get("format", "svg"), FORMATS)
    quantity = check_choice("quantity", given.get("quantity", "velocity"), QUANTITIES)
    chain = chain_of(given.get("document"))
    pulses, run = (
        _pulses(chain, stop) if kind in ("pulse", "map", "forces", "budget") else ({}, None)
    )
    if kind in ("map", "forces", "budget") and run is None:
        run = _run(chain, pulses["simulation"], stop)
    with _figures:
        content = _draw(kind, form, quantity, chain, pulses, run, given.get("sensors", []))
    return Export(f"{kind}.{form}", FORMATS[form], content)


def _draw(
    kind: str, form: str, quantity: str, chain: Chain, pulses: Mapping[str, Pulse],
    run: Run | None, sensors: Any,
) -> bytes:  # fmt: skip
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from .. import plotting
    from ..plotting.style import figure_bytes

    with plotting.figure_style():
        if kind == "chain":
            axes = plotting.plot_chain(chain)
        elif kind == "pulse":
            shown = [each for each in pulses.values() if each.column(quantity) is not None]
            axes = plotting.plot_pulses(shown, quantity)
        else:
            assert run is not None
            axes = {
                "map": lambda: plotting.plot_run(run),
                "forces": lambda: plotting.plot_forces(run, _places(chain, sensors)),
                "budget": lambda: plotting.plot_budget(run.budget()),
            }[kind]()
    figure = axes.figure
    try:
        return figure_bytes(figure, form)  # type: ignore[arg-type]
    finally:
        plt.close(figure)  # type: ignore[arg-type]


def _places(chain: Chain, sensors: Any) -> list[int]:
    """Beads with a sensor and walls, as `plot_forces` numbers them; at least one."""
    places = _sensors(chain, sensors)
    places += [0] if chain.left_wall is not None else []
    places += [chain.beads + 1] if chain.right_wall is not None else []
    return places or [chain.beads // 2]


def _sensors(chain: Chain, sensors: Any) -> list[int]:
    """Beads of the chain with a sensor."""
    beads = sensors if isinstance(sensors, list) else []
    return [k for k in beads if type(k) is int and 1 <= k <= chain.beads]


def _page(given: Mapping[str, Any], stop: Stop) -> Export:
    """A page that contains its results and needs no server."""
    raw = b""
    documents = {"A": given.get("document"), "B": given.get("other")}
    for slot, document in documents.items():
        if slot == "B" and document is None:
            continue
        changes = {"session": "page", "number": 0, "draft": False, "run": True, "slot": slot}
        for part in results(Request.of({**given, **changes, "document": document}), stop):
            if part.header["part"] in ("error", "cancelled"):
                raise SimulationError(part.header.get("message", "the export was cancelled"))
            raw += part.pack()
    return Export("chain.html", "text/html; charset=utf-8", saved_page(given, raw))


EXPORTS: Final[Mapping[str, Callable[[Mapping[str, Any], Stop], Export]]] = {
    "toml": _toml,
    "python": _python,
    "csv": _csv,
    "page": _page,
}
