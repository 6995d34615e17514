"""A sampling rate that changes once and for good is told as such, and nothing else is."""

import numpy as np
import pytest
from stamping import record_of

from known import seed_of
from sigmatau.io.live import Live
from sigmatau.io.read.options import TableOptions

N = 30_000


def stamps(before, after, at=N // 2, n=N, jitter=0.0):
    rng = np.random.default_rng(seed_of(f"rate from {before} to {after} at {at} with {jitter}"))
    t = np.concatenate(([0.0], np.cumsum(np.where(np.arange(n - 1) < at, 1 / before, 1 / after))))
    return np.round(t + jitter / before * rng.standard_normal(n), 6)


def changes(record):
    return [f for f in record.findings if f.code == "rate_change"]


@pytest.mark.parametrize(("at", "jitter"), [(500, 0.02), (N // 2, 0.0), (N - 4000, 0.02)])
@pytest.mark.parametrize(("before", "after"), [(50, 100), (100, 50), (100, 80), (200, 125)])
def test_both_rates_and_the_place(before, after, at, jitter):
    (told,) = changes(record := record_of(stamps(before, after, at, jitter=jitter)))
    assert (told.details.before, told.details.after) == pytest.approx((before, after), rel=0.02)
    assert told.spans[0] == pytest.approx((at / before, at / before + (N - 1 - at) / after), abs=3 / after)
    assert told.severity == "warning"
    assert not {"gaps", "rate_drift"} & {f.code for f in record.findings}


def test_a_gap_besides_is_told():
    t = stamps(50, 100)
    t[N // 4 :] += 3.0
    codes = {f.code: f for f in record_of(t).findings}
    assert codes["rate_change"].spans[0][0] == pytest.approx(N / 100 + 3, abs=0.1)
    assert codes["gaps"].details.longest[0].samples in (300, 301)


def without(t, share):
    return t[np.random.default_rng(seed_of(f"lost {share}")).random(len(t)) >= share]


@pytest.mark.parametrize(
    "t",
    [
        without(stamps(100, 100), 0.3),
        np.concatenate([without(stamps(100, 100), 0.4), 400 + stamps(100, 100)]),
        np.delete(stamps(100, 100), slice(9000, 15_000)),
        np.cumsum(1 / np.linspace(100, 120, N)),
        np.repeat(np.arange(N / 10) / 10, 10),
        stamps(100, 103),
        stamps(100, 100, jitter=0.2),
    ],
    ids=["losses", "losses in one part", "a pause", "a slow drift", "bunches", "3 %", "jitter"],
)
def test_nothing_else_is_a_change(t):
    assert not changes(record_of(t))


@pytest.mark.parametrize("size", [37, 100_000])
def test_of_a_live_log(size):
    """However the input is cut; long enough for blocks to be joined."""
    n = 140_000
    t = stamps(50, 100, 90_000, n)
    text = ("time [s],gyro_x [deg/s]\n" + "".join(f"{x:.3f},{k % 7}\n" for k, x in enumerate(t))).encode()
    live = Live(TableOptions().checked())
    found = []
    for k in range(0, len(text), size * 100):
        live.push(text[k : k + size * 100])
        found.append(live.rate_change())
    live.push(b"", last=True)
    assert size > 37 or found[0] is None
    told = live.rate_change()
    assert (told.details.before, told.details.after) == pytest.approx((50, 100), rel=1e-6)
    assert told.spans[0][0] == pytest.approx(1800, abs=1)
