import statistics
import tomllib

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.calibration import calibrate, calibrated_toml, fit_line
from hertzchain.chain.tapers import TAPERS
from hertzchain.theory.modified_bca import calibrated_corrections


@pytest.mark.parametrize("taper", TAPERS)
def test_the_stored_constants_are_what_calibration_finds(taper):
    found, stored = calibrate(taper).correction, calibrated_corrections()[taper]
    for name, value in vars(found).items():
        assert getattr(stored, name) == pytest.approx(value, rel=1e-5)


def test_chains_are_the_samples_of_a_ratio():
    alone = [calibrate("backward-linear", rates=[rate], beads=40, window=(5, 30))
             for rate in (0.2, 0.5, 0.8)]  # fmt: skip
    together = calibrate("backward-linear", rates=[0.2, 0.5, 0.8], beads=40, window=(5, 30))
    ratios = [each.correction.ratio for each in alone]
    assert together.standard_errors["ratio"] == pytest.approx(
        statistics.stdev(ratios) / 3**0.5, rel=1e-6
    )
    assert np.isnan(alone[0].standard_errors["ratio"])
    assert alone[0].as_dict()["constants"]["ratio"]["standard_error"] is None
    assert "# +- unknown" in calibrated_toml(alone[:1])


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


def test_the_printed_constants_are_shown():
    result = calibrate("forward-exponential", rates=[0.02, 0.04, 0.06], beads=60, window=(5, 40))
    assert result.printed == {"c0": 1.32, "x": 0.0252, "d0": 11.1, "y": 2.57}
    assert list(result.constants) == list(result.standard_errors) == list(result.printed)
    assert result.as_dict()["constants"]["d0"]["printed"] == 11.1
    assert len(result.worst_by_rate) == 3
    assert max(result.worst_by_rate) == result.worst_error > result.rms_error > 0.0


def test_toml_brings_back_the_constants():
    result = calibrate("forward-linear", rates=[0.004, 0.008], beads=50, window=(5, 40))
    table = tomllib.loads(calibrated_toml([result]))["corrections"]
    assert list(table) == ["forward-linear"]
    # Six digits are written.
    assert table["forward-linear"]["ratio"] == pytest.approx(result.correction.ratio, rel=5e-6)


def test_progress_counts_chains():
    told = []
    calibrate("backward-linear", rates=[0.2, 0.4], beads=20, window=(5, 15),
              progress=lambda done, total: told.append((done, total)))  # fmt: skip
    assert told[-1] == (2, 2)


def test_line_against_known_errors():
    x = np.array([0.0, 1.0, 2.0, 3.0])
    coefficients, errors = fit_line(x, np.array([1.0, 3.0, 2.0, 4.0]))
    # By hand: slope 0.8, intercept 1.3, residual variance 0.9.
    np.testing.assert_allclose(coefficients, [1.3, 0.8], rtol=1e-12)
    np.testing.assert_allclose(errors, np.sqrt([0.9 * (1 / 4 + 2.25 / 5), 0.9 / 5]), rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"taper": "linear"}, "unknown taper 'linear'"),
        ({"taper": "forward-linear", "window": (5, 100)}, "must contain at least three"),
        ({"taper": "forward-linear", "window": (9, 10)}, "at least three beads"),
        ({"taper": "forward-exponential", "rates": [0.01, 0.02]}, "at least 3 different rates"),
        ({"taper": "forward-exponential", "rates": [0.05] * 3}, "different rates"),
        ({"taper": "forward-linear", "beads": 200}, "reach zero at bead"),
        ({"taper": "forward-linear", "rates": ["a"]}, "must be a number"),
        ({"taper": "forward-linear", "window": (5.5, 20)}, "first and a last bead"),
        ({"taper": "forward-linear", "window": (2, 4, 5)}, "first and a last bead"),
    ],
)
def test_bad_input_is_rejected(options, said):
    with pytest.raises(hc.InputError, match=said):
        calibrate(**options)
