"""Rates of the pulse in exponential tapers by the local-rate law, far from both ends."""

from __future__ import annotations

import math

from ..chain.tapers import exponential_rate
from ..errors import InputError
from ..validation.keywords import checked_arguments
from .universal_functions import STATE, WITHIN, universal_functions


@checked_arguments("steady_rates")
def steady_rates(taper: str, rate: float, *, exponent: float = 1.5) -> dict[str, float]:
    r"""Rates per bead of velocity, momentum and energy of an exponential taper, far from its ends.

    .. math::

        \frac{d\ln v}{dk} = \sigma(s), \quad
        \frac{d\ln P}{dk} = 3s + \sigma(s), \quad
        \frac{d\ln E}{dk} = 3s + 2\sigma(s), \qquad s = \ln\frac{R_{k+1}}{R_k} = -\ln(1 - q)

    with :math:`q \to -q` for a forward taper.  :math:`\sigma` is a table of the local-rate law,
    determined from simulated pulses (see the explanation "The local-rate law").  After the first
    contacts, and until the last ones, the pulse of `propagate` has these rates; those of the BCA
    are `exponential_rates`.

    Parameters
    ----------
    taper : str
        ``"backward-exponential"`` or ``"forward-exponential"``.
    rate : float
        Tapering parameter q: for p = 3/2, at most 0.66 backward and 0.17 forward.
    exponent : float, optional
        Exponent p of the contact force, 1.25 to 3.

    Returns
    -------
    dict
        ``velocity``, ``momentum`` and ``energy``: change of the logarithm per bead.

    Raises
    ------
    InputError
        If the taper is linear and has no constant rate, if the rate is outside the table, or if
        there is no table for the exponent.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import math
    >>> q, k = 0.05, 60
    >>> pulse = hc.propagate(hc.Chain.tapered("forward-exponential", q, beads=100))
    >>> f"{math.log(pulse.velocity[k] / pulse.velocity[k - 1]):.6f}"
    '0.067482'
    >>> f"{hc.theory.steady_rates('forward-exponential', q)['velocity']:.6f}"
    '0.067482'
    """
    q = exponential_rate(taper, rate)
    functions = universal_functions(exponent)
    s = -math.log1p(-q)
    low, high = functions.range
    if not low <= s <= high:
        end = low if q < 0.0 else high
        most = abs(math.expm1(-end))
        raise InputError(
            f"the rate of a {taper} taper must be at most {math.floor(1000.0 * most) / 1000.0:g}, "
            f"the end of the table, got {rate:g}; use propagate"
        )
    growth = float(functions.on_exponential_chains(s, WITHIN)[STATE.index("growth")])
    return {"velocity": growth, "momentum": 3.0 * s + growth, "energy": 3.0 * s + 2.0 * growth}
