"""Noise models of records and of Allan deviation curves.

`fit_channel` fits the spectrum of a record (`channel`, `likelihood`; the numerics are in the core), `fit` an Allan
deviation curve without its samples (`fit`, `statement`), `fit_psd` a density, and `join` several runs (`joint`).
`noise_fit` and `fitted_values` contain the result, and `to_model` converts it to a noise model. `read_off` is the method
of the paper. `planning` predicts what a record can show. `disturbance`, `rounding`, `coarse_counts` and similar modules
adjust a fit to the faults of a record.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
