"""Front-following against the full chain and against SciPy."""

import itertools

import numpy as np
import pytest
import scipy_reference
from hypothesis import given, settings
from hypothesis import strategies as st
from interruption import interrupted
from pulse_errors import COLUMNS, largest_error

import hertzchain as hc
from hertzchain.propagation import propagate


def full(chain):
    return hc.simulate(chain, times=0).pulse()


TAPERS = [
    ("backward-linear", 0.1, 3e-9),
    ("backward-linear", 0.9, 3e-7),
    ("backward-exponential", 0.01, 3e-9),
    ("backward-exponential", 0.08, 1e-8),
    ("backward-exponential", 0.3, 5e-8),
    ("backward-exponential", 0.5, 1e-7),
    ("forward-linear", 0.001, 3e-9),
    ("forward-linear", 0.009, 3e-9),
    ("forward-linear", 0.0101, 1e-7),
    ("forward-exponential", 0.01, 3e-9),
    ("forward-exponential", 0.06, 3e-9),
    ("forward-exponential", 0.12, 5e-8),
    ("forward-exponential", 0.15, 5e-9),
    ("forward-exponential", 0.25, 1e-8),
]


@pytest.mark.parametrize(("taper", "rate", "tolerance"), TAPERS)
def test_tapers_agree_with_the_full_chain(taper, rate, tolerance):
    chain = hc.Chain.tapered(taper, rate, beads=100)
    assert largest_error(hc.propagate(chain), full(chain)) < tolerance


def test_strong_forward_taper_agrees_with_the_full_chain():
    chain = hc.Chain.tapered("forward-exponential", 0.4, beads=24)
    assert largest_error(hc.propagate(chain), full(chain)) < 5e-9


def test_beads_near_zero_radius():
    chain = hc.Chain.tapered("forward-linear", 0.01, beads=100)
    assert chain.radii[-1] == pytest.approx(0.01)
    pulse = hc.propagate(chain)
    assert np.any(np.diff(pulse.peak_time) < 0.0)  # light beads peak before heavy ones
    assert largest_error(pulse, full(chain)) < 3e-8


def test_against_scipy():
    """An independent path: SciPy's DOP853 and a root finder."""
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=40)
    pulse = hc.propagate(chain)
    velocities, times = scipy_reference.peaks(chain.radii, 1.02 * pulse.peak_time[-1])
    assert np.max(np.abs(pulse.velocity[1:-1] / velocities - 1.0)) < 3e-9
    assert np.max(np.abs(pulse.peak_time[1:-1] / times - 1.0)) < 3e-9


def test_equal_beads_against_an_integration_at_a_tolerance_of_1e_13():
    """Beads 2..8, the limit, its period and the last bead; values of SciPy's DOP853."""
    pulse = hc.propagate(hc.Chain.uniform(100))
    velocities = [
        0.751471736247, 0.714561003489, 0.698649441531, 0.690749497480, 0.686608736488,
        0.684377061915, 0.683155358512,
    ]  # fmt: skip
    times = [
        1.8828111864, 3.1210959390, 4.3295734157, 5.5272747592, 6.7206217128, 7.9120858067,
        9.1026863759,
    ]  # fmt: skip
    assert pulse.velocity[1:8] == pytest.approx(velocities, rel=1e-9)
    assert pulse.peak_time[1:8] == pytest.approx(times, rel=1e-9)
    assert pulse.velocity[20] == pytest.approx(0.681632351111, rel=1e-9)
    assert pulse.velocity[90] == pytest.approx(0.681631548571, rel=1e-9)
    assert pulse.peak_time[20] == pytest.approx(24.5704305820, rel=1e-9)
    assert np.diff(pulse.peak_time)[60] == pytest.approx(1.1897555770, rel=2e-9)
    assert pulse.peak_force[90] == pytest.approx(0.6395542321, rel=1e-9)
    assert pulse.peak_overlap[90] == pytest.approx(0.7423093281, rel=1e-9)
    assert pulse.velocity[-1] == pytest.approx(0.98567886, rel=1e-8)


RATES = [
    ("backward-exponential", 0.05, -0.08047222, 2e-8),
    ("backward-exponential", 0.20, -0.39361717, 2e-8),
    ("forward-exponential", 0.05, 0.06748234, 2e-8),
    ("forward-exponential", 0.10, 0.113900, 2e-6),
]


@pytest.mark.parametrize(("taper", "rate", "per_bead", "tolerance"), RATES)
def test_exponential_tapers_run_into_their_rate(taper, rate, per_bead, tolerance):
    velocity = hc.propagate(hc.Chain.tapered(taper, rate, beads=70)).velocity
    assert np.log(velocity[60] / velocity[59]) == pytest.approx(per_bead, abs=tolerance)


def test_other_force_laws():
    """Amplitude of the equal-bead strike for exponents p (third digit block of a table)."""
    for exponent, velocity in ((1.25, 0.57733689), (2.0, 0.79433275), (3.0, 0.90128004)):
        pulse = hc.propagate(hc.Chain.uniform(80, exponent=exponent))
        assert pulse.velocity[70] == pytest.approx(velocity, rel=2e-8)


@pytest.mark.parametrize("beads", [2, 3, 4, 5, 9])
def test_short_chains(beads):
    chain = hc.Chain.uniform(beads)
    assert largest_error(hc.propagate(chain), full(chain)) < 1e-7


def test_two_beads_exchange_velocities_by_their_masses():
    pulse = hc.propagate(hc.Chain.from_radii([1.0, 2.0]))
    assert pulse.velocity[1] == pytest.approx(2.0 / 9.0, rel=1e-9)


@pytest.mark.parametrize("light", [0.9, 0.6, 0.35])
def test_decorated_chains(light):
    radii = np.ones(60)
    radii[1::2] = light
    chain = hc.Chain.from_radii(radii)
    assert largest_error(hc.propagate(chain), full(chain)) < 5e-8


@pytest.mark.parametrize("spread", [0.05, 0.2, 0.5])
def test_long_random_chains(spread):
    """Longer than what is integrated whole, so that every window moves."""
    radii = np.exp(spread * np.random.default_rng(1).uniform(-1, 1, 160))
    chain = hc.Chain.from_radii(radii)
    assert largest_error(hc.propagate(chain), full(chain)) < 1e-7


@settings(max_examples=25)
@given(
    st.lists(st.floats(0.3, 3.0), min_size=2, max_size=40),
    st.floats(0.02, 1.0),
)
def test_random_radii_agree_with_the_full_chain(radii, spread):
    """From nearly equal beads to any radii between 0.3 and 3, on every bead."""
    chain = hc.Chain.from_radii(np.array(radii) ** spread)
    assert largest_error(hc.propagate(chain), full(chain)) < 10 * propagate.DEFAULT_RTOL


@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-9, 1e-10])
@pytest.mark.parametrize("rate", [0.02, 0.06])
def test_errors_keep_to_the_tolerance(rtol, rate):
    for taper in ("backward-exponential", "forward-exponential"):
        chain = hc.Chain.tapered(taper, rate, beads=80)
        error = largest_error(hc.propagate(chain, rtol=rtol), full(chain))
        assert error < 10 * rtol


def test_smaller_tolerance_gives_smaller_errors():
    chain = hc.Chain.uniform(60)
    errors = [largest_error(hc.propagate(chain, rtol=rtol), full(chain)) for rtol in (1e-6, 1e-9)]
    assert errors[1] < errors[0] / 20


def test_the_amplitude_lasts_on_a_long_chain():
    seen = []
    pulse = hc.propagate(
        hc.Chain.uniform(30_000), progress=lambda done, of: seen.append((done, of))
    )
    assert pulse.velocity[-1000] == pytest.approx(0.681631548571, rel=1e-7)
    assert seen[-1] == (30_000, 30_000)


@pytest.mark.parametrize("rtol", [0.0, 1e-12, 0.1, float("nan"), "small"])
def test_tolerances_that_cannot_be_met(rtol):
    with pytest.raises(hc.InputError, match="rtol must be"):
        hc.propagate(hc.Chain.uniform(3), rtol=rtol)


def test_pulse_that_cannot_be_followed_is_an_error():
    with pytest.raises((hc.SimulationError, hc.InputError), match="small|underflow"):
        hc.propagate(hc.Chain.tapered("backward-exponential", 0.9, beads=100))


# Ensembles.


def test_ensemble_rows_are_the_single_chains():
    rates = np.linspace(0.01, 0.06, 7)
    chains = [hc.Chain.tapered("forward-exponential", q, beads=50) for q in rates]
    table = hc.propagate_many(chains)
    for chain, pulse in zip(chains, table, strict=True):
        alone = hc.propagate(chain)
        for name in COLUMNS:
            assert np.array_equal(pulse.column(name), alone.column(name))


def test_threads_change_no_bit(monkeypatch):
    monkeypatch.setattr(propagate, "BLOCK_BEADS", 500)
    radii = np.random.default_rng(2).uniform(0.95, 1.05, (60, 40))
    one = hc.propagate_many(radii, threads=1)
    two = hc.propagate_many(radii, threads=2)
    for name in COLUMNS:
        assert np.array_equal(getattr(one, name), getattr(two, name))


def test_place_in_the_ensemble_changes_nothing():
    rng = np.random.default_rng(4)
    rows = np.sort(rng.uniform(1.0, 2.0, (21, 30)), axis=1)
    table = hc.propagate_many(rows)
    order = rng.permutation(21)
    assert np.array_equal(hc.propagate_many(rows[order]).velocity, table.velocity[order])


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_bad_chains_among_good_ones():
    rows = np.ones((6, 10))
    rows[1, 3], rows[2, 0], rows[4, 9] = -2.0, np.nan, 1e120
    table = hc.propagate_many(rows)
    assert list(table.status) == ["followed", "failed", "failed", "followed", "failed", "followed"]
    assert table.reasons[1].startswith("radius of bead 4 is -2: radii must be positive")
    assert "bead 10" in table.reasons[4]
    assert np.isnan(table.velocity[[1, 2, 4]]).all()
    assert table.velocity[[0, 3, 5]].min() > 0.5
    with pytest.raises(hc.SimulationError, match="chain 1 has no pulse: radius of bead 4"):
        table[1]
    assert table[-1].velocity[1] == pytest.approx(0.751471736247, rel=1e-9)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_a_chain_that_fails_underway_is_marked():
    good, bad = hc.Chain.uniform(100), hc.Chain.tapered("backward-exponential", 0.9, beads=100)
    table = hc.propagate_many([good, bad, good])
    assert list(table.reasons) == [1]
    assert np.array_equal(table.velocity[0], table.velocity[2])


def test_ragged_chains_are_padded():
    table = hc.propagate_many([hc.Chain.uniform(4), [3.0, 3.0], hc.Chain.uniform(7, exponent=2.0)])
    assert list(table.beads) == [4, 2, 7]
    assert table.velocity.shape == (3, 7)
    assert table.peak_overlap.shape == (3, 6)
    assert np.isnan(table.velocity[1, 2:]).all()
    assert np.isfinite(table.velocity[2]).all()
    assert table[2].chain.exponent == 2.0
    assert table[1].velocity[1] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("nothing", [[], np.empty((0, 5)), np.empty((0, 0))])
def test_empty_ensemble(nothing):
    table = hc.propagate_many(nothing)
    assert len(table) == 0
    assert list(table) == []
    assert table.to_xarray().sizes["chain"] == 0


def test_labelled_table():
    dataset = hc.propagate_many(np.ones((2, 5)) * [[1.0], [7.0]]).to_xarray()
    assert dataset.velocity.dims == ("chain", "bead")
    assert float(dataset.velocity.sel(chain=1, bead=2)) == pytest.approx(0.7514717362, rel=1e-9)
    assert dataset.peak_overlap.dims == ("chain", "contact")


def test_progress_counts_chains(monkeypatch):
    monkeypatch.setattr(propagate, "BLOCK_BEADS", 100)
    seen = []
    hc.propagate_many(np.ones((40, 10)), progress=lambda done, of: seen.append((done, of)))
    assert seen[-1] == (40, 40)
    assert all(a <= b for a, b in itertools.pairwise(seen))


@pytest.mark.parametrize("threads", [0, -1, 1.5, "two", True])
def test_bad_threads(threads):
    with pytest.raises(hc.InputError, match="threads must be"):
        hc.propagate_many(np.ones((1, 3)), threads=threads)


@pytest.mark.parametrize(
    ("chains", "said"),
    [
        (hc.Chain.uniform(3), "requires a list of chains, got one chain; use propagate"),
        ("forward", "a list of chains or rows of radii, got 'forward'"),
        (7, "a list of chains or rows of radii, got 7"),
        ([1, 2, 3], r"got \[1, 2, 3\]; put a single row of radii in a list"),
        (np.ones(3), "put a single row of radii in a list"),
        ([hc.Chain.uniform(3), 3], "item 2 of chains must be a chain or a row of radii, got 3"),
        (["one"], "item 1 of chains must be a chain or a row of radii, got 'one'"),
    ],
)
def test_invalid_ensembles(chains, said):
    with pytest.raises(hc.InputError, match=said):
        hc.propagate_many(chains)


INTERRUPTED = {
    "ensemble": "hc.propagate_many(np.ones((100_000, 100)), progress=report)",
    "chain": "hc.propagate(hc.Chain.from_radii(1 + 1e-6 * np.arange(3e6)), progress=report)",
    "heterogeneous": "hc.propagate_many(np.tile([1.0, 0.4], (20_000, 50)), progress=report)",
}


@pytest.mark.parametrize("what", INTERRUPTED)
def test_interrupt(what):
    """Ctrl-C ends long work within a second and reports its progress."""
    code = f"""
        import numpy as np, hertzchain as hc
        hc.propagate(hc.Chain.uniform(9)), hc.propagate_many(np.ones((9, 9)))
        hc.propagate(hc.Chain.from_radii([1.0, 0.4, 1.0]))
        report = lambda done, of: print("working", flush=True)
        {INTERRUPTED[what]}
    """
    errors = interrupted(code)
    assert "KeyboardInterrupt" in errors
    assert "stopped after" in errors
