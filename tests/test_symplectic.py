"""Long runs by fixed steps of splitting methods."""

import numpy as np
import pytest
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.kernels.symplectic import SPLITTINGS
from hertzchain.simulation.fixed_steps import COSTS

WALL = hc.Wall()
CHAINS = {
    "free": hc.Chain.uniform(20),
    "walls": hc.Chain.uniform(20).replace(left_wall=WALL, right_wall=WALL),
    "gaps": hc.Chain.uniform(20).replace(gaps=[*[0.0] * 9, 1.0, *[0.0] * 9], right_wall=WALL),
    "gravity": hc.Chain.uniform(20).replace(gravity=1e-3, right_wall=WALL),
    "precompressed": hc.Chain.uniform(20).replace(
        precompression=0.05, held_by="force", right_wall=WALL
    ),
    "power law": hc.Chain.uniform(20, exponent=2.5),
    "exponents": hc.Chain.uniform(20).replace(
        exponent=[1.5, 2.0] * 9 + [1.5], stiffness=[1.0, 2.0] * 9 + [1.0]
    ),
    "radii": hc.Chain.from_radii(np.linspace(1.0, 0.6, 20)).replace(right_wall=WALL),
}


@pytest.mark.parametrize("step", [0.9, 1.0, 1.1])
def test_a_run_whose_energy_grows_fails(step):
    box = CHAINS["walls"]
    with pytest.raises(
        hc.SimulationError, match="the energy has changed by more than half at t = "
    ):
        hc.simulate(box, until=200.0, method="verlet", step=step, times=201)
    run = hc.simulate(box, until=200.0, method="verlet", step=step, times=201, check=False)
    assert run.status == "unstable steps"
    assert not run.success


def test_a_given_step_that_is_too_long_for_accurate_results_warns():
    box = CHAINS["walls"]
    with pytest.warns(hc.InputWarning, match=r"with step = 0\.5, the energy has drifted by \d"):
        run = hc.simulate(box, until=100.0, method="verlet", step=0.5)
    energy = 0.5 * (run.velocities**2).sum(axis=1)
    assert run.success
    assert energy.max() < 0.6


@pytest.mark.parametrize(("option", "message"), [
    ({"step": -1.0}, "step must be above 0"),
    ({"step": "1 us"}, "step"),
    ({"drift": 5.0}, "drift must be"),
])  # fmt: skip
def test_steps_of_a_chain_at_rest_are_checked(option, message):
    resting = hc.Chain.uniform(3).replace(velocities=[0.0, 0.0, 0.0])
    with pytest.raises(hc.InputError, match=message):
        hc.simulate(resting, until=10.0, times=3, method="verlet", **option)


@pytest.mark.parametrize("name", CHAINS)
def test_runs_agree_with_an_independent_integration(name):
    chain, times = CHAINS[name], np.linspace(0.0, 30.0, 31)
    run = hc.simulate(chain, times=times, method="symplectic", step=0.01)
    exact = trajectory(chain, times)
    # Measured: 4e-7 or less.
    np.testing.assert_allclose(run.velocities, exact.velocities, rtol=0.0, atol=4e-6)
    np.testing.assert_allclose(run.forces, exact.forces, rtol=0.0, atol=4e-6)
    assert run.energy_drift < 1e-6
    assert run.momentum_drift < 1e-12
    adaptive = hc.simulate(chain, times=times, rtol=1e-12)
    for quantity in ("velocity", "arrival", "peak_overlap"):
        one, other = getattr(run.pulse(), quantity), getattr(adaptive.pulse(), quantity)
        np.testing.assert_array_equal(np.isnan(one), np.isnan(other))
        np.testing.assert_allclose(one, other, rtol=2e-5, atol=1e-12)


def test_forces_on_walls_agree_with_the_adaptive_method():
    chain = hc.Chain.uniform(20).replace(right_wall=WALL)
    run, other = hc.simulate(chain, method="symplectic", step=0.01), hc.simulate(chain)
    wall, expected = run.wall_force(), other.wall_force()
    assert run.status == other.status == "wall force complete"
    assert wall.peak == pytest.approx(expected.peak, rel=1e-6)
    assert wall.touches == expected.touches
    assert wall.first_contact_impulse == pytest.approx(expected.first_contact_impulse, rel=1e-6)
    assert wall.impulse_of_impact == pytest.approx(expected.impulse_of_impact, rel=1e-6)


@pytest.mark.parametrize("drift", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("name", ["walls", "radii", "gravity", "power law"])
def test_the_drift_is_what_was_requested(name, drift):
    run = hc.simulate(CHAINS[name], until=300.0, times=0, method="symplectic", drift=drift)
    assert 0.0 < run.energy_drift <= drift
    assert run.method in SPLITTINGS


@pytest.mark.long
def test_the_drift_of_verlet_does_not_grow():
    chain, drifts = CHAINS["walls"], []
    assert (
        hc.simulate(chain, until=1e5, times=0, method="symplectic", drift=1e-3).method == "verlet"
    )
    for until in (300.0, 6000.0):
        run = hc.simulate(chain, until=until, times=0, method="symplectic", drift=3e-4)
        drifts.append(run.energy_drift)
    assert max(drifts) <= 3e-4


def order_of(name, monkeypatch):
    """Order of a splitting by its error in a precompressed chain, whose contacts stay closed."""
    from hertzchain.simulation import fixed_steps

    monkeypatch.setattr(
        fixed_steps, "plan", lambda _, step, *__: fixed_steps.FixedSteps(name, step)
    )
    chain = hc.Chain.uniform(6).replace(
        precompression=1.0, left_wall=WALL, right_wall=WALL, velocities=[0.1] + [0.0] * 5
    )
    exact = hc.simulate(chain, until=20.0, times=[20.0], rtol=1e-14).velocities
    errors = [
        abs(hc.simulate(
            chain, times=[20.0], until=20.0, method="symplectic", step=step
        ).velocities - exact).max()
        for step in (0.1, 0.05)
    ]  # fmt: skip
    return np.log2(errors[0] / errors[1])


@pytest.mark.parametrize(("name", "order"), [("verlet", 2.0), ("forward-4", 4.0)])
def test_order(name, order, monkeypatch):
    assert order_of(name, monkeypatch) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("name", ["walls", "gaps", "precompressed", "exponents"])
def test_a_resumed_run_is_the_same_bit_for_bit(name):
    chain, times = CHAINS[name], np.linspace(0.0, 60.0, 61)
    fixed = {"method": "symplectic", "step": 0.03}
    whole = hc.simulate(chain, times=times, **fixed)
    state = None
    for stop in (7.3, 21.9, 40.2):
        state = hc.simulate(chain, until=stop, times=0, start=state, **fixed).state
    later = times[times >= state.time]
    rest = hc.simulate(chain, times=later, start=state, **fixed)
    np.testing.assert_array_equal(rest.velocities, whole.velocities[-len(later) :])
    for row in ("y", "peaks", "crossings", "walls"):
        np.testing.assert_array_equal(rest.state.arrays[row], whole.state.arrays[row])


@pytest.mark.parametrize(
    ("changes", "options", "said"),
    [
        ({"loss": hc.Restitution(0.9)}, {}, "supports elastic contacts only.*method 'adaptive'"),
        ({"loss": hc.WaltonBraun(0.9)}, {}, "supports elastic contacts only.*method 'adaptive'"),
        ({"drive": hc.SineBurst(0.3, 0.1, cycles=2.0)}, {}, "does not support drives.*'adaptive'"),
        ({}, {"step": 5.0}, r"step = 5 is unstable.* steps must be below \d.*; try 0\.\d+"),
        ({}, {"step": -1.0}, "step must be above 0"),
        ({}, {"step": 0.1, "drift": 1e-5}, "give step or drift, not both"),
        ({}, {"drift": 1.0}, "drift must be at least 1e-11 and at most 0.01"),
        ({}, {"method": "leapfrog"}, "method.*'leapfrog'.*adaptive"),
        ({}, {"method": "adaptive", "step": 0.1}, "step and drift require method 'symplectic'"),
    ],
)
def test_invalid_requests(changes, options, said):
    chain = hc.Chain.uniform(5).replace(**changes)
    with pytest.raises(hc.InputError, match=said):
        hc.simulate(chain, until=10.0, **({"method": "symplectic"} | options))


def test_all_methods_have_a_cost():
    assert COSTS.keys() <= SPLITTINGS.keys()


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize("method", ["adaptive", "symplectic"])
def test_first_contacts_with_negligible_impulses_are_ignored(method):
    """Bead 6 touches the wall before the pulse arrives, and rebounds with twice its momentum."""
    chain = hc.Chain.uniform(6).replace(
        gaps=[0.0, 0.0, 0.0, 0.0, 0.01], right_wall=hc.Wall(stiffness=1e6)
    )
    found = [
        hc.simulate(
            chain.replace(velocities=[1.0, 0.0, 0.0, 0.0, 0.0, speed]), until=30.0, method=method
        ).wall_force()
        for speed in (1e-7, 1e-11)
    ]
    assert found[0].first_contact_impulse == pytest.approx(2e-7, rel=1e-6)
    assert found[1].first_contact_impulse > 1.0
    assert [wall.sensitive for wall in found] == [True, False]
