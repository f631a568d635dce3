"""The rate 0 of a taper, which is that of a uniform chain."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.chain.tapers import PAPER_TAPERS


@pytest.mark.parametrize("taper", PAPER_TAPERS)
@pytest.mark.parametrize("rate", [0, 0.0, "0%"])
def test_a_taper_of_rate_0_is_a_uniform_chain(taper, rate):
    chain = hc.Chain.tapered(taper, rate, beads=9)
    assert chain.taper is None
    assert chain.description == hc.Chain.uniform(9).description
    steel = hc.Chain.tapered(taper, rate, beads=3, first="5 mm", material="steel-52100")
    np.testing.assert_array_equal(steel.radii, 5e-3)


@pytest.mark.parametrize("taper", PAPER_TAPERS)
@pytest.mark.parametrize("methods", [["propagate"], ["simulate", "bca", "local-rate"]])
def test_sweeps_of_the_rate_begin_at_0(taper, methods):
    found = hc.sweep(
        {
            "chain": {"taper": taper},
            "axes": {"rate": [0.0, 1e-6, 0.01], "beads": [12, 20]},
            "sweep": {"methods": methods, "keep": ["velocity"], "at": "last"},
        }
    )
    velocity = found.velocity.transpose("approach", "rate", "beads").values
    uniform = hc.propagate(hc.Chain.uniform(20)).velocity[-1]
    assert velocity[0, 0, 1] == pytest.approx(uniform, rel=1e-6)
    np.testing.assert_allclose(velocity[:, 0], velocity[:, 1], rtol=1e-4)
    assert (np.abs(velocity[:, 2] / velocity[:, 0] - 1.0) > 1e-3).all()
