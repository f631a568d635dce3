r"""
What went wrong with the paper's velocity formulas?
===================================================

The paper that hertzchain reproduces ends with four formulas for the velocity of the pulse, one
for each family of tapers.  How well do they describe the simulation if they are used as printed,
and can they be corrected?
"""

# sphinx_gallery_thumbnail_panel = (2, 0)
# sphinx_gallery_alt_1 = "The first 20 beads of a chain of each family"
# sphinx_gallery_alt_2 = "Errors along chains of four families: as printed, BCA and modified BCA"
import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc
from hertzchain.plotting.looks import method_style
from hertzchain.theory import printed_velocity

plt.style.use("hertzchain.figures")

# %%
# These are the four families, each at the largest rate of the paper's figures.  *Forward* means
# that beads become smaller, *backward* that they become larger.

families = {
    "backward-linear": 0.9,
    "backward-exponential": 0.08,
    "forward-linear": 0.009,
    "forward-exponential": 0.06,
}
chains = {taper: hc.Chain.tapered(taper, rate, beads=100) for taper, rate in families.items()}

figure, grid = plt.subplots(2, 2, figsize=(8.0, 2.6))
for axes, (taper, rate) in zip(grid.flat, families.items()):
    hc.plot_chain(hc.Chain.tapered(taper, rate, beads=20), ax=axes)
    axes.set_title(f"{taper}, first 20 beads")
    axes.set_axis_off()

# %%
# For every family, compute the pulse by simulation, by the formula as printed, and by the
# modified BCA: the exact product of the binary collision approximation (BCA), times a factor
# fitted to the simulation.

beads = np.arange(1, 101)
window = slice(4, 80)
worst = {}
figure, grid = plt.subplots(2, 2, figsize=(8.0, 6.0), sharex=True)
for axes, (taper, rate) in zip(grid.flat, families.items()):
    exact = hc.propagate(chains[taper]).velocity
    candidates = {
        "as printed": printed_velocity(taper, rate, beads.astype(float)),
        "BCA": hc.bca(chains[taper]).velocity,
        "modified BCA": hc.modified_bca(chains[taper]).velocity,
    }
    # The page on the reproduction draws the printed formulas in the same way.
    methods = ("modified-bca-printed", "bca", "modified-bca")
    for (name, velocity), method in zip(candidates.items(), methods):
        error = 100 * (velocity / exact - 1)
        worst[taper, name] = abs(error[window]).max()
        axes.plot(beads[window], error[window], **{**method_style(method), "label": name})
    axes.axhline(0, color="0.6", linewidth=0.7, zorder=1)
    axes.set_title(f"{taper}, rate {rate:g}")
for axes in grid[1]:
    axes.set_xlabel("bead $k$")
for axes in grid[:, 0]:
    axes.set_ylabel("error of the velocity [%]")
grid[0, 1].legend(loc="center right")

# %%
# Each printed formula contradicts another equation or a figure of the paper:
#
# - backward linear: the prefactor of Eqs. (28) to (30) is missing, and it depends on the rate;
# - forward linear: the exponent is -3/2, as in Eq. (22), not +3/2;
# - exponential: the constants :math:`(c_0, x)` of the two families were apparently exchanged.
#
# The last point is an inference, and exchanging them back can be tried:

from hertzchain.theory import PowerLawCorrection, printed_correction

taper = "forward-exponential"
own, other = printed_correction(taper), printed_correction("backward-exponential")
exchanged = PowerLawCorrection(c0=other.c0, x=other.x, d0=own.d0, y=own.y)
exact = hc.propagate(chains[taper])
for name, correction in {"as printed": own, "exchanged": exchanged}.items():
    errors = hc.modified_bca(chains[taper], correction).compare(exact).errors("velocity")
    print(f"{taper}, constants {name}: error up to {abs(errors[window]).max():.1%}")

# %%
# Answer
# ------
#
# Used as printed, none of the four formulas can be trusted.  The form of the correction is
# sound, however: with the exact product of the BCA and recalibrated constants, which
# ``modified_bca`` uses, the error is much smaller.  The page
# :doc:`/explanation/reproduction` lists all errata.

print(f"{'largest error, beads 5 to 80':30}{'as printed':>12}{'BCA':>8}{'modified BCA':>14}")
for taper in families:
    row = [worst[taper, name] for name in ("as printed", "BCA", "modified BCA")]
    print(f"{taper:30}{row[0]:11.1f}%{row[1]:7.1f}%{row[2]:13.1f}%")
