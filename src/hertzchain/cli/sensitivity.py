"""The command `sensitivity`: how much a quantity depends on each bead."""

from __future__ import annotations

from math import isinf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import (
    StrictCommand,
    figure_option,
    json_option,
    measure_from,
    quantity_option,
    time_from,
    until_option,
)
from .output import save_figure, show_json, show_table
from .progress import progress_bar
from .pulse_tables import TABLE_ROWS
from .wording import on_command_line
from .wrapped_text import show_text

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.chain import Chain
    from ..collision import Array
    from ..derivatives.result import Gradient
    from ..designs.measures import Measure
    from ..simulation.yielding import WithYield

BY: Final = ("radii", "masses", "stiffness", "velocities", "young", "density",
             "yield_strength", "gaps")  # fmt: skip
OF_MATERIALS: Final = ("young", "density", "yield_strength")
OF_CONTACTS: Final = ("stiffness", "gaps")


@click.command(cls=StrictCommand)
@chain_options
@quantity_option
@click.option(
    "--to",
    "by",
    type=click.Choice(BY),
    default="radii",
    show_default=True,
    help="The parameter that changes, of one bead or contact after the other.",
)
@until_option
@click.option("--all", "every_bead", is_flag=True, help="Show every bead in the table.")
@json_option()
@figure_option("Plot the relative changes to FILE.")
def sensitivity(
    options: ChainOptions, quantity: str | None, by: str, until: str | None, every_bead: bool,
    as_json: bool, plot: Path | None,
) -> None:  # fmt: skip
    """Show which beads a quantity depends on.

    The table states by how many percent the quantity changes if the radius (or another parameter)
    of one bead changes by 1%.  The largest changes are first.  The changes of the peak force on the
    wall are simulated, for +1% and -1%.  Those of other quantities follow from derivatives, which
    are exact or, with losses such as elastic-plastic, computed from differences of simulations.
    With such a loss, --to yield_strength also changes the assumed yield pressure.  With --to gaps,
    one gap after the other grows by 1 um (in scaled variables, by 0.01); any loss is possible.

    \b
    Examples:
      hertzchain sensitivity --material steel-52100 --diameter "20 mm:8 mm" --beads 20 \\
          --speed "0.1 m/s" --wall same
      hertzchain sensitivity chain.toml --quantity arrival@last --to masses --plot arrival.png
    """
    import hertzchain

    from ..designs.exact_gradients import name_of
    from ..designs.sensitivity import (
        changes_by_gaps,
        changes_of_peak,
        end_of_run,
        gradient_by_gaps,
    )
    from ..designs.yielding import value_if_yielding
    from ..errors import InputError

    chain = chain_from(options)
    measure = measure_from(quantity, chain)
    name = name_of(measure, chain.beads)
    if name is None:
        raise InputError(f"{measure} has no derivatives; use wall_force.peak, body_force.peak or "
                         "velocity@last")  # fmt: skip
    given = time_from("--until", until, chain)
    end = end_of_run(chain, measure, given)
    with progress_bar("chains simulated") as progress:
        changes: tuple[Array, ...] | None
        if by == "gaps":
            found = gradient_by_gaps(chain, name, end, progress)
            changes = changes_by_gaps(chain, measure, end, progress)
        else:
            found = hertzchain.gradient(chain, name, to=by, until=end, progress=progress)
            changes = changes_of_peak(chain, found, by, end, progress)
    yielding = value_if_yielding(chain, measure, until=given)
    notes = [*_notes(found, measure, by, changes), *map(on_command_line, _on_walls(chain, end))]
    if plot is not None:
        from ..plotting.gradients import plot_gradient

        save_figure(plot_gradient(found, by, changes=changes), plot)
    if as_json:
        show_json(_document(found, yielding, by, changes) | {"notes": notes})
    else:
        lines = _lines(found, measure, yielding, by, changes)
        show_text("\n".join(lines + [f"note: {note}" for note in notes]))
        show_table(_table(chain, found, by, changes, every_bead))


def _document(
    found: Gradient, yielding: WithYield, by: str, changes: tuple[Array, ...] | None
) -> dict[str, Any]:  # fmt: skip
    from ..validation.json_types import finite

    document: dict[str, Any] = {
        "quantity": found.quantity,
        "value": found.value,
        "unit": found.unit,
        "value_with_yielding_contacts": finite(yielding.value),
        "yielding_overlap_ratio": finite(yielding.overlap_ratio),
        "yielding_within_range": None if isnan(yielding.value) else not yielding.outside,
        "parameter": by,
        "gradient": finite(found[by].tolist()),
        "gradient_unit": found.units[by],
        "relative": finite(found.relative(by).tolist()),
        "method": found.method,
        "error": finite(found.error),
        "kinks": by in found.kinks,
    }
    if changes:
        for key, values in zip(("larger", "smaller"), changes, strict=False):
            document[f"change_if_{key}"] = finite(values.tolist())
    return document


def _on_walls(chain: Chain, until: float | None) -> tuple[str, ...]:
    """Notes on walls whose spring is too stiff, from a simulation of the unchanged chain."""
    from ..chain.hertz_ratios import linear_springs
    from ..errors import IncompleteWarning, ModelRangeWarning
    from ..recorded_warnings import ignore_warnings
    from ..simulation.simulate import simulate

    if chain.units != "SI" or not linear_springs(chain)[[0, -1]].any():
        return ()
    with ignore_warnings(IncompleteWarning, ModelRangeWarning):
        return simulate(chain, times=0, until=until).notes


def _lines(
    found: Gradient, measure: Measure, yielding: WithYield, by: str,
    changes: tuple[Array, ...] | None,
) -> list[str]:  # fmt: skip
    """The chain, the value, and the method of the derivatives or changes."""
    import numpy as np

    from ..designs.measures import in_words
    from ..designs.sensitivity import GAP_STEP
    from ..designs.yielding import yielding_note

    chain = found._chain
    assert chain is not None
    lines = [chain.description, f"{measure} = {in_words(found.value, found.unit, chain.units)}"]
    if not isnan(yielding.value):
        lines[1] += " with elastic contacts, to which all changes refer"
        note = yielding_note("it", measure, found.value, yielding)
        lines.append(f"  {note} (--loss elastic-plastic)")
    if found.method == "central differences":
        first = "each change by 1% is simulated; derivatives (--json)" if changes else "derivatives"
        lines.append(
            f"{first} are {found.method} of simulations, with an estimated error of "
            f"{found.error:.1g} of the largest one"
        )
    if by in OF_MATERIALS:
        together = float(np.nansum(found.relative(by)))
        lines.append(f"all beads together: {together:+.4f}% per 1%")
    if by == "gaps":
        step = f"One gap at a time is {GAP_STEP[chain.units][1]} larger."
        lines.append(
            f"{step} Derivatives (--json) at closed gaps are\none-sided, and hold only for gaps "
            "much smaller than the overlaps."
            if found.method == "adjoint"
            else f"{step} This loss has no derivatives by gaps."
        )
    return lines


def _notes(
    found: Gradient, measure: Measure, by: str, changes: tuple[Array, ...] | None
) -> list[str]:  # fmt: skip
    """Remarks on the value and its changes, for the table and for JSON."""
    from ..chain.yield_pressure import assumed_for_all
    from ..derivatives.kinks import kink_note
    from ..designs.measures import notes_on
    from ..designs.sensitivity import derivatives_mislead

    assert found._chain is not None
    notes = notes_on(found._chain, [measure])
    if by != "gaps" and changes and derivatives_mislead(found, by, *changes):
        several = "changes of several beads do not add up: use hertzchain scatter"
        notes.append(f"{kink_note([by])}; {several}")
    if assumed := assumed_for_all(found._chain):
        notes.append(on_command_line(assumed))
        if by != "yield_strength":
            notes.append("--to yield_strength shows the dependence on the yield pressure")
    return notes


def _table(
    chain: Chain, found: Gradient, by: str, changes: tuple[Array, ...] | None, every_bead: bool
) -> Table:
    """Changes of the quantity, and the derivative where it is the same in both directions."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    from ..designs.sensitivity import GAP_STEP
    from ..representation import in_column

    absolute = found[by]
    shown = {"% per 1%": found.relative(by)}
    if changes:
        steps = ("+1%", "-1%") if by != "gaps" else (f"+{GAP_STEP[chain.units][1]}",)
        shown = {f"% for {step}": 100.0 * each for step, each in zip(steps, changes, strict=True)}
    rows = _by_influence([*shown.values()], absolute)
    total = len(rows)
    rows = rows if every_bead else rows[:TABLE_ROWS]
    few = f"the {len(rows)} largest of {total}; --all shows every one"
    table = Table(box=box.SIMPLE_HEAD, caption=None if len(rows) == total else few)
    unit = f" [{found.units[by]}]" if found.units[by] else ""
    of_beads = by not in OF_CONTACTS
    columns = ["bead k" if of_beads else "contact k"]
    columns += ["diameter [mm]"] if of_beads and chain.units == "SI" else []
    columns += [*shown, *([] if changes else [f"derivative by {by}{unit}"])]
    for column in columns:
        table.add_column(escape(column), justify="right", no_wrap=True)
    sizes = in_column([2e3 * chain.face_radii[i] for i in rows], 5) if of_beads else []
    derivatives = in_column([absolute[i] for i in rows], 5)
    for place, i in enumerate(rows):
        cells = [_place(chain, i) if of_beads else f"{i + 1}"]
        if of_beads and chain.units == "SI":
            cells.append("flat" if isinf(chain.face_radii[i]) else sizes[place])
        cells += ["-" if isnan(each[i]) else f"{each[i]:+.4f}" for each in shown.values()]
        table.add_row(*cells, *([] if changes else [derivatives[place]]))
    return table


def _place(chain: Chain, i: int) -> str:
    """Number of a bead, the name of a cap, and behind strikers that of the ball."""
    if chain.cap is not None and i + 1 == chain.beads:
        return f"{i + 1} (cap)"
    if not chain.strikers:
        return f"{i + 1}"
    return (
        f"{i + 1} (striker)" if i < chain.strikers else f"{i + 1} (ball {i + 1 - chain.strikers})"
    )


def _by_influence(changes: list[Array], derivatives: Array) -> list[int]:
    """Indices in the order of the larger change; derivatives decide between beads without any."""
    import numpy as np

    largest = np.max(np.nan_to_num(np.abs(changes)), axis=0)
    return [int(i) for i in np.lexsort((-np.abs(derivatives), -largest))]
