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
        ("beads = 3", "unknown table or key 'beads'"),
        ("", r"needs a table \[chain\]"),
        ("chain = 3", r"needs a table \[chain\]"),
        ('[chain]\ntapr = "uniform"\nbeads = 3', "unknown key .*'tapr'.* did you mean 'taper'"),
        ("[chain]\nbeads = 3", "has no taper"),
        ('[chain]\ntaper = "uniform"', "has no beads"),
        ('[chain]\ntaper = "uniform"\nbeads = 3\nrate = 0.1', "omit one"),
        ('[chain]\ntaper = "forward-linear"\nbeads = 3', "no rate"),
        (
            '[chain]\ntaper = "forward-linear"\nbeads = 3\nrate = "x"',
            "must be a number or a percentage",
        ),
        ("[chain]\nradii = [1, 2]\nbeads = 2", "has radii and also beads"),
        ("[chain]\nradii = [1, -2]", "bead 2 is -2"),
        ('[chain]\nradii = [1, "two"]', "value 2 of radii of .chain. must be a number.* got 'two'"),
        ("[chain]\nradii = 5", "at least two numbers, got 5"),
        ("[chain]\nradii = [true, true]", "value 1 of radii .* must be a number.* got True"),
        ('[chain]\ntaper = "unifrm"\nbeads = 2', "did you mean 'uniform'"),
        ('[chain]\ntaper = "forward-linear"\nbeads = 3\nrate = true', "must be a number"),
        ('[chain]\ntaper = "uniform"\nbeads = 2.5', "whole number"),
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
