"""The space of all continuous variables of a design, and its chains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..validation.numbers import number
from .sizes import NOUNS, Block, Sizes, check_sizes_vary

# Factors of lengths in chain files, which have diameters, and their number of digits.
IN_FILES: Final = {"radii": 2.0, "gaps": 1.0}
DIGITS: Final = 9


@dataclass(frozen=True, eq=False)
class SizeSpace:
    """Variables of several blocks, from 0 to 1."""

    chain: Chain
    blocks: tuple[Block, ...]

    @property
    def size(self) -> int:
        """Number of variables."""
        return sum(block.size for block in self.blocks)

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields of the chain that vary."""
        return tuple(block.field for block in self.blocks)

    def _parts(self, x: Array) -> list[Array]:
        ends = np.cumsum([block.size for block in self.blocks])[:-1]
        parts = np.split(x, ends)
        return [
            block.limits[0] + part * (block.limits[1] - block.limits[0])
            for block, part in zip(self.blocks, parts, strict=True)
        ]

    def _changes(self, x: Array) -> dict[str, Any]:
        """The fields of the chain that vary, at a point."""
        changes: dict[str, Any] = {}
        for block, part in zip(self.blocks, self._parts(x), strict=True):
            values = changes.get(block.field)
            values = np.array(getattr(self.chain, block.field)) if values is None else values
            values[block.places] = block.sizes(part)
            changes[block.field] = values
        return changes

    def chain_of(self, x: Array) -> Chain:
        """The chain at a point."""
        return self.chain.replace(**self._changes(x))

    def with_short_sizes(self, chain: Chain) -> Chain:
        """The chain with lengths that vary rounded, so that files state them as 3 mm, for example.

        Scaled chains and masses are not changed.
        """
        if chain.units != "SI":
            return chain
        changes: dict[str, Array] = {}
        for block in self.blocks:
            if block.field not in IN_FILES:
                continue
            factor = IN_FILES[block.field]
            values = changes.get(block.field)
            values = np.array(getattr(chain, block.field)) if values is None else values
            texts = [f"{factor * size * 1e3:.{DIGITS}g} mm" for size in values[block.places]]
            values[block.places] = [number("size", each, unit="m") / factor for each in texts]
            changes[block.field] = values
        return chain.replace(**changes)

    def radii(self, x: Array) -> Array:
        """The radii at a point, without checks of the chain."""
        return np.asarray(self._changes(x).get("radii", self.chain.radii))

    def price(self, x: Array) -> float:
        """Sizes have no price."""
        del x
        return float("nan")

    def pull(self, x: Array, slopes: Mapping[str, Array]) -> Array:
        """Derivatives with respect to x, from those with respect to the fields of the chain."""
        found = [
            block.pull(part, slopes[block.field]) * (block.limits[1] - block.limits[0])
            for block, part in zip(self.blocks, self._parts(x), strict=True)
        ]
        return np.concatenate(found, axis=-1)

    def point(self, chain: Chain) -> Array:
        """The point whose chain is nearest to a given one."""
        found = []
        for block in self.blocks:
            low, high = block.limits
            own = block.coefficients(getattr(chain, block.field)[block.places])
            found.append((own - low) / (high - low))
        return np.clip(np.concatenate(found), 0.0, 1.0)

    def taper(self, first: float, last: float) -> Array:
        """The point of a taper between two sizes, which are fractions of the (log) limits."""
        parts = []
        for block in self.blocks:
            low, high = block.ends
            one, other = (low + (high - low) * end for end in (first, last))
            values = np.linspace(one, other, len(block.places))
            sizes = np.exp(values) if block.log else values
            low, high = block.limits
            parts.append((block.coefficients(sizes) - low) / (high - low))
        return np.clip(np.concatenate(parts), 0.0, 1.0)


def size_space(chain: Chain, given: Sequence[Sizes]) -> SizeSpace:
    """The space of several variables, which must not overlap."""
    blocks = tuple(each.block(chain) for each in given)
    taken: set[tuple[str, int]] = set()
    for block in blocks:
        own = {(block.field, int(place)) for place in block.places}
        if repeated := sorted(taken & own):
            field, place = repeated[0]
            raise InputError(f"the {NOUNS[field]} of place {place + 1} varies twice: omit one")
        taken |= own
        if block.field == "radii" and "masses" in chain.given:
            raise InputError(
                "radii vary, but the masses of this chain are given and would not follow: omit "
                "masses, or vary them"
            )
        if block.field == "radii":
            check_sizes_vary(chain, block.places)
    _check_masses_follow(taken)
    return SizeSpace(chain, blocks)


def _check_masses_follow(taken: set[tuple[str, int]]) -> None:
    """Raise `InputError` if the radius of a bead varies, and the masses of others only."""
    varied = {name: {place for field, place in taken if field == name} for name in NOUNS}
    if varied["masses"] and (fixed := sorted(varied["radii"] - varied["masses"])):
        raise InputError(
            f"the masses of some beads vary, so that of bead {fixed[0] + 1} would not follow its "
            "radius, which varies, too: vary its mass, or only radii"
        )
