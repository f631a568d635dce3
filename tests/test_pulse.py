import json
import warnings
from functools import partial

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.pulse.quantities import QUANTITIES
from hertzchain.store.results import pulses_as_json


@pytest.fixture(scope="module")
def pulses():
    chain = hc.Chain.tapered("forward-exponential", 0.03, beads=20)
    return hc.propagate(chain), hc.bca(chain)


@pytest.mark.parametrize("method", [hc.propagate, lambda chain: hc.simulate(chain).pulse()])
def test_pulses_of_chains_with_bouncing_beads_have_a_note(method):
    dimer = hc.Chain.dimer(0.29, beads=21, exponent=2.0)
    run = hc.simulate(dimer, until=35.0, times=4000)
    pulse = method(dimer)
    # At these beads, a later maximum of the same pulse is larger.
    assert (run.velocities.max(axis=0) > 1.05 * pulse.velocity)[1:-1].any()
    for name in ("velocity", "momentum", "energy"):
        assert pulse.notes[name].startswith("light beads bounce between heavier ones (at 10 beads")
    for smooth in (hc.Chain.uniform(9), hc.Chain.tapered("forward-exponential", 0.1, beads=9)):
        assert "velocity" not in method(smooth).notes
    table = hc.propagate_many([dimer])
    assert table[0].notes == hc.propagate(dimer).notes


def test_derived_quantities(pulses):
    exact, _ = pulses
    m = exact.chain.masses
    np.testing.assert_allclose(exact.momentum, m * exact.velocity, rtol=1e-15)
    np.testing.assert_allclose(exact.energy, 0.5 * m * exact.velocity**2, rtol=1e-15)
    np.testing.assert_allclose(np.cumsum(exact.residence), exact.arrival[1:], rtol=1e-14)
    force = exact.chain.stiffness * exact.peak_overlap**1.5
    np.testing.assert_allclose(exact.peak_force, force, rtol=1e-14)


def test_compare_measures_from_the_reference(pulses):
    exact, theory = pulses
    comparison = theory.compare(exact)
    expected = theory.velocity / exact.velocity - 1
    np.testing.assert_allclose(comparison.errors("velocity"), expected, rtol=1e-12)
    worst = np.abs(expected[1:]).argmax()
    assert comparison.worst("velocity") == pytest.approx(np.abs(expected[1:]).max())
    assert comparison.worst_bead("velocity") == worst + 2
    assert comparison.rms("velocity", first_bead=10) == pytest.approx(
        np.sqrt(np.mean(expected[9:] ** 2))
    )
    assert "peak_time" not in comparison.quantities
    assert "velocity" in str(comparison)


def test_compare_rejects_other_objects(pulses):
    exact, theory = pulses
    with pytest.raises(hc.InputError, match="different chains"):
        exact.compare(hc.bca(hc.Chain.uniform(20)))
    with pytest.raises(hc.InputError, match="BCA does not predict peak_time"):
        theory.compare(exact).errors("peak_time")
    for first_bead in (0, -2, 21):
        with pytest.raises(
            hc.InputError, match="first_bead of velocity must be a whole number from 1 to 20, got"
        ):
            theory.compare(exact).worst("velocity", first_bead=first_bead)
    for last_bead in (3, 21):
        with pytest.raises(
            hc.InputError, match="last_bead of velocity must be a whole number from 4 to 20, got"
        ):
            theory.compare(exact).rms("velocity", first_bead=4, last_bead=last_bead)
    for name in ("velo", "chain"):
        with pytest.raises(hc.InputError, match="unknown quantity"):
            theory.column(name)
    with pytest.raises(hc.InputError, match="BCA does not predict peak_time"):
        theory.plot("peak_time")


def test_dataset_counts_beads_from_one(pulses):
    dataset = pulses[0].to_xarray()
    assert float(dataset.velocity.sel(bead=1)) == 1.0
    assert float(dataset.peak_force.sel(contact=19)) == pulses[0].peak_force[18]
    assert "units" not in dataset.velocity.attrs
    # Only theories have estimates of errors and of the spread over lots.
    missing = {"velocity_error", "velocity_spread", "arrival_spread", "peak_force_spread"}
    assert set(QUANTITIES) - set(dataset) == missing


def test_dataframe_and_html(pulses):
    table = pulses[0].to_dataframe()
    assert table.index.name == "bead"
    assert list(table.index) == list(range(1, 21))
    assert np.isnan(table.residence.loc[20])
    assert "forward-exponential" in pulses[0]._repr_html_()


def test_plot_draws_the_data(pulses):
    axes = pulses[0].plot("peak_force")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), pulses[0].peak_force)
    assert axes.get_xlabel() == "contact $k$"


def test_run_plot_draws_every_bead():
    run = hc.simulate(hc.Chain.uniform(12), times=20)
    axes = run.plot()
    drawn = axes.collections[0].get_array()
    # Few saved times are interpolated.
    assert drawn.shape[0] == 12
    assert drawn.shape[1] > len(run.times)
    assert np.array_equal(drawn[:, 0], run.velocities[0])


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"velocity": [1.0, 1.0]}, r"shape \(3,\)"),
        ({"velocity": [1.0, 0.0, 1.0]}, "bead 2 is 0"),
        ({"velocity": ["fast", 1.0, 1.0]}, "velocity of bead 1 is 'fast': it must be a number"),
        ({"velocity": [1.0] * 3, "residence": [1.0, 0.0]}, "residence of contact 2 is 0"),
        ({"velocity": [1.0, np.nan, 1.0]}, "bead 2 is nan"),
        ({"velocity": [1.0, 1.0, 1.0], "arrival": [0.0, 1.0, np.inf]}, "arrival of bead 3"),
    ],
)
def test_a_pulse_holds_no_doubtful_numbers(columns, said):
    with pytest.raises(hc.InputError, match=said):
        hc.Pulse(hc.Chain.uniform(3), "test", **columns)


def test_the_representation_states_speed_and_force():
    steel = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.1)
    pulse = hc.propagate(steel)
    text = " ".join(repr(pulse).split())
    numbers = f"speed {pulse.speed[9]:.4g} m/s, force {pulse.peak_force[9]:.4g} N at contact 10"
    assert text.endswith(f"v_20 = {pulse.velocity[-1]:.4g} m/s; {numbers})")
    assert numbers in str(pulse)
    scaled = hc.propagate(hc.Chain.uniform(9))
    assert repr(scaled).endswith(f"speed {scaled.speed[3]:.4g} at contact 4)")
    assert "contact" not in repr(hc.hard_sphere(hc.Chain.uniform(9)))


@pytest.mark.parametrize(("theory", "chain"), [
    (hc.bca, hc.Chain.dimer(0.4, beads=30)),
    (hc.theory.two_thirds_bca, hc.Chain.dimer(0.4, beads=30)),
    (hc.modified_bca, hc.Chain.tapered("forward-exponential", 0.09, beads=30)),
    (hc.local_rate, hc.Chain.from_radii(np.where(np.arange(40) < 20, 1.0, 1.3))),
    (hc.local_rate, hc.Chain.from_materials(0.01, "steel-52100", beads=20, velocity=30.0)),
    (partial(hc.disorder, scatter=0.01), hc.Chain.from_radii([1.0] * 20 + [1.05] * 20)),
])  # fmt: skip
def test_pulses_keep_the_warnings_of_their_theory(theory, chain):
    with pytest.warns(hc.ModelRangeWarning) as raised:
        pulse = theory(chain)
    for warning in raised:
        assert str(warning.message) in pulse.notes["warning"]
    assert f"warning: {raised[0].message}" in str(pulse)
    assert json.loads(pulses_as_json([pulse]))["pulses"][0]["notes"] == pulse.notes
    assert pulse.to_xarray().attrs["warning"] == pulse.notes["warning"]
    assert pulse.notes["warning"] in pulse._repr_html_().replace("&#x27;", "'")


def test_a_pulse_keeps_warnings_that_are_not_shown():
    chain = hc.Chain.from_radii(np.where(np.arange(40) < 20, 1.0, 1.3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        pulse = hc.local_rate(chain)
    assert "the estimated velocity error exceeds 0.5% first at bead" in pulse.notes["warning"]
    assert "warning" not in hc.local_rate(hc.Chain.uniform(40)).notes
