import csv
import io
import json

import numpy as np
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.store import results


def chain_file(folder, text):
    path = folder / "chain.toml"
    path.write_text(text)
    return path


def test_chain_files(tmp_path):
    tapered = chain_file(
        tmp_path, '[chain]\ntaper = "forward-linear"\nrate = 1e-2\nbeads = 30\nexponent = 2\n'
    )
    chain = hc.load_chain(tapered)
    expected = hc.Chain.tapered("forward-linear", 0.01, beads=30, exponent=2.0)
    np.testing.assert_array_equal(chain.radii, expected.radii)
    assert (chain.exponent, chain.taper, chain.rate) == (2.0, "forward-linear", 0.01)
    free = hc.load_chain(chain_file(tmp_path, "[chain]\nradii = [2, 1.0, 4]\n"))
    np.testing.assert_array_equal(free.radii, [1.0, 0.5, 2.0])
    uniform = hc.load_chain(chain_file(tmp_path, '[chain]\ntaper = "uniform"\nbeads = 3\n'))
    np.testing.assert_array_equal(uniform.radii, [1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[chain", "is not valid TOML"),
        ("[chain]\ndiameters = 12 mm # all", 'needs quotation marks: diameters = "12 mm"$'),
        ("[chain]\ndiameters = [8 mm, 9 mm]", 'needs quotation marks: "8 mm"$'),
        ("[chain]\ncap = {mass = 1e3g}", 'needs quotation marks: mass = "1e3 g"$'),
        ("[chain]\nflat = yes", r"Invalid value .at line 2, column 8. in flat = yes; write true$"),
        ("[chain]\nflat = False # no", "in flat = False # no; write false$"),
        ("[chain]\nname = steel", r"column 8. in name = steel$"),
        ("[chain]\nradii = [1 2]", r"Unclosed array .at line 2, column 12.$"),
        ("beads = 3", "unknown table or key 'beads'"),
        ('title = "A"\n[chain]\ntaper = "uniform"\nbeads = 3', "only .* of sweeps have a title"),
        ("", r"needs a table \[chain\]"),
        ("chain = 3", r"needs a table \[chain\]"),
        ('[chain]\ntapr = "uniform"\nbeads = 3', "unknown key .*'tapr' .did you mean 'taper'"),
        ("[chain]\nbeads = 3", "has no taper"),
        ('[chain]\ntaper = "uniform"', "has no beads"),
        ('[chain]\ntaper = "uniform"\nbeads = 3\nrate = 0.1', "omit one"),
        ('[chain]\ntaper = "forward-linear"\nbeads = 3', "no rate"),
        (
            '[chain]\ntaper = "forward-linear"\nbeads = 3\nrate = "x"',
            "must be a number or a percentage",
        ),
        ("[chain]\nradii = [1, 2]\nbeads = 2", "has radii and also beads"),
        (
            '[chain]\ndiameters = "10 mm"\nbeads = 9',
            "materials is missing in .chain., which has diam",
        ),
        ("[chain]\nbeads = 3\nbeads = 3", "the same key is given twice .at"),
        ("[chain]\nradii = [1, -2]", "bead 2 is -2"),
        ('[chain]\nradii = [1, "two"]', "value 2 of radii of .chain. must be a number.* got 'two'"),
        ("[chain]\nradii = 5", "list of numbers, one for each bead, got 5"),
        ("[chain]\nradii = [true, true]", "value 1 of radii .* must be a number.* got True"),
        ('[chain]\ntaper = "unifrm"\nbeads = 2', "did you mean 'uniform'"),
        ('[chain]\ntaper = "forward-linear"\nbeads = 3\nrate = true', "must be a number"),
        ('[chain]\ntaper = "uniform"\nbeads = 2.5', "whole number"),
        ('[chain]\ntaper = "uniform"\nbeads = 3.0', "got 3.0 .*; write 3"),
    ],
)
def test_bad_chain_files_are_rejected_by_name(tmp_path, text, said):
    with pytest.raises(hc.InputError, match=said) as caught:
        hc.load_chain(chain_file(tmp_path, text))
    assert "chain.toml" in str(caught.value)


def test_unreadable_chain_files(tmp_path):
    with pytest.raises(hc.InputError, match=r"none\.toml.*No such file"):
        hc.load_chain(tmp_path / "none.toml")
    with pytest.raises(hc.InputError, match="directory"):
        hc.load_chain(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(hc.InputError, match="not UTF-8"):
        hc.load_chain(tmp_path / "binary.toml")


def test_pulses_as_json_and_csv():
    chain = hc.Chain.tapered("backward-linear", 0.1, beads=5)
    pulses = [hc.bca(chain), hc.modified_bca(chain)]
    document = json.loads(results.pulses_as_json(pulses))
    assert document["chain"]["radii"] == chain.radii.tolist()
    assert document["pulses"][0]["peak_force"] == pulses[0].peak_force.tolist()
    assert "arrival" not in document["pulses"][1]
    rows = list(csv.DictReader(io.StringIO(results.pulses_as_csv(pulses))))
    assert len(rows) == 10
    assert float(rows[4]["velocity"]) == pulses[0].velocity[4]
    assert rows[4]["residence"] == rows[5]["arrival"] == ""


def test_saved_runs_can_be_read_again(tmp_path):
    run = hc.simulate(hc.Chain.uniform(6), until=5.0, times=11)
    results.save_run(run, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="scipy") as dataset:
        np.testing.assert_array_equal(dataset.velocity.values, run.velocities)
        assert dataset.attrs["status"] == "time reached"
    results.save_run(run, tmp_path / "run.csv")
    table = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["velocity"], run.velocities.ravel(), rtol=1e-11)
    assert table["bead"][5] == 6
    np.testing.assert_allclose(table["force"], run.forces[:, 1:].ravel(), rtol=1e-11, atol=1e-300)


def test_csv_files_of_runs_have_units_and_the_force_on_a_left_wall(tmp_path):
    chain = hc.Chain.from_materials("10 mm", "steel-52100", beads=3, velocity="0.1 m/s")
    struck = chain.replace(velocities=[0.0, 0.0, -0.1], left_wall=hc.Wall())
    run = hc.simulate(struck, until=2e-4, times=200)
    run.save(tmp_path / "run.csv")
    header, *rows = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    assert header == ["time [s]", "bead", "position [m]", "velocity [m/s]", "force [N]"]
    walls = [row for row in rows if row[1] == "0"]
    assert {(row[2], row[3]) for row in walls} == {("", "")}
    forces = [float(row[4]) for row in walls]
    np.testing.assert_allclose(forces, run.wall_force("left").force, rtol=1e-11)
    assert max(forces) > 1.0


def test_saved_forces_are_traces(tmp_path):
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=20).struck_by(velocity="0.2 m/s")
    run = hc.simulate(chain.replace(right_wall=hc.Wall()), times=2000)
    run.save_forces(tmp_path / "forces.csv", ["ball 12", 1, "wall"])
    with pytest.raises(hc.InputError, match="cannot be estimated"):
        hc.load_traces(tmp_path / "forces.csv")
    traces = hc.load_traces(tmp_path / "forces.csv", sensors=["ball 12", "wall"])
    (shot,) = traces.shots
    np.testing.assert_allclose(shot.times, run.times, rtol=1e-11)
    for signal, expected in zip(shot.signals, (run.sensor(13), run.forces[:, -1]), strict=True):
        assert np.abs(signal.values - expected).max() < 1e-6 * run.forces[:, -1].max()
    assert max(run.compare(traces).differences.values()) < 1e-3
    run.save_forces(tmp_path / "wall.csv")
    assert (tmp_path / "wall.csv").read_text().startswith("time [us],wall [N]\n")


@pytest.mark.parametrize(
    ("sensors", "file", "said"),
    [
        (None, "a.csv", "the chain has no wall; give sensors"),
        ([3], "a.txt", "must end in .csv"),
        ([3, "bead 3"], "a.csv", "name 'bead 3' twice"),
        ([9], "a.csv", "from 1 to 5"),
    ],
)
def test_forces_that_cannot_be_saved(tmp_path, sensors, file, said):
    run = hc.simulate(hc.Chain.uniform(5), times=20)
    with pytest.raises(hc.InputError, match=said):
        run.save_forces(tmp_path / file, sensors)
    assert list(tmp_path.iterdir()) == []


def test_forces_of_walls_and_sensors_are_tables():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=6, velocity="0.2 m/s")
    run = hc.simulate(chain.replace(right_wall=hc.Wall()), times=300)
    for found in (run.wall_force(), run.sensor_force(4)):
        table = found.to_dataframe()
        np.testing.assert_array_equal(table["force"], found.force)
        np.testing.assert_array_equal(table.index, run.times)
        assert table.attrs["units"] == {"time": "s", "force": "N"}


def test_files_are_written_whole_or_not_at_all(tmp_path):
    run = hc.simulate(hc.Chain.uniform(3), until=1.0, times=5)
    with pytest.raises(hc.InputError, match=r"\.nc or \.csv"):
        results.save_run(run, tmp_path / "run.xlsx")
    with pytest.raises(hc.InputError, match="cannot write"):
        results.save_run(run, tmp_path / "missing" / "run.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_run_without_saved_times_is_not_written(tmp_path):
    with pytest.raises(hc.InputError, match="has no saved times"):
        results.save_run(hc.simulate(hc.Chain.uniform(3), times=0), tmp_path / "run.csv")


def test_a_byte_order_mark_is_read_over(tmp_path):
    path = tmp_path / "chain.toml"
    path.write_bytes(b"\xef\xbb\xbf[chain]\r\nradii = [1, 2]\r\n")
    assert hc.load_chain(path).beads == 2
