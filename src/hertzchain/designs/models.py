"""Theories by which trials may be evaluated instead of the simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..pulse.pulse import Pulse
from ..recorded_warnings import ignore_warnings
from ..theory.bca import bca
from ..theory.hard_sphere import hard_sphere
from ..theory.local_rate import local_rate
from .measures import Measure

MODELS: Final[dict[str, Callable[[Chain], Pulse]]] = {
    "hard-sphere": hard_sphere, "bca": bca, "local-rate": local_rate,
}  # fmt: skip


def by_model(
    name: str, chains: Sequence[Chain | None], measures: Sequence[Measure],
    reject: Callable[[str], None],
) -> Array:  # fmt: skip
    """Values of measures of the leading pulse by a theory, shape (C, M)."""
    values = np.full((len(chains), len(measures)), np.nan)
    for i, chain in enumerate(chains):
        if chain is None:
            continue
        try:
            with ignore_warnings():
                pulse = MODELS[name](chain)
            for j, each in enumerate(measures):
                if not each.of_chain:
                    values[i, j] = each.from_pulse(pulse)
        except InputError as error:
            reject(str(error))
    return values
