"""The error estimate of the local-rate law in long chains, compared with `propagate`."""

import warnings

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.errors import ModelRangeWarning
from hertzchain.theory.growth_errors import COVERED, errors_per_bead
from hertzchain.theory.universal_functions import universal_functions

# Tapers and rates.
TAPERS = [
    *[("forward-exponential", q) for q in (0.005, 0.02, 0.05, 0.07, 0.09, 0.1, 0.11)],
    *[("backward-exponential", q) for q in (0.005, 0.02, 0.05, 0.1)],
    *[("backward-linear", S) for S in (0.005, 0.01, 0.02, 0.03, 0.1, 0.5)],
]


@pytest.mark.parametrize(("taper", "rate"), TAPERS)
@pytest.mark.parametrize("beads", [300, 1000, 2000])
def test_the_estimate_covers_long_tapers(taper, rate, beads):
    chain = hc.Chain.tapered(taper, rate, beads=beads)
    law, exact = hc.local_rate(chain), hc.propagate(chain)
    error = np.abs(law.compare(exact).errors("velocity"))[1:]
    assert np.mean(error <= law.velocity_error[1:]) >= 0.95
    assert (error <= 1.6 * law.velocity_error[1:]).all()


@pytest.mark.parametrize(
    ("taper", "rate"),
    [("forward-exponential", each) for each in (0.07, 0.09, 0.11)]
    + [("backward-linear", each) for each in (0.01, 0.02, 0.03)],
)
def test_the_estimate_of_long_tapers_is_not_much_too_large(taper, rate):
    chain = hc.Chain.tapered(taper, rate, beads=1000)
    law = hc.local_rate(chain)
    error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))[1:]
    assert (error / law.velocity_error[1:])[200:].max() > 0.4


def test_the_estimate_covers_long_forward_linear_tapers():
    for rate, beads in ((0.0005, 1800), (0.001, 900), (0.002, 450)):
        chain = hc.Chain.tapered("forward-linear", rate, beads=beads)
        law = hc.local_rate(chain)
        error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))[1:]
        assert (error <= law.velocity_error[1:]).all()


def test_estimates_of_chains_of_interpolated_exponents_grow_with_their_length():
    chain = hc.Chain.tapered("forward-exponential", 0.06, beads=1500, exponent=1.41)
    with pytest.warns(ModelRangeWarning, match="estimated velocity error exceeds 0.5%"):
        law = hc.local_rate(chain)
    error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))[1:]
    assert (error <= law.velocity_error[1:]).all()
    assert error[-10] > 2e-3
    with pytest.warns(ModelRangeWarning, match="estimated velocity error exceeds 0.5%"):
        hc.local_rate_gradient(chain, bead=1400)


def test_short_chains_have_the_estimate_without_accumulated_errors():
    long = hc.Chain.tapered("forward-exponential", 0.1, beads=1000)
    estimate = hc.local_rate(long).velocity_error
    # The first order of an accumulated error is its rate per bead.
    growth = np.diff(np.log1p(estimate[COVERED:-10]))
    np.testing.assert_allclose(growth, errors_per_bead(-np.log(1.1), 1.5), rtol=1e-6)
    assert np.ptp(estimate[30:COVERED]) < 1e-7


@pytest.mark.parametrize("exponent", [1.3, 1.35, 1.4, 1.45, 1.52, 1.6, 1.9, 2.3])
@pytest.mark.parametrize("part", [0.4, 0.7, 0.85, 0.95])
def test_forward_tapers_of_interpolated_exponents_have_no_large_error_without_a_warning(
    exponent, part
):
    (lowest, _) = universal_functions(exponent).range
    for beads in (24, 41, 60):
        rates = part * lowest * np.arange(beads)
        chain = hc.Chain.from_radii(np.exp(rates), exponent=exponent)
        with warnings.catch_warnings(record=True) as raised:
            warnings.simplefilter("always")
            law = hc.local_rate(chain)
        error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))
        assert raised or error.max() < 0.005
        known = np.isfinite(law.velocity_error)
        # Without the errors that accumulate, those at 1.35 are ten times the estimate, and without
        # lost maxima, those of the last beads at 1.4 are fifty times.
        assert (error <= np.maximum(4.0 * law.velocity_error, 3e-4))[known].all()


@pytest.mark.parametrize(
    ("exponent", "rate"), [(1.5, -0.1), (1.5, 0.05), (2.0, 0.3), (1.33, -0.04)]
)
def test_the_tabulated_error_is_that_of_the_steady_rate(exponent, rate):
    beads = 400
    chain = hc.Chain.from_radii(np.exp(rate * np.arange(beads)), exponent=exponent)
    logs = np.log(hc.propagate(chain).velocity)
    taper = "forward-exponential" if rate < 0.0 else "backward-exponential"
    law = hc.theory.steady_rates(taper, abs(np.expm1(-rate)), exponent=exponent)["velocity"]
    error = abs(law - (logs[350] - logs[150]) / 200)
    assert error <= 1.3 * errors_per_bead(np.array([rate]), exponent)[0] + 1e-11
