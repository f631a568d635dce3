"""The local-rate law with loss, against simulations of chains that its tables do not contain."""

import warnings

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.theory import lossy_law
from hertzchain.theory.lossy_law import tail

K = np.arange(100)
TAPERS = {
    "uniform": np.ones(100),
    "exponential": np.exp(0.05 * K),
    "backward-linear": 1 + 0.05 * K,
    "forward-linear": 1 - 0.006 * K,
    "power": (1 + K / 40) ** 1.2,
    "hump": np.exp(0.4 * np.exp(-(((K - 50) / 25) ** 2))),
}
LAWS = {
    "restitution": hc.Restitution(0.95),
    "strong restitution": hc.Restitution(0.91),
    "without pull": hc.Restitution(0.95, attractive=False),
    "unloading ratio": hc.UnloadingRatio(0.05),
    "viscoelastic": hc.Viscoelastic(0.01),
    "viscoelastic with pull": hc.Viscoelastic(0.01, attractive=True),
}


def simulated(chain):
    return hc.simulate(chain, times=0, rtol=1e-9, check=False).pulse()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("taper", TAPERS)
def test_every_column_agrees_with_the_simulation(taper, law):
    chain = hc.Chain.from_radii(TAPERS[taper]).replace(loss=LAWS[law])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pulse = hc.local_rate(chain)
    compared = pulse.compare(simulated(chain))
    for name in ("velocity", "momentum", "energy", "arrival", "residence", "peak_overlap",
                 "peak_force"):  # fmt: skip
        limit = 0.01 if name == "energy" else 0.005
        assert np.abs(compared.errors(name)).max() < limit, name


@pytest.mark.parametrize("make", [lambda: hc.Restitution(0.985), lambda: hc.UnloadingRatio(0.02),
                                  lambda: hc.Viscoelastic(0.003)])  # fmt: skip
def test_weak_losses(make):
    for radii in TAPERS.values():
        chain = hc.Chain.from_radii(radii).replace(loss=make())
        compared = hc.local_rate(chain).compare(simulated(chain))
        assert np.abs(compared.errors("velocity")).max() < 1e-3


def test_equal_beads_decay_as_by_the_closed_form():
    """For a small loss, by another method: integrals over the lossless wave."""
    plain = hc.local_rate(hc.Chain.uniform(90)).velocity
    for law in (hc.Restitution(0.9995), hc.UnloadingRatio(5e-4), hc.Viscoelastic(5e-4)):
        chain = hc.Chain.uniform(90).replace(loss=law)
        velocity = hc.local_rate(chain).velocity
        ratio = np.log(velocity / plain)
        decay = -(ratio[80] - ratio[50]) / 30
        assert decay == pytest.approx(float(hc.attenuation(chain, velocity[65])), rel=4e-3)


def test_the_estimate_covers_the_error():
    random = np.random.default_rng(77)
    errors, estimates = [], []
    for index in range(24):
        bend = np.cumsum(random.normal(size=100)) * 0.004
        rates = 0.01 * random.normal() + np.convolve(bend, np.ones(21) / 21, "same")
        if rates.min() < -0.08 or rates.max() > 0.1:
            continue
        law = (hc.Restitution(0.93), hc.UnloadingRatio(0.07), hc.Viscoelastic(0.02))[index % 3]
        chain = hc.Chain.from_radii(np.exp(np.cumsum(rates))).replace(loss=law)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                pulse = hc.local_rate(chain)
            except hc.InputError:
                continue
        errors.append(np.abs(pulse.compare(simulated(chain)).errors("velocity"))[1:])
        estimates.append(pulse.velocity_error[1:])
    error, estimate = np.concatenate(errors), np.concatenate(estimates)
    assert error.size > 1000
    assert np.mean(error <= estimate) > 0.95


def test_weak_viscoelastic_losses_add_up():
    """The effect of a weak loss is the sum of those of losses at single contacts."""
    chain = hc.Chain.tapered("backward-linear", 0.05, beads=40)
    time = 2e-4

    def log_velocity(times):
        loss = [hc.Viscoelastic(float(each)) for each in times]
        pulse = hc.simulate(chain.replace(loss=loss), times=0, rtol=1e-12, check=False).pulse()
        return np.log(pulse.velocity)

    plain = log_velocity(np.zeros(39))
    summed = sum(log_velocity(row) - plain for row in time * np.eye(39))
    law = np.log(hc.local_rate(chain.replace(loss=hc.Viscoelastic(time))).velocity)
    found = law - np.log(hc.local_rate(chain).velocity)
    np.testing.assert_allclose(found[1:], summed[1:], rtol=5e-3)


def test_a_viscoelastic_loss_becomes_stronger_in_smaller_beads():
    """Its strength exceeds the limit near the end of a forward taper."""
    radii = 1 - 0.008 * K
    loss = hc.Viscoelastic(0.02)
    with pytest.raises(hc.InputError, match=r"at bead 8\d .*or fewer beads") as raised:
        hc.local_rate(hc.Chain.from_radii(radii).replace(loss=loss))
    bead = int(str(raised.value).split("at bead ")[1].split()[0])
    part = hc.Chain.from_radii(radii[: bead - 1]).replace(loss=loss)
    compared = hc.local_rate(part).compare(simulated(part))
    assert np.abs(compared.errors("velocity")).max() < 0.01
    # One bead more is too many, also by the simulated velocity.
    scale = (hc.Chain.from_radii(radii).stiffness / radii[:-1] ** 3) ** 0.4
    velocity = simulated(hc.Chain.from_radii(radii).replace(loss=loss)).velocity
    assert 0.02 * (scale * velocity[:-1] ** 0.2)[bead - 1] == pytest.approx(0.06, rel=0.03)


def test_a_tail_that_overtakes_is_announced(monkeypatch):
    """The pulse grows in small beads, then decays faster than the tail behind it."""
    rates = np.where(K[1:] < 55, -0.05, 0.04)
    rates = np.convolve(np.pad(rates, 10, mode="edge"), np.ones(21) / 21, "valid")
    radii = np.exp(np.concatenate(([0.0], np.cumsum(rates))))
    chain = hc.Chain.from_radii(radii).replace(loss=hc.Restitution(0.9))
    with pytest.raises(hc.InputError, match="tail behind the pulse overtakes it near bead 7"):
        hc.local_rate(chain)
    part = hc.Chain.from_radii(radii[:70]).replace(loss=hc.Restitution(0.9))
    with pytest.warns(hc.ModelRangeWarning, match="estimated velocity error above 1% from bead"):
        pulse = hc.local_rate(part)
    errors = np.abs(pulse.compare(simulated(part)).errors("velocity"))
    assert errors.max() < 0.03
    assert (errors[1:] < pulse.velocity_error[1:]).all()
    # Without the check, the result would be wrong.
    monkeypatch.setattr(lossy_law, "OVERTAKEN", np.inf)
    with pytest.warns(hc.ModelRangeWarning):
        beyond = hc.local_rate(chain)
    assert np.abs(beyond.compare(simulated(chain)).errors("velocity")).max() > 0.1


def test_a_tail_grows_by_the_momentum_that_the_pulse_loses():
    """On equal beads, each bead keeps 1.67 times the velocity that the pulse loses."""
    decay = 0.02 * np.arange(61)
    relative, _ = tail(np.zeros(60), -decay)
    assert relative[6] == pytest.approx(1.67 * 0.02)
    assert relative[40] / relative[10] == pytest.approx(np.exp(0.6))


def test_no_loss_changes_nothing():
    chain = hc.Chain.tapered("backward-linear", 0.05, beads=40)
    plain = hc.local_rate(chain)
    for law in (hc.Restitution(1.0), hc.UnloadingRatio(0.0), hc.Viscoelastic(0.0)):
        pulse = hc.local_rate(chain.replace(loss=law))
        for name in ("velocity", "arrival", "peak_force", "velocity_error"):
            np.testing.assert_allclose(pulse.column(name), plain.column(name), rtol=1e-14)


@pytest.mark.parametrize("loss", [hc.Restitution(0.97), hc.Viscoelastic(5e-7)])
def test_units(loss):
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=60, velocity=0.1)
    balls = balls.replace(loss=loss)
    compared = hc.local_rate(balls).compare(hc.simulate(balls, times=0).pulse())
    assert np.abs(compared.errors("velocity")).max() < 1e-3


@pytest.mark.parametrize(
    ("loss", "message"),
    [
        (hc.Restitution(0.8), r"restitution coefficient of at least 0\.9, got 0\.8"),
        (hc.UnloadingRatio(0.2), r"unloading ratio of at most 0\.1, got 0\.2"),
        (hc.Viscoelastic(0.07), r"of at most 0\.06, but this is 0\.07 at bead 1 .*use simulate"),
        (hc.Viscoelastic(1e300), r"of at most 0\.06, but this is 1e\+300 at bead 1 "),
        (hc.Dashpot(0.01), r"no tables for Dashpot.*use simulate"),
        (hc.WaltonBraun(0.9), r"no tables for WaltonBraun.*use simulate"),
    ],
)
def test_other_losses_are_refused(loss, message):
    with pytest.raises(hc.InputError, match=message):
        hc.local_rate(hc.Chain.uniform(40).replace(loss=loss))


def test_scatter_hardly_changes_the_effect_of_a_loss():
    for seed in range(3):
        chain = hc.Chain.uniform(100).with_scatter(seed, relative=0.003)
        lossy = chain.replace(loss=hc.Restitution(0.97))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pulse = hc.local_rate(lossy)
        error = np.abs(pulse.compare(simulated(lossy)).errors("velocity"))
        assert error.max() < 5e-3
        assert np.mean(error <= pulse.velocity_error) > 0.9


# Without the term of short chains, errors are up to eight times the estimate.
@pytest.mark.parametrize("beads", [9, 12, 18])
@pytest.mark.parametrize("rate", [-0.06, 0.0, 0.03])
@pytest.mark.parametrize("loss", [hc.Restitution(0.95), hc.Restitution(0.91)])
def test_the_estimate_includes_the_overlap_of_impact_and_free_end(beads, rate, loss):
    chain = hc.Chain.from_radii(np.exp(rate * np.arange(beads))).replace(loss=loss)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        law = hc.local_rate(chain)
    error = np.abs(law.compare(simulated(chain)).errors("velocity"))[-1]
    assert error < law.velocity_error[-1] < 0.03


def test_messages_do_not_state_a_time_in_other_units():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=500, velocity=0.1)
    with pytest.raises(hc.InputError, match="with Viscoelastic, the tail behind the pulse"):
        hc.local_rate(chain.replace(loss=hc.Viscoelastic(1e-6)))
    with pytest.raises(
        hc.InputError, match=r"A \(k/m\)\^\(2/5\) v\^\(1/5\) .* is 0\.2\d\d at bead 1 "
    ):
        hc.local_rate(chain.replace(loss=hc.Viscoelastic(5e-6)))


def test_other_chains_are_refused():
    chain = hc.Chain.uniform(40).replace(loss=hc.Restitution(0.95))
    with pytest.raises(hc.InputError, match="does not support strikers"):
        hc.local_rate(chain.struck_by(mass=2.0, radius=1.0))
    with pytest.raises(hc.InputError, match="mixed losses"):
        hc.local_rate(chain.replace(loss=[hc.Restitution(0.9)] + [hc.Restitution(0.95)] * 38))
    steep = hc.Chain.tapered("backward-linear", 0.5, beads=40)
    with pytest.raises(hc.InputError, match=r"rates .* from -0\.1 to 0\.12, but that of bead 1 is"):
        hc.local_rate(steep.replace(loss=hc.Restitution(0.95)))
    with pytest.raises(hc.InputError, match="exponent 3/2"):
        hc.local_rate(hc.Chain.uniform(40, exponent=2.0).replace(loss=hc.Restitution(0.95)))
    with pytest.raises(hc.InputError, match="does not support a loss"):
        hc.local_rate_gradient(chain, bead=20)


def test_one_warning_states_what_is_uncertain():
    """The law without loss has warned; the total exceeds the limit of the law with loss, too."""
    rates = 0.03 * np.sin(0.5 * np.arange(30))
    chain = hc.Chain.from_radii(np.exp(np.concatenate([[0.0], np.cumsum(rates)])))
    with pytest.warns(hc.ModelRangeWarning):
        without = hc.local_rate(chain).velocity_error.max()
    with pytest.warns(hc.ModelRangeWarning) as raised:
        total = hc.local_rate(chain.replace(loss=hc.Restitution(0.9))).velocity_error.max()
    assert without < lossy_law.DOUBTFUL < total
    assert len(raised) == 1
