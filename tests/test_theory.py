import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hertzchain as hc
from hertzchain.chain.tapers import TAPERS
from hertzchain.paper.published import published_correction, published_ratio
from hertzchain.theory.bca import (
    backward_linear_prefactor,
    bca_velocity_closed_form,
    exponential_rates,
    forward_linear_momentum_slope,
)
from hertzchain.theory.modified_bca import (
    PRINTED_EXPONENTIAL,
    PRINTED_RATIO,
    RatioCorrection,
    printed_velocity,
)

RATES = {"backward-linear": 0.9, "forward-linear": 0.009}


@pytest.mark.parametrize("taper", TAPERS)
def test_product_equals_closed_form(taper):
    rate = RATES.get(taper, 0.06)
    product = hc.bca(hc.Chain.tapered(taper, rate, beads=100)).velocity
    np.testing.assert_allclose(bca_velocity_closed_form(taper, rate, 100), product, rtol=5e-12)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@given(st.lists(st.floats(0.1, 10.0), min_size=2, max_size=30))
def test_each_collision_conserves_energy_and_momentum(radii):
    chain = hc.Chain.from_radii(radii)
    m, v = chain.masses, hc.bca(chain).velocity
    after = v[:-1] - m[1:] / m[:-1] * v[1:]
    np.testing.assert_allclose(
        m[:-1] * after**2 + m[1:] * v[1:] ** 2, m[:-1] * v[:-1] ** 2, rtol=1e-10
    )


@pytest.mark.parametrize(
    ("rate", "prefactor"),
    [(0.1, 28.262858), (0.3, 4.361752), (0.5, 1.642384), (0.7, .814389), (0.9, .465657),
     (1.0, .364974)],
)  # fmt: skip
def test_prefactor_of_backward_linear_tapers(rate, prefactor):
    assert backward_linear_prefactor(rate) == pytest.approx(prefactor, abs=6e-7)
    velocity = bca_velocity_closed_form("backward-linear", rate, 100_000)
    assert velocity[-1] * 1e5**1.5 == pytest.approx(prefactor, rel=2e-4)


def test_exponential_rates_are_those_of_the_product():
    for taper, q in (("backward-exponential", 0.08), ("forward-exponential", 0.06)):
        pulse = hc.bca(hc.Chain.tapered(taper, q, beads=50))
        for quantity, rate in exponential_rates(taper, q).items():
            values = pulse.column(quantity)
            np.testing.assert_allclose(np.diff(np.log(values)), rate, rtol=1e-11)
    with pytest.raises(hc.InputError, match="no constant rate"):
        exponential_rates("forward-linear", 0.01)


def test_slope_of_forward_linear_tapers_is_that_of_small_rates():
    rate = 1e-6
    momentum = hc.bca(hc.Chain.tapered("forward-linear", rate, beads=3)).momentum
    slope = momentum[1] - momentum[0]
    assert forward_linear_momentum_slope(rate) == pytest.approx(slope, rel=1e-5)


def test_residence_times_of_equal_beads():
    pulse = hc.bca(hc.Chain.uniform(10))
    np.testing.assert_allclose(pulse.residence, 1.21941878235, rtol=1e-11)
    assert 1 / pulse.residence[0] == pytest.approx(0.820062816, abs=1e-9)


@pytest.mark.parametrize(
    ("taper", "rate", "worst"),
    [("backward-exponential", 0.3, 0.055), ("forward-exponential", 0.05, 0.055),
     ("backward-linear", 0.9, 0.055), ("forward-linear", 0.009, 0.055)],
)  # fmt: skip
def test_residence_times_agree_with_the_integration(taper, rate, worst):
    chain = hc.Chain.tapered(taper, rate, beads=60)
    comparison = hc.bca(chain).compare(hc.propagate(chain))
    residence = np.abs(comparison.errors("residence"))[1:-2]
    assert residence.max() < worst
    # The velocity is what the BCA does not get right: Sec. 2 of the paper.
    assert comparison.worst("velocity", first_bead=10) > 0.3


def test_underflow_is_named():
    with pytest.raises(hc.InputError, match=r"velocity of bead 1\d\d is 0 by BCA .* underflows"):
        hc.bca(hc.Chain.from_radii([1.0, 0.01] * 100))


def test_printed_constants_are_those_of_the_published_data():
    for taper, correction in PRINTED_EXPONENTIAL.items():
        assert correction == published_correction(taper)
    for taper, ratio in PRINTED_RATIO.items():
        assert ratio == published_ratio(taper).value


def test_printed_formulas_by_hand():
    k = np.array([10.0])
    be = (0.5 * (1 + 0.95**-3)) ** -9 / (1.64 * 0.05**0.0259 + 0.211 * 0.05**1.83 * 10)
    fe = (0.5 * (1 + 1.05**-3)) ** -9 / (1.32 * 0.05**0.0252 + 11.1 * 0.05**2.57 * 10)
    assert printed_velocity("backward-exponential", 0.05, k)[0] == pytest.approx(be, rel=1e-13)
    assert printed_velocity("forward-exponential", 0.05, k)[0] == pytest.approx(fe, rel=1e-13)
    assert printed_velocity("backward-linear", 0.3, k)[0] == pytest.approx(2 / 3 / 10**1.5)
    fl = 0.68 * (1 - 10 / 101) ** 1.5
    assert printed_velocity("forward-linear", 0.01, k)[0] == pytest.approx(fl, rel=1e-13)
    for taper, rate, beads in (
        ("forward-linear", 0.5, [2.0, 4.0]),
        ("backward-exponential", 1.5, [2.0, 3.0]),
        ("backward-linear", 0.1, [0.0]),
    ):
        with pytest.raises(hc.InputError, match=f"{taper} taper|bead must be .* at least 1"):
            printed_velocity(taper, rate, np.array(beads))


def test_modified_bca_by_coefficients():
    chain = hc.Chain.tapered("forward-linear", 0.005, beads=50)
    exact = hc.propagate(chain)
    printed = hc.modified_bca(chain, "printed").compare(exact)
    calibrated = hc.modified_bca(chain).compare(exact)
    assert printed.errors("velocity")[29] < -0.3
    assert np.abs(calibrated.errors("velocity")[4:45]).max() < 0.03
    own = hc.modified_bca(chain, RatioCorrection(0.5))
    np.testing.assert_allclose(own.velocity[1:], 0.5 * hc.bca(chain).velocity[1:], rtol=1e-15)
    assert own.velocity[0] == 1.0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.modified_bca(hc.Chain.uniform(9)), "requires a tapered chain"),
        (
            lambda: hc.modified_bca(
                hc.Chain.tapered("forward-linear", 0.01, beads=9, exponent=2.0)
            ),
            "Hertz contacts",
        ),
        (
            lambda: hc.modified_bca(
                hc.Chain.tapered("forward-linear", 0.005, beads=9), "calibratd"
            ),
            "did you mean 'calibrated'",
        ),
    ],
)
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_slope_of_the_paper_exceeds_that_of_the_exact_product():
    momentum = hc.bca(hc.Chain.tapered("forward-linear", 0.01, beads=2)).momentum
    ratio = forward_linear_momentum_slope(0.01) / (momentum[1] - momentum[0])
    assert ratio == pytest.approx(1.01**1.5, rel=2e-4)


def test_rates_outside_the_fitted_ones_are_announced():
    chain = hc.Chain.tapered("backward-exponential", 0.5, beads=9)
    with pytest.warns(hc.ModelRangeWarning, match=r"q = 0\.01\.\.0\.08, but .* 0\.5"):
        hc.modified_bca(chain)


def test_functions_of_a_taper_check_it():
    for call in (
        lambda: exponential_rates("bakward-exponential", 0.1),
        lambda: exponential_rates("backward-exponential", 1.5),
        lambda: backward_linear_prefactor(-0.3),
        lambda: forward_linear_momentum_slope(2.0),
    ):
        with pytest.raises(hc.InputError):
            call()


@pytest.mark.parametrize(("chain", "advice"), [
    (hc.Chain.dimer(0.4, beads=30), "use propagate or simulate"),
    (hc.Chain.dimer(radii=[1.0, 0.7], beads=30), "use propagate or simulate"),
    (hc.Chain.dimer(radii=[1.0, 0.9], beads=200), "use propagate or simulate"),
    (hc.Chain.uniform(30), "use bca or theory.two_thirds_bca"),
])  # fmt: skip
def test_the_modified_bca_advises_no_theory_that_is_wrong(chain, advice):
    """The BCA warns about alternating masses, and its velocities are too small by a factor."""
    with pytest.raises(hc.InputError, match=advice):
        hc.modified_bca(chain)
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always")
        hc.bca(chain)
    assert bool(raised) == ("simulate" in advice)


@pytest.mark.parametrize(
    "theory", [hc.bca, hc.modified_bca, hc.theory.two_thirds_bca, hc.hard_sphere]
)
def test_a_theory_without_an_estimated_error_says_so(theory):
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=30)
    pulse = theory(chain)
    assert pulse.velocity_error is None
    assert "does not estimate its error" in str(pulse)
    assert "does not estimate its error" in pulse._repr_html_()
    for other in (hc.local_rate(chain), hc.propagate(chain)):
        assert "does not estimate" not in str(other)


@pytest.mark.parametrize("taper", ["backward-linear", "forward-exponential"])
def test_the_closed_form_of_equal_beads_is_constant(taper):
    np.testing.assert_array_equal(bca_velocity_closed_form(taper, 0.0, 5), np.ones(5))
