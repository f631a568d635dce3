"""Random chains against an independent integration by SciPy, which shares no formula with ours."""

import numpy as np
import pytest
from random_chains import LAWS, force_difference, may_wedge
from scipy_chain import trajectory

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def deviation(case):
    """Of motion, forces, and what has passed through walls and drive until the end."""
    chain, units = case.chain, case.units
    times = np.linspace(0.0, case.until, 41)
    run, motion = hc.simulate(chain, times=times), trajectory(chain, times, units)
    impulses = [
        run.wall_force(side).impulse - motion.impulses[-1, i]
        for i, side in enumerate(("left", "right"))
        if getattr(chain, f"{side}_wall") is not None and not may_wedge(chain)
    ]
    work = 0.0
    if chain.drive is not None:
        work = np.abs(run.budget().energy_given["drive"] - motion.work).max()
    return max(
        np.abs(run.positions - run.positions[0] - motion.displacements).max() / units.length,
        np.abs(run.velocities - motion.velocities).max() / units.velocity,
        force_difference(run, motion.forces, units),
        np.abs(impulses).max(initial=0.0) / (units.force * units.time),
        work / (units.force * units.length),
    )


@pytest.mark.parametrize("law", LAWS)
def test_chains_with_losses(try_chains, law):
    # Measured on 75 chains: 3e-8, and 2.5e-7 where SciPy's method is implicit (alpha < 1).
    most = 2.5e-6 if law == "VelocityPower" else 3e-7
    try_chains(deviation, most, fewer=4, only=("loss",), laws=(law,))


def test_chains_without_losses(try_chains):
    # Measured on 75 chains: 1e-8.
    try_chains(deviation, 1e-7, fewer=4, without=("loss",))


def held(beads, **fields):
    """Equal beads between two walls that press them together."""
    walls = {"left_wall": hc.Wall(), "right_wall": hc.Wall(), "precompression": 0.2}
    return hc.Chain.uniform(beads).replace(**walls | fields)


@pytest.mark.parametrize(
    ("chain", "until"),
    [
        pytest.param(
            held(2, loss=hc.WaltonBraun(0.5)), 20.0, id="beyond the dent and back in a step"
        ),
        pytest.param(
            hc.Chain.uniform(5).replace(
                gravity=0.1, right_wall=hc.Wall(stiffness=1.5), loss=hc.UnloadingRatio(0.9)
            ),
            20.0,
            id="stuck neighbours of a contact that sticks",
        ),
        pytest.param(
            held(
                2,
                loss=hc.UnloadingRatio(0.8),
                drive=hc.Table([0.0, 1.0, 30.0, 31.0], [0.0, 0.2, 0.2, -0.2], of="displacement"),
            ),
            40.0,
            id="a wall that starts from a stuck contact",
        ),
    ],
)
@pytest.mark.xfail(strict=True, reason="modes of contacts are looked at only at the ends of steps")
def test_modes_that_change_within_a_step_or_at_a_kink(chain, until):
    times = np.linspace(0.0, until, 41)
    run, motion = hc.simulate(chain, times=times), trajectory(chain, times)
    np.testing.assert_allclose(run.velocities, motion.velocities, rtol=0, atol=1e-9)
