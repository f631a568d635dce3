"""The disorder law against ensembles of simulated pulses."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc

BEADS, BEAD = 106, 100
TAPERS = {
    "uniform": np.ones(BEADS),
    "exponential": np.exp(0.04 * np.arange(BEADS)),
    "linear": 1 - 0.006 * np.arange(BEADS),
    "sine": np.exp(0.15 * np.sin(np.arange(BEADS) / 10)),
}


def logarithms(table, at=BEAD - 1):
    """Logarithms of velocity, arrival time and next force, in units of the nominal R_1 = 1."""
    force = np.log(table.stiffness[:, at]) + 1.5 * np.log(table.peak_overlap[:, at])
    return np.stack([np.log(table.velocity[:, at]), np.log(table.arrival[:, at]), force])


def simulated(radii, x, moduli=False):
    """Tables without and with deviations x of ln R or ln E, and the deviation of bead 1."""
    chain = hc.Chain.from_radii(radii)
    clean = hc.propagate_many([chain], threads=1)
    if not moduli:
        return clean, hc.propagate_many(radii * np.exp(x), rtol=1e-7, threads=1), x[:, 0]
    soft = np.exp(-x)
    factors = 2.0 / (soft[:, :-1] + soft[:, 1:])
    chains = [chain.replace(stiffness=chain.stiffness * each) for each in factors]
    return clean, hc.propagate_many(chains, rtol=1e-7, threads=1), 0.0 * x[:, 0]


def change(tables, at=BEAD - 1):
    """Change of the logarithms by the deviations, shape (3, lots)."""
    clean, table, first = tables
    size = first * np.array([[0.0], [1.0], [2.0]])
    return logarithms(table, at) + size - logarithms(clean, at)


def lots(scatter, count, seed):
    """Pairs of opposite, uncorrelated deviations: the first degree has exact means and spreads."""
    drawn = np.random.default_rng(seed).standard_normal((count // 2, BEADS))
    x = scatter * np.sqrt(len(drawn)) * np.linalg.qr(drawn)[0]
    return np.concatenate((x, -x))


def predicted(radii, at=BEAD - 1, **scatter):
    """Mean change of the logarithms, and standard deviations, by the law."""
    chain = hc.Chain.from_radii(radii)
    law, clean = hc.disorder(chain, **scatter), hc.local_rate(chain)
    force = np.log(law.peak_force[at] / clean.peak_force[at])
    mean = (
        np.log(law.velocity[at] / clean.velocity[at]),
        np.log(law.arrival[at] / clean.arrival[at]),
    )
    spread = law.velocity_spread[at], law.arrival_spread[at], law.peak_force_spread[at]
    return np.array([*mean, force]), np.array(spread)


def check(radii, scatter, count, *, mean_error, spread_error, seed=3):
    found = change(simulated(radii, lots(scatter, count, seed)))
    mean, spread = predicted(radii, scatter=scatter)
    np.testing.assert_allclose(found.mean(axis=1)[[0, 2]], mean[[0, 2]], rtol=mean_error)
    np.testing.assert_allclose(found.std(axis=1), spread, rtol=spread_error)
    return found


@pytest.mark.parametrize("taper", TAPERS)
def test_mean_and_spread_of_an_ensemble(taper):
    # The standard error of the mean of 600 chains is 1.2%.
    check(TAPERS[taper], 0.003, 600, mean_error=0.06, spread_error=0.01)


@pytest.mark.long
@pytest.mark.parametrize("scatter", [0.001, 0.003, 0.01])
@pytest.mark.parametrize("taper", TAPERS)
def test_mean_and_spread_of_ten_thousand_chains(taper, scatter):
    check(TAPERS[taper], scatter, 10_000, mean_error=0.05, spread_error=0.01)


def test_scatter_of_moduli():
    found = change(simulated(TAPERS["uniform"], lots(0.03, 600, 4), moduli=True))
    mean, spread = predicted(TAPERS["uniform"], modulus_scatter=0.03)
    np.testing.assert_allclose(found.std(axis=1), spread, rtol=0.02)
    # Fifty times less than scatter of radii; the ensemble has a standard error of 5%.
    assert found.mean(axis=1)[0] == pytest.approx(mean[0], rel=0.25)


def test_both_scatters_add():
    chain = hc.Chain.uniform(50)
    radii, moduli = hc.disorder(chain, 0.01), hc.disorder(chain, modulus_scatter=0.05)
    both, clean = hc.disorder(chain, 0.01, modulus_scatter=0.05), hc.local_rate(chain)
    np.testing.assert_allclose(
        both.velocity * clean.velocity, radii.velocity * moduli.velocity, rtol=1e-12
    )
    square = radii.velocity_spread**2 + moduli.velocity_spread**2
    np.testing.assert_allclose(both.velocity_spread**2, square, rtol=1e-12)


def test_early_beads_and_the_last_one():
    x = lots(0.01, 1000, 5)
    chain = hc.Chain.uniform(40)
    table = hc.propagate_many(np.exp(x[:, :40]), rtol=1e-7, threads=1)
    law = hc.disorder(chain, 0.01)
    found = np.log(table.velocity)
    for bead in (2, 3, 5, 9, 39, 40):
        spread = float(found[:, bead - 1].std())
        assert spread == pytest.approx(law.velocity_spread[bead - 1], rel=0.1)
        mean = float(np.exp(found[:, bead - 1].mean()))
        assert law.velocity[bead - 1] == pytest.approx(mean, abs=3e-4)
    assert law.velocity_spread[0] == law.arrival_spread[0] == 0.0


@pytest.mark.parametrize("moduli", [False, True])
@pytest.mark.parametrize("taper", TAPERS)
def test_arrival_times_and_forces_at_all_beads(taper, moduli):
    tables = simulated(TAPERS[taper], lots(0.001, 220, 6), moduli)
    option = "modulus_scatter" if moduli else "scatter"
    for at in (1, 2, 4, 9, 29, 49, BEADS - 2):
        found = change(tables, at)
        mean, spread = predicted(TAPERS[taper], at, **{option: 0.001})
        np.testing.assert_allclose(found[1:].std(axis=1), spread[1:], rtol=0.02)
        if at < 5:
            # The arithmetic mean would differ by up to the variance.
            assert found[1].mean() == pytest.approx(mean[1], abs=0.2 * spread[1] ** 2)


def test_the_spread_does_not_grow():
    spread = hc.disorder(hc.Chain.uniform(200), 0.002).velocity_spread
    np.testing.assert_allclose(spread[10:-2], spread[10], rtol=1e-9)


def test_si_units():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=30, velocity=0.2)
    real, scaled = hc.disorder(chain, 0.005), hc.disorder(hc.Chain.uniform(30), 0.005)
    scales = hc.Scales.of(chain)
    np.testing.assert_allclose(real.velocity, 0.2 * scaled.velocity, rtol=1e-12)
    np.testing.assert_allclose(real.arrival, scales.time * scaled.arrival, rtol=1e-12)
    np.testing.assert_array_equal(real.velocity_spread, scaled.velocity_spread)
    dataset = real.to_xarray()
    assert "units" not in dataset.velocity_spread.attrs
    assert dataset.peak_force_spread.dims == ("contact",)


@pytest.mark.parametrize(("chain", "options", "message"), [
    (hc.Chain.uniform(20), {}, "scatter or modulus_scatter above 0"),
    (hc.Chain.uniform(20), {"scatter": 0.04},
     "at most 0.03, got 0.04; for more, use propagate_many with Chain.with_scatter"),
    (hc.Chain.uniform(20), {"scatter": "5%"}, "must be at least 0% and at most 3%, got '5%'"),
    (hc.Chain.uniform(20), {"scatter": -0.01}, "at least 0"),
    (hc.Chain.uniform(20), {"modulus_scatter": 0.2}, "at most 0.1"),
    (hc.Chain.uniform(8), {"scatter": 0.01}, "at least 10 beads"),
    (hc.Chain.uniform(20, exponent=2.0), {"scatter": 0.01}, "exponent 1.5"),
    (hc.Chain.tapered("backward-exponential", 0.2, beads=20), {"scatter": 0.01}, "contact 1"),
    (hc.Chain.uniform(20).replace(precompression=1.0, held_by="force"), {"scatter": 0.01},
     "does not support precompression; use distribution"),
])  # fmt: skip
def test_other_arguments_are_rejected(chain, options, message):
    with pytest.raises(hc.InputError, match=message):
        hc.disorder(chain, **options)


def test_warnings_about_the_nominal_chain_name_the_disorder_law():
    chain = hc.Chain.from_radii(np.resize([1.0, 1.09], 60))
    with pytest.warns(hc.ModelRangeWarning) as raised:
        hc.disorder(chain, 0.01)
    for each in raised:
        text = str(each.message)
        assert text.startswith("the disorder law may be inaccurate for this chain (")
        assert text.endswith("; use propagate_many with Chain.with_scatter")
    assert len(raised) == 2
    assert "the estimated velocity error" in str(raised[0].message)


def test_random_chains_have_the_spread_of_the_law():
    """All beads deviate, in scaled chains, too; bead 1 adds 2.55 of the variance."""
    real = hc.Chain.from_materials(5e-3, "steel-316", beads=30, velocity=1e-3)
    scaled = hc.Chain.uniform(30)
    for chain in (scaled, real):
        law = hc.disorder(chain, 0.01).velocity_spread[20] / 0.01
        for beads, expected in ((None, law), ("2:", np.sqrt(law**2 - 2.55))):
            samples = hc.Scatter(radius=0.01, samples=1000, beads=beads).sample(chain)
            spread = np.log(hc.propagate_many(samples).velocity[:, 20]).std() / 0.01
            assert spread == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("quantity", ["velocity", "arrival", "peak_force"])
def test_plots_show_the_spread_as_a_band(quantity):
    pulse = hc.disorder(hc.Chain.uniform(40), scatter=0.02)
    values, spread = pulse.columns()[quantity], pulse.columns()[f"{quantity}_spread"]
    axes = pulse.plot(quantity)
    handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    swatch = handles["± one standard deviation"].get_facecolor()
    np.testing.assert_array_equal(swatch, axes.collections[0].get_facecolor())
    (corners,) = (path.vertices for path in axes.collections[0].get_paths())
    # The last bead leaves the free end: its band is a bar of its own.
    joined = len(values) - (quantity == "velocity")
    for k in range(joined):
        band = corners[corners[:, 0] == k + 1, 1]
        expected = values[k] * np.exp([-spread[k], spread[k]])
        np.testing.assert_allclose([band.min(), band.max()], expected, rtol=1e-14)
    if quantity == "velocity":
        ((low, high),) = axes.collections[1].get_segments()
        np.testing.assert_allclose(
            [low[1], high[1]], values[-1] * np.exp([-spread[-1], spread[-1]])
        )
        assert low[0] == high[0] == 40


def test_tables_of_pulses_are_plotted_with_a_band():
    chain = hc.Chain.uniform(20)
    chains = [chain.with_scatter(seed, relative=0.03) for seed in range(40)]
    table = hc.propagate_many([*chains, hc.Chain.uniform(30)], threads=1)
    axes = table.plot("arrival")
    (line,) = axes.lines
    expected = np.nanmedian(table.arrival, axis=0)
    np.testing.assert_allclose(line.get_ydata(), expected)
    (corners,) = (path.vertices for path in axes.collections[0].get_paths())
    band = corners[corners[:, 0] == 15, 1]
    low, high = np.percentile(table.arrival[:, 14], (5, 95))
    assert (band.min(), band.max()) == pytest.approx((low, high), rel=1e-12)
    assert axes.get_title() == "41 chains of up to 30 beads"
    assert table.plot("peak_force").get_xlabel() == "contact $k$"
    with pytest.raises(hc.InputError, match="quantity"):
        table.plot("speed of light")


def test_plots_have_no_band_where_the_spread_is_not_known():
    pulse = hc.disorder(hc.Chain.uniform(40), scatter=0.02)
    assert not pulse.plot("momentum").collections
    assert not hc.local_rate(pulse.chain).plot("velocity").collections
    axes = hc.plot_pulses([pulse], legend=False)
    assert axes.get_legend() is None


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(("rates", "scatter"), [
    (np.diff(np.log(1 + 0.1 * np.arange(60))), 0.03),
    (np.diff(np.log(1 + 0.1 * np.arange(60))), 0.01),
    (np.linspace(0.1, -0.1, 59), 0.01),
    (0.1 * np.sin(2 * np.pi * np.arange(59) / 60), 0.01),
    (np.full(59, -0.1), 0.003),
])  # fmt: skip
def test_the_estimated_error_covers_the_deviations_from_ensembles(rates, scatter):
    radii = np.exp(np.append(0.0, np.cumsum(rates)))
    x = lots(scatter, 600, 7)[:, : len(radii)]
    found = np.log(hc.propagate_many(radii * np.exp(x), rtol=1e-7, threads=1).velocity)
    law = hc.disorder(hc.Chain.from_radii(radii), scatter)
    pairs = found.reshape(2, -1, len(radii)).mean(axis=0)
    uncertain = 2.0 * pairs.std(axis=0) / np.sqrt(len(pairs))
    deviations = np.abs(np.log(law.velocity) - found.mean(axis=0))
    assert (deviations <= law.velocity_error + uncertain).all()
    # The estimate has a purpose: it is not much larger than the largest deviation.
    k = np.argmax(deviations)
    assert law.velocity_error[k] < 5.0 * (deviations[k] + uncertain[k])
    clean = hc.local_rate(hc.Chain.from_radii(radii)).velocity_error
    if rates[0] > 0.09:
        assert (deviations - uncertain > clean).any()


def test_warnings_of_inaccurate_means():
    taper = hc.Chain.tapered("backward-linear", 0.1, beads=110)
    with pytest.warns(hc.ModelRangeWarning, match=r"exceeds 0\.5% from bead \d+ on and is 0\.78%"):
        hc.disorder(taper, 0.03)
    dimer = hc.Chain.dimer(radii=[1.0, 0.98], beads=30)
    with pytest.warns(hc.ModelRangeWarning, match=r"at bead 2, .* changes by 0\.04"):
        hc.disorder(dimer, 0.01)
    # There is one warning where the law for the nominal chain has one.
    with pytest.warns(hc.ModelRangeWarning) as caught:
        hc.disorder(
            hc.Chain.from_radii(np.exp(np.cumsum(0.1 * np.sin(np.arange(110) / 9.6)))), 0.03
        )
    assert len(caught) == 1
    assert "the estimated velocity error" in str(caught[0].message)


def test_rates_at_the_limits_are_accepted_despite_rounding():
    for rate in (-0.1, 0.1):
        chain = hc.Chain.from_radii(np.exp(rate * np.arange(40)))
        assert hc.disorder(chain, 0.01).velocity_spread[20] > 0.01


@pytest.mark.parametrize("theory", [hc.propagate, lambda chain: hc.disorder(chain, 0.01)])
def test_beads_beyond_given_limits_are_named(theory):
    chain = hc.Chain.tapered("forward-exponential", 0.02, beads=60)
    pulse = theory(chain)
    _, axes = plt.subplots()
    axes.set_ylim(0.78, 1.4)
    hc.plot_pulses([pulse], ax=axes)
    assert axes.get_ylim() == (0.78, 1.4)
    v = pulse.velocity
    low, high = np.flatnonzero(v < 0.78) + 1, np.flatnonzero(v > 1.4) + 1
    assert low.size > 1
    assert {text.get_text() for text in axes.texts} == {
        f"beads {low[0]} to {low[-1]}: down to {v[low - 1].min():.3g} ↓",
        f"beads {high[0]} to 60: up to {v[-1]:.3g} ↑",
    }
    # Further pulses are named, too, and the limits stay.
    hc.plot_pulses([hc.bca(chain)], ax=axes)
    assert axes.get_ylim() == (0.78, 1.4)
    assert any(f"up to {hc.bca(chain).velocity[-1]:.3g} ↑" in t.get_text() for t in axes.texts)
    plt.close(axes.figure)


def test_names_of_beads_beyond_the_limits_follow_later_limits():
    law = hc.disorder(hc.Chain.uniform(100), 0.005)
    axes = law.plot()
    assert len(axes.texts) == 2
    axes.plot([1, 100], [0.6, 0.7])
    axes.figure.canvas.draw()
    assert axes.get_ylim()[1] > 1.0
    assert not axes.texts
    axes.set_ylim(0.5, 0.99)
    assert [text.get_text() for text in axes.texts] == ["bead 1: 1 ↑"]
    table = hc.propagate_many([hc.Chain.uniform(100).with_scatter(1, relative=0.005)])
    axes = law.plot()
    table.plot("velocity", ax=axes)
    axes.figure.canvas.draw()
    assert axes.get_ylim()[1] > 1.0
    assert not axes.texts
    plt.close(axes.figure)


def test_the_band_of_the_spread_is_visible():
    law = hc.disorder(hc.Chain.uniform(100), 0.005)
    axes = law.plot()
    low, high = axes.get_ylim()
    inner = law.velocity[1:-1]
    assert low < inner.min() < inner.max() < high < min(law.velocity[0], law.velocity[-1])
    # Beads 1 and N would leave the band less than 4% of the height.
    band = 2.0 * law.velocity_spread[50] * law.velocity[50]
    assert band / np.ptp(law.velocity) < 0.04 < 0.1 < band / (high - low)
    texts = [text.get_text() for text in axes.texts]
    assert texts == ["bead 1: 1 ↑", f"bead 100: {law.velocity[-1]:.3g} ↑"]
    assert "last bead (free end)" not in axes.get_legend_handles_labels()[1]
    # Further curves are not cut off, and the values are in the axes then.
    hc.bca(hc.Chain.uniform(100)).plot(ax=axes)
    assert axes.get_ylim()[1] > 1.0
    assert not axes.texts
    assert "last bead (free end)" in axes.get_legend_handles_labels()[1]
    assert hc.bca(hc.Chain.uniform(100)).plot().get_ylim()[1] >= 1.0
    # Limits that would hardly help remain, and so do those of a logarithmic axis.
    growing = hc.disorder(hc.Chain.tapered("forward-exponential", 0.03, beads=60), 0.005)
    assert growing.plot().get_ylim()[1] > growing.velocity[-1]
    assert law.plot(log=True).get_ylim()[1] > 1.0
    forces = law.plot("peak_force")
    assert f"contact 99: {law.peak_force[-1]:.3g} ↓" in [each.get_text() for each in forces.texts]


def test_a_single_pulse_has_a_panel_of_its_spread():
    chain = hc.Chain.tapered("forward-exponential", 0.03, beads=25)
    pulse = hc.disorder(chain, 0.01)
    axes = hc.plot_pulses([pulse], "velocity", residuals=True)
    below = axes.figure.axes[1]
    assert below.get_ylabel() == "spread [%]"
    (band,) = [each for each in below.collections if len(each.get_paths()[0].vertices) > 10]
    # The band is that of one standard deviation of the logarithm.
    spread = 100.0 * np.expm1(pulse.column("velocity_spread")[:-1].max())
    assert band.get_paths()[0].vertices[:, 1].max() == pytest.approx(spread, rel=1e-6)
    with pytest.raises(hc.InputError, match="residuals need at least two pulses"):
        hc.plot_pulses([hc.propagate(chain)], "velocity", residuals=True)
