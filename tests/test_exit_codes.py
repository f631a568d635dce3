"""The exit code depends on the kind of failure, not on the command."""

import contextlib
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

import hertzchain as hc
from hertzchain.paper import report_folder
from hertzchain.store.file_lock import lock
from hertzchain.store.sweep_store import locked

SWEEP = {
    "chain": {"taper": "uniform"}, "axes": {"beads": [10, 12, 14]}, "sweep": {"batch": 1}
}  # fmt: skip
SPECIFICATION = """
[chain]
taper = "uniform"
[axes]
beads = [10, 12, 14]
[sweep]
batch = 1
"""
STREAM = ("simulate", "--beads", 4, "--until", 9, "--times", 10, "--stream")


@pytest.fixture
def run(run, monkeypatch, tmp_path):
    """Runs a command in a folder with a specification and its store."""
    monkeypatch.chdir(tmp_path)
    Path("sweep.toml").write_text(SPECIFICATION)
    hc.sweep(SWEEP, "sweep.zarr")
    return run


def test_errors_of_values_have_no_lines_about_the_usage(run):
    for command in (
        ("pulse", "--rate", 0.05),
        ("simulate", "--material", "steel-52100", "--diameter", 20),
        ("simulate", "--material", "stel", "--diameter", "20 mm"),
        ("pulse", "--beads", "many"),
    ):
        code, out, err = run(*command)
        assert (code, out) == (2, "")
        assert err.startswith("Error: ")
    assert run("pulse", "--bead", 5)[2].startswith("Usage: ")


def test_a_place_that_cannot_be_written_is_bad_input(run):
    for name in ("dir.csv", "dir.svg"):
        Path(name).mkdir()
    Path("file").touch()
    for command in (
        ("simulate", "--beads", 4, "--out", "dir.csv"),
        ("simulate", "--beads", 4, "--plot", "dir.svg"),
        ("pulse", "--beads", 4, "--plot", "dir.svg"),
        (*STREAM, "file"),
        (*STREAM, "file/run"),
        ("sweep", "sweep.toml", "--store", "file/store"),
        ("sweep", "merge", "file/store", "sweep.zarr"),
        ("sweep", "export", "sweep.zarr", "dir.csv"),
        ("sweep", "plot", "sweep.zarr", "dir.svg", "--at", "bead=3"),
        ("reproduce", "--only", "table3", "--out", "file"),
    ):
        code, out, err = run(*command)
        assert (code, out) == (2, ""), (command, err)
        assert err.startswith("Error: "), command


def test_a_plot_with_too_many_axes_names_the_option(run):
    specification = {
        **SWEEP, "chain": {"taper": "forward-exponential"},
        "axes": {"beads": [10, 12], "rate": [0.02, 0.05]},
    }  # fmt: skip
    hc.sweep(specification, "three.zarr")
    code, out, err = run("sweep", "plot", "three.zarr", "a.svg")
    assert (code, out) == (2, "")
    assert "choose a value of the others, such as --at beads=10" in err


def test_damaged_input_is_bad_input(run):
    assert run(*STREAM, "run")[0] == 0
    part = Path("run/part-000001.nc")
    part.write_bytes(part.read_bytes()[:-1])
    Path("sweep.zarr/velocity/c/1/0/0").unlink()
    Path("chain.toml").write_bytes(bytes(range(256)))
    for command in (
        (*STREAM, "run"),
        ("sweep", "sweep.toml"),
        ("sweep", "status", "sweep.zarr"),
        ("sweep", "export", "sweep.zarr", "a.csv"),
        ("sweep", "plot", "sweep.zarr", "a.svg", "--at", "bead=3"),
        ("sweep", "merge", "b.zarr", "sweep.zarr"),
        ("pulse", "chain.toml"),
    ):
        code, out, err = run(*command)
        assert (code, out) == (2, ""), (command, err)
        assert ("is damaged" in err) is (command[0] != "pulse"), command
    assert not any(map(os.path.exists, ("a.csv", "a.svg", "b.zarr")))


def test_a_place_in_use_is_bad_input(run):
    for held, command in (
        (locked("sweep.zarr"), ("sweep", "sweep.toml")),
        (locked("b.zarr"), ("sweep", "merge", "b.zarr", "sweep.zarr")),
        (lock(Path("run/.lock"), "run"), (*STREAM, "run")),
        (
            report_folder.reserved(Path("report")),
            ("reproduce", "--only", "table3", "--out", "report"),
        ),
    ):
        with held:
            code, out, err = run(*command)
        assert (code, out) == (2, ""), (command, err)
        assert "another process is writing to" in err, command


@contextlib.contextmanager
def files_of_at_most(size):
    """For the time of a ``with`` block, a disk that takes small files only."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.long
@pytest.mark.parametrize(
    "command",
    [
        ("simulate", "--beads", 9, "--out", "a.csv"),
        ("simulate", "--beads", 9, "--plot", "a.svg"),
        (*STREAM, "run"),
        ("sweep", "sweep.toml", "--store", "b.zarr"),
        ("sweep", "merge", "b.zarr", "sweep.zarr"),
        ("sweep", "export", "sweep.zarr", "a.csv"),
        ("reproduce", "--only", "table3", "--out", "report"),
    ],
    ids=lambda command: " ".join(map(str, command[:2])),
)
def test_a_full_disk_is_a_failure(run, command):
    # Compiled before: numba's cache does not fit on such a disk either.
    run("simulate", "--beads", 9)
    with files_of_at_most(300):
        code, out, err = run(*command)
    assert (code, out) == (1, "")
    assert "File too large" in err


@pytest.mark.long
@pytest.mark.parametrize("stdout", ["/dev/full", None])
def test_results_that_cannot_be_printed_are_a_failure(stdout):
    command = f"{sys.executable} -m hertzchain pulse --beads 4 " + (
        ">&-" if stdout is None else f"> {stdout}"
    )
    done = subprocess.run(command, shell=True, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert "cannot write the results" in done.stderr
