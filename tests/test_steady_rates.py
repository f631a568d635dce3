"""Rates of exponential tapers by the local-rate law, against simulations."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.theory import exponential_rates, steady_rates


@pytest.mark.parametrize("exponent", [1.5, 2.0])
@pytest.mark.parametrize(("taper", "rate"), [
    ("backward-exponential", 0.02), ("backward-exponential", 0.2), ("backward-exponential", 0.6),
    ("forward-exponential", 0.02), ("forward-exponential", 0.1),
])  # fmt: skip
def test_steady_rates_are_those_of_simulated_pulses(taper, rate, exponent):
    chain = hc.Chain.tapered(taper, rate, beads=60, exponent=exponent)
    pulse = hc.propagate(chain, rtol=1e-10)
    for name, value in steady_rates(taper, rate, exponent=exponent).items():
        along = getattr(pulse, name)
        assert value == pytest.approx(np.log(along[40] / along[39]), abs=2e-6)


def test_steady_rates_of_equal_beads_are_zero_and_near_those_of_the_bca():
    for taper in ("backward-exponential", "forward-exponential"):
        exact, bca = steady_rates(taper, 1e-3), exponential_rates(taper, 1e-3)
        # The difference is of second order in the rate.
        assert exact["velocity"] == pytest.approx(bca["velocity"], abs=2e-6)


@pytest.mark.parametrize(("arguments", "said"), [
    (("forward-exponential", 0.3), "must be at most 0.179, .* got 0.3; use propagate"),
    (("backward-exponential", 0.7), "must be at most 0.667, .* got 0.7; use propagate"),
    (("forward-linear", 0.1), "has no constant rate"),
])  # fmt: skip
def test_errors(arguments, said):
    with pytest.raises(hc.InputError, match=said):
        steady_rates(*arguments)


def test_an_exponent_without_table():
    with pytest.raises(hc.InputError, match="has no tables for the exponent 5"):
        steady_rates("forward-exponential", 0.1, exponent=5.0)
