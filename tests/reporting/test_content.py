"""What a report says, and the numbers of its charts."""

import base64
from dataclasses import replace

import numpy as np
import pytest
from report_records import NAMES, six_axes

import sigmatau as st
from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.record.mask import only_used
from sigmatau.reporting.charts import digits, packed
from sigmatau.reporting.content import collect_content
from sigmatau.reporting.envelope import envelope


@pytest.fixture(scope="module")
def record():
    return six_axes()


@pytest.fixture(scope="module")
def analysis(record):
    return st.analyze(record)


def unpacked(one):
    x = np.frombuffer(base64.b64decode(one["data"]), "<u2").astype(float)
    share = x / 65534
    return np.where(x == 65535, np.nan, one["low"] * (1 - share) + one["high"] * share)


def test_used_stretches_rebuild_what_was_analysed(record):
    cut = st.analyze(record, window="60s:660s", leave_out="100s:120s")
    assert cut.used["accel_y"].tolist() == [[60.0, 100.0], [120.0, 660.0]]
    spike = 43.21
    whole = st.analyze(record)
    assert any(first == pytest.approx(spike + 0.01, abs=0.02) for first in whole.used["gyro_x"][:, 0])
    again = st.allan(only_used(record, {channel: cut.masks[channel] for channel in cut.curves}))
    for name in NAMES:
        np.testing.assert_array_equal(again[name].avar, cut.curves[name].avar)


def test_a_record_that_is_another_one_is_refused(analysis):
    with pytest.raises(OptionError, match="shorter than the record"):
        collect_content(analysis, six_axes(hours=0.1))
    with pytest.raises(OptionError, match="no channel 'gyro_x'"):
        collect_content(analysis, st.Record.from_arrays(rate=100.0, other=np.arange(100.0)))
    with pytest.raises(TypeError, match="not a str"):
        collect_content(analysis, "log.csv")


def changed(record, name, change):
    """The record with other samples of a channel, or without it."""
    columns = {one: np.array(record.stream_of(one).column(one)) for one in record.channels}
    columns |= {name: change(columns[name])}
    return st.Record.from_arrays(rate=100.0, **{one: x for one, x in columns.items() if x is not None})


def test_other_samples_are_refused(record, analysis):
    assert (
        collect_content(analysis, changed(record, "accel_z", np.array)).charts
        == collect_content(analysis, record).charts
    )
    with pytest.raises(OptionError, match="not the record of the analysis"):
        collect_content(analysis, changed(record, "accel_z", lambda x: x * 1.001))
    with pytest.raises(OptionError, match="no channel 'gyro_y'"):
        collect_content(analysis, changed(record, "gyro_y", lambda _: None))
    with pytest.raises(OptionError, match="not the record of the analysis"):
        collect_content(analysis, six_axes(hours=0.3))


@pytest.mark.parametrize(
    "options",
    [
        {"window": "60s:660s", "leave_out": "100s:120s", "overlap": "none"}, {"long": "strided"},
        {"counting": "paper", "method": "read-off", "taus": [0.05, 1.0], "keep": "all"},
    ],
)  # fmt: skip
def test_the_record_of_any_analysis_is_its_own(record, options):
    assert "series" in collect_content(st.analyze(record, **options), record).charts["channels"]["gyro_x"]


def test_missing_ends_are_no_other_record(record):
    def without_ends(x):
        x[:300] = x[-500:] = np.nan
        return x

    cut = changed(record, "gyro_x", without_ends)
    assert "series" in collect_content(st.analyze(cut, taus=[0.05, 1.0]), cut).charts["channels"]["gyro_x"]


def test_sensors_that_begin_at_different_times(record):
    gyro, accel = record.streams
    late = replace(accel, grid=replace(accel.grid, start=gyro.grid.start + 20.0))
    both = replace(record, streams=(gyro, late))
    channels = collect_content(st.analyze(both, leave_out="100s:101s"), both).charts["channels"]
    assert channels["gyro_z"]["series"]["outside"] == [[100.0, 101.0]]
    assert channels["accel_x"]["series"]["outside"] == [[100.0, 101.0]]
    assert channels["accel_x"]["series"]["from"] == 20
    first = channels["accel_x"]["map"]
    assert first["times"][0] == pytest.approx(20 + first["window"] / 2)


def test_without_a_record_there_are_curves_only(analysis):
    charts = collect_content(analysis, None).charts
    assert set(charts["channels"]["gyro_x"]) == {"deviation"}
    assert set(collect_content(analysis, six_axes()).charts["channels"]["gyro_x"]) == {
        "deviation", "density", "map", "series",
    }  # fmt: skip


def test_curves_are_those_of_the_analysis(analysis):
    drawn = collect_content(analysis, None).charts["channels"]["accel_z"]["deviation"]
    curve, fitted = analysis.curves["accel_z"], analysis.fits["accel_z"]
    np.testing.assert_allclose(drawn["adev"], curve.adev, rtol=1e-4)  # five digits
    np.testing.assert_allclose(drawn["model"], np.sqrt(fitted.avar(m=curve.m)), rtol=1e-4)
    parts = sum(np.square(np.array(part)) for part in drawn["parts"].values())
    np.testing.assert_allclose(parts, fitted.avar(m=curve.m), rtol=1e-3)


def test_the_density_of_a_fit_is_that_of_its_noise(record, analysis):
    fitted = analysis.fits["gyro_y"]
    f = np.array([0.01, 1.0, 40.0])
    np.testing.assert_allclose(fitted.psd(f), analysis.model.channels["gyro_y"].psd(f, tau0=0.01), rtol=1e-9)


def test_every_spike_shows():
    """The largest of 200,000 samples is in the envelope of 300 bins, with the place of its bin."""
    rng = np.random.default_rng(1)
    x = rng.standard_normal(200_000)
    x[123_456], x[777] = 50.0, -40.0
    x[1000:3000] = np.nan
    (stream,) = st.Record.from_arrays(rate=100.0, gyro_x=x).streams
    low, high, edges = envelope(stream, "gyro_x", 300)
    assert high.shape == (300,)
    k = int(np.nanargmax(high))
    assert high[k] == 50.0
    assert edges[k] <= 123_456 < edges[k + 1]
    assert low[np.searchsorted(edges, 777, side="right") - 1] == -40.0
    assert np.isnan(low[2:4]).all()  # bins 2 and 3 are within the gap
    for j in (0, 100, 299):
        assert (low[j], high[j]) == (x[edges[j] : edges[j + 1]].min(), x[edges[j] : edges[j + 1]].max())


def test_few_samples_are_all_drawn():
    (stream,) = st.Record.from_arrays(rate=1.0, gyro_x=np.arange(7.0)).streams
    low, high, _ = envelope(stream, "gyro_x", 300)
    assert low.tolist() == high.tolist() == list(range(7))


@pytest.mark.parametrize("values", [[1.0, 2.0, np.nan, 3.5], [4.0], [np.nan], [1e308, -1e308], [5.0, 5.0]])
def test_packed_numbers(values):
    x = np.array(values)
    found = unpacked(packed(x))
    span = np.nanmax(x) / 65534 - np.nanmin(x) / 65534 if np.isfinite(x).any() else 0.0
    np.testing.assert_array_equal(np.isnan(found), np.isnan(x))
    with np.errstate(over="ignore", invalid="ignore"):
        assert np.isnan(x).all() or abs(x[0]) > 1e300 or np.nanmax(np.abs(found - x)) <= 0.51 * span + 1e-300


def test_digits_have_no_nan():
    assert digits([1.234567, np.nan, np.inf, 0.0]) == [1.2346, None, None, 0.0]


def test_left_out_samples_are_marked(record, analysis):
    outside = collect_content(analysis, record).charts["channels"]["gyro_x"]["series"]["outside"]
    assert any(start <= 43.21 <= stop + 0.01 for start, stop in outside)


def test_a_very_fine_curve_is_thinned(record):
    fine = st.analyze(record, taus="all", window="0s:60s")
    drawn = collect_content(fine, record).charts["channels"]["gyro_x"]["deviation"]
    assert len(drawn["tau"]) <= 240
    assert drawn["tau"][0] == 0.01


def test_what_was_done(analysis, record):
    done = dict(collect_content(analysis, record, command="sigmatau analyze a.csv --report r.html").done)
    fitted = "maximum likelihood of the spectrum; lines and filters that were found are in the model"
    assert fitted in done.values()
    assert done["Command"].endswith("r.html")
    assert done["Confidence level"] == "95 %"
    assert "0 s to 720 s" in done["Analysed"]


def test_a_dead_axis_and_a_thermometer_are_among_the_time_series():
    rng = np.random.default_rng(8)
    x = 1e-3 * rng.standard_normal((20_000, 3))
    x[:, 1] = 0.25
    record = st.Record.from_arrays(rate=100.0, gyro=x, temperature=20 + np.arange(20_000) / 1e4)
    channels = collect_content(st.analyze(record), record).charts["channels"]
    assert set(channels["gyro_y"]) == {"series"}
    assert channels["gyro_y"]["series"]["outside"] == [[0.0, 200.0]]
    assert channels["temperature"]["series"]["outside"] == []
    low = unpacked(channels["temperature"]["series"]["low"])
    assert (low[0], low[-1]) == (pytest.approx(20.0), pytest.approx(22.0, abs=0.01))


def test_notes(analysis):
    content = collect_content(analysis, None, notes={"serial number": "A123\n"})
    assert content.notes == (("serial number", "A123\\n"),)
    assert (content.title, content.file_name) == ("A123\\n", "Record in memory")
    assert collect_content(analysis, None, notes={"operator": "N. N."}).title == "Record in memory"


@pytest.mark.parametrize(
    ("name", "level", "columns"), [("quantization", 20.0, ("quantization",)), ("angle random walk", 0.02, ())]
)
def test_a_dominant_term_has_a_column(name, level, columns):
    rng = np.random.default_rng(seed_of(f"dominant {name}"))
    angle = np.diff(rng.standard_normal(8001)) * level
    record = st.Record.from_arrays(rate=100.0, gyro_x=(angle + rng.standard_normal(8000)) * 1e-4)
    overview = collect_content(st.analyze(record), None).overview
    assert overview.labels == ("random walk", "bias instability", "rate random walk", *columns)
    (sensor,) = overview.sensors
    assert len(sensor.units) == len(sensor.axes[0].coefficients) == len(overview.terms) == len(overview.labels)
