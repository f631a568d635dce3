"""Contacts that leave their mode within one step and are back in it at its end."""

import numpy as np
import pytest
from random_chains import random_case
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.kernels.compilation import uncompiled
from hertzchain.kernels.contact_margins import vanishes_between

DAMPING = ("Restitution", "Viscoelastic", "Dashpot", "VelocityPower")


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
    may_vanish = uncompiled(vanishes_between)
    # A parabola with minimum m has tangents that meet at m - 1/4.
    for least, searched in ((-0.1, True), (0.2, True), (0.3, False)):
        assert may_vanish(least + 0.25, -1.0, least + 0.25, 1.0) == searched
    assert not may_vanish(1e-3, 1.0, 1.0, 1.0)
    assert not may_vanish(1.0, -1.0, 1e-3, -1.0)
    # Tangents that meet outside the step say nothing.
    assert may_vanish(1.0, -0.1, 0.01, 5.0)
