"""Data of the page before the first result: schema, materials, gallery, limits."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any, Final

from .. import __version__
from ..chain.materials import catalogue
from ..chain.random_radii import BALL_GRADES
from ..chain.tapers import TAPERS
from ..pulse.quantities import QUANTITIES
from ..simulation.run_pulse import moving_first
from ..store.chain_schema import chain_schema
from ..theory.catalogue import THEORIES
from ..units import PERCENT, UNITS, converted
from .documents import MAX_BEADS, chain_of

# Titles of tables of chain files, and of the ways to describe beads; others have their own names.
TITLES: Final = {
    "struck_by": "Strikers", "left_wall": "Left wall", "right_wall": "Right wall",
    "loss": "Loss in contacts", "drive": "Drive", "decorated": "Small beads between",
    "with_defects": "Defects", "with_scatter": "Random scatter",
    "with_contacts": "Shapes of contacts", "cap": "Cap or free body at the end",
}  # fmt: skip
# Table of which files keep the entries, but which has no controls: `struck_by` adds strikers.
WITHOUT_CONTROLS: Final = "chain.striker_properties"
FORMS: Final = {
    "taper": "a taper and its rate", "first": "end radii", "first_diameter": "end diameters",
    "radii": "a list of radii", "diameters": "a list of diameters",
    "cell": "a cell of radii", "cell_diameters": "a cell of diameters",
    "mass_ratio": "a dimer’s mass ratio",
}  # fmt: skip
# Usual ranges of sliders by dimension, in the units that the page shows, in SI units and scaled.
RANGES_OF_DIMENSIONS: Final = {
    "length": ((0.1, 50), (0.05, 5)), "velocity": ((0.01, 20), (0.01, 5)),
    "force": ((0.1, 1000), (0.001, 10)), "frequency": ((0.1, 50), (0.01, 10)),
    "time": ((1, 10_000), (0.1, 100)), "stiffness": ((1e6, 1e12), (0.01, 100)),
    "mass": ((0.01, 1000), (0.01, 100)), "acceleration": ((-20, 20), (-0.1, 0.1)),
    "damping": ((1e-4, 10), (1e-3, 1)), "pressure": ((0.1, 500), (0.01, 100)),
    "density": ((500, 20_000), (0.01, 100)),
}  # fmt: skip
# Those of keys without a dimension, by name.
RANGES: Final = {
    "beads": (2, 200), "cells": (1, 100), "exponent": (1.1, 4), "rate": (0.001, 0.3),
    "mass_ratio": (0.01, 1), "ratio": (0.05, 1.2), "relative": (0, 0.3), "seed": (0, 50),
    "count": (1, 8), "between": (1, 4), "strikers": (0, 5), "cycles": (0.5, 20),
    "grade": (min(BALL_GRADES), max(BALL_GRADES)),
}  # fmt: skip
# Parts of a budget; see `hertzchain.simulation.budget`.
PARTS: Final = {
    "leading pulse": "Motion of beads in the leading pulse, without the energy in its contacts",
    "lagging": "All other beads that move away from the impact",
    "scattered back": "Beads that move back towards the impact",
    "contacts": "Stored in contacts between beads, those of the pulse included",
    "walls": "Stored in the contacts with walls",
    "left wall": "Transferred to the left wall",
    "right wall": "Transferred to the right wall",
    "lost": "Lost in contacts and walls",
}
# Values with which forms of chains and new tables begin where the schema has no default: those of
# scaled chains, and in SI units by name or dimension.
BEGIN: Final = {
    "forms": {
        "taper": {"taper": "backward-exponential", "rate": 0.05, "beads": 40},
        "first": {"first": 1, "last": 0.3, "beads": 40},
        "first_diameter": {"first_diameter": 1, "last_diameter": 0.3, "beads": 40},
        "diameters": {"diameters": [1, 0.7]},
        "radii": {"radii": [1, 0.8, 0.6, 0.8, 1]},
        "cell": {"cell": [1, 0.6], "cells": 20},
        "cell_diameters": {"cell_diameters": [1, 0.6], "cells": 20},
        "mass_ratio": {"mass_ratio": 0.3428, "beads": 40},
    },
    # A soft polymer, which can be seen next to steel.
    "material": {"density": "1200 kg/m^3", "young": "2 GPa", "poisson": 0.35},
    "other": {"bead": 10, "radius": 2, "seed": 1, "relative": 0.05, "ratio": 0.4,
              "coefficient": 0.9, "amplitude": 0.3, "frequency": 0.1,
              "times": [0, 5, 10], "values": [0, 0.1, 0]},
    "SI": {"radius": "20 mm", "diameter": "20 mm", "mass": "5 g", "velocity": "0.1 m/s",
           "height": "0.5 mm", "energy": "0.2 mJ", "amplitude": "10 N", "frequency": "5 kHz",
           "time": "10 µs", "times": ["0 µs", "50 µs", "100 µs"], "values": ["0 N", "10 N", "0 N"]},
}  # fmt: skip
# Number of beads in a picture of the gallery.
MAX_THUMBNAIL: Final = 40


@cache
def gallery() -> list[dict[str, Any]]:
    """Examples with a title, a sentence and a document; a small picture has the radii.

    Its first beads, which move, are marked.
    """
    text = (files("hertzchain.app") / "gallery.toml").read_text("utf-8")
    found = []
    for entry in tomllib.loads(text)["example"]:
        document = {name: entry[name] for name in ("chain", "materials") if name in entry}
        chain = chain_of(document)
        radii = chain.radii[:MAX_THUMBNAIL]
        found.append(
            {"title": entry["title"], "look_for": entry["look_for"], "document": document,
             "other": {"chain": entry["other"]} if "other" in entry else None,
             "view": entry.get("view", {}), "radii": [float(f"{r:.3g}") for r in radii],
             "moving": max(1, moving_first(chain))}
        )  # fmt: skip
    return found


def _factors() -> dict[str, float]:
    """Factors to SI of the units that the page shows; that of a stiffness depends on the chain."""
    return {PERCENT: 0.01} | {
        unit: converted(dimension, 1.0, unit, units[0])
        for dimension, units in UNITS.items() if dimension != "stiffness" for unit in units
    }  # fmt: skip


def _schema() -> dict[str, Any]:
    schema = chain_schema()
    del schema["sections"][WITHOUT_CONTROLS]
    return schema


def about(document: object = None, view: object = None) -> dict[str, Any]:
    """Description of the program for the page, which begins with a document or an example.

    ``view`` has the chain B and choices of the views with which the page begins.
    """
    return {
        "version": __version__,
        "schema": _schema(),
        "titles": TITLES,
        "forms": FORMS,
        "tapers": {name: dict(taper.symbols) for name, taper in TAPERS.items()},
        "materials": list(catalogue()),
        "quantities": {
            each.name: {"description": each.description.replace("^2", "²"), "symbol": each.symbol,
                        "unit": each.unit, "per": each.per, "estimate": each.estimate}
            for each in QUANTITIES.values()
        },
        "factors": _factors(),
        "begin": BEGIN,
        "parts": PARTS,
        "ranges": RANGES_OF_DIMENSIONS | {name: (each, each) for name, each in RANGES.items()},
        "theories": [*THEORIES, "effective-chain"],
        "gallery": gallery(),
        "max_beads": MAX_BEADS,
        "document": gallery()[0]["document"] if document is None else document,
        "view": view,
        "sensors": [] if _has_force(document) else None,
    }  # fmt: skip


def _has_force(document: object) -> bool:
    """Whether a given chain has a wall or a cap, so that the page begins without a sensor."""
    chain = document.get("chain") if isinstance(document, Mapping) else None
    return isinstance(chain, Mapping) and not {"left_wall", "right_wall", "cap"}.isdisjoint(chain)
