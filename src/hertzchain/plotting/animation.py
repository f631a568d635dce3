"""Animation of the beads as a GIF."""

from __future__ import annotations

import io
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

from ..collision import Array
from ..errors import InputError
from ..simulation.run import Run
from ..store.writing import write_bytes
from ..validation.numbers import number, whole_number
from ..validation.objects import check_type, file_path
from .chains import bead_centres, draw_walls
from .runs import check_times
from .style import figure_style, literal, time_axis


def animate(
    run: Run,
    path: str | os.PathLike[str],
    *,
    frames: int = 120,
    seconds: float = 6.0,
    magnify: float | None = None,
) -> Path:
    """Write an animation of the beads as a GIF, with magnified motion and speed as colour.

    Parameters
    ----------
    run : Run
        A run with saved times; more times give a smoother animation.
    path : path-like
        File to write, ``.gif``.
    frames : int
        Number of frames, at least 2; at most one per saved time is shown.
    seconds : float
        Duration of the animation.
    magnify : float, optional
        Factor on the displacements.  By default the largest displacement becomes two radii.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For another file extension, fewer than two saved times, or a file that cannot be written.

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

    check_type("run", run, Run, "simulate makes one")
    check_times(run)
    target = file_path("animation", path)
    frames = whole_number("frames", frames, least=2)
    seconds = number("seconds", seconds, above=0.0)
    if magnify is not None:
        magnify = number("magnify", magnify, above=0.0)
    if target.suffix != ".gif":
        raise InputError(f"the name of an animation must end in .gif, got {target.name!r}")
    chosen = np.unique(np.linspace(0, len(run.times) - 1, frames).round().astype(int))
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
    with figure_style():
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
        draw_walls(chain, 1.0, tall, axes)
        axes.set_xlim(low - 0.6 * radii.max(), high + 0.6 * radii.max())
        axes.set_ylim(-tall, tall)
        axes.set_aspect("equal")
        axes.set_axis_off()
        for i in chosen:
            beads.set_offsets(np.column_stack([centres + moved[i], 0.0 * centres]))
            beads.set_array(run.velocities[i])
            now = f"t = {unit * run.times[i]:.1f}{suffix}"
            axes.set_title(f"{literal(chain.description)}; {now}", fontsize=8)
            content = io.BytesIO()
            figure.savefig(content, format="png")
            pictures.append(content.getvalue())
        plt.close(figure)
    return pictures
