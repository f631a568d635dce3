"""
How do you compute thousands of chains on several machines?
===========================================================

A map of the force on a wall requires many simulations.  On a cluster, each job computes a share,
jobs are sometimes killed, and the shares must fit together.  This notebook divides a sweep in
three shares, as three jobs would, loses one of them, and merges the rest.
"""

# sphinx_gallery_thumbnail_panel = (1, 1)
import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt

import hertzchain as hc

plt.style.use("hertzchain.figures")
folder = Path(tempfile.mkdtemp())

# %%
# The specification is a TOML file or a mapping.  Every combination of the axes is a point.

taper = hc.Chain.tapered("forward-exponential", 0.01, beads=10)
specification = {
    "title": "Forward tapers in front of a wall",
    "chain": taper.replace(right_wall=hc.Wall()),
    "axes": {
        "rate": {"linspace": [0.0025, 0.08, 32]},
        "right_wall.stiffness": {"geomspace": [0.05, 50.0, 31]},
    },
    "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"], "batch": 64},
}

# %%
# A job computes the share ``(i, n)`` into a separate store.  On a cluster, ``i`` is the number of
# the job in its array: ``hertzchain sweep taper.toml --shard "$SLURM_ARRAY_TASK_ID/3"``.

stores = [folder / f"share-{i}.zarr" for i in (1, 2, 3)]
for i, store in enumerate(stores, start=1):
    part = hc.sweep(specification, store, shard=(i, 3))
    print(f"job {i}: {int((part.status == 1).sum())} of {part.status.size} points")

# %%
# Merge the stores of two jobs, as if the third job had been killed before it began.  Missing points
# are marked as such.

merged, _ = hc.merge_sweeps(stores[:2], folder / "merged.zarr")
merged = merged.load()  # datasets of stores are read when they are used
print(f"{int((merged.status == 0).sum())} points are missing")

# %%
# The same call as on a single machine resumes the merged store and computes only what is missing.
# At the largest rates and the stiffest walls, the map has a small jump: there, the largest force
# occurs in a later collision with the wall.

complete = hc.sweep(specification, folder / "merged.zarr")
single = hc.sweep(specification)
same = bool((complete.wall_peak_force == single.wall_peak_force).all())

figure, axes = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
for panel, dataset, title in zip(
    axes, (merged, complete), ("Two of three jobs", "After the sweep was resumed"), strict=True
):
    with warnings.catch_warnings(action="ignore", category=hc.IncompleteWarning):
        hc.plot_sweep(dataset, "wall_peak_force", ax=panel)
    panel.set_title(title)

# %%
# Answer
# ------
#
# Compute shares with ``--shard i/n``, merge them, and run the sweep again on the result: it
# computes only the missing points.  :doc:`/how-to/sweep_cluster` has scripts for SLURM, dask and
# MPI.

force = complete.wall_peak_force.squeeze()
least = force.isel(force.argmin(...))
print(f"the merged and resumed sweep equals that of one process: {same}")
print(f"smallest force of {force.size} chains: {least:.3f}, at rate {least.rate:g} and wall "
      f"stiffness {least.stiffness:g}")
