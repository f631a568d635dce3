import signal

import matplotlib
import pytest
from hypothesis import settings

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
