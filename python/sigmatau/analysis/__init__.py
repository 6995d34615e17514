"""Analysis of a record: `analyze`, and the `Analysis` that it returns, as JSON and in words."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
