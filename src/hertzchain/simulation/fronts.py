r"""Times at which the front of a pulse or shock reaches each contact.

The front reaches contact k at the first time at which :math:`F_k - F_k(0)` is half of its first
maximum, or half of its last value if the force has become constant without a maximum, as in a
shock behind a piston.  Unlike crests, fronts exist in shocks, and a drive that is slower than the
chain does not shift them.  For example, if a half-sine of 20 time units drives a chain under
precompression 0.3, the speed from crest to crest is 1.3 to 1.5 beads per time unit, whereas the
speed of the fronts is 1.03 to 1.06, the speed of sound.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import loading_forces
from ..chain.scales import scale
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared
from ..representation import measure, short
from ..validation.keywords import checked_methods
from .missing_values import reason, together
from .run_pulse import moving_first
from .trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

# Fraction of the maximum that defines a front, and the fractions between which the force rises.
HEIGHT: Final = 0.5
LOW, HIGH = 0.1, 0.9
# Smallest number of saved times from below the rise to above it.
MIN_TIMES: Final = 4
# A force has become constant if it was at least this fraction of its last value at half of the time
# since the front.
SETTLED: Final = 0.9


@checked_methods
@dataclass(frozen=True, eq=False)
class Fronts(Compared):
    r"""Fronts of a run; see `hertzchain.simulation.fronts`.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (N - 1,)
        Time at which the front reached each contact [scaled, or s]; NaN where it is not known.
    heights : ndarray, shape (N - 1,)
        First maximum of :math:`F_k - F_k(0)`, or its last value [scaled, or N].
    notes : dict of str
        Reasons why values are NaN, by the name of the attribute.

    Examples
    --------
    A hammer blow, modelled as a half-sine of force; the speed is in beads per time:

    >>> import hertzchain as hc
    >>> blow = hc.SineBurst(0.5, 0.125, cycles=0.5, window="none")
    >>> chain = hc.Chain.uniform(40).replace(drive=blow)
    >>> fronts = hc.simulate(chain, until=60.0, times=1500).fronts()
    >>> f"{10 / (fronts.times[29] - fronts.times[19]):.3f}"
    '0.845'
    """

    chain: Chain
    times: Array = field(metadata=scale("time"))
    heights: Array = field(metadata=scale("force"))
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
        >>> driven = chain.replace(drive=hc.StepDrive(20.0, rise=50e-6))
        >>> fronts = hc.simulate(driven, until=700e-6, times=2000).fronts()
        >>> f"{fronts.speed[15]:.0f} m/s"
        '512 m/s'
        """
        taken = np.diff(self.times, prepend=np.nan)
        return np.asarray(self.chain.centre_distances / taken)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per contact.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``contact``; columns ``time``, ``height`` and ``speed``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(drive=hc.StepDrive(0.5))
        >>> fronts = hc.simulate(chain, until=30.0, times=900).fronts()
        >>> f"{fronts.to_dataframe().time.loc[10]:.2f}"
        '11.97'
        """
        import pandas as pd

        contacts = pd.Index(np.arange(1, self.chain.beads), name="contact")
        columns = {"time": self.times, "height": self.heights, "speed": self.speed}
        return pd.DataFrame(columns, index=contacts)

    def __repr__(self) -> str:
        known, units = np.flatnonzero(np.isfinite(self.times)), self.chain.units
        summary = f"known at {len(known)} of {len(self.times)} contacts"
        if len(known):
            first, last = known[[0, -1]]
            begin, end = self.times[[first, last]]
            summary += f", from t = {measure(begin, 's', units)} at contact {first + 1} to t = "
            summary += f"{measure(end, 's', units)} at contact {last + 1}"
        return short("Fronts", self.chain.description, summary)

    def _repr_html_(self) -> str:
        from ..notebook.waves import fronts_html

        return fronts_html(self)


def fronts_of(self: Trajectory) -> Fronts:
    """Times at which the front of the motion reached each contact, and its speed.

    Use fronts for driven chains: they exist in shocks, where the force has no maximum, and
    unlike crests they are not shifted by a slow drive.

    Returns
    -------
    Fronts
        From the saved times.

    Raises
    ------
    InputError
        If fewer than two times were saved.

    Examples
    --------
    A piston that moves at constant speed in a chain with losses causes a shock without a crest.
    By the balance of mass and momentum, the speed of the shock is 1 bead per time:

    >>> import hertzchain as hc
    >>> piston = hc.TableDrive([0.0, 200.0], [0.0, 200.0], of="displacement")
    >>> chain = hc.Chain.uniform(40).replace(
    ...     drive=piston, left_wall=hc.Wall(stiffness=1.0), loss=hc.Viscoelastic(0.5)
    ... )
    >>> fronts = hc.simulate(chain, until=28.0, times=1000).fronts()
    >>> f"{5 / (fronts.times[14] - fronts.times[9]):.2f}"
    '1.01'
    >>> fronts.notes["times"]
    'contacts 24 to 39: not reached, or still being loaded, at the end of the run'
    """
    from ..kernels import state_layout

    chain, times, crossings = self.chain, self.times, self._crossings
    if len(times) < 2:
        raise InputError(f"fronts require at least 2 saved times, the run has {len(times)}")
    static = chain.static_state.forces[1:-1]
    excess = self.forces[:, 1:-1] - static
    overlap = np.maximum(crossings[state_layout.OVERLAP], 0.0)
    crest = crossings[state_layout.CROSSING_TIME]
    crests = loading_forces(chain.contact_groups, np.pad(overlap, 1))[1:-1]
    found, heights = np.full((2, chain.beads - 1), np.nan)
    among, risen, late, coarse = np.zeros((4, chain.beads - 1), bool)
    among[: max(0, moving_first(chain) - 1)] = True
    for k in np.flatnonzero(~among):
        force = excess[:, k]
        top = float(force[times <= crest[k]].max(initial=0.0)) if crest[k] > 0.0 else force.max()
        if crest[k] > 0.0:
            top = max(top, float(crests[k]) - static[k])
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
        reason("contact", coarse, f"fewer than {MIN_TIMES} saved times in the rise: save more"),
    )
    return Fronts(chain, found, heights, {"times": note, "heights": note} if note else {})


def _settled(times: Array, force: Array, first: int) -> bool:
    """Whether a force without a maximum has become constant; it passed half at index ``first``."""
    middle = np.interp(0.5 * (times[first] + times[-1]), times, force)
    return bool(first < len(times) - 1 and middle >= SETTLED * force[-1])


def _resolved(force: Array, first: int, top: float) -> bool:
    """Whether enough saved times show the rise of a force."""
    below = np.flatnonzero(force[:first] <= LOW * top)
    above = np.flatnonzero(force[first:] >= HIGH * top)
    begin = int(below[-1]) if len(below) else -MIN_TIMES
    end = first + (int(above[0]) if len(above) else 0)
    return end - begin >= MIN_TIMES


def _crossing(times: Array, force: Array, first: int, level: float) -> float:
    """Time at which a force reaches a level before a saved time, by a monotonic cubic."""
    from scipy.interpolate import PchipInterpolator

    near = slice(max(first - 3, 0), first + 3)
    roots = PchipInterpolator(times[near], force[near]).solve(level, extrapolate=False)
    within = roots[(roots >= times[first - 1]) & (roots <= times[first])]
    return float(within[0]) if len(within) else float(times[first])
