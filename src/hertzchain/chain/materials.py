r"""Materials of beads and walls: density, elastic constants, yield strength.

`Material` defines a custom material; `material` finds one in the catalogue, the file
``materials.toml``, which also states the source of each number.
"""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib.resources import files
from typing import Any, Final, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError, InputWarning, alternatives, unknown_name_error, warn_user
from ..representation import short
from ..validation.keywords import checked_arguments, checked_fields, checked_methods
from ..validation.numbers import number, real_numbers
from ..validation.objects import check_list, check_type, text

__all__ = ("Material", "catalogue", "contact_modulus", "material", "sphere_stiffness")

# Densities that a bead can have [kg/m^3]: an aerogel has 1, osmium 22,600.
MIN_DENSITY, MAX_DENSITY = 1e-3, 1e6
# Density [kg/m^3] and modulus [Pa] below which the unit is probably wrong.
LIGHT, SOFT = 20.0, 1e4
# Largest pressure of a contact over the yield strength when its softer body first yields.
FIRST_YIELD: Final = 1.60
# Largest mean pressure over the yield strength, of fully plastic contacts: K. L. Johnson, Contact
# Mechanics, Cambridge 1985, Sec. 6.3.
FULLY_PLASTIC: Final = 2.8

# Key of the catalogue: the yield strength is the minimum of annealed bars, not that of balls.
ANNEALED_BAR: Final = "annealed_bar"

STAINLESS: Final = "'steel-304', 'steel-316' or 'steel-440c'"
# Names that users give to materials of the catalogue.
OTHER_NAMES: Final = {
    "teflon": "'ptfe'", "stainless": STAINLESS, "stainless steel": STAINLESS,
    "440c": "'steel-440c'", "ss440c": "'steel-440c'", "bearing steel": "'steel-52100'",
    "chrome steel": "'steel-52100'", "100cr6": "'steel-52100'", "aluminum": "'aluminium'",
    "ss304": "'steel-304'", "304": "'steel-304'", "304l": "'steel-304'",
    "ss316": "'steel-316'", "316": "'steel-316'", "316l": "'steel-316'",
    "52100": "'steel-52100'",
    "plexiglass": "'acrylic'", "pmma": "'acrylic'", "wc": "'tungsten-carbide'",
}  # fmt: skip


def __dir__() -> tuple[str, ...]:
    return __all__  # for completion


@checked_methods
@checked_fields
@dataclass(frozen=True)
class Material:
    """Material of a bead or a wall, in SI units.

    Attributes
    ----------
    name : str
        Name, one line of text without control characters.
    density : float
        Density, 0.001 to 1e6 [kg/m^3].
    young : float
        Young's modulus E > 0 [Pa]; infinite for `RIGID`.
    poisson : float
        Poisson's ratio, -1 < nu < 0.5.
    yield_strength : float or None
        Yield strength in tension [Pa], if the material has one.
    source : str
        Source of the numbers.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    A custom material:

    >>> import hertzchain as hc
    >>> hc.Material("my steel", density=7850.0, young=210e9, poisson=0.29)
    Material(my steel: 7850 kg/m^3, E = 210 GPa, nu = 0.29)
    """

    name: str
    density: float
    young: float
    poisson: float
    yield_strength: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        text("name of a material", self.name)
        check_type("source of a material", self.source, str)
        _check_text("name", self.name, ("Cc", "Cs"))
        _check_text("source", self.source, ("Cs",))

        def check(field: str, **bounds: Any) -> None:
            value = number(f"{field} of {self.name!r}", getattr(self, field), **bounds)
            object.__setattr__(self, field, value)

        check("density", unit="kg/m**3", least=MIN_DENSITY, most=MAX_DENSITY,
              hint="steel has 7800 kg/m^3")  # fmt: skip
        if not (isinstance(self.young, float) and self.young == math.inf):
            check("young", unit="Pa", above=0.0, hint="steel has 200e9 Pa")
        check("poisson", unit="", above=-1.0, below=0.5, hint="metals have 0.3, rubber 0.499")
        if self.yield_strength is not None:
            check("yield_strength", unit="Pa", above=0.0)
        if self.young < math.inf and (self.density < LIGHT or self.young < SOFT):
            warn_user(
                f"{self.name!r} has {self.density:g} kg/m^3 and E = {self.young:g} Pa, less than a "
                "foam; if you have g/cm^3 and GPa, multiply by 1000 and 1e9",
                InputWarning,
            )

    def replace(self, **changes: Any) -> Self:
        """Return a material with some fields changed.

        Parameters
        ----------
        **changes
            Fields of `Material` and their new values.

        Raises
        ------
        InputError
            If a field does not exist or is out of range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.material("steel-52100").replace(name="my steel", young=200e9).compliance
        4.55e-12
        """
        names = [each.name for each in fields(self)]
        for name in changes:
            if name not in names:
                raise unknown_name_error("field of a material", name, names)
        return replace(self, **changes)

    @property
    def compliance(self) -> float:
        r"""Plane-strain compliance :math:`(1-\nu^2)/E` [1/Pa]."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def sound_speed(self) -> float:
        r"""Speed of longitudinal waves in a thin bar, :math:`\sqrt{E/\rho}` [m/s]."""
        return math.sqrt(self.young / self.density)

    def __repr__(self) -> str:
        strength = self.yield_strength
        yields = "" if strength is None else f", yields at {strength / 1e6:g} MPa"
        modulus = f"E = {self.young / 1e9:g} GPa, nu = {self.poisson:g}"
        return short("Material", self.name, f"{self.density:g} kg/m^3, {modulus}{yields}")

    def _repr_html_(self) -> str:
        from ..notebook.chains import material_html

        return material_html(self)


def _check_text(what: str, given: str, categories: tuple[str, ...]) -> None:
    """Reject characters that cannot be written to a file: surrogates or control characters."""
    for place, character in enumerate(given, start=1):
        if unicodedata.category(character) in categories:
            raise InputError(
                f"{what} of a material must be text that can be written to a file, but character "
                f"{place} of {given!a} is U+{ord(character):04X}; remove it"
            )


# Material of a rigid wall: only the bead deforms.
RIGID: Final = Material("rigid", density=1.0, young=math.inf, poisson=0.0)
MaterialLike: TypeAlias = Material | str
# Materials of all beads; None in a chain without them.
Materials: TypeAlias = Sequence[Material] | None


class Catalogue(dict[str, Material]):
    """Materials by name, shown as a table."""

    def __missing__(self, name: str) -> Material:
        return material(name)

    def _rows(self) -> list[tuple[str, ...]]:
        """Header and one row per material."""
        header = ("material", "density [kg/m^3]", "E [GPa]", "nu", "yields at [MPa]")
        return [header, *(
            (name, f"{each.density:g}", f"{each.young / 1e9:g}", f"{each.poisson:g}",
             "" if each.yield_strength is None else f"{each.yield_strength / 1e6:g}")
            for name, each in self.items()
        )]  # fmt: skip

    def __repr__(self) -> str:
        rows = self._rows()
        first, *wide = (max(map(len, column)) for column in zip(*rows, strict=True))
        lines = (
            "  ".join([f"{name:{first}}", *map(str.rjust, values, wide)]).rstrip()
            for name, *values in rows
        )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from ..notebook.chains import catalogue_html

        return catalogue_html(self)


@checked_arguments("catalogue")
def catalogue() -> Catalogue:
    """All materials of the catalogue by name, a dictionary that is shown as a table.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.catalogue()["brass"].young
    101000000000.0
    """
    return _catalogue()


@cache
def _catalogue() -> Catalogue:
    given = {name: dict(entry) for name, entry in _document().items()}
    for entry in given.values():
        entry.pop(ANNEALED_BAR, None)
    return Catalogue({name: Material(name, **entry) for name, entry in given.items()})


@cache
def _document() -> dict[str, dict[str, Any]]:
    return tomllib.loads((files("hertzchain.chain") / "materials.toml").read_text("utf-8"))


def is_of_annealed_bar(given: Material) -> bool:
    """Whether the yield strength is the minimum of annealed bars, which balls exceed."""
    return any(
        ANNEALED_BAR in entry
        and given.yield_strength == entry["yield_strength"]
        and (given.name == name or given.source == entry["source"])
        for name, entry in _document().items()
    )


@checked_arguments("material")
def material(name: MaterialLike) -> Material:
    """Find a material by its name in the catalogue; a `Material` is returned unchanged.

    Parameters
    ----------
    name : str or Material
        Name, such as ``"steel-52100"``.

    Raises
    ------
    InputError
        If there is no such material.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.material("steel-52100").density
    7780.0
    """
    if isinstance(name, Material):
        return name
    known = catalogue()
    if isinstance(name, str):
        lower = name.lower()
        if name in known or lower in known:
            return known[name if name in known else lower]
        other = lower.replace("-", " ").removeprefix("aisi").strip()
        other = other.removeprefix("steel ")
        if (meant := OTHER_NAMES.get(other)) is not None:
            raise InputError(f"unknown material {name!r}; did you mean {meant}?")
    alike = _same_kind(name, known) if isinstance(name, str) else []
    raise unknown_name_error(
        "material", name, known, meant=alternatives(alike) if len(alike) > 1 else "",
        more=", or define a custom one with Material(name, density=, young=, poisson=), or "
        "[materials.NAME] in a chain file",
    )  # fmt: skip


def _same_kind(name: str, known: Iterable[str]) -> list[str]:
    """Materials of a catalogue whose names begin with the same word, such as steel."""
    return [each for each in known if each.split("-")[0] == re.split("[- ]", name.lower())[0]]


def contact_modulus(one: Material, other: Material) -> float:
    r"""Effective modulus of two materials in contact [Pa].

    .. math:: \frac{1}{E^*} = \frac{1-\nu_1^2}{E_1} + \frac{1-\nu_2^2}{E_2}

    K. L. Johnson, *Contact Mechanics*, Cambridge 1985, Eq. (4.20),
    doi:10.1017/CBO9781139171731.

    Parameters
    ----------
    one, other : Material
        The two materials; one of them may be `RIGID`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.chain.materials import contact_modulus
    >>> steel = hc.material("steel-52100")
    >>> round(contact_modulus(steel, steel) / 1e9, 2)
    111.54
    """
    return 1.0 / (one.compliance + other.compliance)


def contact_moduli(materials: Sequence[Material]) -> Array:
    """Effective modulus of each contact of neighbouring bodies [Pa]; infinite if both are rigid."""
    compliance = np.array([each.compliance for each in materials])
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(1.0 / (compliance[:-1] + compliance[1:]))


def sphere_stiffness(radius: ArrayLike, next_radius: ArrayLike, modulus: ArrayLike) -> Array:
    r"""Hertz stiffness k of two spheres in SI units, with :math:`F = k\,d^{3/2}`.

    .. math::

        k = \tfrac43 E^* \sqrt{R_{\mathrm{eff}}}, \qquad
        \frac1{R_{\mathrm{eff}}} = \frac1{R_1} + \frac1{R_2}

    Johnson 1985, Eq. (4.23).  An infinite radius represents a flat wall.

    Parameters
    ----------
    radius, next_radius : array_like
        Radii [m]; one of the two may be infinite.
    modulus : array_like
        Effective modulus of `contact_modulus` [Pa].

    Returns
    -------
    ndarray
        Stiffness [N/m^1.5].

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.chain.materials import contact_modulus
    >>> from hertzchain.chain.materials import sphere_stiffness
    >>> steel = hc.material("steel-52100")
    >>> modulus = contact_modulus(steel, steel)
    >>> round(float(sphere_stiffness(5e-3, 5e-3, modulus)) / 1e9, 6)
    7.435897
    """
    one, other = (real_numbers("radius", each, unit="m") for each in (radius, next_radius))
    modulus = real_numbers("modulus", modulus, unit="Pa")
    return np.asarray(4.0 / 3.0 * modulus / np.sqrt(1.0 / one + 1.0 / other))


def material_per_bead(given: Sequence[MaterialLike], beads: int) -> tuple[Material, ...]:
    """Look up the materials of all beads."""
    listed = check_list("materials", given, "names")
    kinds = tuple(each if isinstance(each, Material) else material(each) for each in listed)
    if len(kinds) != beads:
        words = f"there must be {beads} materials, one for each bead, got {len(kinds)}"
        if len(kinds) > 1 and not beads % len(kinds):
            words += (
                f"; for a cell of {len(kinds)} beads that repeats, use Chain.periodic, or in a "
                f"chain file cell_diameters with {len(kinds)} values and "
                f"cells = {beads // len(kinds)}"
            )
        raise InputError(words)
    return kinds
