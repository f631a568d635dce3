"""The modified BCA in SI units is that of the scaled taper with the same law of the radii."""

import re

import numpy as np
import pytest

import hertzchain as hc

RATES = {
    "backward-linear": 0.3, "backward-exponential": 0.04, "forward-linear": 0.005,
    "forward-exponential": 0.0389,
}  # fmt: skip


@pytest.mark.parametrize("taper", RATES)
def test_a_taper_of_balls_is_converted_through_its_scales(taper):
    scaled = hc.Chain.tapered(taper, RATES[taper], beads=25)
    balls = hc.Chain.tapered(
        taper, RATES[taper], first_diameter="20 mm", material="steel-316", beads=25,
        velocity="1 mm/s",
    )  # fmt: skip
    expected = hc.modified_bca(scaled)
    found = hc.modified_bca(balls)
    np.testing.assert_allclose(found.velocity, 1e-3 * expected.velocity, rtol=1e-11)
    assert found.chain is balls
    np.testing.assert_allclose(
        hc.modified_bca(hc.Scales.of(balls).to_scaled(balls)).velocity,
        expected.velocity,
        rtol=1e-11,
    )
    assert "bead N, which is about 30% too slow within the range of the fit" in str(found)


def test_the_free_end_has_the_largest_error():
    chain = hc.Chain.tapered("forward-exponential", 0.0389, beads=25)
    compared = hc.modified_bca(chain).compare(hc.propagate(chain))
    assert compared.worst_bead("velocity") == 25
    assert compared.worst("velocity") == pytest.approx(0.33, abs=0.01)
    errors = abs(compared.errors("velocity")[1:-1])
    assert compared.worst("velocity", last_bead=24) == errors.max()
    assert compared.rms("velocity", last_bead=24) == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert compared.worst_bead("velocity", last_bead=24) == 2 + errors.argmax()
    others = f"{errors.max():.2%}"
    for text in (str(compared), repr(compared), compared._repr_html_()):
        words = " ".join(text.split())
        after = re.split("without the last bead, at the free end:", words, flags=re.IGNORECASE)[1]
        assert after.split()[:2] == ["velocity", f"{others},"]
    assert "without the last" not in str(hc.bca(chain[:2]).compare(hc.propagate(chain[:2])))


def test_other_radii_are_no_taper():
    radii = 1e-2 * (1.0389 ** -np.arange(25.0))
    radii[12] *= 1.0 + 1e-6
    chain = hc.Chain.from_materials(radii, "steel-316", velocity="1 mm/s")
    with pytest.raises(hc.InputError, match=r"requires a tapered chain .*diameters 20 mm"):
        hc.modified_bca(chain)
