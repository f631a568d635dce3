"""What a sweep shall do: every choice, checked, as text of one form."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from hertzchain.sweeps.axes import Axis

# Quantities of the right wall, of `simulate` alone: what `WallForce` calls them, what they are,
# their unit in SI.
WALL_QUANTITIES: Final[Mapping[str, tuple[str, str, str]]] = {
    "wall_peak_force": ("peak", "largest force on the right wall", "N"),
    "wall_peak_time": ("peak_time", "time of the largest force on the right wall", "s"),
    "wall_largest_so_far": (
        "largest_so_far", "largest force on the right wall in the run, complete or not", "N",
    ),
    "wall_impulse_of_impact": (
        "impulse_of_impact", "impulse of the right wall until its largest force is complete", "N s",
    ),
    "wall_first_contact_impulse": (
        "first_contact_impulse", "impulse of the first contact with the right wall", "N s",
    ),
    "wall_impulse": ("impulse", "impulse of the right wall in the whole run", "N s"),
}  # fmt: skip
# Names that axes cannot have, since the dataset needs them.
TAKEN: Final = ("by", "bead", "contact", "point", "status", "reason", "outside_range", "incomplete")


@dataclass(frozen=True, eq=False)
class Specification:
    """A checked specification of a sweep.

    Attributes
    ----------
    title : str
        Heads pictures and the dataset; may be empty.
    chain : mapping
        Table ``[chain]`` of a chain file, to which the axes are applied.
    materials : mapping
        Materials of one's own by name, as in a chain file.
    axes : tuple of Axis
        What varies.
    combine : str
        ``"product"``: every combination of values; ``"zip"``: the first of each, the second
        of each, and so on.
    methods : tuple of str
        Names of `hertzchain.sweeps.methods.METHODS`.
    keep : tuple of str
        Quantities of a pulse, or of a wall.
    at : str or tuple of int
        ``"every"`` bead, the ``"last"`` one, or the numbers of beads.
    errors : tuple of str
        Quantities whose relative errors are kept, too.
    reference : str
        Method from which errors are measured.
    batch : int or None
        Points that are computed together; chosen if `None`.
    options : mapping
        Of the integrations: rtol, until, max_steps.

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> spec = read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}})
    >>> spec.methods, len(spec.axes[0])
    (('propagate',), 2)
    """

    title: str
    chain: Mapping[str, Any]
    materials: Mapping[str, Any]
    axes: tuple[Axis, ...]
    combine: str
    methods: tuple[str, ...]
    keep: tuple[str, ...]
    at: str | tuple[int, ...]
    errors: tuple[str, ...]
    reference: str
    batch: int | None
    options: Mapping[str, Any]

    def as_json(self) -> str:
        """All of it as JSON text, the same for the same sweep.

        Returns
        -------
        str

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> spec = read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": [20]}})
        >>> spec.as_json()[:42]
        '{"title": "", "chain": {"taper": "uniform"'
        """
        axes = {axis.long_name: dict(_entry(axis)) for axis in self.axes}
        settings = {
            "combine": self.combine, "methods": list(self.methods), "keep": list(self.keep),
            "at": self.at if isinstance(self.at, str) else list(self.at),
            "errors": list(self.errors), "reference": self.reference,
        }  # fmt: skip
        if self.batch is not None:
            settings["batch"] = self.batch  # type: ignore[assignment]
        document = {
            "title": self.title, "chain": _sorted(self.chain), "materials": _sorted(self.materials),
            "axes": axes, "sweep": settings, "method": _sorted(self.options),
        }  # fmt: skip
        return json.dumps(document, allow_nan=False)


def differences(one: str, other: str) -> list[str]:
    """Where two specifications, as JSON text, differ.

    Parameters
    ----------
    one, other : str
        Texts of `Specification.as_json`.

    Returns
    -------
    list of str
        A line for each place: its path, what is in the one, what is in the other.

    Examples
    --------
    >>> differences('{"sweep": {"at": "last"}}', '{"sweep": {"at": "every"}}')
    ["sweep.at: 'last', now 'every'"]
    """
    documents = [json.loads(text) for text in (one, other)]
    left, right = (dict(_leaves(document)) for document in documents)
    # The order of axes is that of the dimensions.
    for leaves, document in zip((left, right), documents, strict=True):
        leaves["axes"] = ", ".join(document.get("axes", {}))
    return [
        f"{path}: {left.get(path, 'nothing')!r}, now {right.get(path, 'nothing')!r}"
        for path in sorted(left.keys() | right.keys())
        if left.get(path) != right.get(path)
    ]


def _entry(axis: Axis) -> Mapping[str, Any]:
    """An axis as it was specified."""
    if isinstance(axis.entry, Mapping) and "list" not in axis.entry:
        return axis.entry
    return {"list": axis.values}


def _sorted(table: Mapping[str, Any]) -> Any:
    return json.loads(json.dumps(table, sort_keys=True))


def _leaves(entry: Any, path: str = "") -> Any:
    if isinstance(entry, Mapping):
        for key, value in entry.items():
            yield from _leaves(value, f"{path}.{key}" if path else key)
    else:
        yield path, entry
