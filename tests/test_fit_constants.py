"""Constants that a fit takes as exact, compared with fits to other constants."""

import dataclasses

import numpy as np
import pytest
from synthetic_traces import bench, measured

import hertzchain as hc


def changed(traces, times=1.0, values=1.0):
    """Traces whose times or values are multiplied by a factor."""
    (shot,) = traces.shots
    columns = {f"{each.name} [{each.unit}]": values * each.values for each in shot.signals}
    return hc.Traces.from_arrays(times * shot.times, columns)


def test_changes_per_percent_of_a_constant_are_those_of_fits_with_another_one():
    """The same data are fitted with a wall or a density that differs by 0.25%."""
    stiffness = bench(beads=8, behind=3).wall_stiffness[1]
    true = bench(beads=8, behind=3).replace(right_wall=hc.Wall(stiffness=stiffness))
    traces = measured(true, np.random.default_rng(3), balls=(3, 6), duration=400e-6)
    free = ["materials[steel].young", "struck_by.velocity", "time_offset"]
    exact = hc.fit(traces, true, free=free)
    constants = {each.name: each for each in exact.constants}
    assert sorted(constants) == [
        "gain", "materials[steel].density", "right_wall.stiffness", "sampling interval"
    ]  # fmt: skip
    heavy = [dataclasses.replace(each, density=1.0025 * each.density) for each in true.materials]
    soft = true.replace(right_wall=hc.Wall(stiffness=1.0025 * stiffness))
    others = {
        "right_wall.stiffness": soft,
        "materials[steel].density": true.replace(materials=tuple(heavy)),
    }
    for name, other in others.items():
        refitted = hc.fit(traces, other, free=free)
        for key in free:
            moved = refitted.values[key] - exact.values[key]
            expected = 0.25 * constants[name].changes[key]
            assert moved == pytest.approx(expected, rel=0.05, abs=0.05 * exact.errors[key])
    assert any(note.startswith("right_wall.stiffness is taken as exact") for note in exact.warnings)
    more = hc.fit(
        traces, true, free=[*free, "right_wall.stiffness"],
        priors={"right_wall.stiffness": (stiffness, 0.04 * stiffness)},
    )  # fmt: skip
    assert "right_wall.stiffness" not in [each.name for each in more.constants]


@pytest.fixture(scope="module")
def capped():
    """Ten balls in front of the cap of a load cell, and their traces."""
    row = bench(hc.Viscoelastic("0.6 us"), beads=10, behind=3)
    row = row.replace(right_wall=hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic()))
    row = row.with_cap("5 g")
    return row, measured(row, np.random.default_rng(3), balls=(3, 6), duration=400e-6)


def test_the_mass_of_a_cap_is_a_constant_whose_changes_are_those_of_fits(capped):
    """The same data are fitted with a cap that is heavier by 0.25%."""
    row, traces = capped
    free = ["materials[steel].young", "loss.time", "time_offset"]
    exact = hc.fit(traces, row, free=free)
    (cap,) = [each for each in exact.constants if each.name == "cap.mass"]
    heavy = row.replace(cap=dataclasses.replace(row.cap, mass=1.0025 * row.cap.mass))
    refitted = hc.fit(traces, heavy, free=free)
    for key in free:
        moved = refitted.values[key] - exact.values[key]
        assert moved == pytest.approx(
            0.25 * cap.changes[key], rel=0.05, abs=0.05 * exact.errors[key]
        )
    planned = hc.forecast(row, ["ball 3", "wall"], noise="0.1 N", interval="1 us", free=free)
    assert any(each.name == "cap.mass" for each in planned.constants)


@pytest.mark.parametrize("name", ["cap.mass", "mass[11]"])
def test_the_mass_of_a_cap_can_be_free_by_both_of_its_names(capped, name):
    row, traces = capped
    result = hc.fit(traces, row, free=["loss.time", "time_offset", name])
    assert result.values[name] == pytest.approx(5e-3, abs=4.0 * result.errors[name])
    assert "cap.mass" not in [each.name for each in result.constants]


def test_a_chain_without_a_cap_has_no_mass_of_a_cap():
    traces = measured(bench(beads=8, behind=3), np.random.default_rng(3), balls=(3,))
    with pytest.raises(hc.InputError, match=r"'cap\.mass'"):
        hc.fit(traces, bench(beads=8, behind=3), free=["cap.mass"])


@pytest.mark.long
def test_a_wrong_mass_of_a_cap_is_named_before_the_stiffness_of_the_cell(capped):
    row, traces = capped
    heavy = row.replace(cap=dataclasses.replace(row.cap, mass=1.05 * row.cap.mass))
    free = ["materials[steel].young", "loss.time", "time_offset"]
    result = hc.fit(traces, heavy, free=free)
    assert "with cap.mass = 0.00" in result.advice[0]
    assert "right_wall.stiffness" not in result.advice[0]
    soft = row.replace(right_wall=hc.Wall("45 kN/mm", exponent=1, loss=hc.Elastic()))
    assert "with right_wall.stiffness" in hc.fit(traces, soft, free=free).advice[0]


def test_changes_per_percent_of_gains_and_times_are_those_of_fits_to_other_data():
    """The forces of the data are divided, or their times multiplied, by 1.0025."""
    row = bench(beads=8, behind=3)
    traces = measured(row, np.random.default_rng(3), balls=(3, 6), duration=400e-6)
    free = ["stiffness", "struck_by.velocity", "time_offset"]
    exact = hc.fit(traces, row, free=free)
    constants = {each.name: each for each in exact.constants}
    others = {
        "gain": changed(traces, values=1.0 / 1.0025),
        "sampling interval": changed(traces, times=1.0025),
    }
    for name, other in others.items():
        refitted = hc.fit(other, row, free=free)
        for key in free:
            moved = refitted.values[key] - exact.values[key]
            expected = 0.25 * constants[name].changes[key]
            assert moved == pytest.approx(expected, rel=0.02, abs=0.02 * exact.errors[key])


def test_a_modulus_within_the_factor_of_all_contacts_is_not_mentioned():
    traces = measured(bench(beads=8, behind=3), np.random.default_rng(3), balls=(3,))
    result = hc.fit(traces, bench(beads=8, behind=3), free=["stiffness", "time_offset"])
    assert "materials[steel].young" not in [each.name for each in result.constants]
    assert any(note.startswith("materials[steel].density is") for note in result.warnings)


def test_a_common_gain_of_calibrated_sensors_is_named_and_can_be_free():
    """The error of the stiffness then contains that of the gain: its square is the sum of both."""
    row = bench(beads=8, behind=3)
    traces = measured(row, np.random.default_rng(3), balls=(3, 6), duration=400e-6)
    free, priors = ["stiffness", "time_offset"], {"gain": (1.0, 0.01)}
    exact = hc.fit(traces, row, free=free)
    (note,) = [
        each for each in exact.warnings if each.startswith("the gain of all sensors in N is")
    ]
    assert note.endswith("free 'gain' with a prior")
    assert any(each.startswith("the sampling interval is taken as") for each in exact.warnings)
    names = [each["name"] for each in exact.as_dict()["constants"]]
    assert {"gain", "sampling interval"} <= set(names)
    included = hc.fit(traces, row, free=[*free, "gain"], priors=priors)
    assert "gain" not in [each.name for each in included.constants]
    tight = hc.fit(traces, row, free=[*free, "gain"], priors={"gain": (1.0, 1e-5)})
    constant = next(each for each in exact.constants if each.name == "gain")
    assert tight.errors["stiffness"] == pytest.approx(exact.errors["stiffness"], rel=0.01)
    # Weighted with the error of the gain that remains, which the data reduce.
    expected = np.hypot(
        exact.errors["stiffness"], constant.changes["stiffness"] * included.errors["gain"] / 0.01
    )
    assert included.errors["stiffness"] == pytest.approx(expected, rel=0.05)


def test_gains_of_other_sensors_and_units_are_named_apart():
    row = bench(beads=8, behind=3)
    times = np.arange(0.0, 400e-6, 1e-6)
    run = hc.simulate(row, times=times)
    noise = 0.1 * np.random.default_rng(1).standard_normal((4, len(times)))
    columns = {
        "ball 2 [N]": run.sensor("ball 2"), "ball 3 [N]": run.sensor("ball 3"),
        "ball 4 [N]": run.sensor("ball 4"), "ball 5 velocity [m/s]": run.velocity("ball 5"),
    }  # fmt: skip
    sizes = np.array([[1.0], [1.0], [1.0], [0.01]])
    seen = dict(zip(columns, np.stack([*columns.values()]) + sizes * noise, strict=True))
    sigmas = {name.split(" [")[0]: 0.1 * size for name, (size,) in zip(seen, sizes, strict=True)}
    traces = hc.Traces.from_arrays(times, seen, noise=sigmas)
    result = hc.fit(traces, row, free=["stiffness", "gain[ball 4]"])
    labels = {each.name: each.label for each in result.constants}
    assert labels["gain[ball 2] and gain[ball 3]"] == "the gain of the other sensors in N"
    assert labels["gain[ball 5 velocity]"] == ""
    assert any(
        each.endswith("free gain[ball 2] and gain[ball 3] with priors") for each in result.warnings
    )
