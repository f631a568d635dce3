"""
Which loss law describes the data, and how large is the loss?
=============================================================

A pulse in real balls decays.  The traces of four force sensors contain enough information to
determine the loss law, its constant and its error, and even a hidden gap.
"""

# sphinx_gallery_thumbnail_panel = (1, 2)
# sphinx_gallery_alt_1 = "Measured and fitted forces, crests and residuals of four sensors"
import matplotlib.pyplot as plt

import hertzchain as hc

plt.style.use("hertzchain.figures")
traces, chain_file = hc.example_experiment()

# %%
# The chain file names the free parameters and the measurements that serve as priors.  ``fit`` finds
# the values and their standard errors.

result = hc.fit(traces, chain_file)
print(result.summary())

# %%
# Always look at the residuals.  Here they look like noise, so the model describes the data.

result.plot()

# %%
# A fit always returns numbers, even for the wrong law.  ``compare_losses`` fits several laws to the
# same data; a difference of the BIC by more than 10 decides.

compared = hc.compare_losses(
    traces, chain_file, laws=["viscoelastic", "restitution", "dashpot", "elastic"]
)
names = [each.law for each in compared.fits]
scores = [each.bic - compared.fits[0].bic for each in compared.fits]

figure, axes = plt.subplots(figsize=(8.0, 2.6))
rows = range(1, len(names))
axes.plot(scores[1:], rows, "o")
for row, score in zip(rows, scores[1:], strict=True):
    axes.annotate(f"{score:.0f}", (score, row), xytext=(7, 0), textcoords="offset points",
                  va="center")
axes.annotate("the best law", (1.2, 0), va="center")
axes.axvline(10, color="0.4", linestyle="--", linewidth=0.9)
axes.annotate("decisive beyond 10", (11, 0), va="center", color="0.4")
axes.set_yticks(range(len(names)), names)
axes.set_ylim(len(names) - 0.5, -0.5)
axes.set_xscale("log")
axes.set_xlim(1.0, 3e5)
axes.set_title("Difference of the BIC from the best law")
axes.set_xlabel("difference")

# %%
# Answer
# ------
#
# The fit finds a viscoelastic loss.  The data are synthetic, so the true values are known: a
# relaxation time of 0.62 µs, and 0.96 of the nominal stiffness.

print(compared.statement)
for name in ("loss.time", "stiffness"):
    row = dict(result.rows())[name]
    print(f"{name:10} {row}")
