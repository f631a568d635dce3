import numpy as np
import pytest

import hertzchain as hc
from hertzchain.calibration import calibrate, line
from hertzchain.chain import TAPERS
from hertzchain.theory.modified_bca import calibrated_corrections


@pytest.mark.parametrize("taper", TAPERS)
def test_the_stored_constants_are_what_calibration_finds(taper):
    found, stored = calibrate(taper).correction, calibrated_corrections()[taper]
    for name, value in vars(found).items():
        assert getattr(stored, name) == pytest.approx(value, rel=1e-5)


def test_the_paper_found_about_the_same():
    # Own words of the paper: ratio 2/3 and 0.680 for linear tapers.
    assert calibrate("backward-linear").correction.ratio == pytest.approx(2 / 3, rel=0.02)
    assert calibrate("forward-linear").correction.ratio == pytest.approx(0.680, rel=0.01)
    forward = calibrate("forward-exponential", window=(15, 50)).correction
    assert forward.y == pytest.approx(2.57, rel=0.01)
    assert forward.d0 == pytest.approx(11.1, rel=0.03)


def test_windows_and_rates_are_arguments():
    early = calibrate("backward-linear", rates=[0.5], window=(5, 20), beads=40)
    late = calibrate("backward-linear", rates=[0.5], window=(40, 60), beads=80)
    assert early.correction.ratio > late.correction.ratio + 0.03
    assert early.residuals.shape == (1, 16)
    assert early.worst_error == np.abs(early.residuals).max()


def test_line_against_known_errors():
    x = np.array([0.0, 1.0, 2.0, 3.0])
    coefficients, errors = line(x, np.array([1.0, 3.0, 2.0, 4.0]))
    # By hand: slope 0.8, intercept 1.3, residual variance 0.9.
    np.testing.assert_allclose(coefficients, [1.3, 0.8], rtol=1e-12)
    np.testing.assert_allclose(errors, np.sqrt([0.9 * (1 / 4 + 2.25 / 5), 0.9 / 5]), rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"taper": "linear"}, "unknown taper 'linear'"),
        ({"taper": "forward-linear", "window": (5, 100)}, "before the free end"),
        ({"taper": "forward-linear", "window": (9, 10)}, "at least three beads"),
        ({"taper": "forward-exponential", "rates": [0.01, 0.02]}, "at least 3 different rates"),
        ({"taper": "forward-exponential", "rates": [0.05] * 3}, "different rates"),
        ({"taper": "forward-linear", "rates": ["a"]}, "must be a number"),
        ({"taper": "forward-linear", "window": (5.5, 20)}, "first and a last bead"),
        ({"taper": "forward-linear", "window": (2, 4, 5)}, "first and a last bead"),
    ],
)
def test_bad_input_is_refused(options, said):
    with pytest.raises(hc.InputError, match=said):
        calibrate(**options)
