"""The page on JSON describes all keys of fits and forecasts."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy_row import FREE, chain, traces

import hertzchain as hc

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "json.md"
# Keys that only options of the command or all commands add.
OF_OPTIONS = {"comparison", "defects", "fit_with_defect", "fit_with_best_law", "posterior"}


def described(command):
    """Keys in the first column of the table of a command."""
    page = PAGE.read_text(encoding="utf-8")
    (part,) = re.findall(rf"## `hertzchain {command} --json`\n(.*?)(?=\n## |\Z)", page, re.S)
    rows = re.findall(r"^\| (`.*?) \|", part, re.M)
    return {key for row in rows for key in re.findall(r"`(\w+)`", row)} - {"schema_version"}


@pytest.fixture(scope="module")
def result():
    return hc.fit(traces(), chain(), free=FREE)


def test_the_page_has_the_keys_of_a_fit(result):
    assert described("fit") - OF_OPTIONS == set(result.as_dict())


def test_the_page_has_the_keys_of_a_forecast():
    plan = hc.forecast(chain(), ["ball 5"], noise=0.02, interval="1 us", free=["stiffness"])
    assert described("forecast") == set(plan.as_dict())


def test_a_fit_that_an_error_of_the_data_explains_says_so(result):
    assert result.as_dict()["explained"] is False
    attenuated = hc.Traces.from_arrays(
        result.traces.shots[0].times,
        {f"{each.name} [N]": each.values * (0.1 if each.name == "wall" else 1.0)
         for _, each in result.traces},
    )  # fmt: skip
    found = hc.fit(attenuated, chain(), free=FREE, starts=1, diagnose=False)
    assert found.as_dict()["explained"] is True
    assert any("wall" in each for each in found.as_dict()["warnings"])
    assert np.isfinite(found.chi2)
