"""Simulation and theory of impacts on granular chains.

>>> import hertzchain as hc
>>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
>>> exact = hc.propagate(chain)
>>> theory = hc.bca(chain)
>>> round(float(theory.velocity[49] / exact.velocity[49]), 3)
1.439
"""

import lazy_loader

__version__ = "0.1.0"

# Names are listed in __init__.pyi and loaded on first use.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
