"""Standard errors of the arrivals of noisy, sampled signals."""

import math

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.fitting.crossings import arrival_error, reached

# The pulse cos^6(pi t / 2) reaches its half at this time.
HALF = -2.0 / math.pi * math.acos(2.0 ** (-1.0 / 6.0))


def pulse(times):
    return np.where(np.abs(times) < 1.0, np.cos(0.5 * np.pi * np.clip(times, -1.0, 1.0)) ** 6, 0.0)


@pytest.mark.parametrize("step", [0.5, 0.3, 0.1, 0.03, 0.003])
@pytest.mark.parametrize("noise", [1e-6, 0.01, 0.03])
def test_errors_cover_the_scatter_of_arrivals(step, noise):
    """Coarse steps with an interpolation error are overestimated most."""
    rng = np.random.default_rng(1)
    deviations, errors = [], []
    for _ in range(300):
        times = np.arange(-2.0, 2.0, step) + rng.uniform(0.0, step)
        seen = 5.0 * pulse(times) + 5.0 * noise * rng.standard_normal(len(times))
        deviations.append(reached(times, seen, 0.5 * seen.max()) - HALF)
        errors.append(arrival_error(times, 3.0 * pulse(times), seen.max(), 5.0 * noise))
    ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(deviations)))
    assert 1.0 < ratio < 4.0
    if noise == 0.03 and step <= 0.1:
        assert ratio < 1.8


def test_a_comparison_states_the_errors_of_arrivals():
    traces, chain = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
    compared = run.compare(traces)
    errors = [each.arrival_error for each in compared.sensors]
    low, high = (f"{1e6 * each:.2g} us" for each in (min(errors), max(errors)))
    text = f"errors of measured arrivals, from noise and sampling: {low} to {high}"
    assert text in compared.summary(width=None).splitlines()
    # Samples are 1 us apart, and pulses are resolved.
    assert 1e-8 < min(errors) < max(errors) < 1e-6 / math.sqrt(12.0)
