import matplotlib.pyplot as plt
import pytest

import hertzchain as hc
from hertzchain.plotting.decades import extends_over_decades, is_pale
from hertzchain.plotting.run_overview import plot_run_and_forces


@pytest.mark.parametrize(
    ("rate", "quantity", "expected"),
    [
        (0.05, "velocity", True),
        (0.05, "energy", False),
        (0.01, "velocity", False),
        (0.05, "arrival", False),
    ],
)
def test_pulses_that_decay_over_decades_need_a_logarithmic_axis(rate, quantity, expected):
    chain = hc.Chain.tapered("backward-exponential", rate, beads=80)
    assert extends_over_decades([hc.propagate(chain), hc.bca(chain)], quantity) == expected


@pytest.mark.parametrize(
    ("chain", "until", "expected"),
    [
        (hc.Chain.tapered("forward-exponential", 0.05, beads=60), None, True),
        (hc.Chain.tapered("backward-exponential", 0.05, beads=60), None, True),
        (hc.Chain.uniform(60), None, False),
        # Beads that the wave has not reached are at rest, not pale.
        (hc.Chain.uniform(60), 20.0, False),
        (hc.Chain.tapered("forward-exponential", 0.05, beads=60), 5.0, False),
    ],
)
def test_maps_with_pale_beads_are_recognised(chain, until, expected):
    assert is_pale(hc.simulate(chain, until=until)) == expected


def test_the_map_below_forces_is_relative_if_beads_are_pale():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=60).replace(right_wall=hc.Wall())
    plot_run_and_forces(hc.simulate(chain), [61])
    labels = [axes.get_ylabel() for axes in plt.gcf().axes]
    assert "velocity / largest of the bead" in labels
