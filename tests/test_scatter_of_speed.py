"""Random speeds of the impact: `Scatter(speed=...)` and `hertzchain scatter --speed-scatter`."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import hertzchain as hc
from hertzchain.cli import cli

ROW = hc.Chain.from_materials(
    "5 mm", "steel-52100", beads=6, velocity="0.05 m/s", right_wall=hc.Wall.of("steel-52100")
)
OPTIONS = [
    "scatter", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "6",
    "--speed", "0.05m/s", "--wall", "same",
]  # fmt: skip


def test_peaks_of_elastic_rows_are_proportional_to_a_power_of_the_speed():
    scatter = hc.Scatter(speed="3%", samples=30)
    speeds = np.array([each.velocities[0] for each in scatter.sample(ROW)]) / 0.05
    found = hc.distribution(ROW, "wall_force.peak", scatter)
    # Hertz's law without gaps or static forces has no scale of its own: F ~ v^(6/5).
    assert found.values / found.nominal == pytest.approx(speeds**1.2, rel=1e-5)
    assert np.log(speeds).std() == pytest.approx(0.03, rel=0.4)


def test_radii_and_gaps_do_not_depend_on_the_scatter_of_the_speed():
    others = {"radius": 0.01, "gaps": "5 um", "samples": 3}
    plain = hc.Scatter(**others).sample(ROW, seed=2)
    varied = hc.Scatter(**others, speed=0.02).sample(ROW, seed=2)
    for one, two in zip(plain, varied, strict=True):
        assert (one.radii == two.radii).all()
        assert (one.gaps == two.gaps).all()
        assert two.velocities[0] != 0.05
        assert not two.velocities[1:].any()


@pytest.mark.parametrize("value", [0.0, -0.1, 0.31, "5 mm", np.nan])
def test_other_scatters_of_the_speed_are_errors(value):
    with pytest.raises(hc.InputError, match="speed of a scatter"):
        hc.Scatter(speed=value)


def test_a_number_of_percent_is_recognised():
    with pytest.raises(hc.InputError, match="for a scatter of 2%, give '2%'"):
        hc.Scatter(speed=2)


def test_a_chain_at_rest_has_no_speed_that_could_vary():
    still = ROW.replace(velocities=np.zeros(6))
    with pytest.raises(hc.InputError, match="requires an impact, but the chain is at rest"):
        hc.distribution(still, "wall_force.peak", hc.Scatter(speed=0.02), until=1e-3)
    drive = hc.SineBurst(amplitude=1e-6, frequency=1e3, cycles=2)
    driven = still.replace(left_wall=hc.Wall.of("steel-52100"), drive=drive)
    with pytest.raises(hc.InputError, match="but the chain has a drive"):
        hc.Scatter(speed=0.02).sample(driven)


def test_the_command_prints_the_distribution_of_python():
    done = CliRunner().invoke(cli, [*OPTIONS, "--speed-scatter", "2%", "--chains", "5", "--json"])
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    given = {key: value for key, value in document["scatter"].items() if value is not None}
    assert given == {"speed": 0.02}
    found = hc.distribution(ROW, "wall_force.peak", hc.Scatter(speed=0.02, samples=5))
    assert document["values"] == pytest.approx(found.values.tolist(), rel=1e-6)


def test_the_title_of_the_figure_has_the_scatter_of_the_speed():
    assert hc.Scatter(radius=0.01, speed=0.02)._in_words("SI") == "1% scatter, speed +-2%"


def test_without_any_scatter_the_command_names_all_options():
    done = CliRunner().invoke(cli, OPTIONS)
    assert done.exit_code == 2
    assert "--speed-scatter, such as 2%" in done.output
