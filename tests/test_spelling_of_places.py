"""Spellings of the places of sensors, in headers, arguments and on the command line."""

import numpy as np
import pytest
from scipy_row import FREE, chain, recorded

import hertzchain as hc
from hertzchain.chain.bead_names import bead_number, with_bead_numbers
from hertzchain.traces.places import place_named


@pytest.mark.parametrize("name", ["ball6", "Ball 6", "BALL_6", "ball-6", "ball#6", " ball  6 "])
def test_unambiguous_spellings_are_accepted(name):
    row = hc.Chain.uniform(9).struck_by()
    assert place_named(name).name == "ball 6"
    assert bead_number(row, name) == 7
    assert with_bead_numbers(row, f"velocity@{name.strip()}") == "velocity@7"
    assert place_named(f"{name}_velocity").name == "ball 6 velocity"


def test_walls_are_spelled_as_arguments():
    assert place_named("right_wall").body == "right"
    run = hc.simulate(hc.Chain.uniform(5).replace(right_wall=hc.Wall()), until=9.0, times=200)
    with pytest.raises(hc.InputError, match="force in a bead"):
        run.sensor_force("right_wall")


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("bal 6", "'ball 6'"),
        ("ball no. 6", "'ball 6'"),
        ("beda 12", "'bead 12'"),
        ("ball 3 velocty", "'ball 3 velocity'"),
        ("rightwall", "'right wall'"),
        ("ball -6", "'ball 6'"),
    ],
)
def test_similar_names_are_suggested(name, meant):
    with pytest.raises(hc.InputError) as caught:
        place_named(name)
    assert f"(did you mean {meant}?)" in str(caught.value)


@pytest.mark.parametrize("name", ["ball", "CH1", "6", "load", "kugel 6"])
def test_other_names_have_no_suggestion(name):
    with pytest.raises(hc.InputError, match=r"^column '[^']*' does not name the place of its") as e:
        place_named(name)
    assert "did you mean" not in str(e.value)


@pytest.fixture(scope="module")
def scope(tmp_path_factory):
    """Traces with names of channels, and their chain file."""
    folder = tmp_path_factory.mktemp("scope")
    times, columns = recorded()
    rows = np.column_stack([1e6 * times, *columns.values()])
    np.savetxt(folder / "scope.csv", rows, fmt="%.7g", delimiter=",", comments="",
               header="time [us],CH1 [N],CH2 [N],CH3 [N]")  # fmt: skip
    (folder / "row.toml").write_text(hc.chain_as_toml(chain()))
    return folder / "scope.csv", folder / "row.toml"


def test_channels_on_the_command_line(run, scope):
    free = [word for name in FREE for word in ("--free", name)]
    sensors = ["--sensor", "CH1=ball5", "--sensor", "CH2=Ball_10", "--sensor", "CH3=wall"]
    code, out, _ = run("fit", *scope, *sensors, *free, "--noise", "ball5=0.1")
    assert code == 0
    assert "chi2 per sample: ball 5 0.96" in out


def test_a_misspelled_channel_on_the_command_line_is_answered_in_one_message(run, scope):
    code, _, err = run("fit", *scope, "--sensor", "CH1=bal5")
    assert code == 2
    assert "'bal5', given for column 'CH1', does not name the place of a sensor" in err
    assert "(did you mean 'ball 5'?)" in err
    assert len(err.strip().splitlines()) == 1
