"""Gradients state where a small change makes another maximum the largest one."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.derivatives import kinks

# The best order of 8 steel and 7 PTFE balls has three maxima of nearly the same height.
KINDS = [{"S": "steel-52100", "P": "ptfe"}[each] for each in "SPPSSSSSSPSPPPP"]
BEST = hc.Chain.from_materials("5 mm", KINDS, velocity="2 m/s", right_wall=hc.Wall.of("ptfe"))
SMOOTH = hc.Chain.from_materials("5 mm", "brass", beads=5, velocity=0.01, right_wall=hc.Wall())
# Several maxima, none of which is near the largest one.
ABSORBER = hc.Chain.from_materials(
    [3.175e-3, 2.5e-3, 2e-3, 4e-3, 1.5e-3, 4e-3, 3.175e-3, 2.5e-3, 1.5e-3], "steel-52100",
    velocity=0.3, right_wall=hc.Wall(),
)  # fmt: skip
# Not linear in the closing speed, so that derivatives are differences, but nearly elastic.
LOSSY = hc.WaltonBraun(0.9999)
pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def simulated(chain: hc.Chain, found: hc.Gradient) -> bool:
    """Whether simulated changes of a radius by 1% differ from the derivatives."""
    changed = [
        chain.replace(radii=chain.radii * (1.0 + part * np.eye(chain.beads)[k]))
        for part in (0.01, -0.01) for k in range(chain.beads)
    ]  # fmt: skip
    peaks = hc.simulate_many(changed, keep=["wall_force.peak"])["wall_force.peak"]
    larger, smaller = (peaks / found.value - 1.0).reshape(2, -1)
    return kinks.mislead(0.01 * found.relative("radii"), larger, smaller)


@pytest.mark.parametrize("loss", [None, LOSSY], ids=["adjoint", "differences"])
@pytest.mark.parametrize(
    ("chain", "expected"), [(BEST, True), (SMOOTH, False), (ABSORBER, False)],
    ids=["best", "smooth", "absorber"],
)  # fmt: skip
def test_kinks_are_those_of_simulations(chain: hc.Chain, expected: bool, loss: object) -> None:
    chain = chain.replace(loss=loss)
    found = hc.gradient(chain, "wall_force.peak")
    assert (found.method == "adjoint") == (loss is None)
    assert simulated(chain, found) is expected
    assert found.kinks == (("radii",) if expected else ())
    words = "a change of one of the radii by 1% can make another maximum"
    assert (words in " ".join(repr(found).split())) is expected
    assert (words[1:] in found._repr_html_()) is expected


def test_other_quantities_have_no_kinks() -> None:
    assert hc.gradient(BEST, "wall_force.impulse", until="5 ms").kinks == ()
