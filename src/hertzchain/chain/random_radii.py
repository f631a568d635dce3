"""Random deviations of radii and gaps, for `Chain.with_scatter` and `hertzchain.Scatter`.

The deviation of a bead multiplies its radius, or adds to it for a ball grade, regardless of the
units of the chain: radii of a scaled chain stay in units of the chain without deviations.
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError, short_repr
from ..units import converted, has_dimension, quantity
from ..validation.numbers import FRACTION, number
from .description import sizes_in_words
from .fields import ChainFields
from .input_checks import GAP_HINT, MAX_GAP
from .places import ball_places
from .scattered_radii import ScatteredRadii
from .static_forces import static_forces

C = TypeVar("C", bound=ChainFields)

# Largest standard deviation of the logarithm of the radius.
MAX_SCATTER: Final = 0.3

# Variation of ball lot diameter V_DwL by grade [m], from ISO 3290-1:2014 for steel balls: the
# difference between the mean diameters of the largest and the smallest ball of a lot.
BALL_GRADES: Final = MappingProxyType(
    {
        3: 0.13e-6, 5: 0.25e-6, 10: 0.5e-6, 16: 0.8e-6, 20: 1e-6, 24: 1.2e-6, 28: 1.4e-6,
        40: 2e-6, 60: 3e-6, 100: 5e-6, 200: 10e-6,
    }
)  # fmt: skip


def relative_scatter(
    what: str,
    value: object,
    *,
    chain: ChainFields | None = None,
    above: float = -math.inf,
    least: float = -math.inf,
) -> float:
    """Check a standard deviation of the logarithm of the radius."""
    reject_length(what, value, chain)
    whole = isinstance(value, int | float) and MAX_SCATTER < value < 100.0 * MAX_SCATTER
    percent = f"for a scatter of {value:g}%, give '{value:g}%'" if whole else ""
    return number(
        what, value, unit=FRACTION, above=above, least=least, most=MAX_SCATTER, hint=percent
    )


def reject_length(what: str, value: object, chain: ChainFields | None = None) -> None:
    """Reject a scatter that is a length, with the relative one of the diameters of a chain."""
    found = quantity(value) if isinstance(value, str) else None
    if found is None or not has_dimension(found[1], "m"):
        return
    length = converted(what, *found, "m")
    if chain is None or chain.scaled:
        example = f"; for diameters of 10 mm, give '{100.0 * length / 10e-3:.3g}%'"
    else:
        radii = chain.radii[chain._balls]
        parts = (f"'{50.0 * length / radius:.3g}%'" for radius in (radii.max(), radii.min()))
        between = " to ".join(dict.fromkeys(parts))
        sizes = sizes_in_words(radii)
        of = "" if sizes.startswith("between") else "of "
        example = f"; for diameters {of}{sizes}, give {between}"
    raise InputError(f"{what} must be relative to the diameters, got the length {value!r}{example}")


def check_grade(grade: object) -> None:
    """Raise `InputError` unless it is a ball grade."""
    if type(grade) is not int or grade not in BALL_GRADES:
        known = ", ".join(map(str, BALL_GRADES))
        raise InputError(f"ISO 3290-1 has no ball grade {short_repr(grade)}; choose from {known}")


def checked_size_of_gaps(what: str, gaps: object, unit: str | None) -> float:
    """The scale of random gaps, a length in the units of a chain."""
    return number(what, gaps, unit=unit, above=0.0, most=MAX_GAP, hint=GAP_HINT)


def check_gaps_can_open(chain: ChainFields) -> None:
    """Raise `InputError` if static forces close all gaps of a chain."""
    if chain.precompression > 0.0:
        raise InputError(
            "precompressed beads touch and have no gaps: omit the gaps, or the precompression"
        )
    if static_forces(chain.loads).any():
        raise InputError(
            "the beads of this chain rest on each other under gravity, and a chain with gaps would "
            "fall: omit the gaps, or the gravity"
        )


def check_scatter(
    chain: ChainFields, relative: float | None, grade: int | None, gaps: object, beads: Any
) -> float | None:
    """Raise `InputError` if the radii or gaps of a chain cannot deviate; the size of the gaps."""
    if gaps is not None:
        gaps = checked_size_of_gaps("gaps of a scatter", gaps, chain._unit("m"))
        check_gaps_can_open(chain)
    if relative is not None or grade is not None:
        _check_radii(chain, grade, beads)
    return gaps


def _check_radii(chain: ChainFields, grade: int | None, beads: Any) -> None:
    if beads is not None:
        _check_places(chain, ball_places(chain, beads))
    if own := sorted({"masses", "stiffness"} & set(chain.given)):
        raise InputError(
            f"a scatter of radii changes the {' and '.join(own)}, which this chain gives: omit them"
        )
    if grade is None:
        return
    if chain.units != "SI":
        raise InputError(
            "ball grades are tolerances in micrometres; use Chain.from_materials, or relative"
        )
    if 0.25 * BALL_GRADES[grade] >= (smallest := chain.radii[: chain._balls.stop].min()):
        raise InputError(
            f"a diameter of {2e3 * smallest:.4g} mm is too small for balls of grade "
            f"{grade}, whose diameters vary by {1e6 * BALL_GRADES[grade]:g} um"
        )


def _check_places(chain: ChainFields, places: NDArray[np.int64]) -> None:
    fixed = places[~chain._follows("masses")[places]]
    if len(fixed) and "masses" not in chain.given:
        body = "striker" if fixed[0] < chain.strikers else "cap"
        raise InputError(
            f"the mass of bead {fixed[0] + 1}, a {body}, is given and would not follow its radius: "
            "let only the balls deviate"
        )


def random_draws(
    rng: np.random.Generator, shape: tuple[int, int], grade: int | None, gaps: float | str | None
) -> Array:
    """Random numbers of radii and gaps, shape (..., 2); those of radii do not depend on gaps.

    They are normal; those of radii are uniform from -1 to 1 for a grade.
    """
    radii = rng.standard_normal(shape) if grade is None else rng.uniform(-1.0, 1.0, shape)
    between = np.zeros(shape) if gaps is None else rng.standard_normal(shape)
    return np.stack((radii, between), axis=-1)


def with_deviations(
    chain: C, draws: Array, relative: float | None, grade: int | None, gaps: float | None,
    beads: Any,
) -> list[C]:  # fmt: skip
    """One chain for each row of draws; masses and contacts follow from its radii.

    A gap is random if both of its beads deviate.
    """
    places = np.arange(chain.beads)
    deviate = np.isin(places, places[chain._balls] if beads is None else ball_places(chain, beads))
    chains = [chain] * len(draws)
    if relative or grade is not None:
        radii = np.where(deviate, _random_radii(chain, draws[..., 0], relative, grade), chain.radii)
        chains = [scattered(chain, row, relative, grade) for row in radii]
    if gaps is None:
        return chains
    added = np.where(deviate[:-1] & deviate[1:], gaps * np.abs(draws[:, :-1, 1]), 0.0)
    return [each.replace(gaps=chain.gaps + row) for each, row in zip(chains, added, strict=True)]


def _random_radii(
    chain: ChainFields, draws: Array, relative: float | None, grade: int | None
) -> Array:
    if grade is None:
        assert relative is not None
        return np.asarray(chain.radii * np.exp(relative * draws))
    # The grade limits the variation of diameters, which is four times the largest deviation.
    return chain.radii + 0.25 * BALL_GRADES[grade] * draws


def scattered(chain: C, radii: Array, relative: float | None, grade: int | None) -> C:
    """The chain with these radii, which have a scatter."""
    scatter = ScatteredRadii(chain.radii, relative, grade, chain.taper, chain.taper_parameters)
    return chain.replace(radii=radii, scatter=scatter)
