"""Constants of the chain that a fit takes as exact, compared with fits to other constants."""

import dataclasses

import numpy as np
import pytest
from synthetic_traces import bench, measured

import hertzchain as hc


def test_changes_per_percent_of_a_constant_are_those_of_fits_with_another_one():
    """The same data are fitted with a wall or a density that differs by 0.25%."""
    stiffness = bench(beads=8, behind=3).wall_stiffness[1]
    true = bench(beads=8, behind=3).replace(right_wall=hc.Wall(stiffness=stiffness))
    traces = measured(true, np.random.default_rng(3), balls=(3, 6), duration=400e-6)
    free = ["materials[steel].young", "struck_by.velocity", "time_offset"]
    exact = hc.fit(traces, true, free=free)
    constants = {each.name: each for each in exact.constants}
    assert list(constants) == ["materials[steel].density", "right_wall.stiffness"]
    heavy = [dataclasses.replace(each, density=1.0025 * each.density) for each in true.materials]
    others = {
        "right_wall.stiffness": true.replace(right_wall=hc.Wall(stiffness=1.0025 * stiffness)),
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


def test_a_modulus_within_the_factor_of_all_contacts_is_not_mentioned():
    traces = measured(bench(beads=8, behind=3), np.random.default_rng(3), balls=(3,))
    result = hc.fit(traces, bench(beads=8, behind=3), free=["stiffness", "time_offset"])
    assert "materials[steel].young" not in [each.name for each in result.constants]
    assert any(note.startswith("materials[steel].density is") for note in result.warnings)
