"""The speed of the exact wave as a length per time is that of the pulse of a simulation."""

import pytest

import hertzchain as hc


@pytest.mark.parametrize("exponent", [1.5, 2.0, 2.5])
def test_with_a_diameter_it_is_the_speed_of_a_pulse(exponent):
    pulse = hc.propagate(hc.Chain.uniform(60, exponent=exponent))
    wave, velocity = hc.solitary_wave(exponent), pulse.velocity[39]
    assert wave.speed(velocity, diameter=2.0) == pytest.approx(pulse.speed[39], rel=1e-6)
    assert wave.speed(velocity, diameter=2.0) == 2.0 * wave.speed(velocity)


def test_a_diameter_with_a_unit_needs_the_others():
    wave = hc.solitary_wave()
    steel = {"mass": 4.073598e-3, "stiffness": 7.435897e9}
    assert wave.speed(0.68, **steel, diameter="10 mm") == 0.01 * wave.speed(0.68, **steel)
    with pytest.raises(hc.InputError, match="a diameter with a unit requires velocity, mass and"):
        wave.speed(0.68, diameter="10 mm")
    with pytest.raises(hc.InputError, match="diameter"):
        wave.speed(0.68, diameter=-1.0)
