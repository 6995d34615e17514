"""The thresholds of a check are its argument: with others it finds nothing where it found something."""

from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record
from sigmatau.fitting import disturbance
from sigmatau.quality.drift import stationarity
from sigmatau.quality.samples import (
    copied_stretches,
    dense_spikes,
    dropouts,
    duplicate_rows,
    interpolation,
    light_shocks,
    motion,
    repeated_samples,
    resolution,
    saturation,
    spikes,
    start_transient,
    stillness,
    straight_lines,
    stuck_samples,
    units,
)
from sigmatau.quality.spectrum import axis_correlation

N = 20_000
MANY = 10**9


def clipped(x):
    np.clip(x, -2e-3, 2e-3, out=x)


def with_zeros(x):
    x += 1.0
    x[::1000] = 0.0


def stuck(x):
    x[5000:5100] = x[5000]


def with_copies(x):
    x[1000::1000] = x[999::1000][: len(x[1000::1000])]


def with_copied_stretch(x):
    x[15_000:15_500] = x[5000:5500]


def knocked(x):
    for k in range(5):
        x[3000 + 2 * k] += 0.1


def settling(x):
    x += 1 - np.exp(-np.arange(N) / 30)[:, None]
    x[0] = 0.0


def held(x):
    x[1::2] = x[::2]


def interpolated(x):
    rows = np.arange(N)
    for axis in x.T:
        axis[:] = np.interp(rows, rows[::4], axis[::4])


def filled(x):
    for start in range(500, N, 2000):
        x[start : start + 60] = np.linspace(x[start], x[start + 59], 60)


def with_spikes(x):
    x[::200] += 7e-3


def shared(x):
    x += x[:, :1]


def louder(x):
    x[N // 2 :] *= 3


def turning(x):
    x[:, 2] += 0.5


def too_noisy(x):
    x *= 1e4


def rounded(x):
    x[:] = np.round(x, 3)


def stepped(x):
    x[N // 2 :] += 1e-2


def shaken(x):
    x[5000:6000] *= 20


def turned(x):
    x[5000:7000] += 0.5


def walked_past(x):
    x[5000:6200] += 0.02 * np.sin(np.arange(1200) / 20)[:, None]


def spikes_of(stream, **thresholds):
    return np.flatnonzero(spikes.find_spikes(stream.column("gyro_x"), **thresholds)).tolist()


CASES = {
    "saturation": (clipped, saturation, saturation.saturation, {"levels": MANY}),
    "dropouts": (with_zeros, dropouts, dropouts.dropouts, {"no_chance": -1.0, "min_rows": MANY}),
    "stuck samples": (stuck, stuck_samples, stuck_samples.stuck_samples, {"min_run": MANY}),
    "copies": (with_copies, duplicate_rows, duplicate_rows.copies, {"min_rows": MANY}),
    "copied stretch": (with_copied_stretch, copied_stretches, copied_stretches.copied_stretches, {"least_rows": MANY}),
    "light shocks": (knocked, light_shocks, light_shocks.light_shocks, {"least_spikes": MANY}),
    "start": (settling, start_transient, start_transient.start_transient, {"least_windows": MANY}),
    "held": (held, repeated_samples, repeated_samples.repeated_samples, {"min_equal": MANY}),
    "interpolated": (interpolated, interpolation, interpolation.interpolated, {"max_share": 0.0}),
    "filled gaps": (
        filled,
        straight_lines,
        lambda stream, **thresholds: straight_lines.filled(stream, "gyro_x", **thresholds),
        {"max_share": 0.0},
    ),
    "many spikes": (
        with_spikes,
        dense_spikes,
        lambda stream, **thresholds: [
            mask
            for mask in [dense_spikes.dense_spikes(stream.column("gyro_x"), 0.0, **thresholds)]
            if mask is not None and mask.any()
        ],
        {"count": MANY},
    ),
    "spikes": (with_spikes, spikes, spikes_of, {"min_samples": MANY}),
    "coarse": (rounded, resolution, resolution.coarse_resolution, {"max_noise_steps": 0.0}),
    "turning": (turning, units, units.mean_rate, {"usual_offset": 1.0}),
    "too noisy": (too_noisy, units, units.implausible_unit, {"times_noisiest": 1e9}),
    "correlated": (shared, axis_correlation, axis_correlation.cross_axis, {"reported": 1.5}),
    "step": (
        stepped,
        motion,
        lambda stream, **thresholds: motion.level_changes(stream, motion.summary(stream, "gyro_x"), **thresholds),
        {"step_spreads": 1e9},
    ),
    "burst": (
        shaken,
        motion,
        lambda stream, **thresholds: motion.bursts(stream, motion.summary(stream, "gyro_x"), **thresholds),
        {"burst_power": 1e9},
    ),
    "motion": (
        turned,
        stillness,
        lambda stream, **thresholds: stillness.moved([stream], **thresholds).spans,
        {"most_missing": -1.0},
    ),
    "people": (
        walked_past,
        disturbance,
        lambda stream, **thresholds: disturbance.burst_share(stream.column("gyro_x"), 0.01, **thresholds),
        {"max_bursts": 1e9},
    ),
    "louder": (
        louder,
        stationarity,
        lambda stream, **thresholds: stationarity.non_stationary(stream, {}, **thresholds),
        {"min_ratio": 1e9},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_thresholds_are_an_argument(name):
    change, module, check, others = CASES[name]
    x = 1e-3 * np.random.default_rng(seed_of(f"thresholds {name}")).standard_normal((N, 3))
    change(x)
    (stream,) = Record.from_arrays(rate=100, gyro=x).streams
    assert check(stream)
    assert not check(stream, thresholds=replace(module.THRESHOLDS, **others))
