"""Heterogeneous chains: the wide window, its checks, and chains that raise an error."""

import re

import numpy as np
import pytest
import scipy_reference
from numba import njit
from pulse_errors import COLUMNS, largest_error
from scipy.optimize import brentq

import hertzchain as hc
from hertzchain.kernels import wide_window, wide_window_rows
from hertzchain.propagation import heterogeneous
from hertzchain.propagation.batch import Batch
from hertzchain.threads import COUNT

RADII = np.array([1, 0.3, 3, 0.5, 1, 2, 0.4, 0.6, 1, 0.3, 1, 1, 3, 0.3, 0.3, 1])


def strongly_random(beads, seed=7):
    return hc.Chain.from_radii(np.random.default_rng(seed).uniform(0.3, 3.0, beads))


def follow(chains, behind=100, tolerance=1e-9, grading=1.1, work=10**9):
    """Columns of all chains in one row, and what became of each."""
    batch = Batch.of(chains)
    columns = np.zeros((wide_window_rows.COLUMNS, len(batch.masses)))
    status = np.zeros(len(chains), np.int64)
    wide_window.follow(
        (behind, tolerance, grading),
        (batch.given, batch.first, batch.beads, batch.chain_exponents),
        columns, status, np.full(len(chains), work), np.zeros(2, np.int64),
        wide_window.new_scratch(),
    )  # fmt: skip
    return columns, status


# The kernel.


@njit
def steps_of_two_beads(w, steps, exponent):
    for i in range(2):
        w[wide_window_rows.TRIAL + i] = w[wide_window_rows.POSITION + i]
    wide_window_rows.accelerate(w, 2, exponent, wide_window_rows.STAGE_0)
    for _ in range(steps):
        wide_window_rows.try_step(w, 2, 1.0 / steps, exponent)
        wide_window.accept(w, 2)


def energy_error(steps, exponent):
    """Two compressed beads are released: overlap and velocity conserve energy."""
    w = wide_window.new_scratch()[0]
    w[wide_window_rows.STIFFNESS] = 1.0
    w[wide_window_rows.INVERSE_MASS : wide_window_rows.INVERSE_MASS + 2] = 1.0
    w[wide_window_rows.EXPONENT : wide_window_rows.EXPONENT + 2] = exponent
    w[wide_window_rows.POSITION] = 1.0
    steps_of_two_beads(w, steps, exponent)
    overlap = w[wide_window_rows.POSITION] - w[wide_window_rows.POSITION + 1]
    speed = w[wide_window_rows.VELOCITY + 1] - w[wide_window_rows.VELOCITY]
    return abs(speed**2 / 4.0 + (overlap ** (exponent + 1.0) - 1.0) / (exponent + 1.0))


@pytest.mark.parametrize("exponent", [1.5, 2.0, 2.6])
def test_order_8(exponent):
    # Before rounding counts, the order seen rises from 7 towards 8.
    errors = [energy_error(steps, exponent) for steps in (2, 4)]
    assert errors[0] < 5e-7
    assert errors[0] / errors[1] > 2.0**6.8


def largest_difference(one, other):
    return np.max(np.abs(one[0, 1:] / other[0, 1:] - 1.0))


def test_errors_follow_the_tolerance():
    fine, *others = (follow([strongly_random(40)], tolerance=t)[0] for t in (1e-11, 1e-5, 1e-9))
    loose, tight = (largest_difference(columns, fine) for columns in others)
    assert tight < 1e-9 < 1e-7 < loose < 3e-5


def test_what_is_behind_matters_in_disorder():
    """No fixed window is sufficient: 24 beads are too few for this chain, but not for a dimer."""
    dimer = hc.Chain.from_radii(np.tile([1.0, 0.5], 50))
    for chain, low, high in ((strongly_random(100), 1e-5, 1.0), (dimer, 0.0, 1e-8)):
        narrow, wide = (follow([chain], behind=behind)[0] for behind in (24, 100))
        assert low <= largest_difference(narrow, wide) < high


def test_window_without_room_is_noticed():
    """Beads far behind the front still wait for their maxima: all must stay in the window."""
    chain = hc.Chain.tapered("forward-exponential", 0.3, beads=wide_window_rows.SLOTS + 60)
    status = follow([chain, hc.Chain.uniform(5)])[1]
    assert list(status) == [wide_window.WINDOW_FULL, wide_window.FOLLOWED]


def test_motion_that_vanishes_is_noticed():
    chain = hc.Chain.tapered("backward-exponential", 0.9, beads=100)
    assert follow([chain])[1][0] == wide_window.BROKEN


def test_work_of_a_chain_is_limited():
    assert follow([hc.Chain.uniform(50)], work=50)[1][0] == wide_window.STALLED


def test_stop_signal_ends_the_kernel():
    batch, signal = Batch.of([strongly_random(30)] * 3), np.array([1, 0])
    columns = np.zeros((wide_window_rows.COLUMNS, 90))
    status = np.full(3, wide_window.RUNNING)
    wide_window.follow(
        (48, 1e-8, 1.3), (batch.given, batch.first, batch.beads, batch.chain_exponents),
        columns, status, np.full(3, 10**9), signal, wide_window.new_scratch(),
    )  # fmt: skip
    assert list(status) == [wide_window.STOPPED, wide_window.RUNNING, wide_window.RUNNING]
    assert signal[COUNT] == 0


# Results of `propagate`.


def test_against_scipy():
    """An independent path: SciPy's DOP853 and a root finder."""
    pulse = hc.propagate(hc.Chain.from_radii(RADII))
    velocities, times = scipy_reference.peaks(RADII / RADII[0], 1.02 * pulse.peak_time.max())
    assert np.max(np.abs(pulse.velocity[1:-1] / velocities - 1.0)) < 3e-9
    assert np.max(np.abs(pulse.peak_time[1:-1] / times - 1.0)) < 2e-9
    assert np.any(np.diff(pulse.peak_time) < 0.0)


@pytest.mark.parametrize("exponent", [1.05, 1.5, 2.0, 2.7, 7.0])
def test_two_beads_in_closed_form(exponent):
    """Speeds by the masses; overlap where all relative energy is in the contact."""
    chain = hc.Chain.from_radii([1.0, 0.4], exponent=exponent)
    pulse = hc.propagate(chain)
    mass = 0.4**3
    reduced = mass / (1.0 + mass)
    overlap = (0.5 * (exponent + 1.0) * reduced / chain.stiffness[0]) ** (1.0 / (exponent + 1.0))
    assert pulse.velocity[1] == pytest.approx(2.0 / (1.0 + mass), rel=1e-8)
    assert pulse.peak_overlap[0] == pytest.approx(overlap, rel=1e-8)


@pytest.mark.parametrize("exponent", [1.1, 2.0, 5.0])
@pytest.mark.parametrize("taper", ["backward-exponential", "forward-exponential"])
def test_other_force_laws_agree_with_the_full_chain(taper, exponent):
    chain = hc.Chain.tapered(taper, 0.05, beads=60, exponent=exponent)
    assert largest_error(hc.propagate(chain), hc.simulate(chain, times=0).pulse()) < 1e-8


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_errors_keep_to_the_tolerance(rtol):
    chain = strongly_random(60, seed=3)
    assert largest_error(hc.propagate(chain, rtol=rtol), hc.simulate(chain, times=0).pulse()) < rtol


def test_residences_are_times_between_arrivals():
    pulse = hc.propagate(hc.Chain.from_radii(RADII))
    assert np.diff(pulse.arrival) == pytest.approx(pulse.residence, rel=1e-9, abs=1e-12)
    assert pulse.residence.min() < 0.0  # a light bead is overtaken after the next one


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_results_that_do_not_agree_are_an_error(monkeypatch):
    """With the first ways only, the window is too narrow for this chain."""
    monkeypatch.setattr(heterogeneous, "WINDOW_SETTINGS", heterogeneous.WINDOW_SETTINGS[:3])
    chains = [strongly_random(100), hc.Chain.from_radii([1.0, 0.3, 1.0])]
    with pytest.raises(hc.SimulationError, match="results at two tolerances differ by"):
        hc.propagate(chains[0])
    table = hc.propagate_many(chains)
    assert list(table.reasons) == [0]
    assert np.isnan(table.velocity[0]).all()
    assert np.isfinite(table.velocity[1, :3]).all()


def test_motion_that_amplifies_errors_is_an_error():
    """Beads that press on each other all the way: even the full chain has no digits there."""
    chain = hc.Chain.tapered("forward-exponential", 0.5, beads=24)
    runs = [hc.simulate(chain, times=0, rtol=rtol).pulse() for rtol in (1e-12, 1e-13)]
    # A million times the tolerance.
    assert runs[0].compare(runs[1]).worst("velocity", first_bead=1) > 1e-6
    with pytest.raises(hc.SimulationError, match="amplifies rounding errors; use fewer beads$"):
        hc.propagate(chain)


def test_tolerance_that_can_be_met_is_named(monkeypatch):
    monkeypatch.setattr(heterogeneous, "AGREEMENT", 1e-5)
    with pytest.raises(hc.SimulationError, match=r"or rtol = \de-\d+ or more"):
        hc.propagate(strongly_random(60))


def test_whole_chain_agrees_with_the_window():
    chain = strongly_random(50)
    columns = heterogeneous.integrate_full_chain(chain, 1e-8, np.zeros(2, np.int64))
    assert np.max(np.abs(columns[0] / hc.propagate(chain).velocity - 1.0)) < 3e-9


def test_whole_chain_at_two_tolerances(monkeypatch):
    monkeypatch.setattr(heterogeneous, "AGREEMENT", 1e-9)
    with pytest.raises(hc.SimulationError, match="amplifies"):
        heterogeneous.integrate_full_chain(strongly_random(50), 1e-8, np.zeros(2, np.int64))


def test_too_long_for_the_whole_chain():
    chain = hc.Chain.uniform(heterogeneous.WHOLE + 1)
    with pytest.raises(hc.SimulationError, match=r"2001 beads cannot .* at most 2000 beads"):
        heterogeneous.integrate_full_chain(chain, 1e-8, np.zeros(2, np.int64))


def test_stop_ends_the_whole_chain():
    with pytest.raises(hc.SimulationError, match="stopped"):
        heterogeneous.integrate_full_chain(hc.Chain.uniform(20), 1e-8, np.array([1, 0]))


def test_ensemble_of_uneven_chains():
    """Results are equal, bit for bit, for one chain, in an ensemble and on two threads."""
    rows = np.random.default_rng(2).uniform(0.3, 3.0, (300, 25))
    one, two = (hc.propagate_many(rows, threads=threads) for threads in (1, 2))
    assert not one.reasons
    for name in COLUMNS:
        assert np.array_equal(getattr(one, name), getattr(two, name))
        assert np.array_equal(
            one[200].column(name), hc.propagate(hc.Chain.from_radii(rows[200])).column(name)
        )


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_a_hopeless_chain_ends_soon_with_advice_that_can_be_followed(monkeypatch):
    """Light beads that rattle: a million steps of the whole chain were not enough."""
    monkeypatch.setattr(heterogeneous, "WHOLE_BEAD_STEPS", 200_000)
    chain = hc.Chain.from_radii(10.0 ** np.random.default_rng(5).uniform(-2.0, 0.5, 40))
    with pytest.raises(hc.SimulationError, match="light beads bounce") as raised:
        hc.propagate(chain)
    said = str(raised.value)
    assert "after 5000 steps" in said
    assert "max_steps" not in said
    table = hc.propagate_many([chain, hc.Chain.uniform(5)])
    assert table.reasons == {0: said}


def test_the_cause_in_a_steep_taper_is_the_range_of_its_contacts(monkeypatch):
    monkeypatch.setattr(heterogeneous, "WHOLE_BEAD_STEPS", 200_000)
    with pytest.raises(hc.SimulationError, match="step limit reached") as raised:
        hc.propagate(hc.Chain.tapered("forward-exponential", 0.5, beads=60))
    said = str(raised.value)
    assert re.search(r"passes contact 59 \de\+1\d times faster than contact 1,", said)
    assert "use fewer beads or a weaker taper" in said
    assert "bounce" not in said


def test_a_contact_counts_as_passed_when_its_bead_turns_round_within_the_step():
    radii = np.append(1.0, np.exp(np.random.default_rng(355).uniform(-0.8, 0.8, 9)))
    left, right = 7, 8
    dense = scipy_reference.trajectory(radii, 14.0).sol

    def closing(t):
        state = dense(t)
        return state[10 + left] - state[10 + right]

    times = np.linspace(0.0, 14.0, 14001)
    touching = dense(times)[left] - dense(times)[right] > 1e-6
    rates = closing(times)
    first = np.flatnonzero(touching[1:] & (rates[:-1] > 0.0) & (rates[1:] <= 0.0))[0]
    passed = brentq(closing, *times[first : first + 2], xtol=1e-13)
    chain = hc.Chain.from_radii(radii)
    assert hc.simulate(chain, times=0).pulse().arrival[right] == pytest.approx(passed, rel=1e-10)
    assert hc.propagate(chain).arrival[right] == pytest.approx(passed, rel=1e-7)
