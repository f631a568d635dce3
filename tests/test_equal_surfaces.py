"""The same numbers, remarks and names on the command line, in JSON and in the app."""

import json

import pytest
from app_client import computed

import hertzchain as hc
from hertzchain.recorded_warnings import ignore_warnings
from hertzchain.representation import in_bytes, in_column

COLUMN = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 12, "--wall", "same",
          "--gravity", "9.81 m/s^2")  # fmt: skip


def test_numbers_of_a_column_have_equal_digits():
    assert in_column([5.8, 5.837, float("nan")], 4) == ["5.800", "5.837", "-"]
    assert in_column([20.0, 17.5, -3.0], 4) == ["20.0", "17.5", "-3.00"]
    assert in_column([20.0, 10.0], 4) == ["20", "10"]
    assert in_column([3000.0, 1.234, 0.0], 4) == ["3000", "1.234", "0"]
    assert in_column([20000.0, 1.5, 1.25e-9], 4) == ["2e+04", "1.50", "1.25e-09"]
    assert in_column([], 4) == []


@pytest.mark.parametrize(
    ("size", "shown"),
    [(0, "0 bytes"), (999, "999 bytes"), (1.5e3, "1.5 kB"), (194e9, "194 GB"), (3e15, "3e+03 TB")],
)
def test_sizes_of_files_have_a_suitable_unit(size, shown):
    assert in_bytes(size) == shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("simulate", "--rtol", 3), "--rtol must be at least 1e-14 and at most 1e-06, got 3"),
        (("simulate", "--times", -4), "--times must be a whole number of at least 0, got -4"),
        (("simulate", "--precompression", "20 kg"), "--precompression has a unit ('20 kg')"),
        (("sweep", "x.toml", "--workers", 0), "--workers must be a whole number of at least 1"),
        (("sweep", "x.toml", "--shard", "0/2"), "--shard 0 of 2 does not exist"),
    ],
)  # fmt: skip
def test_messages_name_options_with_their_dashes(run, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    text = "[chain]\nbeads = 5\ntaper = 'backward-exponential'\n[axes]\nrate = [0.1]\n"
    (tmp_path / "x.toml").write_text(text)
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith(f"Error: {message}")


def test_a_value_of_a_chain_file_has_no_dashes(run, tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text("[chain]\nbeads = 5\ntaper = 'uniform'\nprecompression = -1\n")
    _, _, err = run("simulate", path, "--speed", 1)
    assert "precompression must" in err
    assert "--precompression" not in err


@pytest.mark.parametrize("quantity", ["wall_force.peak", "sensor.first_maximum@5"])
def test_sensitivity_and_scatter_under_gravity_end_alike(run, quantity):
    chain = (*COLUMN, "--speed", "0.1 m/s", "--quantity", quantity, "--json")
    code, out, _ = run("sensitivity", *chain)
    assert code == 0
    nominal = json.loads(run("scatter", *chain, "--scatter", "1%", "--chains", 2)[1])["nominal"]
    assert json.loads(out)["value"] == pytest.approx(nominal, rel=1e-6)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_peaks_so_far_with_contacts_that_yield_are_marked_everywhere(run):
    chain = (*COLUMN, "--speed", "1 m/s")
    text = run("simulate", *chain)[1]
    found = json.loads(run("simulate", *chain, "--json")[1])
    low, high = found["peak_range_with_yielding_contacts"]
    assert found["yielding_proven"] is False
    assert f"peak so far with contacts that yield: {low:.5g} N" in text
    row = {"diameters": "10 mm", "beads": 12, "materials": "steel-52100", "right_wall": {},
           "velocity": "1 m/s", "gravity": "9.81 m/s^2"}  # fmt: skip
    with ignore_warnings():
        peaks = computed({"chain": row})["run"][0]["peaks"]["right"]
    assert peaks["shown"][1:] == [
        ["peak if contacts yield at 1.6 Y (so far)", pytest.approx(low, rel=1e-5), None],
        ["at 2.8 Y (so far)", pytest.approx(high, rel=1e-5), None],
    ]
    assert peaks["yielding"] == peaks["shown"][1][1]


@pytest.mark.parametrize("more", [(), ("--quantity", "peak_force", "--method", "bca")])
def test_tables_state_static_forces(run, more):
    chain = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 6, "--wall", "same",
             "--speed", "0.1 m/s", "--gravity", "9.81 m/s^2")  # fmt: skip
    table = run("pulse", *chain, "--method", "simulate")[1]
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=6, right_wall=hc.Wall())
    at_rest = row.replace(gravity="9.81 m/s^2").static_state.forces
    assert f"includes the static force, {at_rest[1]:.4g} N to {at_rest[-2]:.4g} N" in table
    assert "static" not in run("pulse", *chain[:6], "--speed", "0.1 m/s", *more)[1]
