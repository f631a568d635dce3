"""Every theory of the leading pulse by its name, as the command line and the scoreboard use it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Final

from hertzchain.chain.chain import Chain
from hertzchain.pulse.pulse import Pulse
from hertzchain.theory.bca import bca
from hertzchain.theory.hard_sphere import hard_sphere
from hertzchain.theory.local_rate import local_rate
from hertzchain.theory.modified_bca import modified_bca, two_thirds_bca

Theory = Callable[[Chain], Pulse]

# A theory refuses a chain it does not cover with an InputError.
THEORIES: Final[Mapping[str, Theory]] = MappingProxyType(
    {
        "bca": bca,
        "hard-sphere": hard_sphere,
        "two-thirds-bca": two_thirds_bca,
        "modified-bca-printed": partial(modified_bca, coefficients="printed"),
        "modified-bca": modified_bca,
        "local-rate": local_rate,
    }
)
