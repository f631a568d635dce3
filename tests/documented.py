"""The public functions: those that `hertzchain` exports or the API reference documents."""

import inspect
import re
from importlib import import_module
from pathlib import Path

import hertzchain as hc
from hertzchain.chain.laws import Loss

# Methods that only authors of a law need (docs/how-to/extend.md).
OF_AUTHORS = {
    "damper", "largest_overlap", "loading_force", "loading_overlap", "resolved", "row",
    "stored_energy", "strength",
}  # fmt: skip
REFERENCE = Path(__file__).parents[1] / "docs" / "reference" / "api.md"


def directives():
    """The objects that the API reference documents."""
    module = "hertzchain"
    text = REFERENCE.read_text("utf-8")
    for match in re.finditer(r"^\.\. (\w+):: +([\w.]+)(?:\(\))?\n((?:   :.*\n)*)", text, re.M):
        kind, name, options = match.groups()
        if kind == "currentmodule":
            module = name
        elif kind == "automodule" and ":members:" in options:
            members = re.search(r":members: +(.+)", options)
            loaded = import_module(name)
            for member in members.group(1).split(", ") if members else vars(loaded):
                own = getattr(getattr(loaded, member), "__module__", "") == name
                if own and not member.startswith("_"):
                    yield getattr(loaded, member)
        elif kind in ("autofunction", "autoclass", "autoexception"):
            home, _, member = name.rpartition(".")
            yield getattr(import_module(home or module), member)


def _overrides(item, name):
    """Whether a method is described by the class from which its own is derived."""
    return sum(name in vars(base) for base in item.__mro__) > 1


def public_functions():
    """Functions and methods by name, ``hertzchain.theory.bca.bca`` or ``...Pulse.compare``."""
    found = {}
    for item in [*map(hc.__getattr__, hc.__all__), *directives()]:
        if inspect.isfunction(item):
            found[f"{item.__module__}.{item.__qualname__}"] = item
        elif inspect.isclass(item) and item.__module__.startswith("hertzchain"):
            for name, method in inspect.getmembers(item, inspect.isfunction):
                own = not name.startswith("_") and method.__module__.startswith("hertzchain")
                author = issubclass(item, Loss) and name in OF_AUTHORS
                if own and not author and not _overrides(item, name):
                    found[f"{method.__module__}.{method.__qualname__}"] = method
    return found
