"""Fixtures of all tests, including the examples of docstrings and pages."""

import doctest
import platform

import pytest

# Notebooks are executed by the build of the documentation, and so are the files made from
# them.  Other pages are made by the build, which `make test` runs beside the tests.
collect_ignore = [
    "docs/examples", "docs/gallery", "docs/_build", "docs/_generated", "docs/reference/api",
    "docs/conf.py", "docs/loaded_kernels.py",
]  # fmt: skip

REFERENCE = ("x86_64", "AMD64")


@pytest.fixture(autouse=True)
def _examples_can_be_pasted(request):
    """Examples see no name of their module, so that they import what they use."""
    # The check of console blocks is an example of its own module.
    if isinstance(request.node, pytest.DoctestItem) and request.node.path.parent.name != "docs":
        request.node.dtest.globs.clear()


@pytest.fixture(autouse=True)
def _examples_print_what_readers_get(request):
    """Examples are compared character by character on the processors on which they were written.

    Others round differently, which can change the last digit of a number.
    """
    if isinstance(request.node, pytest.DoctestItem) and platform.machine() not in REFERENCE:
        for example in request.node.dtest.examples:
            example.options.setdefault(doctest.OPTIONFLAGS_BY_NAME["NUMBER"], True)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    from matplotlib import pyplot as plt

    plt.close("all")
