"""Simulation and theory of impacts on granular chains.

>>> import hertzchain as hc
>>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
>>> exact = hc.propagate(chain)
>>> theory = hc.bca(chain)
>>> round(float(theory.velocity[49] / exact.velocity[49]), 3)
1.44
"""

import lazy_loader

__version__ = "0.1.0"

# Names are listed in __init__.pyi and loaded on first use.
_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

# Other words that users try.
_OTHER_WORDS = {
    "dispersion": "spectrum", "band_gap": "spectrum", "band_gaps": "spectrum", "bands": "spectrum",
    "modes": "spectrum", "run": "simulate", "solve": "simulate", "integrate": "simulate",
    "force": "simulate(chain).wall_force", "wall_force": "simulate(chain).wall_force",
    "plot": "plot_pulses", "optimise": "design", "optimize": "design", "bead": "Chain",
    "soliton": "solitary_wave", "sensitivity": "gradient", "monte_carlo": "distribution",
    "ensemble": "simulate_many", "materials": "catalogue", "load": "load_chain",
    "uniform": "Chain.uniform", "tapered": "Chain.tapered", "dimer": "Chain.dimer",
    "reflection": "simulate(chain).reflection", "transmission": "simulate(chain).reflection",
}  # fmt: skip


def __getattr__(name: str) -> object:
    if name.startswith("_") or name in __all__:
        return _load(name)
    import difflib

    within_parts = {
        each.lower(): f"{part}.{each}"
        for part in ("collision", "evaluation", "paper", "plotting", "theory")
        for each in _load(part).__all__
    }
    known = within_parts | {each.lower(): each for each in __all__} | _OTHER_WORDS
    near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.75)
    # A long word in a name, such as "tapered_chain".
    within = sorted((each for each in known if len(each) > 4 and each in name.lower()), key=len)
    found = known[(near or within[-1:])[0]] if near or within else ""
    hint = f"; did you mean {found!r}?" if found else ""
    # Another object than the module, whose names Python would add as a second suggestion.
    raise AttributeError(
        f"module 'hertzchain' has no attribute {name!r}{hint}", name=name, obj=None
    )
