"""Names of balls, which do not count the strikers, are accepted where a bead is."""

import json

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.derivatives.names import KNOWN
from hertzchain.designs.measured import measured
from hertzchain.designs.measures import NAMES, parse_measure
from hertzchain.pulse.quantity_names import COLUMNS

ROW = hc.Chain.from_materials("10 mm", "steel-52100", beads=6).struck_by(velocity="0.2 m/s")
CHAIN = ROW.replace(right_wall=hc.Wall())


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_sensors_of_many_chains_have_names():
    keep = ["sensor_first_maximum", "sensor_largest_so_far"]
    named = hc.simulate_many([CHAIN, CHAIN], keep=keep, sensors=["ball 4", "bead 3"])
    assert named.sensors == (5, 3)
    numbered = hc.simulate_many([CHAIN], keep=keep, sensors=[5, 3])
    for name in keep:
        np.testing.assert_array_equal(named[name][0], numbered[name][0])
    longer = hc.Chain.from_materials("10 mm", "steel-52100", beads=9).struck_by(velocity=0.2)
    table = hc.simulate_many([CHAIN, longer], keep=keep, sensors=["ball 9"])
    assert table.sensors == (10,)
    assert [*table.reasons] == [0]


@pytest.mark.parametrize(
    ("chains", "sensor", "words"),
    [
        ([CHAIN], "ball 7", "there is no ball 7: the chain has 6 balls after its strikers"),
        ([CHAIN], "marble 2", r"'ball 6' \(without the strikers\) or 'bead 7' "),
        ([CHAIN], "0", "or a name such as 'ball 6'"),
        ([CHAIN.replace(right_wall=None).with_cap("2 g")], "piezo", "'bead 7' .*, or 'cap', got"),
        ([CHAIN, hc.Chain.from_materials("10 mm", "steel-52100", beads=6, velocity=0.2)],
         "ball 4", "different numbers of strikers"),
    ],
)  # fmt: skip
def test_wrong_names_of_sensors_are_explained(chains, sensor, words):
    with pytest.raises(hc.InputError, match=words):
        hc.simulate_many(chains, keep=["sensor_first_maximum"], sensors=[sensor])


def test_gradients_accept_names():
    numbered = hc.gradient(CHAIN, "velocity@5")
    for found in (hc.gradient(CHAIN, "velocity@ball 4"),
                  hc.gradient(CHAIN, "velocity", bead="ball 4")):  # fmt: skip
        assert found.quantity == numbered.quantity
        np.testing.assert_array_equal(found["radii"], numbered["radii"])


@pytest.mark.parametrize("command", ["scatter", "sensitivity"])
def test_quantities_of_commands_have_names(command, run, tmp_path):
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(CHAIN))
    more = ("--scatter", "1%", "--chains", "4") if command == "scatter" else ()
    texts = []
    for quantity in ("peak_force@ball 4", "peak_force@5"):
        code, out, err = run(command, tmp_path / "row.toml", "--quantity", quantity, *more,
                             "--json")  # fmt: skip
        assert code == 0, err
        texts.append(json.loads(out))
    if command == "scatter":
        assert [each.pop("quantity") for each in texts] == ["peak_force@ball 4", "peak_force@5"]
    assert texts[0] == texts[1]
    code, _, err = run(command, tmp_path / "row.toml", "--quantity", "velocity@ball 9", *more)
    assert code == 2
    assert "there is no ball 9: the chain has 6 balls after its strikers" in err


def test_plots_and_headings_of_sensitivities_name_balls(run, tmp_path):
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(CHAIN))
    code, out, err = run("sensitivity", tmp_path / "row.toml", "--quantity", "velocity@ball 4")
    assert code == 0, err
    assert "\nvelocity@ball 4 = " in out
    axes = hc.gradient(CHAIN, "velocity@ball 4").plot()
    plain = hc.gradient(hc.Chain.uniform(5), "velocity@4").plot()
    assert plain.get_ylabel() == "velocity of bead 4:\nchange [%] per 1% of the radius"
    words = "velocity of bead 5 (ball 4):\nchange [%] per 1% of the diameter"
    assert axes.get_ylabel() == words


@pytest.mark.long
@pytest.mark.parametrize("ball", [3, 6])
@pytest.mark.parametrize("wall", [None, hc.Wall()])
@pytest.mark.parametrize("loss", [None, hc.Restitution(0.95)])
def test_sensor_forces_are_those_of_a_run(ball, wall, loss):
    chain = ROW.replace(right_wall=wall, loss=loss)
    scatter = hc.Scatter(radius=0.01, samples=2)
    chains = [chain, *scatter.sample(chain)]
    for item, words in (
        ("first_maximum", "first maximum of the force"), ("largest", "largest force")
    ):  # fmt: skip
        found = hc.distribution(chain, f"sensor.{item}@ball {ball}", scatter)
        assert found.quantity == f"sensor.{item}@ball {ball}"
        assert found.unit == "N"
        assert found.label == f"{words} in the sensor of ball {ball}"
        for each, value in zip(chains, (found.nominal, *found.values), strict=True):
            run = hc.simulate(each, times=6001)
            sensor = run.sensor_force(ball + 1)
            expected = sensor.first_maximum if item == "first_maximum" else sensor.largest_so_far
            assert value == pytest.approx(expected, rel=1e-5, abs=sensor.error)


def test_a_design_limits_the_force_in_a_sensor():
    chain = ROW.replace(right_wall=hc.Wall())
    radii = hc.vary.radii("4 mm", "6 mm", beads="3:", by="common")
    name = "sensor.first_maximum@ball 6"
    start = hc.simulate_many([chain], keep=["sensor.first_maximum"], sensors=["ball 6"])
    limit = 0.9 * float(start["sensor_first_maximum"][0, 0])
    problem = hc.Design(
        chain, maximise="wall_force.impulse_of_impact", vary=[radii],
        subject_to={name: f"<= {limit} N"},
    )  # fmt: skip
    found = hc.design(problem, budget=60, seed=1)
    values = problem.evaluate(found.chain).values
    assert values[name] == found.values[name]
    assert f"{name} <= " in found.summary()
    assert values[name] <= limit * (1.0 + 1e-9)
    run = hc.simulate(found.chain, until=1e-3, times=6001).sensor_force("ball 6")
    assert values[name] == pytest.approx(run.first_maximum, rel=1e-6)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_last_beads_with_sensors_of_chains_of_several_lengths():
    chains = [ROW, hc.Chain.from_materials(5e-3, "brass", beads=6, velocity=0.1)]
    found = measured(chains, [parse_measure("sensor.first_maximum@last")])
    for chain, value in zip(chains, found.values[:, 0], strict=True):
        (expected,) = hc.simulate_many(
            [chain], keep=["sensor_first_maximum"], sensors=[chain.beads]
        )["sensor_first_maximum"][0]
        assert value == expected


@pytest.mark.parametrize(
    ("full", "column"),
    [("wall_force.peak", "wall_peak_force"), ("wall_force.duration", "wall_duration"),
     ("wall_force.impulse_of_impact", "wall_impulse_of_impact")],
)  # fmt: skip
def test_quantities_have_a_full_name_and_that_of_a_column(full, column):
    chain = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    tables = [hc.simulate_many([chain], keep=[name]) for name in (full, column)]
    values = [table[name][0] for table in tables for name in (full, column)]
    spec = {"chain": chain, "axes": {"beads": [8]}, "sweep": {"methods": ["simulate"]}}
    for name in (full, column):
        spec["sweep"]["keep"] = [name]
        values.append(hc.sweep({**spec, "chain": {"taper": "uniform", "right_wall": {}}})[column])
        values.append(hc.gradient(chain, name).value)
        values.append(hc.distribution(chain, name, hc.Scatter(radius=0.1, samples=2)).nominal)
        assert hc.gradient(chain, name).quantity == full
    np.testing.assert_allclose([float(np.ravel(each)[0]) for each in values], values[0], rtol=1e-6)


def test_names_of_gradients_are_those_of_the_table_of_quantities():
    for name in KNOWN:
        if name.startswith(("wall_force.", "sensor.", "final.", "pulse.")):
            assert name in COLUMNS or name == "wall_force.maxima"
    assert {name for name in NAMES if "." in name} <= {*COLUMNS}


def test_a_cap_is_not_a_ball():
    capped = ROW.with_cap("3 g")
    with pytest.raises(hc.InputError, match=r"6 balls and a cap .* number from 1 to 6, or 'cap'"):
        hc.simulate(capped, until="0.1 ms").sensor_force("ball 7")
