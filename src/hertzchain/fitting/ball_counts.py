"""Chains with one ball more or fewer at the end of the row, in front of a cap."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.repeated_cells import smallest_cell
from ..errors import InputError

# Fields with one value per bead, and per contact of two beads, that chains keep if they are given.
OF_BEADS: Final = ("masses", "velocities")
OF_CONTACTS: Final = ("stiffness", "gaps")


def ball_count(chain: Chain) -> int:
    """Number of balls: beads without strikers and a cap."""
    return chain._balls.stop - chain._balls.start


def numbers_in_words(chain: Chain) -> str:
    """Numbers of the balls and of a cap, such as "balls are 1 to 16, and whose cap is 17"."""
    balls = ball_count(chain)
    cap = f", and whose cap is {balls + 1}" if chain.cap is not None else ""
    return f"balls are 1 to {balls}{cap}"


def with_ball_more(chain: Chain) -> Chain:
    """The chain with another ball behind the last one, which continues the pattern of the balls."""
    end = chain._balls.stop
    like = end - _cell(chain)

    def of_beads(values: Any) -> list[Any]:
        return [*values[:end], values[like], *values[end:]]

    def of_contacts(values: Any) -> list[Any]:
        # The contact in front of the new ball; that behind it is the one with the cap.
        return [*values[: end - 1], values[max(like - 1, 0)], *values[end - 1 :]]

    return _changed(chain, of_beads, of_contacts)


def with_ball_fewer(chain: Chain) -> Chain:
    """The chain without its last ball."""
    last = chain._balls.stop - 1

    def of_beads(values: Any) -> list[Any]:
        return [*values[:last], *values[last + 1 :]]

    def of_contacts(values: Any) -> list[Any]:
        return [*values[: last - 1], *values[last:]]

    return _changed(chain, of_beads, of_contacts)


def _cell(chain: Chain) -> int:
    """Balls of the cell that the row repeats; 1 if the last ball is to be repeated."""
    balls = chain._balls
    radii, masses = chain.radii[balls], chain.masses[balls]
    kinds = (chain.materials or ())[balls]
    numbers = np.array([kinds.index(each) for each in kinds])
    properties = [radii, masses, numbers] if kinds else [radii, masses]
    if all(np.ptp(each) == 0 for each in properties):
        return 1
    return smallest_cell(*properties) or 1


def _changed(chain: Chain, of_beads: Any, of_contacts: Any) -> Chain:
    """The chain with functions applied to all values that are listed."""
    if ball_count(chain) < 2:
        raise InputError("a row of one ball cannot have one ball more or fewer")
    changes: dict[str, Any] = {"radii": of_beads(chain.radii)}
    changes |= {name: of_beads(getattr(chain, name)) for name in OF_BEADS if name in chain.given}
    changes |= {
        name: of_contacts(getattr(chain, name)) for name in OF_CONTACTS if name in chain.given
    }
    if chain.materials is not None:
        changes["materials"] = of_beads(chain.materials)
    if isinstance(chain.exponent, np.ndarray):
        changes["exponent"] = of_contacts(chain.exponent)
    if isinstance(chain.loss, tuple):
        changes["loss"] = of_contacts(chain.loss)
    return chain.replace(**changes)
