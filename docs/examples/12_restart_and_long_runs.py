"""
How do you continue a run, and how long can it be trusted?
==========================================================

Some questions need long runs: pulses that are reflected again and again, or a run that must
survive the end of a job.  Can a run be continued without any difference, and do its numbers still
mean something at the end?
"""

# sphinx_gallery_thumbnail_panel = (1, 1)
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")
folder = Path(tempfile.mkdtemp())
wall = hc.Wall()
box = hc.Chain.uniform(40).replace(left_wall=wall, right_wall=wall)

# %%
# Continue a run
# --------------
#
# Every run has its last state.  Save it, load it in another process, and continue from there.

first = hc.simulate(box, until=150.0, times=601)
hc.save_state(first.state, folder / "state.json")

state = hc.load_state(folder / "state.json", box)
second = hc.simulate(box, start=state, until=300.0, times=np.linspace(150.0, 300.0, 601))
whole = hc.simulate(box, until=300.0, times=np.linspace(150.0, 300.0, 601))
identical = bool(np.array_equal(second.velocities, whole.velocities))
print(f"the continued run equals the uninterrupted one bit for bit: {identical}")

# %%
# Keep a long run on disk
# -----------------------
#
# ``stream`` writes files during the run.  If it is interrupted, the same call resumes it after the
# last complete file.

stored = hc.stream(box, folder / "long", times=np.linspace(0.0, 3000.0, 6001))
late = stored.load(start=2900.0, stop=3000.0)
print(f"{len(stored.files)} file(s); loaded {late.sizes['time']} of 6001 times")

# %%
# How long it is predictable
# --------------------------
#
# In a box, waves collide, and small errors grow.  ``horizon`` estimates them: it repeats the run
# with another tolerance and compares the velocities.  The estimate is ten times their largest
# difference, for safety.  When the two runs have become unrelated, it therefore saturates well
# above 2, the largest possible difference.

run = hc.simulate(box, until=1200.0, times=4801)
found = run.horizon()

figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6))
left.semilogy(found.times[1:], found.error[1:])
left.axhline(found.within, color="0.5", linestyle="--", linewidth=0.9, label="error of 1%")
left.axvline(found.time, color="0.5", linestyle=":", label="horizon of the run")
left.legend(loc="lower right")
left.set_title("Estimated error of the velocities")
left.set_xlabel("time $t$")
left.set_ylabel("estimated error / largest velocity")
early = run.times < 150
shown = right.pcolormesh(
    run.times[early], np.arange(1, 41), run.velocities[early].T,
    cmap="RdBu_r", vmin=-1, vmax=1, shading="nearest", rasterized=True,
)
figure.colorbar(shown, ax=right, label="velocity")
right.set_title("Velocities at the beginning")
right.set_xlabel("time $t$")
right.set_ylabel("bead $k$")

# %%
# Answer
# ------
#
# Runs can be stopped and continued at any time without a difference.  After the horizon, single
# velocities are no longer meaningful, but the conserved quantities and averages are.

end = run.times[-1]
print(f"predictable within {found.within:.0%} until t = {found.time:.0f}, of {end:.0f}")
print(f"drift of the energy at the end: {run.energy_drift:.0e}")
