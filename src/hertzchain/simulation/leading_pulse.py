r"""The leading pulse of a run: its rear end, momentum and energy.

A pulse has a well-defined front but, in most chains, no well-defined rear: in a forward taper, the
tail is attached to the main pulse.  The length of the pulse is therefore derived from its front.
With the crest at contact k at the first time :math:`s_k` at which :math:`v_k = v_{k+1}`,

.. math::

   J_k &= \sum_{j>k} m_j \left[v_j(s_k) - v_j(0)\right], &
   \tau_k &= \frac{J_k}{F_k(s_k) - F_k(0)}, \\
   e_k &= \max_{j \le k}\,(s_j + 4\tau_j), &
   w_k(t) &= \min\!\left(1, \max\!\left(0, \frac{e_k - t}{\tau_k}\right)\right) [v_k > 0] ,

:math:`J_k` is the momentum that contact k has transferred when the crest passes,
:math:`\tau_k` its rise time (0.748 bead spacings in a chain of equal spheres), :math:`e_k` the
time at which the pulse has left the contact, and :math:`w_k` the weight of bead k in the pulse.
The leading pulse has the momentum :math:`\sum_k w_k m_k v_k` and the kinetic energy
:math:`\tfrac12\sum_k w_k m_k v_k^2`.  Before a wall, bead N leaves the pulse when the wall has
reversed its motion; before a free end it never leaves the pulse.

The weights fall linearly and are multiplied by velocities that pass through zero, which makes
momentum and energy continuous in time in every chain.  In a chain of equal beads they agree with
the solitary wave within :math:`2 \cdot 10^{-5}`, and in a self-similar taper they are a constant
multiple of the values of one bead.  The number 4 is the smallest for which both hold.

.. warning::

   In strong forward tapers (q > 0.05) the tail moves at a tenth or more of the speed of the
   crest, and the end of the pulse is a convention: the momentum depends on the number 4.  In
   random chains the leading pulse is the *first* wave, not the largest one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..chain.chain import Chain
from ..chain.scales import scale
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared
from ..representation import measure, short
from ..validation.keywords import checked_methods
from ..validation.numbers import real_numbers
from .missing_values import reason, together

if TYPE_CHECKING:
    import pandas as pd


@checked_methods
@dataclass(frozen=True, eq=False)
class LeadingPulse(Compared):
    r"""The leading pulse of a run; see `hertzchain.simulation.leading_pulse`.

    Attributes
    ----------
    chain : Chain
        The chain.
    crest : ndarray, shape (N - 1,)
        Time :math:`s_k` of the crest at contact k, its first largest overlap [scaled, or s].
    handed_over : ndarray, shape (N - 1,)
        Momentum :math:`J_k` that contact k has transferred until then [scaled, or N s].
    rise_time : ndarray, shape (N - 1,)
        :math:`\tau_k` [scaled, or s].
    rear : ndarray, shape (N,)
        Time :math:`e_k` at which the pulse has left contact k; k = N is the contact with the
        right wall [scaled, or s].  Infinite where the crest had not passed the contact when the run
        stopped, and at a free end; it may be later than the end of the run.
    momentum, kinetic_energy : ndarray, shape (N - 1,)
        Momentum and kinetic energy of the leading pulse when its crest is at contact k
        [scaled, or N s and J].
    notes : dict of str
        Reasons why values are NaN, by the name of the attribute.

    Examples
    --------
    The momentum of the pulse, relative to the momentum of its fastest bead, in a chain of equal
    beads (where it is that of the solitary wave) and in a taper:

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
    crest: Array = field(metadata=scale("time"))
    handed_over: Array = field(metadata=scale("momentum"))
    rise_time: Array = field(metadata=scale("time"))
    rear: Array = field(metadata=scale("time"))
    momentum: Array = field(metadata=scale("momentum"))
    kinetic_energy: Array = field(metadata=scale("energy"))
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
        # Bead N leaves at the instant at which its velocity is zero.
        fall = np.append(_last_known(self.rise_time), np.finfo(float).tiny)
        left = self.rear - times[:, np.newaxis]
        with np.errstate(over="ignore"):
            parts = np.clip(left / fall, 0.0, 1.0)
        return np.asarray(parts * (velocities > 0.0))

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per contact.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``contact``; columns ``crest``, ``handed_over``, ``rise_time``, ``rear``,
            ``momentum`` and ``kinetic_energy``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.simulate(hc.Chain.uniform(60), times=0).leading_pulse()
        >>> round(float(pulse.to_dataframe().momentum.loc[41]), 5)
        1.13831
        """
        import pandas as pd

        columns = {
            "crest": self.crest, "handed_over": self.handed_over, "rise_time": self.rise_time,
            "rear": self.rear[:-1], "momentum": self.momentum,
            "kinetic_energy": self.kinetic_energy,
        }  # fmt: skip
        contacts = pd.Index(np.arange(1, self.chain.beads), name="contact")
        return pd.DataFrame(columns, index=contacts)

    def __repr__(self) -> str:
        known, units = np.flatnonzero(np.isfinite(self.momentum)), self.chain.units
        if not len(known):
            return short("LeadingPulse", self.chain.description, "not known at any contact")
        k = int(known[-1])
        return short(
            "LeadingPulse",
            self.chain.description,
            f"known at {len(known)} of {len(self.crest)} contacts",
            f"at contact {k + 1} crest t = {measure(self.crest[k], 's', units)}, momentum "
            f"{measure(self.momentum[k], 'N s', units)}, kinetic energy "
            f"{measure(self.kinetic_energy[k], 'J', units)}",
        )

    def _repr_html_(self) -> str:
        from ..notebook.waves import leading_pulse_html

        return leading_pulse_html(self)


def leading_pulse_of(chain: Chain, crossings: Array, turned_back: float) -> LeadingPulse:
    """The leading pulse, from the records of the compiled loop."""
    from ..kernels import leading_pulse, state_layout

    passed = crossings[state_layout.CROSSING_TIME] > 0.0
    rises = crossings[state_layout.RISE_TIME] > 0.0
    crest, rise = (
        np.where(known, crossings[row], np.nan)
        for row, known in ((state_layout.CROSSING_TIME, passed), (state_layout.RISE_TIME, rises))
    )
    own = np.where(rises, crest + leading_pulse.LENGTH * rise, -np.inf)
    rear = np.maximum.accumulate(own)
    # The pulse has not reached contacts beyond the last crest; before the first, there was none.
    known = np.flatnonzero(rises)
    rear[known[-1] + 1 if len(known) else 0 :] = np.inf
    rear[np.isneginf(rear)] = np.inf
    unpassed = reason(
        "contact", ~passed, "no first maximum of the overlap before the end of the run"
    )
    unrisen = reason(
        "contact", passed & ~rises, "until the crest it transferred no momentum towards bead N"
    )
    notes = dict.fromkeys(("crest", "handed_over", "momentum", "kinetic_energy"), unpassed)
    notes["rise_time"] = together(unpassed, unrisen)
    return LeadingPulse(
        chain=chain,
        crest=crest,
        handed_over=np.where(passed, crossings[state_layout.HANDED_OVER], np.nan),
        rise_time=rise,
        rear=np.append(rear, turned_back if turned_back > 0.0 else np.inf),
        momentum=np.where(passed, crossings[state_layout.LEADING_MOMENTUM], np.nan),
        kinetic_energy=np.where(passed, crossings[state_layout.LEADING_ENERGY], np.nan),
        notes={name: note for name, note in notes.items() if note},
    )


def _last_known(values: Array) -> Array:
    """Replace each NaN by the last value before it, or by 1 if there is none."""
    known = np.where(np.isnan(values), -1, np.arange(len(values)))
    last = np.maximum.accumulate(known)
    return np.where(last < 0, 1.0, values[last])
