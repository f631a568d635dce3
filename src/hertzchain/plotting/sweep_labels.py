"""Labels of the axes, quantities and values of sweeps."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from ..sweeps.kept import KEPT, sensor_of
from ..units import PERCENT
from .style import literal

if TYPE_CHECKING:
    import xarray as xr

# Labels of parameters that are ratios, whose names do not state both quantities.
LABELS: Final = MappingProxyType(
    {
        "ratio": "radius of the last bead / that of the first",
        "mass_ratio": "mass of light beads / that of heavy ones",
        "decorated.ratio": "radius of small beads / mean of neighbours",
        "with_scatter.relative": "scatter of the radii",
        "with_scatter.grade": "ball grade",
        "with_scatter.seed": "seed of the radii",
    }
)
# Names of parameters with one value for each bead or contact, in a label.
SINGULARS: Final = MappingProxyType({
    "radii": "radius", "diameters": "diameter", "masses": "mass", "velocities": "velocity",
    "gaps": "gap", "materials": "material",
})  # fmt: skip


def axis_label(coordinate: xr.DataArray) -> str:
    """Label of an axis: ``struck_by.mass`` of a specification is the mass of the striker."""
    name = str(coordinate.name)
    if name in ("bead", "contact"):
        return f"{name} $k$"
    words = coordinate.attrs.get("long_name", name) if name not in ("approach", "point") else name
    if words in LABELS:
        return _with_unit(LABELS[words], coordinate)
    plain = words.removeprefix("method.").removeprefix("with_").replace("struck_by", "striker")
    parts = [SINGULARS.get(part, part) for part in plain.split(".")]
    return _with_unit(" ".join(parts).replace("_", " "), coordinate)


def quantity_label(drawn: xr.DataArray) -> str:
    """Label of the quantity with its unit; the index of the last bead is N, not k."""
    name = str(drawn.name)
    if (sensor := sensor_of(name)) is not None:
        text = f"{sensor.quantity.label.removesuffix(' so far')} in {sensor.where}"
        return _with_unit(text, drawn)
    quantity = KEPT.get(name)
    text = name.replace("_", " ") if quantity is None else quantity.label
    if quantity is not None and not {"bead", "contact"} & set(drawn.coords):
        text = text.replace("_k$", "_{N-1}$" if quantity.per == "contact" else "_{N}$")
    return _with_unit(text, drawn)


def _with_unit(text: str, values: xr.DataArray) -> str:
    unit = values.attrs.get("units", "1")
    return text if unit == "1" else f"{text} [{unit}]"


def coordinate_text(value: xr.DataArray, name: str) -> str:
    """A value of an axis in words."""
    if name == "approach":
        return f"by {value.item()}"
    unit = value.attrs.get("units", "1")
    label = axis_label(value).removesuffix(f" [{unit}]")
    shown = "" if unit == "1" else unit if unit == PERCENT else f" {unit}"
    return f"{label} = {short_value(value.item())}{shown}"


def short_value(value: Any) -> str:
    """A value of an axis without its unit."""
    return f"{value:.4g}" if isinstance(value, float) else literal(str(value))
