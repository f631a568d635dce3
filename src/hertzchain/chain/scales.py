r"""Between the paper's scaled variables and SI units.

Eqs. (2) and (3) of the paper: with the mass :math:`M_1`, radius :math:`R_1'` and speed
:math:`V_1` of the striker and the stiffness :math:`k_1` of a contact of two beads like it,
lengths of motion are in units of

.. math:: L = \left(\frac{M_1 V_1^2}{k_1}\right)^{1/(p+1)} ,

times of :math:`L/V_1`, forces of :math:`M_1 V_1^2/L = k_1 L^p`; radii are in units of
:math:`R_1'`, velocities of :math:`V_1`, masses of :math:`M_1`.  Nothing is converted
unless asked for here.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.materials import contact_modulus, sphere_stiffness
from hertzchain.chain.sizes import checked_exponent
from hertzchain.chain.walls import Wall
from hertzchain.checks import number
from hertzchain.contacts import HERTZ_EXPONENT, hertz_stiffness
from hertzchain.errors import InputError, shown

# Two numbers that only rounding has made different.
ROUNDING = 1e-12


@runtime_checkable
class _Convertible(Protocol):
    """A frozen dataclass that says in what units its fields are.

    The factor of an array may be an array, that of a dictionary is one with the same keys;
    what has no factor has no unit.
    """

    def factors(self, scales: Scales) -> Mapping[str, Any]: ...


T = TypeVar("T")


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
    Steel balls of 10 mm diameter, struck with 1 m/s:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    >>> scales = Scales.of(chain)
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
        object.__setattr__(self, "exponent", checked_exponent(self.exponent))
        for name in ("time", "energy", "force", "stiffness", "acceleration"):
            self._check_derived(name)

    def _check_derived(self, name: str) -> None:
        """Refuse units that cannot be represented."""
        try:
            value = float(getattr(self, name))
        except (OverflowError, ZeroDivisionError):
            value = math.inf
        if not 0.0 < value < math.inf:
            raise InputError(
                f"the unit of {name} that follows from {self} is {value:g}: look at their units"
            )

    @classmethod
    def of(cls, chain: Chain, *, velocity: float | None = None) -> Scales:
        """The scales in which a chain in SI units becomes the paper's.

        The first bead that is no striker has radius and mass 1.

        Parameters
        ----------
        chain : Chain
            A chain in SI units.
        velocity : float, optional
            Unit of velocity [m/s]; the fastest bead's at time 0 if not given.

        Returns
        -------
        Scales

        Raises
        ------
        InputError
            If the chain is not in SI units, or nothing moves and no velocity is given.

        Examples
        --------
        >>> chain = Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=2.0)
        >>> Scales.of(chain).velocity
        2.0
        """
        check_chain("Scales.of", chain)
        if chain.units != "SI":
            raise InputError(
                "scales belong to a chain in SI units; for a scaled one give radius, mass, "
                "velocity and length, or Scales.of_material"
            )
        fastest = float(np.abs(chain.velocities).max())
        if velocity is None and fastest == 0.0:
            raise InputError("nothing moves at time 0: give the velocity to scale with")
        speed = number("velocity", fastest if velocity is None else velocity, unit="m/s", above=0.0)
        unit = chain.strikers
        radius, mass = float(chain.radii[unit]), float(chain.masses[unit])
        if chain.materials is not None and "stiffness" not in chain.given:
            own = chain.materials[unit]
            stiffness = float(sphere_stiffness(radius, radius, contact_modulus(own, own)))
        else:
            # The contact behind it, as if its beads were of one material.
            ratio = hertz_stiffness(1.0, chain.radii[min(unit + 1, chain.beads - 1)] / radius)
            stiffness = float(chain.stiffness[min(unit, chain.beads - 2)] / ratio)
        length = (mass * (speed * speed) / stiffness) ** (1.0 / (chain.exponent + 1.0))
        return cls(radius, mass, speed, length, chain.exponent)

    @property
    def time(self) -> float:
        """Unit of time L/V_1 [s]."""
        return self.length / self.velocity

    @property
    def momentum(self) -> float:
        """Unit of momentum M_1 V_1 [kg m/s]."""
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
        """Unit of stiffness, that of two beads like the first [N/m^p]."""
        return self.force / self.length**self.exponent

    @property
    def acceleration(self) -> float:
        """Unit of acceleration V_1^2/L [m/s^2]."""
        return self.velocity**2 / self.length

    def to_si(self, item: T) -> T:
        """A chain, run, pulse, drive, ... in scaled variables, in SI units.

        Parameters
        ----------
        item : Chain, Run, State, Pulse, or part of a chain
            What to convert.

        Returns
        -------
        the same type

        Raises
        ------
        InputError
            If it is in SI units already, or cannot be converted.

        Examples
        --------
        >>> import hertzchain as hc
        >>> scales = Scales(radius=5e-3, mass=4e-3, velocity=1.0, length=12e-6)
        >>> pulse = scales.to_si(hc.bca(hc.Chain.uniform(20)))
        >>> float(pulse.peak_time is None), round(float(pulse.arrival[1] * 1e6), 3)
        (1.0, 14.633)
        """
        return _converted(item, self, to_si=True)

    def to_scaled(self, item: T) -> T:
        """A chain, run, pulse, drive, ... in SI units, in the paper's scaled variables.

        A chain that is the paper's but for its units becomes a plain one, which the
        theories take.

        Parameters
        ----------
        item : Chain, Run, State, Pulse, or part of a chain
            What to convert.

        Returns
        -------
        the same type

        Raises
        ------
        InputError
            If it is scaled already, or cannot be converted.

        Examples
        --------
        >>> chain = Chain.from_materials([5e-3, 2.5e-3, 5e-3], "steel-52100")
        >>> Scales.of(chain).to_scaled(chain).masses
        array([1.   , 0.125, 1.   ])
        """
        return _converted(item, self, to_si=False)


def _converted(item: T, scales: Scales, *, to_si: bool) -> T:
    if isinstance(item, Chain):
        return _converted_chain(item, scales, to_si=to_si)  # type: ignore[return-value]
    changes: dict[str, Any] = {}
    if not dataclasses.is_dataclass(item) or isinstance(item, type):
        raise InputError(
            f"cannot convert {shown(item)}: it is no chain, run, pulse or part of a chain"
        )
    for field in dataclasses.fields(item):
        value = getattr(item, field.name)
        if isinstance(value, Chain | _Convertible):
            changes[field.name] = _converted(value, scales, to_si=to_si)
    if isinstance(item, _Convertible):
        for name, factor in item.factors(scales).items():
            value = getattr(item, name)
            if value is not None:
                changes[name] = _times(value, factor, to_si=to_si)
    return dataclasses.replace(item, **changes)


def _times(value: Any, factor: Any, *, to_si: bool) -> Any:
    if isinstance(value, dict):
        return value | {
            name: _times(value[name], part, to_si=to_si) for name, part in factor.items()
        }
    return value * factor if to_si else value / factor


def _converted_chain(chain: Chain, scales: Scales, *, to_si: bool) -> Chain:
    wanted, units = ("SI", "scaled") if to_si else ("scaled", "SI")
    if chain.units != units:
        raise InputError(f"the chain is in {chain.units} units already: {chain.description}")
    if chain.exponent != scales.exponent:
        raise InputError(
            f"these scales are for p = {scales.exponent:g}, but the chain has p = "
            f"{chain.exponent:g}"
        )
    factors = {
        "radii": scales.radius, "masses": scales.mass, "stiffness": scales.stiffness,
        "velocities": scales.velocity, "gaps": scales.length,
        "precompression": scales.force, "gravity": scales.acceleration,
    }  # fmt: skip
    power = 1.0 if to_si else -1.0
    changes: dict[str, Any] = {
        name: getattr(chain, name) * factor**power for name, factor in factors.items()
    }
    if not to_si:
        # Division, not a product with the inverse: a radius over itself is 1.
        changes |= {name: getattr(chain, name) / factor for name, factor in factors.items()}
    for name in ("drive", "loss"):
        part = getattr(chain, name)
        changes[name] = _converted(part, scales, to_si=to_si) if part is not None else None
    for name, stiffness in zip(("left_wall", "right_wall"), chain.wall_stiffness, strict=True):
        wall = getattr(chain, name)
        if wall is not None:
            resolved = Wall(stiffness=stiffness, gap=wall.gap)
            changes[name] = _converted(resolved, scales, to_si=to_si)
    return _derived_where_possible(chain.replace(units=wanted, **changes))


def _derived_where_possible(chain: Chain) -> Chain:
    """Leave out masses and contacts that follow from the rest, so that a plain chain is one."""
    for name in ("masses", "stiffness"):
        try:
            derived = chain.replace(**{name: None})
        except InputError:
            continue  # nothing that they would follow from
        if np.allclose(getattr(derived, name), getattr(chain, name), rtol=ROUNDING, atol=0.0):
            chain = derived
    return chain
