"""Noise models: from a file, a fit or by hand, with their expected Allan variance, density and covariance."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
