"""The leading pulse under static forces, whose rounding errors must not be taken for it."""

import warnings

import numpy as np
import pytest
from scipy.optimize import brentq

import hertzchain as hc

BEADS, FORCE, SPEED, UNTIL = 40, 20.0, 1e-6, 9e-4


@pytest.fixture(scope="module")
def crystal():
    """A steel crystal and an impact so weak that its contacts are linear springs."""
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=BEADS, velocity=SPEED)
    return chain.replace(precompression=FORCE, held_by="force")


@pytest.fixture(scope="module")
def first_maxima(crystal):
    """Times and values of the first maxima of all velocities but the first, from normal modes."""
    mass, k = crystal.masses[0], crystal.stiffness[0]
    spring = 1.5 * k ** (2 / 3) * FORCE ** (1 / 3)
    springs = 2.0 * np.eye(BEADS) - np.eye(BEADS, k=1) - np.eye(BEADS, k=-1)
    springs[0, 0] = springs[-1, -1] = 1.0
    squares, modes = np.linalg.eigh(spring / mass * springs)
    omega = np.sqrt(np.maximum(squares, 0.0))
    shares = modes * modes[0]

    def acceleration(t, bead):
        return -SPEED * (shares[bead] * omega * np.sin(omega * t)).sum()

    found = []
    for bead in range(1, BEADS):
        # The foot of the pulse rises from below the rounding errors of this sum.
        times = np.linspace(0.5 * bead / omega.max(), UNTIL, 4000)
        slopes = np.array([acceleration(t, bead) for t in times])
        first = np.flatnonzero((slopes[:-1] > 0.0) & (slopes[1:] <= 0.0) & (times[:-1] * omega.max()
                               > 1.5 * bead))[0]  # fmt: skip
        time = brentq(acceleration, times[first], times[first + 1], args=(bead,), xtol=1e-15)
        found.append((time, SPEED * (shares[bead] * np.cos(omega * time)).sum()))
    return np.array(found).T


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-11, 1e-13])
def test_the_pulse_is_found_at_any_tolerance(crystal, first_maxima, rtol):
    pulse = hc.simulate(crystal, until=UNTIL, rtol=rtol, times=0).pulse()
    times, velocities = first_maxima
    np.testing.assert_allclose(pulse.velocity[1:], velocities, rtol=1e-4)
    np.testing.assert_allclose(pulse.peak_time[1:], times, rtol=1e-3)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-11])
def test_ensembles_find_the_pulse_at_any_tolerance(crystal, first_maxima, rtol):
    strong = crystal.replace(precompression=FORCE)
    table = hc.simulate_many([strong], keep=["velocity"], until=UNTIL, rtol=rtol)
    np.testing.assert_allclose(table["velocity"][0][1:], first_maxima[1], rtol=1e-4)


def test_runs_by_fixed_steps_find_the_pulse(crystal, first_maxima):
    pulse = hc.simulate(crystal, until=UNTIL, method="symplectic", drift=1e-8, times=0).pulse()
    np.testing.assert_allclose(pulse.velocity[1:], first_maxima[1], rtol=1e-4)


def test_gradients_are_those_of_the_pulse(crystal, first_maxima):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = hc.gradient(crystal, "pulse.velocity@30", to="masses", until=UNTIL)
    assert found.value == pytest.approx(first_maxima[1][28], rel=1e-4)


def test_a_run_ends_when_the_pulse_has_left_the_crystal(crystal, first_maxima):
    for rtol in (1e-6, 1e-9):
        run = hc.simulate(crystal, rtol=rtol, times=0)
        assert first_maxima[0][-1] < run.state.time < 1.3 * first_maxima[0][-1]


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_weight_is_not_taken_for_the_pulse(rtol):
    chain = hc.Chain.uniform(30).replace(gravity=1e-3, right_wall=hc.Wall())
    chain = chain.replace(velocities=np.append(1e-4, np.zeros(29)))
    pulse = hc.simulate(chain, until=200.0, rtol=rtol, times=0).pulse()
    assert (np.diff(pulse.peak_time[1:]) > 0.0).all()
    assert (pulse.velocity[1:] > 1e-6).all()
