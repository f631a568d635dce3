"""The public functions: those that `hertzchain` exports or the API reference documents."""

import inspect
from importlib import import_module
from pathlib import Path

from reference_pages import OF_AUTHORS, entries

import hertzchain as hc
from hertzchain.chain.laws import Loss

DOCS = Path(__file__).parents[1] / "docs"

# The package `hertzchain.paper` is described on a separate page.
PAGES = ("api.md", "closed_forms_api.md", "extension_api.md")


def documented(page):
    """The objects that one page of the API reference documents."""
    return [getattr(import_module(module), name) for module, name in entries(page)]


def _overrides(item, name):
    """Whether a method is described by the class from which its own is derived."""
    return sum(name in vars(base) for base in item.__mro__) > 1


def public_functions():
    """Functions and methods by name, ``hertzchain.theory.bca.bca`` or ``...Pulse.compare``."""
    found = {}
    pages = [item for page in PAGES for item in documented(DOCS / "reference" / page)]
    for item in [*map(hc.__getattr__, hc.__all__), *pages]:
        if inspect.isfunction(item):
            found[f"{item.__module__}.{item.__qualname__}"] = item
        elif inspect.isclass(item) and item.__module__.startswith("hertzchain"):
            for name, method in inspect.getmembers(item, inspect.isfunction):
                own = not name.startswith("_") and method.__module__.startswith("hertzchain")
                author = issubclass(item, Loss) and name in OF_AUTHORS
                if own and not author and not _overrides(item, name):
                    found[f"{method.__module__}.{method.__qualname__}"] = method
    return found
