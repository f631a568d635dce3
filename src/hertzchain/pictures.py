"""Pictures of runs: force traces, budgets, the chain to scale, an animation of the beads.

Every function takes data and optional axes, and returns the axes.  What is in SI units is
drawn in microseconds, newtons and millimetres.
"""

from __future__ import annotations

import io
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, PatchCollection
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter

from hertzchain.budget import BALANCED, Balanced, Budget
from hertzchain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.errors import InputError, unknown_name
from hertzchain.plotting import COLOURS, house_style
from hertzchain.run import Run
from hertzchain.store import write_bytes

# Where energy and momentum are, from light to dark as they are lost to the pulse.
PARTS: Final[dict[str, tuple[str, str]]] = {
    "leading pulse": ("#0072B2", ""),
    "lagging": ("#56B4E9", ""),
    "scattered back": ("#E69F00", "//"),
    "contacts": ("#BBBBBB", ""),
    "walls": ("#777777", ""),
    "left wall": ("#999999", "\\\\"),
    "right wall": ("#777777", ""),
    "lost": ("#D55E00", ".."),
}
TICK: Final = {"energy": ("energy", "J"), "momentum": ("momentum", "N s")}


def time_axis(chain: Chain) -> tuple[float, str]:
    """Factor and label of times: microseconds for a chain in SI units.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    tuple of float and str

    Examples
    --------
    >>> time_axis(Chain.uniform(2))
    (1.0, 'time $t$')
    """
    return (1e6, "time [µs]") if chain.units == "SI" else (1.0, "time $t$")


def plot_forces(run: Run, beads: Sequence[int], *, ax: Axes | None = None) -> Axes:
    """Draw what sensors in some beads, and on the walls, show in time.

    Parameters
    ----------
    run : Run
        A run with saved times.
    beads : sequence of int
        Numbers of the beads with a sensor; N + 1 is the right wall, 0 the left one.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> axes = plot_forces(hc.simulate(chain, until=30.0), [5, 10, 21])
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['bead 5', 'bead 10', 'right wall']
    """
    _check_times(run)
    factor, label = time_axis(run.chain)
    walls = {0: "left", run.chain.beads + 1: "right"}
    with house_style():
        axes = ax if ax is not None else plt.subplots()[1]
        for i, k in enumerate(beads):
            wall = walls.get(k)
            force = run.wall_force(wall).force if wall else run.sensor(k)  # type: ignore[arg-type]
            axes.plot(
                factor * run.times,
                force,
                color=COLOURS[i % len(COLOURS)],
                linestyle=("-", "--", "-.", ":")[i // len(COLOURS) % 4],
                label=f"{wall} wall" if wall else f"bead {k}",
            )
        axes.set_xlabel(label)
        axes.set_ylabel("force [N]" if run.chain.units == "SI" else "force $F$")
        axes.set_title(run.chain.description)
        axes.margins(x=0.0)
        axes.legend()
    return axes


def plot_budget(budget: Budget, of: Balanced = "energy", *, ax: Axes | None = None) -> Axes:
    """Draw where energy or momentum is over time, stacked; momentum backwards below zero.

    Parameters
    ----------
    budget : Budget
        Of a run with at least two saved times.
    of : str
        ``"energy"`` or ``"momentum"``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        For another word, or a single time.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = plot_budget(hc.simulate(hc.Chain.uniform(9)).budget(), "momentum")
    >>> axes.get_ylabel()
    'momentum'
    """
    if of not in BALANCED:
        raise unknown_name("balance", of, BALANCED)
    if len(budget.times) < 2:
        raise InputError("a stacked plot needs at least 2 saved times, the run has 1")
    there = budget.energy if of == "energy" else budget.momentum
    given = budget.energy_given if of == "energy" else budget.momentum_given
    shown = {name: values for name, values in there.items() if np.abs(values).max() > 0.0}
    factor, label = time_axis(budget.chain)
    times, total = factor * budget.times, np.sum([*given.values()], axis=0)
    with house_style():
        axes = ax if ax is not None else plt.subplots()[1]
        above, below = np.zeros(len(times)), np.zeros(len(times))
        for name, values in shown.items():
            colour, hatch = PARTS[name]
            for base, part in ((above, np.maximum(values, 0.0)), (below, np.minimum(values, 0.0))):
                if np.any(part != 0.0):
                    axes.fill_between(
                        times, base, base + part, facecolor=colour, hatch=hatch,
                        edgecolor="white", linewidth=0.0,
                    )  # fmt: skip
                base += part
            axes.fill_between([], [], [], facecolor=colour, hatch=hatch, edgecolor="white",
                              label=name)  # fmt: skip
        axes.plot(times, total, color="black", linewidth=1.0, label="given in all")
        quantity, unit = TICK[of]
        axes.set_ylabel(quantity)
        if budget.chain.units == "SI":
            # An impact of balls has some microjoules: a prefix instead of many zeros.
            scale, prefix = _prefix(float(np.abs([above, below]).max()))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / scale:g}"))
            axes.set_ylabel(f"{quantity} [{prefix}{unit}]")
        axes.set_xlabel(label)
        axes.set_title(budget.chain.description)
        axes.margins(x=0.0)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return axes


def _prefix(largest: float) -> tuple[float, str]:
    """Unit prefix with which a number is between 1 and 1000, if there is one."""
    prefixes = {0: "", -3: "m", -6: "µ", -9: "n"}
    power = 3 * math.floor(math.log10(largest) / 3) if largest > 0.0 else 0
    power = min(0, max(-9, power))
    return 10.0**power, prefixes[power]


def plot_chain(chain: Chain, *, ax: Axes | None = None) -> Axes:
    """Draw a chain to scale: beads, gaps and walls.

    Parameters
    ----------
    chain : Chain
        Any chain.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = plot_chain(hc.Chain.tapered("forward-linear", 0.05, beads=15))
    >>> len(axes.collections)
    1
    """
    factor, unit = (1e3, "mm") if chain.units == "SI" else (1.0, "$R_1$")
    radii = factor * chain.radii
    centres = bead_centres(chain) * factor
    with house_style():
        axes = ax if ax is not None else plt.subplots(figsize=(7.0, 1.6))[1]
        circles = [Circle((x, 0.0), r) for x, r in zip(centres, radii, strict=True)]
        face = _face_colours(chain)
        axes.add_collection(
            PatchCollection(circles, facecolor=face, edgecolor="black", linewidth=0.4)
        )
        low, high = centres[0] - radii[0], centres[-1] + radii[-1]
        tall = 1.15 * radii.max()
        _draw_walls(chain, factor, tall, axes)
        axes.set_aspect("equal")
        axes.set_xlim(low - 0.7 * radii.max(), high + 0.7 * radii.max())
        axes.set_ylim(-tall, tall)
        axes.set_xlabel(f"place [{unit}]")
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)  # it would look like a wall
        axes.set_title(chain.description)
    return axes


def _draw_walls(chain: Chain, factor: float, tall: float, axes: Axes) -> None:
    """Walls that reach up and down by ``tall``, half a bead's radius thick."""
    low, high = factor * np.array([0.0, bead_centres(chain)[-1] + chain.radii[-1]])
    thick = 0.5 * factor * chain.radii.max()
    for wall, at, side in ((chain.left_wall, low, -1.0), (chain.right_wall, high, 1.0)):
        if wall is not None:
            # Gaps are in units of motion, as they are: far smaller than beads if scaled.
            edge = at + side * (factor * wall.gap if chain.units == "SI" else 0.0)
            axes.fill_betweenx([-tall, tall], edge, edge + side * thick, facecolor="#BBBBBB",
                               hatch="///", edgecolor="black", linewidth=0.0, zorder=0)  # fmt: skip


def bead_centres(chain: Chain) -> Array:
    """Where the centres of the beads are, bead 1 at its radius.

    Parameters
    ----------
    chain : Chain
        Any chain.  Gaps of a scaled chain, in units of motion, are not drawn.

    Returns
    -------
    ndarray, shape (N,)
        In the unit of the radii.

    Examples
    --------
    >>> bead_centres(Chain.from_radii([1.0, 0.5]))
    array([1. , 2.5])
    """
    apart = np.cumsum(chain.centre_distances)
    return np.asarray(chain.radii[0] + np.concatenate(([0.0], apart)))


def animate(
    run: Run,
    path: str | os.PathLike[str],
    *,
    frames: int = 120,
    seconds: float = 6.0,
    magnify: float | None = None,
) -> Path:
    """Write an animation of the beads as a GIF: their motion magnified, their speed as colour.

    Parameters
    ----------
    run : Run
        A run with saved times; the more, the smoother.
    path : path-like
        File to write, ``.gif``.
    frames : int
        Number of pictures, at most the saved times.
    seconds : float
        How long it plays.
    magnify : float, optional
        Factor on the displacements; by default the largest becomes two radii.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For another ending, fewer than two saved times, or a file that cannot be written.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = hc.simulate(hc.Chain.uniform(9), until=12.0, times=20)
    ...     file = animate(run, Path(folder) / "beads.gif", frames=5)
    ...     file.read_bytes()[:3]
    b'GIF'
    """
    from PIL import Image

    _check_times(run)
    target = Path(path)
    if target.suffix != ".gif":
        raise InputError(f"an animation is a .gif file, got {target.name!r}")
    chosen = np.unique(np.linspace(0, len(run.times) - 1, max(2, frames)).round().astype(int))
    moved = run.positions - run.positions[0]
    largest = float(np.abs(moved).max())
    factor = magnify or 2.0 * float(run.chain.radii.mean()) / max(largest, np.finfo(float).tiny)
    images = [Image.open(io.BytesIO(png)) for png in _pictures(run, chosen, factor * moved)]
    content = io.BytesIO()
    images[0].convert("P").save(
        content, format="GIF", save_all=True, append_images=images[1:], loop=0,
        duration=max(20, round(1000.0 * seconds / len(images))),
    )  # fmt: skip
    write_bytes(target, content.getvalue())
    return target


def _pictures(run: Run, chosen: Array, moved: Array) -> list[bytes]:
    """One PNG for each chosen time."""
    chain, radii = run.chain, run.chain.radii
    centres = bead_centres(chain)
    fastest = float(np.abs(run.velocities).max())
    unit = time_axis(chain)[0]
    suffix = " µs" if chain.units == "SI" else ""
    pictures = []
    with house_style():
        figure, axes = plt.subplots(figsize=(8.0, 1.5), dpi=110)
        beads = EllipseCollection(
            2 * radii, 2 * radii, np.zeros(chain.beads), units="xy", cmap="RdBu_r",
            offsets=np.column_stack([centres, 0.0 * centres]), offset_transform=axes.transData,
            edgecolor="black", linewidth=0.4,
        )  # fmt: skip
        beads.set_clim(-fastest, fastest)
        axes.add_collection(beads)
        low = min(0.0, float((centres + moved - radii).min()))
        high = max(float(centres[-1] + radii[-1]), float((centres + moved + radii).max()))
        tall = 1.2 * radii.max()
        _draw_walls(chain, 1.0, tall, axes)
        axes.set_xlim(low - 0.6 * radii.max(), high + 0.6 * radii.max())
        axes.set_ylim(-tall, tall)
        axes.set_aspect("equal")
        axes.set_axis_off()
        for i in chosen:
            beads.set_offsets(np.column_stack([centres + moved[i], 0.0 * centres]))
            beads.set_array(run.velocities[i])
            now = f"t = {unit * run.times[i]:.1f}{suffix}"
            axes.set_title(f"{chain.description}; {now}", fontsize=8)
            content = io.BytesIO()
            figure.savefig(content, format="png")
            pictures.append(content.getvalue())
        plt.close(figure)
    return pictures


def _face_colours(chain: Chain) -> list[str]:
    """A colour for each material, light enough for black edges."""
    names = [each.name for each in chain.materials] if chain.materials else ["beads"]
    tints = ("#DDE6EE", "#F0D9C0", "#D3E8DC", "#F3DDE9", "#E8E8E8", "#FBEFC9")
    by_name = {name: tints[i % len(tints)] for i, name in enumerate(dict.fromkeys(names))}
    return [by_name[name] for name in names]


def _check_times(run: Run) -> None:
    if len(run.times) < 2:
        raise InputError(f"a picture needs at least 2 saved times, the run has {len(run.times)}")
