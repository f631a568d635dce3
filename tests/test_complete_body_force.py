"""The largest force on a cap behind a row, in runs that end when no larger one can follow."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.simulation.body_bound import least_energy
from hertzchain.simulation.body_force import body_force
from hertzchain.simulation.ensemble_input import is_covered

PEAK = "body_force.peak"
EARLY = """
[chain]
diameters = ["16 mm", "5 mm", "5 mm", "10 mm", "5 mm", "6 mm", "16 mm", "16 mm"]
materials = "steel-52100"
cap = {mass = "60 g"}

[[chain.struck_by]]
mass = "200 g"
velocity = "0.2 m/s"
"""
pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


@pytest.fixture(name="path")
def _path(tmp_path):
    path = tmp_path / "early.toml"
    path.write_text(EARLY, encoding="utf-8")
    return path


@pytest.fixture(name="early")
def _early(path):
    return hc.load_chain(path)


def simulated(path, *options):
    """Output of the command for an early end."""
    arguments = ["simulate", str(path), "--until", "0.3ms", *options]
    return CliRunner().invoke(cli, arguments, standalone_mode=False).stdout


def by_scipy(chain, end):
    """Largest force of the last contact, from SciPy's DOP853."""
    n, k, m = chain.beads, chain.stiffness, chain.masses

    def forces(x):
        return k * np.maximum(x[:-1] - x[1:], 0.0) ** 1.5

    def rates(_, y):
        return np.concatenate([y[n:], -np.diff(np.pad(forces(y[:n]), 1)) / m])

    start = np.concatenate([np.zeros(n), chain.velocities])
    found = solve_ivp(
        rates, (0.0, end), start, method="DOP853", rtol=1e-10, atol=1e-15, max_step=1e-6,
        dense_output=True,
    )  # fmt: skip
    return max(float(forces(found.sol(t)[:n])[-1]) for t in np.linspace(0.0, end, 20_001))


def test_a_run_without_an_end_has_the_later_pulse_on_the_cap(early):
    expected = by_scipy(early, 1e-3)
    assert expected == pytest.approx(200.34, abs=0.01)
    found = body_force(hc.simulate(early))
    assert found.complete
    assert found.later
    assert found.force == pytest.approx(expected, rel=1e-5)


def test_a_resumed_run_has_the_largest_force_before(early, tmp_path):
    run = hc.simulate(early)
    first = hc.simulate(early, until=0.5 * (body_force(run).time + run.end_time))
    later = hc.simulate(early, start=first.state, until=run.end_time)
    assert later.force(early.beads - 1).max() < 50.0
    assert body_force(later).force == pytest.approx(by_scipy(early, 1e-3), rel=1e-5)
    assert body_force(later).complete
    later.save(tmp_path / "later.nc")
    assert body_force(hc.load_run(tmp_path / "later.nc")).force == body_force(later).force


def test_a_run_that_resumes_an_unknown_one_is_not_complete(early):
    # The second hit begins with dents, and its resumed run does not contain the largest force.
    hit = hc.simulate(early.replace(loss=hc.ElasticPlastic()))
    again = hc.simulate(hit.chain, start=hit.state.struck_again())
    end = again.end_time
    first = hc.simulate(hit.chain, start=hit.state.struck_again(), until=0.9 * end)
    part = body_force(hc.simulate(hit.chain, start=first.state, until=end))
    assert body_force(again).complete
    assert part is None or not part.complete


def test_a_row_without_a_cap_is_complete_only_if_proven():
    row = hc.Chain.uniform(6)
    assert body_force(hc.simulate(row)).complete
    table = hc.simulate_many([row], keep=[PEAK])
    assert table.complete[0]
    driven = row.replace(velocities=np.zeros(6), drive=hc.SineBurst(0.5, 0.1, cycles=6))
    with pytest.warns(hc.IncompleteWarning, match="force on the last body is complete"):
        table = hc.simulate_many([driven], keep=[PEAK], until=20.0)
    assert not table.complete[0]
    found = [body_force(hc.simulate(driven, until=until)) for until in (20.0, 60.0)]
    assert found[1].force > 6.0 * found[0].force
    assert [each.complete for each in found] == [False, True]


def test_tables_sweeps_and_scatters_use_the_same_run(early):
    table = hc.simulate_many([early], keep=[PEAK])
    assert table.complete[0]
    assert table["body_peak_force"][0] == pytest.approx(200.340, abs=1e-3)
    nominal = hc.distribution(early, PEAK, hc.Scatter(radius=1e-9, samples=3), seed=1)
    assert np.median(nominal.values) == pytest.approx(200.340, abs=0.01)


@pytest.mark.parametrize("behind", [None, hc.Wall()])
@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_the_elastic_kernel_continues_until_no_larger_force_follows(behind):
    rng = np.random.default_rng(11)
    rows = []
    for _ in range(24):
        sizes = [f"{each:g} mm" for each in rng.choice([4.0, 5.0, 6.0, 10.0, 16.0], 8)]
        row = hc.Chain.from_materials(sizes, "steel-52100").with_cap(f"{rng.choice([2, 60])} g")
        row = row.struck_by(mass="200 g", velocity="0.1 m/s").replace(left_wall=behind)
        rows.append(row.replace(gaps=rng.choice([0.0, 1e-6], 9)) if rng.random() < 0.3 else row)
    assert all(is_covered(row, None) for row in rows)
    table = hc.simulate_many(rows, keep=[PEAK, "end_time"], rtol=1e-11)
    assert (table["end_time"] < 1.0).all()
    found = [body_force(hc.simulate(row, rtol=1e-12)) for row in rows]
    # Between the wall and the cap, the balls may return for a long time.
    assert table.complete.tolist() == [each.complete for each in found]
    assert table.complete.sum() >= (24 if behind is None else 12)
    assert table["body_peak_force"] == pytest.approx([each.force for each in found], rel=1e-9)
    assert sum(each.later for each in found) >= 4


def test_an_early_end_is_reported(early, path):
    with pytest.warns(hc.IncompleteWarning, match="a larger force may follow"):
        table = hc.simulate_many([early], keep=[PEAK], until=3e-4)
    assert not table.complete[0]
    assert not body_force(hc.simulate(early, until=3e-4)).complete
    with pytest.warns(hc.IncompleteWarning, match="not complete"):
        hc.gradient(early, PEAK, to="masses", until=3e-4)
    shown = simulated(path)
    assert "largest force on it so far" in shown
    assert "a larger force may follow" in shown
    document = json.loads(simulated(path, "--json"))
    assert document["last_bead_force"]["complete"] is False


@pytest.mark.parametrize("loss", [None, hc.Restitution(0.9), hc.ElasticPlastic()])
def test_no_larger_force_follows_in_random_rows(loss):
    rng = np.random.default_rng(7)
    later = 0
    for _ in range(8):
        sizes = rng.choice([4.0, 5.0, 6.0, 10.0, 16.0], 8)
        row = hc.Chain.from_materials([f"{each:g} mm" for each in sizes], "steel-52100")
        mass = f"{rng.choice([2, 20, 60])} g"
        row = row.with_cap(mass).struck_by(mass="200 g", velocity="0.1 m/s").replace(loss=loss)
        run = hc.simulate(row)
        found = body_force(run)
        assert found.complete
        longer = body_force(hc.simulate(row, until=10.0 * run.end_time))
        assert longer.complete
        assert longer.force == pytest.approx(found.force, rel=1e-5)
        later += found.later
    assert later


def test_precompression_has_no_proof():
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity="0.1 m/s")
    row = row.with_cap("20 g").replace(precompression="1 N", held_by="force")
    assert not body_force(hc.simulate(row)).complete


def test_the_least_energy_is_that_of_plastic_collisions():
    masses, velocities = np.array([1.0, 2.0, 3.0]), np.array([3.0, 0.0, 2.0])
    # Beads 1 and 2 stick together at velocity 1, and bead 3 is faster.
    assert least_energy(masses, np.cumsum(masses * velocities)) == pytest.approx(1.5 + 6.0)
