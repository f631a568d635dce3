"""The leading pulse of a run: known values, and the definition against independent sums."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

import hertzchain as hc
from hertzchain.chain.equilibrium import equilibrium

# Momentum of the solitary wave of a chain struck with momentum 1, by the fixed point of the
# travelling wave; in parts of the momentum of one bead, 1.66997.
SOLITARY = 1.138305088728
WALLED = hc.Chain.tapered("forward-linear", 0.05, beads=12).replace(right_wall=hc.Wall())
CHAINS = {
    "uniform": hc.Chain.uniform(60),
    "forward": hc.Chain.tapered("forward-exponential", 0.03, beads=60),
    "backward": hc.Chain.tapered("backward-exponential", 0.03, beads=60),
    "dimer": hc.Chain.dimer(0.342845, beads=60),
    "heavy": hc.Chain.uniform(60).replace(masses=np.append(4.0, np.ones(59))),
}


def at_passage(chain, bead):
    """Budget at the time at which a bead is fastest, and the pulse."""
    pulse = hc.simulate(chain, times=0).pulse()
    return hc.simulate(chain, times=[pulse.peak_time[bead - 1]]).budget(), pulse


def test_in_equal_beads_it_is_the_solitary_wave():
    budget, pulse = at_passage(hc.Chain.uniform(100), 50)
    momentum = {name: values[0] for name, values in budget.momentum.items()}
    assert momentum["leading pulse"] == pytest.approx(SOLITARY, rel=2e-5)
    assert momentum["leading pulse"] / pulse.momentum[49] == pytest.approx(1.66997, rel=2e-5)
    assert abs(momentum["lagging"]) < 1e-4


# From a separate program with 6000 saved times: momentum and kinetic energy of the leading pulse,
# of lagging beads, and of beads that move back.
@pytest.mark.parametrize(
    ("q", "beads", "bead", "momentum", "energy"),
    [
        (0.01, 100, 71, [0.4204, 0.6550, -0.0754], [0.2783, 0.0098, 0.0018]),
        (0.05, 60, 43, [0.0627, 0.9429, -0.0057], [0.2075, 0.1487, 0.0000]),
    ],
)
def test_forward_tapers_leave_most_momentum_behind(q, beads, bead, momentum, energy):
    chain = hc.Chain.tapered("forward-exponential", q, beads=beads)
    budget, _ = at_passage(chain, bead)
    parts = ("leading pulse", "lagging", "scattered back")
    found = [budget.momentum[name][0] for name in parts], [budget.energy[name][0] for name in parts]
    np.testing.assert_allclose(found[0], momentum, rtol=0, atol=6e-5)
    np.testing.assert_allclose(found[1], energy, rtol=0, atol=6e-5)
    assert budget.momentum["lagging"][0] > budget.momentum["leading pulse"][0]


@pytest.mark.parametrize("q", [-0.05, -0.01, 0.0, 0.01, 0.05])
def test_it_is_constant_along_self_similar_chains(q):
    taper = "forward-exponential" if q > 0.0 else "backward-exponential"
    chain = hc.Chain.tapered(taper, abs(q), beads=60) if q else hc.Chain.uniform(60)
    run = hc.simulate(chain, times=0)
    leading, pulse = run.leading_pulse(), run.pulse()
    bead, velocity = slice(25, 45), pulse.velocity[25:45]
    np.testing.assert_allclose(
        leading.momentum[bead] / pulse.momentum[bead],
        leading.momentum[44] / pulse.momentum[44], rtol=1e-3,
    )  # fmt: skip
    np.testing.assert_allclose(
        leading.kinetic_energy[bead] / (chain.masses[bead] * velocity**2),
        leading.kinetic_energy[44] / (chain.masses[44] * velocity[-1] ** 2), rtol=1e-3,
    )  # fmt: skip


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_it_is_continuous_in_time(chain):
    steps = []
    for count in (2000, 8000):
        run = hc.simulate(chain, times=count)
        momentum = run.budget().momentum["leading pulse"]
        steps.append(np.abs(np.diff(momentum) / momentum[1:])[len(run.times) // 4 :].max())
    # A jump would not fall with the spacing of the saved times, which is a quarter.
    assert steps[1] < 0.5 * steps[0]


def test_half_of_a_symmetric_pulse_is_handed_over_at_the_crest():
    leading = hc.simulate(hc.Chain.uniform(60), times=0).leading_pulse()
    np.testing.assert_allclose(leading.handed_over[30:50], SOLITARY / 2.0, rtol=5e-9)
    # J over the peak force 0.6395542 of a pulse with peak velocity 0.68163155.
    np.testing.assert_allclose(leading.rise_time[30:50], SOLITARY / 2.0 / 0.6395542, rtol=1e-7)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"loss": hc.Viscoelastic(0.05)},
        {"loss": hc.UnloadingRatio(0.2), "gravity": 0.02},
        {"precompression": 0.2, "left_wall": hc.Wall()},
        {"velocities": np.zeros(12), "drive": hc.SineBurst(0.3, 0.1, cycles=2.0)},
    ],
    ids=lambda changes: "+".join(changes) or "wall",
)
def test_what_is_handed_over_is_the_impulse_of_the_force(changes):
    chain = WALLED.replace(**changes)
    run = hc.simulate(chain, until=25.0, times=20001)
    leading = run.leading_pulse()
    excess = run.forces - equilibrium(chain).forces
    # A force that jumps does so somewhere between two saved times, 0.00125 apart.
    error = 2e-4 if isinstance(chain.loss, hc.UnloadingRatio) else 1e-5
    for k in range(1, 12):
        # Momentum transferred by contact k, minus that transferred to the wall.
        given = cumulative_trapezoid(excess[:, k] - excess[:, 12], run.times, initial=0.0)
        impulse = np.interp(leading.crest[k - 1], run.times, given)
        assert leading.handed_over[k - 1] == pytest.approx(impulse, abs=error)


def lossy(law):
    return hc.Chain.uniform(40).replace(loss=law)


@pytest.mark.parametrize(
    "chain",
    [
        *CHAINS.values(), WALLED, lossy(hc.UnloadingRatio(0.19)), lossy(hc.Restitution(0.8)),
        hc.Chain.from_radii(np.random.default_rng(1).uniform(0.5, 1.5, 40)),
        hc.Chain.dimer(0.1, beads=40), hc.Chain.uniform(20).decorated(0.3),
        hc.Chain.uniform(30).struck_by(count=3),
    ],
    ids=range(12),
)  # fmt: skip
def test_momentum_and_energy_at_the_crest_are_those_of_the_weights(chain):
    """Summed by the compiled loop at the crest, and here from saved states."""
    leading = hc.simulate(chain, until=60.0, times=0).leading_pulse()
    seen = np.flatnonzero(leading.crest > 0.0)
    order = seen[np.argsort(leading.crest[seen])]
    run = hc.simulate(chain, until=60.0, times=leading.crest[order])
    parts = run.leading_pulse().weights(run.times, run.velocities) * chain.masses * run.velocities
    np.testing.assert_allclose(parts.sum(axis=1), leading.momentum[order], rtol=1e-9)
    energy = 0.5 * (parts * run.velocities).sum(axis=1)
    np.testing.assert_allclose(energy, leading.kinetic_energy[order], rtol=1e-9)


def test_nothing_of_it_is_left_after_a_wall():
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=80.0, times=800)
    leading = run.leading_pulse()
    assert leading.weights(run.times, run.velocities)[-1].sum() == 0.0
    # The wall's force is largest when bead N stands still.
    assert leading.rear[-1] == pytest.approx(run.wall_force().peak_time, abs=0.1)
    # A run from a state later than that has the rear of the whole one.
    late = hc.simulate(chain, start=run.state, until=90.0)
    assert late.leading_pulse().rear[-1] == leading.rear[-1]
    assert (late.budget().momentum["leading pulse"] == 0.0).all()


def test_the_parts_are_all_that_moves():
    chain = hc.Chain.from_radii(np.random.default_rng(2).uniform(0.5, 1.5, 30))
    run = hc.simulate(chain.replace(loss=hc.Restitution(0.9), right_wall=hc.Wall()), until=60.0)
    momentum = run.budget().momentum
    moving = sum(momentum[name] for name in ("leading pulse", "lagging", "scattered back"))
    np.testing.assert_allclose(moving, run.velocities @ chain.masses, rtol=0, atol=1e-13)
    assert (momentum["lagging"] > -1e-15).all()
    assert (momentum["scattered back"] <= 0.0).all()


def test_it_is_the_same_in_other_units():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.1)
    scales = hc.Scales.of(chain)
    real = hc.simulate(chain, times=0)
    scaled = scales.to_scaled(real).leading_pulse()
    direct = hc.simulate(scales.to_scaled(chain), times=0).leading_pulse()
    for one, other in ((scales.to_si(scaled), real.leading_pulse()), (scaled, direct)):
        for name in ("crest", "handed_over", "rise_time", "rear", "momentum", "kinetic_energy"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9)


def test_what_has_no_crest_yet_is_missing_with_a_reason():
    leading = hc.simulate(hc.Chain.uniform(20), until=10.0, times=0).leading_pulse()
    missing = np.flatnonzero(np.isnan(leading.momentum)) + 1
    assert missing.tolist() == list(range(missing[0], 20))
    assert leading.notes["momentum"].startswith(f"contacts {missing[0]} to 19: no first maximum")
    assert np.isinf(leading.rear[missing - 1]).all()
    with pytest.raises(hc.InputError, match=r"must have shape \(T, 20\), got \(1, 3\)"):
        leading.weights([1.0], [[1.0, 2.0, 3.0]])


@pytest.mark.parametrize("ratio", [0.2, 0.54, 0.58, 0.62])
def test_dimers_are_overtaken_near_the_resonance_only_after_bead_81(ratio):
    run = hc.simulate(hc.Chain.dimer(ratio, beads=121), until=125.0, times=6250)
    excess = run.velocities.max(axis=0) / run.pulse().velocity - 1
    assert excess[40:82:2].max() < 1e-6
    assert (excess[90:102:2].max() > 0.25) == (ratio == 0.58)
