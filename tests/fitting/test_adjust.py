"""Adjustments of a fit by checks: kept in their order, and the same in interval, limit, covariance and verdict."""

import typing
from functools import partial

import numpy as np
import pytest

from known import seed_of
from sigmatau import Analysis, Record, analyze, fit_channel
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.adjustment import Adjustment, Cause, Change, Ends
from sigmatau.fitting.known_biases import WalkBias, bias
from sigmatau.fitting.rounding import rounding_adjustment
from sigmatau.model.parameters import Parameter

N, WALK = 20_000, Parameter("random_walk")
ORDER = typing.get_args(Cause)


def noise(name):
    return 1e-3 * np.random.default_rng(seed_of(f"adjust {name}")).standard_normal(N)


def stepped():
    """A density that no model has, see `test_misfit`."""
    f = np.fft.rfftfreq(N, 0.01)
    f[0] = f[1]
    gain = np.where((f < 6) & (np.floor(2 * np.log2(f)) % 2 == 0), 3.0, 1.0)
    return np.fft.irfft(np.fft.rfft(noise("misfit")) * gain, N)


def wandering():
    """Twenty lines whose phases wander."""
    rng, x = np.random.default_rng(seed_of("adjust wandering")), noise("crowded lines")
    for line in np.linspace(3, 40, 20):
        x += 5e-4 * np.sin(2 * np.pi * line * np.arange(N) / 100 + np.cumsum(0.05 * rng.standard_normal(N)))
    return x


RECORDS = {
    "rounding": lambda: np.round(noise("rounding") / 1.5e-3) * 1.5e-3,
    "bias": lambda: np.clip(noise("bias"), -1.5e-3, 1.5e-3),
    "misfit": stepped,
    "changing_level": lambda: noise("changing level") * np.repeat([0.8, 1.2], N // 2),
    "crowded_lines": wandering,
}


@pytest.mark.parametrize("cause", RECORDS)
def test_each_adjustment_continues_the_one_before(cause):
    analysis = analyze(Record.from_arrays(rate=100, gyro_x=RECORDS[cause]()), threads=1)
    fitted = analysis["gyro_x"]
    causes = [adjustment.cause for adjustment in fitted.adjustments]
    assert cause in causes
    assert causes == sorted(causes, key=ORDER.index)
    ends = {}
    for adjustment in fitted.adjustments:
        for change in adjustment.changes:
            assert change.before == ends.get(change.parameter, change.before)
            ends[change.parameter] = change.after
    for parameter, after in ends.items():
        if parameter.number is None and (fitted[parameter.part].observed or not after.low):
            assert (after.low, after.high) == (fitted[parameter.part].low, fitted[parameter.part].high)
    assert Analysis.from_json(analysis.to_json())["gyro_x"].adjustments == fitted.adjustments
    assert set(fitted.adjustments[-1].findings) <= {finding.code for finding in analysis.findings}


def plain():
    return fit_channel(Record.from_arrays(rate=100, gyro_x=noise("plain")), "gyro_x")


def test_crowded_lines_widen_the_standard_error_too():
    record = Record.from_arrays(rate=100, gyro_x=wandering())
    (change,) = analyze(record, threads=1)["gyro_x"].adjustments[0].changes
    assert change.scale == pytest.approx(change.after.width / change.before.width)
    assert change.scale > 1


def test_an_ordinary_fit_has_none():
    assert plain().adjustments == ()


def test_the_standard_error_grows_as_the_interval():
    fitted = plain()
    wide = adjusted(fitted, partial(bias, biases=[WalkBias(factors=(1.0, 1.25), tail_error=0.0, findings=("spikes",))]))
    (change,) = wide.adjustments[0].changes
    assert change.scale == pytest.approx(change.after.width / change.before.width)
    assert wide.covariance.variance_of(WALK) == pytest.approx(
        fitted.covariance.variance_of(WALK) * change.scale**2, rel=1e-12
    )
    assert wide.adjustments[0].findings == ("spikes",)


def test_a_term_that_becomes_a_limit_keeps_the_size_of_its_standard_error():
    """A step far above the noise leaves a limit; the factor of the standard error has no unit."""
    fitted = plain()
    wide = adjusted(fitted, partial(rounding_adjustment, step=4e-3, noise=1e-3))
    assert not wide["random_walk"].observed
    assert wide.unclear == ("random_walk",)
    assert not any("not significant" in text for text in wide.notes())
    ratio = wide.covariance.variance_of(WALK) / fitted.covariance.variance_of(WALK)
    assert 1 <= ratio < 1e6


def test_a_number_without_ends_leaves_the_covariance():
    fitted = plain()
    change = Change.limiting(WALK, fitted["random_walk"], 2e-4)
    without = adjusted(fitted, lambda _: Adjustment(cause="misfit", changes=(change,)))
    assert without["random_walk"].upper_limit == 2e-4
    assert without.covariance.variance_of(WALK) is None
    assert change.before == Ends.of(fitted["random_walk"])
