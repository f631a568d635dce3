"""Effect of the impact of a bead at the free end of a short chain.

With another striker or with losses, this effect is not that of the table; its size is part of the
estimated error.
"""

from __future__ import annotations

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from .universal_functions import universal_functions


def left_by_impact(rates: Array) -> Array:
    """Change of ln v at each bead, (N,), by the table of short chains for Hertz contacts."""
    from ..kernels.fast_changes import STATES
    from ..kernels.last_contacts import LAST, write_last

    tables = universal_functions(HERTZ_EXPONENT).fast
    found, growth = np.zeros(len(rates) + 1), []
    for each in (tables, tables._replace(short=tables.short[:0])):
        states = np.zeros((len(rates), STATES))
        write_last(rates, each, states)
        growth.append(states[-LAST:, 0])
    found[-LAST:] = np.cumsum(growth[0] - growth[1])
    return found
