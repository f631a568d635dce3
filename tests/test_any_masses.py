"""`propagate` of chains whose masses, contacts and strikers do not follow from radii."""

import numba
import numpy as np
import pytest
from pulse_errors import COLUMNS
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hertzchain as hc
from hertzchain.kernels.powers import power
from hertzchain.propagation import geometric_series, window_choice
from hertzchain.propagation.batch import Batch

RANDOM = np.random.default_rng(3)


def random_materials():
    kinds = list(RANDOM.choice(["steel-316", "ptfe", "brass"], 40))
    return hc.Chain.from_materials(RANDOM.uniform(3e-3, 8e-3, 40), kinds, velocity=1e-3)


def smooth_masses():
    k = np.arange(60)
    stiffness = np.exp(0.2 * np.cos(k[:-1] / 9))
    return hc.Chain(np.ones(60), masses=np.exp(0.3 * np.sin(k / 8)), stiffness=stiffness)


def mixed_exponents():
    exponents, masses = RANDOM.choice([1.5, 2.0, 1.3], 29), RANDOM.uniform(0.5, 2.0, 30)
    stiffness = RANDOM.uniform(0.5, 2.0, 29)
    return hc.Chain(np.ones(30), exponents, masses=masses, stiffness=stiffness)


def piston():
    balls = hc.Chain.from_materials(5e-3, "brass", beads=30)
    return balls.struck_by(mass=0.05, radius=np.inf, material="steel-304", velocity=1e-3)


CHAINS = {
    "two materials": hc.Chain.periodic(
        [9.5e-3] * 2, cells=20, materials=["steel-316", "ptfe"], velocity=1e-3
    ),
    "random materials": random_materials(),
    "dimer": hc.Chain.dimer(0.3, beads=60),
    "heavy striker": hc.Chain.uniform(40).struck_by(mass=4.0, radius=1.0, velocity=2.0),
    "light striker": hc.Chain.uniform(40).struck_by(mass=0.3, radius=1.0),
    "piston": piston(),
    "smooth masses": smooth_masses(),
    "mixed exponents": mixed_exponents(),
    "growing, in SI units": hc.Chain.from_materials(
        5e-3 * 1.03 ** np.arange(50), "brass", velocity=1e-3
    ),
    "dimer, p = 2.2": hc.Chain.dimer(0.5, beads=30, exponent=2.2),
}


def exact_pulse(chain):
    return hc.simulate(chain, times=0, rtol=1e-12).pulse()


@pytest.mark.parametrize("name", CHAINS)
def test_agreement_with_the_full_chain(name):
    pulse, exact = hc.propagate(CHAINS[name]), exact_pulse(CHAINS[name])
    assert pulse.chain is CHAINS[name]
    for column in ("velocity", "arrival", "peak_overlap", "peak_force"):
        assert pulse.compare(exact).worst(column, first_bead=1) < 1e-8
    # The velocity is flat at its maximum, but its time is that of a zero of the net force.
    assert pulse.compare(exact).worst("peak_time", first_bead=1) < 2e-9
    assert pulse.residence == pytest.approx(np.diff(pulse.arrival), rel=1e-8)


def test_against_scipy():
    """A chain of two materials in SI units, by another integrator and root finder."""
    chain = hc.Chain.periodic([9.5e-3] * 2, cells=6, materials=["steel-316", "ptfe"], velocity=1e-3)
    pulse = hc.propagate(chain)
    n = chain.beads
    # In units of 1 mm/s and 40 us, so that positions and velocities are of one size.
    unit, speed = 4e-5, 1e-3

    def derivative(_, y):
        force = (
            chain.stiffness * np.maximum(y[: n - 1] - y[1:n], 0.0) ** 1.5 * (unit * speed) ** 1.5
        )
        push = np.append(0.0, force) - np.append(force, 0.0)
        return np.concatenate((y[n:], push / chain.masses * unit / speed))

    start = np.append(np.zeros(n), chain.velocities / speed)
    end = 1.1 * pulse.peak_time.max() / unit
    sol = solve_ivp(
        derivative, (0.0, end), start, method="DOP853", rtol=1e-12, atol=1e-16, dense_output=True
    ).sol
    for k in range(1, n):
        middle, width = pulse.arrival[k] / unit, 0.02
        arrival = brentq(
            lambda t, k=k: sol(t)[n + k] - sol(t)[n + k - 1], middle - width, middle + width,
            xtol=1e-13,
        )  # fmt: skip
        assert pulse.arrival[k] == pytest.approx(arrival * unit, rel=1e-8)
        overlap = (sol(arrival)[k - 1] - sol(arrival)[k]) * unit * speed
        assert pulse.peak_overlap[k - 1] == pytest.approx(overlap, rel=1e-8)


def test_units_do_not_matter():
    """A chain in SI units and the same chain in scaled variables."""
    chain = CHAINS["growing, in SI units"]
    scales = hc.Scales.of(chain)
    scaled = scales.to_si(hc.propagate(scales.to_scaled(chain)))
    pulse = hc.propagate(chain)
    for name in COLUMNS:
        assert pulse.column(name) == pytest.approx(scaled.column(name), rel=1e-8)


def test_impact_velocity_scales_times_and_velocities():
    """v = 32: times shrink by v^(1/5) = 2, overlaps grow by v^(4/5) = 16."""
    slow = hc.Chain.dimer(0.3, beads=20)
    fast = slow.replace(velocities=32.0 * slow.velocities)
    one, other = hc.propagate(slow), hc.propagate(fast)
    assert other.velocity == pytest.approx(32.0 * one.velocity, rel=1e-8)
    assert other.arrival == pytest.approx(one.arrival / 2.0, rel=1e-8)
    assert other.peak_overlap == pytest.approx(16.0 * one.peak_overlap, rel=1e-8)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_ensemble_of_any_chains():
    """Rows of radii, chains of unlike features, and one that fails."""
    chains = [CHAINS["mixed exponents"], [1.0, 2.0, 1.0], CHAINS["dimer"],
              hc.Chain.uniform(9).replace(gravity=0.1)]  # fmt: skip
    table = hc.propagate_many(chains)
    assert list(table.reasons) == [3]
    assert table.units == "scaled"
    for row in (0, 2):
        alone = hc.propagate(chains[row])
        for name in (*COLUMNS, "peak_force", "momentum"):
            assert table[row].column(name) == pytest.approx(alone.column(name), rel=1e-12)
            columns = table.column(name)[row, : len(alone.column(name))]
            assert columns == pytest.approx(alone.column(name), rel=1e-12)
    assert table[1].chain.radii == pytest.approx([1.0, 2.0, 1.0])
    assert table.masses[1, :3] == pytest.approx([1.0, 8.0, 1.0])
    assert np.isnan(table.exponents[0])


@pytest.mark.parametrize(
    ("chain", "said"),
    [
        (hc.Chain.uniform(9).struck_by(count=2), "only bead 1 moves at time 0, but bead 2 has"),
        (hc.Chain.uniform(9).replace(velocities=np.zeros(9)), "first bead is struck, but this one"),
        (hc.Chain.uniform(9).struck_by(gap=0.1), "propagate does not support gaps; use simulate"),
    ],
)
def test_unsupported_starts(chain, said):
    with pytest.raises(hc.InputError, match=said):
        hc.propagate(chain)


@pytest.mark.parametrize("exponent", [1.2, 1.3, 1.7, 2.0, 2.5, 2.9])
@pytest.mark.parametrize("taper", ["backward-exponential", "forward-exponential"])
def test_exponents_agree_with_the_full_chain(exponent, taper):
    chain = hc.Chain.tapered(taper, 0.04, beads=60, exponent=exponent)
    pulse, exact = hc.propagate(chain), exact_pulse(chain)
    for name in COLUMNS:
        assert pulse.compare(exact).worst(name, first_bead=1) < 3e-8


def test_heavy_light_bead_that_turns_round_at_once():
    """Radii of which one bead moves backwards when the crest passes it."""
    for seed in (0, 9, 20):
        chain = hc.Chain.from_radii(np.random.default_rng(seed).uniform(0.5, 2.0, 100))
        pulse, exact = hc.propagate(chain, rtol=1e-9), exact_pulse(chain)
        assert pulse.compare(exact).worst("velocity", first_bead=1) < 1e-8


# Powers and long chains.


def test_powers_of_one_number_at_a_time():
    @numba.njit
    def powers(bases, exponent):
        return np.array([power(base, exponent) for base in bases])

    bases = 10.0 ** np.random.default_rng(5).uniform(-250, 60, 2000)
    for exponent in (1.05, 1.2, 1.5, 2.0, 3.0, 5.0):
        exact = bases.astype(np.longdouble) ** np.longdouble(exponent)
        within = (exact > 1e-300) & (exact < 1e300)
        error = np.abs(powers(bases, exponent)[within] / exact[within] - 1)
        # The series of the logarithm, and one rounding of the logarithm of the result.
        rounding = 2.0**-52 * np.abs(exponent * np.log2(bases))
        assert np.all(error < 4e-15 * (1.0 + exponent) + rounding[within])
    assert list(powers(np.array([0.0, -1.0, 1e-301]), 1.5)) == [0.0, 0.0, 0.0]
    assert np.isnan(powers(np.array([np.nan]), 1.5))[0]


LONG_CHAINS = {
    "uniform": hc.Chain.uniform(1500),
    "backward": hc.Chain.tapered("backward-exponential", 0.02, beads=1000),
    "forward": hc.Chain.tapered("forward-exponential", 0.01, beads=1000),
    "p = 2": hc.Chain.uniform(900, exponent=2.0),
    "SI": hc.Chain.from_materials(5e-3, "brass", beads=900, velocity=1e-3),
}


@pytest.mark.parametrize("name", LONG_CHAINS)
def test_long_chains_continue_as_geometric_series(name, monkeypatch):
    """The same columns as if every bead were integrated, up to the free end."""
    chain = LONG_CHAINS[name]
    series, finer = hc.propagate(chain), hc.propagate(chain, rtol=1e-10)
    monkeypatch.setattr(window_choice, "LONG", 10**9)
    whole, usual = hc.propagate(chain, rtol=1e-10), hc.propagate(chain)
    for column in (*COLUMNS, "residence"):
        assert finer.compare(whole).worst(column, first_bead=1) < 3e-10
        assert series.compare(whole).worst(column, first_bead=1) < 2e-10
    # More accurate than if every bead were integrated at the same tolerance.
    errors = [abs(each.compare(whole).worst("velocity")) for each in (series, usual)]
    assert errors[0] < errors[1]


def test_series_agree_with_simulation():
    for chain in (hc.Chain.uniform(620), hc.Chain.tapered("backward-exponential", 0.03, beads=620)):
        exact = hc.simulate(chain, times=0, rtol=1e-12).pulse()
        assert hc.propagate(chain).compare(exact).worst("velocity", first_bead=2) < 2e-9


def test_a_million_equal_beads():
    pulse = hc.propagate(hc.Chain.uniform(1_000_000))
    assert pulse.velocity[900_000] == pytest.approx(0.681631548571, rel=1e-10)
    assert pulse.velocity[-1] == pytest.approx(hc.propagate(hc.Chain.uniform(200)).velocity[-1])


def test_series_is_not_used_where_a_check_fails(monkeypatch):
    """A chain that is not exponential to rounding, and a pulse that does not repeat itself."""
    radii = 1.01 ** np.arange(700.0)
    radii[650] *= 1.0 + 1e-9
    exact, bent = Batch.of([hc.Chain.from_radii(1.01 ** np.arange(700.0))]), hc.Chain(radii)
    signal = np.zeros(2, np.int64)

    def head(batch):
        return window_choice.follow(batch, 1e-10, signal).columns

    assert geometric_series.continue_series(exact, 0, 1e-8, head) is not None
    assert geometric_series.continue_series(Batch.of([bent]), 0, 1e-8, head) is None
    monkeypatch.setattr(geometric_series, "REPEATING", 1e-18)
    assert geometric_series.continue_series(exact, 0, 1e-8, head) is None


def test_arrival_just_before_a_contact_opens():
    """A contact that is released early must not delay the arrival at the next bead."""
    for taper, rate in (("backward-linear", 0.35), ("backward-exponential", 0.1332608695652174)):
        chain = hc.Chain.tapered(taper, rate, beads=100)
        pulse, exact = hc.propagate(chain), exact_pulse(chain)
        for column in ("arrival", "residence"):
            assert pulse.compare(exact).worst(column, first_bead=1) < 3e-8
