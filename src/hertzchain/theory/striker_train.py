r"""The train of solitary waves behind a heavy striker on equal beads.

The striker hits the chain repeatedly, each time more slowly.  Each wave is close to a particle of
mass :math:`m_e = P_1^2 m/2E_1`, which has the momentum and energy of the solitary wave.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from ..validation.keywords import checked_arguments
from ..validation.numbers import number
from .solitary_wave import solitary_wave
from .striker_table import striker_table

# Mass ratios of the table, and the largest number of waves.
MASS_RATIOS: Final = (1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0)
WAVES: Final = 10


@checked_arguments("striker_train")
def striker_train(mass_ratio: float, velocity: float = 1.0) -> Array:
    r"""Peak velocities of the waves that a heavy striker sends into a chain of equal beads.

    .. math::

        v_n = f_n(\mu)\, \frac{P_1}{2E_1} \frac{2\mu\, V}{\mu + \mu_e}
              \left|\frac{\mu - \mu_e}{\mu + \mu_e}\right|^{n-1}, \qquad
        \mu_e = \frac{P_1^2}{2E_1} = 1.304

    Without :math:`f_n`, this is the sequence of collisions of the striker with particles that
    have the momentum and energy of the solitary wave.  The factors :math:`f_n`, from 0.83 to 1.2,
    were determined by simulation for Hertz contacts.

    Parameters
    ----------
    mass_ratio : float
        Mass of the striker over that of a bead, :math:`\mu`, from 1.25 to 8.  Its contact has the
        stiffness of the others.
    velocity : float
        Velocity V of the striker, > 0.

    Returns
    -------
    ndarray
        Velocities of the first waves, at most ten, far from the striker and in the units of
        ``velocity``.  More waves follow, below 10% of the first one (5% for a ratio of 8), that
        decay irregularly.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.striker_train(4.0).round(3)
    array([1.213, 0.55 , 0.266, 0.132, 0.068])
    """
    mu = number("mass_ratio of a striker", mass_ratio, least=MASS_RATIOS[0], most=MASS_RATIOS[-1],
                hint="a lighter striker creates one wave; for a heavier one, use simulate(chain, "
                "until=...).waves()")  # fmt: skip
    v = number("velocity of a striker", velocity, above=0.0)
    found = []
    for n, factors in enumerate(striker_table()["train"].T):
        known = np.isfinite(factors)
        if not known.any() or mu < np.array(MASS_RATIOS)[known][0]:
            break
        factor = np.interp(mu, np.array(MASS_RATIOS)[known], factors[known])
        found.append(factor * particle_velocity(mu, n))
    return v * np.array(found)


def particle_velocity(mass_ratio: float, waves_before: int) -> float:
    """Peak velocity of a wave by collisions with particles, over the striker's velocity."""
    wave = solitary_wave()
    ratio = wave.momentum_constant / (2.0 * wave.energy_constant)
    mass = ratio * wave.momentum_constant
    kept = (mass_ratio - mass) / (mass_ratio + mass)
    return float(ratio * 2.0 * mass_ratio / (mass_ratio + mass) * abs(kept) ** waves_before)
