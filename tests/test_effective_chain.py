import re
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hertzchain as hc
from hertzchain.theory.decoration import small_beads


def decorated(large, ratio, small=1):
    return hc.Chain.from_radii(large).decorated(ratio, between=small)


def measured(chain, effective, first, last):
    """Mean time between the maxima of large beads, and their velocities."""
    pulse, index = hc.propagate(chain), effective.large_beads - 1
    time = pulse.peak_time[index]
    return (time[last] - time[first]) / (last - first), pulse.velocity[index]


@pytest.mark.parametrize(
    ("ratio", "small", "off"),
    [
        (0.2, 1, 5e-5), (0.3, 1, 2e-4), (0.4, 1, 9e-4), (0.5, 1, 1e-3), (0.3, 2, 5e-4),
        (0.396, 2, 1.2e-3), (0.292, 5, 2.0e-3),
    ],
)  # fmt: skip
def test_pulse_spacing_against_the_integration(ratio, small, off):
    chain = decorated(np.ones(30), ratio, small)
    effective = hc.effective_chain(chain)
    spacing, velocity = measured(chain, effective, 12, 24)
    error = effective.spacing(velocity)[12:24].mean() / spacing - 1.0
    assert abs(error) < 1.1 * off
    assert abs(error) > off / 10


def test_where_the_small_beads_are_not_light():
    chain = decorated(np.ones(42), 0.7)
    with pytest.warns(hc.ModelRangeWarning, match=r"beads 1 and 3 have 0.343 .* only up to 0.125"):
        effective = hc.effective_chain(chain)
    spacing, velocity = measured(chain, effective, 15, 35)
    assert effective.spacing(velocity[25])[25] / spacing > 1.02


@pytest.mark.parametrize("exponent", [1.25, 1.75, 2.0, 2.5, 3.0])
def test_the_range_of_small_beads_depends_on_the_exponent(exponent):
    ratio = 0.5 * min(1.0, 1.5 / exponent)
    for part in (0.6, 0.8, 1.0):
        chain = hc.Chain.uniform(45, exponent=exponent).decorated(part * ratio)
        pulse = hc.propagate(chain)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            spacing = hc.effective_chain(chain).spacing(pulse.velocity[::2])
        time = pulse.peak_time[::2]
        assert spacing[18:38].sum() == pytest.approx(time[38] - time[18], rel=4e-3)
    with pytest.warns(hc.ModelRangeWarning, match="the effective chain is accurate to"):
        hc.effective_chain(hc.Chain.uniform(45, exponent=exponent).decorated(1.05 * ratio))


def test_light_beads_are_those_of_little_mass():

    def alternating(large, small):
        radii, materials = zip(large, small, large, strict=True)
        return hc.Chain.from_materials(radii, materials, velocity=0.1)

    light, heavy = (hc.material(name).density for name in ("ptfe", "tungsten-carbide"))
    share = heavy / light * (2.2 / 5.0) ** 3
    assert share > 0.5
    with pytest.warns(hc.ModelRangeWarning, match=f"beads 1 and 3 have {share:.3g} times the mass"):
        hc.effective_chain(alternating((5e-3, "ptfe"), (2.2e-3, "tungsten-carbide")))
    # Radii in a ratio of 0.6 alone would be too large.
    hc.effective_chain(alternating((5e-3, "tungsten-carbide"), (3e-3, "ptfe")))


def test_bca_of_decorated_chains_is_that_of_plain_ones():
    chain = decorated(np.ones(42), 0.4)
    effective = hc.effective_chain(chain)
    spacing, velocity = measured(chain, effective, 15, 35)
    pulse = effective.bca()
    assert np.diff(pulse.arrival)[25] / spacing == pytest.approx(1.025, abs=0.01)
    assert pulse.velocity[25] / velocity[25] == pytest.approx(1.46, abs=0.01)
    assert pulse.bead[:3].tolist() == [1, 3, 5]


def test_without_small_beads_it_is_the_bca():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=12)
    ours, plain = hc.effective_chain(chain, range(1, 13)).bca(), hc.bca(chain)
    np.testing.assert_allclose(ours.velocity, plain.velocity, rtol=1e-15)
    np.testing.assert_allclose(ours.arrival, plain.arrival, rtol=1e-12)
    np.testing.assert_allclose(ours.peak_force, plain.peak_force, rtol=1e-12)


@pytest.mark.parametrize("exponent", [1.5, 2.5])
def test_contacts_in_series_by_balance_of_forces(exponent):
    """Push two large beads together by one, and find the overlaps contact after contact."""
    chain = hc.Chain.from_radii([1.0, 0.2, 0.15, 0.18, 1.2], exponent=exponent)
    effective = hc.effective_chain(chain, [1, 5])

    def overlaps(force):
        return (force / chain.stiffness) ** (1.0 / exponent)

    force = brentq(lambda f: overlaps(f).sum() - 1.0, 1e-6, 10.0, xtol=1e-15, rtol=1e-14)
    assert effective.stiffness[0] == pytest.approx(force, rel=1e-12)
    # Displacements of the small beads if the left large one moves by one, the right by none.
    follow = 1.0 - np.cumsum(overlaps(force))[:-1]
    first = 1.0 + np.sum(follow * chain.masses[1:-1])
    assert effective.masses[0] == pytest.approx(first, rel=1e-12)
    assert effective.masses.sum() == pytest.approx(chain.masses.sum(), rel=1e-14)


def test_effective_chain_of_tapered_large_beads_moves_as_the_full_one():
    chain = decorated(0.98 ** np.arange(24), 0.3)
    effective = hc.effective_chain(chain)
    spacing, velocity = measured(chain, effective, 8, 18)
    # The speed is that of the wave in a uniform chain, without the effect of the taper.
    with pytest.warns(hc.ModelRangeWarning, match="error of 2.0%"):
        found = effective.spacing(velocity)[8:18].mean()
    assert found / spacing == pytest.approx(1.02, abs=1e-3)
    m, k, n = effective.masses, effective.stiffness, 24

    def rates(_, y):
        force = k * np.maximum(-np.diff(y[:n]), 0.0) ** 1.5
        return np.concatenate([y[n:], -np.diff(force, prepend=0.0, append=0.0) / m])

    start = np.zeros(2 * n)
    start[n] = 1.0
    run = solve_ivp(
        rates, (0.0, 45.0), start, method="DOP853", rtol=1e-9, atol=1e-12, dense_output=True
    )
    times = np.linspace(10.0, 45.0, 20_001)
    moving = run.sol(times)[n:]
    peaks = times[np.argmax(moving, axis=1)]
    assert (peaks[18] - peaks[8]) / 10 == pytest.approx(spacing, rel=1.5e-3)
    np.testing.assert_allclose(moving[8:19].max(axis=1), velocity[8:19], rtol=8e-3)


def test_small_beads_are_found():
    found = small_beads(np.array([1.0, 0.5, 0.2, 0.5, 1.0, 1.0, 0.3, 0.9]))
    assert np.flatnonzero(found).tolist() == [1, 2, 3, 6]
    tapered = decorated(0.85 ** np.arange(20), 0.3, 2)
    assert hc.effective_chain(tapered, range(1, 59, 3)).masses.tolist() == (
        hc.effective_chain(tapered).masses.tolist()
    )
    later = np.concatenate([0.5 ** np.arange(5), [0.01, 0.05]])
    assert np.flatnonzero(small_beads(later)).tolist() == [5]
    k = np.arange(60)
    for radii in (0.6**k, 1.3**k, 1 + 0.4 * np.sin(k / 5), 1 - 0.5 * np.exp(-((k - 30) ** 2) / 60)):
        assert not small_beads(radii).any()


def test_theories_of_single_collisions_warn_of_decorated_chains():
    chain = decorated(np.ones(5), 0.3)
    for theory in (hc.bca, hc.hard_sphere):
        with pytest.warns(hc.ModelRangeWarning, match="bead 2 is small.*effective_chain"):
            theory(chain)


CHAIN = hc.Chain.uniform(3).decorated(0.3)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.effective_chain(hc.Chain.uniform(9)), "uniform, 9 beads has no radii"),
        (lambda: hc.effective_chain(CHAIN, [1, 3]), r"that include 1 and 5 .* got \[1, 3\]"),
        (lambda: hc.effective_chain(CHAIN, [1, 3, 3, 5]), "ascending bead numbers"),
        (lambda: hc.effective_chain(CHAIN, [1.0, 3.5, 5.0]), "large bead must be a whole number"),
        (lambda: hc.effective_chain(CHAIN, [1, 5]), "bead 3 is between .* has 1 times the radius"),
        (lambda: hc.effective_chain(CHAIN).spacing([1.0, 0.7]), "each of the 3 large beads"),
        (lambda: hc.effective_chain(CHAIN).spacing(0.0), "positive"),
    ],
)
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


@pytest.mark.parametrize(
    ("taper", "q", "error"),
    [("forward-exponential", 0.05, 0.055), ("backward-exponential", 0.05, -0.038),
     ("forward-exponential", 0.01, 0.0094), ("backward-exponential", 0.01, -0.0084)],
)  # fmt: skip
def test_the_spacing_of_steep_tapers_warns_of_its_error(taper, q, error):
    chain = hc.Chain.tapered(taper, q, beads=31).decorated(0.3)
    pulse = hc.propagate(chain)
    effective = hc.effective_chain(chain)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        spacing = effective.spacing(pulse.velocity[::2])
    found = spacing[20] / np.diff(pulse.peak_time[::2])[20] - 1.0
    assert found == pytest.approx(error, abs=1e-3)
    assert bool(caught) == (q > 0.02)
    for each in caught:
        assert issubclass(each.category, hc.ModelRangeWarning)
        told = float(re.search(r"error of ([\d.]+)%", str(each.message)).group(1)) / 100.0
        assert told == pytest.approx(abs(found), rel=0.2)


def test_methods_of_chains_advise_those_of_an_effective_chain():
    with pytest.raises(hc.InputError, match=r"got EffectiveChain\(.*bca\(\) and spacing"):
        hc.propagate(hc.effective_chain(CHAIN))


@pytest.mark.parametrize("units", ["scaled", "SI"])
def test_pulses_of_effective_chains_compare_and_plot_like_others(units):
    chain = hc.Chain.uniform(41)
    if units == "SI":
        chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=41, velocity="0.1 m/s")
    chain = chain.decorated(0.3)
    found, exact = hc.effective_chain(chain).bca(), hc.propagate(chain)
    pulse = found.pulse()
    large = found.bead - 1
    np.testing.assert_array_equal(pulse.velocity[large], found.velocity)
    assert np.isnan(np.delete(pulse.velocity, large)).all()
    # The force is the same in both contacts of a small bead.
    np.testing.assert_allclose(pulse.peak_force[::2], found.peak_force, rtol=1e-12)
    np.testing.assert_allclose(pulse.peak_force[1::2], found.peak_force, rtol=1e-12)
    assert "velocities are too large by 39% to 67%" in str(pulse)
    comparison = pulse.compare(exact)
    assert 0.4 < comparison.worst("velocity", first_bead=20) < 0.5
    assert comparison.worst("arrival", first_bead=20) < 0.03
    assert exact.compare(found).reference.method == "effective chain"
    axes = hc.plot_pulses([exact, found], "arrival")
    line = next(each for each in axes.lines if each.get_label() == "effective chain")
    # A line joins the large beads.
    np.testing.assert_array_equal(line.get_xdata(), found.bead)
    np.testing.assert_array_equal(line.get_ydata(), found.arrival)


def test_times_and_velocities_have_the_errors_that_are_stated():
    times, velocities = [], []
    for kind in ("forward-exponential", "backward-exponential"):
        chain = hc.Chain.tapered(kind, 0.05, beads=31).decorated(0.3)
        found, exact = hc.effective_chain(chain).bca(), hc.propagate(chain)
        i = found.bead - 1
        times.append(np.ptp(found.arrival[8:-3]) / np.ptp(exact.peak_time[i][8:-3]) - 1.0)
        velocities += (found.velocity / exact.velocity[i] - 1.0)[3:-2].tolist()
    assert 0.06 < max(np.abs(times)) < 0.07
    assert 0.385 < min(velocities) < max(velocities) < 0.675


def test_an_effective_chain_without_its_chain_has_no_pulse():
    found = hc.effective_chain(CHAIN)
    bare = hc.EffectiveChain(found.masses, found.stiffness, found.exponent, found.large_beads)
    with pytest.raises(hc.InputError, match="no chain with small beads"):
        bare.bca().pulse()
