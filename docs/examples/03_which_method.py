"""
Which method is accurate enough, and how long does it take?
===========================================================

``simulate`` integrates all beads, ``propagate`` only those around the pulse, and ``local_rate``,
``bca`` and ``modified_bca`` are theories.  Which of them do you need?
"""

# sphinx_gallery_thumbnail_panel = (1, 1)
import time

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc
from hertzchain.plotting.looks import method_style

plt.style.use("hertzchain.figures")

# %%
# Compare all methods on one smooth taper.  The reference is ``simulate``, with a relative error of
# 1e-13 per step.

chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
methods = {
    "simulate": lambda chain: hc.simulate(chain, times=0).pulse(),
    "propagate": hc.propagate,
    "local_rate": hc.local_rate,
    "modified_bca": hc.modified_bca,
    "bca": hc.bca,
}


def best_time(function, chain, repetitions=5):
    """Shortest time of several calls, after a first one, which may compile."""
    function(chain)
    times = []
    for _ in range(repetitions):
        began = time.perf_counter()
        function(chain)
        times.append(time.perf_counter() - began)
    return min(times)


seconds = {name: best_time(function, chain) for name, function in methods.items()}
pulses = {name: function(chain) for name, function in methods.items()}
exact = pulses["simulate"].velocity
inner = slice(4, 97)

figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6))
styles = {name: method_style(name.replace("_", "-")) for name in pulses}
for name, pulse in pulses.items():
    style = styles[name]
    # The curves of propagate and local_rate would hide that of simulate.
    if name not in ("propagate", "local_rate"):
        # The last bead leaves the free end, and is no part of the curve.
        # Circles show the modified BCA, whose curve coincides with that of simulate.
        marker = "o" if name == "modified_bca" else None
        left.semilogy(np.arange(1, 100), pulse.velocity[:-1], marker=marker, markevery=9,
                      markersize=4.5, markerfacecolor="none", **style)
    if name != "simulate":
        error = abs(pulse.velocity / exact - 1)[inner]
        right.semilogy(np.arange(5, 98), error, **style)
        right.annotate(style["label"], (97, error[-1]), xytext=(5, 0), ha="left", va="center",
                       textcoords="offset points", color=style["color"])
left.annotate("simulation", (45, exact[44]), xytext=(-6, -6), textcoords="offset points",
              ha="right", va="top")
left.annotate("modified BCA", (70, exact[69]), xytext=(-10, -9), textcoords="offset points",
              ha="right", va="top", color=styles["modified_bca"]["color"])
left.annotate("BCA", (60, pulses["bca"].velocity[59]), xytext=(6, 6),
              textcoords="offset points", color=styles["bca"]["color"])
left.set_title("Velocity of the pulse")
left.set_xlabel("bead $k$")
left.set_ylabel("velocity $v_k$")
right.set_title("Relative error of the velocity")
right.set_xlabel("bead $k$")
right.set_ylabel("relative error")

# %%
# With a random variation of its radii by 5%, the chain is not smooth.  The local-rate law warns
# that it is outside its range: its error is much larger than for the smooth taper,
# although it is still smaller than that of the BCA.

import warnings

factors = np.exp(0.05 * np.random.default_rng(1).normal(size=100))
rough = hc.Chain.from_radii(chain.radii * factors)
reference = hc.propagate(rough)
with warnings.catch_warnings(record=True) as raised:
    warnings.simplefilter("always")
    law = hc.local_rate(rough)
print(raised[0].message if raised else "no warning")
print(f"largest error of local_rate: {law.compare(reference).worst('velocity'):.1%}")
print(f"largest error of bca:        {hc.bca(rough).compare(reference).worst('velocity'):.1%}")

# %%
# ``propagate`` and the theories describe the pulse in a row of elastic balls.  With a wall, a gap
# or a drive, they raise an error that names the unsupported feature.  Of these methods, only
# ``local_rate`` supports losses, and not by all laws.  ``simulate``, and ``simulate_many``,
# ``stream``, ``sweep``, ``design`` and ``fit``, which are based on it, support all of these chains:

try:
    hc.propagate(chain.replace(right_wall=hc.Wall()))
except hc.InputError as error:
    print(error)

# %%
# Answer
# ------
#
# Use ``simulate`` for forces on walls, losses and anything behind the pulse, ``propagate`` for the
# pulse itself, and ``local_rate`` for smooth tapers if you need derivatives or millions of
# chains.  The BCA is for estimates of times only.  :doc:`/how-to/which_function` has the complete
# table.

print(f"{'method':14}{'time':>12}{'largest error, beads 5 to 97':>32}")
for name, pulse in pulses.items():
    error = abs(pulse.velocity / exact - 1)[inner].max()
    shown = "reference" if name == "simulate" else f"{error:.1e}"
    print(f"{name:14}{1e3 * seconds[name]:9.3f} ms{shown:>32}")
