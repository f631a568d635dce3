"""Random chains against an independent integration by SciPy, which shares no formula with ours."""

import numpy as np
import pytest
from random_chains import LAWS
from scipy_chain import trajectory

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def deviation(case):
    """Of motion, forces, and what has passed through walls and drive until the end."""
    chain, units = case.chain, case.units
    times = np.linspace(0.0, case.until, 41)
    run, motion = hc.simulate(chain, times=times), trajectory(chain, times, units)
    budget = run.budget()
    impulses = [
        run.wall_force(side).impulse - motion.impulses[-1, i]
        for i, side in enumerate(("left", "right"))
        if getattr(chain, f"{side}_wall") is not None
    ]
    work = 0.0
    if chain.drive is not None:
        work = np.abs(budget.energy_given["drive"] - motion.work).max()
    return max(
        np.abs(run.positions - run.positions[0] - motion.displacements).max() / units.length,
        np.abs(run.velocities - motion.velocities).max() / units.velocity,
        np.abs(run.forces - motion.forces).max() / units.force,
        np.abs(impulses).max(initial=0.0) / (units.force * units.time),
        work / (units.force * units.length),
    )


@pytest.mark.parametrize("law", LAWS)
def test_chains_with_losses(try_chains, law):
    # Measured: ...
    try_chains(deviation, 1e-6, fewer=4, only=("loss",), laws=(law,))


def test_chains_without_losses(try_chains):
    try_chains(deviation, 1e-6, fewer=4, without=("loss",))
