"""Fitting noise terms to an Allan deviation curve.

From the bottom up: `components` (what the variances and their covariance are made of), `gls` (least squares with them),
`inference` (tests, intervals, limits), `ramp`, `sixth_term`, `noise_fit` (the result), `tau_min` (from which averaging time,
with which terms), `statement` (from numbers to a result), `fit`; `read_off` (the paper's method), `planning`, `tables`.
"""
