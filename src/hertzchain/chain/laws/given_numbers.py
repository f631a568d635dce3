"""Numbers of a law, and the law in a few words."""

from __future__ import annotations

from ...representation import measure
from .base import Loss
from .elastic import Elastic


def given_numbers(law: Loss) -> dict[str, tuple[float, str]]:
    """Numbers that a law has and their units in SI chains, by their names in messages."""
    return {
        about.called: (value, (law._unit(name) or "") if about.dimension else "")
        for name, about in law.parameters().items()
        if not about.boolean and (value := getattr(law, name)) is not None
    }


def law_with_value(law: Loss, units: str, digits: int = 4, name: str = "") -> str:
    """Such as ``restitution 0.95``, ``viscoelastic 0.5 us``, ``elastic-plastic`` or ``no loss``."""
    if isinstance(law, Elastic):
        return "no loss"
    single = sum(not each.boolean for each in law.parameters().values()) == 1
    told = [
        f"{'' if single else f'{called} '}{measure(value, unit, units, digits).strip()}"
        for called, (value, unit) in given_numbers(law).items()
    ]
    usual = type(law).__dataclass_fields__.get("attractive")
    if usual is not None and (pulls := vars(law)["attractive"]) != usual.default:
        told.append("attractive" if pulls else "without attraction")
    name = name or law.name
    if single and len(told) == 1:
        return f"{name} {told[0]}"
    return f"{name} ({', '.join(told)})" if told else name
