"""Theories and propagation of chains in SI units: conversion by themselves and by hand."""

import re
import warnings
from dataclasses import fields

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import InputError, ModelRangeWarning
from hertzchain.sweeps.methods import pulse_by
from hertzchain.theory.modified_bca import two_thirds_bca

RADII = 5e-3 / 1.02 ** np.arange(30)
STEEL = hc.Chain.from_materials(RADII, "steel-52100", velocity=0.1)
SCALES = hc.Scales.of(STEEL)
SCALED = SCALES.to_scaled(STEEL)
METHODS = (hc.bca, hc.local_rate, hc.hard_sphere, two_thirds_bca)


@pytest.mark.parametrize("method", METHODS)
def test_si_chains_give_what_conversion_by_hand_gives(method):
    pulse, by_hand = method(STEEL), SCALES.to_si(method(SCALED))
    assert pulse.chain is STEEL
    assert pulse.method == by_hand.method
    # All results of the method are converted by the same products.
    for field in fields(pulse):
        if isinstance(getattr(pulse, field.name), np.ndarray):
            np.testing.assert_array_equal(getattr(pulse, field.name), getattr(by_hand, field.name))
    # Derived columns have the masses of the given chain, not of one converted there and back.
    for name, values in pulse.columns().items():
        np.testing.assert_allclose(values, by_hand.column(name), rtol=1e-15, atol=0.0)


def test_propagation_does_not_depend_on_units():
    """Chains in any units are integrated in units of their own, so only rounding differs."""
    pulse, by_hand = hc.propagate(STEEL), SCALES.to_si(hc.propagate(SCALED))
    assert pulse.chain is STEEL
    for name, values in pulse.columns().items():
        np.testing.assert_allclose(values, by_hand.column(name), rtol=1e-12, atol=0.0)


def test_si_values_agree_with_the_simulation():
    pulse = hc.propagate(STEEL)
    run = hc.simulate(STEEL).pulse()
    for name in run.columns():
        assert pulse.compare(run).worst(name) < 1e-7, name


def test_a_single_bead_without_material_has_no_unit_of_length():
    bead = hc.Chain(
        [5e-3], units="SI", masses=[4e-3], stiffness=[], velocities=[1.0],
        right_wall=hc.Wall(stiffness=1e9),
    )  # fmt: skip
    with pytest.raises(hc.InputError, match="single bead requires its material"):
        hc.Scales.of(bead)


def test_two_materials_are_converted_for_the_theories_that_support_them():
    materials = ["steel-316", "ptfe"]
    chain = hc.Chain.periodic([9.5e-3] * 2, cells=10, materials=materials, velocity=1e-3)
    scales = hc.Scales.of(chain)
    with pytest.warns(hc.ModelRangeWarning, match="treats each contact as a separate collision"):
        found = hc.bca(chain)
    with pytest.warns(hc.ModelRangeWarning, match="treats each contact as a separate collision"):
        by_hand = hc.bca(scales.to_scaled(chain))
    np.testing.assert_array_equal(found.peak_overlap, scales.to_si(by_hand).peak_overlap)
    message = r"does not support several materials; .*steel-316 and ptfe"
    with pytest.raises(InputError, match=message):
        hc.local_rate(chain)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_a_table_of_si_chains_is_in_si_units():
    short = hc.Chain.from_materials(RADII[:12], "brass", velocity=0.003)
    walled = STEEL.replace(right_wall=hc.Wall())
    table = hc.propagate_many([STEEL, short, walled])
    assert table.units == "SI"
    assert "right wall" in table.reasons[2]
    assert table.chain(1) is short
    for row, chain in enumerate((STEEL, short)):
        pulse = hc.propagate(chain)
        for name, values in pulse.columns().items():
            found = table.column(name)[row, : len(values)]
            np.testing.assert_allclose(found, values, rtol=1e-15)
            np.testing.assert_array_equal(table[row].column(name), values)
    assert np.isnan(table.velocity[1, 12:]).all()
    dataset = table.to_xarray()
    assert dataset.velocity.attrs["units"] == "m/s"
    assert dataset.radius.attrs["units"] == "m"
    np.testing.assert_allclose(dataset.radius[0], RADII, rtol=1e-15)


def test_a_table_has_one_set_of_units():
    for other in (SCALED, np.ones(5)):
        with pytest.raises(InputError, match=r"1 of 2 chains are in SI units.*separately"):
            hc.propagate_many([STEEL, other])


@pytest.mark.parametrize(
    "quantity", ["velocity", "momentum", "energy", "arrival", "residence", "peak_force"]
)
def test_the_gradient_has_the_value_of_the_law_in_si_units(quantity):
    value, gradient = hc.local_rate_gradient(STEEL, quantity, bead=20)
    scaled, same = hc.local_rate_gradient(SCALED, quantity, bead=20)
    np.testing.assert_array_equal(gradient, same)
    law, by_hand = hc.local_rate(STEEL), hc.local_rate(SCALED)
    assert value == pytest.approx(law.column(quantity)[19], rel=1e-12)
    unit = SCALES.to_si(by_hand).column(quantity)[19] / by_hand.column(quantity)[19]
    assert value == pytest.approx(scaled * unit, rel=1e-14)


def test_the_gradient_in_si_units_is_that_of_finite_differences():
    # Larger radii at the same velocity and material, in metres and kilograms.
    bead, step = 22, 2e-5
    _, gradient = hc.local_rate_gradient(STEEL, "momentum", bead=25)

    def momentum(factor):
        radii = RADII.copy()
        radii[bead - 1] *= factor
        chain = hc.Chain.from_materials(radii, "steel-52100", velocity=0.1)
        return hc.local_rate(chain).momentum[24]

    slope = np.log(momentum(1.0 + step) / momentum(1.0 - step)) / (2.0 * step)
    assert gradient[bead - 1] == pytest.approx(slope, rel=1e-5)


def test_small_beads_are_eliminated_in_si_units():
    chain = hc.Chain.from_materials([5e-3, 1.5e-3] * 8 + [5e-3], "steel-52100", velocity=0.1)
    scales = hc.Scales.of(chain)
    found, scaled = (hc.effective_chain(each).bca() for each in (chain, scales.to_scaled(chain)))
    for name, unit in (("velocity", "velocity"), ("arrival", "time"), ("peak_force", "force")):
        expected = getattr(scaled, name) * getattr(scales, unit)
        np.testing.assert_allclose(getattr(found, name), expected, rtol=1e-13)


def test_unsupported_features_are_named_with_the_chain_as_it_was_given():
    walled = STEEL.replace(right_wall=hc.Wall())
    for method in METHODS:
        with pytest.raises(InputError, match=r"right wall; .* \(chain: \d+ steel-52100 beads"):
            method(walled)
    with pytest.raises(InputError, match="the modified BCA requires a tapered chain"):
        hc.modified_bca(hc.Chain.from_materials([1e-2] * 9, "steel-52100"))
    driven = STEEL.replace(drive=hc.SineBurst(1.0, 1e4))
    with pytest.raises(InputError, match=r"propagate does not support a drive"):
        hc.propagate(driven)


def test_a_chain_at_rest_is_rejected():
    still = STEEL.replace(velocities=np.zeros(30))
    for method in METHODS:
        with pytest.raises(InputError, match="needs a chain whose first bead is struck"):
            method(still)


def test_a_striker_that_moves_backwards_is_not_at_rest():
    backwards = STEEL.replace(velocities=np.append(-0.1, np.zeros(29)))
    for method in (hc.local_rate, hc.propagate):
        with pytest.raises(InputError, match="this one moves backwards .*: give it a velocity > 0"):
            method(backwards)


def test_the_limits_of_hertz_are_checked_where_the_user_called(tmp_path):
    fast = hc.Chain.from_materials(5e-3, "steel-304", beads=10, velocity=5.0)
    for call in (lambda: hc.propagate(fast), lambda: hc.bca(fast)):
        with pytest.warns(ModelRangeWarning) as caught:
            call()
        assert {warning.filename for warning in caught} == {__file__}
        assert "pressure / yield" in str(caught[0].message)
    with pytest.warns(
        ModelRangeWarning,
        match="^propagation: 2 of 2 chains .* chain 0, .* use simulate with loss=Elas",
    ) as caught:
        hc.propagate_many([fast, fast])
    assert [warning.filename for warning in caught] == [__file__]
    with pytest.warns(ModelRangeWarning, match="^local-rate law: "):
        hc.local_rate_gradient(fast, bead=5)
    with pytest.warns(ModelRangeWarning, match="^simulation: "):
        hc.simulate(fast)
    with pytest.warns(ModelRangeWarning, match="^simulation: "):
        hc.stream(fast, tmp_path / "run", times=[1e-4, 2e-4])
    with pytest.warns(ModelRangeWarning, match="^gradient: "):
        hc.gradient(fast, "energy", to=["radii"], bead=5)


def test_warnings_of_theories_name_the_line_of_the_caller():
    rough = hc.Chain.from_radii(np.where(np.arange(20) % 2, 1.0, 1.3))
    decorated = hc.Chain.uniform(9).decorated(0.3)
    tapered = hc.Chain.tapered("backward-exponential", 0.2, beads=20)
    for call in (
        lambda: hc.local_rate(rough),
        lambda: hc.local_rate_gradient(rough, bead=10),
        lambda: hc.bca(decorated),
        lambda: hc.modified_bca(tapered),
    ):
        with pytest.warns(ModelRangeWarning) as caught:
            call()
        assert caught[0].filename == __file__


def test_pulses_in_different_units_are_compared_in_si():
    exact, law = hc.propagate(STEEL), hc.local_rate(SCALED)
    one, other = law.compare(exact), exact.compare(law)
    assert one.pulse.chain.units == other.reference.chain.units == "SI"
    same = hc.local_rate(STEEL).compare(exact)
    for name in same.quantities:
        assert one.worst(name) == pytest.approx(same.worst(name), rel=1e-9)
    # A pulse converted there and back is still one of the same chain, in spite of rounding.
    by_hand = SCALES.to_si(hc.propagate(SCALED))
    assert by_hand.compare(exact).worst("momentum") < 1e-14


def test_pulses_of_different_chains_are_not_compared():
    other = hc.propagate(hc.Chain.uniform(30))
    with pytest.raises(InputError, match="different chains"):
        hc.propagate(STEEL).compare(other)
    with pytest.raises(InputError, match="different chains"):
        other.compare(hc.propagate(STEEL))


@pytest.mark.parametrize("method", ["propagate", "simulate", "bca", "local-rate", "hard-sphere"])
def test_methods_by_name_give_the_same_pulse(method):
    functions = {"propagate": hc.propagate, "bca": hc.bca, "local-rate": hc.local_rate,
                 "hard-sphere": hc.hard_sphere,
                 "simulate": lambda chain: hc.simulate(chain, times=0).pulse()}  # fmt: skip
    named, direct = pulse_by(method, STEEL), functions[method](STEEL)
    for name, values in direct.columns().items():
        np.testing.assert_array_equal(named.column(name), values)


def test_scaled_chains_are_passed_on_as_they_are():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert hc.bca(SCALED).chain is SCALED
        assert hc.bca(chain=SCALED).chain is SCALED


@pytest.mark.parametrize("theory", [hc.modified_bca, hc.local_rate])
def test_messages_of_theories_describe_the_chain_as_given(theory):
    radii = 5e-3 * hc.Chain.tapered("forward-exponential", 0.3, beads=20).radii
    radii[5:10] *= 1.001  # no taper
    chain = hc.Chain.from_materials(radii, "steel-316", velocity="1 um/s")
    described = re.escape(chain.description)
    assert described == r"20\ steel\-316\ beads,\ diameters\ 10\ mm\ to\ 68\.4\ um"
    with (
        pytest.raises(hc.InputError, match=described)
        if theory is hc.modified_bca
        else pytest.warns(hc.ModelRangeWarning, match=described)
    ):
        theory(chain)
    # A scaled copy that the user makes has its own description.
    assert hc.Scales.of(chain).to_scaled(chain).description == "given radii, 20 beads"
