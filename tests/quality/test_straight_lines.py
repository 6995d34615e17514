"""Lost samples filled in with straight lines, single ones and outages: told with place, length and effect."""

import math

import numpy as np
import pytest
from clean_records import check_samples as check
from clean_records import record

from known import seed_of
from sigmatau import Record, allan
from sigmatau.quality.samples.interpolation import interpolated
from sigmatau.quality.samples.straight_lines import filled

RATE, N = 100.0, 180_000


def six(name, n=N):
    """Two triads of white noise, as of a MEMS unit."""
    rng = np.random.default_rng(seed_of(name))
    return {
        "gyro": 2e-4 * rng.normal(size=(n, 3)) + 1e-3,
        "accel": 5e-3 * rng.normal(size=(n, 3)) + [0.1, -0.15, 9.803],
    }


def fill(x, lost):
    """Straight lines over lost rows."""
    t = np.arange(len(x))
    return np.column_stack([np.where(lost, np.interp(t, t[~lost], column[~lost]), column) for column in x.T])


def lost_rows(name, share, n=N):
    lost = np.random.default_rng(seed_of(name)).random(n) < share
    lost[[0, -1]] = False
    return lost


@pytest.mark.parametrize("digits", [None, 9])
def test_an_outage_is_one_finding_a_stream(digits):
    """Also as printed with nine digits."""
    n = 60_000
    lost = np.zeros(n, dtype=bool)
    lost[30_000:36_000] = True
    data = {name: fill(x, lost) for name, x in six("outage", n).items()}
    if digits:
        data = {name: np.vectorize(lambda v: float(f"{v:.{digits}g}"))(x) for name, x in data.items()}
    for stream in Record.from_arrays(rate=RATE, **data).streams:
        (finding,) = check(stream)
        assert (finding.code, finding.severity, finding.channels) == ("interpolated", "warning", stream.channels)
        assert finding.spans == ((300.0, 360.0),)
        assert finding.size == 60.0
        outages = finding.details.outages
        assert (outages.count, outages.start, outages.longest) == (1, 300.0, 60.0)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.3])
def test_single_lost_samples_and_what_filling_them_does(share):
    """σ at one sample is smaller and N at long τ larger than the sensor's own, by what is stated: over 12 channels."""
    lost = lost_rows(f"single {share}", share)
    m = 64
    stated, short, measured = [], [], []
    for k in range(4):
        x = np.random.default_rng(seed_of(f"white {share} {k}")).normal(size=(N, 3))
        y = fill(x, lost)
        stream = Record.from_arrays(rate=RATE, gyro=y).streams[0]
        (finding,) = interpolated(stream)
        # Of some chance at either end of 1 %.
        assert finding.size == pytest.approx(lost.mean(), rel=0.03)
        stated.append(dict(finding.factors)["random_walk"])
        short.append(filled(stream, "gyro_x").short)
        curves = [allan(Record.from_arrays(rate=RATE, gyro=z), taus=[1 / RATE, m / RATE]) for z in (y, x)]
        for a, b in zip(*(c.values() for c in curves), strict=True):
            measured.append(np.sqrt(a.avar / b.avar))
    mean, error = np.mean(measured, axis=0), np.std(measured, axis=0, ddof=1) / math.sqrt(12)
    assert mean[0] == pytest.approx(np.mean(short), abs=3 * error[0] + 1e-3)
    assert mean[1] == pytest.approx(np.mean(stated), abs=3 * error[1] + 1e-3)
    assert np.mean(stated) == pytest.approx(math.sqrt((1 + share / 2) / (1 - share)), rel=0.01)


def test_a_stretch_of_one_channel():
    x = six("one channel")["gyro"]
    lost = np.zeros(N, dtype=bool)
    lost[50_000:50_200] = True
    x[:, 1] = fill(x, lost)[:, 1]
    (finding,) = check(Record.from_arrays(rate=RATE, gyro=x).streams[0])
    assert (finding.code, finding.channels, finding.spans) == ("interpolated", ("gyro_y",), ((500.0, 502.0),))


def test_lines_behind_a_filter_and_rounded():
    """The samples between the lines need not be white, nor fine."""
    from scipy.signal import lfilter

    lost = lost_rows("behind a filter", 0.05)
    x = np.random.default_rng(seed_of("filtered and filled")).normal(size=(N, 1))
    slow = fill(lfilter([0.4], [1, -0.6], x, axis=0), lost)
    for y in (slow, np.round(fill(x, lost), 2)):
        (finding,) = interpolated(Record.from_arrays(rate=RATE, gyro_x=y[:, 0]).streams[0])
        assert finding.details.singles is not None
        assert finding.details.outages is None


@pytest.mark.parametrize("ratio", [2.05, 2.3, 3.5])
def test_interpolation_from_another_rate_is_no_loss(ratio):
    rng = np.random.default_rng(seed_of(f"other rate {ratio}"))
    known = rng.normal(size=int(60_000 / ratio) + 3)
    x = np.interp(np.arange(60_000) / ratio + 0.1, np.arange(len(known)), known)
    assert filled(Record.from_arrays(rate=RATE, gyro_x=x).streams[0], "gyro_x") is None


def test_what_is_not_filled():
    """Noise that comes and goes, filtered, drifting, clipped, repeated, stuck, with spikes or coarse."""
    from scipy.signal import butter, lfilter

    rng = np.random.default_rng(seed_of("not filled"))
    w = rng.normal(size=N)
    loud = w.copy()
    loud[: int(0.6 * N)] *= 100
    stuck = w.copy()
    stuck[1000:9000] = stuck[1000]
    cases = {
        "loud for a while": loud,
        "low-pass": lfilter(*butter(4, 0.01), w),
        "walk": np.cumsum(w),
        "ramp": w + np.arange(N),
        "clipped": np.clip(w, -0.5, 0.5),
        "repeated": np.repeat(w[: N // 2], 2),
        "stuck": stuck,
        "spikes": w + 1000 * (rng.random(N) < 1e-3),
        "coarse": np.round(w),
        "rounded": np.round(w, 1),
        "counts less a slow bias": np.round(1.8 * w) + 0.3 * np.cumsum(np.sin(np.arange(N) / 5000)) / 1000,
        "line": np.arange(N) * 0.3,
        "sine": np.sin(np.arange(N) / 1000.0),
    }
    for name, x in cases.items():
        assert filled(Record.from_arrays(rate=RATE, gyro_x=x).streams[0], "gyro_x") is None, name


def test_no_false_alarm():
    """Not one in 60 clean channels of any mixture; by the law of single lines 1e-4 a record."""
    rng = np.random.default_rng(seed_of("clean of lines"))
    for _ in range(10):
        for stream in record(rng, most=20_000).streams:
            assert interpolated(stream) == []
