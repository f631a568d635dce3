"""What the paper prints, as data: `published.toml`, read into typed records."""

from __future__ import annotations

import functools
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal

from hertzchain.chain.chain import Taper
from hertzchain.theory.modified_bca import PowerLawCorrection

Fit = Literal["exponential", "linear"]
Order = Literal["rising", "falling"]
FigureQuantity = Literal["velocity", "momentum", "energy", "ratio"]


@dataclass(frozen=True)
class Printed:
    """A number as printed: its value and how many decimals it shows.

    Examples
    --------
    >>> Printed("-0.00160").value, Printed("-0.00160").decimals
    (-0.0016, 5)
    """

    text: str

    @property
    def value(self) -> float:
        """The number; a fraction such as 2/3 is worked out."""
        numerator, _, denominator = self.text.partition("/")
        return float(numerator) / float(denominator or 1)

    @property
    def decimals(self) -> int:
        """Digits behind the point."""
        return len(self.text.partition(".")[2])

    @property
    def unit(self) -> float:
        """One unit of the last printed digit."""
        return float(f"1e-{self.decimals}")


@dataclass(frozen=True)
class PublishedColumn:
    """One taper's rows of a table: rates, the theory's numbers, the integration's."""

    taper: Taper
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
    """What a figure's caption fixes: chains, quantity and the order of its curves."""

    number: int
    label: str
    taper: Taper
    rates: tuple[float, ...]
    quantity: FigureQuantity
    order: Order
    caption: str

    @property
    def name(self) -> str:
        """Name on the command line and of the files."""
        return f"figure{self.number}"


@functools.cache
def _document() -> dict[str, Any]:
    text = resources.files("hertzchain.paper").joinpath("published.toml").read_text("utf-8")
    return tomllib.loads(text)


def published_tables() -> dict[str, PublishedTable]:
    """The three tables of the paper, by name.

    Returns
    -------
    dict of str to PublishedTable

    Examples
    --------
    >>> published_tables()["table1"].columns[0].numerical[0].text
    '0.01491'
    """

    def column(taper: str, raw: dict[str, list[str]]) -> PublishedColumn:
        lists = {key: tuple(map(Printed, values)) for key, values in raw.items()}
        return PublishedColumn(taper=taper, **lists)  # type: ignore[arg-type]

    return {
        name: PublishedTable(
            name=name,
            columns=tuple(column(taper, column_) for taper, column_ in raw["columns"].items()),
            **{key: value for key, value in raw.items() if key != "columns"},
        )
        for name, raw in _document()["tables"].items()
    }


def published_figures() -> dict[str, PublishedFigure]:
    """The fourteen figures of the paper, by name.

    Returns
    -------
    dict of str to PublishedFigure

    Examples
    --------
    >>> published_figures()["figure1"].rates
    (0.1, 0.5, 0.9)
    """
    return {
        name: PublishedFigure(
            number=int(name.removeprefix("figure")), **(raw | {"rates": tuple(raw["rates"])})
        )
        for name, raw in _document()["figures"].items()
    }


def published_ratio(taper: Taper) -> Printed:
    """The working ratio of a linear taper's velocity to the BCA's.

    Parameters
    ----------
    taper : str
        A linear taper.

    Returns
    -------
    Printed

    Examples
    --------
    >>> published_ratio("forward-linear").text
    '0.680'
    """
    return Printed(_document()["ratios"][taper]["value"])


def published_correction(taper: Taper) -> PowerLawCorrection:
    """The four constants of an exponential taper's correction.

    Parameters
    ----------
    taper : str
        An exponential taper.

    Returns
    -------
    PowerLawCorrection

    Examples
    --------
    >>> published_correction("forward-exponential").d0
    11.1
    """
    raw = _document()["corrections"][taper]
    return PowerLawCorrection(**{name: float(raw[name]) for name in ("c0", "x", "d0", "y")})
