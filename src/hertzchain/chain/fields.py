"""Fields of a chain: checked numbers and arrays, and quantities derived from them."""

from __future__ import annotations

import dataclasses
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Any, Final, Literal, Self, get_args

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import unknown_name_error
from ..frozen import Frozen, ShortClassDir, without_defaults
from ..units import unit_of_stiffness
from ..validation.keywords import checked_methods, show_fields
from ..validation.numbers import (
    SCALED,
    number,
    per_bead_array,
    plain_magnitude,
    whole_number,
)
from ..validation.objects import check_choice
from . import input_checks
from .boundary_checks import (
    HELD_BY,
    PARTS,
    HeldBy,
    check_drive,
    check_laws,
    check_part,
    check_precompression,
    warn_soft_walls,
)
from .cap import Cap, cap_of_chain, checked_cap, with_radius_of_cap
from .contact_groups import ContactGroup, group_contacts
from .drives import Drive
from .laws import Loss
from .mass_and_stiffness import contact_stiffness, sphere_masses, wall_stiffness
from .materials import Material, material_per_bead
from .per_contact import (
    ELASTIC,
    Exponent,
    Losses,
    checked_exponents,
    checked_losses,
    contact_exponents,
    contact_losses,
    given_laws,
)
from .scattered_radii import ScatteredRadii, check_scatter_of
from .static_forces import Loads, check_static_overlaps, static_forces
from .striker_properties import (
    Bodies,
    StrikerProperties,
    bodies_with,
    checked_properties,
    face_radii,
    following,
    masses_with,
    stiffness_with,
    without_given,
)
from .tapers import checked_parameters
from .walls import Wall, materials_with_walls

Units = Literal["scaled", "SI"]
UNITS: Final[tuple[Units, ...]] = get_args(Units)

# Default of a field that is computed from the others unless it is given.
FROM_OTHERS: Final[Any] = None
DERIVED: Final = ("masses", "stiffness", "velocities", "gaps")


@without_defaults
@checked_methods
@dataclass(frozen=True, eq=False)
class ChainFields(Frozen, metaclass=ShortClassDir):
    """Fields of `hertzchain.Chain`, which documents them; each is checked when it is set."""

    _omitted = (
        "contact_groups", "face_radii", "features", "given", "loads",
        "strikers_are_spheres",
    )  # fmt: skip
    radii: Array
    exponent: Exponent = HERTZ_EXPONENT
    _: KW_ONLY
    taper: str | None = None
    taper_parameters: tuple[tuple[str, float], ...] = ()
    masses: Array = FROM_OTHERS
    stiffness: Array = FROM_OTHERS
    units: Units = "scaled"
    materials: tuple[Material, ...] | None = None
    velocities: Array = FROM_OTHERS
    gaps: Array = FROM_OTHERS
    strikers: int = 0
    striker_properties: tuple[StrikerProperties, ...] = ()
    cap: Cap | None = None
    precompression: float = 0.0
    held_by: HeldBy = "walls"
    gravity: float = 0.0
    left_wall: Wall | None = None
    right_wall: Wall | None = None
    drive: Drive | None = None
    loss: Losses = None
    scatter: ScatteredRadii | None = None
    # Names of the derived fields that were given.
    given: frozenset[str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        given = frozenset(name for name in DERIVED if getattr(self, name) is not None)
        self._set("given", given)
        check_choice("units", self.units, UNITS)
        self._check_radii()
        self._set("exponent", checked_exponents(self.exponent, self.beads - 1))
        self._set("loss", checked_losses(self.loss, self.beads - 1))
        parameters = checked_parameters(self.taper, self.taper_parameters, self.radii)
        self._set("taper_parameters", parameters)
        check_scatter_of(self.scatter, self.beads)
        self._check_masses_and_stiffness()
        self._check_start()
        self._check_parts()
        check_drive(self.drive, self.left_wall)
        # Rejects a wall whose stiffness does not follow from its material and that of the bead.
        _ = self.wall_stiffness
        if not self.lossless:
            check_laws(given_laws(self.loss), self.contact_groups, scaled=self.scaled)
        check_choice("way to hold a chain", self.held_by, HELD_BY)
        check_precompression(self.loads, self.held_by)
        loaded = self.precompression > 0.0 or self.gravity != 0.0
        if loaded and (forces := static_forces(self.loads)).any():
            radii = None if self.scaled else self.radii
            check_static_overlaps(self.loads, forces, self.contact_groups, radii)

    def __getstate__(self) -> dict[str, Any]:
        """Fields without cached results, which are computed again."""
        return {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_parts(self) -> None:
        for name, *_ in PARTS:
            part, p = getattr(self, name), HERTZ_EXPONENT
            if part is None:
                continue
            if isinstance(part, Wall) and part.with_units:
                p = float(self.contact_exponents[0 if name == "left_wall" else -1])
            check_part(name, part, scaled=self.scaled, exponent=p)
        if self.units == "SI":
            walls = self.left_wall, self.right_wall
            warn_soft_walls(walls, self.contact_exponents)
            of_walls = [each.gap if each and not self.gravity else 0.0 for each in walls]
            input_checks.warn_large_gap(self.gaps, of_walls, self.radii)
            input_checks.warn_large_gravity(self.gravity)

    def _check_radii(self) -> None:
        radii = plain_magnitude("radius", self.radii, self._unit("m"))
        checked = input_checks.scaled_radii if self.scaled else input_checks.checked_radii
        self._set("radii", _read_only(checked(radii)))
        strikers = whole_number("strikers", self.strikers, least=0, most=self.beads - 1)
        self._set("strikers", strikers)
        if self.units == "scaled":
            input_checks.check_unit_of_length(float(self.radii[strikers]), strikers=strikers)
        if self.units == "SI":
            input_checks.warn_unusual_radius(self.radii)

    def _check_masses_and_stiffness(self) -> None:
        """Check masses and stiffness, or compute them from radii and materials."""
        if self.materials is not None:
            self._set("materials", material_per_bead(self.materials, self.beads))
        p = np.atleast_1d(self.exponents)
        own = checked_properties(self.striker_properties, self.strikers, scaled=self.scaled,
                                 exponent=float(p[0]), all_given=self.given)  # fmt: skip
        self._set("striker_properties", own)
        cap = checked_cap(self.cap, self.beads - self.strikers - 1, scaled=self.scaled,
                          exponent=float(p[-1]), all_given=self.given)  # fmt: skip
        self._set("cap", cap)
        if "masses" in self.given:
            masses = per_bead_array(
                "mass", self.masses, self.beads, "bead", unit=self._unit("kg"), above=0.0
            )
        else:
            spheres = sphere_masses(self.radii, self.materials, scaled=self.scaled)
            masses = input_checks.positive_derived(
                "mass", "bead", masses_with(self._bodies, spheres)
            )
        self._set("masses", masses)
        if cap is not None:
            self._set("cap", cap_of_chain(cap, float(masses[-1]), scaled=self.scaled))
            radii = with_radius_of_cap(self.radii, masses, self.materials, scaled=self.scaled)
            self._set("radii", _read_only(radii))
            # The cap is not part of a taper, and has no scatter.
            self._set("taper", None)
            self._set("taper_parameters", ())
            if self.scatter is not None:
                nominal = np.append(self.scatter.radii[:-1], radii[-1])
                self._set("scatter", self.scatter.with_radii(nominal))
        if "stiffness" in self.given:
            unit = self._unit(self._stiffness_unit)
            stiffness = per_bead_array(
                "stiffness", self.stiffness, self.beads - 1, "contact", unit=unit, above=0.0
            )
        else:
            of_spheres = without_given(self._bodies, p, self.beads - 1)
            values = contact_stiffness(self.radii, self.materials, of_spheres, scaled=self.scaled)
            values = stiffness_with(self._bodies, values, self.radii, self.materials, p,
                                    scaled=self.scaled)  # fmt: skip
            stiffness = input_checks.positive_derived("stiffness", "contact", values)
        self._set("stiffness", stiffness)

    def _check_start(self) -> None:
        """Check velocities, gaps, gravity and precompression."""
        force = number("precompression", self.precompression, unit=self._unit("N"), least=0.0,
                       hint="contacts carry no tension")  # fmt: skip
        self._set("precompression", force)
        if "velocities" in self.given:
            values = per_bead_array(
                "velocity", self.velocities, self.beads, "bead", unit=self._unit("m/s")
            )
            input_checks.check_velocities(values)
        else:
            values = np.zeros(self.beads)
            values[: 0 if self._at_rest_by_default else max(1, self.strikers)] = 1.0
        self._set("velocities", _read_only(values))
        gaps, unit = np.zeros(self.beads - 1), self._unit("m")
        if "gaps" in self.given:
            gaps = input_checks.checked_gaps(self.gaps, len(gaps), unit, self.strikers, self.cap)
        self._set("gaps", _read_only(gaps))
        gravity = number("gravity", self.gravity, unit=self._unit("m/s**2"))
        self._set("gravity", gravity)

    @property
    def _stiffness_unit(self) -> str:
        p = self.exponents
        return unit_of_stiffness(p) if isinstance(p, float) else ""

    def _unit(self, unit: str) -> str:
        """Unit in which this chain stores a quantity, for `hertzchain.validation.numbers`."""
        return SCALED if self.scaled else unit

    def replace(self, **changes: Any) -> Self:
        """Return a chain with some fields changed and all derived fields recomputed.

        Parameters
        ----------
        **changes
            Fields of `Chain` and their new values.

        Raises
        ------
        InputError
            If a field does not exist, is out of range or contradicts another one.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.uniform(20).replace(right_wall=hc.Wall.rigid())
        Chain(uniform, 20 beads, rigid right wall)
        """
        fields = [item.name for item in dataclasses.fields(self) if item.init]
        for name in changes:
            if name not in fields:
                raise unknown_name_error("field of a chain", name, fields)
        kept = {
            name: getattr(self, name)
            for name in fields
            if name not in DERIVED or name in self.given
        }
        if "radii" in changes:
            kept |= {"taper": None, "taper_parameters": (), "scatter": None}
        return type(self)(**(kept | changes))

    @property
    def beads(self) -> int:
        """Number of beads N."""
        return len(self.radii)

    @property
    def scaled(self) -> bool:
        """Whether the chain is in the scaled variables of the paper."""
        return self.units == "scaled"

    @property
    def rate(self) -> float | None:
        """Rate of the taper: S if it is linear, q if it is exponential; None without a rate."""
        return dict(self.taper_parameters).get("rate")

    def _follows(self, name: Literal["masses", "stiffness"]) -> Array:
        """Whether the mass of each bead, or the stiffness of each contact, follows from radii."""
        count, given = len(getattr(self, name)), name in self.given
        return following(self._bodies, name, count, all_given=given)

    @property
    def strikers_are_spheres(self) -> bool:
        """Whether the masses of all strikers follow from their radii."""
        return bool(self._follows("masses")[: self.strikers].all())

    @property
    def face_radii(self) -> Array:
        """Radii of curvature at the contacts, shape (N,): infinite for flat strikers and caps."""
        return face_radii(self._bodies, self.radii)

    @property
    def _bodies(self) -> Bodies:
        return bodies_with(self.striker_properties, self.cap, self.beads)

    @property
    def _balls(self) -> slice:
        """Beads between the strikers and the cap."""
        return slice(self.strikers, self.beads - (self.cap is not None))

    @cached_property
    def wall_stiffness(self) -> tuple[float, float]:
        r"""Stiffness of the contacts with the left and right wall [scaled, or N/m^p]; 0 if free.

        In scaled variables it is :math:`\sqrt{2R}` for a flat wall of the bead's own material and
        twice as much for a rigid wall.
        """
        left, right = (
            0.0
            if wall is None
            else wall_stiffness(
                wall,
                float(self.face_radii[bead]),
                None if self.materials is None else self.materials[bead],
                scaled=self.scaled,
                given="stiffness" in self.given,
                exponent=float(self.contact_exponents[bead]),
            )
            for wall, bead in ((self.left_wall, 0), (self.right_wall, -1))
        )
        return left, right

    @cached_property
    def contact_stiffness(self) -> Array:
        """Stiffness of all contacts, walls included, shape (N + 1,); 0 at a free end."""
        left, right = self.wall_stiffness
        return _read_only(np.concatenate(([left], self.stiffness, [right])))

    @property
    def exponents(self) -> Exponent:
        """Exponents p of the contacts of two beads: one number if all are equal, else (N - 1,)."""
        if isinstance(self.exponent, float):
            return self.exponent
        inner = self.contact_exponents[1 : max(self.beads, 2)]
        return float(inner[0]) if np.all(inner == inner[0]) else inner

    @cached_property
    def contact_exponents(self) -> Array:
        """Exponents p of all contacts, walls included, shape (N + 1,)."""
        walls = self.left_wall, self.right_wall
        return _read_only(contact_exponents(self.exponent, self.materials, walls, self.beads))

    @cached_property
    def contact_losses(self) -> tuple[Loss, ...]:
        """Laws of all contacts, walls included, length N + 1; `Elastic()` without a loss."""
        walls = self.left_wall, self.right_wall
        return contact_losses(self.loss, self.materials, walls, self.contact_exponents)

    @cached_property
    def contact_groups(self) -> tuple[ContactGroup, ...]:
        """All contacts, walls included, by law and exponent."""
        kinds = None
        if self.materials is not None and not self.scaled:
            kinds = materials_with_walls(self.materials, (self.left_wall, self.right_wall))
        radii = None if self.scaled else self.face_radii
        return group_contacts(
            self.contact_losses, self.contact_exponents, self.contact_stiffness, self.masses,
            radii, kinds,
        )  # fmt: skip

    @property
    def _damped(self) -> bool:
        """Whether forces between beads have a part of damping."""
        return any(law.damps for law in self.contact_losses[1:-1])

    @property
    def lossless(self) -> bool:
        """Whether no contact has a loss."""
        walls = self.left_wall, self.right_wall
        if self.loss is None and all(wall is None or wall.loss is None for wall in walls):
            return True
        return all(each == ELASTIC for each in self.contact_losses)

    @property
    def loads(self) -> Loads:
        """Quantities that determine the static contact forces."""
        walls = self.left_wall, self.right_wall
        return Loads(
            self.masses, self.gaps, self.strikers, self.precompression, self.gravity, walls
        )

    @property
    def centre_distances(self) -> Array:
        """Distances between the centres of neighbours at time 0, shape (N - 1,) [R_1, or m].

        In SI units they include the gaps.  Scaled gaps are in units of the overlaps, which are
        negligible compared with a radius.
        """
        touching = self.radii[:-1] + self.radii[1:]
        return touching + self.gaps if not self.scaled else touching

    @cached_property
    def features(self) -> tuple[str, ...]:
        """Names of features that the paper's chains do not have, such as ``"gaps"``."""
        losses: set[Loss] = {ELASTIC}
        p = self.contact_exponents
        if not self.lossless:
            losses = {*{id(law): law for law in self.contact_losses}.values()}
        present = {
            "SI units": not self.scaled,
            "masses": "masses" in self.given,
            "stiffness": "stiffness" in self.given,
            "strikers": self.strikers > 0,
            "cap": self.cap is not None,
            "velocities": "velocities" in self.given and not self._only_first_moves,
            "gaps": "gaps" in self.given and bool(self.gaps.any()),
            "precompression": self.precompression > 0.0,
            "gravity": self.gravity != 0.0,
            "left wall": self.left_wall is not None,
            "right wall": self.right_wall is not None,
            "drive": self.drive is not None,
            "loss": len(losses) == 1 and losses != {ELASTIC},
            "mixed exponents": bool(p.min() < p.max()),
            "mixed losses": len(losses) > 1,
        }
        return tuple(name for name, there in present.items() if there)

    @property
    def _at_rest_by_default(self) -> bool:
        """With a drive, or with precompression in SI units, which no impact suits by default."""
        held = not self.scaled and self.precompression > 0.0 and self.strikers == 0
        return held or self.drive is not None

    @property
    def _only_first_moves(self) -> bool:
        """Whether only bead 1 moves: with velocity 1 if scaled, forwards at any speed in SI."""
        first = float(self.velocities[0])
        expected = first == 1.0 if self.scaled else first >= 0.0
        return expected and not self.velocities[1:].any()


def _read_only(values: Array) -> Array:
    values.setflags(write=False)
    return values


show_fields(ChainFields, "replace")
