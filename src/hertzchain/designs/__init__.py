"""Design of chains: a problem, methods that search for chains, and verified results."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["vary"])
