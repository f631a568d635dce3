import matplotlib
import pytest
from hypothesis import settings

import hertzchain as hc

matplotlib.use("Agg")
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
