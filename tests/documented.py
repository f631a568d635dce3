"""The public functions: those that `hertzchain` exports or the API reference documents.

Examples see no names of their module (``conftest.py``), so that readers can paste them:

>>> "inspect" in globals()
False
"""

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


def public_objects():
    """Everything that `hertzchain` exports or the API reference documents."""
    pages = [item for page in PAGES for item in documented(DOCS / "reference" / page)]
    return [*map(hc.__getattr__, hc.__all__), *pages]


def public_classes():
    """Classes of the package by name, ``hertzchain.chain.walls.Wall``."""
    classes = filter(inspect.isclass, public_objects())
    return {f"{c.__module__}.{c.__qualname__}": c for c in classes if "hertz" in c.__module__}


def public_functions():
    """Functions and methods by name, ``hertzchain.theory.bca.bca`` or ``...Pulse.compare``."""
    found = {}
    for item in public_objects():
        if inspect.isfunction(item):
            found[f"{item.__module__}.{item.__qualname__}"] = item
        elif inspect.isclass(item) and item.__module__.startswith("hertzchain"):
            for name, method in inspect.getmembers(item, inspect.isfunction):
                own = not name.startswith("_") and method.__module__.startswith("hertzchain")
                author = issubclass(item, Loss) and name in OF_AUTHORS
                if own and not author and not _overrides(item, name):
                    found[f"{method.__module__}.{method.__qualname__}"] = method
    return found
