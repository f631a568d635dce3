"""
Does the simulation agree with your measured traces?
====================================================

You have a CSV file with the signals of force sensors and a description of the chain.  Before any
fit, plot both and see where they differ.
"""

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
# stiffness, and its decay on the loss.  Adjust first one and then the other:

from scipy.optimize import minimize_scalar


def differ(chain):
    """Mean difference of all sensors, in units of their measured peaks."""
    found = hc.simulate(chain, until=600e-6, times=1201).compare(traces).differences
    return np.mean(list(found.values()))


nominal = hc.load_chain(chain_file)
stiffness = minimize_scalar(
    lambda factor: differ(nominal.replace(stiffness=factor * nominal.stiffness)),
    bounds=(0.85, 1.1), method="bounded", options={"xatol": 1e-3},
).x
softer = nominal.replace(stiffness=stiffness * nominal.stiffness)
loss_time = minimize_scalar(
    lambda time: differ(softer.replace(loss=hc.Viscoelastic(time))),
    bounds=(0.1e-6, 1.5e-6), method="bounded", options={"xatol": 1e-8},
).x
adjusted = softer.replace(loss=hc.Viscoelastic(loss_time))

better = hc.simulate(adjusted, until=600e-6, times=1201).compare(traces)
better.plot()

# %%
# Answer
# ------
#
# The nominal chain does not agree with the data; two adjusted numbers remove most of the
# difference.  The rest are effects of the sensors.  The next notebook fits all parameters at once,
# with errors.

print(f"{'sensor':10}{'nominal':>10}{'adjusted':>10}")
for sensor, difference in compared.differences.items():
    print(f"{sensor:10}{difference:10.1%}{better.differences[sensor]:10.1%}")
print(f"adjusted: stiffness times {stiffness:.3f}, loss time {1e6 * loss_time:.2f} us")
