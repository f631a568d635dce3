"""Summaries of fits, comparisons and forecasts have lines of at most 88 columns."""

import re

import pytest

import hertzchain as hc
from hertzchain.fitting.loss_comparison import LossComparison, LossFit
from hertzchain.representation import SUMMARY_WIDTH, folded


@pytest.fixture(scope="module")
def result():
    return hc.fit(*hc.example_experiment())


def unbroken(text):
    return re.sub(r"\n {4,}", " ", text)


def test_long_lines_are_broken_without_changing_their_words(result):
    whole = result.summary(width=None)
    assert max(map(len, whole.splitlines())) > SUMMARY_WIDTH
    lines = result.summary().splitlines()
    assert max(map(len, lines)) <= SUMMARY_WIDTH
    assert unbroken("\n".join(lines)) == whole
    assert any(line.startswith("    ") for line in lines)


def test_width_can_be_chosen(result):
    lines = result.summary(width=50).splitlines()
    assert 45 <= max(map(len, lines)) <= 50


def test_impossible_widths_are_rejected(result):
    for width in (39, 0, 60.5, "wide"):
        with pytest.raises(hc.InputError, match="width must be a whole number of at least 40"):
            result.summary(width=width)


def test_parameters_of_loss_laws_are_below_their_heading():
    data, chain = hc.example_experiment()
    free = ["loss.gamma", "loss.alpha", "time_offset", "gain[*]"]
    lossy = hc.load_chain(chain).replace(loss=hc.VelocityPower(25.0, 1.8))
    result = hc.fit(data, lossy, free=free, starts=1, diagnose=False)
    fits = (LossFit("velocity-power", result, bic=0.0), LossFit("dashpot", result, bic=20.0))
    compared = LossComparison(fits)
    lines = compared.summary(width=70).splitlines()
    column = lines[0].index("parameters")
    broken = [line for line in lines if line.startswith(" " * 5)]
    assert all(re.match(" *", line)[0] == " " * column for line in broken)
    assert broken
    assert max(map(len, lines)) <= 76
    assert max(map(len, compared.summary().splitlines())) <= SUMMARY_WIDTH


def test_forecasts_are_broken():
    chain = hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")
    plan = hc.forecast(chain, ["ball 5"], noise=0.02, interval="1 us", until="300 us")
    assert max(map(len, plan.summary(width=None).splitlines())) > SUMMARY_WIDTH
    assert max(map(len, plan.summary().splitlines())) <= SUMMARY_WIDTH


def test_waves_are_broken():
    masses = [4.0] + [1.0] * 49
    chain = hc.Chain.uniform(50).replace(masses=masses, right_wall=hc.Wall.rigid())
    shown = str(hc.simulate(chain, until=65.0, times=1040).waves())
    assert "merged" in shown
    assert max(map(len, shown.splitlines())) <= SUMMARY_WIDTH


def test_numbers_stay_with_their_units():
    assert folded("a time of 12 us", 13) == "a time of\n    12 us"
    assert (
        folded("x = 1.0 +- 0.1 and y = 2.0 +- 0.2", 20) == "x = 1.0 +- 0.1 and\n    y = 2.0 +- 0.2"
    )


def test_rows_of_tables_are_broken_only_on_request():
    row = "  name  1.0 and 2.0 and 3.0"
    assert folded(row, 20) == row
    assert folded(row, 20, below=8) == "  name  1.0 and 2.0\n        and 3.0"
