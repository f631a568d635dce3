import itertools
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.simulation import simulate
from hertzchain.simulation.fixed_steps import FixedSteps
from hertzchain.store import manifest, results, streaming, writing

CHAIN = hc.Chain.uniform(12).replace(right_wall=hc.Wall(), loss=hc.UnloadingRatio(0.2))
TIMES = np.linspace(0.0, 40.0, 81)


@pytest.fixture
def _small_files(monkeypatch):
    monkeypatch.setattr(streaming, "FILE_SIZE", 10 * 8 * (3 * 12 + 1))


@pytest.mark.usefixtures("_small_files")
def test_what_is_streamed_is_the_run(tmp_path):
    whole = hc.simulate(CHAIN, times=TIMES)
    stored = hc.stream(CHAIN, tmp_path / "run", times=TIMES)
    assert len(stored.files) > 8
    data = stored.load()
    np.testing.assert_array_equal(data.time, TIMES)
    np.testing.assert_array_equal(data.velocity, whole.velocities)
    np.testing.assert_array_equal(data.force, whole.forces)
    assert stored.load(start=10.0, stop=20.0).time.values[[0, -1]].tolist() == [10.0, 20.0]


def test_times_of_parts_have_the_units_of_the_chain(tmp_path, monkeypatch):
    monkeypatch.setattr(streaming, "FILE_SIZE", 10 * 8 * (3 * 5 + 1))
    chain = hc.Chain.from_materials("5 mm", "steel-316", beads=5, velocity="1 mm/s")
    times = np.linspace(0.0, 1e-4, 51)
    stored = hc.stream(chain, tmp_path / "SI", times=times)
    np.testing.assert_array_equal(stored.load("19 us", "0.061 ms").time, times[10:31])
    with pytest.raises(hc.InputError, match="start must have a unit such as s, .* got 'm'"):
        stored.load("1 m")
    with pytest.raises(hc.InputError, match="stop must be a time, got nan"):
        stored.load(stop=float("nan"))
    # The unit does not depend on a part that is omitted.
    lost = next(stored.parts()).sizes["time"]
    stored.files[0].write_bytes(b"")
    with pytest.warns(hc.DamageWarning, match="part-000001.nc is not as it was written"):
        rest = stored.load("0 s", "0.061 ms", skip_damaged=True)
    np.testing.assert_array_equal(rest.time, times[lost:31])
    for file in stored.files:
        file.write_bytes(b"")
    with pytest.raises(hc.InputError, match="part-000001.nc is not as it was written"):
        stored.load("0 s")
    scaled = hc.stream(CHAIN, tmp_path / "scaled", times=[1.0, 2.0])
    with pytest.raises(hc.InputError, match="start .*'1 ms'"):
        scaled.load("1 ms")


@pytest.mark.usefixtures("_small_files")
def test_an_interrupted_stream_resumes_bit_for_bit(tmp_path):
    class Stopped(Exception):
        pass

    def stop(done, _):
        if done >= 30:
            raise Stopped

    with pytest.raises(Stopped):
        hc.stream(CHAIN, tmp_path, times=TIMES, progress=stop)
    assert 2 < len(streaming.StoredRun(tmp_path).files) < 6
    stored = hc.stream(CHAIN, tmp_path, times=TIMES)
    whole = hc.simulate(CHAIN, times=TIMES)
    np.testing.assert_array_equal(stored.load().velocity, whole.velocities)


@pytest.mark.usefixtures("_small_files")
def test_a_file_ahead_of_its_state_is_written_again(tmp_path, monkeypatch):
    calls = []

    def fail_late(state, path):
        calls.append(state)
        if len(calls) == 3:
            raise hc.StoreError("cannot write: no space left on device")
        results.save_state(state, path)

    monkeypatch.setattr(streaming, "save_state", fail_late)
    with pytest.raises(hc.StoreError, match=r"no space left.*times up to \d+\.?\d* are stored"):
        hc.stream(CHAIN, tmp_path, times=TIMES)
    monkeypatch.setattr(streaming, "save_state", results.save_state)
    assert streaming.StoredRun(tmp_path).load().time[-1] >= 9.0
    stored = hc.stream(CHAIN, tmp_path, times=TIMES)
    np.testing.assert_array_equal(stored.load().time, TIMES)


def test_a_folder_holds_one_tolerance(tmp_path):
    hc.stream(CHAIN, tmp_path, times=[1.0, 2.0], rtol=1e-10)
    with pytest.raises(
        hc.InputError, match="rtol = 1e-10, but now rtol is 1e-12; resume it with 1e-10, or choose"
    ):
        hc.stream(CHAIN, tmp_path, times=[1.0, 2.0, 3.0], rtol=1e-12)
    assert hc.stream(CHAIN, tmp_path, times=[1.0, 2.0, 3.0], rtol=1e-10).load().sizes["time"] == 3


BETWEEN_WALLS = hc.Chain.uniform(12).replace(left_wall=hc.Wall(), right_wall=hc.Wall())


@pytest.mark.usefixtures("_small_files")
def test_a_stream_by_fixed_steps_resumes_bit_for_bit(tmp_path):
    class Stopped(Exception):
        pass

    def stop(done, _):
        if done >= 30:
            raise Stopped

    fixed = {"method": "symplectic", "step": 0.02}
    with pytest.raises(Stopped):
        hc.stream(BETWEEN_WALLS, tmp_path, times=TIMES, progress=stop, **fixed)
    # The method that "symplectic" chose and the step are those of the folder.
    stored = hc.stream(BETWEEN_WALLS, tmp_path, times=TIMES, method="symplectic")
    whole = hc.simulate(BETWEEN_WALLS, times=TIMES, **fixed)
    np.testing.assert_array_equal(stored.load().velocity, whole.velocities)


@pytest.mark.usefixtures("_small_files")
def test_a_stream_whose_energy_drifts_begins_again_with_shorter_steps(tmp_path, monkeypatch):
    times, reports = np.linspace(0.0, 300.0, 61), []

    def note(done, _):
        reports.append(done)

    # The drift of this step exceeds the limit after the first parts are written.
    drifts = [
        hc.simulate(BETWEEN_WALLS, until=until, times=0, method="forward-4", step=0.05).energy_drift
        for until in (60.0, 300.0)
    ]
    limit = float(np.sqrt(np.prod(drifts)))
    monkeypatch.setattr(streaming, "fixed_steps", lambda *_: FixedSteps("forward-4", 0.05, limit))
    stored = hc.stream(
        BETWEEN_WALLS, tmp_path, times=times, method="forward-4", drift=limit, progress=note
    )
    assert len(stored.files) > 2
    assert any(later < earlier for earlier, later in itertools.pairwise(reports))
    written = manifest.load_manifest(tmp_path)
    same = hc.simulate(BETWEEN_WALLS, times=times, method=written.method, step=written.step)
    np.testing.assert_array_equal(stored.load().velocity, same.velocities)
    assert same.energy_drift <= limit < drifts[1]
    assert written.step < 0.05


def test_a_folder_holds_one_method_and_step(tmp_path):
    fixed = {"method": "verlet", "step": 0.02}
    hc.stream(BETWEEN_WALLS, tmp_path, times=[1.0, 2.0], **fixed)
    with pytest.raises(
        hc.InputError, match="by method 'verlet', but now .* is 'adaptive'; .* with method 'verlet'"
    ):
        hc.stream(BETWEEN_WALLS, tmp_path, times=[1.0, 2.0])
    with pytest.raises(hc.InputError, match="step = 0.02, but now step is 0.03; resume .* 0.02"):
        hc.stream(BETWEEN_WALLS, tmp_path, times=[1.0, 2.0], **(fixed | {"step": 0.03}))
    with pytest.raises(hc.InputError, match="supports elastic contacts only"):
        hc.stream(CHAIN, tmp_path / "lossy", times=[1.0], method="symplectic")
    assert not (tmp_path / "lossy").exists()


def test_a_folder_holds_one_run(tmp_path):
    hc.stream(CHAIN, tmp_path, times=[1.0, 2.0])
    with pytest.raises(hc.InputError, match="a run with other times"):
        hc.stream(CHAIN, tmp_path, times=[1.0, 3.0])
    with pytest.raises(hc.InputError, match="another chain"):
        hc.stream(hc.Chain.uniform(12), tmp_path, times=[1.0, 2.0])
    with pytest.raises(hc.InputError, match="increasing"):
        hc.stream(CHAIN, tmp_path / "b", times=[2.0, 1.0])


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "part-000001.nc").write_bytes(b"mine")
    with pytest.raises(hc.InputError, match=r"contains 'part-000001.nc' but no run"):
        hc.stream(CHAIN, tmp_path, times=TIMES)
    assert (tmp_path / "part-000001.nc").read_bytes() == b"mine"
    (tmp_path / "part-000001.nc").unlink()
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(hc.InputError, match=r"contains 'notes.txt' but no run"):
        hc.stream(CHAIN, tmp_path, times=TIMES)
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]
    with pytest.raises(hc.InputError, match=r"notes.txt' is a file"):
        hc.stream(CHAIN, tmp_path / "notes.txt", times=TIMES)
    (tmp_path / "other").mkdir()
    hc.save_state(hc.simulate(CHAIN, until=1.0).state, tmp_path / "other" / "state.npz")
    with pytest.raises(hc.InputError, match=r"contains 'state.npz' but no run"):
        hc.stream(CHAIN, tmp_path / "other", times=TIMES)


@pytest.mark.parametrize("damaged", [b"", b"CDF", bytes(9999)])
def test_a_damaged_file_is_named(tmp_path, damaged):
    stored = hc.stream(CHAIN, tmp_path, times=TIMES)
    file = stored.files[-1]
    for content in (damaged, file.read_bytes()[: file.stat().st_size // 2]):
        file.write_bytes(content)
        for use in (stored.load, lambda: hc.stream(CHAIN, tmp_path, times=TIMES)):
            with pytest.raises(
                hc.InputError, match=rf"is damaged: {file.name} is not as it was written"
            ):
                use()


@pytest.fixture
def stored(tmp_path, _small_files):
    """A run in eight parts or more."""
    return hc.stream(CHAIN, tmp_path / "run", times=TIMES)


def lose(files):
    files[3].unlink()


def repeat(files):
    shutil.copy(files[2], files[3])


def swap(files):
    content = files[2].read_bytes()
    shutil.copy(files[4], files[2])
    files[4].write_bytes(content)


def flip(files):
    content = bytearray(files[3].read_bytes())
    content[-100] ^= 4
    files[3].write_bytes(content)


@pytest.mark.parametrize("damage", [lose, repeat, swap, flip])
def test_a_part_that_is_lost_repeated_or_altered_is_rejected(stored, damage):
    whole = stored.load()
    damage(stored.files)
    said = r"is damaged: part-00000\d.nc is (missing|not as it was written)"
    for use in (stored.load, lambda: [*stored.parts()],
                lambda: hc.stream(CHAIN, stored.folder, times=TIMES)):  # fmt: skip
        with pytest.raises(hc.InputError, match=said):
            use()
    with pytest.warns(hc.DamageWarning, match=r"part-00000\d.nc is .* it is omitted"):
        rest = stored.load(skip_damaged=True)
    assert 0.6 < rest.sizes["time"] / whole.sizes["time"] < 1.0
    xr.testing.assert_equal(rest, whole.sel(time=rest.time))


def test_parts_of_another_run_are_rejected_and_not_changed(stored, tmp_path):
    other = hc.stream(CHAIN.replace(loss=None), tmp_path / "other", times=TIMES)
    extra = stored.folder / f"part-{len(stored.files) + 1:06d}.nc"
    shutil.copy(other.files[0], extra)
    mine = extra.read_bytes()
    for use in (stored.load, lambda: hc.stream(CHAIN, stored.folder, times=TIMES)):
        with pytest.raises(hc.InputError, match=f"{extra.name} is not part of this run; move"):
            use()
    assert extra.read_bytes() == mine
    extra.unlink()
    first = stored.files[0]
    shutil.copy(other.files[0], first)
    with pytest.raises(hc.InputError, match=f"{first.name} is not as it was written"):
        stored.load()


@pytest.mark.parametrize("name", ["manifest.json", "state.npz"])
def test_a_run_is_not_resumed_without_its_manifest_and_state(stored, name):
    (stored.folder / name).unlink()
    before = {file.name: file.read_bytes() for file in stored.folder.glob("[!.]*")}
    with pytest.raises(hc.InputError, match=r"but no run of stream|state.npz is missing"):
        hc.stream(CHAIN, stored.folder, times=TIMES)
    assert {file.name: file.read_bytes() for file in stored.folder.glob("[!.]*")} == before
    if name == "manifest.json":
        with pytest.raises(hc.InputError, match="has no manifest.json"):
            stored.load()


def test_a_manifest_is_compared_with_its_digest(stored):
    file = stored.folder / "manifest.json"
    good = file.read_text()
    for bad in ("{}", "[", "[]", "null", good[:-9], good.replace('"times": ', '"times": 9', 1)):
        file.write_text(bad)
        with pytest.raises(hc.InputError, match="damaged: manifest.json is not as it was written"):
            stored.load()


def test_a_state_of_a_later_time_is_rejected(stored):
    times = np.linspace(0.0, 80.0, 161)
    older = (stored.folder / "manifest.json").read_bytes()
    hc.stream(CHAIN, stored.folder, times=times)
    (stored.folder / "manifest.json").write_bytes(older)
    for file in sorted(stored.folder.glob("part-*.nc"))[len(stored.files) :]:
        file.unlink()
    with pytest.raises(hc.InputError, match=r"state.npz has the time t = \d+.*after"):
        hc.stream(CHAIN, stored.folder, times=times)


def test_what_a_killed_run_left_half_written_is_removed(stored):
    left = [stored.folder / f".{name}.77.partial" for name in ("part-000009.nc", "state.npz")]
    for file in (*left, stored.folder / ".mine.partial"):
        file.write_bytes(b"half")
    hc.stream(CHAIN, stored.folder, times=TIMES)
    assert not any(file.exists() for file in left)
    assert (stored.folder / ".mine.partial").read_bytes() == b"half"


class Killed(BaseException):
    """Nothing catches it, as nothing catches a kill."""


@pytest.mark.long
@pytest.mark.usefixtures("_small_files")
@pytest.mark.parametrize("kill", range(16))
def test_a_run_killed_between_any_two_files_is_whole_and_resumed(tmp_path, monkeypatch, kill):
    calls = []

    def write(target, content):
        if len(calls) == kill:
            raise Killed
        calls.append(target.name)
        writing.write_bytes(target, content)

    for module in (streaming, results, manifest):
        monkeypatch.setattr(module, "write_bytes", write)
    with pytest.raises(Killed):
        hc.stream(CHAIN, tmp_path, times=TIMES)
    monkeypatch.undo()
    whole = hc.simulate(CHAIN, times=TIMES)
    if (tmp_path / "manifest.json").exists() and streaming.StoredRun(tmp_path).files:
        part = streaming.StoredRun(tmp_path).load()
        np.testing.assert_array_equal(part.velocity, whole.velocities[: part.sizes["time"]])
    found = hc.stream(CHAIN, tmp_path, times=TIMES).load()
    np.testing.assert_array_equal(found.time, TIMES)
    np.testing.assert_array_equal(found.velocity, whole.velocities)


def test_two_runs_into_one_folder_are_kept_apart(tmp_path):
    refused = []

    def again(done, _):
        with pytest.raises(hc.InputError, match="another process is writing to .*run'; wait"):
            hc.stream(CHAIN, tmp_path / "run", times=TIMES)
        refused.append(done)

    stored = hc.stream(CHAIN, tmp_path / "run", times=TIMES, progress=again)
    assert refused[-1] == len(TIMES)
    np.testing.assert_array_equal(stored.load().time, TIMES)


@pytest.mark.parametrize("name", ["x" * 300, "x" * 300 + "/a"])
def test_a_folder_that_cannot_be_created_is_reported(tmp_path, name):
    with pytest.raises(hc.InputError, match="cannot write .*too long"):
        hc.stream(CHAIN, tmp_path / name, times=TIMES)


def test_other_files_next_to_a_run_are_allowed(tmp_path):
    hc.stream(CHAIN, tmp_path, times=[1.0, 2.0])
    (tmp_path / "notes.txt").write_text("mine")
    assert len(hc.stream(CHAIN, tmp_path, times=[1.0, 2.0, 3.0]).files) == 2


@pytest.mark.parametrize(("seconds", "fewest", "most"), [(0.0, 9, 12), (100.0, 4, 5)])
def test_files_grow_until_one_takes_long(tmp_path, monkeypatch, seconds, fewest, most):
    monkeypatch.setattr(streaming, "FIRST_TIMES", 10)
    monkeypatch.setattr(streaming, "SECONDS_PER_FILE", seconds)
    stored = hc.stream(CHAIN, tmp_path, times=TIMES)
    assert fewest <= len(stored.files) <= most
    np.testing.assert_array_equal(stored.load().time, TIMES)


def test_a_long_run_has_no_step_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(simulate, "MIN_STEP_LIMIT", 10)
    monkeypatch.setattr(simulate, "STEPS_PER_BEAD", 1)
    with pytest.raises(hc.SimulationError, match="step limit"):
        hc.simulate(CHAIN, times=TIMES)
    hc.stream(CHAIN, tmp_path, times=TIMES)


def test_a_state_goes_through_a_file_unchanged(tmp_path):
    state = hc.simulate(CHAIN, until=20.0).state
    hc.save_state(state, tmp_path / "state.npz")
    again = hc.load_state(tmp_path / "state.npz", CHAIN)
    for name, values in state.arrays.items():
        np.testing.assert_array_equal(again.arrays[name], values)
    later = hc.simulate(CHAIN, start=again, times=[40.0])
    whole = hc.simulate(CHAIN, times=[40.0])
    np.testing.assert_array_equal(later.velocities, whole.velocities)


def test_states_that_do_not_fit_are_rejected(tmp_path, monkeypatch):
    state, file = hc.simulate(CHAIN, until=1.0).state, tmp_path / "state.npz"
    monkeypatch.setattr(results, "RECORDS_VERSION", 2)
    hc.save_state(state, file)
    monkeypatch.undo()
    with pytest.raises(hc.InputError, match="with version 2 of the records, .* restart the run"):
        hc.load_state(file, CHAIN)
    monkeypatch.setattr(results, "__version__", "0.0.1")
    hc.save_state(state, file)
    monkeypatch.undo()
    with pytest.warns(hc.InputWarning, match=r"was written by hertzchain 0\.0\.1, this is"):
        later = hc.load_state(file, CHAIN)
    np.testing.assert_array_equal(later.arrays["y"], state.arrays["y"])
    hc.save_state(state, file)
    with pytest.raises(hc.InputError, match="belongs to another chain"):
        hc.load_state(file, hc.Chain.uniform(12))
    file.write_bytes(b"nothing")
    with pytest.raises(hc.InputError, match="not a file of save_state"):
        hc.load_state(file, CHAIN)
    with pytest.raises(hc.InputError, match="No such file"):
        hc.load_state(tmp_path / "none.npz", CHAIN)


LONG = """
import sys
from pathlib import Path
import numpy as np
import hertzchain as hc
chain = hc.Chain.uniform(1000).replace(right_wall=hc.Wall(), left_wall=hc.Wall())
hc.stream(chain, sys.argv[1], times=np.linspace(0.0, float(sys.argv[2]), int(sys.argv[3])))
# Only of this process; getrusage may include the memory of its parent.
peak = next(line for line in Path("/proc/self/status").open() if line.startswith("VmHWM"))
print(int(peak.split()[1]) / 1024)
"""


@pytest.mark.long
def test_memory_does_not_grow_with_the_run(tmp_path):
    """Almost half a GB of states is written with less memory."""
    arguments = [os.fspath(tmp_path), "120", "20000"]
    done = subprocess.run(
        [sys.executable, "-c", LONG, *arguments], capture_output=True, text=True, check=True
    )
    stored = sum(file.stat().st_size for file in tmp_path.iterdir())
    assert stored > 450 * 2**20
    assert float(done.stdout) < 500


@pytest.mark.usefixtures("_small_files")
def test_a_given_step_that_is_too_long_warns_once(tmp_path):
    box = hc.Chain.uniform(12).replace(left_wall=hc.Wall(), right_wall=hc.Wall())
    with pytest.warns(hc.InputWarning, match=r"the energy has drifted by \d") as caught:
        stored = hc.stream(box, tmp_path / "run", times=TIMES, method="verlet", step=0.5)
    assert len(stored.files) > 4
    assert len(caught) == 1


def test_a_long_run_out_of_the_range_of_hertz_warns_once(tmp_path, monkeypatch):
    monkeypatch.setattr(streaming, "FILE_SIZE", 10 * 8 * (3 * 6 + 1))
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=1.0)
    with pytest.warns(hc.ModelRangeWarning) as caught:
        stored = hc.stream(chain, tmp_path, times=np.linspace(0.0, 200e-6, 60))
    assert len(stored.files) > 3
    assert len(caught) == 1
    assert str(caught[0].message).startswith("simulation: pressure / yield is 1.4")


def test_properties_of_a_folder_without_a_run_name_themselves(tmp_path):
    stored = hc.stream(hc.Chain.uniform(5), tmp_path, times=np.linspace(0.0, 9.0, 10))
    manifest = tmp_path / "manifest.json"
    manifest.write_text("{")
    for name in ("chain", "files"):
        with pytest.raises(hc.InputError, match=rf"^StoredRun\.{name}: .* is damaged") as caught:
            getattr(stored, name)
        # The type remains that of damaged files.
        assert type(caught.value).__name__ == "DamagedFileError"
    manifest.unlink()
    for name in ("chain", "files"):
        with pytest.raises(hc.InputError, match=rf"^StoredRun\.{name}: .* has no manifest"):
            getattr(stored, name)
