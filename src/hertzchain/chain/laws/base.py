r"""What all laws of loss have in common: parameters, elastic curve, stored energy.

A law is one small frozen dataclass derived from `Loss`, in a file of this package.  Its class
statement names it for chain files; its fields are made by `parameter`, from which checks, units,
the schema of chain files and the axes of sweeps follow.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Final

import numpy as np

from ...collision import Array, collision_overlap, compression_time
from ...kernels.law_kinds import LawRow
from ...units import UNITS
from ...validation.numbers import number
from ...validation.objects import check_bool
from ..parts import Part
from ..scales import Scale, scale

# Every law by its name in chain files.
LAWS: Final[dict[str, type[Loss]]] = {}
# Units of dimensions in scaled variables; a pressure has none.
SCALED_UNITS: Final[Mapping[str, str]] = MappingProxyType(
    {"time": "time", "length": "length", "damping": "force/velocity"}
)


@dataclass(frozen=True)
class Parameter:
    """A number or truth value of a law: its name in messages, description, unit and range."""

    called: str
    description: str
    dimension: str = ""
    bounds: Mapping[str, float] = dataclasses.field(default_factory=dict)
    boolean: bool = False


def parameter(
    called: str, description: str, dimension: str = "", *, default: Any = dataclasses.MISSING,
    unit: Scale | None = None, **bounds: float,
) -> Any:  # fmt: skip
    """A field of a law that is a number within bounds; a default of `None` makes it optional."""
    metadata: dict[str, Any] = {"parameter": Parameter(called, description, dimension, bounds)}
    unit = SCALED_UNITS.get(dimension) if unit is None else unit
    if unit is not None:
        metadata |= scale(unit)
    return dataclasses.field(default=default, metadata=metadata)


def may_pull(*, default: bool) -> Any:
    """The field ``attractive`` of a law whose force can become negative."""
    about = Parameter(
        "attractive", "whether the force may pull before the overlap ends", boolean=True
    )
    return dataclasses.field(default=default, metadata={"parameter": about})


@dataclass(frozen=True, eq=False)
class ContactArrays:
    """What a law needs to know of its contacts; each array has one number per contact.

    The contacts have one exponent.  Effective radii [m] are `None` in scaled chains.  Yield
    strengths [Pa], of the softer material, are `None` without materials and infinite if unknown.
    """

    exponent: float
    stiffness: Array
    reduced_mass: Array
    radius: Array | None = None
    yield_strength: Array | None = None

    def only(self, which: Array) -> ContactArrays:
        """Some of the contacts.

        Parameters
        ----------
        which : ndarray
            Their indices, or a mask.

        Returns
        -------
        ContactArrays

        Examples
        --------
        >>> ContactArrays(1.5, np.array([1.0, 2.0]), np.ones(2)).only(np.array([1])).stiffness
        array([2.])
        """
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
    name : str
        Name in chain files.
    yields : bool
        Whether the law itself describes contacts beyond first yield.
    """

    name: ClassVar[str]
    yields: ClassVar[bool] = False

    def __init_subclass__(cls, *, name: str, **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.name = name
        LAWS[name] = cls

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in sorted(self.parameters(), key=lambda each: each != "attractive"):
            self._check(name)

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
        dimension = self.parameters()[name].dimension
        return UNITS[dimension][0] if dimension else None

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """What the fields of the law are, by name.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Dashpot.parameters()["gamma"].dimension
        'damping'
        """
        return {
            item.name: item.metadata["parameter"]
            for item in dataclasses.fields(cls)
            if "parameter" in item.metadata
        }

    def row(self, exponent: float) -> LawRow:
        """The kernel's numbers that are the same for all contacts of one exponent.

        Parameters
        ----------
        exponent : float
            Exponent p of the contact force.

        Returns
        -------
        LawRow

        Raises
        ------
        InputError
            If the law is not defined for this exponent.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Viscoelastic(0.1).row(1.5).overlap_power
        0.5
        """
        raise NotImplementedError

    def strength(self, contacts: ContactArrays) -> Array:
        """The kernel's number of each contact: its damping, or its overlap at yield.

        Parameters
        ----------
        contacts : ContactArrays
            The contacts.

        Returns
        -------
        ndarray
            0 for a law without such a number.

        Examples
        --------
        >>> import hertzchain as hc
        >>> contacts = hc.Chain.uniform(3).contact_groups[0].contacts
        >>> hc.Dashpot(2.0).strength(contacts)
        array([2., 2., 2., 2.])
        """
        return np.zeros(len(contacts.stiffness))

    def resolved(self, contacts: ContactArrays) -> list[Loss]:
        """The law of each contact, with numbers in place of what follows from materials.

        Parameters
        ----------
        contacts : ContactArrays
            The contacts.

        Returns
        -------
        list of Loss

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-316", beads=2, loss=hc.ElasticPlastic())
        >>> law = chain.contact_losses[1].resolved(chain.contact_groups[0].contacts)[1]
        >>> round(1e9 * law.yield_overlap, 2)
        59.01
        """
        return [self] * len(contacts.stiffness)

    def loading_force(self, overlap: Array, contacts: ContactArrays) -> Array:
        r"""Force of contacts that are loaded slowly for the first time, :math:`k\,d^{\,p}`.

        Parameters
        ----------
        overlap : ndarray
            Overlaps d; the force of a negative one is 0 [scaled, or m].
        contacts : ContactArrays
            The contacts.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> contacts = hc.Chain.uniform(2).contact_groups[0].contacts.only(np.array([1]))
        >>> hc.ElasticPlastic(yield_overlap=1.0).loading_force(np.array([4.0]), contacts)
        array([5.5])
        """
        return np.asarray(contacts.stiffness * np.maximum(overlap, 0.0) ** contacts.exponent)

    def loading_overlap(self, force: Array, contacts: ContactArrays) -> Array:
        r"""Overlap of contacts that carry a force for the first time, :math:`(F/k)^{1/p}`.

        Parameters
        ----------
        force : ndarray
            Forces F >= 0 [scaled, or N].
        contacts : ContactArrays
            The contacts.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> contacts = hc.Chain.uniform(2).contact_groups[0].contacts.only(np.array([1]))
        >>> hc.Elastic().loading_overlap(np.array([8.0]), contacts)
        array([4.])
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((force / contacts.stiffness) ** (1.0 / contacts.exponent))

    def stored_energy(self, overlap: Array, force: Array, contacts: ContactArrays) -> Array:
        r"""Energy that contacts give back, :math:`k\,d^{\,p+1}/(p+1)` if they are elastic.

        The same as `hertzchain.kernels.contact_law.potential`, for saved states, which have
        overlaps and forces.

        Parameters
        ----------
        overlap : ndarray
            Overlaps d [scaled, or m].
        force : ndarray
            Forces, which plastic laws use [scaled, or N].
        contacts : ContactArrays
            The contacts, along the last axis.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> contacts = hc.Chain.uniform(2).contact_groups[0].contacts.only(np.array([1]))
        >>> hc.WaltonBraun(0.5).stored_energy(np.array([4.0]), np.array([8.0]), contacts)
        array([6.4])
        """
        p = contacts.exponent
        return np.asarray(contacts.stiffness * np.maximum(overlap, 0.0) ** (p + 1.0) / (p + 1.0))

    def largest_overlap(self, energy: Array, contacts: ContactArrays) -> Array:
        """Overlap of the largest force that an energy can make, after any loading.

        Parameters
        ----------
        energy : ndarray
            Energies >= 0 [scaled, or J].
        contacts : ContactArrays
            The contacts.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> contacts = hc.Chain.uniform(2).contact_groups[0].contacts.only(np.array([1]))
        >>> hc.WaltonBraun(0.5).largest_overlap(np.array([6.4]), contacts)
        array([4.])
        """
        p = contacts.exponent
        return np.asarray(((p + 1.0) * energy / contacts.stiffness) ** (1.0 / (p + 1.0)))

    def damper(self, contacts: ContactsAtRest) -> Array:
        """Damping constants for small motions about a static state.

        Parameters
        ----------
        contacts : ContactsAtRest
            The contacts.

        Returns
        -------
        ndarray
            0 without damping.

        Raises
        ------
        InputError
            If no motion is small enough to be linear.

        Examples
        --------
        >>> import hertzchain as hc
        >>> one = np.ones(1)
        >>> at_rest = ContactsAtRest(1.5, one, one, overlap=one, spring=1.5 * one)
        >>> hc.Viscoelastic(2.0).damper(at_rest)
        array([3.])
        """
        return np.zeros(len(contacts.spring))

    def restitution(
        self, speed: float, *, reduced_mass: float = 0.5, stiffness: float = 1.0,
        exponent: float = 1.5,
    ) -> float:  # fmt: skip
        r"""Coefficient of restitution of a collision of two beads.

        Relative speed after over before.  Laws without a closed form integrate
        :math:`\mu d'' = -F(d, d')` from touch to the end of the contact.

        Parameters
        ----------
        speed : float
            Relative speed before the collision, > 0 [scaled, or m/s].
        reduced_mass : float
            :math:`\mu = m_1 m_2/(m_1 + m_2)` [scaled, or kg].
        stiffness : float
            Stiffness of the contact [scaled, or N/m^p].
        exponent : float
            Exponent p of the contact force.

        Returns
        -------
        float

        Raises
        ------
        InputError
            For a number out of its range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.WaltonBraun(0.81).restitution(speed=1.0)
        0.9
        >>> round(hc.Dashpot(0.1).restitution(speed=1.0), 4)
        0.7562
        """
        contacts = ContactArrays(
            number("exponent of the contact force", exponent, above=1.0),
            np.array([number("stiffness", stiffness, above=0.0)]),
            np.array([number("reduced mass", reduced_mass, above=0.0)]),
        )
        return self._restitution(number("speed", speed, above=0.0), contacts)

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        """From the integrated collision, in units of the elastic one."""
        from scipy.integrate import solve_ivp

        p, row = contacts.exponent, self.row(contacts.exponent)
        mass, k = float(contacts.reduced_mass[0]), float(contacts.stiffness[0])
        length = float(collision_overlap(mass, k, speed, p))
        time = float(compression_time(mass, k, speed, p)) * speed / length
        damping = float(self.strength(contacts)[0]) * length ** (row.overlap_power + 1.0)
        damping *= speed ** (row.speed_power - 2.0) / mass

        def force(d: float, closing: float) -> float:
            d = max(d, 0.0)
            loss = d**row.overlap_power * abs(closing) ** row.speed_power
            return 0.5 * (p + 1.0) * d**p + damping * math.copysign(loss, closing)

        def ended(_: float, y: Array) -> float:
            if y[1] >= 0.0:
                return 1.0
            return float(y[0]) if row.attractive else force(y[0], y[1])

        ended.terminal = True  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, y: (y[1], -force(y[0], y[1])), (0.0, 1e6 * time), (0.0, 1.0),
            method="LSODA", events=ended, rtol=1e-11, atol=1e-14,
        )  # fmt: skip
        return max(0.0, -float(found.y[1, -1]))
