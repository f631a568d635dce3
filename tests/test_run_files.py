"""Runs that are read from netCDF files are the same runs, and the files describe their chain."""

import json
import warnings
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.store import stored_runs, streaming
from hertzchain.store.manifest import Manifest
from hertzchain.validation import memory

STRUCK = hc.Chain.from_materials("10 mm", "steel-52100", beads=6).struck_by(velocity="0.2 m/s")
CHAINS = {
    "default": hc.Chain.tapered("forward-exponential", 0.05, beads=9),
    "walls and loss": STRUCK.replace(right_wall=hc.Wall(), loss=hc.Viscoelastic(1e-6)),
    "given radii": hc.Chain.from_radii([1.0, 0.3, 0.7, 1.0]).replace(left_wall=hc.Wall()),
    "loss per contact": STRUCK.replace(
        loss=[hc.Restitution(0.9), None, *[hc.Dashpot(2.0)] * 4]
    ),
    "driven": hc.Chain.uniform(6).replace(
        drive=hc.SineBurst(0.3, 0.1, cycles=2.0), right_wall=hc.Wall(), gravity=0.01
    ),
}  # fmt: skip


def same(one, other):
    np.testing.assert_array_equal(one, other, strict=True)


@pytest.mark.parametrize("name", CHAINS)
def test_a_run_is_read_back_bit_for_bit(name, tmp_path):
    chain = CHAINS[name]
    run = hc.simulate(chain, times=50)
    run.save(tmp_path / "run.nc")
    again = hc.load_run(tmp_path / "run.nc")
    for field in ("times", "positions", "velocities", "forces", "largest_overlaps"):
        same(getattr(again, field), getattr(run, field))
    same(again.pulse().velocity, run.pulse().velocity)
    same(again.pulse().arrival, run.pulse().arrival)
    assert again.message == run.message
    assert repr(again) == repr(run)
    assert str(again.budget()) == str(run.budget())
    if chain.right_wall is not None:
        one, other = again.wall_force(), run.wall_force()
        assert str(one) == str(other)
    end = 1.5 * run.end_time
    later, whole = (hc.simulate(each.chain, start=each.state, until=end) for each in (again, run))
    same(later.velocities, whole.velocities)


def test_files_of_runs_contain_the_chain(tmp_path, run):
    chain = CHAINS["walls and loss"]
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain))
    code, out, err = run("simulate", tmp_path / "row.toml", "--out", tmp_path / "run.nc", "--json")
    assert code == 0, err
    with xr.open_dataset(tmp_path / "run.nc", engine="scipy") as dataset:
        text = dataset.attrs["chain_file"]
        assert {"position", "velocity", "force"} < {*dataset.data_vars}
    (tmp_path / "again.toml").write_text(text)
    read = hc.load_chain(tmp_path / "again.toml")
    same(read.contact_stiffness, chain.contact_stiffness)
    assert read.loss == chain.loss
    assert json.loads(out)["end_time"] == hc.load_run(tmp_path / "run.nc").end_time


def test_a_stored_run_is_compared_with_traces(tmp_path):
    traces, chain_file = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain_file), until=6e-4, times=1201)
    run.save(tmp_path / "run.nc")
    assert str(hc.load_run(tmp_path / "run.nc").compare(traces)) == str(run.compare(traces))


def test_streams_contain_the_chain(tmp_path):
    chain = CHAINS["walls and loss"]
    stored = hc.stream(chain, tmp_path / "long", times=np.linspace(0.0, 1e-4, 20))
    same(stored.chain.contact_stiffness, chain.contact_stiffness)
    assert stored.chain.loss == chain.loss
    assert stored.load().attrs["chain_file"] == hc.chain_as_toml(chain)
    with pytest.raises(hc.InputError, match=r"is not a file of Run\.save; .* load_run\(FOLDER\)"):
        hc.load_run(tmp_path / "long" / "part-000001.nc")


def assert_same_run(found, expected):
    for field in ("times", "positions", "velocities", "forces", "largest_overlaps"):
        same(getattr(found, field), getattr(expected, field))
    assert repr(found) == repr(expected)
    assert found.message == expected.message
    assert str(found.budget()) == str(expected.budget())
    same(found.pulse().velocity, expected.pulse().velocity)
    if found.chain.right_wall is not None:
        assert str(found.wall_force()) == str(expected.wall_force())


@pytest.mark.parametrize("name", CHAINS)
def test_streamed_runs_are_those_of_simulate(name, tmp_path, monkeypatch):
    monkeypatch.setattr(streaming, "FIRST_TIMES", 7)
    chain = CHAINS[name]
    times = np.linspace(0.0, hc.simulate(chain).end_time, 40)
    stored = hc.stream(chain, tmp_path / "long", times=times)
    assert len(stored.files) > 2
    for dataset in (stored.load(), *stored.parts()):
        assert {*dataset.data_vars} == {"position", "velocity", "force", "mass", "radius"}
    found, whole = hc.load_run(tmp_path / "long"), hc.simulate(chain, times=times)
    assert_same_run(found, whole)
    end = 1.5 * whole.end_time
    later, usual = (hc.simulate(chain, start=each.state, until=end) for each in (found, whole))
    same(later.velocities, usual.velocities)


def test_incomplete_streams_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr(streaming, "FIRST_TIMES", 7)
    chain, folder = CHAINS["walls and loss"], tmp_path / "long"
    times = np.linspace(0.0, 2e-4, 40)

    def stop(done, _):
        if done > 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hc.stream(chain, folder, times=times, progress=stop)
    found = hc.load_run(folder)
    done = len(found.times)
    assert 10 < done < 40
    whole = hc.simulate(chain, times=times)
    for field in ("times", "positions", "velocities", "forces"):
        same(getattr(found, field), getattr(whole, field)[:done])
    assert found.times[-1] <= found.end_time < times[done]
    (folder / "state.npz").unlink()  # as if the process was killed before the first state
    (folder / "part-000002.nc").rename(tmp_path / "lost.nc")
    with pytest.raises(hc.InputError, match=r"part-000002\.nc is missing"):
        hc.load_run(folder)


def test_streams_without_records_or_times_are_rejected(tmp_path, monkeypatch):
    folder = tmp_path / "long"
    hc.stream(CHAINS["default"], folder, times=[1.0, 2.0])
    monkeypatch.setattr(stored_runs, "ACCUMULATORS", "none")
    with pytest.raises(hc.InputError, match="written by an earlier version and has no records"):
        hc.load_run(folder)
    Manifest("", 1e-9).save(folder)
    with pytest.raises(hc.InputError, match="has no saved times yet"):
        hc.load_run(folder)
    (tmp_path / "other").mkdir()
    with pytest.raises(hc.InputError, match=r"has no manifest\.json: it is not a run of stream"):
        hc.load_run(tmp_path / "other")


def test_streams_that_do_not_fit_in_memory_are_rejected(tmp_path, monkeypatch):
    hc.stream(CHAINS["default"], tmp_path / "long", times=np.linspace(0.0, 1.0, 200))
    monkeypatch.setattr(memory, "ALWAYS_FREE", 0)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=50_000))
    with pytest.raises(
        hc.InputError, match=r"200 times of 9 beads need .* StoredRun\(folder\)\.load"
    ):
        hc.load_run(tmp_path / "long")


def changed(file, **changes):
    with xr.open_dataset(file, engine="scipy") as dataset:
        dataset.load()
    for name, values in changes.items():
        if name in dataset.attrs:
            dataset.attrs[name] = values
        else:
            dataset[name] = (dataset[name].dims, values(dataset[name].values))
    dataset.to_netcdf(file, engine="scipy")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"velocity": lambda values: 2.0 * values}, "its numbers are not those of the run"),
        ({"run_records": lambda values: values[::-1].copy()}, "is damaged or was changed"),
        ({"chain_file": hc.chain_as_toml(hc.Chain.uniform(9))}, "its chain is not that of the run"),
        ({"chain_file": "[chain]"}, "the chain of"),
        ({"chain_file": ""}, "has no chain"),
        ({"records_version": 2}, "with version 2 of the records, but hertzchain .* version 1"),
    ],
)
def test_changed_files_are_rejected(changes, words, tmp_path):
    file = tmp_path / "run.nc"
    hc.simulate(CHAINS["default"], times=20).save(file)
    changed(file, **changes)
    with pytest.raises(hc.InputError, match=words):
        hc.load_run(file)


def without_records_version(file):
    with xr.open_dataset(file, engine="scipy") as dataset:
        dataset.load()
    dataset.attrs.pop("records_version", None)
    dataset.to_netcdf(file, engine="scipy")


def test_files_of_another_version_are_read_with_a_warning(tmp_path):
    file, run = tmp_path / "run.nc", hc.simulate(CHAINS["walls and loss"], times=20)
    run.save(file)
    changed(file, hertzchain_version="0.0.9")
    for _ in range(2):
        with pytest.warns(
            hc.InputWarning, match=r"written by hertzchain 0\.0\.9, this is"
        ) as heard:
            assert_same_run(hc.load_run(file), run)
        assert heard[0].filename == __file__
        without_records_version(file)  # as files that were written before it was introduced


def test_changed_files_of_another_version_are_rejected(tmp_path):
    file = tmp_path / "run.nc"
    hc.simulate(CHAINS["default"], times=20).save(file)
    other = hc.chain_as_toml(hc.Chain.uniform(9))
    changed(file, hertzchain_version="0.0.9", chain_file=other)
    with (
        pytest.warns(hc.InputWarning),
        pytest.raises(
            hc.InputError, match=r"0\.0\.9 and cannot be read as a run by .* its chain is"
        ),
    ):
        hc.load_run(file)


def test_other_files_are_rejected(tmp_path):
    with pytest.raises(hc.InputError, match="No such file"):
        hc.load_run(tmp_path / "none.nc")
    file = tmp_path / "run.nc"
    hc.simulate(CHAINS["default"], times=20).save(file)
    content = file.read_bytes()
    for part in (b"", b"text", content[:200], content[: len(content) // 2], content[:-200]):
        file.write_bytes(part)
        with pytest.raises(hc.InputError, match=r"damaged|not a file of Run\.save"):
            hc.load_run(file)


def test_saving_a_run_leaves_sensors_as_they_are(tmp_path, run):
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(CHAINS["walls and loss"]))
    command = ("simulate", tmp_path / "row.toml", "--sensor", "ball 3", "--json")
    forces = ("--forces", tmp_path / "forces.csv", "--out", tmp_path / "run.nc")
    plain, stored = (json.loads(run(*command, *more)[1]) for more in ((), forces))
    assert stored == plain
    assert len((tmp_path / "forces.csv").read_text().splitlines()) == stored["saved_times"] + 1


def test_a_damaged_file_is_never_read_as_another_run(tmp_path):
    file = tmp_path / "run.nc"
    run = hc.simulate(CHAINS["walls and loss"], times=20)
    run.save(file)
    content, rng, refused = file.read_bytes(), np.random.default_rng(5), 0
    for _ in range(60):
        damaged = bytearray(content)
        damaged[rng.integers(len(content))] ^= int(rng.integers(1, 256))
        file.write_bytes(damaged)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", hc.InputWarning)  # the version may be damaged
                found = hc.load_run(file)
        except hc.InputError:
            refused += 1
            continue
        # Texts such as units may change, numbers may not.
        same(found.velocities, run.velocities)
        assert found.wall_force().peak == run.wall_force().peak
    assert refused > 20


def test_a_csv_file_of_a_run_cannot_be_loaded(tmp_path):
    run = hc.simulate(hc.Chain.uniform(5), times=20)
    run.save(tmp_path / "run.csv")
    with pytest.raises(
        hc.InputError, match=r"is a CSV file, .*; save it with run\.save\('run\.nc'"
    ):
        hc.load_run(tmp_path / "run.csv")
