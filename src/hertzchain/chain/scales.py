r"""The units of the paper's scaled variables, in SI.

Eqs. (2) and (3) of the paper: with the mass :math:`M_1`, radius :math:`R_1'` and speed
:math:`V_1` of the striker and the stiffness :math:`k_1` of a contact of two beads like it,
lengths of motion are in units of

.. math:: L = \left(\frac{M_1 V_1^2}{k_1}\right)^{1/(p+1)} ,

times of :math:`L/V_1`, forces of :math:`M_1 V_1^2/L = k_1 L^p`; radii are in units of
:math:`R_1'`, velocities of :math:`V_1`, masses of :math:`M_1`.

`Scales` does not depend on chains.  `hertzchain.chain.conversion` converts chains and results; it
reads the unit of each number from the metadata of its field, which `scale` creates.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

from ..collision import HERTZ_EXPONENT
from ..errors import InputError
from ..representation import wrapped
from ..validation.keywords import checked_arguments, checked_fields, checked_methods
from ..validation.numbers import number
from ..validation.objects import text
from .input_checks import checked_wall_exponent

if TYPE_CHECKING:
    from .conversion import Chain

T = TypeVar("T")

# Unit of a field: a product of powers of the units of `Scales`, such as "force/velocity"; one such
# product for each row of an array or key of a dictionary; or a function of the object that
# returns any of these.
Scale: TypeAlias = "str | tuple[str, ...] | Mapping[str, Scale] | Callable[[Any], Scale]"

# Names of the units of `Scales`.
_UNITS: Final = (
    "1", "radius", "mass", "velocity", "length", "time", "momentum", "energy", "force", "stiffness",
    "acceleration",
)  # fmt: skip
_NUMBER: Final = r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_FACTOR: Final = re.compile(
    rf"([*/]?)([a-z1]+)(?:\^(?:({_NUMBER})|\(({_NUMBER})(?:/([1-9]\d*))?\)))?"
)


def factors_of(scale: str) -> list[tuple[str, str, float]]:
    """Sign, unit and power of each factor of a product of powers of units."""
    product = f"*{text('scale', scale)}"
    factors = _FACTOR.findall(product)
    known = all(sign and name in _UNITS for sign, name, *_ in factors)
    if not known or _FACTOR.sub("", product):
        raise InputError(
            f"a scale is a product of powers of {', '.join(_UNITS)}, such as "
            f"'force/velocity' or 'force/length^(1/4)', got {scale!r}"
        )
    return [
        (sign, name, float(power or above or 1.0) / float(below or 1.0))
        for sign, name, power, above, below in factors
    ]


def scale(unit: Scale, *, axis: int = 0) -> dict[str, Any]:
    """Metadata of a field: its unit, or a tuple of units along an axis of an array."""
    if isinstance(unit, str):
        factors_of(unit)
    return {"scale": unit, "axis": axis}


@checked_fields
@checked_methods
@dataclass(frozen=True)
class Scales:
    r"""The units of the paper's scaled variables, in SI.

    Attributes
    ----------
    radius : float
        :math:`R_1'`, unit of radii [m].
    mass : float
        :math:`M_1` [kg].
    velocity : float
        :math:`V_1` [m/s].
    length : float
        L, unit of displacements, overlaps and gaps [m].
    exponent : float
        Exponent p of the contact force.

    Examples
    --------
    Steel balls of 10 mm diameter, struck at 1 m/s:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    >>> scales = hc.Scales.of(chain)
    >>> round(scales.length * 1e6, 5), round(scales.force, 2)
    (12.45828, 326.98)
    """

    radius: float
    mass: float
    velocity: float
    length: float
    exponent: float = HERTZ_EXPONENT

    def __post_init__(self) -> None:
        for name, unit in (("radius", "m"), ("mass", "kg"), ("velocity", "m/s"), ("length", "m")):
            value = number(f"{name} of the scales", getattr(self, name), unit=unit, above=0.0)
            object.__setattr__(self, name, value)
        object.__setattr__(
            self, "exponent", checked_wall_exponent(self.exponent, "exponent of the scales")
        )
        for name in ("time", "energy", "force", "stiffness", "acceleration"):
            self._check_derived(name)

    def _check_derived(self, name: str) -> None:
        """Raise an error if a unit is too large or too small for a float."""
        try:
            value = float(getattr(self, name))
        except (OverflowError, ZeroDivisionError):
            value = math.inf
        if not 0.0 < value < math.inf:
            raise InputError(
                f"the unit of {name} that follows from {self} is {value:g}: check the units "
                "of the scales"
            )

    @classmethod
    @checked_arguments("Scales.of")
    def of(cls, chain: Chain, *, velocity: float | None = None) -> Scales:
        """Scales in which a chain in SI units has the variables of the paper.

        In these scales the first bead after the strikers has radius and mass 1.

        Parameters
        ----------
        chain : Chain
            A chain in SI units.
        velocity : float, optional
            Unit of velocity [m/s]; by default the velocity of the fastest bead at time 0.

        Raises
        ------
        InputError
            If the chain is not in SI units, or nothing moves and no velocity is given.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=2.0)
        >>> hc.Scales.of(chain).velocity
        2.0
        """
        from .conversion import scales_of

        return scales_of(chain, velocity)

    def __repr__(self) -> str:
        fields = ("radius", "mass", "velocity", "length", "exponent")
        return wrapped(f"Scales({', '.join(f'{name}={getattr(self, name)!r}' for name in fields)})")

    def _repr_html_(self) -> str:
        from ..notebook.chains import scales_html

        return scales_html(self)

    @property
    def time(self) -> float:
        """Unit of time L/V_1 [s]."""
        return self.length / self.velocity

    @property
    def momentum(self) -> float:
        """Unit of momentum M_1 V_1 [N s]."""
        return self.mass * self.velocity

    @property
    def energy(self) -> float:
        """Unit of energy M_1 V_1^2 [J]."""
        return self.mass * self.velocity**2

    @property
    def force(self) -> float:
        """Unit of force M_1 V_1^2/L [N]."""
        return self.energy / self.length

    @property
    def stiffness(self) -> float:
        """Unit of stiffness, that of a contact of two first beads [N/m^p]."""
        return self.force / self.length**self.exponent

    @property
    def acceleration(self) -> float:
        """Unit of acceleration V_1^2/L [m/s^2]."""
        return self.velocity**2 / self.length

    def unit(self, scale: str) -> float:
        """SI value of a product of powers of units.

        Parameters
        ----------
        scale : str
            Names of attributes, evaluated from left to right, such as ``"momentum"``,
            ``"force/velocity"``, ``"1/time"`` or ``"force/velocity^1.8"``.

        Raises
        ------
        InputError
            If the text is not such a product.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Scales(radius=1.0, mass=1.0, velocity=2.0, length=6.0).unit("1/time")
        0.3333333333333333
        """
        value = 1.0
        for sign, name, power in factors_of(scale):
            base = 1.0 if name == "1" else float(getattr(self, name)) ** power
            value = value / base if sign == "/" else value * base
        return value

    def to_si(self, item: T) -> T:
        """Convert a chain, run, pulse, drive, ... from scaled variables to SI units.

        Parameters
        ----------
        item : Chain, Run, State, Pulse, LeadingPulse, Fronts, or part of a chain
            Object to convert.

        Returns
        -------
        the same type

        Raises
        ------
        InputError
            If the object is already in SI units, or cannot be converted.

        Examples
        --------
        >>> import hertzchain as hc
        >>> scales = hc.Scales(radius=5e-3, mass=4e-3, velocity=1.0, length=12e-6)
        >>> pulse = scales.to_si(hc.bca(hc.Chain.uniform(20)))
        >>> round(float(pulse.arrival[1] * 1e6), 3)
        14.633
        """
        from .conversion import converted

        return converted(item, self, to_si=True)

    def to_scaled(self, item: T) -> T:
        """Convert a chain, run, pulse, drive, ... from SI units to the paper's scaled variables.

        Masses and stiffness that follow from the radii are not set in the scaled chain,
        which the theories therefore accept.

        Parameters
        ----------
        item : Chain, Run, State, Pulse, LeadingPulse, Fronts, or part of a chain
            Object to convert.

        Returns
        -------
        the same type

        Raises
        ------
        InputError
            If the object is already scaled, or cannot be converted.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials([5e-3, 2.5e-3, 5e-3], "steel-52100")
        >>> hc.Scales.of(chain).to_scaled(chain).masses
        array([1.   , 0.125, 1.   ])
        """
        from .conversion import converted

        return converted(item, self, to_si=False)
