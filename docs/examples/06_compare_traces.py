"""
Does the simulation agree with your measured traces?
====================================================

You have a CSV file with the signals of force sensors and a description of the chain.  Before any
fit, plot both and see where they differ.
"""

# sphinx_gallery_thumbnail_panel = (1, 6)
# sphinx_gallery_alt_1 = "Measured and nominal forces at three balls and at the wall"
# sphinx_gallery_alt_2 = "Measured and adjusted forces at three balls and at the wall"
import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")

# %%
# The data
# --------
#
# hertzchain has an example experiment: twenty steel balls, four sensors, and an equal ball as
# striker.  Its data are synthetic, with noise and with sensors that are not ideal.  Replace the
# two names by those of your files.

_, chain_file = hc.example_experiment()
data_file = chain_file.parent / "fast.csv"
print("\n".join(data_file.read_text().splitlines()[1:5]))

# %%
# The header names sensors and units.  The sensor in ball 11 has no calibration, so its column is
# in millivolts.

traces = hc.load_traces(data_file)
traces

# %%
# The comparison
# --------------
#
# Simulate the chain for the duration of the measurement.  ``Run.compare`` finds the trigger time,
# scales the signal of an uncalibrated sensor, and reports peaks, arrivals and the difference of
# every sensor in units of its measured peak.

run = hc.simulate(hc.load_chain(chain_file), until=600e-6, times=1201)
compared = run.compare(traces)
print(compared)

# %%
# The same as a figure:

compared.plot()

# %%
# The simulated pulses are too high, and the reflected pulse arrives too early in ball 16: the
# nominal contacts are too stiff and lose too little energy.  The speed of a pulse depends on the
# stiffness, and its decay on the loss, but a loss also slows the pulse down.  Therefore, adjust
# both together:

from scipy.optimize import minimize

nominal = hc.load_chain(chain_file)


def compare(stiffness, loss_time):
    """Compare the chain with a changed stiffness and loss time [us] with the traces."""
    chain = nominal.replace(
        stiffness=stiffness * nominal.stiffness, loss=hc.Viscoelastic(1e-6 * loss_time)
    )
    return hc.simulate(chain, until=600e-6, times=1201).compare(traces)


def differ(values):
    """Mean difference of all sensors, in units of their measured peaks."""
    return np.mean(list(compare(*values).differences.values()))


stiffness, loss_time = minimize(
    differ, x0=(1.0, 0.5), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-5}
).x
better = compare(stiffness, loss_time)
better.plot()

# %%
# Answer
# ------
#
# The nominal chain does not agree with the data, and two adjusted numbers remove most of the
# difference.  They are not the true values, because they also compensate for the unknown gains and
# delays of the sensors and for the error of the nominal velocity.  The next notebook fits all
# parameters at once, with errors.

print(f"{'sensor':10}{'nominal':>10}{'adjusted':>10}")
for sensor, difference in compared.differences.items():
    print(f"{sensor:10}{difference:10.1%}{better.differences[sensor]:10.1%}")
print(f"adjusted: stiffness times {stiffness:.3f}, loss time {loss_time:.2f} us")
