"""Force and acceleration of the last body of a free end as quantities of tables and commands."""

import json

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs.comparison import shown_chains
from hertzchain.plotting.run_overview import plot_run_and_forces
from hertzchain.simulation.body_force import body_force

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")

PEAK, ACCELERATION = "body_force.peak", "body_force.acceleration"
DURATION = "body_force.duration"


def box(mass="100 g", beads=6, **more):
    row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=beads)
    hammer = {"mass": "50 g", "radius": "flat", "velocity": "0.1 m/s"}
    return row.with_cap(mass).struck_by(**hammer).replace(**more)


def sampled(chain):
    """Largest force of the last contact among many samples."""
    return hc.simulate(chain, until="2 ms", times=50_001).force(chain.beads - 1).max()


def lasting(chain):
    """Time around the largest force of the last contact among many samples, above a tenth."""
    run = hc.simulate(chain, until="2 ms", times=50_001)
    force = run.force(chain.beads - 1)
    below, top = np.flatnonzero(force < 0.1 * force.max()), int(np.argmax(force))
    return run.times[below[below > top][0]] - run.times[below[below < top][-1]]


@pytest.fixture
def file(tmp_path):
    (tmp_path / "box.toml").write_text(hc.chain_as_toml(box()))
    return tmp_path / "box.toml"


@pytest.mark.parametrize("loss", [None, hc.Restitution(0.9), hc.ElasticPlastic()])
def test_tables_have_the_force_and_the_acceleration_of_the_body(loss):
    chains = [box(loss=loss), box("20 g", 4, loss=loss)]
    table = hc.simulate_many(chains, keep=[PEAK, "body_peak_time", ACCELERATION])
    for i, chain in enumerate(chains):
        force = sampled(chain)
        assert table["body_peak_force"][i] == pytest.approx(force, rel=1e-5)
        assert table["body_acceleration"][i] == pytest.approx(force / chain.masses[-1], rel=1e-5)
        found = body_force(hc.simulate(chain))
        assert table["body_peak_time"][i] == pytest.approx(found.time, abs=1e-8)
    dataset = table.to_xarray()
    assert dataset["body_acceleration"].attrs["units"] == "m/s^2"


@pytest.mark.parametrize("loss", [None, pytest.param(hc.Restitution(0.9), marks=pytest.mark.long)])
def test_the_duration_is_a_quantity_of_tables_scatters_and_designs(loss, run, file, tmp_path):
    chain = box(loss=loss)
    # The samples are 40 ns apart.
    expected = pytest.approx(lasting(chain), abs=1e-7)
    table = hc.simulate_many([chain], keep=[DURATION, PEAK])
    assert table["body_duration"][0] == expected
    assert table.to_xarray()["body_duration"].attrs["units"] == "s"
    same = hc.distribution(chain, DURATION, hc.Scatter(radius=1e-9, samples=2))
    assert np.median(same.values) == expected
    problem = hc.Design(
        chain, minimise=PEAK, vary=[hc.vary.radii("4 mm", "5 mm", beads="2:7")],
        subject_to={DURATION: "<= 0.15 ms", ACCELERATION: "<= 1000 m/s^2"},
    )  # fmt: skip
    found = hc.design(problem, budget=90)
    assert found.values[DURATION] == pytest.approx(lasting(found.chain), abs=1e-7)
    if loss is None:
        out = run(
            "scatter", file, "--scatter", "1%", "--chains", "3", "--quantity", DURATION
        ).stdout
        assert f"{1e6 * lasting(chain):.0f}"[:3] in out
        code, _, err = swept(run, tmp_path, f'["{DURATION}"]')
        assert code == 0, err
        kept = hc.open_sweep(tmp_path / "found.zarr")["body_duration"]
        assert float(kept[1, 0]) == pytest.approx(lasting(box(beads=4)), abs=1e-7)


def test_the_duration_has_no_gradient_and_no_value_before_it_is_over(run, file):
    with pytest.raises(hc.InputError, match=r"has no gradient.*use body_force\.peak"):
        hc.gradient(box(), DURATION, until=1e-3)
    code, _, err = run("sensitivity", file, "--quantity", DURATION)
    assert code == 2
    assert "has no derivatives" in err
    with pytest.warns(hc.IncompleteWarning, match="a larger force may follow"):
        table = hc.simulate_many([box()], keep=[PEAK, DURATION], until=1.8e-4)
    assert table["body_peak_force"][0] > 0.0
    assert np.isnan(table["body_duration"][0])


def test_a_chain_with_a_wall_has_no_body_and_an_early_end_no_value():
    walled = box().replace(right_wall=hc.Wall("5 kN/mm", exponent=1))
    with pytest.warns(hc.IncompleteWarning, match="use wall_force.peak"):
        hc.simulate_many([box(), walled], keep=[PEAK])
    for loss in (None, hc.Restitution(0.9)):
        table = hc.simulate_many([box(loss=loss)], keep=[PEAK], until=1e-4)
        assert np.isnan(table["body_peak_force"][0])
    with pytest.raises(hc.InputError, match=r"wall: use wall_force\.peak"):
        hc.distribution(walled, PEAK, hc.Scatter(radius=0.01))
    with pytest.raises(hc.InputError, match=r"wall: use wall_force\.peak"):
        hc.gradient(walled, PEAK, until=1e-3)
    with pytest.raises(hc.InputError, match=r"last body is body_force\.peak"):
        hc.distribution(box(), "wall_force.peak", hc.Scatter(radius=0.01))


def test_a_precompressed_row_excludes_the_static_force():
    row = hc.Chain.uniform(6).replace(precompression=0.05, held_by="force")
    with pytest.warns(hc.IncompleteWarning, match="the force on the last body is complete"):
        table = hc.simulate_many([row], keep=[PEAK], until=20.0)
    net = hc.simulate(row, until=20.0, times=20_001).force(5).max() - 0.05
    assert table["body_peak_force"][0] == pytest.approx(net, rel=1e-6)
    with pytest.raises(hc.InputError, match="under a static force"):
        hc.gradient(row, PEAK, until=20.0)


@pytest.mark.parametrize("name", [PEAK, ACCELERATION])
def test_gradients_are_differences(name):
    chain, end, step = box(), 4e-4, 1e-5
    column = {PEAK: "body_peak_force", ACCELERATION: "body_acceleration"}[name]
    found = hc.gradient(chain, name, to=("radii", "masses"), until=end)
    for field, place in (("masses", 0), ("masses", -1), ("radii", 3)):
        changed = []
        for factor in (1.0 + step, 1.0 - step):
            values = np.array(getattr(chain, field))
            values[place] *= factor
            changed.append(chain.replace(**{field: values}))
        high, low = hc.simulate_many(changed, keep=[name], until=end, rtol=1e-12)[column]
        own = getattr(chain, field)[place]
        assert found[field][place] == pytest.approx((high - low) / (2.0 * step * own), rel=1e-5)
    assert found.unit == ("N" if name == PEAK else "m/s^2")


def test_scatter_of_a_chain_with_a_free_cap_is_that_of_the_force(run, file):
    out = run("scatter", file, "--scatter", "1%", "--chains", "10", "--json").stdout
    document = json.loads(out)
    assert document["quantity"] == PEAK
    assert document["nominal"] == pytest.approx(sampled(box()), rel=1e-5)
    out = run("scatter", file, "--scatter", "1%", "--chains", "10", "--quantity", ACCELERATION)
    assert f"{sampled(box()) / 0.1:.0f}"[:3] in out.stdout
    assert "m/s^2" in out.stdout


def test_sensitivity_is_that_of_the_force_on_the_body(run, file):
    out = run("sensitivity", file).stdout
    assert f"body_force.peak = {sampled(box()):.4g} N" in out
    assert "% for +1%" in out
    document = json.loads(run("sensitivity", file, "--to", "masses", "--json").stdout)
    masses = box().masses.copy()
    masses[-1] *= 1.01
    change = sampled(box().replace(masses=masses)) / sampled(box()) - 1.0
    assert document["change_if_larger"][-1] == pytest.approx(change, abs=1e-6)


@pytest.mark.parametrize("command", [("scatter", "--scatter", "1%", "--chains", "5"),
                                     ("sensitivity", "--until", "1ms")])  # fmt: skip
@pytest.mark.parametrize("place", ["cap", "3"])
def test_commands_say_that_a_sensor_in_a_cap_has_half_of_the_force(run, file, command, place):
    name, *options = command
    out = run(name, file, *options, "--quantity", f"sensor.largest@{place}").stdout
    words = "the free face has none: the force on the body is twice this (body_force.peak)"
    assert (words in out) == (place == "cap")


SWEEP = """
[chain]
diameters = "10 mm"
beads = 4
materials = "steel-52100"
cap = {mass = "100 g"}

[[chain.struck_by]]
mass = "50 g"
radius = inf
velocity = "0.1 m/s"

[axes]
diameters = ["8 mm", "10 mm"]

[sweep]
methods = ["simulate"]
keep = KEEP
"""


def swept(run, folder, keep):
    (folder / "sweep.toml").write_text(SWEEP.replace("KEEP", keep))
    return run("sweep", folder / "sweep.toml", "--store", folder / "found.zarr")


def test_sweeps_keep_the_force_on_a_body_and_sensors_in_caps(run, tmp_path):
    code, out, err = swept(run, tmp_path, '["body_force.peak", "sensor.largest@cap"]')
    assert code == 0, err
    found = hc.open_sweep(tmp_path / "found.zarr")
    force, half = found["body_peak_force"], found["sensor_largest_so_far_cap"]
    np.testing.assert_allclose(force, 2.0 * half, rtol=1e-5)
    assert float(force[1, 0]) == pytest.approx(sampled(box(beads=4)), rel=1e-5)
    assert "note: sensor.largest@cap: mean of the forces on both faces" in out
    label = hc.plotting.plot_sweep(found, "sensor_largest_so_far_cap").get_ylabel()
    assert "(half of that on the body)" in " ".join(label.split())


def test_sweeps_name_the_places_that_exist(run, tmp_path):
    code, _, err = swept(run, tmp_path, '["sensor.largest@top"]')
    assert code == 2
    words = "write sensor.largest@5, 'sensor.largest@ball 4', sensor.largest@last or, with a cap,"
    assert words in " ".join(err.split())
    walled = SWEEP.replace("[[chain", 'right_wall = {stiffness = "5 kN/mm", exponent = 1}\n[[chain')
    (tmp_path / "walled.toml").write_text(walled.replace("KEEP", '["body_force.peak"]'))
    code, _, err = run("sweep", tmp_path / "walled.toml", "--store", tmp_path / "walled.zarr")
    assert code == 2
    assert "use wall_force.peak" in " ".join(err.split())


def test_designs_minimise_the_force_on_the_body():
    problem = hc.Design(
        box(beads=4), minimise=PEAK, vary=[hc.vary.radii("3 mm", "6 mm", beads="2:5")],
        subject_to={ACCELERATION: "<= 100000 m/s^2"},
    )  # fmt: skip
    found = hc.design(problem, budget=120)
    assert found.values[PEAK] == pytest.approx(sampled(found.chain), rel=1e-4)
    assert found.values[PEAK] < sampled(box(beads=4))
    assert found.values[ACCELERATION] == pytest.approx(10.0 * found.values[PEAK], rel=1e-6)


def test_figures_show_the_whole_force_on_a_cap(run, tmp_path):
    for name, mass in (("heavy", "100 g"), ("light", "20 g")):
        (tmp_path / f"{name}.toml").write_text(hc.chain_as_toml(box(mass)))
    files = [tmp_path / "heavy.toml", tmp_path / "light.toml"]
    for options in ((), ("--sensor", "cap")):
        target = tmp_path / "forces.svg"
        code, _, err = run("simulate", *files, *options, "--plot", target)
        assert code == 0, err
        drawn = target.read_text()
        assert "force on the cap" in drawn
        assert "half of the force" not in drawn
    found = hc.simulate(box(), times=101)
    axes = found.plot_forces(["body"])
    assert axes.lines[0].get_ydata().max() == pytest.approx(sampled(box()), rel=1e-6)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["force on the cap"]
    axes = found.plot_forces([8])
    assert axes.lines[0].get_ydata().max() == pytest.approx(0.5 * sampled(box()), rel=1e-3)
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words == ["bead 8 (cap), half of the force on it"]
    walled = hc.simulate(box().replace(right_wall=hc.Wall("5 kN/mm", exponent=1)))
    with pytest.raises(hc.InputError, match="use 'wall'"):
        walled.plot_forces(["body"])


@pytest.mark.parametrize("objective", [PEAK, "sensor.largest@last", "velocity@last"])
def test_the_figure_of_a_design_shows_the_force_on_the_cap_that_is_its_objective(objective):
    problem = hc.Design(
        box(beads=4), minimise=objective, vary=[hc.vary.radii("3 mm", "6 mm", beads="2:5")]
    )
    found = hc.design(problem, budget=90)
    axes = found.plot("forces")
    force = max(line.get_ydata().max() for line in axes.lines if len(line.get_ydata()) > 2)
    if objective == "velocity@last":
        assert "velocity" in axes.get_ylabel()
        return
    assert axes.get_ylabel().split() == ["force", "on", "the", "cap", "[N]"]
    chains = [each.chain for each in shown_chains(found).values()]
    assert force == pytest.approx(max(map(sampled, chains)), rel=1e-3)


def test_the_labels_of_a_design_say_that_a_sensor_in_the_cap_has_half_of_the_force():
    problem = hc.Design(
        box(beads=4), minimise="sensor.largest@cap", until="1 ms",
        vary=[hc.vary.radii("3 mm", "6 mm", beads="2:5")],
    )  # fmt: skip
    found = hc.design(problem, budget=90)
    for kind in ("history", "sensitivity"):
        assert "(half of that on the body)" in " ".join(found.plot(kind).get_ylabel().split())


def test_the_figure_of_one_chain_has_the_force_on_the_cap_above_the_map(run, file, tmp_path):
    code, _, err = run("simulate", file, "--plot", tmp_path / "one.svg")
    assert code == 0, err
    drawn = (tmp_path / "one.svg").read_text()
    assert "force on the cap" in drawn
    assert "velocity [m/s]" in drawn
    found = hc.simulate(box(), times=101)
    upper = plot_run_and_forces(found, ["body"])
    lower = upper.figure.axes[1]
    assert upper.get_xlim() == lower.get_xlim()
    assert upper.lines[0].get_ydata().max() == pytest.approx(sampled(box()), rel=1e-6)
    early = hc.simulate(box(), until=2e-4, times=401).plot_forces(["body"])
    assert "a larger force may follow" in early.get_legend().get_texts()[0].get_text()


def test_a_time_axis_shows_the_times_at_which_forces_act():
    run = hc.simulate(box("20 g"), until="5 ms", times=8001)
    axes = run.plot_forces(["body"])
    force, limits = run.force(7), axes.get_xlim()
    last = run.times[np.flatnonzero(force > 0.02 * force.max())[-1]]
    assert limits[0] == 0.0
    assert 1e3 * last < limits[1] < 1.3e3 * last
    # A later curve of a longer impact is not cut.
    hc.simulate(box("2 kg", 20), until="5 ms", times=2001).plot_forces(["body"], ax=axes)
    shown = [line.get_xdata()[line.get_ydata() > 1.0].max() for line in axes.lines]
    assert max(shown) < axes.get_xlim()[1]


@pytest.mark.long
def test_a_front_shows_the_initial_chain_and_the_one_to_compare():
    problem = hc.Design(
        box(beads=4), minimise=[PEAK, "length"], until="1 ms",
        vary=[hc.vary.radii("3 mm", "8 mm", beads="2:5")],
    )  # fmt: skip
    found = hc.design(problem, budget=400, points=4)
    axes = found.plot("front")
    named = {line.get_label().partition(":")[0]: line for line in axes.lines}
    line = named["given chain"]
    values = found._initial.values
    if len(line.get_xdata()):
        assert line.get_ydata()[0] == pytest.approx(values[PEAK])
        assert line.get_xdata()[0] == pytest.approx(1e3 * values["length"])
    else:
        assert f"{values[PEAK]:.4g} N" in line.get_label()
    assert {each.partition(":")[0] for each in shown_chains(found)} - {"design"} <= named.keys()


@pytest.mark.long
def test_the_sensitivity_to_the_yield_strength_is_that_of_simulations(run, tmp_path):
    chain = box(velocities=4.0 * box().velocities, loss=hc.ElasticPlastic())
    (tmp_path / "yields.toml").write_text(hc.chain_as_toml(chain))
    out = run("sensitivity", tmp_path / "yields.toml", "--to", "yield_strength").stdout
    # The factor multiplies the yield strengths of all beads, except that of the flat hammer.
    forces = [
        body_force(hc.simulate(chain.replace(loss=hc.ElasticPlastic(factor=each)))).force
        for each in (1.6 * 1.005, 1.6 * 0.995)
    ]
    change = 100.0 * (forces[0] / forces[1] - 1.0)
    stated = float(out.partition("all beads together: ")[2].partition("%")[0])
    assert stated == pytest.approx(change, rel=0.02)
    assert "--to yield_strength shows" not in out
    out = run("sensitivity", tmp_path / "yields.toml", "--to", "young").stdout
    assert "note: --to yield_strength shows the dependence on the yield pressure" in out
    (tmp_path / "elastic.toml").write_text(hc.chain_as_toml(box()))
    code, _, err = run("sensitivity", tmp_path / "elastic.toml", "--to", "yield_strength")
    assert code == 2
    assert "yield_strength changes only contacts that yield" in " ".join(err.split())
