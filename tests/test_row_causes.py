"""Gaps and balls between sensors, which look like delays."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.fitting.defect_fits import fits_of_defect
from hertzchain.fitting.goodness import rounded_chi2
from hertzchain.fitting.row_causes import _with_material
from hertzchain.recorded_warnings import ignore_warnings

FREE = ["stiffness", "loss.time", "time_offset"]


def row(gaps=0.0, material="steel-52100"):
    kinds = ["steel-52100"] * 12
    kinds[8] = material
    balls = hc.Chain.from_materials([5e-3] * 12, kinds)
    struck = balls.struck_by(velocity="0.3 m/s", material="steel-52100")
    return struck.replace(loss=hc.Viscoelastic("0.6 us"), right_wall=hc.Wall(), gaps=gaps)


def measured(chain):
    run = hc.simulate(chain, times=1e-6 * np.arange(400))
    noise = 0.1 * np.random.default_rng(3).standard_normal((2, 500))
    signals = [run.sensor("ball 4"), run.sensor("wall")]
    ball, wall = np.pad(signals, ((0, 0), (100, 0))) + noise
    return hc.Traces.from_arrays(1e-6 * np.arange(500), {"ball 4 [N]": ball, "wall [N]": wall})


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_a_large_gap_is_not_called_a_delay():
    data = measured(row(2e-5 * (np.arange(12) == 9)))
    (advice,) = hc.fit(data, row(), free=FREE).advice
    assert "with gap[9-10] = 20.0" in advice
    assert "and the model describes the data: check for a gap between balls 9 and 10" in advice
    assert "delay" not in advice


def test_diameter_means_diameters():
    text = '[chain]\nbeads = 3\n{} = "10 mm"\nmaterials = "brass"\n'
    chains = [hc.chain_from_toml(text.format(key)) for key in ("diameter", "diameters")]
    assert chains[0] == chains[1]


def test_a_ball_is_not_replaced_by_one_of_its_own_material():
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity="0.1 m/s")
    assert _with_material(row, 2, "brass").materials[1].name == "brass"
    with pytest.raises(hc.InputError, match="ball 2 has this material"):
        _with_material(row, 2, "steel-52100")


def with_mass(factor):
    """The row in which ball 9 has another mass, as with a hole, but the usual size."""
    chain = row()
    return chain.replace(masses=chain.masses * np.where(np.arange(13) == 9, factor, 1.0))


@pytest.fixture(scope="module")
def lighter():
    """The fit of the usual row to the one with a lighter ball."""
    with ignore_warnings():
        return hc.fit(measured(with_mass(0.9)), row(), free=FREE)


@pytest.mark.long
def test_a_ball_of_another_mass_is_not_one_of_another_size(lighter):
    (advice,) = lighter.advice
    assert advice.startswith("with mass[9] = ")
    assert "the model describes the data: check the mass of ball 9" in advice
    found = float(advice.split(": ")[1].split(" +- ")[0])
    assert found == pytest.approx(1e3 * with_mass(0.9).masses[9], rel=0.01)
    # A small change of the size has nearly the same effect, but describes the data less well.
    assert advice.find("radius[9]") in (-1, advice.find(". With radius[9] = ") + 7)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_a_search_for_an_odd_ball_tries_its_mass(lighter):
    first = fits_of_defect(hc.scan_defects(lighter, "bead"), 4)[0]
    assert first.names[-1] == "mass[9]"
    assert first.values["mass[9]"] == pytest.approx(with_mass(0.9).masses[9], rel=0.01)


@pytest.mark.parametrize(
    ("chi2", "shown"), [(2332.74, "2332.7"), (11735424092560.5, "1.2e13"), (4.9e9, "4.9e9")]
)
def test_large_values_of_chi2_have_two_digits(chi2, shown):
    assert rounded_chi2(chi2, 1) == shown
