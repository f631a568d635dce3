"""Energy that is in no wave of the list, and the list in dimers."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.cli.wave_tables import wave_table
from hertzchain.simulation import find_waves


@pytest.fixture(scope="module")
def dimer():
    """At this mass ratio, the crest at every second contact precedes that at the contact before."""
    return hc.simulate(hc.Chain.dimer(0.3428, beads=61), until=52.0, times=2400)


def listed_energy(waves, contact):
    return sum(float(each.energies[each.contacts == contact][0]) for each in waves.passing(contact))


@pytest.mark.parametrize("ratio", [0.25, 0.30, 0.3428, 0.40, 0.45, 0.55])
def test_the_waves_of_dimers_have_the_energy_flux(ratio):
    run = hc.simulate(hc.Chain.dimer(ratio, beads=61), until=52.0, times=2400)
    waves, flux = run.waves(), run.energy_flux()
    for k in (15, 20, 25, 30):
        assert listed_energy(waves, k) == pytest.approx(flux.right[k - 1], rel=0.15)
    # One track follows the crest in which most of the energy passes.
    strongest = max(waves.passing(20), key=lambda wave: wave.energy)
    assert {20, 25, 30} <= set(strongest.contacts)


def test_crests_of_dimers_change_their_order(dimer):
    times = {event.contact: event.time for event in dimer.waves().passing(30)[0].events}
    assert times[30] < times[29] < times[31]


def test_energy_in_no_wave_is_announced(dimer, monkeypatch):
    """No links make a list without waves, so that all of the energy is missing."""
    monkeypatch.setattr(find_waves, "MAX_COST", 1e-9)
    said = r"100% of the energy flux at contact \d+ is in no listed wave, and more than half at"
    with pytest.warns(hc.InputWarning, match=said) as shown:
        waves = dimer.waves()
    assert not len(waves)
    # Only fewer saved times may be the reason.
    assert "may be missing" not in str(shown[0].message)
    with pytest.warns(hc.InputWarning, match=r"waves may be missing: times=[5-9]\d0 is enough"):
        hc.simulate(dimer.chain, until=52.0, times=400).waves()
    flux = dimer.energy_flux().right
    much = flux > 0.1 * flux.max()
    np.testing.assert_array_equal(waves.unlisted_energy, much.astype(float))
    short = f"more than half at {much.sum()} of 60 contacts"
    for text in (str(waves), repr(waves), waves._repr_html_(), wave_table(waves).caption):
        assert short in " ".join(text.replace("\u00a0", " ").split())
    with pytest.warns(hc.InputWarning, match="100% of the energy flux at contact 20 is in no"):
        assert not len(waves.passing(20))


def test_energy_of_one_wave_is_listed_except_where_it_meets_its_reflection():
    chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall.rigid())
    waves = hc.simulate(chain, until=60.0, times=1000).waves()
    assert waves.unlisted_energy.max() < 0.25
    assert "no listed wave" not in str(waves)
