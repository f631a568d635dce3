"""Data of the page before the first result: schema, materials, gallery, limits."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, Final

from .. import __version__
from ..chain.materials import catalogue
from ..chain.tapers import TAPERS
from ..pulse.quantities import QUANTITIES
from ..store.chain_schema import chain_schema
from ..theory.catalogue import THEORIES
from ..units import PERCENT, UNITS, converted
from .documents import DEFAULT, MAX_BEADS, chain_of

# Titles of tables of chain files, and of the ways to describe beads; others have their own names.
TITLES: Final = {
    "struck_by": "Strikers", "left_wall": "Left wall", "right_wall": "Right wall",
    "loss": "Loss in contacts", "drive": "Drive", "decorated": "Small beads between",
    "with_defects": "Defects", "with_scatter": "Random scatter",
    "with_contacts": "Shapes of contacts",
}  # fmt: skip
FORMS: Final = {
    "taper": "a taper and its rate", "first": "end radii", "first_diameter": "end diameters",
    "radii": "a list of radii", "diameters": "a list of diameters", "cell": "a repeated cell",
    "mass_ratio": "a dimer’s mass ratio",
}  # fmt: skip
# Number of beads in a picture of the gallery.
MAX_THUMBNAIL: Final = 40


@cache
def gallery() -> list[dict[str, Any]]:
    """Examples with a title, a sentence and a document; radii for a small picture."""
    text = (files("hertzchain.app") / "gallery.toml").read_text("utf-8")
    found = []
    for entry in tomllib.loads(text)["example"]:
        document = {name: entry[name] for name in ("chain", "materials") if name in entry}
        radii = chain_of(document).radii[:MAX_THUMBNAIL]
        found.append(
            {"title": entry["title"], "look_for": entry["look_for"], "document": document,
             "other": {"chain": entry["other"]} if "other" in entry else None,
             "view": entry.get("view", {}), "radii": [float(f"{r:.3g}") for r in radii]}
        )  # fmt: skip
    return found


def _factors() -> dict[str, float]:
    """Factors to SI of the units that the page shows; that of a stiffness depends on the chain."""
    return {PERCENT: 0.01} | {
        unit: converted(dimension, 1.0, unit, units[0])
        for dimension, units in UNITS.items() if dimension != "stiffness" for unit in units
    }  # fmt: skip


def about(document: object = None) -> dict[str, Any]:
    """Description of the program for the page, with the initial document."""
    return {
        "version": __version__,
        "schema": chain_schema(),
        "titles": TITLES,
        "forms": FORMS,
        "tapers": {name: dict(taper.symbols) for name, taper in TAPERS.items()},
        "materials": list(catalogue()),
        "quantities": {
            each.name: {"description": each.description, "symbol": each.symbol, "unit": each.unit,
                        "per": each.per, "estimate": each.estimate}
            for each in QUANTITIES.values()
        },
        "factors": _factors(),
        "theories": [*THEORIES, "effective-chain"],
        "gallery": gallery(),
        "max_beads": MAX_BEADS,
        "document": DEFAULT if document is None else document,
    }  # fmt: skip
