"""Parameters of loss laws that a fit can determine, with typical values and steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.laws.base import LAWS
from .names import ENDS

# Typical values of the parameters of each law in units of the motion, from which a fit starts if
# the chain has no loss.  Laws with switching contacts use larger steps, because their signals are
# less smooth functions of the parameters.
TYPICAL: Final[Mapping[type[Loss], Mapping[str, float]]] = {
    LAWS["viscoelastic"]: {"time": 0.03},
    LAWS["dashpot"]: {"gamma": 0.015},
    LAWS["velocity-power"]: {"gamma": 0.01, "alpha": 1.5},
    LAWS["restitution"]: {"coefficient": 0.97},
    LAWS["unloading-ratio"]: {"ratio": 0.05},
    LAWS["walton-braun"]: {"ratio": 0.95},
    LAWS["elastic-plastic"]: {"yield_overlap": 1.0},
}
SWITCHING: Final = tuple(
    LAWS[name] for name in ("unloading-ratio", "walton-braun", "elastic-plastic")
)
SMOOTH_STEP, SWITCHING_STEP = 1e-3, 2e-2
# Laws whose force jumps when a contact closes, begins to unload or opens.
JUMPING: Final = tuple(LAWS[name] for name in ("unloading-ratio", "dashpot", "velocity-power"))


def loss_parameters(chain: Chain) -> dict[str, Loss]:
    """Parameters of the laws of a chain, each with the first law that has it.

    Those of walls with their own law are not among them.
    """
    found: dict[str, Loss] = {}
    own = walls_with_own_laws(chain).values()
    for contact, law in enumerate(chain.contact_losses):
        for name in free_parameters_of(law) if contact not in own else ():
            found.setdefault(name, law)
    return found


def walls_with_own_laws(chain: Chain) -> dict[str, int]:
    """Walls for which a law is given, and their contacts, 0 and N."""
    return {
        end: contact
        for end, contact in zip(ENDS, (0, chain.beads), strict=True)
        if (wall := getattr(chain, end)) is not None and wall.loss is not None
    }


def names_of_losses(chain: Chain) -> list[str]:
    """Names of the parameters of the laws of a chain, and of walls with their own law."""
    own = [
        f"{end}.loss.{name}"
        for end, contact in walls_with_own_laws(chain).items()
        for name in free_parameters_of(chain.contact_losses[contact])
    ]
    return [*(f"loss.{name}" for name in loss_parameters(chain)), *own]


def free_parameters_of(law: Loss) -> list[str]:
    """Parameters of a law that a fit can determine."""
    return [name for name in law.parameters() if has(law, name)]


def has(law: Loss, field: str) -> bool:
    """Whether a law has a parameter that is a number."""
    about = law.parameters().get(field)
    return about is not None and not about.boolean and getattr(law, field) is not None
