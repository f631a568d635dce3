"""Quantities with units, at the border."""

import numpy as np
import pint
import pytest

import hertzchain as hc

UNIT = pint.UnitRegistry()


def test_a_chain_described_in_everyday_units():
    radii = np.array([5.0, 4.0]) * UNIT.mm
    chain = hc.Chain.from_materials(
        radii, "brass", velocity=120 * UNIT.cm / UNIT.s, gaps=[2 * UNIT.um],
        gravity=981 * UNIT.cm / UNIT.s**2, right_wall=hc.Wall(gap=0.1 * UNIT.mm),
        loss=hc.Viscoelastic(3 * UNIT.us),
        drive=hc.SineBurst(2 * UNIT.kN, 5 * UNIT.kHz),
        velocities=[1.2, 0.0] * UNIT.m / UNIT.s,
    )  # fmt: skip
    plain = hc.Chain.from_materials(
        [5e-3, 4e-3], "brass", gaps=[2e-6], gravity=9.81, right_wall=hc.Wall(gap=1e-4),
        loss=hc.Viscoelastic(3e-6), drive=hc.SineBurst(2e3, 5e3), velocities=[1.2, 0.0],
    )  # fmt: skip
    for name in ("radii", "masses", "stiffness", "velocities", "gaps", "gravity"):
        np.testing.assert_allclose(getattr(chain, name), getattr(plain, name), rtol=1e-14)
    assert chain.right_wall.gap == pytest.approx(1e-4, rel=1e-14)
    assert chain.loss.time == pytest.approx(3e-6, rel=1e-14)
    assert chain.drive.amplitude == pytest.approx(2e3)
    assert chain.drive.frequency == pytest.approx(5e3)


def test_one_radius_and_the_speed_of_the_strike():
    chain = hc.Chain.from_materials(
        9.525 / 2 * UNIT.mm, "brass", beads=3, velocity=3 * UNIT.km / UNIT.hour
    )
    assert chain.radii[2] == pytest.approx(9.525e-3 / 2)
    assert chain.velocities[0] == pytest.approx(3 / 3.6)


def test_own_materials_may_have_units():
    mine = hc.Material("mine", 7.8 * UNIT.g / UNIT.cm**3, 200 * UNIT.GPa, 0.3, 400 * UNIT.MPa)
    assert (mine.density, mine.young) == pytest.approx((7800.0, 200e9))
    assert mine.yield_strength == pytest.approx(400e6)


def test_the_wrong_dimension_is_refused():
    with pytest.raises(hc.InputError, match="velocity must be convertible to m/s.*meter"):
        hc.Chain.from_materials(5e-3, "brass", beads=3, velocity=3 * UNIT.m)
    with pytest.raises(hc.InputError, match="density of 'x' must be convertible to kg/m"):
        hc.Material("x", 3 * UNIT.m, 2e11, 0.3)


def test_scaled_chains_take_plain_numbers_only():
    with pytest.raises(hc.InputError, match="gap has a unit .* scaled variables"):
        hc.Chain.uniform(3).replace(gaps=[1 * UNIT.m, 0 * UNIT.m])
