"""Common parts of the laws of loss: parameters, elastic curve, stored energy.

A law is a frozen dataclass derived from `Loss`, in a file of this package.  Its class statement
states its name in chain files.  Its fields are created by `parameter`, from which checks, units,
the schema of chain files and the axes of sweeps follow.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np

from ...collision import Array, collision_overlap, compression_time
from ...errors import InputError, InputWarning, short_repr, warn_user
from ...kernels.law_kinds import LawRow
from ...units import UNITS
from ...validation.keywords import checked_arguments
from ...validation.numbers import FRACTION, SCALED, contact_number, has_unit, number
from ...validation.objects import check_bool, check_type
from ..input_checks import checked_exponent
from ..parts import Part
from ..scales import Scale, scale

# Every law by its name in chain files.
LAWS: Final[dict[str, type[Loss]]] = {}
# Speeds after a collision, relative to those before it, that are taken to be zero.
NO_SPEED: Final = 1e-14
# Restitution above which the parameters of a law are probably in other units.
ALMOST_ONE: Final = 1.0 - 1e-5
# Units of dimensions in scaled variables, in which pressures are not defined.
SCALED_UNITS: Final[Mapping[str, str]] = MappingProxyType(
    {"time": "time", "length": "length", "damping": "force/velocity"}
)


@dataclass(frozen=True)
class Parameter:
    """A parameter of a law: its name in messages, description, dimension and range."""

    called: str
    description: str
    dimension: str = ""
    bounds: Mapping[str, float] = dataclasses.field(default_factory=dict)
    boolean: bool = False
    fraction: bool = False


def parameter(
    called: str, description: str, dimension: str = "", *, default: Any = dataclasses.MISSING,
    unit: Scale | None = None, fraction: bool = False, **bounds: float,
) -> Any:  # fmt: skip
    """Create a field of a law: a number within bounds, optional if its default is `None`."""
    about = Parameter(called, description, dimension, bounds, fraction=fraction)
    metadata: dict[str, Any] = {"parameter": about}
    unit = SCALED_UNITS.get(dimension) if unit is None else unit
    if unit is not None:
        metadata |= scale(unit)
    return dataclasses.field(default=default, metadata=metadata)


def may_pull(*, default: bool) -> Any:
    """Create the field ``attractive`` of a law whose force can become negative."""
    about = Parameter("attractive", "whether the force may pull before the overlap ends",
                      boolean=True)  # fmt: skip
    return dataclasses.field(default=default, metadata={"parameter": about})


@dataclass(frozen=True, eq=False)
class ContactArrays:
    """Properties of contacts that laws use, in arrays with one entry per contact.

    All contacts have the same exponent.  Effective radii [m] are `None` in scaled chains.  Yield
    strengths [Pa], of the softer material, are `None` without materials and infinite if unknown.
    """

    exponent: float
    stiffness: Array
    reduced_mass: Array
    radius: Array | None = None
    yield_strength: Array | None = None

    def only(self, which: Array) -> ContactArrays:
        """Select contacts by indices or by a mask."""
        arrays = {name: each[which] for name, each in vars(self).items() if np.ndim(each)}
        return dataclasses.replace(self, **arrays)


@dataclass(frozen=True, eq=False)
class ContactsAtRest(ContactArrays):
    """Contacts under a static force, with their overlaps and spring constants."""

    overlap: Array = dataclasses.field(default_factory=lambda: np.zeros(0))
    spring: Array = dataclasses.field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Loss(Part):
    """A law by which contacts lose energy; the base class of all laws.

    Attributes
    ----------
    name, words : str
        Name in chain files, and that in figures if it is another one.
    yields : bool
        Whether the law itself describes contacts beyond first yield.
    leaves_dents : bool
        Whether contacts may open at a residual overlap.
    damps : bool
        Whether a part of the force is one of damping.
    """

    name: ClassVar[str]
    yields: ClassVar[bool] = False
    leaves_dents: ClassVar[bool] = False
    words: ClassVar[str] = ""
    damps: ClassVar[bool] = False

    def __init_subclass__(cls, *, name: str, **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.name = name
        LAWS[name] = cls

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in sorted(self.parameters(), key=lambda each: each != "attractive"):
            self._check(name)

    def _repr_html_(self) -> str:
        from ...notebook.chains import loss_html

        return loss_html(self)

    def _check(self, name: str) -> None:
        """Check one field, and convert it to a plain number."""
        about, value = self.parameters()[name], getattr(self, name)
        optional = type(self).__dataclass_fields__[name].default is None
        if about.boolean:
            value = check_bool(name, value)
        elif value is not None or not optional:
            unit = self._unit(name)
            value = number(about.called, value, unit=unit, **about.bounds)  # type: ignore[arg-type]
        object.__setattr__(self, name, value)

    def _unit(self, name: str) -> str | None:
        """The unit of a field in SI chains, for `hertzchain.validation.numbers`."""
        about = self.parameters()[name]
        if about.fraction:
            return FRACTION
        return UNITS[about.dimension][0] if about.dimension else None

    @property
    def relaxation_time(self) -> float:
        """Time that must be much shorter than a contact [scaled, or s]; 0 if the law has none."""
        return 0.0

    @property
    def needs_yield_strength(self) -> bool:
        """Whether the law follows from the yield strength of the materials in contact."""
        return False

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Descriptions of the fields of the law, by name."""
        return {item.name: item.metadata["parameter"] for item in dataclasses.fields(cls)
                if "parameter" in item.metadata}  # fmt: skip

    def row(self, exponent: float) -> LawRow:
        """Kernel parameters common to all contacts of an exponent; `InputError` if unsupported."""
        raise InputError(f"the law {type(self).__name__} needs a method row: see Extending")

    def strength(self, contacts: ContactArrays) -> Array:
        """Kernel parameter of each contact: damping constant or overlap at yield; 0 if unused."""
        return np.zeros(len(contacts.stiffness))

    def resolved(self, contacts: ContactArrays) -> list[Loss]:
        """Law of each contact, with explicit values for parameters that follow from materials."""
        return [self] * len(contacts.stiffness)

    def loading_force(self, overlap: Array, contacts: ContactArrays) -> Array:
        """Forces at overlaps that are reached slowly for the first time; 0 if contacts are open."""
        return np.asarray(contacts.stiffness * np.maximum(overlap, 0.0) ** contacts.exponent)

    def loading_overlap(self, force: Array, contacts: ContactArrays) -> Array:
        """Overlaps of contacts that carry forces >= 0 for the first time."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((force / contacts.stiffness) ** (1.0 / contacts.exponent))

    def stored_energy(self, overlap: Array, force: Array, contacts: ContactArrays) -> Array:
        """Energy that contacts return when they open; the kernels have it as `potential`."""
        p = contacts.exponent
        return np.asarray(contacts.stiffness * np.maximum(overlap, 0.0) ** (p + 1.0) / (p + 1.0))

    def largest_overlap(self, energy: Array, contacts: ContactArrays) -> Array:
        """Overlaps of the largest forces that energies >= 0 can cause, after any loading."""
        p = contacts.exponent
        return np.asarray(((p + 1.0) * energy / contacts.stiffness) ** (1.0 / (p + 1.0)))

    def dent(self, largest: Array, contacts: ContactArrays) -> Array:
        """Residual overlaps at which contacts open after these largest overlaps."""
        return np.zeros(len(contacts.stiffness))

    def yield_ratio(self, largest: Array, contacts: ContactArrays) -> Array:
        """Largest pressure over the yield pressure of the law; NaN if it has none."""
        return np.full(len(contacts.stiffness), math.nan)

    def damper(self, contacts: ContactsAtRest) -> Array:
        """Damping constants for small motions; `InputError` if no motion is small enough."""
        from .small_motions import damping_constants

        row, strength = self.row(contacts.exponent), self.strength(contacts)
        return damping_constants(str(self), row, strength, contacts.overlap)

    @checked_arguments("restitution")
    def restitution(
        self, speed: float, *, chain: Any = None, contact: int = 1,
        reduced_mass: float | None = None, stiffness: float | None = None, exponent: float = 1.5,
    ) -> float:  # fmt: skip
        r"""Coefficient of restitution of a collision of two beads.

        Relative speed after over before.  Laws without a closed form integrate
        :math:`\mu d'' = -F(d, d')` from touch to the end of the contact.

        Parameters
        ----------
        speed : float
            Relative speed before the collision, > 0 [scaled, or m/s].
        chain : Chain, optional
            Chain whose beads collide; reduced mass, stiffness, exponent and, for
            ``ElasticPlastic()``, the pressure at yield are those of one of its contacts.
        contact : int
            Number of this contact: k is that of beads k and k + 1; 0 and N are those with walls.
        reduced_mass : float, optional
            :math:`\mu = m_1 m_2/(m_1 + m_2)`, the mass of the bead for a wall [scaled, or kg]; by
            default 0.5, that of equal scaled beads.
        stiffness : float, optional
            Stiffness of the contact [scaled, or N/m^p]; by default 1, that of equal scaled beads.
        exponent : float
            Exponent p of the contact force, 1 < p <= 50.

        Raises
        ------
        InputError
            For a number out of its range, for units without a chain in SI units or reduced mass and
            stiffness, or for a law whose parameters follow from materials, such as
            ``ElasticPlastic()`` without a ``yield_overlap``, without a chain.

        Warns
        -----
        InputWarning
            If the law loses almost nothing in scaled variables, because its parameters are probably
            in SI units.

        Examples
        --------
        Two steel balls of 10 mm diameter:

        >>> import hertzchain as hc
        >>> balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=2)
        >>> law = hc.Viscoelastic("0.8 us")
        >>> round(law.restitution("0.1 m/s", chain=balls), 4)
        0.9128

        In scaled variables:

        >>> hc.WaltonBraun(0.81).restitution(speed=1.0)
        0.9
        >>> round(hc.Dashpot(0.1).restitution(speed=1.0), 4)
        0.7562
        """
        if chain is not None:
            if reduced_mass is not None or stiffness is not None:
                raise InputError(
                    "give restitution a chain, or reduced_mass and stiffness, not both"
                )
            contacts, si = _contact_of(chain, contact), chain.units == "SI"
        else:
            self._check_without_chain()
            si = reduced_mass is not None and stiffness is not None
            contacts = _contact_with(reduced_mass, stiffness, exponent, si=si)
        if self.with_units and not si:
            raise InputError(
                f"the restitution of a law with units ({', '.join(sorted(self.with_units))}) "
                "depends on the bodies: give chain=..., or reduced_mass and stiffness"
            )
        before = number("speed", speed, unit="m/s" if si else SCALED, above=0.0)
        found = self.resolved(contacts)[0]._restitution(before, contacts)
        if chain is None and reduced_mass is None and stiffness is None:
            self._warn_without_loss(found)
        return found

    @classmethod
    @checked_arguments("from_restitution")
    def from_restitution(
        cls,
        coefficient: float,
        *,
        speed: float,
        chain: Any,
        contact: int = 1,
        given: Mapping[str, Any] | None = None,
    ) -> Self:
        """Law with a coefficient of restitution at one speed, such as that of a drop test.

        Parameters
        ----------
        coefficient : float
            Coefficient of restitution, between 0 and 1.
        speed : float
            Relative speed before the collision [scaled, or m/s].
        chain : Chain
            Chain whose beads collide, or a bead with a wall.
        contact : int
            Number of their contact: k is that of beads k and k + 1; 0 and N are those with walls.
        given : dict, optional
            Parameters of the law that are known, such as ``{"alpha": 1.5}`` of `VelocityPower`.

        Returns
        -------
        Loss
            In the units of the chain.

        Raises
        ------
        InputError
            If a number is out of its range, if the law has no or several unknown parameters, or if
            no value gives this restitution.

        Examples
        --------
        A ball of 10 mm that falls onto a thick steel plate:

        >>> import hertzchain as hc
        >>> ball = hc.Chain.from_materials("5 mm", "steel-52100", beads=1, right_wall=hc.Wall())
        >>> law = hc.Viscoelastic.from_restitution(0.93, speed="0.8 m/s", chain=ball)
        >>> f"{1e6 * law.time:.3f} us"
        '0.481 us'
        >>> round(law.restitution("0.8 m/s", chain=ball, contact=1), 6)
        0.93
        """
        from .given_restitution import law_with_restitution

        contacts, si = _contact_of(chain, contact), chain.units == "SI"
        others = {} if given is None else given
        check_type("given", others, Mapping, "such as {'alpha': 1.5}")
        law: Any = law_with_restitution(cls, coefficient, speed, contacts, si=si, others=others)
        return law

    def _check_without_chain(self) -> None:
        """Raise `InputError` if restitution depends on more than mass and stiffness."""

    def _warn_without_loss(self, restitution: float) -> None:
        """Warn about parameters that are hardly losses in scaled variables."""
        small = [name for name, each in self.parameters().items()
                 if each.dimension and getattr(self, name)]  # fmt: skip
        if small and restitution > ALMOST_ONE and not self.yields:
            warn_user(
                f"{self!r} loses almost nothing in scaled variables, where the reduced mass is 0.5 "
                "and the stiffness 1: for SI units, give restitution chain=..., or reduced_mass "
                "and stiffness",
                InputWarning,
            )

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        """Integrate the collision, in units of the elastic one."""
        from scipy.integrate import solve_ivp

        p, row = contacts.exponent, self.row(contacts.exponent)
        mass, k = float(contacts.reduced_mass[0]), float(contacts.stiffness[0])
        with np.errstate(all="ignore"):
            length = collision_overlap(mass, k, speed, p)
            time = float(compression_time(mass, k, speed, p) * speed / length)
            strength = self.strength(contacts)[0] * length ** (row.overlap_power + 1.0)
            damping = float(strength * np.float64(speed) ** (row.speed_power - 2.0) / mass)
        if not (0.0 < time < math.inf and damping >= 0.0):
            raise InputError(
                f"a collision with reduced mass {mass:g}, stiffness {k:g} and speed {speed:g} is "
                "outside the range of floating-point numbers; use other units"
            )
        if _stops(damping, row.speed_power):
            return 0.0

        def loss(d: float, closing: float) -> float:
            size = max(d, 0.0) ** row.overlap_power * abs(closing) ** row.speed_power
            return math.copysign(size, closing)

        def force(d: float, closing: float) -> float:
            return 0.5 * (p + 1.0) * max(d, 0.0) ** p + damping * loss(d, closing)

        def ended(_: float, y: Array) -> float:
            if y[1] >= 0.0:
                return 1.0
            return float(y[0]) if row.attractive else force(y[0], y[1])

        ended.terminal = True  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, y: (y[1], -force(y[0], y[1]), y[1] * loss(y[0], y[1])),
            (0.0, 1e6 * time), (0.0, 1.0, 0.0), method="LSODA", events=ended, rtol=1e-11,
            atol=NO_SPEED,
        )  # fmt: skip
        overlap, closing, work = map(float, found.y[:, -1])
        # A small loss is computed from the work: in the speed, it would be lost to rounding.
        lost = 2.0 * damping * work + max(overlap, 0.0) ** (p + 1.0)
        return math.sqrt(1.0 - lost) if lost < 0.5 else max(0.0, -closing)


def _contact_of(chain: Any, contact: int) -> ContactArrays:
    """Properties of one contact of a chain, from 0 (left wall) to N (right wall)."""
    groups = getattr(chain, "contact_groups", None)
    if groups is None:
        raise InputError(f"chain must be a Chain, got {short_repr(chain)}")
    k = contact_number(contact, chain.beads)
    group = next(each for each in groups if k in each.index)
    found: ContactArrays = group.contacts.only(np.flatnonzero(group.index == k))
    if not found.stiffness[0]:
        raise InputError(f"contact {k} has no restitution: this end of the chain is free")
    return found


def _contact_with(
    reduced_mass: float | None, stiffness: float | None, exponent: float, *, si: bool
) -> ContactArrays:
    """A contact with given properties; by default, that of equal scaled beads."""
    p = checked_exponent(exponent)
    for name, value in (("reduced_mass", reduced_mass), ("stiffness", stiffness)):
        if has_unit(value) and not si:
            raise InputError(
                f"{name} has a unit ({value!r}): give both reduced_mass and stiffness in SI units"
            )
    mass = number("reduced mass", 0.5 if reduced_mass is None else reduced_mass,
                  unit="kg" if si else SCALED, above=0.0)  # fmt: skip
    k = number("stiffness", 1.0 if stiffness is None else stiffness,
               unit={1.0: "N/m", 1.5: "N/m**1.5"}.get(p) if si else SCALED, above=0.0)  # fmt: skip
    return ContactArrays(p, np.array([k]), np.array([mass]))


def _stops(damping: float, speed_power: float) -> bool:
    """Whether beads that collide at speed 1 separate at less than the speed taken to be zero.

    With strong damping they stop after a small fraction of the elastic overlap, and then separate
    at a speed of at most the order of damping^(-1/(speed_power - 1)), or of damping^-2 if the power
    is less than one.
    """
    decay = 2.0 if speed_power < 1.0 else 1.0 / max(speed_power - 1.0, 1.0)
    return damping**-decay < NO_SPEED if damping > 1.0 else False
