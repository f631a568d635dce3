"""Errors of the growth per bead in exponential chains: ``python tools/growth_errors.py``.

For exponential chains of several exponents and rates, the growth of the velocity per bead by the
tables of the local-rate law is compared with that of `propagate` far from both ends.  The largest
errors in each interval of rates are written to `hertzchain.theory.growth_errors`.  Two minutes of
one core.
"""

import itertools
import math

import numpy as np

import hertzchain as hc
from hertzchain.errors import InputError, SimulationError
from hertzchain.theory.exponents import HIGHEST, LOWEST
from hertzchain.theory.growth_errors import EDGES, OWN_TABLES, edges_of, table_file
from hertzchain.theory.steady_rates import steady_rates

# Exponents of interpolated tables, and rates in each interval, as fractions of it.
EXPONENTS = np.geomspace(LOWEST, HIGHEST, 41)
PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)
# Beads between which the growth is constant, and number of beads; steep chains are shorter.
BEADS, FIRST, LEFT = 360, 160, 40
LARGEST_SUM = 200.0
# Error that is below that of `propagate`.
LEAST = 1e-12


def simulated(rate, exponent):
    """Growth per bead of simulated velocities."""
    beads = min(BEADS, int(LARGEST_SUM / max(abs(rate), 1e-9)))
    radii = np.exp(rate * np.arange(beads))
    logs = np.log(hc.propagate(hc.Chain.from_radii(radii, exponent=exponent)).velocity)
    first = min(FIRST, beads // 2)
    return (logs[beads - LEFT] - logs[first]) / (beads - LEFT - first)


def error(rate, exponent):
    """Size of the law's error of the growth per bead; NaN if the pulse cannot be simulated."""
    q = -math.expm1(-rate)
    taper = "backward-exponential" if q > 0.0 else "forward-exponential"
    try:
        law = steady_rates(taper, abs(q), exponent=exponent)["velocity"]
        return max(abs(law - simulated(rate, exponent)), LEAST)
    except (InputError, SimulationError):
        return math.nan


def largest_errors(exponent):
    """Largest error in each interval; intervals that cannot be simulated take the next one's."""
    edges, found = edges_of(float(exponent)), []
    for low, high in itertools.pairwise(edges):
        errors = [error(low + place * (high - low), exponent) for place in PLACES]
        found.append(max((each for each in errors if each == each), default=math.nan))
    known = np.flatnonzero(np.isfinite(found))
    return [found[known[np.argmin(np.abs(known - i))]] for i in range(len(found))]


def main():
    """Write the table."""
    lines = [
        "# Largest error of the law's growth per bead in exponential chains, for rates from each",
        "# column's number on, which is multiplied by `exponents.shrink_of` if it is negative.",
        "# Written by tools/growth_errors.py.",
        ",".join(["p", *(f"{each:g}" for each in EDGES[:-1])]),
    ]
    for exponent in sorted({*EXPONENTS.tolist(), *OWN_TABLES}):
        errors = largest_errors(exponent)
        lines.append(",".join([f"{exponent:.12g}", *(f"{each:.1e}" for each in errors)]))
        print(lines[-1][:60], flush=True)
    table_file().write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
