import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.collision import collision_overlap, compression_time
from hertzchain.theory.hard_sphere import (
    exponential_energy_ratio,
    hard_sphere_energy_ratio,
    restitution_from_unloading,
)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@given(st.lists(st.floats(0.3, 3.0), min_size=2, max_size=12), st.floats(0.1, 1.0))
def test_collisions_obey_newton(radii, e):
    """Momentum is kept and the relative speed is e times what it was, pair by pair."""
    chain = hc.Chain.from_radii(radii)
    pulse = hc.hard_sphere(chain, restitution=e)
    m, v = chain.masses, pulse.velocity
    after = v[:-1] - m[1:] / m[:-1] * v[1:]
    np.testing.assert_allclose(v[1:] - after, e * v[:-1], rtol=1e-9)
    ratio = hard_sphere_energy_ratio(chain, restitution=e)
    assert ratio == pytest.approx(pulse.energy[-1] / pulse.energy[0], rel=1e-11)
    assert hc.bca(chain, restitution=e).velocity.tolist() == v.tolist()


def test_hard_spheres_take_no_time():
    pulse = hc.hard_sphere(hc.Chain.tapered("forward-exponential", 0.05, beads=30))
    assert list(pulse.columns()) == ["velocity", "momentum", "energy"]
    assert pulse.method == "hard sphere"


@pytest.mark.parametrize("theory", [hc.bca, hc.hard_sphere])
def test_alternating_masses_are_outside_the_range_of_single_collisions(theory):
    chain = hc.Chain.dimer(0.55, beads=60)
    with pytest.warns(hc.ModelRangeWarning, match="masses that grow and fall"):
        pulse = theory(chain)
    assert pulse.velocity[-1] < 0.5 * hc.propagate(chain).velocity[-1]


def test_published_ratio_of_exponential_chains():
    assert exponential_energy_ratio(0.05, 20) == pytest.approx(0.893718, abs=5e-7)
    chain = hc.Chain.from_radii(0.9 ** np.arange(15))
    product = hard_sphere_energy_ratio(chain, restitution=0.8)
    assert exponential_energy_ratio(0.1, 15, restitution=0.8) == pytest.approx(product, rel=1e-13)
    backward = hc.Chain.tapered("backward-exponential", 0.1, beads=15)
    assert hard_sphere_energy_ratio(backward, restitution=0.8) == pytest.approx(product, rel=1e-13)


@given(st.lists(st.floats(0.05, 1.0), min_size=1, max_size=6))
def test_geometric_masses_pass_on_most(between):
    last, n = 0.02, len(between) + 2
    best = hard_sphere_energy_ratio(hc.Chain.from_radii(last ** (np.arange(n) / (n - 1))))
    assert hard_sphere_energy_ratio(hc.Chain.from_radii([1.0, *between, last])) <= best + 1e-14


@pytest.mark.parametrize("exponent", [1.5, 2.5])
def test_soft_unloading_by_integration(exponent):
    """Loss w in unloading: e as stated, and the elastic time and overlap until equal speeds."""
    w, masses, v = 0.3, np.array([1.0, 0.4]), 0.7

    def rates(_, y):
        overlap = max(y[0] - y[1], 0.0)
        force = overlap**exponent * (1.0 if y[2] > y[3] else 1.0 - w)
        return [y[2], y[3], -force / masses[0], force / masses[1]]

    def equal(_, y):
        return y[2] - y[3]

    def apart(_, y):
        return y[0] - y[1] + 1e-15

    equal.direction, apart.direction, apart.terminal = -1, -1, True
    options = {"rtol": 1e-11, "atol": 1e-14, "max_step": 0.005, "events": [equal, apart]}
    run = solve_ivp(rates, (0.0, 20.0), [0.0, 0.0, v, 0.0], **options)
    e = (run.y[3, -1] - run.y[2, -1]) / v
    assert restitution_from_unloading(w) == pytest.approx(e, rel=1e-6)
    reduced = masses.prod() / masses.sum()
    assert run.t_events[0][0] == pytest.approx(
        float(compression_time(reduced, 1.0, v, exponent)), rel=1e-8
    )
    state = run.y_events[0][0]
    assert state[0] - state[1] == pytest.approx(
        float(collision_overlap(reduced, 1.0, v, exponent)), rel=1e-8
    )


def test_bca_with_loss_slows_the_pulse():
    chain = hc.Chain.uniform(5)
    elastic, lossy = hc.bca(chain), hc.bca(chain, restitution=0.8)
    assert lossy.method == "BCA, e = 0.8"
    np.testing.assert_allclose(lossy.velocity, 0.9 ** np.arange(5), rtol=1e-15)
    np.testing.assert_allclose(
        lossy.residence, elastic.residence * lossy.velocity[:-1] ** -0.2, rtol=1e-13
    )


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.bca(hc.Chain.uniform(3), restitution=0.0), "restitution .* got 0"),
        (lambda: hc.hard_sphere(hc.Chain.uniform(3), restitution=1.1), "at most 1, got 1.1"),
        (lambda: hc.bca(hc.Chain.uniform(3), restitution=float("nan")), "got nan"),
        (lambda: hc.bca(hc.Chain.uniform(3), restitution="high"), "got 'high'"),
        (lambda: restitution_from_unloading(1.0), "below 1, got 1"),
        (lambda: exponential_energy_ratio(1.0, 20), "q must .* got 1"),
        (lambda: exponential_energy_ratio(0.1, 1), "beads must .* got 1"),
    ],
)
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


@pytest.mark.parametrize("theory", [hc.bca, hc.hard_sphere])
@pytest.mark.parametrize(
    "law", [hc.Restitution(0.9), hc.UnloadingRatio(0.19), hc.WaltonBraun(0.81)], ids=str
)
def test_comparison_with_a_lossy_run_warns_that_the_decay_is_too_fast(theory, law):
    chain = hc.Chain.uniform(30)
    run = hc.simulate(chain.replace(loss=law), times=0).pulse()
    lossy = theory(chain, restitution=0.9)
    with pytest.warns(hc.ModelRangeWarning, match=r"e = 0.9 assumes .* 1.2 to 3.4 times"):
        compared = lossy.compare(run)
    with pytest.warns(hc.ModelRangeWarning, match="1.2 to 3.4 times"):
        run.compare(lossy)
    # The reason for the warning: decay per bead from bead 10 to 25.
    excess = np.log(lossy.velocity[9] / lossy.velocity[24])
    excess /= np.log(run.velocity[9] / run.velocity[24])
    assert 1.2 < excess < 3.4
    assert compared.errors("velocity")[24] < compared.errors("velocity")[9]


def test_comparison_without_loss_does_not_warn():
    chain = hc.Chain.uniform(12)
    lossy = hc.bca(chain, restitution=0.9)
    lossy.compare(hc.propagate(chain))
    run = hc.simulate(chain.replace(loss=hc.Restitution(0.9)), times=0).pulse()
    hc.bca(chain).compare(run)
    assert (lossy.restitution, hc.bca(chain).restitution, run.restitution) == (0.9, 1.0, 1.0)
