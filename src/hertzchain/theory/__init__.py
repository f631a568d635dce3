"""Theories of the leading pulse, one file each: from a chain to a `Pulse`, without integration.

`hertzchain` exports the theories themselves; the names here are further functions.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
