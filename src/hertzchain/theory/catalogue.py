"""All theories of the leading pulse by name, for the command line and the scoreboard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Final

from ..chain.chain import Chain
from ..pulse.pulse import Pulse
from .bca import bca
from .hard_sphere import hard_sphere
from .local_rate import local_rate
from .modified_bca import modified_bca, two_thirds_bca

Theory = Callable[[Chain], Pulse]

# Each theory raises InputError for chains that it does not support.
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
