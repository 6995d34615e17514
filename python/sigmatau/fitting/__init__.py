"""Fitting noise terms to an Allan deviation curve.

From the bottom up: `components` (what the variances and their covariance are made of), `gls` (least squares with them),
`goodness` (of fit), `inference` (tests, intervals, limits), `ramp`, `noise_fit` (the result), `attempt` (a fit from one
averaging time on), `gauss_markov`, `selection` (of that time and of a process), `statement` (from numbers to a result),
`fit`; `read_off` (the paper's method), `planning`, `tables`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
