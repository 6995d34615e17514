"""All times that findings tell count from the beginning of the whole record, whatever part of it is analysed."""

from dataclasses import fields, is_dataclass, replace

import h5py
import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.findings.disturbances import NotStatic
from sigmatau.findings.drift import NonStationary
from sigmatau.findings.phrases import window_hint
from sigmatau.findings.rest import NotAtRest, PartlyAtRest
from sigmatau.findings.stamps import Gaps
from sigmatau.quality.check import check
from sigmatau.quality.motion.shocks_and_steps import between_steps, not_static
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.selection.window import cut
from sigmatau.record.record import make_stream

RATE, N = 100.0, 60_000
WINDOW = "100s:400s"
AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
_PLACES = ("start", "time", "largest_at", "smallest_at")


def white(name, n=N):
    rng = np.random.default_rng(seed_of(name))
    columns = {axis: (2e-4 if axis.startswith("gyro") else 5e-3) * rng.standard_normal(n) for axis in AXES}
    columns["accel_z"] += 9.8
    return columns, rng


def disturbed():
    """A spike, stuck samples, zeros, an end of the range, a knock, a step, and noise that grows, all within the window."""
    columns, rng = white("told times")
    columns["gyro_x"][12_345] += 1.0
    columns["gyro_y"][18_000:18_100] = columns["gyro_y"][18_000]
    for axis in "xyz":
        columns[f"accel_{axis}"][21_000:21_050] = 0.0
    columns["gyro_z"][24_000:24_100] = 2e-3
    for axis in "xyz":
        columns[f"accel_{axis}"][27_000:27_050] += 0.5 * rng.standard_normal(50)
    columns["accel_x"][31_000:] += 0.05
    columns["gyro_x"][33_000:] *= 2.0
    return st.Record.from_arrays(rate=RATE, **columns)


@pytest.fixture(scope="module")
def record():
    return disturbed()


@pytest.fixture(scope="module")
def both(record):
    return st.analyze(record), st.analyze(record, window=WINDOW)


def by_code(findings):
    told = {}
    for one in findings:
        told.setdefault((one.code, one.channels), []).append(one)
    return told


def places(details):
    """All times of day of details, by the name of the field, in their order."""
    if isinstance(details, tuple):
        return [one for part in details for one in places(part)]
    if not is_dataclass(details):
        return []
    found = []
    for one in fields(details):
        value = getattr(details, one.name)
        found += [(one.name, value)] if one.name in _PLACES else places(value)
    return found


EXACT = {  # by sample
    ("spikes", ("gyro_x",)): 123.45,
    ("stuck_samples", ("gyro_y",)): 180.0,
    ("dropout", ("accel_x", "accel_y", "accel_z")): 210.0,
    ("saturation", ("gyro_z",)): 240.0,
}


@pytest.mark.parametrize("kind", EXACT, ids=lambda kind: kind[0])
def test_of_samples(both, kind):
    for analysis in both:
        (one,) = by_code(analysis.findings)[kind]
        ((_, time),) = places(one.details)
        assert time == pytest.approx(EXACT[kind], abs=1.5 / RATE)  # a run may begin with the sample that it repeats
        assert one.spans[0][0] == pytest.approx(EXACT[kind], abs=1.5 / RATE)


def test_of_a_knock(both):
    for analysis in both:
        (one,) = (f for f in analysis.findings if isinstance(f.details, NotStatic) and f.details.bursts)
        (burst,) = one.details.bursts
        assert 269 <= burst.start <= 270.5 <= burst.stop <= 272  # windows of 1 s
        assert one.spans == ((burst.start, burst.stop),)


def test_of_a_step(both):
    for analysis in both:
        (one,) = (f for f in analysis.findings if isinstance(f.details, NotStatic) and f.details.steps)
        (step,) = one.details.steps
        assert step.time == pytest.approx(310, abs=step.uncertainty)
        assert one.spans == ((step.time, step.time),)
        assert one.details.keep[1] == pytest.approx(step.time - step.window)  # what the option `--window` counts


def test_of_a_change_of_noise(both):
    for analysis in both:
        (one,) = by_code(analysis.findings)[("non_stationary", ("gyro_x",))]
        assert isinstance(one.details, NonStationary)
        assert one.details.change.time == pytest.approx(330, abs=3)  # blocks of 0.6 s
        assert one.spans == ((one.details.change.time,) * 2,)
        if (segments := one.details.segments) is not None:
            assert segments.smallest_at < 330 < segments.largest_at + segments.length
            assert segments.smallest_at >= (0 if analysis is both[0] else 100)


def test_the_same_words(both):
    """Nothing but the effects and shares differ: whoever looks at the named time finds it."""
    for kind in EXACT:
        whole, part = (by_code(analysis.findings)[kind][0].message for analysis in both)
        assert f"{EXACT[kind]:.4g} s" in whole
        assert f"{EXACT[kind]:.4g} s" in part


def test_a_told_step_is_found_again(record):
    """The samples about a step are left out of the part, where they are."""
    part = cut(from_the_start(record), WINDOW).stream_of("accel_x").only("accel_x")
    (one,) = not_static(masked(part, np.arange(part.grid.n) // 5000 == 2))  # without the zeros and the knock
    (step,) = one.details.steps
    (missing,) = between_steps(part, [one]).mask.T
    gone = np.flatnonzero(missing)
    assert gone[0] <= 21_000 <= gone[-1] + 1
    assert len(gone) == pytest.approx(2 * step.uncertainty * RATE, abs=1)


def test_samples_and_times_are_each_others_inverse(record):
    grid = replace(record.streams[0].grid, lead=20.0)
    assert (grid.time(0), grid.time(150)) == (20.0, 21.5)
    assert [grid.sample(grid.time(k)) for k in (-3, 0, 12_345)] == [-3, 0, 12_345]


def test_a_part_at_rest():
    """Carried for 5 min: the part at rest begins then, and the spike is at 600 s of the log."""
    columns, rng = white("carried first", 120_000)
    for axis in AXES:
        columns[axis][:30_000] += np.cumsum(rng.standard_normal(30_000)) * (0.02 if axis.startswith("gyro") else 0.1)
    columns["gyro_y"][60_000] += 1.0
    log = st.Record.from_arrays(rate=RATE, **columns)
    for window, begins in (None, 0.0), ("100s:", 100.0):
        analysis = st.analyze(log, method="read-off", window=window)
        (part,) = (f for f in analysis.findings if isinstance(f.details, PartlyAtRest))
        assert {one.stop for one in part.details.kept} == {1200.0}
        assert part.spans == part.details.moved
        assert part.spans[0][0] == begins
        assert part.spans[-1][1] == pytest.approx(300, abs=5)  # a motion has a second more on either side
        for one in part.details.kept:
            assert one.start == pytest.approx(part.spans[-1][1], abs=1 / RATE)
        (spike,) = (f for f in analysis.findings if f.code == "spikes")
        assert spike.details.time == pytest.approx(600.0)
        assert analysis.used["gyro_x"][0, 0] == part.details.kept[0].start


def test_the_advised_window_is_at_rest():
    """At rest from 300 s to 360 s only: what the finding advises is that part, also if a window was analysed."""
    columns, _ = white("at rest in the middle", 120_000)
    t = np.arange(120_000) / RATE
    moves = (t < 300) | (t >= 360)
    for axis in AXES:
        columns[axis] += moves * (0.5 if axis.startswith("gyro") else 3.0) * np.sin(2 * np.pi * 0.3 * t)
    log = st.Record.from_arrays(rate=RATE, **columns)
    for window in None, "200s:1100s":
        (one,) = (f for f in st.analyze(log, window=window).findings if isinstance(f.details, NotAtRest))
        assert one.details.still[0] == (pytest.approx(300, abs=5), pytest.approx(360, abs=5))
        advised = window_hint(one.details.still[0]).value
        assert st.analyze(log, window=advised, method="read-off").rest.verdict == "at_rest"


def two_sensors():
    """The accelerometer begins 20 s later, by another clock, with a warm-up, and has a spike 30 s after its first sample."""
    columns, _ = white("one begins later", 40_000)
    gyro = {axis: columns[axis] for axis in AXES[:3]}
    accel = {axis: columns[axis][:30_000] for axis in AXES[3:]}
    accel["accel_y"][3000] += 1.0
    accel["accel_x"] += 0.1 * np.exp(-np.arange(30_000) / RATE / 30)
    accel["accel_z"][6000:6100] = np.nan
    first = make_stream("gyro", gyro, rate=RATE, unit={}, start=1000.0)
    return st.Record(streams=(first, make_stream("accel", accel, rate=RATE, unit={}, start=1020.0)))


def test_a_sensor_that_begins_later():
    log = two_sensors()
    (spike,) = (f for f in check(log) if f.code == "spikes")
    assert spike.details.time == spike.spans[0][0] == pytest.approx(50.0)
    analysis = st.analyze(log)
    (again,) = (f for f in analysis.findings if f.code == "spikes")
    assert (again.details, again.spans) == (spike.details, spike.spans)
    (warm,) = (f for f in analysis.findings if f.code == "warm_up")
    assert (warm.channels, warm.spans[0][0]) == (("accel_x",), 20.0)
    assert warm.spans[0][1] == pytest.approx(20 + 5 * warm.details.time_constant)
    assert st.analyze(log, method="read-off", stability=True).stability["accel_x"].times[0] == pytest.approx(20 + 15)


def test_windows_that_were_chosen():
    """The most stable window begins at its time in the record, not in its own stream."""
    log = two_sensors()
    streams = tuple(
        replace(one, samples=replace(one.samples, raw=tuple(np.nan_to_num(raw) for raw in one.samples.raw)), mask=None)
        for one in log.streams
    )
    analysis = st.analyze(replace(log, streams=streams), window="most-stable=200s", method="read-off")
    (one,) = (f for f in analysis.findings if f.code == "window_chosen")
    for window in one.details.windows:
        channel = f"{window.stream}_y"
        assert analysis.used[channel][0, 0] == pytest.approx(window.start, abs=1 / RATE)
    assert one.details.windows[1].start >= 20


def rows_of_two(tmp_path, late):
    """Rows of two sensors in one file; the accelerometer begins `late` seconds later and loses a second after 30 s."""
    rng = np.random.default_rng(seed_of("rows of two"))
    lines = [(k / RATE, *(f"{x:.6g}" for x in 1e-3 * rng.standard_normal(3)), "", "", "") for k in range(8000)]
    own = [k for k in range(5000) if not 3000 <= k < 3100]
    lines += [(late + k / RATE, "", "", "", *(f"{x:.6g}" for x in rng.standard_normal(3))) for k in own]
    path = tmp_path / "rows.csv"
    head = ["time [s]", *(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"accel_{a} [m/s^2]" for a in "xyz")]
    rows = [f"{time:.4f}," + ",".join(more) for time, *more in sorted(lines)]
    path.write_text("\n".join([",".join(head), *rows]) + "\n")
    return path


def test_gaps_of_a_sensor_that_begins_later(tmp_path):
    path = rows_of_two(tmp_path, 2.003)
    for findings in st.read(path).findings, st.inspect(path).findings:
        (gaps,) = (f for f in findings if isinstance(f.details, Gaps))
        assert gaps.channels == ("accel",)
        assert gaps.details.longest[0].start == gaps.spans[0][0] == pytest.approx(32.003, abs=1 / RATE)


def test_gaps_of_two_tables(tmp_path):
    """Two sensors with clocks in tables of their own: read or inspected."""
    path = tmp_path / "two.h5"
    rng = np.random.default_rng(seed_of("two tables"))
    times = 20 + np.delete(np.arange(5000), np.s_[3000:3100]) / RATE
    with h5py.File(path, "w") as file:
        file["g/t_s"], file["g/gyro"] = np.arange(8000) / RATE, 1e-3 * rng.standard_normal((8000, 3))
        file["a/t_s"], file["a/accel"] = times, rng.standard_normal((len(times), 3))
    unit = {"gyro": "rad/s", "accel": "m/s^2"}
    for findings in st.read(path, unit=unit).findings, st.inspect(path, unit=unit).findings:
        (gaps,) = (f for f in findings if isinstance(f.details, Gaps))
        assert gaps.details.longest[0].start == gaps.spans[0][0] == pytest.approx(50.0, abs=1 / RATE)
