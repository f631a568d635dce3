"""How far a run can be predicted, against runs with a tighter tolerance."""

import pickle
import warnings

import numpy as np
import pytest
from click.testing import CliRunner
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.store.sweep_layout import SCHEMA

WALLS = {"left_wall": hc.Wall(), "right_wall": hc.Wall()}


def box(beads=20, **changes):
    return hc.Chain.uniform(beads).replace(**(WALLS | changes))


def true_horizon(run, within=0.01):
    """First saved time at which the run differs from one with a hundredth of its tolerance."""
    tight = hc.simulate(run.chain, times=run.times, rtol=run.rtol / 100.0)
    error = np.abs(run.velocities - tight.velocities).max(axis=1)
    beyond = np.flatnonzero(error > within * np.abs(run.velocities).max())
    return run.times[beyond[0]] if len(beyond) else np.inf


@pytest.mark.parametrize(("rtol", "until"), [(1e-12, 500.0), (1e-9, 400.0)])
@pytest.mark.parametrize("seed", range(6))
def test_the_horizon_is_never_later_than_the_true_one(seed, rtol, until):
    radii = np.random.default_rng(seed).uniform(0.8, 1.2, 16)
    run = hc.simulate(hc.Chain.from_radii(radii).replace(**WALLS), until=until, rtol=rtol)
    true, found = true_horizon(run), run.horizon().time
    assert np.isfinite(true)
    assert 0.5 * true < found <= true


@pytest.mark.long
@pytest.mark.parametrize(("method", "drift"), [("forward-4", 1e-4), ("verlet", 1e-6)])
@pytest.mark.parametrize("seed", range(3))
def test_the_horizon_of_fixed_steps_is_never_later_than_the_true_one(seed, method, drift):
    radii = np.random.default_rng(seed).uniform(0.8, 1.2, 16)
    chain = hc.Chain.from_radii(radii).replace(**WALLS)
    run = hc.simulate(chain, until=400.0, method=method, drift=drift)
    exact = hc.simulate(chain, times=run.times, rtol=1e-13)
    error = np.abs(run.velocities - exact.velocities).max(axis=1)
    true = run.times[np.argmax(error > 0.01 * np.abs(run.velocities).max())]
    horizon = run.horizon()
    assert 0.5 * true < horizon.time <= true < 0.6 * run.end_time
    assert horizon.shadow_step == 0.5 * horizon.step < 0.1
    assert "from steps of" in " ".join(repr(horizon).split())


def test_what_cannot_become_unpredictable_does_not():
    for chain in (
        hc.Chain.uniform(30),
        box(30, loss=hc.Restitution(0.95)),
        box(30, precompression=0.3, velocities=np.append(1e-3, np.zeros(29))),
    ):
        horizon = hc.simulate(chain, until=200.0).horizon()
        assert horizon.time == np.inf
        assert horizon.error[-1] < 1e-5
        assert "at all saved times, up to t = 200" in " ".join(repr(horizon).split())


def test_the_drift_of_energy_says_nothing_of_it():
    run = hc.simulate(box(), until=400.0)
    assert run.horizon().time < 400.0
    assert run.horizon().error[-1] > 0.5
    assert run.energy_drift < 1e-10


def test_a_tighter_tolerance_is_no_remedy():
    loose, tight = (hc.simulate(box(), until=400.0, rtol=rtol).horizon() for rtol in (1e-11, 1e-13))
    # Two digits of tolerance, and not twice the time.
    assert loose.time < tight.time < 1.6 * loose.time


def test_the_error_is_a_running_maximum():
    horizon = hc.simulate(box(), until=300.0).horizon()
    assert np.all(np.diff(horizon.error) >= 0.0)
    at = np.searchsorted(horizon.times, horizon.time)
    assert horizon.error[at - 1] <= horizon.within < horizon.error[at]


def test_it_is_kept_and_said():
    run = hc.simulate(box(), until=300.0)
    assert run.known_horizon is None
    assert "run.horizon() shows how long it is predictable" in " ".join(repr(run).split())
    first = run.horizon()
    assert run.horizon(within=1e-6).time < first.time
    assert run.horizon(within=0.01).error is first.error
    assert f"predictable within 1% until t = {first.time:.4g}" in " ".join(repr(run).split())
    assert pickle.loads(pickle.dumps(run)).known_horizon.time == first.time


def tapered(rate, beads, **changes):
    chain = hc.Chain.tapered("forward-exponential", rate, beads=beads)
    return chain.replace(right_wall=hc.Wall(), **changes)


def words(found):
    return " ".join(repr(found).split())


def test_a_taper_at_one_wall_traps_waves_as_well():
    run = hc.simulate(tapered(0.05, 30), until=150.0)
    assert not run.wall_force().sensitive
    assert "; 9 transits long: run.horizon() shows how long it is predictable" in words(run)
    assert run.horizon().time < 150.0


@pytest.mark.long
def test_a_largest_force_after_the_first_contact_is_called_sensitive():
    """With a tenth of the tolerance, another impact is the strongest."""
    run = hc.simulate(tapered(0.1, 40))
    wall, other = run.wall_force(), hc.simulate(tapered(0.1, 40), rtol=1e-12).wall_force()
    assert abs(wall.peak / other.peak - 1.0) > 1e-3
    assert wall.peak_time > wall.first_contact_end
    assert wall.proven
    assert wall.sensitive
    assert other.sensitive
    assert "no larger force follows in this run; the largest " in words(wall)
    assert "such as another tolerance: check with run.horizon()" in words(wall)
    assert "no larger force on the right wall can follow in this run" in run.message
    assert "10 transits long, wall peak not in the first contact: run.horizon()" in words(run)
    assert "small changes" in wall._repr_html_()


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("keep", [["wall_peak_force"], ["wall_duration", "end_time"]])
def test_tables_flag_sensitive_forces_as_simulate_does(keep):
    chains = [tapered(0.05, 20), tapered(0.1, 40), tapered(0.1, 40, loss=hc.Restitution(0.8))]
    table = hc.simulate_many([*chains, None], keep=keep)
    flags = [hc.simulate(chain).wall_force().sensitive for chain in chains]
    assert table.sensitive.tolist() == [*flags, False] == [False, True, False, False]
    assert "; 1 largest force on the wall may be sensitive to small changes" in words(table)
    assert table.to_dataframe()["sensitive"].tolist() == table.sensitive.tolist()
    assert table.to_xarray()["sensitive"].values.tolist() == table.sensitive.tolist()
    assert "small changes" in table._repr_html_()
    assert "small changes" not in words(hc.simulate_many(chains, keep="velocity"))


@pytest.mark.long
# The duration is not computed by the kernel for many chains.
@pytest.mark.parametrize("keep", ["wall_peak_force", "wall_duration"])
def test_sweeps_flag_sensitive_forces(keep, tmp_path):
    found = hc.sweep({
        "chain": {"taper": "forward-exponential", "beads": 40, "right_wall": {}},
        "axes": {"rate": [0.05, 0.1]},
        "sweep": {"methods": ["simulate"], "keep": [keep]},
    }, tmp_path / "sweep")  # fmt: skip
    assert found.sensitive.values[:, 0].tolist() == [0, 1]
    assert "1 point may be sensitive to small changes" in hc.plot_sweep(found).get_title()
    # Stores with other arrays cannot be resumed: their layout must have another name.
    arrays = {each.name for each in (tmp_path / "sweep").iterdir() if each.is_dir()}
    found = {"approach", "rate", "status", "reason", "incomplete", "sensitive", keep, "digest"}
    assert (arrays, SCHEMA) == (found, "hertzchain sweep 3")
    told = CliRunner().invoke(cli, ["sweep", "status", str(tmp_path / "sweep")]).output
    assert (
        "points whose largest force on the wall may be sensitive to small changes: 1 (see" in told
    )


@pytest.mark.parametrize(
    ("chain", "until"),
    [
        (tapered(0.05, 20), None),
        (tapered(0.1, 40, loss=hc.Restitution(0.8)), None),
        (hc.Chain.uniform(20).replace(right_wall=hc.Wall(stiffness=1e6)), None),
        (box(), None),
    ],
)
def test_forces_in_the_first_contact_or_with_losses_are_not_called_sensitive(chain, until):
    wall = hc.simulate(chain, until=until).wall_force()
    assert wall.complete
    assert not wall.sensitive
    assert "computed motion" not in words(wall)
    assert "small changes" not in words(wall)


@pytest.mark.parametrize(
    ("chain", "until"),
    [
        (hc.Chain.uniform(20), 300.0),
        (box(), 50.0),
        (box(loss=hc.Restitution(0.9)), 300.0),
        (hc.Chain.uniform(20).replace(right_wall=hc.Wall()), 300.0),
        (tapered(0.05, 20), 20.0),
    ],
)
def test_short_and_harmless_runs_say_nothing_of_it(chain, until):
    assert "horizon" not in repr(hc.simulate(chain, until=until))


def test_a_resumed_run_has_the_horizon_of_the_whole():
    times = np.linspace(2.0, 300.0, 150)
    whole = hc.simulate(box(), times=times)
    part = hc.simulate(box(), times=times[:75])
    rest = hc.simulate(box(), times=times[75:], start=part.state)
    # The last step before the break is shorter, so that other rounding errors grow.
    assert rest.horizon().time == pytest.approx(whole.horizon().time, rel=0.03)


@pytest.mark.long
def test_a_run_in_si_units_has_the_same_horizon():
    ratios = []
    for velocity in (0.05, 0.08, 0.09, 0.1, 0.12, 0.15, 0.2, 0.3):
        balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=15, velocity=velocity)
        balls = balls.replace(**WALLS)
        scales = hc.Scales.of(balls)
        plain = hc.simulate(scales.to_scaled(balls), until=400.0)
        real = scales.to_si(plain)
        assert real.known_horizon is None
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            horizon = real.horizon()
        ratios.append(horizon.time / (scales.time * plain.horizon().time))
    # Each horizon depends on the first rounding errors, and differs by up to 25%: that of one
    # scaled chain is 222 to 291 with changes of the last digits of the velocity.
    assert np.median(ratios) == pytest.approx(1.0, abs=0.15)
    assert f"until t = {1e6 * horizon.time:.4g} us;" in " ".join(repr(horizon).split())


def test_the_largest_tolerance_is_compared_with_a_tighter_one():
    horizon = hc.simulate(hc.Chain.uniform(9), until=20.0, rtol=1e-6).horizon()
    assert horizon.shadow_rtol == pytest.approx(1e-7)
    assert 0.0 < horizon.error[-1] < 1e-3


def test_pictures_show_where_it_begins():
    run = hc.simulate(box(), until=300.0)
    horizon = run.horizon()
    budget = run.budget()
    for axes in (
        budget.plot(horizon=horizon), budget.plot("momentum", horizon=horizon), run.plot(),
        run.plot_forces([5]),
    ):  # fmt: skip
        begins = [line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == ":"]
        assert begins == [pytest.approx(horizon.time)]
    assert "horizon: error 1%" in legend_texts(axes)


def test_what_has_no_horizon():
    chain = hc.Chain.uniform(9)
    with pytest.raises(hc.InputError, match="no saved times to compare"):
        hc.simulate(chain, until=5.0, times=0).horizon()
    with pytest.raises(hc.InputError, match="no saved times to compare"):
        hc.simulate(chain, until=5.0, times=[0.0]).horizon()
    state = hc.simulate(chain, until=5.0).state.reversed()
    with pytest.raises(hc.InputError, match="its state was reversed"):
        hc.simulate(chain, start=state, until=5.0).horizon()
    with pytest.raises(hc.InputError, match="within must be above 0 and below 1"):
        hc.simulate(chain, until=5.0).horizon(within=1.0)
    with pytest.raises(hc.InputError, match="horizon must be a Horizon"):
        hc.simulate(chain).budget().plot(horizon=3.0)
