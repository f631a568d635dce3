"""Largest forces in sensors, between saved times."""

import warnings

import numpy as np
import pytest

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")


def row(**changes):
    """Steel balls and PTFE balls behind a striker: the largest force in ball 4 comes late."""
    materials = ["steel-52100"] * 6 + ["ptfe"] * 6
    balls = hc.Chain.from_materials(diameters=["9.5 mm"] * 12, materials=materials)
    struck = balls.struck_by(diameter="19 mm", material="steel-52100", velocity="0.01 m/s")
    return struck.replace(right_wall=hc.Wall.of("steel-52100"), **changes)


def test_a_late_and_short_maximum_between_saved_times_is_found():
    # The ensemble locates maxima within its steps.
    exact = hc.simulate_many([row()], keep=["sensor_largest_so_far"], sensors=[5])
    exact = float(exact["sensor_largest_so_far"].squeeze())
    assert exact == pytest.approx(1.30113, rel=1e-5)  # DOP853 of SciPy
    for times in (400, 600, 1000, 4000):
        found = hc.simulate(row(), times=times).sensor_force("ball 4")
        assert found.first_maximum == pytest.approx(1.2229, rel=1e-3)
        assert abs(found.largest_so_far - exact) <= found.error + 1e-7 * exact
        assert found.error < 5e-3 * exact


@pytest.mark.long
def test_bounds_of_the_error_hold_in_random_rows_with_few_saved_times():
    rng, warned = np.random.default_rng(0), 0
    for _ in range(12):
        beads = int(rng.integers(8, 14))
        materials = [*rng.choice(["steel-52100", "ptfe", "brass"], beads)]
        balls = hc.Chain.from_materials(
            diameters=[*rng.uniform(0.005, 0.015, beads)], materials=materials
        )
        chain = balls.struck_by(diameter=0.02, material="steel-52100", velocity=0.01)
        chain = chain.replace(right_wall=hc.Wall.of("steel-52100"))
        bead = beads // 2
        exact = hc.simulate(chain, times=20_000).sensor_force(bead).largest_so_far
        for times in (100, 150, 400):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                found = hc.simulate(chain, times=times).sensor_force(bead)
            assert abs(found.largest_so_far - exact) <= 1.01 * found.error + 1e-6 * exact
            warned += any("interpolated between" in str(each.message) for each in caught)
    assert 0 < warned < 36


@pytest.mark.parametrize("loss", [None, hc.Restitution(0.95)])
def test_saved_times_that_miss_the_largest_overlaps_are_reported(loss):
    run = hc.simulate(row(loss=loss), times=40)
    with pytest.warns(hc.IncompleteWarning, match="between .* saved times; save more times"):
        found = run.sensor_force("ball 4")
    exact = hc.simulate(row(loss=loss), times=4000).sensor_force("ball 4").largest_so_far
    assert found.largest_so_far + found.error >= exact


def test_the_bound_includes_jumps_of_forces_that_fall_at_once():
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=30)
    lossy = balls.replace(loss=hc.UnloadingRatio(0.2)).struck_by(velocity="0.1 m/s")
    found = []
    for times in (301, 10001):
        with pytest.warns(hc.IncompleteWarning, match="jumps whenever a contact with Unloading"):
            found.append(hc.simulate(lossy, until="0.9 ms", times=times).sensor_force("ball 21"))
    coarse, fine = found
    difference = abs(coarse.first_maximum - fine.first_maximum)
    assert 0.01 * fine.first_maximum < difference < coarse.error


def test_the_static_force_of_a_sensor_is_stated(run, tmp_path):
    column = hc.Chain.from_materials(
        diameters="10 mm", materials="steel-52100", beads=20, gravity="9.81 m/s^2",
        right_wall=hc.Wall(),
    ).struck_by(velocity="0.1 m/s")  # fmt: skip
    found = hc.simulate(column, until="0.5 ms", times=2001).sensor_force("ball 10")
    weight = 9.81 * column.masses[1:]
    static = weight[:9].sum() + 0.5 * weight[9]
    assert found.static_force == pytest.approx(static, rel=1e-12)
    assert f"with the static force of {static:.4g} N" in " ".join(repr(found).split())
    (tmp_path / "column.toml").write_text(hc.chain_as_toml(column))
    _, out, _ = run("simulate", tmp_path / "column.toml", "--sensor", "ball 10")
    assert f", with the static force of {static:.4g} N" in out


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("law", [hc.Dashpot(1.0), hc.VelocityPower(1.0, 1.5)])
def test_the_force_with_which_a_dashpot_begins_is_exact(law):
    # Both beads meet at speed 1, and the force falls from gamma on.
    pair = hc.Chain.uniform(2).replace(loss=law, gaps=[0.1])
    table = hc.simulate_many([pair], keep=["body_force.peak"], until=5.0)
    assert table["body_force.peak"][0] == pytest.approx(1.0, rel=1e-5)
    sensor = hc.simulate(pair, until=5.0).sensor_force(2)
    assert sensor.largest_so_far == pytest.approx(0.5, rel=1e-12)
    assert sensor.first_maximum == sensor.largest_so_far
    assert sensor.error < 1e-12


@pytest.mark.parametrize("law", [hc.Dashpot(0.1), hc.VelocityPower(0.1, 1.5)])
def test_saved_times_do_not_miss_the_jump_with_which_a_contact_closes(law):
    # Bead 1 meets bead 2 with speed 1; bead 2 is light, and its force falls before it rises again.
    row = hc.Chain.uniform(3).replace(loss=law, masses=[10.0, 0.02, 10.0], gaps=[0.1, 0.3])
    for times in (60, 100, 1000, 10_000):
        found = hc.simulate(row, until=5.0, times=times).sensor_force(2)
        assert found.first_maximum == pytest.approx(0.05, rel=1e-9)
        assert found.first_maximum_time == pytest.approx(0.1, rel=1e-9)
        assert found.largest_so_far > 10.0 * found.first_maximum


def test_bounds_of_a_run_without_until_include_overlaps_between_saved_times():
    balls = hc.Chain.uniform(6).with_cap(6.0).struck_by(radius=1.5, count=2)
    chain = balls.replace(left_wall=hc.Wall(), loss=hc.Viscoelastic(0.05))
    coarse = hc.simulate(chain, times=400)
    assert coarse.times[-1] < coarse.end_time
    exact = hc.simulate(chain, until=20.0, times=4000).sensor_force(2).largest_so_far
    with pytest.warns(hc.IncompleteWarning, match="save more times"):
        found = coarse.sensor_force(2)
    assert found.largest_so_far < 0.95 * exact
    assert found.largest_so_far + found.error >= exact


def test_a_resumed_run_states_that_earlier_forces_are_not_included():
    chain = hc.Chain.uniform(9)
    first = hc.simulate(chain, until=6.0)
    later = hc.simulate(chain, start=first.state, until=12.0)
    assert "forces before t = 5.974 are not included" in " ".join(
        repr(later.sensor_force(8)).split()
    )
    assert "not included" not in repr(hc.simulate(chain, until=12.0).sensor_force(8))


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_a_force_that_rises_at_the_last_saved_time_has_an_error():
    # The run ends between the last saved time and the next one.
    chain = hc.Chain.from_radii([1.0, 0.8, 1.3]).replace(gaps=[0.0, 0.5])
    short = hc.simulate(chain, until=1.0).end_time
    run = hc.simulate(chain, times=np.linspace(0.0, 0.97, 98), until=short)
    exact = 0.5 * float(hc.simulate(chain, until=short, times=[0.0, short]).force(1)[-1])
    found = run.sensor_force(1)
    assert found.largest_so_far < 0.995 * exact < exact < found.largest_so_far + found.error


def test_the_bound_includes_the_jump_of_a_contact_that_closes_near_the_maximum():
    # Bead 3 begins to push back on bead 2 shortly before the force in bead 2 is largest.
    chain = hc.Chain.uniform(3).replace(loss=hc.Dashpot(0.08), gaps=[0.0, 0.2])
    exact = hc.simulate(chain, until=4.0, times=100_001).sensor(2).max()
    for times in range(30, 400, 30):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hc.IncompleteWarning)
            found = hc.simulate(chain, until=4.0, times=times).sensor_force(2)
        assert abs(found.largest_so_far - exact) <= found.error
