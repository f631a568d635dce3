"""Drives: a force on bead 1, or a displacement of the left wall, as a function of time.

Each drive is a frozen dataclass that gives its value at any time and the times at which it is
not smooth, at which an integration step must end.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import bounded_numbers, number, per_bead_array, real_numbers
from ..validation.objects import check_choice
from .parts import Part
from .scales import scale

Driven = Literal["force", "displacement"]
Window = Literal["hann", "none"]
DRIVEN: Final[tuple[Driven, ...]] = get_args(Driven)
WINDOWS: Final[tuple[Window, ...]] = get_args(Window)
# Unit of the values of each kind of drive, in SI and as in `Scales.unit`.
_UNIT: Final[dict[str, str]] = {"force": "N", "displacement": "m"}
_DRIVEN_SCALE: Final = scale(lambda drive: {"force": "force", "displacement": "length"}[drive.of])


@checked_methods
@checked_fields
@dataclass(frozen=True)
class SineBurst(Part):
    r"""Some periods of a sine, by default with a window that begins and ends smoothly.

    .. math::

        a(t) = A\,w(t) \sin(2\pi f t), \quad 0 < t < n/f, \qquad
        w = \tfrac12\left[1 - \cos(2\pi f t/n)\right] \ \text{or}\ 1

    Attributes
    ----------
    amplitude : float
        A [scaled; N for a force, m for a displacement].
    frequency : float
        f > 0 [scaled, or Hz].
    cycles : float
        Number n of periods: a multiple of 1/2, or infinite without a window.
    of : str
        ``"force"``, on bead 1 towards bead N, or ``"displacement"``, of the left wall.
    window : str
        ``"hann"`` or ``"none"``.

    Examples
    --------
    Half a sine, like the blow of a hammer:

    >>> import hertzchain as hc
    >>> blow = hc.SineBurst(100.0, 5e3, cycles=0.5, window="none")
    >>> blow.value([0.0, 5e-5, 1e-3]).round(9)
    array([  0., 100.,   0.])
    """

    amplitude: float = field(metadata=_DRIVEN_SCALE)
    frequency: float = field(metadata=scale("1/time"))
    cycles: float = 5.0
    of: Driven = "force"
    window: Window = "hann"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_driven(self.of)
        check_choice("window", self.window, WINDOWS)
        _set(self, "amplitude", number("amplitude", self.amplitude, unit=_UNIT[self.of]))
        _set(self, "frequency", number("frequency", self.frequency, unit="Hz", above=0.0))
        endless = isinstance(self.cycles, float) and self.cycles == math.inf
        if endless and self.window == "none":
            return
        if endless:
            raise InputError("a burst with infinitely many cycles has no window: use window='none'")
        _set(self, "cycles", number("cycles", self.cycles, above=0.0))
        if (2.0 * self.cycles) % 1.0:
            raise InputError(
                f"cycles must be a multiple of 1/2 for the burst to end at 0, got {self.cycles:g}"
            )

    @property
    def kinks(self) -> Array:
        """Times at which the drive is not smooth."""
        return np.array([0.0, self.cycles / self.frequency])

    @property
    def end(self) -> float:
        """Time after which the drive does no work; may be infinite [scaled, or s]."""
        return self.cycles / self.frequency

    def value(self, times: ArrayLike) -> Array:
        """Force or displacement at given times.

        Parameters
        ----------
        times : array_like
            Times [scaled, or s].

        Examples
        --------
        >>> import hertzchain as hc
        >>> round(float(hc.SineBurst(1.0, 1.0, cycles=1.0).value(0.25)), 6)
        0.5
        """
        periods = self.frequency * bounded_numbers("time of a drive", times)
        carrier = self.amplitude * np.sin(2.0 * math.pi * periods)
        if self.window == "hann":
            carrier = carrier * np.sin(math.pi * periods / self.cycles) ** 2
        return np.asarray(np.where((periods > 0.0) & (periods < self.cycles), carrier, 0.0))


@checked_methods
@checked_fields
@dataclass(frozen=True)
class StepDrive(Part):
    r"""A value that is reached within a rise time and then kept.

    .. math:: a(t) = A\,(3u^2 - 2u^3), \qquad u = \min(t/t_r, 1)

    Attributes
    ----------
    amplitude : float
        A [scaled; N for a force, m for a displacement].
    rise : float
        Rise time t_r >= 0 [scaled, or s]; > 0 for a displacement.
    of : str
        ``"force"``, on bead 1 towards bead N, or ``"displacement"``, of the left wall.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.StepDrive(2.0, rise=1.0).value([-1.0, 0.5, 9.0])
    array([0., 1., 2.])
    """

    amplitude: float = field(metadata=_DRIVEN_SCALE)
    rise: float = field(default=0.0, metadata=scale("time"))
    of: Driven = "force"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_driven(self.of)
        _set(self, "amplitude", number("amplitude", self.amplitude, unit=_UNIT[self.of]))
        _set(self, "rise", number("rise time", self.rise, unit="s", least=0.0))
        if self.of == "displacement" and self.rise == 0.0:
            raise InputError(
                "a step of displacement needs a rise time above 0, because a wall cannot move "
                "instantaneously"
            )

    @property
    def kinks(self) -> Array:
        """Times at which the drive is not smooth."""
        return np.array([0.0, self.rise])

    @property
    def end(self) -> float:
        """Time after which the drive does no work; infinite for a force [scaled, or s]."""
        endless = self.of == "force" and self.amplitude != 0.0
        return math.inf if endless else self.rise

    def value(self, times: ArrayLike) -> Array:
        """Force or displacement at given times.

        Parameters
        ----------
        times : array_like
            Times [scaled, or s].

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.StepDrive(3.0).value(1.0))
        3.0
        """
        t = bounded_numbers("time of a drive", times)
        if self.rise == 0.0:
            return np.asarray(np.where(t >= 0.0, self.amplitude, 0.0))
        u = np.clip(t / self.rise, 0.0, 1.0)
        return np.asarray(self.amplitude * u**2 * (3.0 - 2.0 * u))


@checked_methods
@checked_fields
@dataclass(frozen=True, eq=False)
class TableDrive(Part):
    """Values at given times with linear interpolation; constant before and after.

    A displacement is counted from the wall's position at rest.  If it is not 0 at time 0, the
    wall is already there, and its contact with bead 1 begins compressed, or open: subtract the
    offset of a displacement sensor.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Increasing times, at least two [scaled, or s].
    values : ndarray, shape (n,)
        Force or displacement at these times [scaled; N or m].
    of : str
        ``"force"``, on bead 1 towards bead N, or ``"displacement"``, of the left wall.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.TableDrive([0.0, 1.0, 2.0], [0.0, 5.0, 0.0]).value([0.5, 3.0])
    array([2.5, 0. ])

    The force on the left wall at time 0 is :math:`k d^{3/2}` of an offset d:

    >>> moved = hc.TableDrive([0.0, 1.0], [0.25, 0.25], of="displacement")
    >>> chain = hc.Chain.uniform(5).replace(left_wall=hc.Wall(stiffness=1.0), drive=moved)
    >>> float(hc.simulate(chain, until=1.0).force(0)[0])
    0.125
    """

    times: Array = field(metadata=scale("time"))
    values: Array = field(metadata=_DRIVEN_SCALE)
    of: Driven = "force"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_driven(self.of)
        given = real_numbers("time of the drive", self.times, "row", unit="s")
        times = per_bead_array("time of the drive", given, given.size, "row")
        values = per_bead_array(
            "values of the drive", self.values, len(times), "row", unit=_UNIT[self.of]
        )
        if len(times) < 2:
            raise InputError(f"the table of a drive needs at least two times, got {len(times)}")
        falls = np.flatnonzero(np.diff(times) <= 0.0)
        if len(falls):
            row = int(falls[0]) + 2
            raise InputError(
                f"times of a drive must increase, but that of row {row} is {times[row - 1]:g} "
                f"after {times[row - 2]:g}"
            )
        _set(self, "times", times)
        _set(self, "values", values)

    @property
    def kinks(self) -> Array:
        """Times at which the drive is not smooth."""
        return self.times

    @property
    def end(self) -> float:
        """Time after which the drive does no work; infinite if a force remains [scaled, or s]."""
        endless = self.of == "force" and self.values[-1] != 0.0
        return math.inf if endless else max(0.0, float(self.times[-1]))

    def value(self, times: ArrayLike) -> Array:
        """Force or displacement at given times.

        Parameters
        ----------
        times : array_like
            Times [scaled, or s].

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.TableDrive([0.0, 1.0], [0.0, 1.0]).value(0.25))
        0.25
        """
        t = bounded_numbers("time of a drive", times)
        return np.asarray(np.interp(t, self.times, self.values))

    def __repr__(self) -> str:
        return (
            f"TableDrive({len(self.times)} times, {self.times[0]:g} to {self.times[-1]:g}, "
            f"of={self.of!r})"
        )


Drive: TypeAlias = SineBurst | StepDrive | TableDrive


def with_factor(drive: Drive, factor: float) -> Drive:
    """The drive with all of its values multiplied by a factor."""
    if isinstance(drive, TableDrive):
        return dataclasses.replace(drive, values=factor * drive.values)
    return dataclasses.replace(drive, amplitude=factor * drive.amplitude)


def _check_driven(of: str) -> None:
    check_choice("driven quantity", of, DRIVEN)


def _set(item: object, name: str, value: object) -> None:
    object.__setattr__(item, name, value)
