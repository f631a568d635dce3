import re
import signal
import sys
import zlib
from typing import NamedTuple

import matplotlib
import pytest
from hypothesis import settings
from random_chains import Tally

import hertzchain as hc

matplotlib.use("Agg")
# Started in the background of a shell, tests and the commands they interrupt would be deaf to it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
# Kernels compile at the first example; machines are shared.
# The same examples in every run: a chain that fails is found again.
settings.register_profile("hertzchain", deadline=None, derandomize=True)
settings.load_profile("hertzchain")
# Files that take longest come first, so that they do not run on a single worker at the end.
LONGEST = (
    "test_sweep_robustness.py",
    "check_console_blocks.py",
    "test_random_chains.py",
    "test_propagation.py",
)


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.path.name not in LONGEST)


class Done(NamedTuple):
    """Exit code, standard output and standard error of a command."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(monkeypatch, capsys):
    """Runs a command line in this process, as ``hertzchain`` does; takes a second less to start."""
    from hertzchain import cli

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["hertzchain", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            cli.main()
        out, err = capsys.readouterr()
        err = re.sub("hertzchain: compiling once, about .* s\n", "", err)
        return Done(stopped.value.code, out, err)

    return call


@pytest.fixture(scope="session")
def uniform_run():
    return hc.simulate(hc.Chain.uniform(100))


# Random chains of a check in `make test`, and in `make test-long`.
SHORT, LONG = 16, 300


@pytest.fixture(params=["short", pytest.param("long", marks=pytest.mark.long)])
def try_chains(request, record_property):
    """``try_chains(deviation, most, **options of random_case)``: a check on many random chains."""
    tally = Tally(request.node.name)

    def run(deviation, most, fewer=1, **options):
        count = (SHORT if request.param == "short" else LONG) // fewer
        # Other chains for each check, the same in every run.
        first = 1000 * (zlib.crc32(request.node.name.encode()) % 10_000)
        try:
            tally.try_all(range(first, first + count), deviation, most, **options)
        finally:
            counts = {"tried": tally.tried, "failed": len(tally.failures), "text": str(tally)}
            record_property("tally", counts)

    return run


def pytest_terminal_summary(terminalreporter):
    """How many random chains were tried, and how many failed; each check by itself with ``-v``."""
    kinds = ("passed", "failed", "xfailed")
    reports = (each for kind in kinds for each in terminalreporter.getreports(kind))
    tallies = [tally for each in reports for name, tally in each.user_properties if name == "tally"]
    if not tallies:
        return
    tried, failed = (sum(tally[name] for tally in tallies) for name in ("tried", "failed"))
    terminalreporter.section(f"random chains: {tried} tried, {failed} failed")
    if failed or terminalreporter.verbosity > 0:
        terminalreporter.write_line("\n".join(sorted(tally["text"] for tally in tallies)))
