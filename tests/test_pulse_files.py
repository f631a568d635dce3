"""Pulses that are read from netCDF files are the same pulses; other files are rejected."""

import csv

import numpy as np
import pytest
import xarray as xr

import hertzchain as hc

ROW = hc.Chain.from_materials("10 mm", "steel-52100", beads=6)
STRUCK = ROW.struck_by(velocity="0.2 m/s").replace(right_wall=hc.Wall())
PULSES = {
    "simulation": lambda: hc.simulate(STRUCK.replace(loss=hc.Viscoelastic(1e-6))).pulse(),
    "incomplete": lambda: hc.simulate(hc.Chain.uniform(9), until=3.0).pulse(),
    "theory": lambda: hc.local_rate(hc.Chain.tapered("forward-exponential", 0.05, beads=9)),
    "restitution": lambda: hc.bca(hc.Chain.uniform(4), restitution=0.9),
    "spread": lambda: hc.disorder(hc.Chain.uniform(12), scatter=0.01),
    "two beads": lambda: hc.bca(hc.Chain.uniform(2)),
}


@pytest.mark.parametrize("name", PULSES)
def test_a_pulse_is_read_back_bit_for_bit(name, tmp_path):
    pulse = PULSES[name]()
    pulse.save(tmp_path / "pulse.nc")
    again = hc.load_pulse(tmp_path / "pulse.nc")
    assert again == pulse
    assert (str(again), again.chain, again.notes) == (str(pulse), pulse.chain, pulse.notes)
    assert again.columns().keys() == pulse.columns().keys()
    for quantity, values in pulse.columns().items():
        np.testing.assert_array_equal(again.column(quantity), values, strict=True)


def test_files_of_pulses_are_read_by_other_programs(tmp_path):
    pulse = PULSES["simulation"]()
    pulse.save(tmp_path / "pulse.nc")
    with xr.open_dataset(tmp_path / "pulse.nc", engine="scipy") as dataset:
        np.testing.assert_array_equal(dataset.velocity, pulse.velocity)
        assert dataset.peak_force.attrs["units"] == "N"
        (tmp_path / "row.toml").write_text(dataset.attrs["chain_file"])
    assert hc.load_chain(tmp_path / "row.toml") == pulse.chain
    pulse.save(tmp_path / "pulse.csv")
    with (tmp_path / "pulse.csv").open() as file:
        rows = [*csv.DictReader(file)]
    np.testing.assert_array_equal([float(row["velocity"]) for row in rows], pulse.velocity)
    with pytest.raises(hc.InputError, match=r"is a CSV file, .*pulse\.save\('pulse\.nc'\)"):
        hc.load_pulse(tmp_path / "pulse.csv")


def changed(file, **changes):
    with xr.open_dataset(file, engine="scipy") as dataset:
        dataset.load()
    for name, value in changes.items():
        if name in dataset.variables:
            dataset[name] = value * dataset[name]
        else:
            dataset.attrs[name] = value
    dataset.to_netcdf(file, engine="scipy")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"velocity": 1.5}, "is damaged or was changed"),
        ({"mass": 2.0}, "is damaged or was changed"),
        ({"notes": "{}"}, "is damaged or was changed"),
        ({"notes": 3.0}, "is damaged or was changed"),
        ({"restitution": 0.5}, "is damaged or was changed"),
        ({"restitution": "high"}, "is damaged or was changed"),
        ({"chain_file": hc.chain_as_toml(hc.Chain.uniform(8))}, "is damaged or was changed"),
        ({"pulse_version": 2}, "with layout 2, but hertzchain .* reads layout 1"),
    ],
)
def test_changed_files_are_rejected(changes, words, tmp_path):
    file = tmp_path / "pulse.nc"
    PULSES["incomplete"]().save(file)
    changed(file, **changes)
    with pytest.raises(hc.InputError, match=words):
        hc.load_pulse(file)


def test_files_of_earlier_versions_are_read(tmp_path):
    pulse, file = PULSES["simulation"](), tmp_path / "pulse.nc"
    pulse.save(file)
    changed(file, hertzchain_version="0.0.9")
    assert hc.load_pulse(file) == pulse


def test_other_files_are_rejected(tmp_path):
    pulse, file = PULSES["theory"](), tmp_path / "pulse.nc"
    with pytest.raises(hc.InputError, match="No such file"):
        hc.load_pulse(file)
    with pytest.raises(hc.InputError, match=r"must end in \.nc or \.csv, got 'pulse\.txt'"):
        pulse.save(tmp_path / "pulse.txt")
    hc.simulate(STRUCK, times=20).save(tmp_path / "run.nc")
    with pytest.raises(hc.InputError, match=r"read it with load_run\(.*\)\.pulse\(\)"):
        hc.load_pulse(tmp_path / "run.nc")
    pulse.save(file)
    with pytest.raises(hc.InputError, match=r"read it with load_pulse\('"):
        hc.load_run(file)
    content = file.read_bytes()
    for part in (b"", b"text", content[:200], content[: len(content) // 2]):
        file.write_bytes(part)
        with pytest.raises(hc.InputError, match="damaged"):
            hc.load_pulse(file)


def test_pulses_of_chains_without_a_file_are_saved_but_not_read(tmp_path):
    custom = hc.Pulse(hc.Chain.uniform(3), "own", velocity=np.ones(3))
    custom.save(tmp_path / "own.nc")
    assert hc.load_pulse(tmp_path / "own.nc") == custom


def test_chains_have_a_table_of_their_beads():
    row = hc.Chain.from_materials(
        diameters=["10 mm", "8 mm"], materials=["steel-52100", "brass"], gaps="2 um",
        right_wall=hc.Wall(gap="3 um"),
    ).struck_by(mass="5 g", radius="inf", velocity="0.1 m/s")  # fmt: skip
    table = row.to_dataframe()
    assert [*table.index] == [1, 2, 3]
    assert [*table.name] == ["striker", "ball 1", "ball 2"]
    assert [*table.material[1:]] == ["steel-52100", "brass"]
    np.testing.assert_array_equal(table.diameter, [np.nan, 0.01, 0.008])
    np.testing.assert_array_equal(table.mass, row.masses)
    np.testing.assert_allclose(np.diff(table.position)[1], 0.009 + 2e-6)
    np.testing.assert_allclose(table.gap, [0.0, 2e-6, 3e-6])
    assert table.velocity.iloc[0] == 0.1
    assert table.attrs["units"] == {
        "radius": "m", "diameter": "m", "mass": "kg", "position": "m", "gap": "m",
        "velocity": "m/s",
    }  # fmt: skip
    scaled = hc.Chain.uniform(3).to_dataframe()
    assert "material" not in scaled
    assert {*scaled.attrs["units"].values()} == {"1"}
    assert np.isnan(scaled.gap.iloc[-1])
    np.testing.assert_array_equal(scaled.position, [1.0, 3.0, 5.0])
