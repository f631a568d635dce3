"""Ratios of a chain to the limits of Hertz's law, from its overlaps."""

from __future__ import annotations

import itertools
import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..validation.numbers import per_bead_array, real_numbers
from .chain import Chain
from .contact_groups import effective_radii, yield_strengths
from .laws.elastic import Elastic
from .laws.elastic_plastic import ElasticPlastic
from .laws.restitution import Restitution
from .laws.unloading_ratio import UnloadingRatio
from .laws.walton_braun import WaltonBraun
from .materials import FIRST_YIELD, Material, contact_moduli
from .walls import materials_with_walls

MAX_OVERLAP_RATIO: Final = 0.01
MAX_SPEED_RATIO: Final = 0.01
# Overlap over radius beyond which neither Hertz's law nor `ElasticPlastic` predicts forces.
NO_PREDICTION: Final = 0.1
# Advice beyond it, where a law with yield is not valid either.
OTHER_MATERIAL: Final = f" or choose another material (overlaps exceed {NO_PREDICTION:g})"
OUTSIDE_LAW: Final = "outside the range of the law"
# In the reasons of points of sweeps, which are counted by these words.
CONTACTS_YIELD: Final = "contacts yield, which their law omits"
# Ratio of the stiffness of a contact to that of its materials, or its inverse, from which yield of
# `ElasticPlastic()`, which follows from the stiffness, differs from that of the materials.
OTHER_STIFFNESS: Final = 2.0
# Young's modulus [Pa] below which a material is a polymer; glass and metals are stiffer.
POLYMER: Final = 1e10
# Laws whose numbers have no unit: a contact loses the same part of its energy at any speed.
SCALE_FREE: Final = (Elastic, Restitution, UnloadingRatio, WaltonBraun)


def exceeds_limits(chain: Chain, overlaps: Array) -> bool:
    """Whether a chain of materials exceeds a limit, from overlaps of all N + 1 contacts."""
    overlap_ratio, yield_ratio = contact_ratios(chain, overlaps)
    return bool(
        (yield_ratio > 1.0).any()
        or (overlap_ratio > overlap_limits(chain)).any()
        or speed_ratio(chain) > MAX_SPEED_RATIO
    )


def yield_reasons(chain: Chain, overlaps: Array) -> list[str]:
    """A clause if contacts yield and their law omits it, for tables of many chains."""
    if chain.units != "SI" or chain.materials is None:
        return []
    largest = np.nan_to_num(contact_ratios(chain, overlaps)[1]).max()
    return [f"{CONTACTS_YIELD}: pressure / yield is {largest:.3g}"] if largest > 1.0 else []


def overlap_limits(chain: Chain) -> Array:
    """Limits of overlap / radius: laws that describe yield hold beyond the one of Hertz's law."""
    yields = [law.yields for law in chain.contact_losses]
    return np.where(yields, NO_PREDICTION, MAX_OVERLAP_RATIO)


def caution_outside_law(overlap_ratio: float) -> str:
    """Words after a value that is outside the range of the law of yield; otherwise empty."""
    if not overlap_ratio > NO_PREDICTION:
        return ""
    return f"{OUTSIDE_LAW} (overlap / radius {overlap_ratio:.2g})"


def law_of_limit(limit: float) -> str:
    """The law whose overlaps have this limit."""
    return "Hertz's law" if limit == MAX_OVERLAP_RATIO else "contacts that yield"


def with_walls(chain: Chain, overlaps: ArrayLike) -> Array:
    """Overlaps of all N + 1 contacts; those of the walls may be missing."""
    values = real_numbers("overlap", overlaps, "contact")
    if values.size == chain.beads - 1:
        values = np.pad(values.reshape(-1), 1)
    return per_bead_array("overlap", values, chain.beads + 1, "contact", least=0.0)


def contact_ratios(chain: Chain, overlaps: Array) -> tuple[Array, Array]:
    """Overlap over radius and pressure over yield of all contacts; NaN at linear springs."""
    overlap_ratio, pressure = contact_pressures(chain, overlaps)
    strength = yield_strengths(bodies_of(chain))
    elastic = np.array([not law.yields for law in chain.contact_losses])
    strength = np.where(elastic & np.isfinite(strength), strength, math.nan)
    return overlap_ratio, pressure / (FIRST_YIELD * strength)


def contact_pressures(chain: Chain, overlaps: Array) -> tuple[Array, Array]:
    """Overlap over radius and largest pressure [Pa] of all contacts; NaN at linear springs."""
    bodies, radius = bodies_of(chain), effective_radii(chain.face_radii)
    modulus = contact_moduli(bodies)
    # Johnson, Eqs. (4.22) to (4.24): a^3 = 3 F R/(4 E*), a^2 = R d and p_0 = 2 E* d/(pi a).
    force = chain.contact_stiffness * overlaps**chain.contact_exponents
    d = np.cbrt(0.75 * force / (modulus * np.sqrt(radius))) ** 2
    # The force of a pad or a plate does not act at one point of the ball.
    d[linear_springs(chain)] = math.nan
    return d / radius, 2.0 / math.pi * modulus * np.sqrt(d / radius)


def speed_ratio(chain: Chain) -> float:
    """Largest closing speed of neighbours at time 0 over the slower of their sound speeds."""
    assert chain.materials is not None
    sound = np.array([each.sound_speed for each in chain.materials])
    closing = np.maximum(-np.diff(chain.velocities), 0.0)
    return float(np.max(closing / np.minimum(sound[:-1], sound[1:]), initial=0.0))


def bodies_of(chain: Chain) -> list[Material]:
    """Materials of left wall, beads and right wall."""
    assert chain.materials is not None
    return materials_with_walls(chain.materials, (chain.left_wall, chain.right_wall))


def given_contacts(chain: Chain) -> NDArray[np.bool_]:
    """Contacts that are not those of spheres of their materials; none at free ends."""
    own = 4.0 / 3.0 * contact_moduli(bodies_of(chain)) * np.sqrt(effective_radii(chain.face_radii))
    ratio, there = chain.contact_stiffness / own, chain.contact_stiffness > 0.0
    other = (ratio > OTHER_STIFFNESS) | (ratio * OTHER_STIFFNESS < 1.0)
    return np.asarray(there & other | springs_of(chain))


def springs_of(chain: Chain) -> NDArray[np.bool_]:
    """Contacts with another exponent than spheres; none at free ends."""
    return np.asarray((chain.contact_stiffness > 0.0) & (chain.contact_exponents != HERTZ_EXPONENT))


def linear_springs(chain: Chain) -> NDArray[np.bool_]:
    """Contacts with exponent 1, such as pads and load cells; none at free ends."""
    return np.asarray((chain.contact_stiffness > 0.0) & (chain.contact_exponents == 1.0))


def with_yield(chain: Chain, law: ElasticPlastic) -> Chain | None:
    """The chain with a law that yields; None if this law does not apply to it.

    Walls and pads that are springs remain elastic, and walls keep laws of their own.
    """
    try:
        return chain.replace(loss=law)
    except InputError:
        return None


def may_yield(chain: Chain) -> NDArray[np.bool_]:
    """Contacts that yield if the chain has the loss `ElasticPlastic`, and not without it.

    None if some contacts have such a law already, which another loss would replace.
    """
    given = given_contacts(chain)
    found = np.zeros(len(given), bool)
    if any(law.yields for law in chain.contact_losses):
        return found
    # Contacts of a given stiffness need the overlap at yield; its value is without effect here.
    for law, which in ((ElasticPlastic(), ~given), (ElasticPlastic(yield_overlap=1.0), given)):
        dented = with_yield(chain, law) if which.any() else None
        if dented is not None:
            found |= which & np.array([each.yields for each in dented.contact_losses])
    return found


def losses_without_yield(chain: Chain) -> tuple[str, ...]:
    """Names of the losses of a chain that describe no yield, without those that walls keep."""
    walls = (chain.left_wall, chain.right_wall)
    first, last = (wall is not None and wall.loss is not None for wall in walls)
    laws = chain.contact_losses[first : chain.beads + 1 - last]
    names = (law.name for law in laws if not law.yields)
    return tuple(dict.fromkeys(name for name in names if name != "elastic"))


def soft_contacts(chain: Chain) -> NDArray[np.bool_]:
    """Contacts in which a polymer yields first."""
    return np.array([each.young < POLYMER for each in _first_to_yield(chain)])


def yielding_materials(chain: Chain) -> tuple[str, ...]:
    """Names of the materials that yield first, of contacts of two materials; otherwise empty."""
    pairs = itertools.pairwise(bodies_of(chain))
    return tuple(
        first.name if one != other else ""
        for first, (one, other) in zip(_first_to_yield(chain), pairs, strict=True)
    )


def _first_to_yield(chain: Chain) -> list[Material]:
    """The weaker body of each contact."""
    pairs = itertools.pairwise(bodies_of(chain))
    return [min(pair, key=lambda each: each.yield_strength or math.inf) for pair in pairs]


def causes_of(chain: Chain) -> tuple[str, str]:
    """Names of the causes of the motion and of the static force."""
    driven = chain.drive is not None
    motion = ["the velocity"] if chain.velocities.any() or not driven else []
    # Of both, only the precompression can be chosen.
    load = "the precompression" if chain.precompression > 0.0 else "gravity"
    if driven:
        motion.append("the drive")
    return " or ".join(motion), load if chain.static_state.forces.any() else ""


def scale_free_loss(chain: Chain) -> bool:
    """Whether all contacts lose a fraction of the energy that does not depend on the speed.

    The forces of these laws are then proportional to that of Hertz in scaled motions.
    """
    return not chain.lossless and all(
        type(law) in SCALE_FREE
        for group in chain.contact_groups for law in group.law.resolved(group.contacts)
    )  # fmt: skip


def impact_speed(chain: Chain) -> float:
    """Velocity of the impact if overlaps are proportional to a power of it, otherwise 0."""
    other = chain.drive is not None or chain.static_state.forces.any() or chain.gravity != 0.0
    if not (chain.lossless or scale_free_loss(chain)):
        return 0.0
    if other or chain.gaps.any() or springs_of(chain).any():
        return 0.0
    return float(np.abs(chain.velocities).max())
