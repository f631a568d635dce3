r"""The disorder law: mean and spread of the leading pulse of random chains.

Deviations of the beads from their nominal radii reflect a part of the pulse, which decays by
:math:`d\ln v/dk = -c\,\sigma^2` more than in the nominal chain.  The deviation of a single chain
from this mean comes from the beads near the impact and from those that the pulse has just reached;
the spread therefore does not grow along the chain.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.random_radii import reject_length
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.chain_units import for_any_units
from ..pulse.pulse import Pulse
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number
from .disorder_table import (
    DELAYED,
    END,
    OFFSETS,
    RATES,
    SCATTERS,
    START,
    DisorderTables,
    disorder_tables,
)
from .local_rate import DOUBTFUL, smooth_pulse

METHOD: Final = "the disorder law"
ADVICE: Final = "use propagate_many with Chain.with_scatter"
# Largest scatter of moduli, for which the second order was checked.
MAX_MODULUS_SCATTER: Final = 0.1
MIN_BEADS: Final = START + END + 2
# Estimated error of the attenuation (`benchmarks/disorder.py estimate`): in units of the squared
# scatter, and parts of the loss at a constant rate and where the rate has changed by SATURATED.
OF_SCATTER: Final = {"radii": 2.0, "moduli": 0.04}
OF_TABLES, OF_CHANGES, SATURATED = 0.01, 0.06, 0.04
# Largest change of the rate from contact to contact for which the estimate was checked.
MAX_CHANGE: Final = 0.011
# Rounding errors of rates, so that exponential chains at the limits of the tables are accepted.
ROUNDING: Final = 1e-12


@checked_arguments("disorder")
@for_any_units(METHOD, alternative="use distribution")
def disorder(chain: Chain, scatter: float = 0.0, *, modulus_scatter: float = 0.0) -> Pulse:
    r"""Leading pulse of chains that scatter about a nominal chain: mean and spread.

    .. math::

        \overline{\ln v_k} = \ln v_k^{(0)} - \sigma^2 \sum_{j<k} c(s_j, \sigma), \qquad
        \operatorname{var} \ln v_k = \sigma^2 \left[V_{\mathrm{start}}(s_1) + V(s_k)\right]

    with the velocity :math:`v_k^{(0)}` of the nominal chain by `local_rate`, and functions of the
    rates :math:`s_k = \ln(R_{k+1}/R_k)` that were tabulated from ensembles of simulated pulses.  In
    nearly equal beads, c depends on the scatter: the attenuation is not proportional to
    :math:`\sigma^2`.
    In linear and exponential tapers with a scatter up to 1%, mean velocities are within 0.04% and
    standard deviations within 2.1% of those of simulated ensembles; at 3%, within 0.22% and 5%.
    The law is not in the paper; it is derived, with that for arrival times and the accuracy of all
    columns, in the explanation "Disorder".

    Parameters
    ----------
    chain : Chain
        The nominal chain: at least ten spheres of one material, equal or tapered, with rates
        from -0.1 to 0.1 and Hertz contacts (exponent 3/2).
    scatter : float
        Standard deviation :math:`\sigma` of ln R of all beads, independent and normally
        distributed, up to 0.03, such as 0.01 or ``"1%"``.
    modulus_scatter : float
        The same for the moduli E of the beads, up to 0.1; at least one scatter must be above 0.

    Returns
    -------
    Pulse
        Geometric means of all columns, in the units of the nominal chain; and the standard
        deviations of ln v, ln t and ln F, ``velocity_spread``, ``arrival_spread`` and
        ``peak_force_spread``.  Those of other columns differ: the momentum also has the scatter of
        the mass.  The impact velocity does not scatter.  ``velocity_error`` is the estimated error
        of the mean velocity: the estimate of `local_rate` for the nominal chain, and that of the
        attenuation.

    Raises
    ------
    InputError
        If a scatter, rate or exponent is out of range, or `local_rate` does not support the chain.

    Warns
    -----
    ModelRangeWarning
        If the estimated error exceeds 0.5%, or the rate changes by more than 0.011 from one contact
        to the next, for which the estimate was not checked.

    Examples
    --------
    Balls whose radii scatter by 1%; two chains in three are within 1.8% of the mean:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(110)
    >>> pulse = hc.disorder(chain, scatter=0.01)
    >>> loss = 1 - pulse.velocity[99] / hc.local_rate(chain).velocity[99]
    >>> f"{loss:.1%}, +-{pulse.velocity_spread[99]:.1%}"
    '0.6%, +-1.8%'
    """
    reject_length("scatter", scatter)
    scatters = {
        "radii": number(
            "scatter", scatter, unit=FRACTION, least=0.0, most=SCATTERS[-1],
            hint=f"for more, {ADVICE}",
        ),
        "moduli": number(
            "modulus_scatter", modulus_scatter, unit=FRACTION, least=0.0, most=MAX_MODULUS_SCATTER
        ),
    }  # fmt: skip
    if not any(scatters.values()):
        raise InputError("disorder requires a scatter or modulus_scatter above 0; for a chain "
                         "without scatter, use local_rate")  # fmt: skip
    rates = _checked_rates(chain)
    clean = smooth_pulse(chain, METHOD, ADVICE)
    assert clean.residence is not None
    assert clean.velocity_error is not None
    assert clean.peak_overlap is not None
    shift, jitter = np.zeros((3, chain.beads - 1)), np.zeros(chain.beads - 1)
    error = np.zeros(chain.beads)
    for name, sigma in scatters.items():
        if sigma:
            own = sigma**2 * _mean_shift(disorder_tables()[name], sigma, rates)
            shift += own
            error[1:] += attenuation_errors(name, sigma, rates, own[0])
            jitter += sigma**2 * Delays.of(disorder_tables()[name], rates).variance()
    loss = np.concatenate(([0.0], np.cumsum(shift[0])))
    velocity = clean.velocity * np.exp(-loss)
    residence = clean.residence * np.exp(shift[2] + 0.2 * loss[:-1])
    spread = _spread(scatters, rates, residence)
    # The sum of arithmetic means is one, too.
    arrival = np.concatenate(([0.0], np.cumsum(residence * np.exp(0.5 * jitter))))
    arrival *= np.exp(-0.5 * spread[1] ** 2)
    pulse = Pulse(
        chain=chain,
        method=f"disorder law, {_description(scatters)}",
        velocity=velocity,
        arrival=arrival,
        peak_overlap=clean.peak_overlap * np.exp((shift[1] - 1.2 * loss[:-1]) / 1.5),
        residence=residence,
        velocity_error=clean.velocity_error + error,
        velocity_spread=spread[0],
        arrival_spread=spread[1],
        peak_force_spread=spread[2],
        notes=clean.notes,
    )
    _warn_doubtful(pulse, rates, known=float(clean.velocity_error.max()) <= DOUBTFUL)
    return pulse


def _checked_rates(chain: Chain) -> Array:
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"{METHOD} has tables for Hertz contacts (exponent 1.5) only, got "
            f"{chain.exponents:g}; {ADVICE}"
        )
    if chain.beads < MIN_BEADS:
        raise InputError(
            f"{METHOD} requires at least {MIN_BEADS} beads, got {chain.beads}; {ADVICE}"
        )
    rates = np.diff(np.log(chain.radii))
    outside = (rates < RATES[0] - ROUNDING) | (rates > RATES[-1] + ROUNDING)
    if outside.any():
        k = int(np.argmax(outside))
        raise InputError(
            f"{METHOD} has tables for rates ln(R_k+1/R_k) from {RATES[0]:g} to {RATES[-1]:g}, but "
            f"that of contact {k + 1} is {rates[k]:.3g}; {ADVICE}"
        )
    return np.clip(rates, RATES[0], RATES[-1])


def attenuation_errors(name: str, sigma: float, rates: Array, losses: Array) -> Array:
    """Estimated errors of the mean ln v of beads 2 to N, given the loss at each contact.

    The error is a part of the loss, which is larger where the rate has changed, and the error of
    the first contacts and of the tables.
    """
    changed = np.cumsum(np.abs(np.diff(rates, prepend=rates[0])))
    part = OF_TABLES + OF_CHANGES * np.minimum(1.0, changed / SATURATED)
    return np.asarray(OF_SCATTER[name] * sigma**2 + part * np.cumsum(np.abs(losses)))


def _warn_doubtful(pulse: Pulse, rates: Array, *, known: bool) -> None:
    """Warn about mean velocities that may be inaccurate, if the nominal chain has no warning."""
    change = float(np.abs(np.diff(rates)).max())
    errors = pulse.velocity_error
    assert errors is not None
    if change > MAX_CHANGE:
        k = int(np.argmax(np.abs(np.diff(rates)))) + 2
        warn_user(
            f"{METHOD} may be inaccurate for this chain ({pulse.chain.description}): at bead {k}, "
            f"the rate ln(R_k+1/R_k) changes by {change:.2g}, more than {MAX_CHANGE:g}, up to "
            f"which the estimated error was checked; {ADVICE}",
            ModelRangeWarning,
        )
    elif known and errors.max() > DOUBTFUL:
        k = int(np.argmax(errors > DOUBTFUL)) + 1
        warn_user(
            f"{METHOD} may be inaccurate for this chain ({pulse.chain.description}): the estimated "
            f"error of the mean velocity exceeds {DOUBTFUL:.1%} from bead {k} on and is "
            f"{errors.max():.2%} at most; {ADVICE}",
            ModelRangeWarning,
        )


def _stages(contacts: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Index of the stage of each contact."""
    stages = np.full(contacts, START)
    stages[:START] = np.arange(START)
    stages[contacts - END :] = START + 1 + np.arange(END)
    return stages


def _mean_shift(tables: DisorderTables, sigma: float, rates: Array) -> Array:
    """Loss of ln v by each contact, offsets of ln F and ln T, over the squared scatter."""
    contacts = len(rates)
    found = tables.mean(sigma, rates)
    return np.asarray(found[np.arange(contacts), :, _stages(contacts)].T)


def _spread(
    scatters: dict[str, float], rates: Array, residence: Array
) -> tuple[Array, Array, Array]:
    """Standard deviations of ln v and ln t of the beads and ln F of the contacts."""
    contacts = len(rates)
    velocity, force = np.zeros(contacts + 1), np.zeros(contacts)
    arrival = np.zeros(contacts + 1)
    for name, sigma in scatters.items():
        tables, square = disorder_tables()[name], sigma**2
        start = tables.at("velocity", rates[:1])[0, START]
        velocity[1:] += square * _along(tables.at("velocity", rates), start)
        force += square * _along(tables.at("force", rates), tables.at("force", rates[:1])[0, START])
        arrival[1:] += square * Delays.of(tables, rates).arrival_variance(residence)
    return np.sqrt(velocity), np.sqrt(arrival), np.sqrt(force)


@dataclass(frozen=True, eq=False)
class Delays:
    """Derivatives of all residence times, ln T, with respect to the deviations of all beads.

    ``around`` has those of each contact with respect to the beads around it, and ``first`` those
    of all later contacts with respect to the first beads, which change the pulse permanently.
    """

    around: Array
    first: Array

    @classmethod
    def of(cls, tables: DisorderTables, rates: Array) -> Delays:
        """Derivatives in a taper, each from the exponential chain with the contact's rate."""
        contacts = np.arange(len(rates))
        stages = np.minimum(contacts, DELAYED)
        stages[-1] = DELAYED + 1
        tabulated = tables.at("delay", rates)
        return cls(tabulated[contacts, stages], tabulated[0, -1])

    def variance(self) -> Array:
        """Variance of each ln T."""
        early = np.arange(len(self.around)) < DELAYED
        return np.square(self.around).sum(axis=1) + ~early * np.square(self.first).sum()

    def arrival_variance(self, residence: Array) -> Array:
        """Variance of ln t of beads 2 to N: the sum of the squares of its derivatives."""
        contacts, width = len(residence), len(OFFSETS)
        steps = np.arange(width)
        # Delays by bead j at the contacts from j - 2 on, which are the first that it changes.
        bead = np.arange(contacts + 1)[:, np.newaxis]
        contact = bead - OFFSETS[-1] + steps
        exists = (contact >= 0) & (contact < contacts)
        contact = np.clip(contact, 0, contacts - 1)
        delay = exists * residence[contact] * self.around[contact, width - 1 - steps]
        delay = np.cumsum(delay, axis=1)
        late = np.cumsum(residence * (np.arange(contacts) >= DELAYED))
        variance = np.zeros(contacts)
        for j in range(min(width, contacts + 1)):
            step = np.arange(contacts) - j + OFFSETS[-1]
            found = np.where(step < 0, 0.0, delay[j, np.clip(step, 0, width - 1)])
            variance += np.square(found + self.first[j] * late)
        grown = exists * np.diff(np.square(delay), axis=1, prepend=0.0)
        later = np.bincount(contact[width:].ravel(), grown[width:].ravel(), contacts)
        return (variance + np.cumsum(later)) / np.cumsum(residence) ** 2


def _along(table: Array, start: float) -> Array:
    """Variance at each contact, from the columns of the tables at the contact's rate."""
    contacts = len(table)
    stages = _stages(contacts)
    late = stages >= START
    found = table[np.arange(contacts), stages + late]
    return np.asarray(found + np.where(late, start, 0.0))


def _description(scatters: dict[str, float]) -> str:
    shown = (f"{100 * sigma:g}% scatter of {name}" for name, sigma in scatters.items() if sigma)
    return " and ".join(shown)
