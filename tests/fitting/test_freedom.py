"""Degrees of freedom of the curve of a fitted model against those by the whole covariance."""

from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze
from sigmatau._native.gls import Components
from sigmatau.fitting.fitted_values import FittedGaussMarkov, FittedSinusoid, Interval
from sigmatau.noise.terms import NOISE

N, SIZES = 20_000, (1, 2, 3, 7, 50, 400, 5000, 9999)
THETA = [3.0, 2.0, 0.5, 1e-4]


@pytest.fixture(scope="module")
def fitted():
    y = np.random.default_rng(seed_of("freedom of a fit")).standard_normal(N) * 1e-3
    return analyze(Record.from_arrays(rate=1.0, gyro_x=y)).fits["gyro_x"]


def _of(value, unit):
    return Interval(value=value, low=None, high=None, unit=unit)


def test_of_a_fit_with_a_process_or_a_line(fitted):
    assert fitted.tau0 == 1.0
    model = dict(zip(NOISE, np.sqrt(THETA), strict=True))
    process = FittedGaussMarkov(sigma=_of(0.8, "rad/s"), time=_of(40.0, "s"))
    line = FittedSinusoid(amplitude=_of(0.5, "rad/s"), frequency=_of(0.0123, "Hz"))
    m = np.array(SIZES)
    for one, parts, last in (
        (replace(fitted, model=model), Components(N, SIZES), []),
        (replace(fitted, model=model, gauss_markov=(process,)), Components(N, SIZES, correlation_time=40.0), [0.64]),
        (replace(fitted, model=model, sinusoid=(line,)), Components(N, SIZES, frequency=0.0123), [0.25]),
    ):
        expected = parts.degrees_of_freedom(np.array([*THETA, *last]), ramp=0.0)
        np.testing.assert_allclose(one.degrees_of_freedom(m=m), expected, rtol=1e-10)


def test_a_line_alone_has_no_scatter(fitted):
    line = FittedSinusoid(amplitude=_of(0.5, "rad/s"), frequency=_of(0.0123, "Hz"))
    assert replace(fitted, model={}, sinusoid=(line,)).degrees_of_freedom(m=SIZES) is None
