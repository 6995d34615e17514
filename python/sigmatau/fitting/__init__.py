"""Noise models of records and of Allan deviation curves.

`fit_channel` fits the spectrum of a record (`channel`, `likelihood`; the numerics are in the core), `fit` an Allan deviation
curve without its samples (`fit`, `statement`), `fit_psd` a density, `join` several runs (`joint`). `noise_fit` and
`fitted_values` are the result, `to_model` makes a noise model of it. `read_off` is the method of the paper, `planning` says
what a record can show; `disturbance`, `rounding`, `coarse_counts` and their neighbours adjust a fit to what is wrong with a
record, each with an `adjustment`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
