"""The force on the last body of a free end, such as an instrument, and its acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..chain.chain import Chain
from ..errors import IncompleteWarning, InputError, warn_user
from ..representation import measure, short, without_exponent
from .sensor_force import SHOWN

if TYPE_CHECKING:
    from .run import Run


def not_on_a_wall(name: str) -> str:
    """Why a chain with a right wall has no such quantity of a body behind it."""
    return (
        f"{name} is that of the last body of a free right end, and this chain has a right wall: "
        "use wall_force.peak"
    )


def body_in_words(chain: Chain) -> str:
    """The last body of a chain."""
    return "the last body" if chain.cap is None else "the cap"


@dataclass(frozen=True, repr=False)
class BodyForce:
    """The largest force of the last contact on the body behind it, without the static force.

    The result of `hertzchain.Run.body_force`.

    Attributes
    ----------
    force, time : float
        Largest force so far and its time [scaled, or N and s], located between saved times.  That
        of a run that was resumed includes the time before.
    duration : float
        Time around the maximum for which the force exceeds a tenth of it; NaN if the run begins
        later or ends earlier.
    mass : float
        Mass of the body [scaled, or kg].
    error : float
        Bound of the error of the force.
    later : bool
        Whether the largest force is not the first maximum.
    complete : bool
        Whether no later force can exceed it.  It is false if the run ends before that is known, or
        did not begin with the chain.
    units : str
        ``"SI"``, or ``"scaled"``.
    """

    force: float
    time: float
    duration: float
    mass: float
    error: float = 0.0
    later: bool = False
    complete: bool = True
    units: str = "scaled"

    @property
    def acceleration(self) -> float:
        """Largest force over mass, without any filter."""
        return self.force / self.mass

    @property
    def peak(self) -> float:
        """The largest force if it is complete, otherwise NaN."""
        return self.force if self.complete else math.nan

    def __repr__(self) -> str:
        about = f"last body, mass {measure(self.mass, 'kg', self.units)}"
        if math.isnan(self.force):
            return short("BodyForce", about, "no maximum of the force yet")
        size, time = measure(self.force, "N", self.units), measure(self.time, "s", self.units)
        unit = " m/s^2" if self.units == "SI" else ""
        lasts = measure(self.duration, "s", self.units)
        facts = [
            f"largest force{'' if self.complete else ' so far'} {size} at t = {time}",
            f"acceleration {without_exponent(self.acceleration)}{unit}",
            "duration not known" if math.isnan(self.duration) else f"duration {lasts}",
        ]
        if self.error > SHOWN * abs(self.force):
            facts.append(f"error of the force at most {measure(self.error, 'N', self.units, 2)}")
        return short("BodyForce", about, *facts)

    def _repr_html_(self) -> str:
        from ..notebook.runs import body_force_html

        return body_force_html(self)


def body_force_of(self: Run) -> BodyForce:
    """The force on the last body of a free right end, such as a cap, and its acceleration.

    Returns
    -------
    BodyForce
        Independent of the saved times: the run is repeated if they do not resolve the force.

    Raises
    ------
    InputError
        If the chain has a right wall.

    Warns
    -----
    IncompleteWarning
        If a larger force may follow; ``peak`` is then NaN.  Before the first maximum, the force is
        NaN, too.

    Examples
    --------
    >>> import hertzchain as hc
    >>> row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=8)
    >>> box = row.with_cap("100 g").struck_by(mass="50 g", radius="flat", velocity="0.1 m/s")
    >>> found = hc.simulate(box, times=0).body_force()
    >>> f"{found.peak:.2f} N, {found.acceleration:.1f} m/s^2, {1e6 * found.duration:.0f} us"
    '64.04 N, 640.4 m/s^2, 118 us'
    """
    if self.chain.right_wall is not None:
        raise InputError(not_on_a_wall("body_force"))
    # It simulates, and imports the run.
    from .body_force import body_force

    found = body_force(self)
    if found is None:
        found = BodyForce(math.nan, math.nan, math.nan, float(self.chain.masses[-1]),
                          complete=False, units=self.chain.units)  # fmt: skip
    if not found.complete:
        words = "has no maximum yet" if math.isnan(found.force) else "is not complete"
        end = measure(self.end_time, "s", self.chain.units, 6)
        warn_user(
            f"the force on {body_in_words(self.chain)} {words} at the end of the run, t = {end}; "
            "give a later until, or none",
            IncompleteWarning,
        )
    return found
