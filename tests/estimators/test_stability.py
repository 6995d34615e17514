"""Dynamic Allan variance: what each window shows is what the window alone shows; where a change is, and when."""

import json

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, Record, RecordTooShortError, allan
from sigmatau.estimators.stability import dynamic_allan
from sigmatau.plot.stability import beyond_chance, relative

RATE = 10.0


def record(name, n=6000, change=None):
    x = np.random.default_rng(seed_of(name)).standard_normal(n)
    if change is not None:
        x[change:] *= 3
    return Record.from_arrays(rate=RATE, gyro_x=x, gyro_y=x[::-1].copy())


def test_each_row_is_the_curve_of_its_window():
    data = record("rows")
    dynamic = dynamic_allan(data, "gyro_y", window=100, step=30)
    y = data.streams[0].column("gyro_y")
    assert dynamic.adev.shape == (17, len(dynamic.tau))
    assert dynamic.times == pytest.approx(50 + 30 * np.arange(17))
    for k in (0, 5, 16):
        alone = allan(Record.from_arrays(rate=RATE, x=y[300 * k : 300 * k + 1000]), taus=dynamic.tau)["x"]
        assert np.array_equal(dynamic.adev[k], alone.adev)


def test_defaults_are_a_tenth_half_overlapping():
    dynamic = dynamic_allan(record("defaults"), "gyro_x")
    assert (dynamic.window, dynamic.step, dynamic.n) == (60.0, 30.0, 600)
    assert len(dynamic.times) == 19
    assert dynamic.tau[0] == 0.1
    assert 15 < dynamic.tau[-1] <= 20  # a third of the window


def test_a_change_is_where_it_is():
    """Noise three times as large from the middle on: windows wholly after it show three times the deviation."""
    dynamic = dynamic_allan(record("change", change=3000), "gyro_x", taus=[0.1])
    before = dynamic.adev[dynamic.times <= 270, 0]
    after = dynamic.adev[dynamic.times >= 330, 0]
    # 600 samples of white noise: edf 400 at m = 1, so 1/√(2·400) = 3.5 % a window.
    assert after / before.mean() == pytest.approx(3.0, rel=5 * 0.035)
    assert before / before.mean() == pytest.approx(1.0, rel=5 * 0.035)
    assert dynamic.spread[0] == pytest.approx(3.0, rel=6 * 0.035)


def test_a_gap_leaves_a_window_out():
    """If it is longer than a tenth of the window; a few samples less change nothing."""
    x = np.random.default_rng(seed_of("gap")).standard_normal(6000)
    x[3000:3070] = np.nan
    x[600] = np.nan
    dynamic = dynamic_allan(Record.from_arrays(rate=RATE, gyro_x=x), "gyro_x")
    missing = ~np.isfinite(dynamic.adev).all(axis=1)
    # Windows begin every 300 samples and have 600: those from 2700 and from 3000 on hold the gap.
    assert np.flatnonzero(missing).tolist() == [9, 10]
    assert "2 windows miss more than a tenth" in repr(dynamic)
    plain = json.loads(json.dumps(dynamic.to_dict(), allow_nan=False))
    assert plain["adev"][9] is None
    assert len(plain["adev"][0]) == len(plain["tau_s"])
    assert np.isfinite(dynamic.spread).all()


def test_stream_and_record_are_the_same():
    data = record("stream")
    assert np.array_equal(dynamic_allan(data.streams[0], "gyro_x").adev, dynamic_allan(data, "gyro_x", threads=1).adev)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"window": 601}, "longer than the record"),
        ({"window": 1}, "at least 16"),
        ({"window": float("nan")}, "positive number"),
        ({"window": 60, "step": 0}, "positive number"),
        ({"window": 60, "step": 0.1}, "at most 2000"),
        ({"window": 60, "taus": [31]}, "longest is 30"),
    ],
)
def test_refused(options, words):
    with pytest.raises(OptionError, match=words):
        dynamic_allan(record("refused"), "gyro_x", **options)


def test_too_short_and_unknown():
    with pytest.raises(RecordTooShortError, match="not make ten windows"):
        dynamic_allan(record("short", n=100), "gyro_x")
    with pytest.raises(KeyError, match="gyro_z"):
        dynamic_allan(record("short"), "gyro_z")
    with pytest.raises(KeyError, match="gyro_z"):
        dynamic_allan(record("short").streams[0], "gyro_z")


def test_map(tmp_path):
    pytest.importorskip("matplotlib")
    dynamic = dynamic_allan(record("map", n=60000, change=30000), "gyro_x")
    axes = dynamic.plot(unit="deg/s").axes[0]
    (mesh,) = axes.collections
    assert mesh.get_array().shape == dynamic.adev.T.shape
    medians = np.median(dynamic.adev, axis=0)
    shown, ratio = mesh.get_array(), (dynamic.adev / medians).T
    assert np.asarray(shown)[~shown.mask] == pytest.approx(ratio[~shown.mask])
    assert shown.mask.mean() < 0.9
    assert mesh.norm.vmin * mesh.norm.vmax == pytest.approx(1.0)  # the median is in the middle of the colours
    assert axes.get_yscale() == "log"
    assert type(mesh.norm).__name__ == "LogNorm"
    assert "[min]" in axes.get_xlabel()
    assert "hatched" not in axes.get_xlabel()
    colour_bar = axes.figure.axes[1]
    assert colour_bar.get_ylabel() == "σ(τ) over its median at that τ"
    axes.figure.savefig(tmp_path / "map.png")
    (beside,) = axes.child_axes
    assert "[deg/s]" in beside.get_ylabel()
    shown = [float(label.get_text()) for label in beside.get_yticklabels()]
    at = [int(np.argmin(np.abs(dynamic.tau - place))) for place in beside.get_yticks()]
    assert shown == pytest.approx(np.rad2deg(medians[at]), rel=5e-3)  # three digits


def test_a_small_change_of_the_noise_shows_in_the_map():
    """1.3 times from the middle on: half a third of the colours' range on either side; it was 6 % of one scale for all τ."""
    pytest.importorskip("matplotlib")
    rng = np.random.default_rng(seed_of("small change"))
    x = rng.standard_normal(60_000)
    x[30_000:] *= 1.3
    axes = dynamic_allan(Record.from_arrays(rate=100, gyro_x=x), "gyro_x").plot().axes[0]
    mesh = axes.collections[0]
    first = mesh.norm(np.asarray(mesh.get_array())[0])  # the shortest τ, 0 to 1 over the colours
    assert first[-5:].mean() - first[:5].mean() > 0.2


@pytest.mark.parametrize("walk", [False, True])
def test_what_chance_makes_is_white(walk):
    """At each averaging time, any window of 5 % of the maps of stationary noise; here of white noise and its sum."""
    rng = np.random.default_rng(seed_of(f"chance {walk}"))
    coloured = total = 0
    for _ in range(20):
        x = rng.standard_normal(8_000)
        x = np.cumsum(x) if walk else x
        found = dynamic_allan(Record.from_arrays(rate=100, gyro_x=x), "gyro_x")
        there = beyond_chance(relative(found.adev)[0], found)
        coloured, total = coloured + int(there.any(axis=0).sum()), total + there.shape[1]
    # Averaging times of a map are alike: as 20 maps, each with three independent ones at least. The median scatters too.
    assert coloured / total < 0.1 + 3 * np.sqrt(0.05 * 0.95 / 60)
    x = rng.standard_normal(8_000)
    x[4_000:] *= 1.5
    found = dynamic_allan(Record.from_arrays(rate=100, gyro_x=x), "gyro_x")
    assert beyond_chance(relative(found.adev)[0], found)[:, 0].mean() > 0.8


def test_windows_without_a_deviation_are_hatched_and_said_to_be():
    pytest.importorskip("matplotlib")
    rng = np.random.default_rng(seed_of("hatched"))
    x = rng.standard_normal(60_000)
    x[30_000:33_000] = np.nan
    axes = dynamic_allan(Record.from_arrays(rate=100, gyro_x=x), "gyro_x").plot().axes[0]
    (span,) = axes.patches
    assert span.get_hatch()
    assert span.get_x() <= 300 <= span.get_x() + span.get_width()
    assert "hatched: a tenth" in axes.get_xlabel()
