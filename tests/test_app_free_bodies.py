"""The force on a free body behind the row, in the messages of `hertzchain app`."""

import json
import tomllib

import numpy as np
import pytest
from app_client import computed
from click.testing import CliRunner
from test_complete_body_force import EARLY

import hertzchain as hc
from hertzchain.app.about import about
from hertzchain.app.documents import chain_of
from hertzchain.app.exports import export
from hertzchain.cli import cli

BOX = {
    "diameters": "12 mm", "beads": 10, "materials": "steel-52100", "cap": {"mass": "40 g"},
    "struck_by": [{"mass": "50 g", "radius": "inf", "velocity": "1.5 m/s"}],
}  # fmt: skip


def document(**changes):
    return {"chain": {**BOX, **changes}}


def test_the_force_on_a_free_body_is_shown_with_its_acceleration_and_yield():
    header, arrays = computed(document())["run"]
    found = header["peaks"]["body"]
    # SciPy's DOP853 with Hertz's law: 1934.40 N after 166.0 us, for 35.05 us.
    largest, first, fully = found["shown"]
    assert largest[:2] == ["largest force in this run", pytest.approx(1934.4, rel=1e-4)]
    assert largest[2] == pytest.approx(166.0e-6, abs=0.1e-6)
    (_, acceleration, _), (_, in_g0, _), (_, duration, unit) = found["impact"]
    assert acceleration == pytest.approx(largest[1] / 40e-3)
    assert in_g0 == pytest.approx(acceleration / 9.80665)
    assert (duration, unit) == (pytest.approx(35.05, abs=0.15), "µs")
    # A solution with Thornton's law: 862.44 N at 1.6 Y, 1771.3 N at 2.8 Y.
    assert first == ["peak if contacts yield at 1.6 Y", pytest.approx(862.44, rel=1e-3), None]
    assert fully == ["at 2.8 Y", pytest.approx(1771.3, rel=1e-3), None]
    assert found["yielding"] == first[1]
    curve = np.array(arrays["force.body"])
    assert curve.max() == pytest.approx(1934.4, rel=1e-3)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_the_page_and_the_command_show_the_same_later_pulse(tmp_path):
    path = tmp_path / "early.toml"
    path.write_text(EARLY, encoding="utf-8")
    early = tomllib.loads(EARLY)["chain"]
    header, arrays = computed({"chain": early})["run"]
    largest = header["peaks"]["body"]["shown"][0]
    # SciPy's DOP853: 200.34 N; the pulse has left after 160.5 N.
    assert largest[:2] == ["largest force in this run", pytest.approx(200.34, abs=0.01)]
    assert arrays["force.body"].max() == pytest.approx(200.34, rel=5e-3)
    command = CliRunner().invoke(cli, ["simulate", str(path), "--json"], standalone_mode=False)
    shown = json.loads(command.stdout)
    assert shown["last_bead_force"]["complete"]
    assert largest[1] == pytest.approx(shown["last_bead_force"]["force"], rel=1e-6)
    assert arrays["times"][-1] > shown["last_bead_force"]["force_time"]
    figure = export({"kind": "forces", "document": {"chain": early}}, lambda: False)
    lines = figure.content.decode().splitlines()
    assert max(float(line.split(",")[-1]) for line in lines[1:]) > 199.0


def test_a_sensor_in_the_cap_says_that_it_shows_half_of_the_force():
    peaks = computed(document(), sensors=[11])["run"][0]["peaks"]
    assert peaks["12"]["largest"] == pytest.approx(0.5 * peaks["body"]["shown"][0][1])
    assert peaks["12"]["remark"].endswith("the force on the body is twice this")
    # On a wall, both faces of the cap of a load cell have a force.
    wall = {"stiffness": "20 kN/mm", "exponent": 1}
    peaks = computed(document(right_wall=wall), sensors=[11])["run"][0]["peaks"]
    assert "remark" not in peaks["12"]
    assert "body" not in peaks


def test_a_yielding_row_has_the_force_at_the_largest_yield_pressure():
    plastic = document(loss={"law": "elastic-plastic"})
    found = computed(plastic)["run"][0]["peaks"]["body"]
    largest, first, other = found["shown"]
    assert largest[1] == pytest.approx(862.44, rel=1e-3)
    assert first == ["peak if contacts yield at 1.6 Y", largest[1], None]
    # The table of two chains has one row for each label.
    assert other == ["at 2.8 Y", pytest.approx(1771.3, rel=1e-3), None]
    assert found["yielding"] == largest[1]


def test_the_static_force_on_a_free_body_is_not_included():
    row = {name: value for name, value in BOX.items() if name != "struck_by"}
    pressed = {"chain": {**row, "velocity": "1 cm/s", "precompression": "1 N",
                         "held_by": "force"}}  # fmt: skip
    found = computed(pressed)["run"][0]["peaks"]["body"]
    run = hc.simulate(chain_of(pressed), times=4000)
    words = "largest force so far above the static force (a larger force may follow)"
    assert found["shown"][0][0] == words
    assert found["shown"][0][1] == pytest.approx(run.forces[:, -2].max() - 1.0, rel=1e-3)


def test_a_draft_and_scaled_variables_have_fewer_numbers():
    found = computed(document(), draft=True, frames=60)["run"][0]["peaks"]["body"]
    assert [each[0] for each in found["shown"]] == ["largest force so far"]
    scaled = {"chain": {"beads": 10, "taper": "uniform", "cap": {"mass": 4.0}}}
    found = computed(scaled)["run"][0]["peaks"]["body"]
    assert [each[0] for each in found["impact"]] == [
        "largest acceleration (force / mass, unfiltered)", "duration above 10% of it"
    ]  # fmt: skip


def test_the_page_adds_no_sensor_to_a_chain_with_a_free_body():
    assert about(document())["sensors"] == []
