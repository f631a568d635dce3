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
