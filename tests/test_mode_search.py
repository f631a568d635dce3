"""Contacts that leave their mode within one step and are back in it at its end."""

import numpy as np
import pytest
from kernel_call import callable_from_python
from random_chains import random_case
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.kernels.contact_margins import vanishes_between

DAMPING = ("Restitution", "Viscoelastic", "Dashpot", "VelocityPower")


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "laws", "rtol", "most"),
    [
        # Forces that may not pull, cut off for a part of a step.
        (172, DAMPING, 1e-13, 1e-10),
        (199, DAMPING, 1e-9, 1e-8),
        (1235, DAMPING, 1e-9, 5e-7),
        # Contacts that are stuck for a part of a step.
        (128, ("UnloadingRatio",), 1e-9, 1e-7),
        (179, ("UnloadingRatio",), 1e-9, 5e-7),
        (285, ("UnloadingRatio",), 1e-9, 2e-7),
    ],
)
def test_modes_within_a_step_are_found(seed, laws, rtol, most):
    # Velocities differ by 5e-12, 6e-10, 6e-8, 9e-9, 6e-8 and 2e-8; by 5e-6 to 3e-3 if unseen.
    case = random_case(seed, only=("loss",), laws=laws)
    times = np.linspace(0.0, case.until, 41)
    run = hc.simulate(case.chain, times=times, rtol=rtol)
    motion = trajectory(case.chain, times, case.units)
    apart = np.abs(run.velocities - motion.velocities).max() / case.units.velocity
    assert apart < most


def test_margins_that_may_vanish():
    may_vanish = callable_from_python(vanishes_between)
    # A parabola with minimum m has tangents that meet at m - 1/4.
    for least, searched in ((-0.1, True), (0.2, True), (0.3, False)):
        assert may_vanish(least + 0.25, -1.0, least + 0.25, 1.0) == searched
    assert not may_vanish(1e-3, 1.0, 1.0, 1.0)
    assert not may_vanish(1.0, -1.0, 1e-3, -1.0)
    # Tangents that meet outside the step say nothing.
    assert may_vanish(1.0, -0.1, 0.01, 5.0)


@pytest.mark.parametrize("velocities", [[0.3, 0.0, 0.0], [0.05, -0.02, 0.01]])
@pytest.mark.parametrize("gravity", [0.0, 0.05])
def test_the_common_force_of_contacts_at_rest_between_walls(velocities, gravity):
    """It is in the middle of those that all contacts can bear, whatever the rounding."""
    chain = hc.Chain.uniform(3).replace(
        loss=hc.UnloadingRatio(0.6), velocities=velocities, gravity=gravity, precompression=0.2,
        left_wall=hc.Wall(), right_wall=hc.Wall(), held_by="walls",
    )  # fmt: skip
    mirrored = chain.replace(velocities=np.negative(velocities[::-1]), gravity=-gravity)
    times = [0.0, 300.0]
    run = hc.simulate(chain, times=times)
    forces = run.forces[-1]
    weight, k = np.append(0.0, np.cumsum(chain.masses * gravity)), chain.contact_stiffness
    static = ((0.2 + weight) / k) ** (2 / 3)
    loading = k * (static - np.diff(np.pad(run.positions[-1] - run.positions[0], 1))) ** 1.5
    middle = 0.5 * (np.max(0.4 * loading - weight) + np.min(loading - weight))
    np.testing.assert_allclose(forces, weight + middle, rtol=0, atol=1e-13)
    # Measured: 2e-12 and 1e-11; .08 where rounding decided.
    np.testing.assert_allclose(
        hc.simulate(mirrored, times=times).forces[-1][::-1], forces, rtol=0, atol=2e-11
    )
    rough = hc.simulate(chain, times=times, rtol=1e-9)
    np.testing.assert_allclose(rough.forces[-1], forces, rtol=0, atol=1e-10)
