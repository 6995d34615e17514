"""Spikes: none where there are none, all where there are some, and what they do to the random walk."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from clean_records import mixture
from scipy.signal import butter, lfilter, sosfilt

from known import seed_of
from sigmatau import NoiseModel, Record, simulate
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples.dense_spikes import dense_spikes, has_hidden_spikes
from sigmatau.quality.samples.disturbances import disturbances, without
from sigmatau.quality.samples.spikes import _multiple, find_spikes, spike_mask, spikes
from sigmatau.record.streams import Columns, Transform

RATE, N = 100.0, 200_000


def white(name, n=N):
    return np.random.default_rng(seed_of(name)).normal(size=n)


@keep_facts()
def found_in(x):
    """The spikes of a channel, and the finding about them."""
    stream = Record.from_arrays(rate=RATE, signal=x).streams[0]
    ((finding, _),) = spikes(stream)
    return spike_mask(stream, "signal"), finding


def test_spans_are_all_spikes():
    """Of more than 1000 the first are listed, because all are of one length, and the others counted."""
    for number in (300, 1100):
        x, at = white(f"spans {number}"), np.arange(50, N, 150)[:number]
        x[at] += 100.0
        _, finding = found_in(x)
        assert finding.spans == tuple((k / RATE, k / RATE) for k in at[:1000])
        assert finding.more_spans == max(number - 1000, 0)


@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("height", [-16.0, 16.0, 1e3])
def test_planted_spikes_are_found_where_they_are(width, height):
    """16 standard deviations of the noise: the threshold is 8, and noise takes one below it in 1e-8 of cases."""
    x = white(f"planted {width} {height}")
    at = np.arange(500, N - 500, 997)
    planted = np.zeros(N, dtype=bool)
    for k in range(width):
        planted[at + k] = True
    x[planted] += height
    found = find_spikes(x)
    # Of three in a row the outer two have two others on one side, whose median is half way.
    inner = planted if width < 3 or abs(height) > 100 else np.isin(np.arange(N), at + 1)
    assert not np.any(found & ~planted)
    assert not np.any(inner & ~found)


def test_no_spike_in_white_noise_of_four_million_samples():
    """Less than 0.001 false spikes a record, whatever its length."""
    rng = np.random.default_rng(seed_of("four million"))
    assert sum(int(find_spikes(rng.normal(size=1_000_000)).sum()) for _ in range(4)) == 0


@pytest.mark.parametrize("n", [1_000, 1_000_000, 100_000_000, 10_000_000_000])
def test_the_threshold_grows_with_the_record(n):
    """Less than 0.001 samples of Gaussian noise are beyond it, and they are not by more than they must."""
    beyond = 2 * n * NormalDist().cdf(-_multiple(n))
    assert beyond < 1e-3
    assert _multiple(n) < 9


def test_a_sample_half_way_to_a_new_level_is_no_spike():
    x = white("half way")
    x[N // 2 :] += 100
    x[N // 2] -= 50
    assert not find_spikes(x).any()


@pytest.mark.parametrize("step", [0.1, 0.3, 1.0, 3.0, 5.0, 10.0, 30.0])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.5])
def test_coarse_steps_are_no_spikes(step, phase):
    """Noise of a tenth of a step too, which is seen in a few samples only, each a step high."""
    x = np.round(white(f"step {step}") / step + phase) * step
    assert not find_spikes(x).any()


@pytest.mark.parametrize("k", range(6))
def test_mixtures_of_all_terms_have_none(k):
    rng = np.random.default_rng(seed_of(f"mixture {k}"))
    model = NoiseModel(channels={"gyro_x": mixture(rng, tau0=0.01, duration=2000.0)})
    record = simulate(model, duration=2000.0, rate=100, rng=int(rng.integers(1 << 60)))
    x = record.streams[0].column("gyro_x")
    assert not find_spikes(x).any()
    assert dense_spikes(x, 0.0) is None
    assert not has_hidden_spikes(x, 0.0)


FILTERS = {
    **{f"order {k}, {f} Hz": butter(k, f / 50, output="sos") for k in (1, 2, 4) for f in (0.3, 1, 3, 20)},
    **{f"mean of {k}": (np.ones(k) / k, [1.0]) for k in (2, 20, 200)},
    **{f"exponential, {t} s": ([1.0], [1, -np.exp(-1 / RATE / t)]) for t in (0.02, 0.5)},
}


def filtered(name, n=60_000):
    """White noise behind a filter, of one standard deviation; three axes."""
    x = white(f"filtered {name}", 6 * n).reshape(3, -1)
    x = (sosfilt(FILTERS[name], x) if name.startswith("order") else lfilter(*FILTERS[name], x))[:, n:]
    return x / x.std()


@pytest.mark.parametrize("name", FILTERS)
def test_filtered_noise_loses_no_sample(name):
    """Medians do not follow the extremes of smooth noise, which looked like spikes; its numbers rest there when rounded."""
    rng = np.random.default_rng(seed_of(f"filtered in steps {name}"))
    slow = np.cumsum(rng.normal(size=60_000)) / 3e3
    columns = dict(zip(("gyro_x", "gyro_y", "gyro_z"), filtered(name) + np.outer([0, 1, 30], slow), strict=True))
    step = {c: np.std(np.diff(y)) * 10 ** rng.uniform(-2, 0.7) for c, y in columns.items()}
    for each in (columns, {c: np.round(y / step[c]) * step[c] for c, y in columns.items()}):
        assert [one.cause for one in disturbances(Record.from_arrays(rate=RATE, **each).streams[0])] == []


@pytest.mark.parametrize(("name", "height"), [("order 2, 1 Hz", 1.5), ("order 4, 3 Hz", 2), ("order 1, 1 Hz", 10)])
def test_spikes_in_filtered_noise_are_found(name, height):
    x, at = filtered(name)[0], np.arange(0, 60_000, 997)
    x[at] += height * np.where(np.arange(len(at)) % 2, 1, -1)
    x[-1] += 20
    found = find_spikes(x)
    assert found[at].all()
    assert found[-1]
    assert np.count_nonzero(found) < 1.2 * len(at)  # few neighbours of them


def test_a_change_of_level_and_a_knock_are_no_spikes():
    x = white("level")
    x[N // 2 :] += 50
    x[30_000:30_200] *= 40
    assert not find_spikes(x).any()


def test_a_spike_beside_gaps_and_at_the_ends():
    x = white("gaps", 5000)
    at = [0, 1000, 2000, 4999]
    x[at] += 40
    x[[999, 1998, 1999, 2001]] = np.nan
    assert np.flatnonzero(find_spikes(x)).tolist() == at


@pytest.mark.parametrize("share", [0.005, 0.02, 0.05, 0.2])
@pytest.mark.parametrize(("height", "signs"), [(20.0, 2), (1e3, 1)])
def test_many_spikes(share, height, signs):
    """Up to a fifth of all samples."""
    n = 60_000
    x = white(f"many {share} {height} {signs}", n)
    rng = np.random.default_rng(seed_of(f"many places {share} {height} {signs}"))
    planted = rng.random(n) < share
    y = x.copy()
    y[planted] += height * rng.choice([-1.0, 1.0][2 - signs :], planted.sum())
    found, finding = found_in(y)
    assert np.count_nonzero(found & ~planted) <= 1e-3 * planted.sum()  # the last of a few good samples among bad ones
    assert np.count_nonzero(planted & ~found) <= (0.02 if share > 0.1 else 0.001) * planted.sum()
    assert finding.severity == "warning"
    assert finding.details.share == pytest.approx(found.mean())


@pytest.mark.parametrize(
    ("count", "height", "signs"),
    [
        (500, 7, 2),
        (2000, 6, 2),
        (5000, 6, 2),
        (5000, 8, 2),
        (10_000, 8, 1),
        (10_000, 10, 2),
        (20_000, 8, 1),
        (20_000, 10, 2),
    ],
)
def test_many_small_spikes_are_found_by_their_hump(count, height, signs):
    """Each alone could be one of noise in a long record, or of its scale; together they are not, and the rest is the noise.

    Of those 6 standard deviations high 5 % are below a threshold of 4.3 and add 0.05·share·16 of the variance; of the
    others next to none. A variance of n samples has an error of √(2/n), and so have the products of noise and spikes.
    """
    x = white(f"hump {count} {height} {signs}")
    rng = np.random.default_rng(seed_of(f"hump places {count} {height} {signs}"))
    planted = np.zeros(N, dtype=bool)
    planted[rng.choice(N, count, replace=False)] = True
    y = x.copy()
    y[planted] += height * rng.choice([-1.0, 1.0][2 - signs :], count)
    found, finding = found_in(y)
    assert np.count_nonzero(found & ~planted) <= 0.02 * count
    missed = 0.07 if height == 6 else 0.005
    assert np.count_nonzero(planted & ~found) <= missed * count + 3 * np.sqrt(missed * count)
    kept = float(np.var(y[~found]) / np.var(x))
    assert kept == pytest.approx(1.0, abs=missed * count / N * 16 + 0.002)
    assert finding.details.count == np.count_nonzero(found)


HEAVY = {
    "Laplace": lambda rng: rng.laplace(size=N),
    "Student of 5": lambda rng: rng.standard_t(5, N),
    "swells": lambda rng: rng.normal(size=N) * np.where(np.arange(N) // 5000 % 4 == 0, 10, 1),
    "bursts": lambda rng: rng.normal(size=N) * np.where(np.arange(N) % 1000 < 40, 10, 1),
    "counts": lambda rng: np.round(rng.normal(size=N) * 1.3),
    "walk": lambda rng: np.cumsum(rng.normal(size=N)),
    "levels": lambda rng: rng.normal(size=N) + 20 * (np.arange(N) // 300 % 2),
}


@pytest.mark.parametrize("name", HEAVY)
def test_noise_that_swells_or_has_heavy_tails_has_no_hump(name):
    """Only what is beyond the threshold of single samples may be found, as before: no tail that thins out is cut off."""
    x = HEAVY[name](np.random.default_rng(seed_of(f"heavy {name}")))
    assert dense_spikes(x, 1.0 if name == "counts" else 0.0) is None


def test_a_number_of_spikes_that_stay_in_the_noise_is_a_lower_bound():
    """5000 of 5 standard deviations are half of a hump: those that are found are few, and it is said that there are more."""
    x = white("lower bound")
    at = np.random.default_rng(seed_of("lower bound places")).choice(N, 5000, replace=False)
    x[at] += 5
    x[1000] += 40
    ((finding, _),) = spikes(Record.from_arrays(rate=RATE, signal=x).streams[0])
    assert finding.details.more_below
    one = white("no lower bound")
    one[1000] += 40
    ((finding, _),) = spikes(Record.from_arrays(rate=RATE, signal=one).streams[0])
    assert not finding.details.more_below


def test_one_is_placed():
    x = white("few")
    x[1000] += 20
    ((finding, _),) = spikes(Record.from_arrays(rate=RATE, signal=x).streams[0])
    assert finding.details.count == 1
    assert finding.details.time == 10.0


@pytest.mark.parametrize("kind", ["rate", "increments", "accumulated"])
def test_masked_spikes_leave_the_rest_as_it_was(kind):
    x = white("masked", 20_000).reshape(-1, 2)
    x[5000, 0] += 100
    raw = x / RATE if kind != "rate" else x
    if kind == "accumulated":
        raw = np.concatenate((np.zeros((1, 2)), np.cumsum(raw, axis=0)))
    record = Record.from_arrays(rate=RATE, input=kind, gyro_x=raw[:, 0], gyro_y=raw[:, 1])
    stream, findings = without(record.streams[0])
    assert [(f.code, f.channel, f.severity, f.left_out) for f in findings] == [("spikes", "gyro_x", "info", 1)]
    y = stream.column("gyro_x")
    assert np.flatnonzero(np.isnan(y)).tolist() == [5000]
    assert np.argwhere(stream.mask).tolist() == [[5000, 0]]
    there = np.isfinite(y)
    assert y[there] == pytest.approx(x[there, 0], rel=1e-12, abs=1e-11)
    assert stream.column("gyro_y") == pytest.approx(x[:, 1], rel=1e-12, abs=1e-11)
    assert record.streams[0].mask is None  # the record given is as it was
    assert without(stream)[1] == []
    (kept,) = without(record.streams[0], keep=["spikes"])[1]
    assert (kept.severity, kept.left_out) == ("warning", 0)


def test_without_spikes_the_record_is_the_same():
    stream = Record.from_arrays(rate=RATE, gyro_x=white("same", 1000)).streams[0]
    assert without(stream)[0] is stream


def test_counts_of_a_mapped_file_are_masked_in_a_copy():
    x = np.round(white("counts", 4000) * 50).astype(np.int16)
    x[7] = 30_000
    stream = Record.from_arrays(rate=RATE, gyro_x=x).streams[0]
    columns = Columns((x,), (Transform(scale=0.01, factor=0.5),), 1 / RATE)
    masked, _ = without(replace(stream, samples=columns))
    assert np.isnan(masked.column("gyro_x")[7])
    assert x[7] == 30_000


@pytest.mark.parametrize("share", [0.7, 0.85, 0.9, 0.97])
def test_where_most_samples_are_missing_noise_makes_no_spike(share):
    """Thousands before, from a scale of nothing; nor is a neighbour of a spike one."""
    rng = np.random.default_rng(seed_of(f"sparse {share}"))
    for _ in range(5):
        x = rng.standard_normal(60_000)
        x[rng.random(len(x)) < share] = np.nan
        assert not find_spikes(x).any()
        there = np.flatnonzero(np.isfinite(x))
        # With two neighbours on either side.
        near = np.convolve(np.isfinite(x), np.ones(5), "same")
        at = int(there[np.argmax(near[there])])
        x[at] += 30
        found = np.flatnonzero(find_spikes(x))
        assert set(found.tolist()) <= {at}
        assert share > 0.9 or found.tolist() == [at]
