"""Published numbers, tables and captions of the paper, read from `published.toml`."""

from __future__ import annotations

import functools
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal

from ..theory.modified_bca import PowerLawCorrection

Fit = Literal["exponential", "linear"]
Order = Literal["rising", "falling"]
FigureQuantity = Literal["velocity", "momentum", "energy", "ratio"]


@dataclass(frozen=True)
class Printed:
    """A number as printed: its value and its number of decimals.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.paper.published import Printed
    >>> Printed("-0.00160").value, Printed("-0.00160").decimals
    (-0.0016, 5)
    """

    text: str

    @property
    def value(self) -> float:
        """Value of the number, which may be a fraction such as 2/3."""
        numerator, _, denominator = self.text.partition("/")
        return float(numerator) / float(denominator or 1)

    @property
    def decimals(self) -> int:
        """Number of digits after the decimal point."""
        return len(self.text.partition(".")[2])

    @property
    def unit(self) -> float:
        """One unit of the last printed digit."""
        return float(f"1e-{self.decimals}")


@dataclass(frozen=True)
class PublishedColumn:
    """Rates, theoretical values and numerical values of one taper in a table."""

    taper: str
    rates: tuple[Printed, ...]
    bca: tuple[Printed, ...]
    numerical: tuple[Printed, ...]


@dataclass(frozen=True)
class PublishedTable:
    """A table of growth rates."""

    name: str
    place: str
    caption: str
    quantity: Literal["momentum", "energy"]
    fit: Fit
    symbol: str
    columns: tuple[PublishedColumn, ...]


@dataclass(frozen=True)
class PublishedFigure:
    """Chains, quantity and order of the curves as stated in a figure's caption."""

    number: int
    label: str
    taper: str
    rates: tuple[float, ...]
    quantity: FigureQuantity
    order: Order
    caption: str

    @property
    def name(self) -> str:
        """Name used on the command line and for files."""
        return f"figure{self.number}"


@functools.cache
def _document() -> dict[str, Any]:
    text = resources.files("hertzchain.paper").joinpath("published.toml").read_text("utf-8")
    return tomllib.loads(text)


def published_tables() -> dict[str, PublishedTable]:
    """The three tables of the paper, by name."""

    def column(taper: str, raw: dict[str, list[str]]) -> PublishedColumn:
        lists = {key: tuple(map(Printed, values)) for key, values in raw.items()}
        return PublishedColumn(taper=taper, **lists)

    return {
        name: PublishedTable(
            name=name,
            columns=tuple(column(taper, column_) for taper, column_ in raw["columns"].items()),
            **{key: value for key, value in raw.items() if key != "columns"},
        )
        for name, raw in _document()["tables"].items()
    }


def published_figures() -> dict[str, PublishedFigure]:
    """The fourteen figures of the paper, by name."""
    return {
        name: PublishedFigure(
            number=int(name.removeprefix("figure")), **(raw | {"rates": tuple(raw["rates"])})
        )
        for name, raw in _document()["figures"].items()
    }


def published_ratio(taper: str) -> Printed:
    """Printed ratio of a linear taper's velocity to that of the BCA."""
    return Printed(_document()["ratios"][taper]["value"])


def published_correction(taper: str) -> PowerLawCorrection:
    """Printed constants of an exponential taper's correction."""
    raw = _document()["corrections"][taper]
    return PowerLawCorrection(**{name: float(raw[name]) for name in ("c0", "x", "d0", "y")})
