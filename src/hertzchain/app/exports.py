"""Files that the page offers: chain file, Python script, tables, figures, saved page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.bead_names import walls_of
from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..propagation.propagate import propagate
from ..pulse.notes import OUT_OF_ORDER, out_of_order
from ..pulse.pulse import Pulse
from ..pulse.quantities import QUANTITIES
from ..recorded_warnings import record_warnings
from ..simulation.budget import Budget
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..theory.catalogue import THEORIES
from ..theory.effective_chain import effective_chain
from ..validation.numbers import number
from ..validation.objects import check_choice
from .body_curve import BODY
from .documents import chain_of, document_as_toml
from .force_curves import beads_of, run_for_forces
from .messages import Part
from .requests import SLOTS, Request
from .results import Stop, has_static_forces, limited, results
from .saved_page import saved_page
from .shown_run import motion
from .wording import title, without_advice

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS: Final[Mapping[str, str]] = {
    "svg": "image/svg+xml",
    "pdf": "application/pdf",
    "png": "image/png",
}
FIGURES: Final = ("chain", "pulse", "map", "forces", "budget")
EFFECTIVE: Final = "effective-chain"
SIMULATION: Final = "simulation"
FRAMES: Final = 400
RTOL: Final = 1e-9
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
    # Times of the page are those of its steps, with rounding errors.
    until = "" if end is None else f"until={number('until', end, above=0.0):.12g}, "
    lines += [f"run = hc.simulate(chain, {until}rtol=1e-9)"]
    exact = "hc.propagate(chain)" if _supported(chain) else "run.pulse()"
    lines += [f"pulse = {exact}", "print(run)", "print(pulse)"]
    lines += ['print(pulse.to_dataframe().to_string(float_format="{:.7g}".format))']
    lines += [f"print(run.wall_force({side!r}))" for side in walls_of(chain)]
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
    pulses = _pulses(chain, stop)
    units = {name: each.unit_in(chain.units) for name, each in QUANTITIES.items()}
    head = ["bead", "radius [m]" if not chain.scaled else "radius"]
    columns: list[Any] = [range(1, chain.beads + 1), chain.face_radii]
    for name, pulse in pulses.items():
        for quantity, values in pulse.columns().items():
            unit = "" if units[quantity] == "1" else f" [{units[quantity]}]"
            head.append(f"{quantity} ({name}){unit}")
            columns.append(np.concatenate([values, [np.nan] * (chain.beads - len(values))]))
    rows = (
        ",".join("" if value != value else repr(value) for value in row)
        for row in zip(*(np.asarray(each).tolist() for each in columns), strict=True)
    )
    lines = [",".join(head), *rows]
    known = [each.residence for each in pulses.values() if each.residence is not None]
    if any(map(out_of_order, known)):
        early = np.any([each < 0.0 for each in known], axis=0)
        notes = ["note", *(OUT_OF_ORDER if each else "" for each in early), ""]
        lines = [f"{line},{note}" for line, note in zip(lines, notes, strict=True)]
    text = "\n".join([*lines, ""])
    return Export("pulse.csv", "text/csv; charset=utf-8", text.encode())


def _forces(given: Mapping[str, Any], stop: Stop) -> Export:
    """Forces on walls, in sensors and on a free body at the times of the figure."""
    chain = chain_of(given.get("document"))
    sensors = _sensors(chain, given.get("sensors"))
    body = chain._free_cap
    places = [*sensors, *walls_of(chain).values(), *[chain.beads + 1] * body]
    if not places:
        raise InputError("the chain has no wall and no sensor; add one to save forces")
    exact, run = _simulated(chain, stop, end := _run_until(given))
    run, _ = run_for_forces(run or _run(chain, exact, stop, end), places, RTOL, limited(stop))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "forces.csv"
        walls = [f"{side} wall" for side in walls_of(chain)]
        run.save_forces(path, [*sensors, *walls, *[BODY] * body])
        return Export(path.name, "text/csv; charset=utf-8", path.read_bytes())


def _pulses(chain: Chain, stop: Stop) -> dict[str, Pulse]:
    """The simulated pulse and those of all theories that support the chain."""
    found = {SIMULATION: _simulated(chain, stop)[0]}
    for name, theory in THEORIES.items():
        try:
            found[name] = theory(chain)
        except InputError:
            continue
    return found


def _run_until(given: Mapping[str, Any]) -> float:
    """Time until which the run of the page lasts at least."""
    return number("run until", given.get("run_until", 0.0), least=0.0)


def _simulated(chain: Chain, stop: Stop, end: float = 0.0) -> tuple[Pulse, Run | None]:
    """The simulated pulse, and the run if `propagate` does not support the chain."""
    try:
        return propagate(chain), None
    except (InputError, SimulationError):
        run = _run(chain, None, stop, end)
        return run.pulse(), run


def _run(chain: Chain, exact: Pulse | None, stop: Stop, end: float) -> Run:
    """The run of the page at equally spaced times, until the peak on the wall is complete."""
    request = Request("figure", "A", 0, None, frames=FRAMES, rtol=RTOL, clock="time", run_until=end)
    progress = limited(stop)
    run, whole, _ = motion(chain, exact, request, progress)
    if whole is run:
        return run
    times = np.linspace(0.0, max(PAST_THE_END * whole.end_time, end), FRAMES)
    return simulate(chain, times=times, rtol=request.rtol, check=False, progress=progress)


def _figure(given: Mapping[str, Any], stop: Stop) -> Export:
    """A figure of the library, as SVG, PDF or PNG."""
    kind = check_choice("figure", given.get("figure"), FIGURES)
    form = check_choice("format", given.get("format", "svg"), FORMATS)
    quantity = check_choice("quantity", given.get("quantity", "velocity"), QUANTITIES)
    chain = chain_of(given.get("document"))
    curves: dict[str, Pulse] = {}
    run: Run | None = None
    if kind == "pulse":
        curves = _shown_curves(given, quantity, chain, _pulses(chain, stop), stop)
    elif kind != "chain":
        simulated, run = _simulated(chain, stop, end := _run_until(given))
        run = run or _run(chain, simulated, stop, end)
    if kind == "forces" and run is not None:
        places = _places(chain, given.get("sensors"))
        run, _ = run_for_forces(run, places, RTOL, limited(stop))
    with _figures:
        content = _draw(kind, form, quantity, chain, curves, run, given)
    return Export(f"{kind}.{form}", FORMATS[form], content)


def _view(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Choices of the views of the page: hidden curves, logarithmic axis, quantity of the map."""
    # The page sends them in the table from which a saved page begins.
    stored = given.get("view") or {}
    view = stored.get("view") or {} if isinstance(stored, Mapping) else None
    if not isinstance(view, Mapping):
        raise InputError("view must be a JSON object")
    return view


def _shown_curves(
    given: Mapping[str, Any], quantity: str, chain: Chain, pulses: Mapping[str, Pulse], stop: Stop
) -> dict[str, Pulse]:
    """The curves that the page shows, by the names in its legend."""
    hidden = _view(given).get("hidden", [])
    own, their = _letters(given)
    found = {own + title(name): each for name, each in pulses.items() if _key(name) not in hidden}
    if their and "other" not in hidden:
        other = chain_of(given["other"])
        if other.units == chain.units:
            simulated = {own + SIMULATION: found.pop(own + SIMULATION, None),
                         their + SIMULATION: _simulated(other, stop)[0]}  # fmt: skip
            # As on the page, chain A is the first.
            first = {name: each for name, each in sorted(simulated.items()) if each is not None}
            found = first | found
    found = {name: each for name, each in found.items() if each.column(quantity) is not None}
    if not found:
        raise InputError("the view of the leading pulse shows no curve; show one to save a figure")
    return found


def _letters(given: Mapping[str, Any]) -> tuple[str, str]:
    """Beginnings of the names of curves of the chain and of the other one, as in `views.js`."""
    if given.get("other") is None:
        return "", ""
    own = check_choice("slot", given.get("slot", "A"), SLOTS)
    return f"{own}, ", "B, " if own == "A" else "A, "


def _key(name: str) -> str:
    """Name of a pulse among the hidden curves of the page."""
    return "exact" if name == SIMULATION else name


def _draw(
    kind: str, form: str, quantity: str, chain: Chain, curves: Mapping[str, Pulse],
    run: Run | None, given: Mapping[str, Any],
) -> bytes:  # fmt: skip
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from .. import plotting
    from ..plotting.style import figure_bytes

    view = _view(given)
    with plotting.figure_style():
        if kind == "chain":
            axes = plotting.plot_chain(chain)
        elif kind == "pulse":
            axes = _pulse_axes(quantity, chain, curves, view, _letters(given))
        else:
            assert run is not None
            forces = view.get("map") == "forces"
            axes = {
                "map": lambda: plotting.plot_run(run, "force" if forces else "velocity"),
                "forces": lambda: plotting.plot_forces(run, _places(chain, given.get("sensors"))),
                "budget": lambda: plotting.plot_budget(_budget(run)),
            }[kind]()
    figure = axes.figure
    try:
        return figure_bytes(figure, form)  # type: ignore[arg-type]
    finally:
        plt.close(figure)  # type: ignore[arg-type]


def _budget(run: Run) -> Budget:
    """The budget as on the page."""
    budget = run.budget()
    return budget.over_static() if has_static_forces(run.chain) else budget


def _pulse_axes(
    quantity: str,
    chain: Chain,
    curves: Mapping[str, Pulse],
    view: Mapping[str, Any],
    letters: tuple[str, str] = ("", ""),
) -> Axes:
    """The curves of the leading pulse, and the large beads of a decorated chain."""
    from .. import plotting
    from ..plotting.differences import words_of_chains
    from ..plotting.legends import place_legend

    own, their = letters
    other = curves.get(their + SIMULATION) if their else None
    differ = other is not None and len({*map(tuple, words_of_chains([chain, other.chain]))}) > 1
    # The names of the page; for two chains, those of the library, which state the difference.
    axes = plotting.plot_pulses(
        [replace(each, method=name[len(own) :]) if differ else each
         for name, each in curves.items()],
        quantity, labels=None if differ else [*curves], log=bool(view.get("log")), legend=False,
    )  # fmt: skip
    if other is not None:
        _shift(axes, other.chain, chain.strikers - other.chain.strikers)
    if differ:
        _add_letters(axes, [*curves])
    if EFFECTIVE not in view.get("hidden", []) and quantity in ("velocity", "arrival"):
        with suppress(InputError):
            effective = effective_chain(chain).bca()
            axes.plot(
                effective.bead, getattr(effective, quantity), "k--", label=own + title(EFFECTIVE)
            )
    place_legend(axes, own=True)
    return axes


def _add_letters(axes: Axes, names: Sequence[str]) -> None:
    """Put the letters of two chains, with which the names begin, before their labels."""
    from matplotlib.lines import Line2D

    listed = [each for each in axes.get_legend_handles_labels()[0] if isinstance(each, Line2D)]
    curves = [line for line in listed if np.size(line.get_xdata())]
    letters = [name[: len("A, ")] for name in names]
    if not curves:
        # The first entries are those of the colours of the chains.
        letters = [*dict.fromkeys(letters)]
    for line, letter in zip(curves or listed, letters, strict=False):
        line.set_label(f"{letter}{line.get_label()}")


def _shift(axes: Axes, chain: Chain, beads: int) -> None:
    """Shift a curve and its symbol at a free end, so that the same balls are above each other."""
    from ..plotting.shared_axes import colour_of_chain

    colour = colour_of_chain(axes, chain)
    for line in axes.lines:
        if line.get_color() == colour:
            line.set_xdata(np.asarray(line.get_xdata()) + beads)
    axes.relim()
    axes.autoscale_view()


def _places(chain: Chain, sensors: Any) -> list[int]:
    """Beads with a sensor and walls, as `plot_forces` numbers them; at least one."""
    places = [*_sensors(chain, sensors), *walls_of(chain).values()]
    return places or [chain.beads // 2]


def _sensors(chain: Chain, sensors: Any) -> list[int]:
    """Beads of the chain with a sensor."""
    balls = sensors if isinstance(sensors, list) else []
    return beads_of(chain, [k for k in balls if type(k) is int])


def _page(given: Mapping[str, Any], stop: Stop) -> Export:
    """A page that contains its results and needs no server; its chains keep their letters."""
    if _letters(given)[0] == "B, ":
        stored = {**(given.get("view") or {}), "B": given.get("document")}
        given = {
            **given,
            "document": given["other"],
            "other": given.get("document"),
            "view": stored,
        }
    return Export("chain.html", "text/html; charset=utf-8", page_with_results(given, stop))


def page_with_results(
    given: Mapping[str, Any], stop: Stop, names: Mapping[str, str] | None = None
) -> bytes:
    """The saved page of one or two chains, which may have the names of their files."""
    raw, names, heading = b"", names or {}, ""
    documents = {"A": given.get("document"), "B": given.get("other")}
    for slot, document in documents.items():
        if slot == "B" and document is None:
            continue
        changes = {"session": "page", "number": 0, "draft": False, "run": True, "slot": slot}
        for part in results(Request.of({**given, **changes, "document": document}), stop):
            if part.header["part"] in ("error", "cancelled"):
                raise SimulationError(part.header.get("message", "the export was cancelled"))
            raw += _saved(part, names.get(slot)).pack()
            if slot == "A":
                heading = part.header.get("description", heading)
    file = f" – {names['A']}" if "A" in names else ""
    return saved_page(given, raw, heading + file)


def _saved(part: Part, name: str | None) -> Part:
    """A part of a saved page: with the name of the file, and without advice about choices."""
    header = dict(part.header)
    if name is not None and header["part"] == "beads":
        header["file"] = name
    if "warnings" in header:
        header["warnings"] = [without_advice(each) for each in header["warnings"]]
    return Part(header, part.arrays)


EXPORTS: Final[Mapping[str, Callable[[Mapping[str, Any], Stop], Export]]] = {
    "toml": _toml,
    "python": _python,
    "csv": _csv,
    "forces": _forces,
    "page": _page,
}
