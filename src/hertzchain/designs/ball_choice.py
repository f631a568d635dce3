"""Discrete variables of a design: balls of a catalogue, and the order of given beads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..chain.bead_names import numbered_places
from ..chain.chain import Chain
from ..chain.materials import Material, material
from ..chain.places import ball_places
from ..errors import InputError, unavailable_without
from ..representation import counted, short
from ..validation.objects import check_bool, check_list
from .ball_space import BallSpace
from .balls import Ball, among, load_balls
from .given_diameters import SizeRange, given_diameters
from .sizes import check_sizes_vary
from .start_rows import start_row


@dataclass(frozen=True, repr=False)
class BallChoice:
    """Balls of a catalogue for some places; see `hertzchain.vary.balls`."""

    catalogue: Any
    materials: Any
    diameters: Any
    beads: Any
    optional: bool
    start: Any = None

    def __post_init__(self) -> None:
        check_bool("optional", self.optional)
        if self.start is not None:
            given = check_list("start", self.start, "balls, such as '5 mm' or '5 mm ptfe'")
            object.__setattr__(self, "start", tuple(given))
        if self.materials is not None:
            given = [self.materials] if isinstance(self.materials, str | Material) else (
                check_list("materials", self.materials, "names")
            )  # fmt: skip
            object.__setattr__(self, "materials", tuple(map(material, given)))
        if self.diameters is not None:
            object.__setattr__(self, "diameters", given_diameters(self.diameters))

    @property
    @unavailable_without
    def balls(self) -> tuple[Ball, ...]:
        """The balls to choose from."""
        found, name = load_balls(self.catalogue), repr(str(self.catalogue))
        if self.materials is not None:
            for kind in self.materials:
                if all(each.material != kind for each in found):
                    known = ", ".join(dict.fromkeys(each.material.name for each in found))
                    raise InputError(
                        f"the catalogue {name} has no balls of {kind.name}; it has {known}; "
                        "list other balls in a file, balls = 'balls.csv'"
                    )
            found = tuple(each for each in found if each.material in self.materials)
        if self.diameters is not None:
            wanted = self.diameters
            if isinstance(wanted, SizeRange):
                wanted = wanted.sizes(found, name)
            _check_sizes(found, wanted, name, self.materials)
            chosen = tuple(each for each in found if among(each.diameter, wanted))
            _check_materials(found, chosen, wanted, name, self.materials)
            found = chosen
        return found

    def __repr__(self) -> str:
        kinds = len(self.balls)
        empty = ", places may be empty" if self.optional else ""
        return short("BallChoice", f"{counted(kinds, 'kind')} of balls for {self.beads!r}{empty}")

    def space(self, chain: Chain) -> BallSpace:
        """The choices for a chain."""
        places, balls = ball_places(chain, numbered_places(chain, self.beads)), self.balls
        _check(chain, places)
        if chain.units != "SI" or chain.materials is None:
            raise InputError(
                "balls of a catalogue have materials: build the chain with Chain.from_materials"
            )
        if len(balls) + self.optional < 2:
            raise InputError("there is one kind of balls, which leaves nothing to vary")
        space = BallSpace(chain, places, balls, self.optional)
        if space.limits is not None and not self.optional and sum(space.limits) < space.size:
            raise InputError(
                f"the catalogue {str(self.catalogue)!r} has {sum(space.limits)} balls in stock for "
                f"{space.size} places; let fewer beads vary, or permit empty places (optional)"
            )
        if self.start is None:
            return space
        return replace(space, start=start_row(space, self.start))


@dataclass(frozen=True, repr=False)
class OrderChoice:
    """The order of some beads; see `hertzchain.vary.order`."""

    beads: Any

    def __repr__(self) -> str:
        return short("OrderChoice", f"order of the beads {self.beads!r}")

    def space(self, chain: Chain) -> BallSpace:
        """The orders for a chain."""
        places = ball_places(chain, numbered_places(chain, self.beads))
        _check_no_striker(chain, places)
        _check(chain, places)
        kinds = chain.materials or (None,) * chain.beads
        items = [(float(chain.radii[k]), kinds[k]) for k in places]
        distinct = list(dict.fromkeys(items))
        if len(distinct) < 2:
            raise InputError("all beads that can be exchanged are equal, which leaves no order")
        if chain.units == "scaled" and chain.strikers in places:
            raise InputError(
                f"bead {chain.strikers + 1} has radius 1, the unit of a scaled chain, and cannot "
                f"be exchanged: use beads='{chain.strikers + 2}:'"
            )
        given = np.array([distinct.index(each) for each in items])
        balls = tuple(Ball(2.0 * radius, kind) for radius, kind in distinct)
        return BallSpace(chain, places, balls, False, given)


def _check_no_striker(chain: Chain, places: NDArray[np.int64]) -> None:
    """Raise `InputError` if a striker of given mass or with a flat face is to be exchanged."""
    bodies = ((k, each) for k, each in chain._bodies.items() if k < chain.strikers)
    given = [k for k, each in bodies if each.mass is not None or each.flat]
    if found := sorted({*given} & {*places.tolist()}):
        first = chain.strikers + 1
        which = "the striker" if chain.strikers == 1 else "a striker"
        raise InputError(
            f"bead {found[0] + 1} is {which}; the order of balls begins at bead {first}: use "
            f"beads='{first}:'"
        )


def _check(chain: Chain, places: NDArray[np.int64]) -> None:
    own = sorted({"masses", "stiffness"} & set(chain.given))
    if chain.gaps[chain.strikers :].any():
        own.append("gaps")
    if own:
        raise InputError(
            f"the {' and '.join(own)} of this chain are given bead by bead, and its beads "
            "cannot be exchanged: omit them"
        )
    check_sizes_vary(chain, places)


def _check_sizes(
    balls: tuple[Ball, ...], wanted: tuple[float, ...], name: str, materials: Any
) -> None:
    """Raise `InputError` if a catalogue does not have all diameters."""
    found = sorted({each.diameter for each in balls})
    missing = [each for each in wanted if not among(each, tuple(found))]
    if not missing:
        return
    nearest = [found[int(np.argmin(np.abs(np.array(found) - size)))] for size in missing]
    of = f" of {' or '.join(kind.name for kind in materials)}" if materials else ""
    verb = "is" if len(missing) == 1 else "are"
    raise InputError(
        f"{', '.join(f'{1e3 * each:g} mm' for each in missing)} {verb} not among the balls{of} in "
        f"the catalogue {name}; the nearest {verb} "
        f"{', '.join(f'{1e3 * each:g} mm' for each in dict.fromkeys(nearest))}"
    )


def _check_materials(
    balls: tuple[Ball, ...], chosen: tuple[Ball, ...], wanted: tuple[float, ...], name: str,
    materials: Any,
) -> None:  # fmt: skip
    """Raise `InputError` if no ball of a requested material has one of the diameters."""
    for kind in materials or ():
        if any(each.material == kind for each in chosen):
            continue
        sizes = np.array([each.diameter for each in balls if each.material == kind])
        nearest = dict.fromkeys(float(sizes[np.argmin(np.abs(sizes - each))]) for each in wanted)
        raise InputError(
            f"no ball of {kind.name} in the catalogue {name} has one of these diameters; the "
            f"nearest are {', '.join(f'{1e3 * each:g} mm' for each in nearest)}: add some of them, "
            f"or omit {kind.name}"
        )
