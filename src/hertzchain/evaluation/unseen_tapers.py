r"""Tapers to which no theory was fitted, for evaluating theories.

None of them is exponential, linear, or a ramp of :math:`s_k = \ln(R_{k+1}/R_k)`; the constants
of the theories were determined from these.  A taper is called smooth if
:math:`|s_k| \le 0.1` and :math:`|s_{k+1} - s_k| \le 0.005`.  Some tapers are not smooth, so
that the limits of the theories can be seen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from ..collision import Array
from ..validation.keywords import checked_arguments

MAX_LOCAL_RATE: Final = 0.1
MAX_CHANGE: Final = 0.005


def power_law(k: Array, exponent: float, offset: float = 0.0) -> Array:
    r"""Radii :math:`(k + a)^x`, with :math:`s_k \approx x/(k + a)`."""
    return np.asarray((k + offset) ** exponent)


def sigmoid(k: Array, last: float, width: float) -> Array:
    """Radii that change from 1 to another value around bead 50."""
    return 1.0 + (last - 1.0) / (1.0 + np.exp((50.0 - k) / width))


def bump(k: Array, height: float, width: float) -> Array:
    """Equal beads with a bump (or waist, of negative height) at bead 50, of half width at 1/e."""
    return 1.0 + height * np.exp(-(((k - 50.0) / width) ** 2))


def wave(k: Array, amplitude: float, period: float, rise: float = 0.0) -> Array:
    """Radii that oscillate about one, or about an exponential of rate ``rise``."""
    return np.asarray(np.exp(rise * k) * (1.0 + amplitude * np.sin(2.0 * np.pi * k / period)))


def hourglass(k: Array, width: float) -> Array:
    """Radii that follow a hyperbolic cosine, with a neck at bead 50."""
    return np.cosh((k - 50.0) / width)


def random_smooth(k: Array, seed: int) -> Array:
    """Radii whose local rates are a sum of four long waves with random coefficients."""
    rng = np.random.default_rng(seed)
    waves, phases = np.arange(1, 5), rng.uniform(0.0, 2.0 * np.pi, 4)
    amplitudes = rng.uniform(-1.0, 1.0, 4)
    rates = np.sin(2.0 * np.pi * np.outer(k / 100.0, waves) + phases) @ amplitudes
    # This limits the slope of the sum to 0.005 per bead.
    rates *= MAX_CHANGE / (2.0 * np.pi / 100.0 * np.sum(waves * np.abs(amplitudes)))
    return np.exp(np.concatenate(([0.0], np.cumsum(rates[:-1]))))


def step(k: Array, ratio: float) -> Array:
    """Two uniform halves, the second from bead 51 on."""
    return np.where(k <= 50.0, 1.0, ratio)


def piecewise_exponential(k: Array, rates: tuple[float, ...]) -> Array:
    """Consecutive exponential tapers, each 25 beads long."""
    piece = np.minimum((k[:-1].astype(int) - 1) // 25, len(rates) - 1)
    return np.exp(np.concatenate(([0.0], np.cumsum(np.array(rates)[piece]))))


def scatter(k: Array, tolerance: float, seed: int) -> Array:
    """Equal beads with random deviations of the radii."""
    return 1.0 + tolerance * np.random.default_rng(seed).standard_normal(len(k))


UNSEEN_TAPERS: Final[dict[str, Callable[[Array], Array]]] = {
    "power law 0.3": partial(power_law, exponent=0.3, offset=9.0),
    "power law 0.7": partial(power_law, exponent=0.7, offset=14.0),
    "power law 1.5": partial(power_law, exponent=1.5, offset=19.0),
    "power law -1": partial(power_law, exponent=-1.0, offset=19.0),
    "sigmoid, up": partial(sigmoid, last=3.0, width=8.0),
    "sigmoid, down": partial(sigmoid, last=0.4, width=10.0),
    "bump": partial(bump, height=0.6, width=15.0),
    "waist": partial(bump, height=-0.4, width=18.0),
    "hourglass": partial(hourglass, width=25.0),
    "sine": partial(wave, amplitude=0.2, period=60.0),
    "sine on a rise": partial(wave, amplitude=0.1, period=40.0, rise=0.02),
    "random smooth, first": partial(random_smooth, seed=1),
    "random smooth, second": partial(random_smooth, seed=2),
    "bare power law 0.3": partial(power_law, exponent=0.3),
    "bare power law 1.5": partial(power_law, exponent=1.5),
    "piecewise exponential": partial(piecewise_exponential, rates=(0.05, -0.04, 0.02, -0.06)),
    "step up": partial(step, ratio=1.3),
    "step down": partial(step, ratio=0.7),
    "fast sine": partial(wave, amplitude=0.1, period=12.0),
    "scatter of 2%": partial(scatter, tolerance=0.02, seed=3),
}


@checked_arguments("unseen_radii")
def unseen_radii(beads: int = 100) -> dict[str, Array]:
    """Radii of all unseen tapers, by name.

    Parameters
    ----------
    beads : int
        Number of beads N of each taper, at least 2.

    Returns
    -------
    dict of str to ndarray
        Radii, shape (N,), not scaled by the first radius.

    Examples
    --------
    >>> import hertzchain as hc
    >>> radii = hc.evaluation.unseen_radii()
    >>> len(radii), sum(hc.evaluation.is_smooth(chain) for chain in radii.values())
    (20, 13)
    """
    k = np.arange(1.0, beads + 1.0)
    return {name: taper(k) for name, taper in UNSEEN_TAPERS.items()}


@checked_arguments("is_smooth")
def is_smooth(radii: Array) -> bool:
    r"""Whether :math:`|s_k| \le 0.1` and :math:`|s_{k+1} - s_k| \le 0.005` for the whole chain.

    Parameters
    ----------
    radii : ndarray, shape (N,)
        Radii, in any unit.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> [hc.evaluation.is_smooth(R) for R in (1.05 ** np.arange(9), np.array([1.0, 1.0, 1.01]))]
    [True, False]
    """
    rates = np.diff(np.log(radii))
    gentle = bool(np.all(np.abs(rates) <= MAX_LOCAL_RATE))
    return gentle and bool(np.all(np.abs(np.diff(rates)) <= MAX_CHANGE))
