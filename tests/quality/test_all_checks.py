"""What holds for every check: no false alarm, no stumbling over gaps, constants, huge offsets or a handful of samples."""

from dataclasses import replace

import numpy as np
import pytest
from clean_records import check_samples as check
from clean_records import record, rounded

from known import seed_of
from sigmatau import Record
from sigmatau.noise.terms import TERMS
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples.disturbances import without
from sigmatau.quality.samples.masking import mask_from_spans, masked

RECORDS = 12
LIMIT = 0.001  # warnings a channel


def warnings_in(streams):
    return [finding for stream in streams for finding in check(stream) if finding.severity != "info"]


def at_most(channels):
    """The stated rate and three standard errors of it (Poisson)."""
    expected = LIMIT * channels
    return expected + 3 * expected**0.5


def test_clean_records_have_no_warnings():
    """Any mixture of the five terms, 10 to 400 Hz."""
    rng = np.random.default_rng(seed_of("clean records"))
    found = [f for _ in range(RECORDS) for f in warnings_in(record(rng, most=20_000).streams)]
    assert len(found) <= at_most(6 * RECORDS), "\n".join(map(str, found))


def test_rounded_records_have_none_but_of_their_coarse_steps():
    rng = np.random.default_rng(seed_of("rounded records"))
    found = []
    for _ in range(RECORDS):
        for stream in record(rng, most=20_000).streams:
            coarse = Record.from_arrays(rate=stream.grid.rate, **rounded(stream, rng))
            found += [f for f in warnings_in(coarse.streams) if f.code != "coarse_resolution"]
    assert len(found) <= at_most(6 * RECORDS), "\n".join(map(str, found))


def test_clean_records_with_gaps_have_none():
    rng = np.random.default_rng(seed_of("records with gaps"))
    found = []
    for _ in range(RECORDS // 3):
        for stream in record(rng, most=20_000).streams:
            columns = {c: np.array(stream.column(c)) for c in stream.channels}
            lost = rng.random(stream.grid.n) < 0.05
            begin = int(rng.integers(stream.grid.n))
            lost[begin : begin + int(60 * stream.grid.rate)] = True
            for x in columns.values():
                x[lost] = np.nan
            if lost.all():
                continue
            found += warnings_in(Record.from_arrays(rate=stream.grid.rate, **columns).streams)
    assert len(found) <= at_most(6 * RECORDS // 3), "\n".join(map(str, found))


SAMPLES = {
    "four": [1.0, 2.0, 4.0, 3.0],
    "four equal": [1.0] * 4,
    "five whole numbers": np.arange(5),
    "one value": np.zeros(5000),
    "all missing": np.full(5000, np.nan),
    "one there": np.concatenate((np.full(2500, np.nan), [1.0], np.full(2500, np.nan))),
    "every second missing": np.where(np.arange(5000) % 2, np.nan, np.sin(np.arange(5000.0) ** 2)),
    "two values": np.arange(5000) % 2,
    "half missing": np.concatenate((np.full(3000, np.nan), np.random.default_rng(1).normal(size=3000))),
    "tiny": np.random.default_rng(2).normal(size=5000) * 1e-150,
    "large": np.random.default_rng(3).normal(size=5000) * 1e100,
    "denormal": np.random.default_rng(4).normal(size=5000) * 1e-310,
    "offset": np.random.default_rng(5).normal(size=5000) + 1e12,
    "whole numbers": np.random.default_rng(6).integers(-(2**31), 2**31, 5000),
    "bytes": np.random.default_rng(7).integers(0, 255, 5000).astype(np.uint8),
    "flags": np.random.default_rng(8).random(5000) < 0.5,
    "a step": np.arange(5000) > 2000,
    "a line": np.arange(5000) * 0.1,
}


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize(
    ("sensor", "kind"),
    [("gyro", "rate"), ("accel", "rate"), ("signal", "rate"), ("gyro", "increments"), ("accel", "accumulated")],
)
def test_any_samples_are_taken(name, sensor, kind):
    x = SAMPLES[name]
    if kind == "accumulated":
        x = np.append(x, x[-1])
    names = [f"{sensor}_{axis}" for axis in "xyz"] if sensor != "signal" else ["signal"]
    (stream,) = Record.from_arrays(rate=100, input=kind, **dict.fromkeys(names, x)).streams
    with keep_facts():
        for finding in [*check(stream), *without(stream)[1]]:
            told(finding, stream)


def told(finding, stream):
    """Everything that a finding has to have."""
    assert finding.severity in ("info", "warning")
    assert set(finding.channels) <= set(stream.channels)
    assert finding.message
    assert finding.action or finding.severity == "info"
    assert set(dict(finding.factors)) <= set(TERMS)
    plain = finding.to_dict()
    values = [v for v in (plain.get("size"), *plain.get("changes", {}).values()) if v is not None]
    assert all(np.isfinite(v) for v in values), finding
    assert "nan" not in str(finding)


@pytest.mark.parametrize("offset", [0.0, 9.8, 1e3, -1e6])
def test_an_offset_changes_nothing(offset):
    """What is planted is found whatever the level; a million times the noise still leaves ten digits of it."""
    rng = np.random.default_rng(seed_of("offset"))
    x = rng.normal(size=20_000)
    x[5000] += 60
    x[9000:9100] = x[9000]
    x[15_000:] += 2
    found = [f.code for f in check(Record.from_arrays(rate=50, accel_x=x + offset).streams[0])]
    assert found == ["stuck_samples", "spikes", "not_static"]


def test_gain_changes_only_units():
    rng = np.random.default_rng(seed_of("gain"))
    x = np.repeat(rng.normal(size=20_000), 2)
    x[5001] += 60
    one, other = (check(Record.from_arrays(rate=50, signal=x * c).streams[0]) for c in (1.0, 1e-9))
    assert [f.code for f in one] == [f.code for f in other]
    for a, b in zip(one, other, strict=True):
        assert dict(a.factors) == pytest.approx(dict(b.factors), rel=1e-6)


def test_order_of_channels_does_not_matter():
    rng = np.random.default_rng(seed_of("order"))
    x = rng.normal(size=(20_000, 3))
    x[4000, 1] += 50
    x[9000:9100, 2] = 1.0
    stream = Record.from_arrays(rate=50, accel=x + np.array([0, 0, 9.8])).streams[0]
    turned = Record.from_arrays(rate=50, **{c: stream.column(c) for c in reversed(stream.channels)}).streams[0]
    assert sorted(map(str, check(stream))) == sorted(map(str, check(turned)))


def test_six_clean_axes_of_a_million_samples():
    rng = np.random.default_rng(seed_of("speed"))
    x = rng.normal(size=(1_000_000, 3)) * 1e-3
    streams = Record.from_arrays(rate=100, gyro=x, accel=np.round(x / 1e-4) * 1e-4 + [0, 0, 9.8]).streams
    assert [f for stream in streams for f in check(stream)] == []


def test_long_records_are_looked_at_whole_for_what_may_be_anywhere():
    x = np.random.default_rng(seed_of("long")).normal(size=4_400_000).astype(np.float32)
    x[4_321_000] += 40
    x[1_234_000:1_234_100] = x[1_234_000]
    stream = Record.from_arrays(rate=1000, signal=x).streams[0]
    assert [f.code for f in check(stream)] == ["stuck_samples", "spikes"]


def test_a_temperature_is_not_expected_to_rest():
    t = 30 + 5 * np.tanh(np.arange(20_000) / 3000) + 0.01 * np.random.default_rng(seed_of("t")).normal(size=20_000)
    stream = replace(Record.from_arrays(rate=10, temperature=t).streams[0], quantity="temperature", unit="degC")
    assert check(stream) == []


def accumulated(rates, *, step=None):
    """A log of the angle, in steps if they are given."""
    angle = np.concatenate((np.zeros((1, rates.shape[1])), np.cumsum(rates / 50, axis=0)))
    if step is not None:
        angle = np.round(angle / step) * step
    return Record.from_arrays(rate=50, gyro=angle, input="accumulated", unit={"gyro": "rad"})


class TestSamplesTakenForMissingOfAccumulatedValues:
    def test_one_of_them_is_a_rate_and_not_a_value(self):
        """Its neighbours, which share a value with it, stay; whether all of the log is read or a part."""
        rates = np.random.default_rng(seed_of("one rate")).normal(size=(1000, 3))
        stream = accumulated(rates).streams[0]
        mask = np.zeros((1000, 3), dtype=bool)
        mask[500, 0] = True
        without = masked(stream, mask)
        expected = np.where(mask, np.nan, rates)
        for k, channel in enumerate(without.channels):
            np.testing.assert_allclose(without.column(channel), expected[:, k], atol=1e-12)
            np.testing.assert_allclose(without.only(channel).column(channel), expected[:, k], atol=1e-12)
            np.testing.assert_allclose(without.cut(400, 600).column(channel), expected[400:600, k], atol=1e-12)
        assert masked(without, mask_from_spans(1000, [(-5, 3), (998, 2000)])).mask.sum() == 1 + 3 * 5
        assert stream.mask is None

    def test_their_step_is_still_one_of_the_angle(self):
        """As that of a rate it would be told as white noise, which it is not."""
        rates = np.random.default_rng(seed_of("step of the angle")).normal(size=(20_000, 3))
        plain = accumulated(rates, step=0.02).streams[0]
        (one,) = (f.details for f in check(plain) if f.code == "coarse_resolution" and f.channel == "gyro_x")
        assert one.rounding == "quantization"
        rates += (
            30 * (1 - np.exp(-np.arange(len(rates)) / 15))[:, None]
        )  # the way of a filter from zero, which is left out
        found = check(accumulated(rates, step=0.02).streams[0])
        assert "start_transient" in {f.code for f in found}
        (other,) = (f.details for f in found if f.code == "coarse_resolution" and f.channel == "gyro_x")
        assert (other.rounding, other.added) == (one.rounding, pytest.approx(one.added, rel=1e-9))

    def test_a_sensor_that_sticks_is_not_one_that_is_gone(self):
        """An angle that rests has a rate of 0: no dropout, with some of the log taken for missing or without."""
        rates = np.random.default_rng(seed_of("an angle that rests")).normal(size=(20_000, 3))
        rates[9000:9200] = 0
        stream = accumulated(rates).streams[0]
        for one in (stream, masked(stream, mask_from_spans(20_000, [(100, 110)]))):
            codes = {f.code for f in check(one)}
            assert "stuck_samples" in codes
            assert "dropout" not in codes
