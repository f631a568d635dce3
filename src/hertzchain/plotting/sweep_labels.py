"""Labels of the axes, quantities and values of sweeps."""

from __future__ import annotations

import json
from collections.abc import Iterator
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from ..chain.laws.base import LAWS
from ..chain.tapers import TAPERS, rate_symbol
from ..store.schema_paths import is_place
from ..sweeps.kept import SWEEP_QUANTITIES
from ..sweeps.placed import placed
from ..units import PERCENT
from .methods import METHODS
from .style import literal, with_micro

if TYPE_CHECKING:
    import xarray as xr

# Labels of parameters that are ratios, whose names do not state both quantities.
LABELS: Final = MappingProxyType(
    {
        "ratio": "last radius / first radius",
        "mass_ratio": "mass of light beads / heavy beads",
        "decorated.ratio": "small radius / mean of neighbours",
        "decorated.radius": "radius of the small beads",
        "decorated.diameter": "diameter of the small beads",
        "decorated.between": "small beads between two large ones",
        "struck_by.count": "number of strikers",
        "with_scatter.relative": "scatter of the radii",
        "with_scatter.grade": "ball grade",
        "with_scatter.seed": "seed of the radii",
    }
)
# Keys of losses in specifications, and parameters of laws with a symbol or a short name.  The
# meaning of a ratio depends on the law.
OF_LOSSES: Final = MappingProxyType({
    "restitution": "coefficient of restitution", "speed": "speed of the collision",
    "law": "law of loss", "attractive": "loss with pull",
    "gamma": r"damping $\gamma$", "alpha": r"exponent $\alpha$ of damping",
    "factor": "yield pressure / yield strength",
})  # fmt: skip
RATIOS: Final = MappingProxyType({
    "walton-braun": "loading / unloading stiffness", "unloading-ratio": "unloading ratio $w$",
})  # fmt: skip
# Labels of axes that do not introduce values, as ``beads = 20`` does.
OF_AXES: Final = MappingProxyType({"rate": "rate of the taper", "beads": "number of beads $N$"})
# Prefixes of variables that are errors, and their names.
ERRORS: Final = MappingProxyType(
    {"worst_error_of_": "largest error of", "relative_error_of_": "error of"}
)
# Dimensions of quantities whose selected value is part of a label.
PLACES_IN_LABELS: Final = ("bead", "contact")
# Names of parameters with one value for each bead or contact, in a label.
SINGULARS: Final = MappingProxyType({
    "radii": "radius", "diameters": "diameter", "masses": "mass", "velocities": "velocity",
    "gaps": "gap", "materials": "material",
})  # fmt: skip


def axis_label(coordinate: xr.DataArray) -> str:
    """Label of an axis: ``struck_by.mass`` of a specification is the mass of the striker."""
    words = str(coordinate.attrs.get("long_name", ""))
    if words in OF_AXES:
        symbol = coordinate.attrs.get("symbol")
        return _with_unit(f"{OF_AXES[words]} ${symbol}$" if symbol else OF_AXES[words], coordinate)
    return _parameter(coordinate)


def with_symbols(drawn: xr.DataArray, dataset: xr.Dataset) -> xr.DataArray:
    """Values whose rate of the taper, if it is an axis, has the symbol of this taper."""
    chain = specification_of(dataset).get("chain", {})
    drawn = _with_one_striker(_with_ratio(drawn, chain), chain)
    taper = chain.get("taper")
    # The taper itself may be an axis, with both symbols.
    if "rate" not in drawn.coords or taper not in TAPERS:
        return drawn
    rate = drawn["rate"]
    return drawn.assign_coords(
        rate=rate.assign_attrs({**rate.attrs, "symbol": rate_symbol(taper)})
    )  # fmt: skip


def with_damping(drawn: xr.DataArray, dataset: xr.Dataset) -> xr.DataArray:
    """Values with the attribute ``damped`` if chains of the sweep may have damping forces."""
    known = "specification" in dataset.attrs
    laws = (LAWS.get(name) for name in _laws(specification_of(dataset)))
    if known and not any(law is not None and law.damps for law in laws):
        return drawn
    return drawn.assign_attrs({**drawn.attrs, "damped": True})


def _laws(entry: Any, *, named: bool = False) -> Iterator[str]:
    """Names of the laws in a specification, which are values of ``law`` or ``loss.law``."""
    if isinstance(entry, dict):
        for key, each in entry.items():
            yield from _laws(each, named=named or key.endswith("law"))
    elif isinstance(entry, list):
        for each in entry:
            yield from _laws(each, named=named)
    elif named and isinstance(entry, str):
        yield entry


def _with_ratio(drawn: xr.DataArray, chain: dict[str, Any]) -> xr.DataArray:
    """Values whose ratio of a law of loss, if it is an axis, is named as in this law."""
    ratio, losses = drawn.coords.get("ratio"), chain.get("loss", {})
    law = losses.get("law") if isinstance(losses, dict) else None
    if ratio is None or law not in RATIOS or ratio.attrs.get("long_name") != "loss.ratio":
        return drawn
    return drawn.assign_coords(ratio=ratio.assign_attrs({**ratio.attrs, "law": law}))


def _with_one_striker(drawn: xr.DataArray, chain: dict[str, Any]) -> xr.DataArray:
    """Values whose axes do not number the striker if there is only one."""
    strikers, first = chain.get("struck_by"), "struck_by.1."
    if not isinstance(strikers, list) or len(strikers) != 1:
        return drawn
    names = {name: str(each.attrs.get("long_name", "")) for name, each in drawn.coords.items()}
    return drawn.assign_coords({
        name: drawn[name].assign_attrs(
            {**drawn[name].attrs, "long_name": words.replace(first, "struck_by.")}
        )
        for name, words in names.items() if words.startswith(first)
    })  # fmt: skip


def reference_of(dataset: xr.Dataset) -> str | None:
    """Name of the method to which errors of a sweep are relative."""
    reference = specification_of(dataset).get("sweep", {}).get("reference")
    return reference if isinstance(reference, str) else None


def specification_of(dataset: xr.Dataset) -> dict[str, Any]:
    """Specification of a sweep; empty for a dataset without it."""
    found: dict[str, Any] = json.loads(dataset.attrs.get("specification", "{}"))
    return found


def _parameter(coordinate: xr.DataArray) -> str:
    """A parameter with its unit."""
    name = str(coordinate.name)
    if name in ("bead", "contact"):
        return f"{name} $k$"
    words = coordinate.attrs.get("long_name", name) if name not in ("approach", "point") else name
    if words in LABELS:
        return _with_unit(LABELS[words], coordinate)
    part, _, field = words.rpartition(".")
    if part.rpartition(".")[2] == "loss" and (called := _of_loss(field, coordinate)):
        wall = part.removesuffix(".loss").replace("_", " ") if part != "loss" else ""
        place = f" of the {wall}" if wall.endswith("wall") else ""
        return _with_unit(f"{called}{place}", coordinate)
    plain = words.removeprefix("method.").removeprefix("with_")
    parts = [SINGULARS.get(part, part) for part in plain.split(".")]
    if parts[0] == "struck_by" and len(parts) > 1:
        which = f"striker {parts[1]}" if len(parts) > 2 else "the striker"
        parts = [*parts[2 if len(parts) > 2 else 1 :], "of", which]
    if is_place(parts[-1]) and parts[0] in SINGULARS.values():
        several = "s" * ("-" in parts[-1])
        parts.insert(-1, f"of {'contact' if parts[0] == 'gap' else 'bead'}{several}")
        parts[-1] = parts[-1].replace("-", " to ")
    return _with_unit(" ".join(parts).replace("_", " "), coordinate)


def quantity_label(drawn: xr.DataArray) -> str:
    """Label of the quantity with its unit, and with the number of a selected bead or contact."""
    name = str(drawn.name)
    if (at := placed(name)) is not None:
        half = drawn.attrs.get("free_face")
        return _with_unit(f"{at.label} ({half})" if half else at.label, drawn)
    error = next((words for prefix, words in ERRORS.items() if name.startswith(prefix)), None)
    if error is not None:
        of = name.partition("_of_")[2].replace("_", " ")
        place = next((f" of {each} {drawn[each].item()}" for each in PLACES_IN_LABELS
                      if _is_selected(drawn, each)), "")  # fmt: skip
        return _with_unit(f"{error} {of}{place}", drawn)
    quantity = SWEEP_QUANTITIES.get(name)
    if quantity is None:
        return _with_unit(name.replace("_", " "), drawn)
    label = quantity.label
    if "damped" in drawn.attrs and quantity.without_damping:
        label = quantity.without_damping
    return _with_unit(label.replace("_k$", f"_{_index(drawn, quantity.per)}$"), drawn)


def _index(drawn: xr.DataArray, per: str) -> str:
    """Index of a quantity: k along beads or contacts, otherwise a number or that of the last."""
    place = "contact" if per == "contact" else "bead"
    if place not in drawn.coords:
        return "{N-1}" if per == "contact" else "{N}"
    return f"{{{drawn[place].item()}}}" if _is_selected(drawn, place) else "k"


def _of_loss(field: str, coordinate: xr.DataArray) -> str:
    """A key of a loss in words; empty for a ratio whose law is not known."""
    if field in OF_LOSSES or field == "ratio":
        return OF_LOSSES.get(field) or RATIOS.get(coordinate.attrs.get("law", ""), "")
    called = {name: each.called for law in LAWS.values() for name, each in law.parameters().items()}
    return called.get(field, "")


def _is_selected(drawn: xr.DataArray, place: str) -> bool:
    return place in drawn.coords and drawn[place].ndim == 0


def _with_unit(text: str, values: xr.DataArray) -> str:
    unit = values.attrs.get("units", "1")
    return text if unit == "1" else f"{text} [{with_micro(unit)}]"


def coordinate_text(value: xr.DataArray, name: str) -> str:
    """A value of an axis in words."""
    if name == "approach":
        method = METHODS.get(value.item())
        return method.name if method else literal(str(value.item()))
    unit = value.attrs.get("units", "1")
    # The rate of a taper has its symbol, as in the label of an axis.
    symbol = value.attrs.get("symbol")
    label = f"${symbol}$" if symbol else _parameter(value).removesuffix(f" [{with_micro(unit)}]")
    shown = "" if unit == "1" else unit if unit == PERCENT else f" {with_micro(unit)}"
    return f"{label} = {short_value(value.item())}{shown}"


def short_value(value: Any) -> str:
    """A value of an axis without its unit."""
    return f"{value:.4g}" if isinstance(value, float) else literal(str(value))
