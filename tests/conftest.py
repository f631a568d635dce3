import signal
import zlib

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
settings.register_profile("hertzchain", deadline=None)
settings.load_profile("hertzchain")


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    from matplotlib import pyplot as plt

    plt.close("all")


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
            record_property("tally", str(tally))

    return run


def pytest_terminal_summary(terminalreporter):
    """What was tried on random chains, and how much of it failed."""
    reports = (each for kind in ("passed", "failed") for each in terminalreporter.getreports(kind))
    tallies = [text for each in reports for name, text in each.user_properties if name == "tally"]
    if tallies:
        terminalreporter.section("random chains")
        terminalreporter.write_line("\n".join(sorted(tallies)))
