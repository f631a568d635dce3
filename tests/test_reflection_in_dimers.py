"""Reflection inside a dimer, where weak waves meet the reflected one at some contact."""

import warnings

import numpy as np
import pytest

import hertzchain as hc


@pytest.fixture(scope="module")
def run():
    """A dimer with one pulse and a few weak waves behind it, then equal beads."""
    masses = np.ones(140)
    masses[1:70:2] = 0.3428
    chain = hc.Chain.uniform(140).replace(masses=masses)
    return hc.simulate(chain, until=130.0, times=4000)


def test_contacts_that_agree_give_the_energy_that_returns(run):
    """Energy flux of all waves to the left, over that of the pulse, through the same contacts."""
    flux = run.energy_flux()
    for before in (46, 47, 54):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = run.reflection(before, 84)
        # The pulse carries all of the flux to the right but that of the weak waves.
        returned = flux.left[before - 1] / found.incident.energy
        assert found.reflected_energy == pytest.approx(returned, abs=2e-3)
        low, high = found.nearby_energy
        assert 0.019 < low <= high < 0.023
        assert "at neighbouring contacts" not in repr(found)


@pytest.mark.filterwarnings("ignore:the reflected energy, .* is not complete")
@pytest.mark.parametrize("before", [57, 58])
def test_a_contact_where_waves_meet_causes_a_warning(run, before):
    with pytest.warns(hc.InputWarning, match=f"depends on the contact: 0.00.. at contact {before}"):
        found = run.reflection(before, 84)
    assert found.reflected_energy < 0.2 * found.nearby_energy[1]
    assert f"({found.nearby_energy[0]:.4f} to 0.0218 at neighbouring contacts)" in repr(found)


@pytest.mark.parametrize("before", [61, 62, 63])
def test_good_contacts_beyond_bad_ones_cause_no_warning(run, before):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = run.reflection(before, 84)
    good = run.reflection(47, 84).reflected_energy
    assert found.reflected_energy == pytest.approx(good, rel=0.01)


def test_energy_that_moves_away_is_stated(run):
    """At this time a second wave, with 4% of the energy, is in front of the interface."""
    with pytest.warns(hc.InputWarning, match=r", and 0\.03.. moves away from it, of which"):
        run.reflection(64, 84)


def test_one_wave_in_equal_beads_has_one_coefficient():
    chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 2.0))
    found = hc.simulate(chain, until=140.0, times=1500).reflection(50, 75)
    np.testing.assert_allclose(found.nearby_energy, found.reflected_energy, rtol=5e-3)
