"""Descriptions of beads in chain files: equal beads, repeated cells, tapers; sizes in mm."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.repeated_cells import smallest_cell
from ..chain.taper_sizes import SHAPES, Sizes, si_radii, taper_between
from ..chain.tapers import TAPERS, tapered_radii
from ..collision import Array
from ..errors import InputError

# Keys that are sizes in m, the name of the key in mm, and its multiple of the radius.
SIZES: Final = {
    "radii": ("diameters", 2.0), "first": ("first_diameter", 2.0), "last": ("last_diameter", 2.0),
    "radius": ("radius", 1.0), "cell": ("cell_diameters", 2.0),
}  # fmt: skip
# Sizes [m] that are written in mm.
MILLIMETRES: Final = (1e-5, 1.0)
# Significant digits of rates and radii that are tried, from few to all.
DIGITS: Final = (2, 4, 6, 9, 12, 15, 17)


def compact_beads(chain: Chain, names: Sequence[str]) -> dict[str, Any]:
    """Keys of [chain] with the radii of a chain, and the names of its materials.

    Radii that the keys give are those of the chain, bit for bit.
    """
    if chain.units == "scaled" and (
        chain.taper is not None or chain.strikers or chain.radii[0] != 1.0
    ):
        return listed_beads(chain, names)
    for form in (_equal, _periodic, _equal_sizes, _tapered):
        entries = form(chain, names)
        if entries is not None:
            return entries
    return listed_beads(chain, names)


def one_for_all(values: Array) -> Any:
    """A list, or one value if all are equal."""
    listed = values.tolist()
    return listed[0] if len(listed) > 1 and len(set(listed)) == 1 else listed


def in_usual_units(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of [chain] in SI units with sizes in mm, and the velocity with its unit."""
    found: dict[str, Any] = {}
    for key, value in entries.items():
        name, multiple = SIZES.get(key, (key, 1.0))
        sizes = multiple * np.atleast_1d(value) if key in SIZES else np.empty(0)
        if key == "velocity":
            found[key] = f"{value!r} m/s"
        elif sizes.size and MILLIMETRES[0] <= sizes.min() and sizes.max() <= MILLIMETRES[1]:
            texts = [with_prefix(each, "mm") for each in sizes.tolist()]
            found[name] = texts if isinstance(value, list) else texts[0]
        else:
            found[key] = value
    return found


def with_prefix(value: float, unit: str) -> str:
    """Text in mm or g with the same decimal digits, rounded once and hence the same number."""
    return f"{Decimal(repr(value)).scaleb(3).normalize():f} {unit}"


def _materials(names: Sequence[str]) -> dict[str, Any]:
    if not names:
        return {}
    return {"materials": names[0] if len(set(names)) == 1 else list(names)}


def listed_beads(chain: Chain, names: Sequence[str]) -> dict[str, Any]:
    """The same keys with one radius per bead, unless the chain names its taper."""
    if chain.units == "scaled" and chain.taper is not None:
        parameters: Mapping[str, float] = dict(chain.taper_parameters)
        return {"taper": chain.taper, **parameters, "beads": chain.beads}
    radii = chain.radii.tolist()
    if chain.units == "scaled" and not chain.strikers and radii[0] != 1.0:
        # A list would be divided by its first radius.
        first = {"bead": 1, "radius": radii[0]}
        return {"radii": [1.0, *radii[1:]], "with_defects": [first]}
    return {"radii": radii, **_materials(names)}


def _equal(chain: Chain, names: Sequence[str]) -> dict[str, Any] | None:
    radius = float(chain.radii[0])
    if not (chain.radii == radius).all():
        return None
    if chain.units == "scaled":
        return {"taper": "uniform", "beads": chain.beads}
    if len(set(names)) != 1:
        return None
    return {"radii": radius, "beads": chain.beads, **_materials(names)}


def _periodic(chain: Chain, names: Sequence[str]) -> dict[str, Any] | None:
    size = smallest_cell(chain.radii, *([np.array(names)] if names else []))
    if size is None or chain.beads % size:
        return None
    cell = {"cell": chain.radii[:size].tolist(), "cells": chain.beads // size}
    return cell | _materials(names[:size])


def _equal_sizes(chain: Chain, names: Sequence[str]) -> dict[str, Any] | None:
    """One radius for beads of several materials."""
    radius = float(chain.radii[0])
    if not names or not (chain.radii == radius).all():
        return None
    return {"radii": radius, **_materials(names)}


def _tapered(chain: Chain, names: Sequence[str]) -> dict[str, Any] | None:
    """A taper of a rate or of two sizes of few digits, if it has exactly the radii of the chain."""
    if not names or chain.beads < 3:
        return None
    for entries, radii in _tapers(chain.radii):
        if np.array_equal(radii, chain.radii):
            return entries | {"beads": chain.beads} | _materials(names)
    return None


def _tapers(radii: Array) -> Iterator[tuple[dict[str, Any], Array]]:
    """Keys and radii of tapers between the first and the last radius, by their digits."""
    beads, first, last = len(radii), float(radii[0]), float(radii[-1])
    for digits, shape in itertools.product(DIGITS, SHAPES):
        try:
            size = _rounded(last, digits)
            entries = {"first": first, "last": size, "taper": shape}
            yield entries, si_radii(shape, beads, Sizes(first=first, last=size))
            taper, rate, _ = taper_between(shape, beads, first, last)
            rate = _rounded(rate, digits)
            TAPERS[taper].check(beads, rate=rate)
            entries = {"taper": taper, "rate": rate, "radius": first}
            yield entries, first * tapered_radii(taper, rate, beads)
        except InputError:
            continue  # Beads cannot shrink this fast.


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
