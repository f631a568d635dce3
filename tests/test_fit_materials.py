"""Fits of a modulus to forces that SciPy integrates, with walls of the same or another material.

All contacts are softer by the factor of `scipy_row`, and Hertz's stiffness is proportional to the
moduli, so the true modulus of each material is its nominal one times this factor.
"""

import dataclasses
import tomllib

import numpy as np
import pytest
from scipy_row import FACTOR, LOSS_TIME, VELOCITY, WALL_YOUNG, YOUNG, chain, traces

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
STEEL, WALL = "steel-52100", "steel-304"
TRUE = dataclasses.replace(hc.material(STEEL), young=FACTOR * YOUNG)
BALL = dataclasses.replace(TRUE, name="balls")


def struck(**fields):
    nominal = chain(**fields)
    return nominal.replace(velocities=nominal.velocities * VELOCITY / nominal.velocities.max())


def soft_row(**fields):
    """Balls with the true modulus in front of a wall of another steel."""
    row = struck(loss=None)
    return row.replace(
        **{"materials": [BALL] * row.beads, "loss": hc.Viscoelastic(LOSS_TIME)} | fields
    )


def deviation(data, nominal, name, true):
    """Deviation of a fitted modulus from the true one, in standard errors."""
    result = hc.fit(data, nominal, free=[name, "loss.time", "time_offset"])
    assert result.describes
    assert result.values["loss.time"] == pytest.approx(LOSS_TIME, rel=0.02)
    return (result.values[name] - true) / result.errors[name]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("wall", [hc.Wall(), hc.Wall.of(STEEL)], ids=["own", "named"])
def test_a_wall_of_the_same_material_follows_its_modulus(wall, seed):
    name = f"materials[{STEEL}].young"
    data = traces(seed, wall_young=YOUNG)
    assert abs(deviation(data, struck(right_wall=wall), name, TRUE.young)) < 3.0


@pytest.mark.long
def test_a_fitted_chain_has_one_material_for_balls_and_wall(tmp_path):
    name = f"materials[{STEEL}].young"
    data = traces(wall_young=YOUNG)
    result = hc.fit(data, struck(right_wall=hc.Wall.of(STEEL)), free=[name, "time_offset"])
    document = tomllib.loads(result.chain_toml())
    assert list(document["materials"]) == [STEEL]
    assert document["chain"]["right_wall"] == {"material": STEEL}
    (tmp_path / "fitted.toml").write_text(result.chain_toml())
    read = hc.load_chain(tmp_path / "fitted.toml")
    assert read.right_wall.material.young == read.materials[0].young
    assert read.materials[0].young == pytest.approx(result.values[name], rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_modulus_of_a_material_that_only_the_wall_has_can_be_free(seed):
    name = f"materials[{WALL}].young"
    assert abs(deviation(traces(seed), soft_row(), name, FACTOR * WALL_YOUNG)) < 3.0


def test_the_balls_and_the_constants_of_a_fit_of_the_wall():
    nominal = soft_row()
    result = hc.fit(traces(), nominal, free=[f"materials[{WALL}].young", "time_offset"])
    assert result.chain.materials == nominal.materials
    assert "right_wall.stiffness" not in [each.name for each in result.constants]


def test_laws_by_pairs_of_materials_follow_a_free_modulus():
    law, steel = hc.Viscoelastic(LOSS_TIME), hc.material(WALL)
    pairs = {(BALL, BALL): law, (BALL, steel): law}
    free = [f"materials[{WALL}].young", "time_offset"]
    one, several = (
        hc.fit(traces(), soft_row(loss=given), free=free).estimates for given in (law, pairs)
    )
    np.testing.assert_allclose(several, one, rtol=1e-9)


def test_the_density_of_a_wall_has_no_effect():
    with pytest.raises(hc.InputError, match=r"only a wall .* free 'materials\[steel-304\].young'"):
        hc.fit(traces(), struck(), free=[f"materials[{WALL}].density", "time_offset"])


def test_the_names_include_the_material_of_the_wall():
    with pytest.raises(hc.InputError, match=r"choose from steel-52100, steel-304$"):
        hc.fit(traces(), struck(), free=["materials[brass].young"])
    with pytest.raises(hc.InputError, match=r"materials\[steel-304\]\.poisson, radius"):
        hc.fit(traces(), struck(), free=["colour"])
