"""Fixtures of all tests, including the examples of docstrings and pages."""

import pytest


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    from matplotlib import pyplot as plt

    plt.close("all")
