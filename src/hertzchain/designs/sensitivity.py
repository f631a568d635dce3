"""Sensitivity of a result to the radius of each bead."""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..simulation.simulate_many import simulate_many
from .problem import Design

STEP, RTOL = 1e-4, 1e-9


def sensitivity(problem: Design, chain: Chain) -> Array:
    """Central differences of the objective with respect to the logarithms of the radii."""
    if "masses" in chain.given:
        raise InputError("the sensitivity to radii needs masses that follow from the radii")
    objective, first = problem.objective, chain.strikers if chain.scaled else -1
    # The first radius of a scaled chain is the unit of length.
    beads = [k for k in range(chain.beads) if k != first]
    chains = []
    for k in beads:
        for factor in (np.exp(STEP), np.exp(-STEP)):
            radii = chain.radii.copy()
            radii[k] *= factor
            chains.append(chain.replace(radii=radii))
    names = sorted({name for each in objective.measures for name in each.columns})
    values = np.empty((len(chains), len(objective.measures)))
    table = simulate_many(chains, keep=names, rtol=RTOL, until=problem.until) if names else None
    for j, each in enumerate(objective.measures):
        if each.of_chain or table is None:
            values[:, j] = [each.from_chain(one, np.nan) for one in chains]
        else:
            values[:, j] = each.from_table(table)
    scores = objective.score(values)
    found = np.zeros(chain.beads)
    found[beads] = (np.log(np.abs(scores[0::2])) - np.log(np.abs(scores[1::2]))) / (2.0 * STEP)
    return found
