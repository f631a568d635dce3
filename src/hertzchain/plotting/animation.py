"""Animation of the beads, with a clock and a force trace, as GIF or MP4."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.animation import FFMpegWriter
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from ..chain.bead_names import bead_label
from ..chain.chain import Chain
from ..chain.drawn_bodies import half_heights, half_widths, pad_contacts
from ..collision import Array
from ..errors import InputError
from ..simulation.budget import overlaps_of
from ..simulation.run import Run
from ..simulation.sensor_force import SensorForce
from ..store.writing import write_bytes
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, whole_number
from ..validation.objects import Progress, callback, check_list, check_type, file_path
from .animation_file import AnimationFile
from .chains import (
    PAD,
    PAD_COLOUR,
    body_collection,
    material_colour,
    material_legend,
    material_names,
)
from .colours import COLOURS, grey
from .runs import check_times, wall_curve
from .static_forces import static_force, static_forces
from .style import figure_style, set_title, time_axis
from .titles import chain_title

if TYPE_CHECKING:
    from PIL.Image import Image

KINDS: Final = (".gif", ".mp4")
# Dots per inch of the frames, which are 8 inches wide.
RESOLUTION: Final = 100
# Room at the left and right edges [inches].
EDGE: Final = 0.2
# Colour map of velocities, and colour of the marker of the time.
COLOUR_MAP: Final = "RdBu_r"
MARKER: Final = COLOURS[2]
# Colours of the forces in sensors.
SENSORS: Final = tuple(COLOURS[k] for k in (1, 3, 4, 5))
# Length of the largest motion, and limit of the overlaps, in radii.
MOTION: Final = 2.0
# Size of the part of a bead that shows its velocity inside a ring in the colour of its material.
INNER: Final = 0.75
MAX_OVERLAP: Final = 0.2


@checked_arguments("animate")
def animate(
    run: Run,
    path: str | os.PathLike[str],
    *,
    frames: int = 120,
    seconds: float = 6.0,
    magnify: float | None = None,
    sensors: Sequence[int | str] = (),
    progress: Progress | None = None,
) -> Path:
    """Write an animation of the beads as GIF or MP4.

    Displacements, gaps and overlaps are magnified by the same factor, which keeps contacts where
    they are; the colour of a bead is its velocity.  If there are several materials, a ring around
    each bead has the colour of its material in all figures, and a legend names them.  Below, a
    trace with a marker at the present time shows the force on the right wall or, without one, the
    largest contact force, and the forces in sensors.  With precompression or gravity, the trace
    shows the changes of these forces from the static ones.

    Parameters
    ----------
    run : Run
        A run with saved times; more times give a smoother animation.
    path : path-like
        File to write: ``.gif``, or ``.mp4``, which requires the program ffmpeg.
    frames : int
        Number of frames, at least 2; at most one per saved time is shown.
    seconds : float
        Duration of the animation.
    magnify : float, optional
        Factor on displacements, gaps and overlaps.  By default, the largest displacement or gap
        becomes two radii, unless an overlap would then exceed 0.2 radii.
    sensors : sequence of int or str
        Beads with sensors, at most 4, as for `Run.sensor_force`.
    progress : callable, optional
        Called with the number of frames drawn and their total number.

    Returns
    -------
    pathlib.Path
        The file.  At the end of a cell of a notebook, the animation is shown, if the file has at
        most 5 MB.

    Raises
    ------
    InputError
        For another file extension, fewer than two saved times, a file that cannot be written, or
        an MP4 without ffmpeg, or for a bead that the chain does not have.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = hc.simulate(hc.Chain.uniform(9), until=12.0, times=20)
    ...     file = hc.animate(run, Path(folder) / "beads.gif", frames=5)
    ...     file.read_bytes()[:3]
    b'GIF'
    """
    check_type("run", run, Run, "simulate makes one")
    check_times(run.times, "an animation")
    target = file_path("animation", path)
    frames = whole_number("frames", frames, least=2)
    seconds = number("seconds", seconds, above=0.0)
    if magnify is not None:
        magnify = number("magnify", magnify, above=0.0)
    callback("progress", progress)
    if target.suffix not in KINDS:
        raise InputError(f"the name of an animation must end in .gif or .mp4, got {target.name!r}")
    if target.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError(
            f"{target.name} requires the program ffmpeg, which was not found: install it, or write "
            "a .gif"
        )
    if not target.parent.is_dir():
        raise InputError(f"{target} cannot be written: the folder {target.parent} does not exist")
    traces = [run.sensor_force(each) for each in check_list("sensors", sensors, "beads")]
    if len(traces) > len(SENSORS):
        raise InputError(f"an animation shows at most {len(SENSORS)} sensors, got {len(traces)}")
    chosen = np.unique(np.linspace(0, len(run.times) - 1, frames).round().astype(int))
    drawn = []
    for frame in _frames(run, chosen, magnify, traces):
        drawn.append(frame)
        if progress is not None:
            progress(len(drawn), len(chosen))
    gif = target.suffix == ".gif"
    write_bytes(target, _gif(drawn, seconds, run.chain) if gif else _mp4(drawn, seconds))
    return AnimationFile(target)


def _frames(
    run: Run, chosen: Array, magnify: float | None, sensors: Sequence[SensorForce]
) -> Iterator[Image]:
    """One frame for each chosen time."""
    from PIL import Image

    factor = magnify or _magnification(run)
    unit, label = time_axis(run.chain, float(run.times[-1]))
    # Such as "ms" of "time [ms]".
    clock_unit = label.partition("[")[2].rstrip("]")
    digits = 2 if clock_unit == "ms" else 1
    centres = _centres(run, factor)
    with figure_style():
        figure, (top, below) = plt.subplots(
            2, figsize=(8.0, 3.0), dpi=RESOLUTION, height_ratios=(1.4, 1.0)
        )
        # An axis without a number at its end would reach the edge of the picture.
        figure.set_layout_engine("constrained", w_pad=EDGE)
        try:
            bodies, left_wall = _draw_beads(top, run, centres, factor)
            marker = _draw_force(below, run, unit, label, sensors)
            set_title(top, chain_title(run.chain))
            below.set_title(_scales(run, factor), loc="left", fontsize="small")
            # Above the axes, where no curve is.
            clock = below.set_title("t", loc="right", fontsize="medium")
            # The layout of the first frame is kept, to align all frames.
            figure.canvas.draw()
            figure.set_layout_engine("none")
            # Beads at whole pixels have equal edges in most frames, which compress well.
            pixel = np.diff(top.get_xlim())[0] / top.get_window_extent().width
            for i in chosen:
                at = pixel * np.round(centres[i] / pixel)
                for each in bodies:
                    each.set_offsets(np.column_stack([at, 0.0 * at]))
                bodies[-1].set_array(run.velocities[i])
                if left_wall is not None:
                    left_wall.set_x(_left_edge(run, factor)[i] - left_wall.get_width())
                marker.set_xdata([unit * run.times[i]] * 2)
                clock.set_text(f"t = {unit * run.times[i]:.{digits}f} {clock_unit}".rstrip())
                figure.canvas.draw()
                pixels = np.asarray(figure.canvas.buffer_rgba())  # type: ignore[attr-defined]
                yield Image.fromarray(pixels[:, :, :3].copy())
        finally:
            plt.close(figure)


def _magnification(run: Run) -> float:
    """Factor that makes motion visible without overlaps that look impossible."""
    chain = run.chain
    radii = np.pad(half_heights(chain), 1, constant_values=np.inf)
    overlaps = _overlaps(run)
    moved = float(np.abs(run.positions - run.positions[0]).max())
    largest = max(moved, float(_gaps(chain).max()), np.finfo(float).tiny)
    deepest = np.max(overlaps.max(axis=0) / np.minimum(radii[:-1], radii[1:]), initial=0.0)
    visible = MOTION * float(half_heights(chain).mean()) / largest
    return min(visible, MAX_OVERLAP / deepest) if deepest > 0.0 else visible


def _overlaps(run: Run) -> Array:
    """Overlaps of all contacts; 0 at free ends."""
    overlaps = overlaps_of(run.chain, run.times, run.positions)
    return np.where(run.chain.contact_stiffness > 0.0, overlaps, 0.0)


def _gaps(chain: Chain) -> Array:
    """Gaps of all contacts, those with the walls included."""
    left, right = (wall.gap if wall else 0.0 for wall in (chain.left_wall, chain.right_wall))
    return np.array([left, *chain.gaps, right])


def _centres(run: Run, factor: float) -> Array:
    """Centres of the beads at all times, if lengths other than radii are magnified."""
    widths = half_widths(run.chain)
    touching = np.cumsum(widths) + np.concatenate(([0.0], np.cumsum(widths[:-1])))
    apart = np.concatenate(([0.0], np.cumsum(run.chain.gaps)))
    return np.asarray(touching + factor * (apart + run.positions))


def _left_edge(run: Run, factor: float) -> Array:
    """Position of the left wall at all times, which a drive may move."""
    overlap, gap = _overlaps(run)[:, 0], _gaps(run.chain)[0]
    driven = overlap + run.positions[:, 0] + gap
    return np.asarray(factor * (driven - gap))


def _right_edge(run: Run, factor: float) -> float:
    """Position of the right wall."""
    return float(2.0 * half_widths(run.chain).sum() + factor * _gaps(run.chain)[1:].sum())


def _scales(run: Run, factor: float) -> str:
    """Scale of the drawn motion, and meaning of the colours."""
    fastest, unit = float(np.abs(run.velocities).max()), " m/s" * (run.chain.units == "SI")
    lengths = "displacements and gaps" if _gaps(run.chain).any() else "displacements"
    times = float(f"{factor:.2g}")
    drawn = f"magnified {times:g} times" if times > 1.0 else f"drawn at {times:g} of their size"
    return (
        f"{lengths} {drawn if times != 1.0 else 'to scale'}; velocity up to {fastest:.3g}{unit}: "
        "red to the right, blue to the left"
    )


def _draw_beads(
    axes: Axes, run: Run, centres: Array, factor: float
) -> tuple[list[PatchCollection], Rectangle | None]:
    """Draw the beads, and the walls in front of them; returns the bodies and the left wall.

    The last ones of the bodies have the colours of velocities, those before have the colours of
    materials, if there are several.
    """
    chain, widths = run.chain, half_widths(run.chain)
    fastest = float(np.abs(run.velocities).max())
    places = np.column_stack([centres[0], 0.0 * centres[0]])
    faces = [material_colour(name) for name in material_names(chain)]
    several = len(set(material_names(chain))) > 1
    bodies = [body_collection(chain, 1.0, places, axes, facecolor=faces)] if several else []
    size = INNER if several else 1.0
    bodies.append(body_collection(chain, size, places, axes, cmap=COLOUR_MAP))
    bodies[-1].set_clim(-fastest, fastest)
    material_legend([chain], axes, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=6)
    largest = float(half_heights(chain).max())
    ends = [float((centres - widths).min()), float((centres + widths).max())]
    left_wall = None
    if chain.left_wall is not None:
        edge = _left_edge(run, factor)
        left_wall = _draw_wall(axes, float(edge[0]) - 0.5 * largest, largest)
        ends.append(float(edge.min()) - 0.5 * largest)
    if chain.right_wall is not None:
        begin = _right_edge(run, factor) + _draw_pad(axes, run, factor, largest)
        _draw_wall(axes, begin, largest)
        ends.append(begin + 0.5 * largest)
    axes.set_xlim(min(ends) - 0.1 * largest, max(ends) + 0.1 * largest)
    axes.set_ylim(-1.2 * largest, 1.2 * largest)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return bodies, left_wall


def _draw_pad(axes: Axes, run: Run, factor: float, largest: float) -> float:
    """The layer of a pad, or of a load cell, before the right wall; returns its thickness."""
    if run.chain.beads not in pad_contacts(run.chain):
        return 0.0
    thick = PAD * largest
    axes.add_patch(Rectangle((_right_edge(run, factor), -0.8 * largest), thick, 1.6 * largest,
                             facecolor=PAD_COLOUR, linewidth=0.0, zorder=3))  # fmt: skip
    return thick


def _draw_wall(axes: Axes, begin: float, largest: float) -> Rectangle:
    wall = Rectangle(
        (begin, -1.2 * largest), 0.5 * largest, 2.4 * largest, facecolor="#BBBBBB", hatch="///",
        edgecolor="black", linewidth=0.0, zorder=3,
    )  # fmt: skip
    axes.add_patch(wall)
    return wall


def _draw_force(
    axes: Axes, run: Run, unit: float, label: str, sensors: Sequence[SensorForce]
) -> Any:
    """The force on the right wall, or the largest contact force, and those in sensors.

    They are changes from static forces, which would hide the wave.  Returns the marker of the time.
    """
    chain, static = run.chain, static_forces(run.chain)
    newton = " [N]" if chain.units == "SI" else ""
    if chain.right_wall is not None:
        times, values = wall_curve(run._wall_force("right"))
        values, what = values - static[-1], "force on wall"
    else:
        times, values, what = run.times, (run.forces - static).max(axis=1), "largest force"
    axes.plot(unit * times, values, color=grey(axes), linewidth=0.9)
    for sensor, colour in zip(sensors, SENSORS, strict=False):
        force = sensor.force - static_force(chain, sensor.bead)
        axes.plot(unit * sensor.times, force, color=colour, linewidth=0.9)
        # The first maximum is NaN if the pulse has not arrived.
        top = int(np.argmax(sensor.force >= np.nan_to_num(sensor.first_maximum, nan=np.inf)))
        top = top or int(np.argmax(sensor.force))
        axes.annotate(bead_label(chain, sensor.bead), (unit * sensor.times[top],
                      force[top]), ha="center", va="bottom", color=colour, xytext=(0, 2),
                      textcoords="offset points", fontsize="small")  # fmt: skip
    if sensors:
        axes.margins(y=0.2)
    axes.set_xlim(unit * run.times[0], unit * run.times[-1])
    axes.set_xlabel(label)
    if static.any():
        what = f"change of {what}" if chain.right_wall is not None else "largest change of force"
        what = what if sensors else what.replace(" of ", " of\n", 1)
    axes.set_ylabel((f"{what}\nand in sensors" if sensors else what) + newton)
    return axes.axvline(unit * run.times[0], color=MARKER, linewidth=1.2)


def _gif(frames: list[Image], seconds: float, chain: Chain) -> bytes:
    from PIL import Image, ImageColor

    content = io.BytesIO()
    # One palette for all frames, so that unchanged pixels do not flicker and compress well: greys
    # for lines and letters, and the colours of velocities and, if there are several, materials.
    greys = np.repeat(np.linspace(0, 255, 8).astype(np.uint8), 3)
    colours = (255.0 * colormaps[COLOUR_MAP](np.linspace(0.0, 1.0, 41))[:, :3]).astype(np.uint8)
    names = dict.fromkeys(material_names(chain))
    others = [MARKER, *SENSORS, *(material_colour(name) for name in names if len(names) > 1)]
    single = [value for each in others for value in ImageColor.getrgb(each)]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*greys.tolist(), *colours.ravel().tolist(), *single])
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    reduced[0].save(
        content, format="GIF", save_all=True, append_images=reduced[1:], loop=0, optimize=True,
        duration=max(20, round(1000.0 * seconds / len(frames))),
    )  # fmt: skip
    return content.getvalue()


def _mp4(frames: list[Image], seconds: float) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "animation.mp4"
        width, height = frames[0].size
        figure = plt.figure(figsize=(width / RESOLUTION, height / RESOLUTION), dpi=RESOLUTION)
        shown = figure.figimage(np.asarray(frames[0]))
        writer = FFMpegWriter(
            fps=max(1, round(len(frames) / seconds)),
            extra_args=["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"],
        )
        try:
            with writer.saving(figure, str(file), RESOLUTION):
                for frame in frames:
                    shown.set_data(np.asarray(frame))
                    writer.grab_frame()
        finally:
            plt.close(figure)
        return file.read_bytes()
