"""Values that coincide with few digits have more, and crowded marks remain legible."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import hertzchain as hc
from hertzchain.cli.yield_range import Ends, range_in_words
from hertzchain.plotting.sweep_marks import mark_curve
from hertzchain.sweeps.axes import Axis


@pytest.mark.parametrize(("scatter", "accuracy"), [(1e-6, 1e-8), (0.01, 1e-3)])
def test_percentiles_in_legends_differ(scatter, accuracy):
    chain = hc.Chain.from_materials("10 mm", "steel-52100", beads=5, velocity="0.01 m/s")
    chain = chain.replace(right_wall=hc.Wall())
    found = hc.distribution(chain, "wall_force.peak", hc.Scatter(scatter, samples=150))
    labels = [each.get_text() for each in found.plot().get_legend().get_texts()]
    (label,) = [each for each in labels if each.startswith("5%, median, 95%: ")]
    numbers, _, unit = label.removeprefix("5%, median, 95%: ").rpartition(" ")
    shown = [float(each) for each in numbers.split(", ")]
    assert shown == sorted(set(shown))
    marked = np.percentile(found.values, (5, 50, 95)) * {"N": 1.0, "mN": 1e3}[unit]
    np.testing.assert_allclose(shown, marked, rtol=accuracy)


@pytest.mark.parametrize(
    ("first", "last", "said"),
    [
        (26.13, 34.02, "26.1 to 34 N for yield"),
        (49.98, 50.01, "49.98 to 50.01 N for yield"),
        (50.0131, 50.0134, "50.0131 to 50.0134 N for yield"),
        (50.013300001, 50.0133, "50.01 N for yield"),
    ],
)
def test_ends_of_a_range_differ(first, last, said):
    assert range_in_words(Ends("right wall", "N", first, last), "SI").startswith(said)


def test_an_unknown_key_is_reported_before_its_unit():
    with pytest.raises(hc.InputError, match=r"unknown key of \[chain.cap\] 'mas' \(did you mean"):
        _ = Axis(("cap", "mas"), {"linspace": ["0.1 m/s", "1 m/s", 5]}).values
    with pytest.raises(hc.InputError, match="has the unit 'm/s', but beads takes none"):
        _ = Axis(("beads",), {"linspace": ["1 m/s", "5 m/s", 5]}).values


def test_long_rows_of_marks_are_thinned_and_single_ones_remain():
    flagged = np.zeros(4001, bool)
    flagged[[7, *range(1005, 4001)]] = True
    curve = xr.DataArray(np.arange(4001.0), dims="x")
    axes = Figure().subplots()
    kinds = mark_curve(axes, np.arange(4001), curve, {"outside_range": curve.copy(data=flagged)},
                       "black", 100)  # fmt: skip
    assert kinds == ["outside_range"]
    (line,) = axes.lines
    assert line.get_xdata().tolist() == [7, 1005, *range(1100, 4001, 100)]
    every = mark_curve(
        axes, np.arange(4001), curve, {"sensitive": curve.copy(data=flagged)}, "black"
    )
    assert every == ["sensitive"]
    assert len(axes.lines[1].get_xdata()) == flagged.sum()
