"""Gaps that no difference between delays of sensors shows, in data integrated by SciPy."""

import numpy as np
import pytest
from scipy_row import FREE, chain, forces, recorded, traces

import hertzchain as hc
from hertzchain.fitting import gap_causes
from hertzchain.fitting.fit import fit_experiment, fitted
from hertzchain.fitting.gap_causes import cause_of, fit_of
from hertzchain.fitting.rough_gaps import gap_names, is_in_front, rough_gap, sizes_of

LAST = 15


def undiagnosed(data):
    """The fit without a gap."""
    return fit_experiment(data, chain(), lambda result, *_: result, free=FREE)


def best_of(result, names):
    """The best rough fit of a gap at one of these contacts."""
    found = [
        rough_gap(result, name, sizes_of(name, result))
        for name in gap_names(result.chain) if str(name) in names
    ]  # fmt: skip
    return min((each for each in found if each is not None), key=lambda each: each.cost)


@pytest.mark.long
def test_a_large_gap_in_front_of_the_first_sensor_is_found_but_not_its_size():
    result = undiagnosed(traces(gap=20e-6, behind=2))
    assert not result.describes
    gap = best_of(result, ["gap[1-2]", "gap[2-3]", "gap[3-4]"])
    assert str(gap.name) == "gap[2-3]"
    cause = cause_of(gap, fit_of(gap, fitted))
    assert cause.result.describes
    assert cause.what.startswith("gap[2-3] of at least ")
    least = float(cause.what.split()[-2])
    assert cause.what.endswith(" um")
    assert 6.0 < least < 20.0  # that of 6 um is determined, see test_flat_valleys
    assert cause.advice.startswith("check for a gap between balls 2 and 3. Larger ones only delay")
    places = [str(name) for name in gap_names(chain()) if is_in_front(name, result)]
    assert places == [f"gap[{k}-{k + 1}]" for k in range(5)]


@pytest.fixture(scope="module")
def medium():
    """The fit without a gap of 8 um in front of the first sensor."""
    return undiagnosed(traces(gap=8e-6, behind=2))


@pytest.mark.long
def test_a_gap_of_twice_the_unit_of_the_motion_is_found_in_front_of_the_first_sensor(medium):
    # From half or five times the unit, rough fits end at another size.
    gap = best_of(medium, ["gap[1-2]", "gap[2-3]", "gap[3-4]"])
    assert str(gap.name) == "gap[2-3]"
    assert gap.size == pytest.approx(8e-6, rel=0.1)
    assert gap.cost < 0.1 * medium.chi2


@pytest.mark.long
def test_neighbours_of_the_contact_that_rough_fits_prefer_are_fitted(medium, monkeypatch):
    near = gap_names(medium.chain)[1:4]
    monkeypatch.setattr(gap_causes, "gap_names", lambda _: near)
    # Rough fits that end too early may prefer a neighbour.
    monkeypatch.setattr(gap_causes, "_likely", lambda _, rough: [rough[2]])
    monkeypatch.setattr(gap_causes, "PROMISING", -1.0)
    causes = list(gap_causes.gap_causes(medium, {}, fitted))
    names = [str(cause.names[0]) for cause in causes]
    assert names == ["gap[3-4]", "gap[2-3]", "gap[1-2]"]
    best = min(causes, key=lambda cause: cause.result.chi2)
    assert best is causes[1]
    assert best.result.describes
    size, error = best.result.values["gap[2-3]"], best.result.errors["gap[2-3]"]
    assert abs(size - 8e-6) < 3.5 * error


def test_only_a_chain_with_a_wall_has_a_gap_there():
    assert str(gap_names(chain())[-1]) == "right_wall.gap"
    assert str(gap_names(chain().replace(right_wall=None))[-1]) == "gap[14-15]"


@pytest.mark.parametrize(("behind", "name", "words"), [
    (7, "gap[7-8]", "balls 7 and 8"),
    pytest.param(LAST, "right_wall.gap", "the last ball and the wall", marks=pytest.mark.long),
])  # fmt: skip
def test_a_fit_names_a_small_gap_rather_than_a_delay_that_looks_like_it(behind, name, words):
    # Residuals are within the uncertainty of noise that is correlated, so that samples count less.
    result = hc.fit(traces(1, gap=0.03e-6, behind=behind), chain(), free=FREE)
    assert result.goodness.accepted
    (advice,) = result.advice
    assert advice.startswith(f"with {name} = 0.0")
    assert f"check for a gap between {words}" in advice


@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(3, 10))]
)
def test_no_gap_is_named_in_a_row_without_one(seed):
    assert not hc.fit(traces(seed), chain(), free=FREE).advice


def test_a_delay_is_not_called_a_gap():
    def late(columns):
        """Columns in which the signal of the wall is late by 0.14 samples, 0.098 us."""
        at = np.arange(len(columns["wall [N]"]))
        return columns | {"wall [N]": np.interp(at - 0.14, at, columns["wall [N]"])}

    (advice,) = hc.fit(traces(1, change=late), chain(), free=FREE).advice
    assert advice.startswith("with delay[wall] = 0.09")
    assert "gap" not in advice


@pytest.mark.long
@pytest.mark.parametrize(("gap", "behind", "what", "words"), [
    (20e-6, 2, "gap[2-3] of at least 1", "balls 2 and 3"),
    (2e-6, LAST, "right_wall.gap = 1.99", "the last ball and the wall"),
])  # fmt: skip
def test_a_fit_names_a_gap_that_no_delay_shows(gap, behind, what, words):
    (advice,) = hc.fit(traces(gap=gap, behind=behind), chain(), free=FREE).advice
    assert advice.startswith(f"with {what}")
    assert "and the model describes the data: check for a gap between " + words in advice


@pytest.mark.long
def test_a_fit_to_two_sensors_names_a_small_gap_between_them():
    signals = {name: forces(gap=0.3e-6, behind=8)[name] for name in ("ball 5", "wall")}
    data = hc.Traces.from_arrays(*recorded(signals=signals))
    (advice,) = hc.fit(data, chain(), free=FREE).advice
    assert advice.startswith("with gap[8-9] = 0.")
    assert "check for a gap between balls 8 and 9" in advice
