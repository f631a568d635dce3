"""Closed-form attenuation by loss, against simulations and energy balances."""

import numpy as np
import pytest
from attenuation_error import LAWS as OF_TOOL
from attenuation_error import (
    chain_with,
    coefficient,
    errors,
    fitted_coefficients,
    velocity_power,
    yielding_decays,
)

import hertzchain as hc
from hertzchain.theory.attenuation import (
    DELAY,
    OF_SQUARE,
    estimated_error,
    first_order,
    second_order,
)

WAVE = hc.solitary_wave()
LAWS = {
    "restitution": lambda x: hc.Restitution(1 - x, attractive=False),
    "unloading ratio": hc.UnloadingRatio,
    "Walton-Braun": lambda x: hc.WaltonBraun(1 - x),
    "viscoelastic": hc.Viscoelastic,
    "dashpot": hc.Dashpot,
    "cubic": lambda x: hc.VelocityPower(x, alpha=3.0),
}


def lost_in_one_contact(law, beads=50, contact=30):
    """Energy that a wave loses in the only contact with a loss, and its peak velocity before."""
    losses = [None] * (beads - 1)
    losses[contact - 1] = law
    before = hc.simulate(hc.Chain.uniform(beads), times=0).pulse().velocity[contact - 1]
    run = hc.simulate(hc.Chain.uniform(beads).replace(loss=losses), until=46.0, times=[46.0])
    return float(run.budget().energy["lost"][0]), float(before)


@pytest.mark.parametrize("shortfall", [0.004, 0.016])
def test_contacts_that_just_yield(shortfall):
    """The contact yields at an overlap that is slightly less than that of the wave."""
    overlap = WAVE.peak_force(0.68163155) ** (2 / 3)
    law = hc.ElasticPlastic(yield_overlap=overlap * (1 - shortfall))
    lost, v = lost_in_one_contact(law)
    decay = first_order(hc.Chain.uniform(3).replace(loss=law), v)
    # The energy of the budget is accurate to 6e-9.
    assert 2 * WAVE.energy(v) * float(decay) == pytest.approx(lost, rel=1e-3, abs=6e-9)
    assert float(hc.attenuation(hc.Chain.uniform(3).replace(loss=law), 0.9 * v)) == 0.0


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_one_contact_loses_as_much_as_the_formula_states(law):
    """Ratio of the energies, extrapolated from two losses to none."""
    ratios = []
    for loss in (2e-3, 4e-3):
        lost, v = lost_in_one_contact(law(loss))
        decay = first_order(hc.Chain.uniform(3).replace(loss=law(loss)), v)
        ratios.append(lost / (2 * WAVE.energy(v) * float(decay)))
    assert 2 * ratios[0] - ratios[1] == pytest.approx(1.0, abs=2e-4)


def test_a_wall_of_another_exponent_has_no_effect():
    chain = hc.Chain.uniform(20).replace(loss=hc.Restitution(0.99))
    walled = chain.replace(right_wall=hc.Wall(stiffness=1.0, exponent=1.0))
    assert hc.attenuation(walled, 0.7) == hc.attenuation(chain, 0.7)
    mixed = chain.replace(exponent=[1.5] * 10 + [2.0] * 9, stiffness=1.0)
    with pytest.raises(hc.InputError, match="one law of loss and one exponent"):
        hc.attenuation(mixed, 0.7)


def test_two_sensors_give_the_relaxation_time():
    """v^(-1/5) grows linearly with A in viscoelastic beads."""
    a = 2e-4
    v = hc.simulate(hc.Chain.uniform(70).replace(loss=hc.Viscoelastic(a)), times=0).pulse().velocity
    unit = float(first_order(hc.Chain.uniform(2).replace(loss=hc.Viscoelastic(a)), 1.0))
    growth = (v[59] ** -0.2 - v[19] ** -0.2) / 40
    assert growth == pytest.approx(unit / 5, rel=1.5e-3)


def test_units_and_impact_make_no_difference():
    law = hc.Viscoelastic(2e-7)
    steel = hc.Chain.from_materials(5e-3, "steel-52100", beads=9, velocity=0.3).replace(loss=law)
    scales = hc.Scales.of(steel)
    scaled = scales.to_scaled(steel)
    expected = hc.attenuation(scaled, 0.2 / 0.3)
    assert hc.attenuation(steel, 0.2) == pytest.approx(expected, rel=1e-12)
    struck = hc.Chain.from_materials(5e-3, "steel-52100", beads=9).struck_by(mass=0.05, radius=0.02)
    assert hc.attenuation(struck.replace(loss=law), 0.2) == pytest.approx(expected, rel=1e-12)
    walled = steel.replace(right_wall=hc.Wall(loss=hc.Dashpot(1.0)))
    assert hc.attenuation(walled, 0.2) == pytest.approx(expected, rel=1e-12)


def test_arrays_and_elastic_beads():
    chain = hc.Chain.uniform(4)
    assert hc.attenuation(chain, [[0.1, 1.0]]).tolist() == [[0.0, 0.0]]
    both = hc.attenuation(chain.replace(loss=hc.Dashpot(1e-4)), [0.1, 0.2])
    np.testing.assert_allclose(both[0] / both[1], 2**0.2, rtol=2e-4)
    both = first_order(chain.replace(loss=hc.Dashpot(1e-4)), [0.1, 0.2])
    np.testing.assert_allclose(both[0] / both[1], 2**0.2, rtol=1e-12)


@pytest.mark.parametrize(("chain", "message"), [
    (hc.Chain.tapered("backward-linear", 0.1, beads=9), "equal beads"),
    (hc.Chain.uniform(3).replace(stiffness=[1.0, 2.0]), "equal contacts"),
    (hc.Chain.uniform(3).replace(precompression=1.0, held_by="force"), "precompression"),
    (hc.Chain.uniform(3).replace(loss=[hc.Dashpot(0.1), None]), "one law of loss"),
])  # fmt: skip
def test_other_chains_are_rejected(chain, message):
    with pytest.raises(hc.InputError, match=message):
        hc.attenuation(chain, 1.0)


@pytest.mark.parametrize("velocity", [0.0, -1.0, [1.0, float("nan")]])
def test_velocities_must_be_positive(velocity):
    with pytest.raises(hc.InputError, match="velocity of a wave"):
        hc.attenuation(hc.Chain.uniform(3), velocity)


@pytest.mark.parametrize("velocity", [1e200, 1e-200, [1.0, 1e61]])
def test_velocities_whose_powers_overflow_are_rejected(velocity):
    with pytest.raises(hc.InputError, match="so that no power overflows; got"):
        hc.attenuation(hc.Chain.uniform(3).replace(loss=hc.Dashpot(1e-3)), velocity)


def test_a_large_loss_is_announced():
    with pytest.warns(hc.ModelRangeWarning, match="first order in the loss: .* more than 30%"):
        hc.attenuation(hc.Chain.uniform(3).replace(loss=hc.Restitution(0.7)), 1.0)


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_huge_loss_does_not_overflow():
    with pytest.warns(hc.ModelRangeWarning, match="more than 30%"):
        assert hc.attenuation(hc.Chain.uniform(3).replace(loss=hc.Dashpot(1e200)), 1.0) > 0.0


@pytest.mark.parametrize("p", [1.5, pytest.param(1.75, marks=pytest.mark.long), 2.5])
@pytest.mark.parametrize(
    "law",
    [*OF_TOOL.values(), velocity_power(0.6), velocity_power(3.0)],
    ids=[*OF_TOOL, "velocity-power-0.6", "velocity-power-3"],
)
def test_second_order_of_simulated_waves(law, p):
    """Also between the exponents at which the coefficients were determined."""
    x = 0.005
    stated = second_order(chain_with(law, x, p).loss, p)
    assert stated == pytest.approx(coefficient(law, x, p), rel=0.03, abs=0.1)


BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=70, velocity=0.1)


@pytest.mark.filterwarnings("error::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(("law", "e", "largest"), [
    (hc.Restitution, 0.96, 0.001),
    (hc.Restitution, 0.9, 0.01),
    (hc.Viscoelastic, 0.96, 0.0015),
    (hc.Dashpot, 0.96, 0.001),
    (hc.Dashpot, 0.9, 0.005),
    (hc.UnloadingRatio, 0.97, 0.001),
])  # fmt: skip
def test_no_warning_where_the_decay_is_accurate(law, e, largest):
    """To first order, the decays are 1% (`UnloadingRatio`) to 26% too large."""
    lossy = BALLS.replace(loss=law.from_restitution(e, speed=0.1, chain=BALLS))
    v = hc.simulate(lossy, times=0).pulse().velocity[15:36]
    simulated = np.log(v[0] / v[-1])
    mean = np.sqrt(v[1:] * v[:-1])
    assert first_order(lossy, mean).sum() / simulated - 1 > 0.01
    assert hc.attenuation(lossy, mean).sum() == pytest.approx(simulated, rel=largest)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(
    ("law", "decay"),
    [
        (OF_TOOL["restitution"], 0.03),
        (OF_TOOL["restitution"], 0.05),
        (OF_TOOL["viscoelastic"], 0.04),
        (OF_TOOL["dashpot"], 0.05),
        (OF_TOOL["walton-braun"], 0.05),
        (OF_TOOL["unloading-ratio"], 0.03),
        (OF_TOOL["unloading-ratio"], 0.04),
        (velocity_power(1.81), 0.04),
        (velocity_power(3.0), 0.03),
    ],
)
def test_the_estimated_error_is_that_of_simulated_waves(law, decay):
    error, estimate = errors(law, decay)
    assert 2 / 3 < estimate / abs(error) < 1.5


@pytest.mark.parametrize(
    ("law", "stated"),
    [
        (hc.UnloadingRatio(0.19), "0.036 per bead .* is about 6.1%"),
        (hc.VelocityPower(0.15, 1.8), "0.04 per bead .* is about 3.1%"),
        (hc.ElasticPlastic(yield_overlap=0.25), "0.048 per bead .* is about 6.2%"),
    ],
)
def test_the_warning_states_the_estimated_error(law, stated):
    with pytest.warns(hc.ModelRangeWarning, match=stated):
        hc.attenuation(hc.Chain.uniform(60).replace(loss=law), 0.6)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize("ratio", [1.2, 1.5, 2.2, 3.0, 4.5, 6.0, 7.0])
def test_decays_of_contacts_that_yield(ratio):
    """From bead 20 on, the error is at most 0.2%, or the estimated one."""
    overlaps, found, simulated = yielding_decays(ratio, first=19)
    assert simulated.min() > 5e-4
    estimates = [estimated_error(hc.ElasticPlastic(), 1.5, each - 1) for each in overlaps]
    assert (np.abs(found / simulated - 1) < np.maximum(estimates, 0.002)).all()


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_coefficients_of_contacts_that_yield_are_those_of_the_best_fit():
    found, largest = fitted_coefficients()
    np.testing.assert_allclose(found, [DELAY, OF_SQUARE], rtol=2.5e-3)
    assert largest < 0.002


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_stated_errors_hold_near_a_strong_impact():
    """The wave of a strong impact is still changing there, and its estimated error is larger."""
    overlaps, found, simulated = yielding_decays(6.0, first=7)
    estimates = [estimated_error(hc.ElasticPlastic(), 1.5, each - 1) for each in overlaps]
    errors = np.abs(found / simulated - 1)
    assert (errors[:7] < estimates[:7]).all()
    assert (errors[:7] > 0.2 * np.array(estimates[:7])).any()
    assert errors.max() > 0.1


@pytest.mark.filterwarnings("ignore:the decay by ElasticPlastic:hertzchain.ModelRangeWarning")
def test_steel_balls_that_yield():
    """The same in SI units, with the yield strength of a material."""
    balls = hc.Chain.from_materials(5e-3, "steel-316", beads=50, velocity=0.01)
    chain = balls.replace(loss=hc.ElasticPlastic())
    v = hc.simulate(chain, times=0, rtol=1e-11).pulse().velocity
    simulated = 0.5 * np.log(v[18:38] / v[20:40])
    np.testing.assert_allclose(hc.attenuation(chain, v[19:39]), simulated, rtol=4e-3)
    # Later waves overtake the first one of a faster impact, and its decay is not that of one wave.
    fast = chain.replace(velocities=[0.1, *[0.0] * 49])
    v = hc.simulate(fast, times=0).pulse().velocity
    with pytest.warns(hc.ModelRangeWarning, match="times the overlap at yield; beyond 7, later"):
        decay = float(hc.attenuation(fast, v[30]))
    assert abs(decay / (0.5 * np.log(v[29] / v[31])) - 1) > 0.5


@pytest.mark.parametrize("law", OF_TOOL.values(), ids=OF_TOOL)
def test_decays_by_large_losses_are_positive(law):
    chain = hc.Chain.uniform(3, exponent=1.3).replace(loss=law(0.2))
    with pytest.warns(hc.ModelRangeWarning, match="more than 30%"):
        assert hc.attenuation(chain, [0.1, 1.0]).min() > 0.0
