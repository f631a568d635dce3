"""Median of a sweep and its 5-95% band over one axis, such as the seeds of random chains."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from ..errors import IncompleteWarning, InputError, unknown_name_error, warn_user
from ..representation import counted
from ..store.sweep_store import DONE
from ..validation.objects import text
from .sweep_labels import axis_label

if TYPE_CHECKING:
    import xarray as xr

# Quantiles of the lower end of the band, the curve and the upper end.
QUANTILES: Final = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Band:
    """A sweep without one axis: the lower end, the median and the upper end of its values."""

    low: xr.Dataset
    median: xr.Dataset
    high: xr.Dataset
    # Such as ``median and 5–95% of 30 values (seed of the radii)``.
    words: str
    # Such as ``5% to 95% of 30 values``, of the band in a legend.
    label: str
    # Dimension of the values.
    name: str


def with_band(dataset: xr.Dataset, axis: Any) -> tuple[xr.Dataset, Band | None]:
    """The medians over an axis and their band, or the sweep itself if there is no axis."""
    found = None if axis is None else band_over(dataset, axis)
    return (dataset if found is None else found.median), found


def band_over(dataset: xr.Dataset, axis: Any) -> Band:
    """Quantiles of all variables over an axis, by its dimension or its name in the specification.

    Points without a value are not included.
    """
    axis = text("band", axis)
    names = {dataset[each].attrs.get("long_name"): str(each) for each in dataset.dims}
    name = names.get(axis, axis)
    if name not in dataset.dims:
        raise unknown_name_error("dimension of this sweep", axis, map(str, dataset.dims))
    if dataset.sizes[name] < 2:
        raise InputError(f"a band requires an axis of at least 2 values, but {name} has 1")
    low, median, high = (_quantile(dataset, name, part) for part in QUANTILES)
    words = f"median and 5–95% of {dataset.sizes[name]} values ({axis_label(dataset[name])})"
    label = f"5% to 95% of {dataset.sizes[name]} values"
    return Band(low, median, high, words, label, name)


def words_of(band: Band | None) -> list[str]:
    """Part of a title."""
    return [] if band is None else [band.words]


def label_of(band: Band | None) -> str:
    """Label of a band in a legend."""
    return "" if band is None else band.label


def warn_incomplete_in_band(values: xr.DataArray, status: xr.DataArray, band: Band) -> None:
    """Warn about values that finished points do not have, which the band does not include."""
    absent, done = values.isnull(), status.broadcast_like(values) == DONE
    incomplete = int((absent & done & ~(absent | ~done).all(band.name)).sum())
    if incomplete:
        warn_user(
            f"{incomplete} of the {counted(values.size, 'value')} of {values.name} are incomplete "
            "or do not exist: the band does not include them",
            IncompleteWarning,
        )


def _quantile(dataset: xr.Dataset, name: str, part: float) -> xr.Dataset:
    """The sweep at a quantile over one dimension; flags are those of any of the points."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "All-NaN slice", RuntimeWarning)
        variables: Mapping[Any, xr.DataArray] = {
            each: _over(values, name, part) for each, values in dataset.data_vars.items()
        }
    return dataset.drop_vars([*dataset.data_vars, name]).assign(variables)


def _over(values: xr.DataArray, name: str, part: float) -> xr.DataArray:
    if name not in values.dims:
        return values
    if values.name == "status":
        # A point has a value if one of the values of the band is done.
        found = values.isel({name: 0}, drop=True).where(
            ~(values == DONE).any(name), DONE
        )  # fmt: skip
        return found.astype(values.dtype)
    if values.dtype.kind == "f":
        return values.quantile(part, dim=name, keep_attrs=True).drop_vars("quantile")
    if values.dtype.kind in "biu":
        return values.max(name, keep_attrs=True)
    return values.isel({name: 0}, drop=True)
