r"""The leading pulse of a run: where it ends, and the momentum and energy that it carries.

A pulse has a clean front and, in most chains, no clean rear: in a forward taper its tail is
attached to the hump.  The length of the pulse is therefore taken from its front.  With the
crest at contact k at the first time :math:`s_k` at which :math:`v_k = v_{k+1}`,

.. math::

   J_k &= \sum_{j>k} m_j \left[v_j(s_k) - v_j(0)\right], &
   \tau_k &= \frac{J_k}{F_k(s_k) - F_k(0)}, \\
   e_k &= \max_{j \le k}\,(s_j + 4\tau_j), &
   w_k(t) &= \min\!\left(1, \max\!\left(0, \frac{e_k - t}{\tau_k}\right)\right) [v_k > 0] ,

:math:`J_k` is the momentum that contact k has handed over when the crest passes,
:math:`\tau_k` its rise time (0.748 bead spacings in a chain of equal spheres), :math:`e_k` the
time at which the pulse has left the contact, and :math:`w_k` the weight of bead k in the pulse.
The leading pulse has the momentum :math:`\sum_k w_k m_k v_k` and the kinetic energy
:math:`\tfrac12\sum_k w_k m_k v_k^2`.  Bead N before a wall leaves the pulse when the wall has
turned it back; before a free end it never does.

The weights fall linearly and are multiplied by velocities that pass through zero, so that
momentum and energy are continuous in time in every chain.  In a chain of equal beads they are
those of the solitary wave within :math:`2 \cdot 10^{-5}`, and in a self-similar taper a constant
multiple of those of one bead.  The number 4 is the smallest for which both hold.

.. warning::

   In strong forward tapers (q > 0.05) the tail moves at a tenth or more of the speed of the
   crest, and where the pulse ends is a convention: the momentum depends on the number 4.  In
   random chains the leading pulse is the *first* wave, not the largest one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.checks import real_numbers
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.simulation.absent import reason, together

if TYPE_CHECKING:
    from hertzchain.chain.scales import Scales


@dataclass(frozen=True, eq=False)
class LeadingPulse:
    r"""The leading pulse of a run; see `hertzchain.simulation.leading_pulse`.

    Attributes
    ----------
    chain : Chain
        The chain.
    crest : ndarray, shape (N - 1,)
        Time :math:`s_k` of the crest at contact k, its first largest overlap [scaled, or s].
    handed_over : ndarray, shape (N - 1,)
        Momentum :math:`J_k` that contact k has handed over until then [scaled, or kg m/s].
    rise_time : ndarray, shape (N - 1,)
        :math:`\tau_k` [scaled, or s].
    rear : ndarray, shape (N,)
        Time :math:`e_k` at which the pulse has left contact k, for k = N the right wall's
        [scaled, or s]; infinite where it had not when the run stopped, and at a free end.
    momentum, kinetic_energy : ndarray, shape (N - 1,)
        Of the leading pulse when its crest is at contact k [scaled, or kg m/s and J].
    notes : dict of str
        Why a value is NaN, by the name of the attribute.

    Examples
    --------
    The momentum of the pulse in parts of the momentum of its fastest bead, in a chain of equal
    beads (that of the solitary wave) and in a taper:

    >>> import hertzchain as hc
    >>> taper = hc.Chain.tapered("forward-exponential", 0.01, beads=80)
    >>> for chain in (hc.Chain.uniform(80), taper):
    ...     run = hc.simulate(chain, times=0)
    ...     leading, pulse = run.leading_pulse(), run.pulse()
    ...     print((leading.momentum / pulse.momentum[:-1])[[20, 40, 60]].round(4))
    [1.67 1.67 1.67]
    [1.7772 1.7773 1.7773]
    """

    chain: Chain
    crest: Array
    handed_over: Array
    rise_time: Array
    rear: Array
    momentum: Array
    kinetic_energy: Array
    notes: Mapping[str, str]

    def weights(self, times: Array, velocities: Array) -> Array:
        r"""Part of each bead that belongs to the leading pulse, :math:`w_k(t)`.

        Parameters
        ----------
        times : ndarray, shape (T,)
            Times [scaled, or s].
        velocities : ndarray, shape (T, N)
            Velocities of the beads at these times [scaled, or m/s].

        Returns
        -------
        ndarray, shape (T, N)
            Between 0 and 1.

        Raises
        ------
        InputError
            If the shapes do not fit.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9), times=[8.0])
        >>> run.leading_pulse().weights(run.times, run.velocities).round(2)
        array([[0., 0., 0., 0., 0., 1., 1., 1., 1.]])
        """
        times, velocities = real_numbers("time", times), real_numbers("velocity", velocities)
        if times.ndim != 1 or velocities.shape != (len(times), self.chain.beads):
            raise InputError(
                f"velocities at T times must have shape (T, {self.chain.beads}), got "
                f"{velocities.shape}, and times shape (T,), got {times.shape}"
            )
        # Bead N leaves when its velocity is zero, within no time.
        fall = np.append(_last_known(self.rise_time), np.finfo(float).tiny)
        left = self.rear - times[:, np.newaxis]
        with np.errstate(over="ignore"):
            parts = np.clip(left / fall, 0.0, 1.0)
        return np.asarray(parts * (velocities > 0.0))

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of everything, for `hertzchain.Scales`.

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
        >>> scales.to_si(hc.simulate(hc.Chain.uniform(9)).leading_pulse()).chain.units
        'SI'
        """
        times = dict.fromkeys(("crest", "rise_time", "rear"), scales.time)
        momenta = dict.fromkeys(("handed_over", "momentum"), scales.momentum)
        return times | momenta | {"kinetic_energy": scales.energy}


def leading_pulse_of(chain: Chain, crossings: Array, turned_back: float) -> LeadingPulse:
    """The leading pulse of what the compiled loop has recorded.

    Parameters
    ----------
    chain : Chain
        The chain.
    crossings : ndarray, shape (7, N - 1)
        As `hertzchain.kernels.records` lays them out.
    turned_back : float
        When the right wall had turned bead N back; 0 if it has not.

    Returns
    -------
    LeadingPulse

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.simulate(hc.Chain.uniform(9)).leading_pulse().crest[:2].round(4)
    array([1.2308, 2.5102])
    """
    from hertzchain.kernels import leading_pulse, records

    passed = crossings[records.CROSSING_TIME] > 0.0
    rises = crossings[records.RISE_TIME] > 0.0
    crest, rise = (
        np.where(known, crossings[row], np.nan)
        for row, known in ((records.CROSSING_TIME, passed), (records.RISE_TIME, rises))
    )
    own = np.where(rises, crest + leading_pulse.LENGTH * rise, -np.inf)
    rear = np.maximum.accumulate(own)
    # Beyond the last crest the pulse is still to come; before the first none has been.
    known = np.flatnonzero(rises)
    rear[known[-1] + 1 if len(known) else 0 :] = np.inf
    rear[np.isneginf(rear)] = np.inf
    unpassed = reason(
        "contact", ~passed, "no first maximum of the overlap before the end of the run"
    )
    unrisen = reason(
        "contact", passed & ~rises, "until the crest it handed over no momentum towards bead N"
    )
    notes = dict.fromkeys(("crest", "handed_over", "momentum", "kinetic_energy"), unpassed)
    notes["rise_time"] = together(unpassed, unrisen)
    return LeadingPulse(
        chain=chain,
        crest=crest,
        handed_over=np.where(passed, crossings[records.HANDED_OVER], np.nan),
        rise_time=rise,
        rear=np.append(rear, turned_back if turned_back > 0.0 else np.inf),
        momentum=np.where(passed, crossings[records.LEADING_MOMENTUM], np.nan),
        kinetic_energy=np.where(passed, crossings[records.LEADING_ENERGY], np.nan),
        notes={name: note for name, note in notes.items() if note},
    )


def _last_known(values: Array) -> Array:
    """Each value, or the last before it that is no NaN; 1 where there is none."""
    known = np.where(np.isnan(values), -1, np.arange(len(values)))
    last = np.maximum.accumulate(known)
    return np.where(last < 0, 1.0, values[last])
