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
    larger, smaller = _changes_of_logarithm(problem, chain, (np.exp(STEP), np.exp(-STEP)))
    return np.asarray((larger - smaller) / (2.0 * STEP))


def changes(problem: Design, chain: Chain, part: float) -> tuple[Array, Array]:
    """Relative changes of the objective if the radius of one bead grows or shrinks by a part.

    They are simulated.  At a design, several maxima of a force are often equal, and every change of
    a radius increases one of them.
    """
    larger, smaller = _changes_of_logarithm(problem, chain, (1.0 + part, 1.0 - part))
    return np.expm1(larger), np.expm1(smaller)


def _changes_of_logarithm(problem: Design, chain: Chain, factors: tuple[float, float]) -> Array:
    """Changes of the logarithm of the objective, shape (2, N), if one radius has each factor."""
    if "masses" in chain.given:
        raise InputError("the sensitivity to radii needs masses that follow from the radii")
    objective, first = problem.objective, chain.strikers if chain.scaled else -1
    # The first radius of a scaled chain is the unit of length.
    beads = [k for k in range(chain.beads) if k != first]
    chains = [chain]
    for factor in factors:
        for k in beads:
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
    logarithms = np.log(np.abs(objective.score(values)))
    found = np.zeros((2, chain.beads))
    found[:, beads] = (logarithms[1:] - logarithms[0]).reshape(2, -1)
    return found
