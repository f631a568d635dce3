"""Beads behind a pulse: left where their motion is below the tolerance, taken back when needed."""

import time

import numpy as np
import pytest
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.kernels import state_layout

WALL = hc.Wall()


def window_of(state):
    """Number of beads that the next step is taken for."""
    counts = state.arrays["counts"]
    return int(counts[state_layout.HIGH] - counts[state_layout.LOW])


def struck(beads, **velocities):
    """Velocities of a chain with the given beads struck, as ``b5=1.0``."""
    found = np.zeros(beads)
    for name, velocity in velocities.items():
        found[int(name[1:]) - 1] = velocity
    return found


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-13])
def test_the_wake_of_equal_beads_is_left_behind(rtol):
    run = hc.simulate(hc.Chain.uniform(1500), until=1000.0, times=0, rtol=rtol)
    assert window_of(run.state) <= 40
    # As in a shorter chain, which the pulse leaves before the window has moved far.
    short = hc.simulate(hc.Chain.uniform(60), times=0, rtol=rtol).pulse().velocity[:50]
    assert abs(run.pulse().velocity[:50] / short - 1.0).max() < 1e-14
    assert run.momentum_drift < 1e-13


def test_the_time_of_a_transit_grows_with_the_number_of_beads():
    chains = {beads: hc.Chain.uniform(beads) for beads in (1000, 8000)}
    hc.simulate(chains[1000], times=0, rtol=1e-8)
    best = dict.fromkeys(chains, np.inf)
    for _ in range(5):
        for beads, chain in chains.items():
            began = time.thread_time()
            run = hc.simulate(chain, times=0, rtol=1e-8)
            best[beads] = min(best[beads], time.thread_time() - began)
    assert run.beads_passed == 8000
    # Measured: an exponent of 1.00; when all moving beads were integrated, it was 1.9.
    assert np.log(best[8000] / best[1000]) / np.log(8.0) < 1.2


CHAINS = {
    "wall": (hc.Chain.uniform(40).replace(right_wall=WALL), 90.0),
    "second strike": (
        hc.Chain.uniform(40).replace(
            gaps=[25.0, *[0.0] * 38], velocities=struck(40, b1=0.6, b2=1.0), right_wall=WALL
        ),
        100.0,
    ),
    "two pulses": (hc.Chain.uniform(40).replace(velocities=struck(40, b1=1.0, b40=-0.6)), 80.0),
    "gap": (
        hc.Chain.uniform(40).replace(gaps=[*[0.0] * 24, 2.0, *[0.0] * 14], right_wall=WALL),
        80.0,
    ),
    "struck inside": (
        hc.Chain.uniform(40).replace(velocities=struck(40, b20=1.0), right_wall=WALL), 80.0,
    ),
    "held by a force": (
        hc.Chain.uniform(30).replace(precompression=0.01, held_by="force", right_wall=WALL), 50.0,
    ),
    "gravity": (hc.Chain.uniform(30).replace(gravity=1e-3, right_wall=WALL), 50.0),
    "lossy": (hc.Chain.uniform(40).replace(loss=hc.Restitution(0.98), right_wall=WALL), 80.0),
    "modes": (hc.Chain.uniform(40).replace(loss=hc.WaltonBraun(0.98), right_wall=WALL), 60.0),
    "taper": (
        hc.Chain.tapered("backward-exponential", 0.02, beads=40).replace(right_wall=WALL), 150.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHAINS)
def test_returning_pulses_find_the_beads_left_behind(name):
    chain, until = CHAINS[name]
    times = np.linspace(0.0, until, 41)
    run = hc.simulate(chain, times=times)
    reference = trajectory(chain, times)
    np.testing.assert_allclose(run.velocities, reference.velocities, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(run.forces, reference.forces, rtol=0.0, atol=1e-7)
    assert run.energy_drift < 1e-10
    assert run.momentum_drift < 1e-12


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("rtol", [1e-6, 1e-13])
def test_stops_anywhere_change_no_bit(name, rtol):
    chain, until = CHAINS[name]
    times = np.linspace(0.0, until, 41)
    whole = hc.simulate(chain, times=times, rtol=rtol)
    state = None
    # At each stop, the state is the one before the step that the stop shortens.
    for stop in until * np.array([0.11, 0.23, 0.36, 0.41, 0.6, 0.73, 0.85]):
        state = hc.simulate(chain, until=stop, times=0, start=state, rtol=rtol).state
        if stop < 0.5 * until:
            continue
        later = times[times >= state.time]
        rest = hc.simulate(chain, times=later, start=state, rtol=rtol)
        np.testing.assert_array_equal(rest.velocities, whole.velocities[-len(later) :])
        np.testing.assert_array_equal(rest.positions, whole.positions[-len(later) :])
        for row in ("y", "clock", "flights", "peaks", "crossings", "walls"):
            np.testing.assert_array_equal(rest.state.arrays[row], whole.state.arrays[row])


def test_beads_behind_the_window_collide_and_keep_energy_and_momentum():
    chain = hc.Chain.uniform(3000)
    run = hc.simulate(chain, until=3500.0, times=[3000.0, 3500.0], rtol=1e-6)
    assert window_of(run.state) <= 40
    low = run.state.arrays["counts"][state_layout.LOW]
    # Some have met, and all overlaps store a negligible energy.
    left = run.state.arrays["flights"][state_layout.FLIGHT_TIME, :low]
    assert np.count_nonzero(np.diff(left) < 0.0) > 0
    overlaps = run.positions[-1, : low - 1] - run.positions[-1, 1:low]
    noise = run.state.arrays["clock"][state_layout.UNRESOLVED]
    assert overlaps.max() ** 2.5 < 30.0 * noise**2
    assert run.momentum_drift < 1e-13
    # Of all beads; the drift is that of the window.
    positions, velocities = run.state.positions, run.state.velocities
    closed = np.maximum(positions[:-1] - positions[1:], 0.0)
    energy = 0.5 * (velocities**2).sum() + 0.4 * (closed**2.5).sum()
    assert abs(energy - 0.5) < 0.5 * run.energy_drift + 1e-10
    assert abs(velocities.sum() - 1.0) < 1e-13


def test_a_wake_does_not_stay_in_contact_for_ever():
    run = hc.simulate(hc.Chain.uniform(60), until=1e6, times=11, rtol=1e-6)
    assert run.forces[-1].max() < 1e-6
    assert run.energy_drift < 1e-4


def test_the_number_of_steps_follows_the_tolerance():
    """Also after the pulse has left; it was 35,858 at 1e-11 and 899 at 2e-12."""
    tolerances = [1e-6, 1e-8, 1e-10, 1e-11, 3e-12, 2e-12, 1e-12, 3e-13, 1e-13]
    chain = hc.Chain.uniform(60)
    steps = [hc.simulate(chain, until=200.0, times=0, rtol=rtol).steps for rtol in tolerances]
    # With order 8, a tenth of the tolerance takes a third more steps.
    bound = 1.5 * 1300 * (np.array(tolerances) / 1e-13) ** -0.125
    assert (np.array(steps) < bound).all()


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_a_pulse_that_is_much_slower_than_what_flew_off_is_kept(rtol):
    chain = hc.Chain.tapered("backward-exponential", 0.4, beads=30)
    exact = hc.simulate(chain, times=0, rtol=1e-13).pulse()
    pulse = hc.simulate(chain, times=0, rtol=rtol).pulse()
    assert exact.velocity[-2] < 1e-8
    assert abs(pulse.velocity / exact.velocity - 1.0)[1:].max() < 1e3 * rtol


@pytest.mark.parametrize("beads", [8, 12, 13, 20, 100])
@pytest.mark.parametrize("moving", [{}, {"b1": -1.0}, {"b1": -1.0, "last": 2.0}, {"last": 1e-3}])
def test_beads_that_never_touch_move_uniformly(beads, moving):
    velocities = np.zeros(beads)
    for name, velocity in moving.items():
        velocities[{"b1": 0, "last": -1}[name]] = velocity
    chain = hc.Chain.uniform(beads).replace(velocities=velocities)
    run = hc.simulate(chain, until=20.0, times=5)
    assert abs(run.positions - run.times[:, None] * velocities).max() < 1e-13
    assert not run.forces.any()
    longer = hc.simulate(chain, start=run.state, until=30.0)
    assert abs(longer.positions[-1] - 30.0 * velocities).max() < 1e-13
