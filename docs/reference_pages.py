"""Names for the templates of the API reference: the documented members of each class."""

import importlib
import inspect
import re
from pathlib import Path

from hertzchain.chain.laws import Loss

REFERENCE = Path(__file__).parent / "reference"
# Methods that only authors of a law need (docs/how-to/extend.md).
OF_AUTHORS = {
    "damper", "dent", "largest_overlap", "loading_force", "loading_overlap", "resolved", "row",
    "stored_energy", "strength", "yield_ratio",
}  # fmt: skip
# Members of classes that have further ones, for other modules of the package.
ONLY = {
    "Wall": {"of", "rigid"},
    "State": {"time", "positions", "velocities", "reversed", "struck_again"},
}
# Classes whose objects are results of functions; their arguments are not shown.
MADE_BY_FUNCTIONS = {
    "Budget", "Comparison", "DefectScan", "EffectiveChain", "EffectivePulse",
    "EnergyBalance", "EnergyFlux",
    "Estimate", "FitResult", "Fronts", "HertzRange", "Horizon", "LeadingPulse", "Loss",
    "LossComparison", "Posterior", "PulseTable", "Reflection", "Reproduction", "Run", "RunTable",
    "Scoreboard", "SensorForce", "SensorPassage", "SolitaryWave", "Spectrum", "State",
    "StaticState", "TraceComparison", "VelocityPeaks", "Verdict", "WallForce", "Wave", "WaveEvent",
    "WaveProfile", "WaveTail", "Waves", "Entry", "Erratum", "Figure", "Statement", "Table",
}  # fmt: skip
# Modules whose docstrings define a quantity.
DEFINITIONS = {
    "Budget": "hertzchain.simulation.budget",
    "Fronts": "hertzchain.simulation.fronts",
    "LeadingPulse": "hertzchain.simulation.leading_pulse",
    "Specification": "hertzchain.sweeps.specification",
    "WaveTail": "hertzchain.theory.wave_tail",
}


def entries(page: Path) -> list[tuple[str, str]]:
    """Module and name of each object in the summary tables of a page."""
    module, found = "", []
    for block in re.findall(r"^```\{eval-rst\}\n(.*?)^```", page.read_text("utf-8"), re.M | re.S):
        summary = False
        for line in block.splitlines():
            if match := re.match(r"\.\. currentmodule:: (\S+)", line):
                module = match[1]
            elif line.startswith(".. "):
                summary = line.startswith(".. autosummary::")
            elif summary and (match := re.match(r"   ([A-Za-z]\w*)$", line)):
                found.append((module, match[1]))
    return found


def members(item: type) -> list[str]:
    """Documented public methods and properties of a class, in the order of the source."""
    found: dict[str, None] = {}
    for base in item.__mro__:
        if not base.__module__.startswith("hertzchain"):
            continue
        for name, member in vars(base).items():
            kind = inspect.isfunction(member) or isinstance(
                member, (property, classmethod, staticmethod)
            )
            described = inspect.getdoc(getattr(item, name, None))
            if kind and described and not name.startswith("_"):
                found[name] = None
    hidden = OF_AUTHORS if issubclass(item, Loss) else set()
    only = ONLY.get(item.__name__, set(found))
    return [name for name in found if name in only and name not in hidden]


def context() -> dict[str, object]:
    """Variables of the templates in ``_templates/autosummary``."""
    listed, summaries = {}, {}
    for page in sorted(REFERENCE.glob("*.md")):
        for module, name in entries(page):
            item = getattr(importlib.import_module(module), name)
            if inspect.isclass(item):
                listed[f"{module}.{name}"] = members(item)
                summaries[f"{module}.{name}"] = (inspect.getdoc(item) or "").splitlines()[0]
    return {
        "documented_members": listed,
        "summaries": summaries,
        "made_by_functions": sorted(MADE_BY_FUNCTIONS),
        "definitions": DEFINITIONS,
    }
