"""
How do you make a figure for a journal?
=======================================

A journal asks for vector graphics of a column's width, text of at least 7 points, and colours
that remain different in grey.  What is needed for that?
"""

# sphinx_gallery_thumbnail_panel = (2, 1)
# sphinx_gallery_alt_1 = "Velocities by propagation, BCA and local-rate law, and their errors"
# sphinx_gallery_alt_2 = "The chain, the velocities along it and the errors of two theories"
# sphinx_gallery_alt_3 = "Map of the velocities of all beads over time"
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

# %%
# The style
# ---------
#
# Inside a block of :obj:`~hertzchain.figure_style`, figures have the width of a column, text of 7
# or 8 points, and no title, because the caption describes them.  Do not scale the figure later.
# On the command line, the option ``--width "single column"`` does the same.

chain = hc.Chain.tapered("forward-linear", 0.015, beads=40)
run = hc.simulate(chain, times=800)
exact, bca, law = hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)
with hc.figure_style("single column"):
    hc.plot_pulses([exact, bca, law], log=True, residuals=True)

# %%
# Your own arrangement
# --------------------
#
# Every plot of hertzchain has a parameter ``ax`` for axes of your own figure.  Here the chain is
# above the velocities.  The lowest panel shows the errors on a logarithmic axis, because they
# differ by orders of magnitude.  Curves with different dashes and symbols remain distinguishable in
# grey.

COLUMN = 86 / 25.4  # inches
with hc.figure_style("single column"):
    figure, (top, middle, bottom) = plt.subplots(
        3, 1, figsize=(COLUMN, 3.9), height_ratios=[0.5, 2, 1.2]
    )
    hc.plot_chain(chain, ax=top)
    top.set_axis_off()
    hc.plot_pulses(
        [exact, bca, law], log=True, residuals=True, ax=(middle, bottom),
    )

# %%
# A map
# -----
#
# A map has thousands of cells.  With ``rasterized=True`` only the map becomes an image; axes and
# text remain vector graphics.

with hc.figure_style("single column"):
    figure_map, axes = plt.subplots(figsize=(COLUMN, 2.4))
    shown = axes.pcolormesh(
        run.times, np.arange(1, chain.beads + 1), run.velocities.T, shading="nearest",
        rasterized=True, cmap="magma_r", vmin=0,
    )
    axes.set_xlabel("time $t$")
    axes.set_ylabel("bead $k$")
    figure_map.colorbar(shown, label="velocity $v_k(t)$")

# %%
# Files
# -----

folder = Path(tempfile.mkdtemp())
figure.savefig(folder / "velocity.pdf", metadata={"CreationDate": None})
figure_map.savefig(folder / "map.pdf", dpi=300, metadata={"CreationDate": None})

# %%
# Answer
# ------
#
# Use the style with the width of the column, lines with different dashes, a panel with the errors,
# and rasterised maps in PDF files.

smallest = min(text.get_fontsize() for text in figure.findobj(plt.Text) if text.get_text())
width, height = figure.get_size_inches()
print(f"velocity.pdf: {width:.2f} by {height:.2f} inches, {smallest:.1f} points or larger, "
      f"{(folder / 'velocity.pdf').stat().st_size / 1024:.0f} kB")
print(f"map.pdf: {(folder / 'map.pdf').stat().st_size / 1024:.0f} kB")
