"""Impacts on granular chains: describe a chain once, simulate or predict, compare.

>>> import hertzchain as hc
>>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
>>> exact = hc.propagate(chain)
>>> theory = hc.bca(chain)
>>> round(float(theory.velocity[49] / exact.velocity[49]), 3)
1.439
"""

import lazy_loader

__version__ = "0.1.0"

# The names are listed once, in __init__.pyi; each is loaded when first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
