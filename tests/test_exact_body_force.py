"""The force on a body behind the row does not depend on the saved times of a run."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.representation import measure
from hertzchain.simulation.body_force import body_force
from hertzchain.simulation.hits import second_hit

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def heavy(mass="400 g", **more):
    """A hammer of 500 g on ten balls and a box; of several pulses, a later one is the largest."""
    row = hc.Chain.from_materials(diameters="12 mm", materials="steel-52100", beads=10)
    hammer = {"mass": "500 g", "radius": "flat", "velocity": "1.5 m/s"}
    return row.with_cap(mass).struck_by(**hammer).replace(**more)


def with_scipy(chain, until):
    """Force of the last contact and the time above a tenth of it, by DOP853 of SciPy."""
    n = chain.beads

    def overlaps(x):
        return np.maximum(x[:-1] - x[1:], 0.0)

    def rates(_, y):
        force = np.pad(chain.stiffness * overlaps(y[:n]) ** chain.exponents, 1)
        return np.concatenate((y[n:], -np.diff(force) / chain.masses))

    start = np.concatenate((np.zeros(n), chain.velocities))
    times = np.linspace(0.0, until, 50_001)
    moved = solve_ivp(
        rates, (0, until), start, "DOP853", rtol=1e-10, atol=1e-14, max_step=2e-6, t_eval=times
    ).y[:n]
    force = chain.stiffness[-1] * np.maximum(moved[-2] - moved[-1], 0.0) ** 1.5
    level, top = 0.1 * force.max(), int(force.argmax())
    below = np.flatnonzero(force < level)
    i, j = below[below < top][-1], below[below > top][0]
    start = np.interp(level, force[i : i + 2], times[i : i + 2])
    end = np.interp(level, force[j - 1 : j + 1][::-1], times[j - 1 : j + 1][::-1])
    return force.max(), end - start


@pytest.mark.parametrize("mass", ["400 g", "40 g"])
def test_force_and_duration_are_those_of_scipy_for_any_saved_times(mass):
    chain = heavy(mass)
    force, duration = with_scipy(chain, 1e-3)
    if mass == "400 g":
        assert force == pytest.approx(3527.17, abs=0.01)
    for options in ({}, {"until": "10 ms"}, {"until": "100 ms", "times": 0}, {"times": 2}):
        found = body_force(hc.simulate(chain, **options))
        assert found.force == pytest.approx(force, rel=1e-6)
        assert found.duration == pytest.approx(duration, abs=2e-9)
        assert found.error < 1e-5 * force


@pytest.mark.parametrize("loss", [hc.Restitution(0.9), hc.ElasticPlastic(), hc.Dashpot(0.02)])
def test_forces_with_losses_do_not_depend_on_the_saved_times(loss):
    runs = [
        hc.simulate(heavy(loss=loss), **options)
        for options in ({"times": 100_001, "until": "2 ms"}, {"until": "10 ms"}, {"times": 0})
    ]
    largest = runs[0].force(11).max()
    for run in runs:
        found = body_force(run)
        assert found.force == pytest.approx(largest, rel=1e-5)
        assert found.error < 1e-4 * largest


def test_a_run_with_a_large_tolerance_has_a_force():
    """Such a run and its repetition with saved times do not end alike."""
    box = hc.Chain.from_materials("2.25 mm", "steel-52100", beads=6, loss=hc.ElasticPlastic())
    box = box.with_cap("200 g").struck_by(mass="100 g", radius="flat", velocity="0.5 m/s")
    rough, fine = (
        hc.simulate_many([box], keep="body_force.acceleration", rtol=rtol)["body_acceleration"]
        for rtol in (1e-5, 1e-11)
    )
    assert rough == pytest.approx(fine, rel=1e-5)


def test_a_second_hit_is_repeated_from_its_dents():
    first = hc.simulate(heavy(loss=hc.ElasticPlastic()), times=0)
    start = first.state.struck_again()
    fine = hc.simulate(first.chain, start=start, times=50_001, until="2 ms").force(11).max()
    for options in ({}, {"times": 0}, {"until": "10 ms"}):
        again = body_force(hc.simulate(first.chain, start=start, **options))
        assert again.force == pytest.approx(fine, rel=1e-5)
    assert second_hit(first) == pytest.approx(fine, rel=1e-5)
    assert fine > 1.01 * body_force(first).force


def test_a_saved_run_is_repeated_only_if_its_start_is_known(tmp_path):
    chain = heavy(loss=hc.ElasticPlastic())
    first = hc.simulate(chain, until="10 ms")
    first.save(tmp_path / "first.nc")
    loaded = hc.load_run(tmp_path / "first.nc")
    assert body_force(loaded).force == pytest.approx(body_force(first).force, rel=1e-9)
    second = hc.simulate(chain, start=first.state.struck_again(), until="10 ms")
    second.save(tmp_path / "second.nc")
    again = body_force(hc.load_run(tmp_path / "second.nc"))
    # Its 400 times give an error bound that contains the true force.
    assert abs(again.force - body_force(second).force) <= again.error
    assert again.error > 1e-4 * again.force


def test_a_symplectic_run_is_repeated_with_its_steps():
    run = hc.simulate(heavy(), until="1 ms", method="symplectic", drift=1e-9)
    assert body_force(run).force == pytest.approx(3527.17, rel=1e-5)


def test_error_bounds_have_no_exponent():
    assert measure(523.4, "N", digits=2) == "520 N"
    assert measure(5.234, "N", digits=2) == "5.2 N"


def test_the_command_states_the_same_force_with_until(run, tmp_path):
    (tmp_path / "box.toml").write_text(hc.chain_as_toml(heavy()))
    for options in ((), ("--until", "10ms"), ("--until", "10ms", "--times", "50")):
        out = run("simulate", tmp_path / "box.toml", *options).stdout
        assert "largest force on it, from contact 11: 3527.2 N at t = 387.34 us\n" in out
        assert "above 10% of it): 369 us" in out
