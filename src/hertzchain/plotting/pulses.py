"""Plot quantities of pulses against the bead number."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from ..collision import Array
from ..errors import InputError, short_repr
from ..pulse.free_end import ends_free
from ..pulse.pulse import EFFECTIVE_CHAIN, Pulse, checked_pulse
from ..pulse.quantities import COLUMN_QUANTITIES
from ..validation.keywords import checked_arguments
from ..validation.objects import check_bool, check_choice, check_list
from .alternating_beads import HEAVY_BEADS, LIGHT_BEADS, light_beads
from .colours import curve_colour, free_numbers, grey, number_of_curves
from .differences import words_of_chains
from .free_ends import (
    CONTINUED,
    FREE_END,
    UNLISTED,
    draw_end_outside_limits,
    end_style,
    include_ends,
    label_free_end,
    open_style,
    unlist_hidden_ends,
)
from .labels import distinguish, numbered, with_assumed_yield
from .legends import place_legend
from .looks import Look, line_style, looks_of, share_colours
from .residuals import hidden_difference, relative_difference
from .shared_axes import label_quantities, note_curve, use_prefix
from .spreads import (
    BAND,
    draw_own_spread,
    draw_spread,
    draw_spread_of_difference,
    remove_values_beyond,
    show_band,
    spread_of,
)
from .style import (
    MARKERS,
    BeadLocator,
    figure_style,
    get_axes,
    get_two_axes,
    heighten_panel,
    literal,
    set_title,
    show_three_ticks,
    shrink_to_height,
)

# Largest number of ticks of a logarithmic axis of differences, and its lower end relative to the
# curve with the smallest differences: a change of sign would need an infinite axis.
RESIDUAL_TICKS: Final = 4
RESIDUAL_DEPTH: Final = 1e-4
# Part of the decades of this axis below its smallest value, which leaves room for a symbol.
MARGIN: Final = 0.08
# Letters in a line of the label of a low panel.
LABEL_LETTERS: Final = 16
# Lines of a name in it; a curve with a longer name is called the first one, also in the legend.
NAME_LINES: Final = 2
# The curve from which differences are, if its name is long.
FIRST: Final = "the first curve"
# Label of bands.
LOTS: Final = "± one standard deviation"


@checked_arguments("plot_pulses")
def plot_pulses(
    pulses: Pulse | Sequence[Pulse],
    quantity: str = "velocity",
    *,
    labels: Sequence[str] | None = None,
    log: bool = False,
    residuals: bool = False,
    legend: bool = True,
    ax: Axes | Sequence[Axes] | None = None,
) -> Axes:
    r"""Plot one quantity of several pulses against the bead number.

    By default a label names every property in which a pulse differs from the others (its method,
    taper, number of beads, loss law, impact speed, walls, ...); the title has the parts that all
    of them share.  Pulses without a difference are numbered.  For several chains and
    several methods, the colour of a curve shows its chain, its line and symbol show its method,
    and the legend has one entry for each of these.  If the last bead leaves a free end at a larger
    velocity, all values of this bead have symbols without a line: filled ones, or open ones of
    methods without this jump.  Where their residuals would hide those of the other beads, they
    are given as text.  In chains of alternating beads,
    heavy beads have filled symbols and light ones open symbols.  A shaded band shows the spread
    of a pulse by `disorder`: one standard deviation over random chains.  If the values of the first
    and the last bead would make this band thin, a linear axis shows those of the other beads.
    Beads whose values are beyond it, or beyond the limits of given axes (``ax.set_ylim``), are
    named at its edge.

    Parameters
    ----------
    pulses : Pulse or sequence of Pulse
        Pulses to compare, or one.
    quantity : str
        ``"velocity"``, ``"momentum"``, ``"energy"``, ``"arrival"``, ``"peak_force"`` or another
        name in ``columns()`` of the pulses, or ``"speed"``.
    labels : sequence of str, optional
        Labels in the legend, one per pulse; text between dollar signs is mathematics.
    log : bool
        Whether the y axis is logarithmic.
    residuals : bool
        Whether a panel below shows the relative differences from the first pulse,
        :math:`Q / Q_\mathrm{first} - 1`, at the beads that both have.  For several chains and
        methods, they are relative to the first pulse of the same chain.  If its name is too long
        for the panel, this names the first curve, as does the legend unless ``labels`` are given.
        If some differences would not be visible beside others, the panel has their sizes on a
        logarithmic axis.  For a single pulse whose spread is known, such as that of `disorder`, the
        panel shows the spread.
    legend : bool
        Whether to add a legend, which is above the axes if it would cover data inside them.  For
        a common legend of several axes, use ``figure.legend(*axes.get_legend_handles_labels())``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; with residuals a pair of axes, of which the second is for the residuals.
        By default, a new figure is created.  The colours are those that no curve in the axes
        has, as long as there are any.  If these have another quantity, the legend and the label
        of the y axis name both quantities.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the quantity; those of the residuals of a new figure are
        ``axes.figure.axes[1]``.

    Raises
    ------
    InputError
        If a method does not predict the quantity, the number of labels differs from that of the
        pulses, only some of the chains are in SI units, or there is nothing to compare with the
        first pulse.

    Examples
    --------
    >>> import hertzchain as hc
    >>> pulses = [hc.propagate(hc.Chain.tapered(ratio=r, beads=40)) for r in (0.5, 0.25)]
    >>> axes = hc.plot_pulses(pulses, "momentum", log=True)
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['$q$ = 0.0179319', '$q$ = 0.0361853', 'last bead (free end)']
    >>> axes.get_title()
    'propagation, forward-exponential, 40 beads'
    """
    pulses = _checked(pulses, quantity)
    log, residuals = check_bool("log", log), check_bool("residuals", residuals)
    legend = check_bool("legend", legend)
    words = _words(pulses)
    names, title = distinguish(words)
    names = [literal(name) for name in numbered(names)]
    if labels is not None:
        names = _given(labels, len(pulses))
    if residuals:
        _check_residuals(pulses, quantity)
    with figure_style():
        axes, lower = _axes(ax, residuals=residuals)
        present = number_of_curves(axes)
        remove_values_beyond(axes)
        two_kinds = any(light_beads(each, quantity) is not None for each in pulses)
        numbers = free_numbers(axes, present, len(pulses))
        looks = looks_of(words, numbers, own=not present, alternating=two_kinds)
        grouped = labels is None and share_colours(looks)
        reference = _reference(pulses, looks, str(names[0]))
        names = _marked(names, reference if residuals and labels is None else "")
        ends = _free_ends(pulses, quantity)
        for pulse, look, name in zip(pulses, looks, names, strict=True):
            values = pulse._predicted(quantity)
            free = len(values) in ends and pulse.chain.right_wall is None
            draw_spread(axes, pulse, quantity, curve_colour(axes, look.colour), free=free)
            if free:
                _draw_free_end(axes, pulse, quantity, look)
            label = None if grouped else str(name)
            line = _draw(axes, pulse, quantity, values[:-1] if free else values, look, label)
            note_curve(line, quantity, pulse.chain, label if labels is None else None)
        if grouped:
            _label_groups(axes, words, looks)
        _label_parts(axes, pulses, quantity, looks)
        label_quantities(axes)
        _set_scale(axes, log=log)
        lowest = axes if lower is None else lower
        if lower is not None:
            lower.set_xlabel(f"{COLUMN_QUANTITIES[quantity].per} $k$")
            axes.set_xlabel("")
        for each in {axes, lowest}:
            each.xaxis.set_major_locator(BeadLocator())
        if lower is not None:
            _draw_lower(lower, pulses, quantity, looks, reference)
            lower.set_xlim(axes.get_xlim())
        set_title(axes, literal(with_assumed_yield(title, [each.chain for each in pulses])))
        show_band(axes, pulses, quantity, keep=bool(present) or log)
        unlist_hidden_ends(axes)
        _finish(axes, lower, legend=legend, own=ax is None)
    return axes


def _check_residuals(pulses: Sequence[Pulse], quantity: str) -> None:
    """Require two pulses, or one with a spread."""
    if len(pulses) < 2 and spread_of(pulses[0], quantity) is None:
        raise InputError("residuals need at least two pulses: omit residuals")


def _draw_lower(
    lower: Axes, pulses: Sequence[Pulse], quantity: str, looks: Sequence[Look], reference: str
) -> None:
    """Draw the differences of several pulses, or the spread of one."""
    if len(pulses) > 1:
        _draw_residuals(lower, pulses, quantity, looks)
        _label_residuals(lower, reference)
        return
    colour, free = curve_colour(lower, looks[0].colour), bool(_free_ends(pulses, quantity))
    draw_own_spread(lower, pulses[0], quantity, colour, free=free)


def _finish(axes: Axes, lower: Axes | None, *, legend: bool, own: bool) -> None:
    """Add the legend, and make the label of a low panel fit beside it."""
    if lower is not None and own:
        heighten_panel(axes, lower)
    if legend:
        place_legend(axes, own=own)
    if lower is not None:
        shrink_to_height(lower)


def _checked(pulses: Pulse | Sequence[Pulse], quantity: str) -> list[Pulse]:
    given = [pulses] if isinstance(pulses, Pulse) else check_list("pulses", pulses, "pulses")
    checked = [checked_pulse("pulse", each) for each in given]
    if not checked:
        raise InputError("plot_pulses requires at least one pulse")
    if not isinstance(quantity, str):
        raise InputError(
            f"plot_pulses draws one quantity, such as 'velocity', got {short_repr(quantity)}; call "
            "it once for each, with ax=... to draw into the same figure"
        )
    check_choice("quantity", quantity, COLUMN_QUANTITIES)
    for pulse in checked:
        pulse._predicted(quantity)
    if len({pulse.chain.units for pulse in checked}) > 1:
        raise InputError(
            "pulses of scaled chains and of chains in SI units cannot share an axis; convert them "
            "with hc.Scales.of(chain).to_scaled(pulse)"
        )
    return checked


def _given(labels: Sequence[str], count: int) -> list[str]:
    names = check_list("labels", labels, "labels")
    if len(names) != count:
        raise InputError(f"there must be {count} labels, one per pulse, got {len(names)}")
    return names


def _words(pulses: Sequence[Pulse]) -> list[list[str]]:
    """Method and chain of each pulse, in parts that can be compared."""
    chains = words_of_chains([pulse.chain for pulse in pulses])
    return [[pulse.method, *words] for pulse, words in zip(pulses, chains, strict=True)]


def _free_ends(pulses: Sequence[Pulse], quantity: str) -> set[int]:
    """Numbers of values at whose end at least one of the pulses jumps."""
    return {len(each._predicted(quantity)) for each in pulses if ends_free(each, quantity)}


def _label_groups(axes: Axes, words: Sequence[Sequence[str]], looks: Sequence[Look]) -> None:
    """Entries of the legend for each chain, in its colour, and for each method, in grey."""
    chains = {look.colour: chain for (_, *chain), look in zip(words, looks, strict=True)}
    for colour, name in zip(chains, distinguish([*chains.values()])[0], strict=True):
        axes.plot([], [], color=curve_colour(axes, colour), label=literal(name))
    methods = {look: method for (method, *_), look in zip(words, looks, strict=True)}
    for look, name in {look.line: (look, name) for look, name in methods.items()}.values():
        axes.plot([], [], color=grey(axes, 0.4), **line_style(look), label=literal(name))


def _set_scale(axes: Axes, *, log: bool) -> None:
    axes.set_yscale("log" if log else "linear")
    use_prefix(axes)


def _axes(ax: Axes | Sequence[Axes] | None, *, residuals: bool) -> tuple[Axes, Axes | None]:
    return get_two_axes(ax) if residuals else (get_axes(ax), None)  # type: ignore[arg-type]


def _draw_free_end(axes: Axes, pulse: Pulse, quantity: str, look: Look) -> None:
    """A symbol, which no line joins to the other beads; filled if the pulse jumps there."""
    values, style = pulse._predicted(quantity), end_style(look.end, look.place)
    if not ends_free(pulse, quantity):
        style = {**open_style(look.marker), "label": CONTINUED}
    axes.plot([len(values)], values[-1:], color=curve_colour(axes, look.colour), **style)


def _label_parts(axes: Axes, pulses: Sequence[Pulse], quantity: str, looks: Sequence[Look]) -> None:
    """Labels of symbols at free ends, and of bands; that of a single band has its colour."""
    # Those of pulses that the axes already had move to the end of the legend.
    present = {artist.get_label(): artist for artist in (*axes.lines, *axes.collections)}
    for label in {LOTS, FREE_END, UNLISTED, HEAVY_BEADS, LIGHT_BEADS} & present.keys():
        present[label].remove()
    banded = {look.colour for pulse, look in zip(pulses, looks, strict=True)
              if spread_of(pulse, quantity) is not None}  # fmt: skip
    if LOTS in present or banded:
        single = len(banded) == 1 and LOTS not in present
        colour = curve_colour(axes, *banded) if single else grey(axes, 0.4)
        axes.fill_between([], [], [], color=colour, alpha=BAND, linewidth=0.0, label=LOTS)
    if LIGHT_BEADS in present or any(light_beads(each, quantity) is not None for each in pulses):
        style: dict[str, Any] = {
            "color": grey(axes, 0.4), "linestyle": "none", "marker": MARKERS[0],
        }  # fmt: skip
        axes.plot([], [], label=HEAVY_BEADS, **style)
        axes.plot([], [], label=LIGHT_BEADS, markerfacecolor="none", **style)
    if {FREE_END, UNLISTED} & present.keys() or any(ends_free(pulse, quantity) for pulse in pulses):
        label_free_end(axes)


def _draw(
    axes: Axes, pulse: Pulse, quantity: str, values: Array, look: Look, label: str | None
) -> Line2D:
    beads, numbers = pulse.chain.beads, pulse.bead[: len(values)]
    if pulse.method == EFFECTIVE_CHAIN:
        # Lines join the large beads.
        known = np.isfinite(values)
        beads, numbers, values = int(known.sum()), numbers[known], values[known]
        line = _draw_line(axes, numbers, values, beads, look, label)
        if look.alternating:
            # Large beads, whose symbols are filled in the other curves.
            line.set_markerfacecolor(line.get_color())
        return line
    if (light := light_beads(pulse, quantity)) is not None:
        # A line through all beads would be a zigzag.
        light, beads = light[: len(values)], beads // 2
        chosen = numbers[light], values[light]
        _draw_line(axes, *chosen, beads, look, None)
        line = _draw_line(axes, numbers[~light], values[~light], beads, look, label)
        line.set_markerfacecolor(line.get_color())
        return line
    return _draw_line(axes, numbers, values, beads, look, label)


def _draw_line(
    axes: Axes, numbers: Array, values: Array, beads: int, look: Look, label: str | None
) -> Line2D:
    (line,) = axes.plot(
        numbers,
        values,
        color=curve_colour(axes, look.colour),
        # Markers of different pulses at different beads do not hide each other.
        markevery=(look.place * max(1, beads // 60), max(look.spacing, beads // 20)),
        label=label,
        **line_style(look),
    )
    return line


def _draw_residuals(
    axes: Axes, pulses: Sequence[Pulse], quantity: str, looks: Sequence[Look]
) -> None:
    """Relative differences from the first pulse, of the same chain if colours are, in percent."""
    grouped = share_colours(looks)
    first: dict[int, Pulse] = {}
    differences = []
    for pulse, look in zip(pulses, looks, strict=True):
        reference = first.setdefault(look.colour if grouped else 0, pulse)
        if reference is not pulse:
            differences.append(
                (look, pulse, reference, relative_difference(pulse, reference, quantity))
            )
    inner = [
        values[: len(values) - (len(values) in _free_ends((reference, pulse), quantity))]
        for _, pulse, reference, values in differences
    ]
    least, ends = hidden_difference(inner), []
    if not least:
        axes.axhline(0.0, color=grey(axes, 0.6), linewidth=0.7)
    for look, pulse, reference, values in differences:
        # An exact zero, such as that of bead 1, has no place on a logarithmic axis.
        shown = np.where(values == 0.0, np.nan, np.abs(values)) if least else values
        free = len(shown) in _free_ends((reference, pulse), quantity)
        _draw(axes, pulse, quantity, shown[:-1] if free else shown, look, None)
        if free:
            colour = curve_colour(axes, look.colour)
            style = end_style(look.end) if ends_free(pulse, quantity) else open_style(look.marker)
            ends.append(draw_end_outside_limits(axes, len(shown), shown[-1], style, colour))
        if not least:
            draw_spread_of_difference(
                axes, pulse, quantity, shown, curve_colour(axes, look.colour), free=free
            )
    include_ends(axes, ends, linear=not least)
    if not least:
        show_three_ticks(axes)
    if least:
        axes.set_yscale("log")
        # By default, a low panel has two ticks.
        axes.yaxis.set_major_locator(LogLocator(numticks=RESIDUAL_TICKS))
        sizes = np.abs(np.concatenate([values for *_, values in differences]))
        smallest = float(np.nanmin(sizes, where=sizes > 0.0, initial=least))
        bottom = max(smallest, RESIDUAL_DEPTH * least)
        decades = max(float(np.nanmax(sizes)) / bottom, 2.0)
        axes.set_ylim(bottom=bottom / decades**MARGIN)
        _hide_cut_symbols(axes, bottom)


def _hide_cut_symbols(axes: Axes, bottom: float) -> None:
    """Omit symbols of points below an axis, of which the edge would show a part."""
    for line in axes.lines:
        every = line.get_markevery()
        if isinstance(every, tuple):
            values = np.asarray(line.get_ydata(), dtype=float)
            marked = np.arange(len(values))[every[0] :: every[1]]
            line.set_markevery(marked[values[marked] >= bottom].tolist())


def _label_residuals(axes: Axes, reference: str) -> None:
    """Name the curve from which the differences are."""
    sign = "|difference|" if axes.get_yscale() == "log" else "difference"
    label = textwrap.fill(f"{sign} from {_with_units(reference)} [%]", LABEL_LETTERS)
    axes.set_ylabel(label.replace("\u00a0", " "))


def _with_units(name: str) -> str:
    """A name in which no line begins with a unit."""
    return re.sub(r"(?<=\d) (?=[^\W\d])", "\u00a0", name)


def _marked(names: Sequence[str], reference: str) -> list[str]:
    """Names of the curves, of which the first is marked if differences are from it."""
    return [f"{names[0]} ({FIRST})" if reference == FIRST else names[0], *names[1:]]


def _reference(pulses: Sequence[Pulse], looks: Sequence[Look], name: str) -> str:
    """Name of the curve from which differences are, or a short one instead of a long name."""
    if share_colours(looks):
        first: dict[int, str] = {}
        for pulse, look in zip(pulses, looks, strict=True):
            first.setdefault(look.colour, pulse.method)
        if len({*first.values()}) > 1:
            return "the first curve of each chain"
        name = literal(pulses[0].method)
    lines = textwrap.wrap(_with_units(name), LABEL_LETTERS, break_long_words=False)
    short = len(lines) <= NAME_LINES and max(map(len, lines), default=0) <= LABEL_LETTERS
    return name if name and short else FIRST
