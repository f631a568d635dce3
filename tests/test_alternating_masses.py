"""The warning of the BCA about masses that alternate, against simulations."""

import warnings

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.theory.alternating_masses import losses

RNG = np.random.default_rng(8)
STEEL_AND_PTFE = hc.Chain.from_materials(5e-3, ["steel-52100", "ptfe"] * 7, velocity=1e-3)
OUTSIDE = {
    "dimer": hc.Chain.dimer(radii=[1.0, 0.85], beads=60),
    "heavy and light": hc.Chain.dimer(0.6, beads=60),
    "steel and PTFE": STEEL_AND_PTFE,
    "three": hc.Chain.from_radii(np.exp(0.2 * np.array([0, 1, 1] * 20))),
    "random": hc.Chain.from_radii(np.exp(RNG.uniform(-0.11, 0.11, 250))),
}
WITHIN = {
    "dimer": hc.Chain.dimer(radii=[1.0, 0.95], beads=60),
    "four": hc.Chain.from_radii(np.exp(0.1 * np.array([0, 0, 1, 1] * 15))),
    "random": hc.Chain.from_radii(np.exp(0.03 * RNG.standard_normal(60))),
    "step": hc.Chain.from_radii([1.0] * 20 + [2.0] * 20),
    "odd bead": hc.Chain.from_radii([1.0] * 20 + [1.6] + [1.0] * 20),
    "backward-linear": hc.Chain.tapered("backward-linear", 0.9, beads=60),
    "backward-exponential": hc.Chain.tapered("backward-exponential", 0.08, beads=60),
    "forward-linear": hc.Chain.tapered("forward-linear", 0.009, beads=60),
}


def ratios(chain):
    """Velocities of the BCA over simulated ones, without those of the ends."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        theory = hc.bca(chain).velocity
    return (theory / hc.simulate(chain, times=0).pulse().velocity)[1:-1]


@pytest.mark.parametrize("chain", OUTSIDE.values(), ids=OUTSIDE)
def test_a_warning_where_velocities_are_less_than_half(chain):
    with pytest.warns(
        hc.ModelRangeWarning, match="underestimates velocities .* use propagate or simulate"
    ):
        hc.bca(chain)
    assert ratios(chain).min() < 0.5


@pytest.mark.parametrize("chain", WITHIN.values(), ids=WITHIN)
def test_no_warning_where_errors_are_those_of_tapers(chain):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hc.bca(chain)
    found = ratios(chain)
    assert 0.9 < found.min() < found.max() < 1.6


def test_no_warning_for_any_taper():
    for taper, rates in {
        "backward-linear": (0.1, 1.0, 10.0, 1e3), "backward-exponential": (0.01, 0.3, 0.6),
        "forward-linear": (0.001, 0.009), "forward-exponential": (0.01, 0.3, 0.6),
    }.items():  # fmt: skip
        for rate in rates:
            masses = hc.Chain.tapered(taper, rate, beads=40).masses
            np.testing.assert_array_equal(losses(masses), 1.0)


def test_the_loss_of_a_dimer_is_that_of_its_collisions():
    """A collision transfers 4 m M/(m + M)^2 of the energy, and equal masses all of it."""
    m = 0.3
    found = losses(hc.Chain.dimer(m, beads=30).masses)
    np.testing.assert_allclose(found, (4.0 * m / (1.0 + m) ** 2) ** (-0.5 * np.arange(30)))
    # Two beads do not alternate.
    assert losses(np.array([1.0, 0.1])).tolist() == [1.0, 1.0]


def test_the_warning_names_the_bead_from_which_the_loss_is_large():
    chain = hc.Chain.dimer(radii=[1.0, 0.85], beads=60)
    bead = int(np.argmax(losses(chain.masses) > 2.5)) + 1
    short = hc.Chain.dimer(radii=[1.0, 0.85], beads=bead - 1)
    with pytest.warns(hc.ModelRangeWarning, match=rf"more than 2\.5 from bead {bead} on"):
        hc.bca(chain)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hc.bca(short)
