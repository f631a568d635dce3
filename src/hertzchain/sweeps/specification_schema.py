"""The schema of a specification: the tables that it has beside those of a chain file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from hertzchain.pulse.quantities import QUANTITIES
from hertzchain.store.chain_schema import Key, Section, chain_schema, section_as_dict
from hertzchain.sweeps.methods import METHODS
from hertzchain.sweeps.specification import WALL_QUANTITIES

# Tables and keys of a specification.
TABLES: Final = ("title", "chain", "materials", "axes", "points", "sweep", "method")

_SWEEP: Final = (
    Key("combine", "choice", "every combination of values, or the first with the first, and so on",
        default="product", choices=("product", "zip")),
    Key("methods", "choice", "simulations and theories", default="propagate", choices=METHODS,
        per="item", one_for_all=True),
    Key("keep", "choice", "quantities of a pulse, or of the right wall", default="velocity",
        choices=(*QUANTITIES, *WALL_QUANTITIES), per="item", one_for_all=True),
    Key("at", "choice", "beads to keep: every, the last, or a list of their numbers",
        default="every", choices=("every", "last")),
    Key("errors", "choice", "quantities whose relative errors are kept", choices=(*QUANTITIES,),
        per="item", one_for_all=True),
    Key("reference", "choice", "method from which errors are measured; the first by default",
        choices=METHODS),
    Key("batch", "integer", "number of points computed together", least=1, most=10**6),
)  # fmt: skip
_METHOD: Final = (
    Key("rtol", "number", "tolerated error of a step", above=0.0),
    Key("until", "number", "time to stop at", dimension="time", above=0.0),
    Key("max_steps", "integer", "step limit", least=1),
)
SECTIONS: Final[Mapping[str, Section]] = MappingProxyType(
    {
        "sweep": Section("sweep", "what is computed and kept", _SWEEP),
        "method": Section("method", "options of the simulations", _METHOD),
    }
)
SETTINGS: Final[Mapping[str, Key]] = MappingProxyType({key.name: key for key in _SWEEP})
OPTIONS: Final = tuple(key.name for key in _METHOD)


def specification_schema() -> dict[str, Any]:
    """The schema of specifications in plain types, with that of chain files in it.

    Returns
    -------
    dict
        As of `hertzchain.store.chain_schema.chain_schema`.

    Examples
    --------
    >>> found = specification_schema()["sections"]
    >>> found["sweep"]["keys"][0]["choices"], "chain.loss" in found
    (['product', 'zip'], True)
    """
    found = chain_schema()
    found["sections"] |= {name: section_as_dict(each) for name, each in SECTIONS.items()}
    return found
