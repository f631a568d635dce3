"""Axes that vary together, or listed points: a quantity instead of the number of the point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from .sweep_labels import coordinate_text, short_value, specification_of

if TYPE_CHECKING:
    import xarray as xr

# Dimension of such a sweep.
POINT: Final = "point"


def over_first_quantity(dataset: xr.Dataset, at: Mapping[str, Any]) -> xr.Dataset:
    """The dataset over the first quantity of its points whose values differ from each other.

    Numbers are preferred to names.  A dataset without such a quantity, or of which a user has
    chosen a point by its number, remains as it is.
    """
    if POINT not in dataset.dims or POINT in at:
        return dataset
    # A store does not keep the order of the specification.
    order = [*specification_of(dataset).get("axes", {})]
    along = sorted(
        (name for name, each in dataset.coords.items() if each.dims == (POINT,)),
        key=lambda name: [*order, dataset[name].attrs.get("long_name")].index(
            dataset[name].attrs.get("long_name")
        ),
    )
    distinct = [
        name for name in along
        if name != POINT and len({*dataset[name].to_numpy().tolist()}) == dataset.sizes[POINT]
    ]  # fmt: skip
    numbers = [name for name in distinct if dataset[name].dtype.kind in "if"]
    chosen = next(iter(numbers or distinct), None)
    return dataset if chosen is None else dataset.swap_dims({POINT: chosen})


def together_in_words(drawn: xr.DataArray) -> list[str]:
    """Ranges of the other quantities that vary along an axis, in words."""
    found = []
    for key, values in drawn.coords.items():
        name = str(key)
        if values.ndim != 1 or name in (POINT, *drawn.dims):
            continue
        first, last = (coordinate_text(values[i], name) for i in (0, -1))
        steps = np.sign(np.diff(values.to_numpy())) if values.dtype.kind in "if" else np.array([])
        if first == last and not steps.any():
            found.append(first)
        elif steps.size and abs(steps.sum()) == steps.size:
            label, _, end = last.rpartition(" = ")
            found.append(f"{label} = {short_value(values[0].item())} to {end}")
        else:
            found.append(f"{first.rpartition(' = ')[0]} varies too")
    return found
