"""Mass and radius of a striker as parameters of a fit."""

import math

import numpy as np
import pytest
from synthetic_traces import measured

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=12).replace(right_wall=hc.Wall())


def row(**striker):
    return BALLS.replace(velocities=None).struck_by(velocity=0.3, **striker)


@pytest.mark.long
@pytest.mark.parametrize(
    ("free", "true", "nominal", "value"),
    [
        ("struck_by.radius", {"radius": 5.3e-3}, {}, 5.3e-3),
        ("struck_by.mass", {"mass": 6e-3}, {"mass": 5e-3}, 6e-3),
        ("struck_by.mass", {"mass": 6e-3, "radius": math.inf},
         {"mass": 5e-3, "radius": math.inf}, 6e-3),
    ],
)  # fmt: skip
def test_mass_and_radius_of_a_striker_are_found(free, true, nominal, value):
    data = measured(row(**true), np.random.default_rng(3), balls=(4, 8), duration=350e-6)
    result = hc.fit(data, row(**nominal), free=["stiffness", free, "time_offset"])
    assert result.describes
    assert result.values[free] == pytest.approx(value, abs=4.0 * result.errors[free])
    assert result.errors[free] < 0.01 * value
    assert result.values["stiffness"] == pytest.approx(1.0, abs=4.0 * result.errors["stiffness"])


def test_a_flat_striker_has_no_radius_and_a_moving_ball_is_no_striker():
    data = measured(row(), np.random.default_rng(3), balls=(4, 8), duration=350e-6)
    for chain, free in (
        (row(mass=5e-3, radius=math.inf), "struck_by.radius"),
        (BALLS.replace(velocities=[0.3, *[0.0] * 11]), "struck_by.mass"),
    ):
        with pytest.raises(hc.InputError, match=f"unknown parameter '{free}'"):
            hc.fit(data, chain, free=[free, "time_offset"])
