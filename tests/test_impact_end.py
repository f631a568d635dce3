"""The end of the impact on a wall does not depend on the steps of the integration."""

import numpy as np
import pytest
from impact_reference import impact

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")


def forward(beads, rate, **changes):
    radii = np.exp(-rate * np.arange(beads)) * (1.0 + 0.1 * np.sin(3.0 * np.arange(beads)))
    return hc.Chain.from_radii(radii).replace(**{"right_wall": hc.Wall(stiffness=5.0)} | changes)


CHAINS = {
    "train": forward(14, 0.06),
    "soft wall": forward(9, 0.02, right_wall=hc.Wall(stiffness=0.1)),
    "stiff wall": forward(8, -0.03, right_wall=hc.Wall(stiffness=1e4)),
    "gap": forward(8, 0.03, right_wall=hc.Wall(stiffness=2.0, gap=0.5)),
    "gravity": forward(10, 0.05, gravity=1e-3),
    "gravity away from the wall": forward(10, 0.05, gravity=-1e-3),
    "precompression": forward(8, 0.0, precompression=0.05, left_wall=hc.Wall()),
}


@pytest.mark.parametrize("name", CHAINS)
def test_the_impact_ends_where_scipy_locates_it(name):
    chain = CHAINS[name]
    until = 60.0 if name == "precompression" else None
    run = hc.simulate(chain, times=0, until=until)
    end, impulse = impact(chain, run.end_time)
    for rtol, tolerance in ((None, 1e-7), (1e-6, 1e-4)):
        options = {} if rtol is None else {"rtol": rtol}
        again = hc.simulate(chain, times=0, until=run.end_time, **options)
        state = again._completion[-3:, 1]
        assert state[0] == pytest.approx(end, rel=tolerance)
        assert state[1] == pytest.approx(impulse, rel=tolerance)
        assert state[2] >= 1


@pytest.mark.parametrize("name", [name for name in CHAINS if name != "precompression"])
def test_all_functions_end_an_impact_at_the_same_time(name):
    chain = CHAINS[name]
    end, impulse = impact(chain, hc.simulate(chain, times=0).end_time)
    table = hc.simulate_many([chain] * 3, keep=["wall_impulse_of_impact", "wall_duration"])
    np.testing.assert_allclose(table["wall_impulse_of_impact"], impulse, rtol=1e-6)
    wall = hc.simulate(chain, times=0, method="forward-4", step=0.01).wall_force()
    assert wall.complete_since == pytest.approx(end, rel=1e-4)
    assert wall.impulse_of_impact == pytest.approx(impulse, rel=1e-4)
    if not chain.gravity:
        slope = hc.gradient(chain, "wall_force.impulse_of_impact")
        assert slope.value == pytest.approx(impulse, rel=1e-6)
