"""What a wall felt: the force in time, its peak, and impulses kept apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from hertzchain.contacts import Array

Side = Literal["left", "right"]
SIDES: Final[tuple[Side, ...]] = ("left", "right")


@dataclass(frozen=True, eq=False)
class WallForce:
    """What one wall felt.

    Attributes
    ----------
    side : str
        ``"left"`` or ``"right"``.
    times, force : ndarray, shape (T,)
        Force on the wall at the saved times [scaled, or s and N].
    peak, peak_time : float
        Largest force and when; found between the steps, not among the saved times.
    first_impulse : float or None
        Impulse of the first contact; `None` while it lasts, or before.
    first_end : float or None
        Time at which the first contact had ended.
    impulse : float
        Impulse of the whole run.  It is larger than the first contact's where more beads
        arrive later, as in forward tapers.
    """

    side: Side
    times: Array
    force: Array
    peak: float
    peak_time: float
    first_impulse: float | None
    first_end: float | None
    impulse: float
