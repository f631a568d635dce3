r"""Compare a chain in SI units with the limits of Hertz's law.

Hertz's law assumes that contacts are small compared with the beads, elastic, and slow
compared with sound.  Each assumption corresponds to a ratio with an upper limit:

=====================  ==============================================  ========
ratio                  definition                                      limit
=====================  ==============================================  ========
overlap / radius       :math:`d/R = (a/R)^2`, a the contact radius     0.01 or 0.1
pressure / yield       :math:`p_0/(1.60\,Y)`, first yield below the    1
                       surface (von Mises, nu = 0.3)
speed / sound          closing speed over :math:`\sqrt{E/\rho}`        0.01
=====================  ==============================================  ========

The limit 0.1 is that of contacts whose law describes yield, beyond which their forces are not a
prediction.  Overlap, contact radius and pressure are those of spheres of the materials under the
force of the contact:

.. math::

    a^3 = \frac{3 F R}{4 E^*}, \qquad d = \frac{a^2}{R}, \qquad
    p_0 = \left(\frac{6 F E^{*2}}{\pi^3 R^2}\right)^{1/3} .

This overlap is that of the simulation if the stiffness of the contact follows from the materials.
A given stiffness or exponent only changes the force; contacts with exponent 1 are springs, pads or
plates, and are not checked.  If the contact is softer than that of the
materials, because a spring or a load cell gives way behind it, :math:`p_0` is exact; if its surface
is softer, :math:`p_0` is an upper limit.

K. L. Johnson, *Contact Mechanics*, Secs. 4.2, 6.1 and 11.4, doi:10.1017/CBO9781139171731.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..collision import Array
from ..errors import InputError
from ..representation import counted, short
from ..validation.keywords import checked_arguments, checked_methods
from .chain import Chain
from .contact_groups import law_yield_ratios
from .feature_support import require_chain
from .hertz_ratios import (
    MAX_OVERLAP_RATIO,
    MAX_SPEED_RATIO,
    NO_PREDICTION,
    OTHER_MATERIAL,
    causes_of,
    contact_ratios,
    given_contacts,
    impact_speed,
    law_of_limit,
    losses_without_yield,
    may_yield,
    overlap_limits,
    soft_contacts,
    speed_ratio,
    with_walls,
    yielding_materials,
)
from .impact_overlaps import impact_overlaps
from .laws.elastic_plastic import restitution_beyond_yield
from .per_contact import contact_name, contacts_in_words

# Pressure over that at first yield up to which yield is a small excess.
SMALL_EXCESS: Final = 1.1
# Factor of the velocity beyond that of first yield from which a reduction does not help.
FAR_AWAY: Final = 3.0
UNKNOWN_YIELD: Final = "no elastic contact has a known yield strength"
ALL_YIELD: Final = "all contacts between beads may yield, which limits their pressure; keep dent"
# Shown with ratios of collisions that were not simulated.
ESTIMATED: Final = (
    "estimated before a run (to about 10% in smooth chains only);\n"
    "of a run: hertz_range(run.chain, run.largest_overlaps)"
)

if TYPE_CHECKING:
    import pandas as pd


@checked_methods
@dataclass(frozen=True, eq=False)
class HertzRange:
    """Ratios that show how far contacts are from the limits of Hertz's law.

    The ratios include the static force of precompression and gravity.  Contact numbers include
    the walls, from 0 (left wall) to N (right wall).

    Attributes
    ----------
    overlap_ratio : ndarray, shape (N + 1,)
        Overlap of two spheres of the materials under the force of the contact, divided by the
        effective radius; NaN at linear springs (exponent 1), which are not checked.
    overlap_limit : ndarray, shape (N + 1,)
        Limit of this ratio: 0.01, or 0.1 if the law of the contact describes yield.
    yield_ratio : ndarray, shape (N + 1,)
        Largest pressure over the pressure at first yield; NaN if no yield strength of the two
        materials is known, at linear springs, or if the law of the contact describes yield itself.
    law_yield_ratio : ndarray, shape (N + 1,)
        Largest pressure over the yield pressure of the law, of contacts whose law describes yield
        itself: at most 1, the value at which the contact yields; NaN at other contacts.
    speed_ratio : float
        Largest ratio of the closing speed of two neighbours at time 0 to the slower of their
        sound speeds.
    static_overlap_ratio, static_yield_ratio : ndarray, shape (N + 1,)
        The first two ratios under the static force alone.
    causes : tuple of two str
        Causes of the motion and of the static force, as `violations` name them.
    given : ndarray of bool, shape (N + 1,)
        Whether the exponent of a contact is not 3/2, or its stiffness differs by more than a factor
        of 2 from that of spheres of its materials.
    soft : ndarray of bool, shape (N + 1,)
        Whether the body of the contact that yields first has a Young's modulus below 10 GPa, as
        polymers have.
    yielding : tuple of str
        If a contact yields, the material that yields first at each contact of two materials, and
        an empty text at the others.
    may_yield : ndarray of bool, shape (N + 1,)
        Whether the contact yields if the chain has the loss `ElasticPlastic`.
    losses : tuple of str
        Names of the losses that a law with yield would replace.
    speed : float
        Velocity of the impact [m/s], if all overlaps are about proportional to its power 4/5, as in
        rows of balls without gaps, drives, static forces and losses with a scale of time or speed;
        otherwise 0.
    estimated : bool
        Whether the ratios follow from separate collisions before a run.  Pressures of a simulation
        differ by up to about 10% in smooth chains, and by much more in others.

    Examples
    --------
    >>> import hertzchain as hc
    >>> print(hc.hertz_range(hc.Chain.from_materials(5e-3, "steel-52100", beads=20)))
    overlap / radius  0.0041 at contact 1 (limit 0.01)
    pressure / yield  1.4 at contact 1 (limit 1)
    speed / sound  0.0002 (limit 0.01)
    estimated before a run (to about 10% in smooth chains only);
    of a run: hertz_range(run.chain, run.largest_overlaps)
    """

    overlap_ratio: Array
    yield_ratio: Array
    speed_ratio: float

    static_overlap_ratio: Array
    static_yield_ratio: Array
    causes: tuple[str, str]
    given: NDArray[np.bool_]
    soft: NDArray[np.bool_]
    yielding: tuple[str, ...]
    may_yield: NDArray[np.bool_]
    losses: tuple[str, ...]
    law_yield_ratio: Array
    overlap_limit: Array
    speed: float = 0.0
    estimated: bool = False
    # Further advice that the law with yield requires, such as "remove ... and ".
    _change: str = field(default="", repr=False)

    @property
    def largest_yield_ratio(self) -> float:
        """Largest known ``yield_ratio``; NaN if none is known."""
        return float(self.yield_ratio[self._most_loaded])

    @property
    def _most_loaded(self) -> int:
        """Contact with the largest known ``yield_ratio``."""
        return int(np.argmax(np.nan_to_num(self.yield_ratio, nan=-1.0)))

    @property
    def _most_squeezed(self) -> int:
        """Contact whose overlap is closest to its limit, or beyond it by the largest factor."""
        return int(np.argmax(np.nan_to_num(self.overlap_ratio / self.overlap_limit)))

    @property
    def _remark(self) -> str:
        """A sentence on contacts that yield, beyond the limit of Hertz's law but not of theirs."""
        at = self._most_squeezed
        ratio, limit = self.overlap_ratio[at], self.overlap_limit[at]
        if not MAX_OVERLAP_RATIO < ratio <= limit:
            return ""
        return (
            f"overlap / radius is {ratio:.2g} at {_place(at, self)} (limit of "
            f"{law_of_limit(limit)}: {limit:g}); above {MAX_OVERLAP_RATIO:g}, "
            "Hertz's law is less accurate"
        )

    @property
    def violations(self) -> tuple[str, ...]:
        """One sentence for each limit that is exceeded; yield comes first."""
        return self._violations()

    def _violations(self, use: str = "use loss=") -> tuple[str, ...]:
        """The same, with other words to use a law with yield; without advice on one if empty."""
        found = []
        at = self._most_loaded
        if (ratio := self.yield_ratio[at]) > 1.0:
            others = int(np.count_nonzero(self.yield_ratio > 1.0)) - 1
            exceed = "contact exceeds" if others == 1 else "contacts exceed"
            besides = f", and {others} more {exceed} it" if others else ""
            digits = 3 if ratio > 1.05 else 5
            cautious = ", cautious for polymers" if self.soft[at] else ""
            found.append(
                f"pressure / yield is {ratio:.{digits}g} at {_place(at, self)}{self._yields(at)} "
                f"(limit of Hertz's law: 1{cautious}){self._basis(at)}{besides}; "
                f"{self._excess(ratio)}{self._against_yield(at, digits, use)}"
            )
        at = self._most_squeezed
        if (ratio := self.overlap_ratio[at]) > (limit := self.overlap_limit[at]):
            far = f"; beyond {NO_PREDICTION:g}, forces are not a prediction"
            advice = self._advice(ratio, self.static_overlap_ratio, limit, 2)
            digits = 2 if ratio > 1.05 * limit else 4
            found.append(
                f"overlap / radius is {ratio:.{digits}g} at {_place(at, self)} "
                f"(limit of {law_of_limit(limit)}: {limit:g}){self._basis(at)}"
                f"{far if ratio > NO_PREDICTION else ''}; {advice}"
                f"{self._slower((ratio / limit) ** -1.25)}"
            )
        if self.speed_ratio > MAX_SPEED_RATIO:
            found.append(
                f"speed / sound is {self.speed_ratio:.2g} (limit of Hertz's law: "
                f"{MAX_SPEED_RATIO:g}); reduce the velocity"
                f"{self._slower(MAX_SPEED_RATIO / self.speed_ratio)}"
            )
        return tuple(found)

    @property
    def _pressure_line(self) -> str:
        """The largest pressure and its limit, if it is known."""
        at = self._most_loaded
        if not (ratio := self.yield_ratio[at]) > 0.0:
            return ""
        digits = 4 if 0.95 <= ratio < 1.05 else 2
        exceeded = ", exceeded" * bool(ratio > 1.0)
        return (f"pressure / yield {ratio:.{digits}g} at {_place(at, self)} "
                f"(limit of Hertz's law: 1{exceeded})")  # fmt: skip

    def _yields(self, contact: int) -> str:
        """The material that yields at a contact of two materials."""
        name = self.yielding[contact]
        return f" in {name}" if name else ""

    def _excess(self, ratio: float) -> str:
        """How little the contact yields, if the pressure exceeds its limit only slightly."""
        if ratio > SMALL_EXCESS or np.nan_to_num(self.static_yield_ratio).any():
            return ""
        # The pressure is proportional to the speed to the power 2/5.
        lost = 1.0 - restitution_beyond_yield(ratio**-2.5)
        return f"the excess is small (yield alone would cost {100.0 * lost:.1g}% of the velocity); "

    def _against_yield(self, contact: int, digits: int, use: str) -> str:
        """Advice to reduce the motion or use a law with yield; far beyond yield, only the law."""
        ratio, static = self.yield_ratio[contact], self.static_yield_ratio
        law = self._law_with_yield(contact, use) if use else ""
        if law and np.nan_to_num(self.overlap_ratio).max() > NO_PREDICTION:
            return f"{self._advice(ratio, static, 1.0, digits)}{OTHER_MATERIAL}"
        if law and self.speed and ratio**-2.5 * FAR_AWAY < 1.0:
            return law.removeprefix(" or ")
        return f"{self._advice(ratio, static, 1.0, digits)}{self._slower(ratio**-2.5)}{law}"

    def _law_with_yield(self, contact: int, use: str) -> str:
        """Advice to use a law with yield, if it applies to the chain and changes this contact."""
        if not self.may_yield[contact]:
            return ""
        argument = "yield_overlap=..." if self.given[contact] else ""
        law = f" or {self._change}{use}ElasticPlastic({argument})"
        return f"{law}{self._replaced}"

    @property
    def _replaced(self) -> str:
        several, names = "es" * (len(self.losses) > 1), ", ".join(self.losses)
        return f", which replaces the loss{several} of the chain ({names})" * bool(names)

    def _slower(self, factor: float) -> str:
        """Velocity of the impact at which all limits hold, if it is known; rounded down.

        ``factor`` is that of one limit.
        """
        # Pressures are proportional to the velocity to the power 2/5, overlaps to its power 4/5.
        yields = np.nan_to_num(self.yield_ratio).max()
        overlap = np.nan_to_num(self.overlap_ratio / self.overlap_limit).max()
        closing = self.speed_ratio / MAX_SPEED_RATIO
        least = 1.0 / max(yields**2.5, overlap**1.25, closing, 1.0)
        if not (speed := least * self.speed):
            return ""
        step = 10.0 ** (math.floor(math.log10(speed)) - 1)
        others = " (all limits)" if least < 0.95 * factor else ""
        return f" to about {math.floor(speed / step) * step:.2g} m/s{others}"

    def _basis(self, contact: int) -> str:
        """Basis of the ratios of a contact whose stiffness is not that of its materials."""
        return " for spheres of these materials under its force" if self.given[contact] else ""

    def _advice(self, ratio: float, static: Array, limit: float, digits: int) -> str:
        """Advice to reduce the motion, or the static force if it exceeds the limit by itself."""
        motion, load = self.causes
        alone = float(np.nan_to_num(static).max())
        if alone <= limit:
            return f"reduce {motion}"
        # The motion matters if it adds more than is printed.
        also = f" and {motion}" if f"{ratio:.2g}" != f"{alone:.2g}" else ""
        # The weight is that of the beads.
        by_weight = "use fewer beads" + (f" and reduce {motion}" if also else "")
        advice = by_weight if load == "gravity" else f"reduce {load}{also}"
        return f"the static force alone gives {alone:.{digits}g}; {advice}"

    def _pressure(self, limit: str = "") -> str:
        """The largest pressure over yield and its contact, with a limit of elastic contacts."""
        yielded = np.flatnonzero(self.law_yield_ratio >= 1.0)
        both = self.yield_ratio if len(yielded) else np.fmax(self.yield_ratio, self.law_yield_ratio)
        texts = []
        if not np.isnan(both).all():
            at = int(np.nanargmax(both))
            texts.append(f"{both[at]:.3g} at contact {at}{limit}")
        if len(yielded):
            beads = len(self.overlap_ratio) - 1
            by_law = "which yields by its law" if len(yielded) == 1 else "which yield by their law"
            texts.append(f"1 at {contacts_in_words(yielded, beads)}, {by_law}")
        return "; ".join(texts) or f"unknown ({UNKNOWN_YIELD})"

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per contact, walls included.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``contact``; the ratios and limits of the attributes, which have no unit.
            Those of a free end, and those that are not known, are missing.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
        >>> hc.hertz_range(chain).to_dataframe().yield_ratio.loc[1:3].round(2).tolist()
        [1.4, 1.4, 1.4]
        """
        import pandas as pd

        names = ("overlap_ratio", "overlap_limit", "yield_ratio", "law_yield_ratio",
                 "static_overlap_ratio", "static_yield_ratio")  # fmt: skip
        contacts = pd.RangeIndex(len(self.overlap_ratio), name="contact")
        return pd.DataFrame({name: getattr(self, name) for name in names}, index=contacts)

    def __repr__(self) -> str:
        overlap = self._most_squeezed
        count = len(self.violations)
        exceeded = f"; {counted(count, 'limit')} exceeded" if count else ""
        return short(
            "HertzRange",
            f"{len(self.overlap_ratio)} contacts",
            f"overlap / radius {self.overlap_ratio[overlap]:.2g} at contact {overlap}, pressure / "
            f"yield {self._pressure()}, speed / sound "
            f"{self.speed_ratio:.2g}{exceeded}{', estimated before a run' * self.estimated}",
        )

    def _repr_html_(self) -> str:
        from ..notebook.chains import hertz_range_html

        return hertz_range_html(self)

    def __str__(self) -> str:
        overlap = self._most_squeezed
        return "\n".join(
            (
                f"overlap / radius  {self.overlap_ratio[overlap]:.2g} at contact {overlap} "
                f"(limit {self.overlap_limit[overlap]:g})",
                f"pressure / yield  {self._pressure(' (limit 1)')}",
                f"speed / sound  {self.speed_ratio:.2g} (limit {MAX_SPEED_RATIO:g})",
                *([ESTIMATED] if self.estimated else []),
            )
        )


@checked_arguments("hertz_range")
def hertz_range(chain: Chain, overlaps: ArrayLike | None = None) -> HertzRange:
    """Compare a chain with the limits of Hertz's law.

    Parameters
    ----------
    chain : Chain
        A chain in SI units with materials.
    overlaps : array_like, optional
        Largest overlap of each contact in a simulation [m], of length N - 1, or N + 1 with the
        walls, such as ``run.largest_overlaps``.  By default, the motion towards the right end is
        treated as a sequence of isolated lossless collisions of two beads, and of the last bead
        with a wall, under the static force of their contact.  This is an estimate: overlaps of a
        simulation differ by up to about 20% in smooth chains, and by much more in others, where
        several beads collide at once or waves return.

    Raises
    ------
    InputError
        If the chain has no materials, or the number of overlaps is wrong.

    Examples
    --------
    Balls of hardened steel first yield at a closing speed of about 0.4 m/s, balls of annealed
    stainless steel at 1.5 mm/s; the pressure is proportional to the speed to the power 2/5:

    >>> import hertzchain as hc
    >>> for name, speed in (("steel-52100", 0.43), ("steel-304", 0.0015)):
    ...     chain = hc.Chain.from_materials(5e-3, name, beads=2, velocity=speed)
    ...     print(name, hc.hertz_range(chain).yield_ratio.max().round(2))
    steel-52100 1.0
    steel-304 1.0

    Static forces count, too.  Under 30 N, balls of PTFE yield without any impact:

    >>> held = hc.Chain.from_materials(5e-3, "ptfe", beads=9, precompression=30, held_by="force")
    >>> float(hc.hertz_range(held).yield_ratio.max().round(1))
    4.2
    """
    require_chain("hertz_range", chain, beads=1)
    if chain.units != "SI" or chain.materials is None:
        raise InputError(
            "the limits of Hertz's law require materials; build the chain with "
            f"Chain.from_materials (chain: {chain.description})"
        )
    static = chain.static_state.overlaps
    d = impact_overlaps(chain, static) if overlaps is None else with_walls(chain, overlaps)
    overlap_ratio, yield_ratio = contact_ratios(chain, d)
    at_rest, static_yield = contact_ratios(chain, static)
    return HertzRange(
        overlap_ratio=overlap_ratio,
        yield_ratio=yield_ratio,
        speed_ratio=speed_ratio(chain),
        static_overlap_ratio=at_rest,
        static_yield_ratio=static_yield,
        causes=causes_of(chain),
        given=given_contacts(chain),
        soft=soft_contacts(chain),
        yielding=yielding_materials(chain) if (yield_ratio > 1.0).any() else (),
        may_yield=may_yield(chain) if (yield_ratio > 1.0).any() else np.zeros(len(d), bool),
        losses=losses_without_yield(chain),
        law_yield_ratio=law_yield_ratios(chain.contact_groups, d),
        overlap_limit=overlap_limits(chain),
        speed=impact_speed(chain),
        estimated=overlaps is None,
    )


def _place(contact: int, found: HertzRange) -> str:
    return contact_name(contact, len(found.overlap_ratio) - 1)
