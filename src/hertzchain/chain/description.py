"""Short description of the beads of a chain, for titles of tables and figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..collision import HERTZ_EXPONENT, Array
from ..representation import MAX_DIGITS, listed, measure
from .changed_tapers import ChangedTaper, changed_taper, taper_behind
from .decorations import Decoration, decoration_of
from .materials import Material
from .repeated_cells import cell_repeats, smallest_cell
from .tapers import taper_named

# Stiffness [N/m^1.5] from which it is in N/um^1.5.
MICRONS: Final = 1e8
# Features whose names would read like a count or a quality.
GIVEN: Final = {"masses": "given masses", "stiffness": "given stiffness"}
# Beads of a chain of which one is called different.
MIN_BEADS: Final = 4


def beads_description(
    radii: Array,
    materials: Sequence[Material] | None,
    taper: str | None,
    parameters: Sequence[tuple[str, float]],
    cells: str = "",
    scatter: str = "",
    masses: Array | None = None,
    *,
    strikers: int = 0,
    scaled: bool,
) -> str:
    """Such as ``uniform, 20 beads``, or ``20 brass beads, diameters 9 mm to 5 mm, linear taper``.

    Strikers are neither counted nor described.  With a scatter, radii and taper are those without
    it.  Masses are `None` if they follow from the radii.
    """
    count = len(radii)
    beads = ", ".join(filter(None, (scatter, beads_of(count, "beads"))))
    if taper is not None:
        return f"{_taper_in_words(taper, parameters)}, {beads}"
    names = [each.name for each in materials or ()]
    # Balls are counted without strikers.
    noun = "ball" if strikers else "bead"
    odd = odd_bead(radii, names, masses, noun=noun, scaled=scaled)
    if scaled and odd is not None:
        return f"uniform{odd.scaled_words}, {beads}"
    if odd is not None:
        counted = beads_of(count, "beads", [odd.usual_material or "SI"])
        size = f"diameter {diameter_in_words(odd.usual_radius)}"
        return ", ".join(filter(None, (counted, size, odd.words, scatter)))
    if scaled:
        equal = np.ptp(radii) == 0.0
        kind = "uniform" if equal else _edited_taper(radii, strikers) or "given radii"
        return f"{cells or kind}, {beads}"
    names = list(dict.fromkeys(names))
    diameters = "diameter" if np.ptp(radii) == 0.0 else "diameters"
    counted = beads_of(count, "beads", names or ["SI"])
    sizes = f"{diameters} {sizes_in_words(radii)}"
    return ", ".join(filter(None, (counted, sizes, shape_in_words(radii), scatter)))


def _taper_in_words(taper: str, parameters: Sequence[tuple[str, float]]) -> str:
    """Such as ``forward-exponential, q = 0.05``."""
    symbols = taper_named(taper).symbols
    return ", ".join((taper, *(f"{symbols[name]} = {value:g}" for name, value in parameters)))


def _edited_taper(radii: Array, strikers: int) -> str:
    """Such as ``backward-linear, S = 0.1, decorated (ratio 0.4)``; empty for other beads."""
    decoration = decoration_of(radii)
    if decoration is None:
        changed = changed_taper(radii)
        # Without strikers, the unit of length is the first radius of the taper.
        if changed is None or not (strikers or math.isclose(changed.radii[0], 1.0)):
            return ""
        taper, parameters = taper_behind(changed.radii)
        return f"{_taper_in_words(str(taper), parameters)}, {changed.words}"
    taper, parameters = taper_behind(decoration.large)
    kind = "given radii" if taper is None else _taper_in_words(taper, parameters)
    return f"{kind}, {decoration.words}"


@dataclass(frozen=True)
class OddBead:
    """The only bead that differs from the others, which are equal.

    ``words`` are such as ``except bead 10 (8 mm brass)``, without commas, which separate the parts
    of a description.
    """

    words: str
    usual_radius: float
    usual_material: str
    usual_mass: float | None

    @property
    def scaled_words(self) -> str:
        """Such as `` (radius 0.5) except bead 1 (radius 1)``, after a word for equal beads."""
        usual = {"radius": self.usual_radius, "mass": self.usual_mass or 1.0}
        sizes = " and ".join(f"{name} {size:.4g}" for name, size in usual.items() if size != 1.0)
        return f"{sizes and f' ({sizes})'} {self.words}"


def odd_bead(
    radii: Array,
    materials: Sequence[str],
    masses: Array | None,
    *,
    noun: str,
    scaled: bool,
) -> OddBead | None:
    """The bead that differs from all others, if there is exactly one among at least four.

    Names of materials are empty if there are none; masses are `None` if they follow from the
    radii.
    """
    usual_radius, odd = _usual(radii)
    usual_material, other = _usual(np.array(materials or [""] * len(radii)))
    odd = odd | other
    usual_mass: Any = None
    if masses is not None:
        usual_mass, other = _usual(masses)
        odd = odd | other
    if len(radii) < MIN_BEADS or np.count_nonzero(odd) != 1:
        return None
    i, words = int(np.argmax(odd)), list[str]()
    if radii[i] != usual_radius:
        size, _ = _distinguishable(radii[i], usual_radius)
        words.append(f"radius {_distinct(radii[i], usual_radius)}" if scaled else size)
    if materials and materials[i] != usual_material:
        words.append(materials[i])
    if masses is not None and masses[i] != usual_mass:
        mass = _distinct(masses[i], usual_mass) if scaled else mass_in_words(float(masses[i]))
        words.append(f"{'and ' * bool(words)}mass {mass}")
    return OddBead(
        f"except {noun} {i + 1} ({' '.join(words)})", usual_radius, usual_material, usual_mass
    )


def _usual(values: NDArray[Any]) -> tuple[Any, NDArray[np.bool_]]:
    """The most frequent value, and which values are others."""
    found, counts = np.unique(values, return_counts=True)
    usual = found[np.argmax(counts)].item()
    return usual, values != usual


def _distinct(value: float, usual: float) -> str:
    """A number with four digits, or with as many as distinguish it from the usual one."""
    short = f"{value:.4g}"
    return short if short != f"{usual:.4g}" else f"{value:.{MAX_DIGITS}g}"


def implied_features(beads: str, *, scaled: bool, equal_contacts: bool) -> list[str]:
    """Features that need not be named after this description of the beads."""
    implied = ["SI units"]
    if scaled and beads.startswith("dimer, mass") and equal_contacts:
        implied += ["masses", "stiffness"]
    if scaled and beads.startswith("uniform") and " except " in beads:
        implied.append("masses")
    return implied


def cells_in_words(radii: Array, masses: Array | None) -> str:
    """Such as ``dimer, mass ratio 0.3`` or ``cells of 3 beads``; empty without repeated cells.

    Masses are `None` if they follow from the radii.
    """
    both = (radii,) if masses is None else (radii, masses)
    if all(np.ptp(each) == 0.0 for each in both):
        return ""
    size = smallest_cell(*both)
    if size == 2:
        name, values = ("radius", radii) if masses is None else ("mass", masses)
        return f"dimer, {name} ratio {values[1] / values[0]:.4g}"
    return "" if size is None else f"cells of {size} beads"


def law_in_words(exponents: Array | float) -> str:
    """Such as ``p = 2``, if one exponent of all contacts is not that of Hertz."""
    hertz = not isinstance(exponents, float) or exponents == HERTZ_EXPONENT
    return "" if hertz else f"p = {exponents:g}"


def beads_of(count: int, noun: str, materials: Sequence[str] = ()) -> str:
    """Such as ``20 brass balls``, ``20 balls of brass and glass``, ``20 balls of 3 materials``.

    A name of several words, such as ``my steel``, follows the noun, too.
    """
    noun = noun.removesuffix("s") if count == 1 else noun
    if len(materials) <= 1 and not any(" " in name for name in materials):
        return " ".join((str(count), *materials, noun))
    few = " and ".join(materials) if len(materials) <= 2 else f"{len(materials)} materials"
    return f"{count} {noun} of {few}"


def sizes_in_words(radii: Array) -> str:
    """Diameter, or those of all but one, two in turn, the ends of a taper, or the extremes.

    Radii that neither grow nor shrink are ``between 8 mm and 20 mm``.  The ends of a decorated
    taper are those of its large beads, and those of a taper with changed beads are without the
    changes; `shape_in_words` names the rest.
    """
    low, high = radii.min(), radii.max()
    if low == high:
        return diameter_in_words(low)
    if len(radii) > 2 and cell_repeats(2, radii):
        one, other = _distinguishable(radii[0], radii[1])
        return f"{one} and {other} in turn"
    usual = np.median(radii)
    if len(radii) > 3 and np.count_nonzero(radii != usual) == 1:
        one, other = _distinguishable(usual, low if high == usual else high)
        return f"{one} except one of {other}"
    if decoration := decoration_of(radii):
        ends = _distinguishable(decoration.large[0], decoration.large[-1])
        return " to ".join(ends)
    if changed := changed_taper(radii):
        return " to ".join(_distinguishable(changed.radii[0], changed.radii[-1]))
    sizes = list(dict.fromkeys(_distinguishable(low, high)))
    steps = np.diff(radii)
    if np.all(steps <= 0.0):
        return " to ".join(sizes[::-1])
    ascending = len(sizes) == 1 or np.all(steps >= 0.0)
    return " to ".join(sizes) if ascending else f"between {' and '.join(sizes)}"


def shape_in_words(radii: Array) -> str:
    """Such as ``exponential taper`` or ``linear taper, 1 changed bead``, after sizes."""
    edit: Decoration | ChangedTaper | None = decoration_of(radii) or changed_taper(radii)
    shape = edit.large if isinstance(edit, Decoration) else radii if edit is None else edit.radii
    taper, _ = taper_behind(shape)
    kind = "" if taper is None else f"{taper.partition('-')[2]} taper"
    return ", ".join(filter(None, (kind, "" if edit is None else edit.words)))


def _distinguishable(one: float, other: float) -> tuple[str, str]:
    """Two diameters, with two digits of their difference if four digits are the same."""
    digits = 4
    if length_in_words(2.0 * one) == length_in_words(2.0 * other):
        digits = min(MAX_DIGITS, math.ceil(math.log10(one / abs(one - other))) + 2)
    return length_in_words(2.0 * one, digits), length_in_words(2.0 * other, digits)


def shown_features(
    names: Sequence[str], left_out: Sequence[str], velocities: Array, moving: int
) -> list[str]:
    """Such as ``given masses``, ``right wall``; equal velocities of all strikers are not named."""
    first = velocities[:moving]
    usual = moving > 0 and np.ptp(first) == 0.0 and not velocities[moving:].any()
    hidden = {"strikers", "cap", *left_out, *(["velocities"] if usual else [])}
    return [GIVEN.get(name, name) for name in names if name not in hidden]


def strikers_in_words(
    count: int,
    radii: Array,
    masses: Array | None,
    units: str,
    materials: Sequence[Material] | None = None,
    *,
    flat: bool = False,
    mass: float = math.nan,
) -> str:
    """Such as ``1 striker``, ``1 striker (mass 5 g, flat)`` or ``2 strikers (19 mm, brass)``.

    Size and material are stated if they are not those of the next bead and of all beads, with the
    ``mass`` [kg] of a single sphere if it is known.  Empty without strikers.  Masses are `None` if
    they follow from the radii.  Otherwise they are shown, because the radius of a striker of a
    given mass need not be its size.
    """
    if count == 0:
        return ""
    own, others = (
        list(dict.fromkeys(each.name for each in part))
        for part in ((materials or ())[:count], (materials or ())[count:])
    )
    size = _size_of_strikers(count, radii, masses, units)
    parts = [size, listed(own) if own and own != others else ""]
    if any(parts) and not math.isnan(mass):
        parts.append(mass_in_words(mass))
    about = ", ".join(filter(None, [*parts, "flat" * flat]))
    return f"{count} striker{'s' * (count > 1)}" + (f" ({about})" if about else "")


def _size_of_strikers(count: int, radii: Array, masses: Array | None, units: str) -> str:
    sizes = radii if masses is None else masses
    if np.ptp(sizes[: count + 1]) == 0.0:
        return ""
    if masses is None and units == "SI":
        return sizes_in_words(radii[:count])
    name, unit = ("radius", "m") if masses is None else ("mass", "kg")
    ends = dict.fromkeys(
        mass_in_words(each) if units == "SI" and masses is not None else measure(each, unit, units)
        for each in (sizes[0], sizes[count - 1])
    )
    return f"{name} {' to '.join(ends)}"


def impact_in_words(velocities: Array, units: str) -> str:
    """Speed of the fastest bead at time 0, unless it is that of most scaled chains, 1."""
    speed = velocities.max()
    known = speed <= 0.0 or (units == "scaled" and speed == 1.0)
    return "" if known else f", impact at {measure(speed, 'm/s', units)}"


def length_in_words(length: float, digits: int = 4) -> str:
    """A length in m, mm or um."""
    factor, unit = (1.0, "m") if length >= 1.0 else (1e3, "mm") if length >= 1e-4 else (1e6, "um")
    return f"{factor * length:.{digits}g} {unit}"


def diameter_in_words(radius: float) -> str:
    """The diameter of a ball in m, mm or um: five digits if it has no more, such as 15.875 mm."""
    usual, exact = (length_in_words(2.0 * radius, digits) for digits in (5, 8))
    return usual if usual == exact else length_in_words(2.0 * radius)


def mass_in_words(mass: float) -> str:
    """A mass in kg or g."""
    return f"{mass:.4g} kg" if mass >= 1.0 else f"{1e3 * mass:.4g} g"


def stiffness_in_words(stiffness: float, exponent: float) -> str:
    """A stiffness in N/m^p: N/m, N/mm or kN/mm if p = 1, and N/um^1.5 for large ones of Hertz."""
    factor, unit = unit_of_stiffness(stiffness, exponent)
    return f"{factor * stiffness:.4g} {unit}"


def unit_of_stiffness(stiffness: float, exponent: float) -> tuple[float, str]:
    """Factor and unit in which a stiffness is shown."""
    if exponent == 1.0:
        if stiffness >= 1e6:
            return 1e-6, "kN/mm"
        return (1e-3, "N/mm") if stiffness >= 1e3 else (1.0, "N/m")
    if exponent == HERTZ_EXPONENT and stiffness >= MICRONS:
        return 1e-9, "N/um^1.5"
    return 1.0, f"N/m^{exponent:g}"
