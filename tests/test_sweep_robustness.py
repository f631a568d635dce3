"""Sweeps that are killed, interrupted or run out of disk, on all kinds of executors."""

import contextlib
import json
import multiprocessing
import os
import pickle
import random
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest
import xarray as xr
from interruption import PROMPT

import hertzchain as hc
from hertzchain.store.sweep_store import SweepStore, locked
from hertzchain.sweeps import dispatch, executors
from hertzchain.sweeps import sweep as sweep_module

# One point of most of these sweeps fails on purpose.
pytestmark = pytest.mark.filterwarnings("ignore:.* points failed:hertzchain.IncompleteWarning")

# A second or so of work, most of it with files, in 32 batches; some points fail.
SPECIFICATION = """
[chain]
taper = "forward-linear"
[axes]
rate = {linspace = [0.004, 0.012, 64]}
beads = {linspace = [65, 100, 8]}
[sweep]
methods = ["propagate", "bca"]
keep = ["velocity", "peak_force"]
batch = 16
"""
HERTZCHAIN = [sys.executable, "-m", "hertzchain"]


@pytest.fixture(scope="module")
def specification(tmp_path_factory):
    file = tmp_path_factory.mktemp("specification") / "sweep.toml"
    file.write_text(SPECIFICATION)
    return file


@pytest.fixture(scope="module")
def undisturbed(specification, tmp_path_factory):
    """Every file of the store of a sweep that nothing disturbed."""
    store = tmp_path_factory.mktemp("undisturbed") / "sweep"
    hc.sweep(specification, store)
    return contents(store)


def contents(store):
    return {str(file.relative_to(store)): file.read_bytes() for file in sorted(store.rglob("*"))
            if file.is_file()}  # fmt: skip


def command(specification, store, *options):
    return [*HERTZCHAIN, "sweep", str(specification), "--store", str(store), *options]


def start(specification, store, *options):
    # A separate process group, like that of a terminal; it includes the workers.
    return subprocess.Popen(
        command(specification, store, *options), stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def done_batches(store):
    return len(list((store / "status").glob("c/**/0")))


def kill_at(process, store, batches, sign=signal.SIGKILL):
    """Send a signal after a number of batches, unless the process ends before."""
    while process.poll() is None and done_batches(store) < batches:
        time.sleep(0.002)
    time.sleep(random.uniform(0.0, 0.03))
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(sign)


def kill_and_resume(specification, store, undisturbed, *, kills, seed):
    """Kill again and again, then let it go to its end."""
    random.seed(seed)
    for _ in range(kills):
        process = start(specification, store, "--workers", "2")
        kill_at(process, store, done_batches(store) + random.randint(0, 8))
        process.communicate()
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


@pytest.mark.long
def test_killed_sweeps_end_with_the_same_bytes(specification, undisturbed, tmp_path):
    kill_and_resume(specification, tmp_path / "sweep", undisturbed, kills=2, seed=1)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(15))
def test_thirty_kills_of_main_and_workers(specification, undisturbed, tmp_path, seed):
    kill_and_resume(specification, tmp_path / "main", undisturbed, kills=1, seed=seed)
    kill_worker_and_resume(specification, tmp_path / "worker", undisturbed, seed=seed)


@pytest.mark.long
def test_a_killed_worker_is_reported_and_the_sweep_resumes(specification, undisturbed, tmp_path):
    told = kill_worker_and_resume(specification, tmp_path / "sweep", undisturbed, seed=3)
    assert "a worker process ended abruptly" in told
    assert "run the same command again to resume" in told


def kill_worker_and_resume(specification, store, undisturbed, *, seed):
    random.seed(seed)
    process = start(specification, store, "--processes", "--workers", "2")
    workers = []
    while process.poll() is None and not (workers and done_batches(store) > seed % 5):
        workers = workers_of(process.pid)
        time.sleep(0.005)
    if workers:
        with contextlib.suppress(ProcessLookupError):
            os.kill(random.choice(workers), signal.SIGKILL)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 1  # failed points, or the worker
    hc.sweep(specification, store)
    assert contents(store) == undisturbed
    return told


def workers_of(pid):
    """Processes that a pool has started, without those that only keep its accounts."""
    import psutil

    with contextlib.suppress(psutil.Error):
        return [child.pid for child in psutil.Process(pid).children(recursive=True)
                if "spawn_main" in " ".join(child.cmdline())]  # fmt: skip
    return []


def half_a_result(folder, batch):
    """Run by a worker: it is killed while it writes a result."""
    (Path(folder) / f"{batch}.result").write_bytes(b"half")
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.long
def test_a_worker_killed_while_it_writes_is_noticed(specification, undisturbed, tmp_path):
    class Elsewhere(ProcessPoolExecutor):
        def submit(self, _, *arguments):
            return super().submit(half_a_result, *arguments)

    begun = time.monotonic()
    context = multiprocessing.get_context("spawn")
    with (
        Elsewhere(2, mp_context=context) as pool,
        pytest.raises(hc.StoreError, match="a worker process ended abruptly"),
    ):
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    assert time.monotonic() - begun < 30.0
    assert files_beside(tmp_path / "sweep") == []
    hc.sweep(specification, tmp_path / "sweep")
    assert contents(tmp_path / "sweep") == undisturbed


def files_beside(store):
    """Files next to the store of a sweep, except for the lock."""
    return [each.name for each in store.parent.iterdir()
            if each != store and not each.name.endswith(".lock")]  # fmt: skip


class InThisProcess(ProcessPoolExecutor):
    """A pool of processes that runs everything here, and keeps what is sent in both directions."""

    def __init__(self):
        super().__init__(1)
        self.sent, self.answers = [], []

    def submit(self, function, *arguments):
        future = Future()
        self.sent.append(pickle.dumps((function, arguments)))
        future.set_result(function(*arguments))
        self.answers.append(pickle.dumps(future.result()))
        return future


@pytest.mark.long
def test_messages_of_processes_are_too_short_to_be_cut(tmp_path):
    """Up to PIPE_BUF bytes are written to a pipe completely or not at all, also by a kill."""
    import select

    rates = {"list": [0.01 + 1e-5 * i for i in range(2000)]}
    given = {"chain": {"taper": "forward-exponential", "beads": 40}, "axes": {"rate": rates}}
    with InThisProcess() as pool:
        found = hc.sweep(given, tmp_path / "sweep", executor=pool)
        xr.testing.assert_equal(hc.sweep(given, executor=pool), found.load())
    assert len(pool.sent) == len(pool.answers) == 2 * 32
    # Python adds the number of the task, the process and a few names.
    assert max(map(len, pool.sent)) < select.PIPE_BUF - 500
    assert max(map(len, pool.answers)) < select.PIPE_BUF - 500
    assert files_beside(tmp_path / "sweep") == []


def test_an_error_in_a_process_is_raised_with_its_traceback(specification, tmp_path, monkeypatch):
    def fail(*_):
        raise ZeroDivisionError("in a batch")

    monkeypatch.setattr(dispatch, "run_planned", fail)
    with InThisProcess() as pool, pytest.raises(ZeroDivisionError, match="in a batch") as error:
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    assert "in fail" in error.value.__notes__[0]
    assert files_beside(tmp_path / "sweep") == []


@pytest.mark.long
def test_results_that_a_killed_sweep_has_left_are_removed(specification, tmp_path):
    left, other = tmp_path / ".sweep.abcd_123.results", tmp_path / ".sweep.efgh_456.results"
    # The last belongs to a store that is named sweep.zarr.
    running = tmp_path / ".sweep.zarr.abcd_123.results"
    for folder in (left, other, running):
        folder.mkdir()
        (folder / "3.result").write_bytes(b"half")
    (other / "thesis.tex").write_text("all I have")
    with InThisProcess() as pool:
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    assert sorted(files_beside(tmp_path / "sweep")) == [other.name, running.name]
    assert (other / "thesis.tex").read_text() == "all I have"
    assert (running / "3.result").exists()


def without_disk(function, *arguments):
    """Run by a worker: its files cannot grow beyond 1000 bytes."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    return function(*arguments)


@pytest.mark.long
def test_a_disk_that_fills_while_a_process_writes_is_reported(specification, tmp_path):
    class Elsewhere(ProcessPoolExecutor):
        def submit(self, *arguments):
            return super().submit(without_disk, *arguments)

    context = multiprocessing.get_context("spawn")
    with (
        Elsewhere(1, mp_context=context) as pool,
        pytest.raises(hc.StoreError, match=r"cannot write .*\.results' \(File too large\)"),
    ):
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    assert files_beside(tmp_path / "sweep") == []


def endless(folder, _):
    """Run by a worker: it looks for a reason to stop, as a batch does."""
    begun = time.monotonic()
    while (Path(folder) / dispatch.SPECIFICATION_FILE).exists() and time.monotonic() < begun + 60:
        time.sleep(0.01)
    return "0.result"


@pytest.mark.long
def test_processes_of_any_pool_stop_with_the_sweep(specification, tmp_path):
    class Elsewhere(ProcessPoolExecutor):
        def submit(self, _, *arguments):
            return super().submit(endless, *arguments)

    context = multiprocessing.get_context("spawn")
    with Elsewhere(2, mp_context=context) as pool:
        stop = threading.Timer(5.0, lambda: signal.raise_signal(signal.SIGINT))
        stop.start()
        with pytest.raises(KeyboardInterrupt):
            hc.sweep(specification, tmp_path / "sweep", executor=pool)
        begun = time.monotonic()
    assert time.monotonic() - begun < PROMPT
    assert files_beside(tmp_path / "sweep") == []


def test_two_batches_are_submitted_per_worker(specification):
    class Counted(ThreadPoolExecutor):
        def submit(self, *arguments):
            waiting.append(len(waiting))
            return super().submit(*arguments)

    for workers, expected in ((3, 6), (None, 2 * 2 * len(os.sched_getaffinity(0)))):
        waiting = []

        def stop(done, _):
            if done:
                raise LookupError("enough")

        with Counted(1) as pool, pytest.raises(LookupError):
            hc.sweep(specification, executor=pool, workers=workers, progress=stop)
        assert len(waiting) == min(expected, 32)


@pytest.mark.parametrize("sign", [
    signal.SIGKILL, *(pytest.param(each, marks=pytest.mark.long)
                      for each in (signal.SIGTERM, signal.SIGINT)),
])  # fmt: skip
def test_no_worker_outlives_its_sweep(specification, undisturbed, tmp_path, sign):
    import psutil

    store = tmp_path / "sweep"
    process = start(specification, store, "--processes", "--workers", "2")
    workers = []
    while process.poll() is None and not (len(workers) > 1 and done_batches(store)):
        workers = [psutil.Process(pid) for pid in workers_of(process.pid)]
        time.sleep(0.005)
    process.send_signal(sign)
    _, told = process.communicate(timeout=60)
    assert "Traceback" not in told
    _, alive = psutil.wait_procs(workers, timeout=60)
    assert alive == []
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


@pytest.mark.long
def test_a_failing_executor_is_reported(specification, undisturbed, tmp_path):
    class Lost(ThreadPoolExecutor):
        def submit(self, *_):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    said = r"the executor stopped with 32 of 32 batches missing"
    with Lost(1) as pool, pytest.raises(hc.StoreError, match=said):
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    hc.sweep(specification, tmp_path / "sweep")
    assert contents(tmp_path / "sweep") == undisturbed


@pytest.mark.long
def test_an_executor_that_is_shut_down_is_reported(specification, undisturbed, tmp_path):
    with ThreadPoolExecutor(1) as pool:
        pass
    with pytest.raises(hc.InputError, match="the executor does not accept work .*after shutdown"):
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    hc.sweep(specification, tmp_path / "sweep")
    assert contents(tmp_path / "sweep") == undisturbed


@pytest.mark.long
def test_an_exception_of_progress_ends_a_sweep_that_resumes(specification, undisturbed, tmp_path):
    def bored(done, _):
        if done > 200:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        hc.sweep(specification, tmp_path / "sweep", progress=bored)
    assert 2 <= done_batches(tmp_path / "sweep") < 32
    hc.sweep(specification, tmp_path / "sweep")
    assert contents(tmp_path / "sweep") == undisturbed


@pytest.mark.long
def test_a_store_that_is_removed_during_a_sweep_is_reported(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"

    def remove(done, _):
        if done > 200:
            shutil.rmtree(store, ignore_errors=True)

    with pytest.raises(hc.StoreError, match="was moved or removed during the sweep"):
        hc.sweep(specification, store, progress=remove)
    assert not store.exists()
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


@pytest.mark.long
def test_an_interrupted_sweep_resumes(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"
    process = start(specification, store)
    kill_at(process, store, 2, signal.SIGINT)
    begun = time.monotonic()
    _, told = process.communicate(timeout=60)
    assert time.monotonic() - begun < PROMPT
    assert process.returncode == 130
    assert "run the same command again to resume" in told
    assert 2 <= done_batches(store) < 32
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


LARGE = {
    "ten million points": ("forward-exponential", "beads = 5", """
        rate = {linspace = [0.001, 0.1, 10000000]}"""),
    "long chains": ("backward-exponential", "beads = 20000", """
        rate = {linspace = [1e-7, 2e-6, 64000]}"""),
    "chains that take long to make": ("uniform", "", """
        beads = {linspace = [3, 42, 40]}
        "decorated.between" = {linspace = [10, 400, 40]}
        "decorated.radius" = [0.2, 0.3]"""),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("seconds", [5, 20, 50])
@pytest.mark.parametrize("size", LARGE)
def test_an_interrupt_is_handled_at_once_in_large_sweeps(tmp_path, size, seconds):
    taper, beads, axes = LARGE[size]
    file = tmp_path / "large.toml"
    file.write_text(f'[chain]\ntaper = "{taper}"\n{beads}\n[axes]{axes}\n[sweep]\nat = "last"\n')
    process = start(file, tmp_path / "sweep", "--workers", "2")
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - begun < PROMPT


@pytest.mark.long
def test_a_full_disk_is_reported_and_the_sweep_resumes(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"
    largest = max(len(content) for content in undisturbed.values())
    # The largest chunk does not fit, all others do.
    limited = subprocess.run(
        command(specification, store), capture_output=True, text=True, timeout=120,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (largest - 1, largest - 1)),
    )  # fmt: skip
    assert limited.returncode == 1
    assert "cannot write" in limited.stderr
    assert "File too large" in limited.stderr
    assert "run the same command again to resume" in limited.stderr
    assert "Traceback" not in limited.stderr
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


def test_a_sweep_that_cannot_fit_is_rejected(specification, tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_module.shutil, "disk_usage",
                        lambda _: type("Usage", (), {"free": 1000})())  # fmt: skip
    with pytest.raises(hc.InputError, match=r"512 points need .* MB.* has 1 kB free"):
        hc.sweep(specification, tmp_path / "sweep")
    assert list(tmp_path.glob("sweep*")) == []


@pytest.mark.long
def test_two_sweeps_into_one_store_are_kept_apart(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"
    process = start(specification, store)
    while not store.exists():
        time.sleep(0.002)
    process.send_signal(signal.SIGSTOP)
    with pytest.raises(hc.InputError, match="another process is writing to"):
        hc.sweep(specification, store)
    process.kill()
    process.communicate()
    # A dead process holds no lock.
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


def test_a_store_has_one_lock_by_any_name(specification, tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "sweep")
    hc.sweep(specification, tmp_path / "sweep", shard=(31, 31))
    with (
        locked(tmp_path / "link"),
        pytest.raises(hc.InputError, match="another process is writing"),
    ):
        hc.sweep(specification, tmp_path / "sweep")


@pytest.mark.parametrize("store", ["/", ".", "/proc/sweep", "x" * 300, "x" * 300 + "/a", "a\0b"])
def test_places_where_no_store_can_be(specification, store):
    with pytest.raises(
        hc.InputError, match=r"was not changed|cannot write|must be a path|/proc has 0 bytes"
    ) as error:
        hc.sweep(specification, store)
    assert "another process" not in str(error.value)
    with pytest.raises(
        hc.InputError, match=r"not the store of a sweep|no sweep store|must be a path"
    ):
        hc.open_sweep(store)


def test_a_sweep_too_large_for_memory_or_disk_is_rejected():
    rates = {"linspace": [0.01, 0.1, 100_000]}
    given = {"chain": {"taper": "forward-exponential", "beads": 20},
             "axes": {"rate": rates, "exponent": {"linspace": [1.3, 2.0, 90_000]}}}  # fmt: skip
    begun = time.process_time()
    with pytest.raises(hc.InputError, match=r"points need \d+\.\d GiB of memory.*or give a store"):
        hc.sweep(given)
    assert time.process_time() - begun < 20.0
    given["axes"] = {"beads": [10, 10**11]}
    with pytest.raises(hc.InputError, match=r"2 points need 149\d\.\d GiB"):
        hc.sweep(given | {"chain": {"taper": "uniform"}})


def test_a_lock_ends_with_its_block(tmp_path):
    with locked(tmp_path / "sweep"):
        pass
    with locked(tmp_path / "sweep"):
        assert [file.name for file in tmp_path.iterdir()] == [".sweep.lock"]


def test_shards_merge_into_the_same_bytes(specification, undisturbed, tmp_path, run):
    shards = [tmp_path / f"{i}" for i in (1, 2, 3)]
    for i, shard in enumerate(shards[:2], start=1):
        run("sweep", specification, "--store", shard, "--shard", f"{i}/3")
    partly = run("sweep", "merge", tmp_path / "all", *shards[:2], "--json")
    assert partly.returncode == 1
    assert "lacks" in partly.stderr
    assert f"lacks {json.loads(partly.stdout)['missing']} points" in partly.stderr
    hc.sweep(specification, shards[2], shard=(3, 3))
    _, missing = hc.merge_sweeps(shards, tmp_path / "all")
    assert missing == 0
    assert contents(tmp_path / "all") == undisturbed
    with pytest.raises(hc.InputError, match="shard 4 of 3 does not exist"):
        hc.sweep(specification, tmp_path / "x", shard=(4, 3))
    assert [file.name for file in tmp_path.iterdir() if "x" in file.name] == []
    with pytest.raises(hc.InputError, match="a shard needs a store"):
        hc.sweep(specification, shard=(1, 3))


def test_a_changed_specification_is_rejected_with_the_difference(specification, tmp_path):
    store, other = tmp_path / "sweep", tmp_path / "other.toml"
    hc.sweep(specification, store, shard=(1, 31))
    before = contents(store)
    other.write_text(SPECIFICATION.replace("0.012", "0.011").replace("batch = 16", "batch = 8"))
    with pytest.raises(hc.InputError) as error:
        hc.sweep(other, store)
    assert "axes.rate.linspace: [0.004, 0.012, 64], now [0.004, 0.011, 64]" in str(error.value)
    assert "sweep.batch: 16, now 8" in str(error.value)
    assert contents(store) == before
    hc.sweep(other, tmp_path / "second", shard=(1, 31))
    with pytest.raises(hc.InputError, match="belongs to another specification"):
        hc.merge_sweeps([store, tmp_path / "second"], tmp_path / "all")


@pytest.mark.long
def test_foreign_and_damaged_files_are_not_changed(specification, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("all I have")
    with pytest.raises(
        hc.InputError, match="mine' is not the store of a sweep and was not changed"
    ):
        hc.sweep(specification, tmp_path / "mine")
    xr.Dataset({"a": ("x", [1.0])}).to_zarr(tmp_path / "other", zarr_format=3, consolidated=False)
    with pytest.raises(hc.InputError, match="other' is not the store of a sweep"):
        hc.sweep(specification, tmp_path / "other")
    (tmp_path / "file").write_text("")
    with pytest.raises(hc.InputError, match="file' is not the store of a sweep"):
        hc.open_sweep(tmp_path / "file")
    with pytest.raises(hc.InputError, match="there is no sweep store"):
        hc.open_sweep(tmp_path / "nothing")
    store = tmp_path / "sweep"
    hc.sweep(specification, store)
    chunk = next(file for file in (store / "velocity" / "c").rglob("0") if file.is_file())
    chunk.write_bytes(b"")
    with pytest.raises(hc.InputError, match="damaged: velocity/c/.* is empty; skip_damaged"):
        hc.sweep(specification, store)
    (store / "velocity" / "zarr.json").write_text("{")
    with pytest.raises(hc.InputError, match="is damaged.*move the store away"):
        hc.open_sweep(store)
    assert (tmp_path / "mine" / "thesis.tex").read_text() == "all I have"


DAMAGES = {
    "cut": lambda content: content[: len(content) // 2],
    "empty": lambda _: b"",
    "flipped": lambda content: bytes([*content[:-9], content[-9] ^ 1, *content[-8:]]),
    "zeros": lambda content: bytes(len(content)),
}


@pytest.mark.long
@pytest.mark.parametrize("how", DAMAGES)
def test_every_damaged_file_is_named(how, tmp_path):
    store = tmp_path / "sweep"
    axes = {"rate": [0.01, 0.02, 0.05], "beads": [15, 40], "gravity": [0.0]}
    hc.sweep({"chain": {"taper": "forward-linear"}, "axes": axes,
              "sweep": {"methods": ["simulate", "bca"], "batch": 2}}, store)  # fmt: skip
    for file in [file for file in store.rglob("*") if file.is_file()]:
        good = file.read_bytes()
        file.write_bytes(DAMAGES[how](good))
        with pytest.raises(hc.InputError, match="is damaged"):
            SweepStore(store).check()
        for arguments in (["export", str(store), str(tmp_path / "sweep.csv")],
                          ["status", str(store)]):  # fmt: skip
            told = invoke(arguments)
            assert isinstance(told.exception, hc.InputError), (arguments, file)
            assert not (tmp_path / "sweep.csv").exists()
        file.write_bytes(good)
    SweepStore(store).check()
    for name in ("rate", "gravity"):
        good = (store / name / "c" / "0").read_bytes()
        (store / name / "c" / "0").unlink()
        with pytest.raises(hc.InputError, match=f"damaged: {name}/c/0 is missing"):
            hc.open_sweep(store)
        (store / name / "c" / "0").write_bytes(good)


def invoke(arguments):
    from click.testing import CliRunner

    from hertzchain.cli.sweep import sweep

    return CliRunner().invoke(sweep, arguments)


@pytest.mark.long
def test_damaged_batches_are_computed_again_on_request(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"
    hc.sweep(specification, store)
    chunks = sorted(file for file in (store / "velocity" / "c").rglob("*") if file.is_file())
    chunks[3].write_bytes(b"")
    chunks[7].unlink()
    shutil.copy(chunks[8], chunks[9])
    (store / "digest" / "c" / "30" / "0").write_bytes(b"half")
    said = r"velocity/c/11/0/0/0 is empty, and files of 3 more batches are damaged; skip_damaged"
    with pytest.raises(hc.InputError, match=said):
        hc.sweep(specification, store)
    with pytest.warns(hc.DamageWarning, match=r"4 batches are omitted as missing, the first"):
        hc.sweep(specification, store, skip_damaged=True)
    assert contents(store) == undisturbed


@pytest.mark.long
def test_the_rest_of_a_damaged_store_is_readable_on_request(tmp_path):
    store, csv, picture = (tmp_path / name for name in ("sweep", "sweep.csv", "sweep.svg"))
    axes = {"rate": [0.01, 0.02, 0.03], "beads": [10, 20]}
    settings = {"batch": 2, "keep": ["velocity", "energy"]}
    given = {"chain": {"taper": "forward-linear"}, "axes": axes, "sweep": settings}
    whole = hc.sweep(given, store).load()
    (store / "velocity" / "c" / "1" / "0" / "0" / "0").unlink()
    for arguments in (["status", str(store)], ["export", str(store), str(csv)],
                      ["plot", str(store), str(picture), "--at", "bead=5"],
                      ["merge", str(tmp_path / "all"), str(store)]):  # fmt: skip
        assert "velocity/c/1/0/0/0 is missing" in str(invoke(arguments).exception)
        with (
            warnings.catch_warnings(action="ignore", category=hc.IncompleteWarning),
            pytest.warns(hc.DamageWarning, match="1 batch is omitted as missing"),
        ):
            told = invoke([*arguments, "--skip-damaged"])
        assert told.exception is None or isinstance(told.exception, SystemExit)
    assert picture.exists()
    rows = csv.read_text().splitlines()
    assert sum(row.endswith(",,0") for row in rows) == 10 + 20
    with pytest.warns(hc.DamageWarning):
        rest = hc.open_sweep(store, skip_damaged=True).load()
    lost = rest.status == 0
    assert lost.values.tolist() == [[[False]] * 2, [[True]] * 2, [[False]] * 2]
    for name in ("velocity", "energy"):
        assert bool(rest[name].where(lost, drop=True).isnull().all())
        xr.testing.assert_equal(rest[name].where(~lost), whole[name].where(~lost))
    xr.testing.assert_equal(hc.open_sweep(tmp_path / "all").load(), rest)


@pytest.mark.long
def test_a_chunk_that_is_damaged_later_is_named_when_it_is_read(specification, tmp_path):
    store = tmp_path / "sweep"
    hc.sweep(specification, store)
    found = hc.open_sweep(store)
    chunk = store / "velocity" / "c" / "5" / "0" / "0" / "0"
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 1
    chunk.write_bytes(content)
    assert found.velocity[0].shape == (8, 2, 100)
    float(found.velocity[0, 0, 0, 0])
    with pytest.raises(hc.InputError, match="velocity/c/5/0/0/0 is not as it was written"):
        found.velocity.load()


@pytest.mark.long
def test_batches_of_another_sweep_are_noticed(specification, tmp_path):
    """All files of a batch agree with each other, but they are not of this sweep."""
    store, other = tmp_path / "sweep", tmp_path / "other"
    hc.sweep(specification, store)
    changed = tmp_path / "changed.toml"
    changed.write_text(SPECIFICATION.replace("0.012", "0.011"))
    hc.sweep(changed, other)
    for name in ("velocity", "peak_force", "status"):
        shutil.rmtree(store / name / "c" / "4")
        shutil.copytree(other / name / "c" / "4", store / name / "c" / "4")
    shutil.copy(other / "digest/c/4/0", store / "digest/c/4/0")
    with pytest.raises(hc.InputError, match="c/4/0.* is not as it was written"):
        hc.open_sweep(store).load()


@pytest.mark.long
def test_files_of_others_are_left_alone(specification, tmp_path):
    store, beside = tmp_path / "sweep", tmp_path / ".sweep.new"
    (beside / "a").mkdir(parents=True)
    (beside / "a" / "thesis.tex").write_text("all I have")
    with pytest.raises(hc.InputError, match=r"\.sweep\.new' is needed to create the new store"):
        hc.sweep(specification, store)
    assert (beside / "a" / "thesis.tex").read_text() == "all I have"
    shutil.rmtree(beside)
    hc.sweep(specification, store)
    mine = store / "velocity" / "thesis.partial"
    mine.write_text("all I have")
    with pytest.raises(hc.InputError, match=r"thesis\.partial' looks like a temporary file, but"):
        hc.sweep(specification, store)
    assert mine.read_text() == "all I have"


@pytest.mark.long
@pytest.mark.parametrize("files", range(9))
def test_a_store_that_was_not_made_to_its_end_is_made_again(
    specification, undisturbed, tmp_path, files
):
    unfinished = tmp_path / ".sweep.new"
    unfinished.mkdir()
    made = sorted(name for name in undisturbed if "/c/" not in name or name.startswith("rate"))
    for name in ["zarr.json", *(name for name in made if name != "zarr.json")][:files]:
        (unfinished / name).parent.mkdir(parents=True, exist_ok=True)
        (unfinished / name).write_bytes(undisturbed[name])
    hc.sweep(specification, tmp_path / "sweep", shard=(31, 31))
    assert not unfinished.exists()


def test_other_versions_are_rejected_with_both_named(specification, tmp_path, monkeypatch):
    store = tmp_path / "sweep"
    with monkeypatch.context() as changed:
        changed.setattr("hertzchain.sweeps.dataset.__version__", "0.0.9")
        hc.sweep(specification, store, shard=(1, 31))
    for use in (lambda: hc.sweep(specification, store),
                lambda: hc.merge_sweeps([store], tmp_path / "all")):  # fmt: skip
        with pytest.raises(
            hc.InputError, match=rf"begun by hertzchain 0\.0\.9, this is {hc.__version__}"
        ):
            use()
    assert not (tmp_path / "all").exists()

    class Elsewhere(ThreadPoolExecutor):
        def submit(self, function, *arguments):
            def older():
                result = function(*arguments)
                object.__setattr__(result, "version", "0.0.9")
                return result

            return super().submit(older)

    with Elsewhere(1) as pool, pytest.raises(hc.InputError, match=r"worker has hertzchain 0\.0\.9"):
        hc.sweep(specification, tmp_path / "new", executor=pool)


def test_data_reach_the_disk_before_what_vouches_for_them(tmp_path, monkeypatch):
    store, settled = tmp_path / "sweep", []

    def settle(descriptor):
        file = Path(f"/proc/self/fd/{descriptor}").readlink()
        name = file.relative_to(store).parts[0]
        done = len([*(store / "status").glob("c/*/*/0")]), len([*store.glob("digest/c/*/0")])
        settled.append((name, *done))

    monkeypatch.setattr(os, "fsync", settle)
    axes = {"rate": [0.005, 0.03], "beads": [20, 60]}
    hc.sweep({"chain": {"taper": "forward-linear"}, "axes": axes,
              "sweep": {"keep": ["velocity", "peak_force"], "batch": 1}}, store)  # fmt: skip
    for batch in range(4):
        for name in ("velocity", "peak_force"):
            assert (name, batch, batch) in settled
        assert ("status", batch + 1, batch) in settled
        assert ("digest", batch + 1, batch) in settled
    assert {name for name, *_ in settled} == {
        "velocity", "peak_force", "reason", "status", "digest"
    }  # fmt: skip


@pytest.mark.long
def test_a_store_can_be_read_while_it_grows(specification, tmp_path):
    store, seen = tmp_path / "sweep", []

    def look(done, total):
        if 0 < done < total and not seen:
            found = hc.open_sweep(store)
            seen.append((done, int((found.status != 0).all("approach").sum())))
            assert SweepStore(store).counts()["missing"] == total - seen[0][1]

    hc.sweep(specification, store, progress=look)
    assert seen[0][1] >= seen[0][0] > 0


@pytest.mark.long
def test_any_executor_gives_the_same_bytes(specification, undisturbed, tmp_path):
    with executors.local_pool("processes", 2) as pool:
        hc.sweep(specification, tmp_path / "sweep", executor=pool)
    assert contents(tmp_path / "sweep") == undisturbed


@pytest.mark.long
def test_in_memory_is_the_same(specification, tmp_path):
    pairs = {"taper": ["forward-linear", "backward-linear"], "rate": [0.08, 0.05]}
    zipped = {"chain": {"beads": 20}, "axes": pairs, "sweep": {"combine": "zip"}}
    for number, given in enumerate((specification, zipped)):
        stored = hc.sweep(given, tmp_path / f"{number}")
        xr.testing.assert_equal(hc.sweep(given), stored.load())
    told = invoke(["status", str(tmp_path / "1")]).stdout
    for place in ("point = 1", "approach = propagate", "taper = forward-linear", "rate = 0.08"):
        assert place in told


@pytest.mark.long
def test_a_process_that_writes_half_a_chunk_is_cleaned_up(specification, undisturbed, tmp_path):
    store = tmp_path / "sweep"
    hc.sweep(specification, store, shard=(1, 2))
    left = store / "velocity" / "c" / "0" / "0" / "0" / f"0.{32 * 'b'}.partial"
    left.write_bytes(b"half")
    hc.sweep(specification, store)
    assert contents(store) == undisturbed


def test_status_tells_how_far_and_why(specification, tmp_path, run):
    store = tmp_path / "sweep"
    hc.sweep(specification, store, shard=(32, 32))
    told = run("sweep", "status", store)
    assert told.returncode == 1
    assert "496 missing" in told.stdout
    assert "reach zero at bead" in told.stdout
    assert "rate = 0.011" in told.stdout


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two worker processes on loopback, that end with the test."""
    base = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    scheduler = [*base, "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                 "--scheduler-file", str(tmp_path / "scheduler.json")]  # fmt: skip
    worker = [sys.executable, "-m", "distributed.cli.dask_worker",
              "--scheduler-file", str(tmp_path / "scheduler.json"), "--host", "127.0.0.1",
              "--no-dashboard", "--no-nanny", "--nthreads", "1",
              "--local-directory", str(tmp_path / "dask")]  # fmt: skip
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    processes = [subprocess.Popen(scheduler, **quiet)]
    try:
        while not (tmp_path / "scheduler.json").exists():
            time.sleep(0.05)
        processes += [subprocess.Popen(worker, **quiet) for _ in range(2)]
        yield tmp_path / "scheduler.json", processes
    finally:
        for process in processes[::-1]:
            process.kill()
            process.wait()


@pytest.mark.long
def test_a_dask_worker_that_is_killed_costs_nothing(
    cluster, specification, undisturbed, tmp_path, monkeypatch
):
    file, processes = cluster
    address = json.loads(file.read_text())["address"]
    store = tmp_path / "sweep"
    done = []

    def kill(count, _):
        done.append(count)
        if count > 300 and processes[1].poll() is None:
            processes[1].kill()

    monkeypatch.setattr(executors, "PATIENCE", 60.0)
    with executors.dask_pool(address, workers=2) as pool:
        hc.sweep(specification, store, executor=pool, progress=kill)
    assert processes[1].poll() is not None
    assert done == sorted(set(done))
    assert contents(store) == undisturbed


def test_a_scheduler_that_does_not_answer_is_reported_soon(monkeypatch):
    monkeypatch.setattr(executors, "PATIENCE", 1.0)
    begun = time.monotonic()
    said = "no dask scheduler answers at 'tcp://127.0.0.1:1'"
    with pytest.raises(hc.InputError, match=said), executors.dask_pool("tcp://127.0.0.1:1"):
        pass
    assert time.monotonic() - begun < 30.0


@pytest.mark.parametrize("address", ["http://127.0.0.1:1", "nonsense", "", "tcp://127.0.0.1", 3])
def test_an_invalid_address_is_rejected_immediately(address):
    begun = time.monotonic()
    said = "a scheduler's address looks like tcp://127.0.0.1:8786, got"
    with pytest.raises(hc.InputError, match=said), executors.dask_pool(address):
        pass
    said = "tls://127.0.0.1:1 needs certificates"
    with pytest.raises(hc.InputError, match=said), executors.dask_pool("tls://127.0.0.1:1"):
        pass
    assert time.monotonic() - begun < PROMPT


def test_options_of_the_command_that_contradict(specification, run):
    for options, said in (
        (["--shard", "2"], "--shard must look like 2/8, got '2'"),
        (["--scheduler", "tcp://x:1", "--processes"], "--scheduler has its own workers"),
        (["--workers", "0"], "workers must be a whole number of at least 1, got 0"),
    ):
        told = run("sweep", specification, *options)
        assert told.returncode == 2
        assert said in told.stderr


@pytest.mark.long
def test_chunks_are_batches(specification, tmp_path):
    store = tmp_path / "sweep"
    hc.sweep(specification, store)
    opened = SweepStore(store)
    assert opened.grid == (32, 1)
    assert len(opened.missing()) == 0
    assert opened.counts() == {
        "missing": 0,
        "done": int((hc.open_sweep(store).status == 1).all("approach").sum()),
        "failed": int((hc.open_sweep(store).status == 2).any("approach").sum()),
    }
    assert opened.counts()["failed"] > 0
