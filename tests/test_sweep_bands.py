"""Medians and bands of sweeps over one axis, compared with NumPy's quantiles."""

import numpy as np
import pytest

import hertzchain as hc

SPECIFICATION = {
    "chain": {
        "taper": "uniform", "beads": 6, "decorated": {"diameter": 0.8},
        "with_scatter": {"relative": "2%", "seed": 1},
    },
    "axes": {"decorated.diameter": [0.4, 0.6, 0.8], "with_scatter.seed": {"linspace": [1, 12, 12]}},
    "sweep": {"methods": ["propagate", "simulate"], "keep": ["velocity"], "at": "last"},
}  # fmt: skip


@pytest.fixture(scope="module")
def found():
    return hc.sweep(SPECIFICATION)


def ends_of(area):
    """Lower and upper end at each place of a filled area."""
    corners = area.get_paths()[0].vertices
    places = np.unique(corners[:, 0])
    at = [corners[corners[:, 0] == place, 1] for place in places]
    return places, [each.min() for each in at], [each.max() for each in at]


@pytest.mark.parametrize("name", ["seed", "with_scatter.seed"])
def test_bands_are_between_quantiles(found, name):
    axes = hc.plot_sweep(found, band=name)
    assert len(axes.collections) == len(axes.lines) == 2
    for approach, area, line in zip(found.approach, axes.collections, axes.lines, strict=True):
        values = found.velocity.sel(approach=approach).transpose("seed", "diameter").to_numpy()
        low, median, high = np.quantile(values, [0.05, 0.5, 0.95], axis=0)
        places, *drawn = ends_of(area)
        np.testing.assert_allclose(places, [0.4, 0.6, 0.8])
        np.testing.assert_allclose(drawn, [low, high], rtol=1e-12)
        np.testing.assert_allclose(line.get_ydata(), median, rtol=1e-12)
    assert "median and 5–95% of 12 values (seed of the radii)" in axes.get_title()
    assert "median, 5% to 95% of 12 values" in [each.get_text() for each in axes.get_legend().texts]


def test_the_axis_of_beads_begins_at_bead_1():
    chain = {"taper": "uniform", "beads": 30, "with_scatter": {"relative": "2%", "seed": 1}}
    found = hc.sweep({"chain": chain, "axes": {"with_scatter.seed": {"linspace": [1, 3, 3]}},
                      "sweep": {"methods": ["propagate"], "keep": ["velocity"]}})  # fmt: skip
    axes = hc.plot_sweep(found, band="seed")
    low, high = axes.get_xlim()
    assert low < 0.0
    assert [each for each in axes.get_xticks() if low <= each <= high] == [5, 10, 15, 20, 25, 30]


def test_the_band_of_a_narrow_figure_is_in_the_legend_and_includes_the_free_end():
    chain = {"taper": "uniform", "beads": 9, "with_scatter": {"relative": "2%", "seed": 1}}
    seeds = {"with_scatter.seed": {"linspace": [1, 12, 12]}}
    found = hc.sweep({"chain": chain, "axes": seeds,
                      "sweep": {"methods": ["propagate"], "keep": ["velocity"]}})  # fmt: skip
    with hc.figure_style("single column"):
        axes = hc.plot_sweep(found, band="seed")
    assert not axes.get_title()
    texts = [each.get_text() for each in axes.get_legend().texts]
    assert texts == ["median, propagation", "5% to 95% of 12 values", "last bead (free end)"]
    last = found.velocity.sel(approach="propagate", bead=9).to_numpy()
    (bar,) = axes.collections[1].get_segments()
    np.testing.assert_allclose(bar[:, 1], np.quantile(last, [0.05, 0.95]), rtol=1e-12)
    assert bar[:, 0].tolist() == [9.0, 9.0]


def test_a_band_does_not_include_missing_points(found):
    part = found.copy(deep=True)
    part.velocity[{"diameter": 1, "seed": slice(0, 3)}] = np.nan
    with pytest.warns(hc.IncompleteWarning, match="6 of the 72 values of velocity are inc"):
        axes = hc.plot_sweep(part, band="seed")
    expected = np.quantile(found.velocity.sel(approach="simulate").to_numpy()[1, 3:], 0.5)
    assert axes.lines[1].get_ydata()[1] == pytest.approx(expected, rel=1e-12)


def test_missing_points_are_counted_as_by_the_status(found):
    """A point is missing if one of its methods is, also where the band has no value at all."""
    part = found.copy(deep=True)
    part.status[{"diameter": 1, "seed": slice(0, 3), "approach": 0}] = 0
    part.status[{"diameter": 2}] = 0
    part = part.assign(velocity=part.velocity.where(part.status == 1))
    for options, said in (
        ({"band": "seed"}, "of the 36 points to plot, 15 missing: the band does not include them"),
        ({"diameter": 0.6}, "of the 12 points to plot, 3 missing: left blank"),
    ):
        with pytest.warns(hc.IncompleteWarning) as told:
            hc.plot_sweep(part, **options)
        assert [str(each.message) for each in told] == [said]


def test_bands_require_an_axis_of_the_sweep(found):
    with pytest.raises(hc.InputError, match="unknown dimension of this sweep 'seeds'"):
        hc.plot_sweep(found, band="seeds")
    with pytest.raises(hc.InputError, match="at least 2 values, but seed has 1"):
        hc.plot_sweep(found.isel(seed=[0]), band="seed")
    with pytest.raises(hc.InputError, match="no remaining axis"):
        hc.plot_sweep(found.isel(diameter=[0]).squeeze("diameter"), band="seed")
