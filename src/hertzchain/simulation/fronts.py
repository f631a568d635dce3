r"""When the front of what runs along a chain reaches each contact.

The front of contact k is at the first time at which :math:`F_k - F_k(0)` is half of its first
maximum, or of its last value if the force has come to rest without one, as in a shock behind a
piston.  Unlike crests, fronts exist in shocks, and a drive that is slower than the chain does
not shift them: where a half-sine of 20 time units drives a chain under precompression 0.3, the
speed from crest to crest is 1.3 to 1.5 beads per time unit, that of the fronts 1.03 to 1.06,
the speed of sound.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.simulation.absent import reason, together
from hertzchain.simulation.run_pulse import moving_first

if TYPE_CHECKING:
    from hertzchain.chain.scales import Scales

# Part of the maximum at which a front is, and between which parts it rises.
HEIGHT: Final = 0.5
LOW, HIGH = 0.1, 0.9
# Saved times from below the rise to above it, at least.
FEWEST_TIMES: Final = 4
# A force has come to rest if it had this part of its last value half of the time ago.
SETTLED: Final = 0.9


@dataclass(frozen=True, eq=False)
class Fronts:
    r"""Fronts of a run; see `hertzchain.simulation.fronts`.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (N - 1,)
        When the front reached each contact [scaled, or s]; NaN where it is not known.
    heights : ndarray, shape (N - 1,)
        First maximum of :math:`F_k - F_k(0)`, or its last value [scaled, or N].
    notes : dict of str
        Why a value is NaN, by the name of the attribute.

    Examples
    --------
    A hammer's blow, a half-sine of force; in units of beads per time:

    >>> import hertzchain as hc
    >>> blow = hc.SineBurst(0.5, 0.125, cycles=0.5, window="none")
    >>> chain = hc.Chain.uniform(40).replace(drive=blow)
    >>> fronts = hc.simulate(chain, until=60.0, times=1500).fronts()
    >>> f"{10 / (fronts.times[29] - fronts.times[19]):.3f}"
    '0.845'
    """

    chain: Chain
    times: Array
    heights: Array
    notes: Mapping[str, str]

    @property
    def speed(self) -> Array:
        r"""Speed of the front from contact to contact, shape (N - 1,).

        .. math:: V_k = \frac{D_k}{f_k - f_{k-1}}

        as `Pulse.speed`, with fronts :math:`f_k` instead of crests.  In m/s for a chain in SI
        units, otherwise in radii :math:`R_1'` per unit of time; NaN for bead 1 and where a front
        is not known.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=30)
        >>> driven = chain.replace(drive=hc.Step(20.0, rise=50e-6))
        >>> fronts = hc.simulate(driven, until=700e-6, times=2000).fronts()
        >>> f"{fronts.speed[15]:.0f} m/s"
        '512 m/s'
        """
        taken = np.diff(self.times, prepend=np.nan)
        return np.asarray(self.chain.centre_distances / taken)

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the attributes, for `hertzchain.Scales`.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> scales = hc.Scales(radius=1.0, mass=1.0, velocity=2.0, length=6.0)
        >>> hc.simulate(hc.Chain.uniform(9)).fronts().factors(scales)["times"]
        3.0
        """
        return {"times": scales.time, "heights": scales.force}


def fronts_of(chain: Chain, times: Array, forces: Array, crossings: Array) -> Fronts:
    """Fronts in the forces of a run.

    Parameters
    ----------
    chain : Chain
        The chain.
    times, forces : ndarray, shapes (T,) and (T, N + 1)
        Saved times and the forces in the contacts.
    crossings : ndarray
        As `hertzchain.kernels.records` lays them out.

    Returns
    -------
    Fronts

    Raises
    ------
    InputError
        If fewer than two times were saved.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.simulate(hc.Chain.uniform(9), times=900).fronts().times[4:7].round(3)
    array([5.296, 6.483, 7.671])
    """
    from hertzchain.kernels import records

    if len(times) < 2:
        raise InputError(f"fronts need at least 2 saved times, the run has {len(times)}")
    static = equilibrium(chain).forces[1:-1]
    excess = forces[:, 1:-1] - static
    overlap = np.maximum(crossings[records.OVERLAP], 0.0)
    crest = crossings[records.CROSSING_TIME]
    found, heights = np.full((2, chain.beads - 1), np.nan)
    among, risen, late, coarse = np.zeros((4, chain.beads - 1), bool)
    among[: max(0, moving_first(chain) - 1)] = True
    for k in np.flatnonzero(~among):
        force = excess[:, k]
        top = float(force[times <= crest[k]].max(initial=0.0)) if crest[k] > 0.0 else force.max()
        if crest[k] > 0.0:
            top = max(top, chain.stiffness[k] * overlap[k] ** chain.exponent - static[k])
        above = np.flatnonzero(force >= HEIGHT * top)
        if top <= 0.0 or not len(above) or not (crest[k] > 0.0 or _settled(times, force, above[0])):
            risen[k] = True
        elif above[0] == 0:
            late[k] = True
        elif not _resolved(force, above[0], top) or times[above[0] - 1] > crest[k] > 0.0:
            coarse[k] = True
        else:
            found[k], heights[k] = _crossing(times, force, above[0], HEIGHT * top), top
    note = together(
        reason("contact", among, "between beads that move from the start"),
        reason("contact", risen, "not reached, or still being loaded, at the end of the run"),
        reason("contact", late, "reached before the first saved time"),
        reason("contact", coarse, f"fewer than {FEWEST_TIMES} saved times in the rise: save more"),
    )
    return Fronts(chain, found, heights, {"times": note, "heights": note} if note else {})


def _settled(times: Array, force: Array, first: int) -> bool:
    """Whether a force without a maximum has come to rest, having passed half at time ``first``."""
    middle = np.interp(0.5 * (times[first] + times[-1]), times, force)
    return bool(first < len(times) - 1 and middle >= SETTLED * force[-1])


def _resolved(force: Array, first: int, top: float) -> bool:
    """Whether enough saved times show the rise of a force."""
    below = np.flatnonzero(force[:first] <= LOW * top)
    above = np.flatnonzero(force[first:] >= HIGH * top)
    begin = int(below[-1]) if len(below) else -FEWEST_TIMES
    end = first + (int(above[0]) if len(above) else 0)
    return end - begin >= FEWEST_TIMES


def _crossing(times: Array, force: Array, first: int, level: float) -> float:
    """When a force reaches a level just before a saved time, by a monotonic cubic."""
    from scipy.interpolate import PchipInterpolator

    near = slice(max(first - 3, 0), first + 3)
    roots = PchipInterpolator(times[near], force[near]).solve(level, extrapolate=False)
    within = roots[(roots >= times[first - 1]) & (roots <= times[first])]
    return float(within[0]) if len(within) else float(times[first])
