"""Fitting noise terms to an Allan deviation curve.

From the bottom up: `components` (what the variances and their covariance are made of), `gls` (least squares with them),
`inference` (tests, intervals, limits), `ramp`, `extension` (a sixth term), `noisefit` (the result), `attempt` (from which
averaging time, with which terms), `statement` (from numbers to a result), `fit`.
"""

from sigmatau.fitting.fit import fit
from sigmatau.fitting.noisefit import FittedTerm, NoiseFit

__all__ = ["FittedTerm", "NoiseFit", "fit"]
