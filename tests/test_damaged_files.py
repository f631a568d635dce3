"""Randomly corrupted stores, streamed runs and states: an error or correct numbers.

Each trial damages one or two files in one way, always the same for a seed.
"""

import math
import random
import warnings

import numpy as np
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.kernels import state_layout
from hertzchain.simulation.state import State
from hertzchain.store import streaming
from hertzchain.store.sweep_store import SweepStore

CHAIN = hc.Chain.uniform(6).replace(
    right_wall=hc.Wall(), loss=hc.WaltonBraun(0.7), drive=hc.StepDrive(0.01, rise=2.0)
)
TIMES = np.linspace(0.0, 30.0, 61)
SWEEP = {
    "chain": {"taper": "forward-linear"},
    "axes": {"rate": [0.01, 0.02, 0.05], "beads": [15, 30, 60], "gravity": [0.0, 0.01]},
    "sweep": {"methods": ["simulate", "bca"], "keep": ["velocity", "peak_force"], "batch": 2},
    "method": {"until": 10.0},
}


def delete(file, *_):
    file.unlink()


def empty(file, *_):
    file.write_bytes(b"")


def truncate(file, _, rng):
    content = file.read_bytes()
    file.write_bytes(content[: rng.randrange(len(content))])


def flip(file, _, rng):
    content = bytearray(file.read_bytes())
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)


def zeros(file, _, rng):
    content = bytearray(file.read_bytes())
    start = rng.randrange(len(content))
    stop = rng.randrange(start, len(content)) + 1
    content[start:stop] = bytes(stop - start)
    file.write_bytes(content)


def append(file, _, rng):
    file.write_bytes(file.read_bytes() + rng.randbytes(rng.randrange(1, 9)))


def noise(file, _, rng):
    file.write_bytes(rng.randbytes(file.stat().st_size))


def copy_over(file, other, _):
    file.write_bytes(other.read_bytes())


def swap(file, other, _):
    content = file.read_bytes()
    file.write_bytes(other.read_bytes())
    other.write_bytes(content)


def duplicate(file, other, _):
    """Copy to a new name of the same kind."""
    digits = [place for place, part in enumerate(file.name) if part.isdigit()]
    if digits:
        name = [*file.name]
        name[digits[-1]] = "9"
        file.with_name("".join(name)).write_bytes(other.read_bytes())


DAMAGES = (
    delete, empty, truncate, flip, zeros, append, noise, copy_over, swap, duplicate
)  # fmt: skip


class Damaged:
    """A folder that is damaged and restored again."""

    def __init__(self, folder):
        self.folder = folder
        self.contents = {file: file.read_bytes() for file in self.files()}

    def files(self):
        return sorted(file for file in self.folder.rglob("*") if file.is_file())

    def damage(self, seed):
        """Damage it according to a seed; returns how, and whether anything changed."""
        rng = random.Random(seed)
        damage = DAMAGES[seed % len(DAMAGES)]
        file = rng.choice([*self.contents])
        alike = [other for other in self.contents if other.name == file.name or
                 other.suffix == file.suffix]  # fmt: skip
        other = rng.choice(alike)
        if file.stat().st_size or damage in (delete, append, copy_over, swap, duplicate):
            damage(file, other, rng)
        return f"{damage.__name__} {file.relative_to(self.folder)} {other.name}", self.changed()

    def changed(self):
        return {file: file.read_bytes() for file in self.files()} != self.contents

    def restore(self):
        for file in self.files():
            if file not in self.contents:
                file.unlink()
        for file, content in self.contents.items():
            if not file.exists() or file.read_bytes() != content:
                file.write_bytes(content)


def trials(short, long):
    """Seeds of a test that is run always, and of one that takes minutes."""
    return [
        pytest.param(range(short), id=f"{short} trials"),
        pytest.param(range(short, long), id=f"{long - short} trials", marks=pytest.mark.long),
    ]


@pytest.fixture(scope="module")
def sweep_store(tmp_path_factory):
    store = tmp_path_factory.mktemp("sweep") / "sweep"
    # The runs end before the pulse reaches the last beads.
    with pytest.warns(hc.IncompleteWarning, match="18 of 18 points failed"):
        return Damaged(store), hc.sweep(SWEEP, store).load()


@pytest.fixture
def damaged_store(sweep_store):
    folder = Damaged(sweep_store[0].folder)
    yield folder, sweep_store[1]
    folder.restore()


def opened(folder, **options):
    """A whole store in memory; None if it is rejected."""
    try:
        return hc.open_sweep(folder, **options).load()
    except hc.InputError:
        return None


def assert_rest_is_right(found, whole):
    """Values are unchanged, or NaN if they are missing."""
    there = (found.status != 0).all("approach")
    for name in found.data_vars:
        if found[name].dtype.kind == "f":
            xr.testing.assert_equal(found[name].where(there), whole[name].where(there))
            assert bool(found[name].where(~there).isnull().all())
    xr.testing.assert_equal(found.status.where(there), whole.status.where(there))
    xr.testing.assert_equal(found.coords.to_dataset(), whole.coords.to_dataset())


@pytest.mark.parametrize("seeds", trials(15, 800))
def test_a_damaged_store_is_rejected_or_its_rest_is_right(damaged_store, seeds):
    folder, whole = damaged_store
    for seed in seeds:
        how, changed = folder.damage(seed)
        found = opened(folder.folder)
        if found is not None:
            # A batch without digests has not been computed.
            assert_rest_is_right(found, whole)
            assert how.split()[1].startswith("digest") or not changed or "duplicate" in how, how
        try:
            SweepStore(folder.folder).check()
            assert found is not None, how
        except hc.InputError:
            assert found is None, how
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hc.DamageWarning)
            rest = opened(folder.folder, skip_damaged=True)
        if rest is not None:
            assert_rest_is_right(rest, whole)
            assert int((rest.status == 0).all("approach").sum()) <= 4, how
        folder.restore()


def test_a_store_with_any_bit_flipped_in_its_description_is_rejected(damaged_store):
    folder = damaged_store[0]
    file = folder.folder / "zarr.json"
    content = folder.contents[file]
    # Every bit after the attributes, and some of theirs.
    last = content.rindex(b"zarr_format") - 10
    places = [*range(0, last, 30), *range(last, len(content))]
    accepted = []
    for place in places:
        for bit in range(8) if place >= last else (place % 8,):
            changed = bytearray(content)
            changed[place] ^= 1 << bit
            file.write_bytes(changed)
            if opened(folder.folder) is not None:
                accepted.append((place, bit))
    assert not accepted


@pytest.fixture(scope="module")
def streamed_run(tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setattr(streaming, "FILE_SIZE", 10 * 8 * (3 * 6 + 1))
    stored = hc.stream(CHAIN, tmp_path_factory.mktemp("stream") / "run", times=TIMES)
    patch.undo()
    assert len(stored.files) > 5
    return stored, stored.load()


@pytest.mark.parametrize("seeds", trials(15, 1200))
def test_a_damaged_stream_is_rejected_or_its_rest_is_right(streamed_run, seeds):
    stored, whole = streamed_run
    folder = Damaged(stored.folder)
    for seed in seeds:
        how, changed = folder.damage(seed)
        name = how.split()[1]
        try:
            xr.testing.assert_equal(stored.load(), whole)
            assert not changed or name in ("state.npz", ".lock"), how
        except hc.InputError:
            assert changed, how
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", hc.DamageWarning)
                rest = stored.load(skip_damaged=True)
            xr.testing.assert_equal(rest, whole.sel(time=rest.time))
            assert rest.sizes["time"] > 0.6 * whole.sizes["time"], how
        except hc.InputError:
            assert "manifest.json" in how, how
        before = {file: file.read_bytes() for file in folder.files()}
        try:
            longer = hc.stream(CHAIN, stored.folder, times=np.append(TIMES, 31.0))
            # NumPy reads archives with appended bytes.
            xr.testing.assert_equal(longer.load(stop=30.0), whole)
            assert not changed or name in ("state.npz", ".lock"), how
        except hc.InputError:
            assert {file: file.read_bytes() for file in folder.files()} == before, how
        folder.restore()


@pytest.fixture(scope="module")
def state_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("state")
    state = hc.simulate(CHAIN, until=6.0).state
    hc.save_state(state, folder / "state.npz")
    hc.save_state(hc.simulate(CHAIN, until=3.0).state, folder / "other.npz")
    return folder, state


@pytest.mark.parametrize("seeds", trials(150, 3000))
def test_a_damaged_state_is_rejected(state_file, seeds):
    path, state = state_file
    folder = Damaged(path)
    for seed in seeds:
        how, _ = folder.damage(seed)
        for name in ("state.npz", "other.npz"):
            content = (path / name).read_bytes() if (path / name).exists() else b""
            try:
                found = hc.load_state(path / name, CHAIN)
            except hc.InputError:
                assert content not in folder.contents.values(), how
                continue
            # Bytes of a ZIP archive that nothing depends on may change.
            expected = state if found.time == state.time else hc.simulate(CHAIN, until=3.0).state
            for key, values in expected.arrays.items():
                np.testing.assert_array_equal(found.arrays[key], values, err_msg=how)
        folder.restore()


def tampered(state, rng):
    """A state with one changed array, written with a valid digest."""
    arrays = {name: values.copy() for name, values in state.arrays.items()}
    name = rng.choice([*arrays])
    values = arrays[name]
    numbers = (0, 1, -1, 7, -(10**7), 2**62, -(2**63), 1e300, -1e300, 1e-300, np.nan, np.inf)
    how = rng.randrange(6)
    if how < 3:
        number = rng.choice(numbers if values.dtype.kind == "f" else numbers[:7])
        values.flat[rng.randrange(values.size)] = number
    elif how == 3:
        with np.errstate(invalid="ignore", over="ignore"):
            arrays[name] = values.astype(rng.choice(["f4", "i4", "c16", "U5", "u8"]))
    elif how == 4:
        arrays[name] = rng.choice([values[..., :-1], values[..., None], values[:0], values.sum()])
    else:
        del arrays[name]
        if rng.random() < 0.5:
            arrays[f"{name}2"] = values
    return State(state.chain, arrays)


@pytest.mark.parametrize("seeds", trials(150, 3000))
def test_a_state_with_impossible_values_never_reaches_compiled_code(state_file, seeds, tmp_path):
    plain = hc.Chain.uniform(6)
    stuck = plain.replace(loss=hc.UnloadingRatio(0.3), left_wall=hc.Wall(), gravity=0.01)
    states = [state_file[1], *(hc.simulate(chain, until=6.0).state for chain in (plain, stuck))]
    refused = 0
    for seed in seeds:
        state = states[seed % 3]
        hc.save_state(tampered(state, random.Random(seed)), tmp_path / "state.npz")
        try:
            found = hc.load_state(tmp_path / "state.npz", state.chain)
        except hc.InputError:
            refused += 1
            continue
        # The time until which no contact closes may be infinite.
        assert found.arrays["clock"][state_layout.IDLE_UNTIL] > -math.inf
        clock = np.delete(found.arrays["clock"], state_layout.IDLE_UNTIL)
        assert all(np.isfinite(each).all() for each in (found.arrays | {"clock": clock}).values())
        until = 2.0 * found.time + 1.0
        with np.errstate(all="ignore"):
            run = hc.simulate(found.chain, start=found, until=until, max_steps=300, check=False,
                              times=0)  # fmt: skip
        assert run.status in (
            "time reached",
            "step limit",
            "step too small",
            "unstable steps",
            "underflow",
        )
    assert refused > 0.6 * len(seeds)


@pytest.mark.parametrize(
    ("name", "place", "value", "said"),
    [
        ("counts", 7, -(10**7), r"entry 8 of its array 'counts' is -10000000, but must be from 0"),
        ("counts", 3, 6, r"entry 4 of its array 'counts' is 6, but must be from 0 to 5"),
        ("counts", 5, 5, r"entry 6 of its array 'counts' is 5, but must be from -1 to 4"),
        ("counts", 7, 0, r"its time \d.* is not in piece 1 of the drive"),
        ("mode", 2, 9, r"'mode' has invalid values"),
        ("y", 0, np.nan, r"'y' has values that are not finite"),
        ("clock", 1, 0.0, r"its step 0 is negative, or the step is 0"),
        ("clock", 0, -1.0, r"its time -1 "),
    ],
)
def test_a_state_to_start_from_is_checked_as_one_from_a_file(state_file, name, place, value, said):
    state = state_file[1].copy()
    state.arrays[name][place] = value
    with pytest.raises(hc.InputError, match=said):
        hc.simulate(CHAIN, start=state, until=9.0)
    state.arrays[name] = state.arrays[name].astype("f4")
    with pytest.raises(hc.InputError, match=f"its array '{name}' has type and shape float32"):
        hc.simulate(CHAIN, start=state, until=9.0)
