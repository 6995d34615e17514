"""Stretches that are left out: missing, at the times that findings name, and said."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze, inspect
from sigmatau.cli import main
from sigmatau.errors import OptionError
from sigmatau.quality.check import check
from sigmatau.quality.samples.dropouts import dropouts
from sigmatau.quality.selection.exclusion import from_the_start, leave_out
from sigmatau.quality.selection.window import cut

RATE = 100.0


def white(name, n=30_000):
    rng = np.random.default_rng(seed_of(name))
    gyro = 2e-4 * rng.standard_normal((n, 3))
    accel = 5e-3 * rng.standard_normal((n, 3)) + [0.1, -0.2, 9.8]
    return gyro, accel


def record_of(gyro, accel):
    return Record.from_arrays(rate=RATE, gyro=gyro, accel=accel)


@pytest.mark.parametrize(
    ("text", "first", "stop"),
    [
        ("12s:13.5s", 1200, 1350),
        (":10s", 0, 1000),
        ("0:10s", 0, 1000),
        ("0.1min:7s", 600, 700),
        ("290s:", 29000, 30000),
    ],
)
def test_these_samples_are_missing(text, first, stop):
    record, (said,) = leave_out(record_of(*white("these")), text)
    for stream in record.streams:
        assert np.flatnonzero(stream.mask.any(axis=1)).tolist() == list(range(first, stop))
        assert np.isnan(stream.column(stream.channels[0])[first:stop]).all()
        assert np.isfinite(np.delete(stream.column(stream.channels[0]), np.s_[first:stop])).all()
    assert [(s.stream, s.count, s.samples) for s in said.details.streams] == [
        (name, stop - first, 30_000) for name in ("gyro", "accel")
    ]
    assert said.spans == ((first / RATE, stop / RATE),)
    assert (said.code, said.severity) == ("left_out", "info")


def test_several_and_repeated():
    record, _ = leave_out(record_of(*white("several")), ["1s:2s,5s:6s", "9s:10s"])
    assert int(record.streams[0].mask[:, 0].sum()) == 300


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("5:7s", "not a time with a unit"),
        ("7s:5s", "before it begins"),
        ("700s:701s", "300 s long"),
        ("5s", "not understood"),
        (":", "not understood"),
        ("", "nothing"),
        ("0:300s", "leaves 0 samples"),
        ("zeros", "not understood"),
    ],
)
def test_what_cannot_be_left_out(text, word):
    with pytest.raises(OptionError, match=word):
        leave_out(record_of(*white("cannot")), text)


def test_times_count_from_the_beginning_of_the_whole_record():
    whole = from_the_start(record_of(*white("whole")))
    late, _ = leave_out(cut(whole, "100s:"), "120s:121s")
    assert np.flatnonzero(late.streams[0].mask[:, 0]).tolist() == list(range(2000, 2100))
    both = analyze(whole, window="100s:", leave_out="120s:121s", method="read-off")
    assert both.curves["gyro_x"].missing == 100


def knocked(name, at=15_000, ring=100):
    gyro, accel = white(name)
    t = np.arange(ring) / RATE
    for samples, size in ((gyro, 0.05), (accel, 1.0)):
        samples[at : at + ring] += size * (np.exp(-t / 0.2) * np.sin(2 * np.pi * 14 * t))[:, None]
    return gyro, accel


def test_a_knock_is_left_out_and_the_random_walk_is_that_of_the_sensor():
    """The log of one sensor shows it; it is left out of both, with a second on either side."""
    gyro, accel = knocked("knock")
    accel[:] = white("knock")[1]
    analysis = analyze(record_of(gyro, accel))
    (said,) = analysis.findings
    assert (said.code, said.severity, said.channels) == ("not_static", "info", ("gyro_x", "gyro_y", "gyro_z"))
    assert said.message.endswith("left out on all axes")
    assert [analysis.curves[c].missing for c in ("gyro_x", "accel_z")] == [said.left_out] * 2
    assert said.left_out == 300
    walk = analysis.fits["gyro_x"]["random_walk"]
    # 30 000 samples: 1/√(2·30 000) = 0.4 % of N, three of them and half a per cent for what the fit knows less well
    assert walk.value == pytest.approx(2e-5, rel=0.018)


def test_what_is_to_be_kept_is_a_warning_and_in_the_curve():
    gyro, accel = knocked("kept")
    gyro[100, 0] += 1.0
    for keep, missing, codes in (
        ("all", 0, {"not_static", "spikes"}),
        ("spikes", 300, {"spikes"}),
        (["shocks", "stuck"], 1, {"not_static"}),
    ):
        analysis = analyze(record_of(gyro, accel), keep=keep, method="read-off")
        assert analysis.curves["gyro_x"].missing == missing
        assert {f.code for f in analysis.findings if f.severity == "warning"} >= codes
        assert all(f.code not in codes or not f.left_out for f in analysis.findings)
    with pytest.raises(OptionError, match="must be all or some of"):
        analyze(record_of(gyro, accel), keep="spike")


def test_one_of_two_spikes_is_kept_by_its_time():
    gyro, accel = white("two spikes")
    gyro[[10_000, 20_000], 0] += 1.0
    record = record_of(gyro, accel)
    first, second = (f"{at / RATE}s:{(at + 1) / RATE}s" for at in (10_000, 20_000))
    spans = analyze(record, method="read-off").mask("gyro_x").spans
    assert [span.start for span in spans] == [10_000, 20_000]
    for keep, left in (
        (first, [20_000]),
        ([second], [10_000]),
        (f"{first},{second}", []),
        (f"shocks,{first}", [20_000]),
    ):
        assert [span.start for span in analyze(record, keep=keep, method="read-off").mask("gyro_x").spans] == left
    for wrong in ("5s:4s", "a:b", ":"):
        with pytest.raises(OptionError, match="keep"):
            analyze(record, keep=wrong)


def test_a_knock_is_kept_on_all_sensors_by_its_time():
    gyro, accel = knocked("knock")
    record = record_of(gyro, accel)
    stretches = analyze(record, method="read-off").mask("accel_z").columns()
    kept = analyze(record, keep=f"{stretches['start_s'][0]}s:{stretches['stop_s'][-1]}s", method="read-off")
    assert not kept.mask("gyro_x").spans
    assert not kept.mask("accel_z").spans


def test_stuck_samples_and_their_times():
    gyro, accel = white("stuck")
    gyro[20_000:20_150, 1] = gyro[20_000, 1]
    analysis = analyze(record_of(gyro, accel), method="read-off")
    (said,) = analysis.findings
    assert (said.code, said.channels, said.spans) == ("stuck_samples", ("gyro_y",), ((200.0, 201.5),))
    assert analysis.curves["gyro_y"].missing == said.left_out == 150
    assert analysis.curves["gyro_x"].missing == 0


def test_a_disturbed_record_keeps_its_findings_in_bounded_memory():
    """Missing samples need all of the record in memory."""
    gyro, accel = white("bounded")
    gyro[20_000:20_150, 1] = gyro[20_000, 1]
    analysis = analyze(record_of(gyro, accel), long="strided", method="read-off")
    (said,) = (f for f in analysis.findings if f.code == "stuck_samples")
    assert (said.severity, said.left_out) == ("warning", 0)


@pytest.mark.parametrize("row", [0, 15_234])
def test_a_single_row_of_zeros_is_left_out(row):
    gyro, accel = white(f"zero row {row}")
    gyro[row] = accel[row] = 0.0
    found = analyze(record_of(gyro, accel), method="read-off").findings
    assert {(f.code, f.left_out) for f in found} == {("dropout", 1)}
    assert [f.channels for f in found] == [("gyro_x", "gyro_y", "gyro_z"), ("accel_x", "accel_y", "accel_z")]


def test_an_outlier_of_a_billion_deviations_is_left_out():
    """It gave a wrong result that was called adequate."""
    gyro, accel = white("outlier")
    gyro[21_234, 2] = 2e5
    analysis = analyze(record_of(gyro, accel))
    assert [(f.code, f.channel, f.left_out) for f in analysis.findings] == [("spikes", "gyro_z", 1)]
    assert analysis.fits["gyro_z"]["random_walk"].value == pytest.approx(2e-5, rel=0.018)


def test_spikes_of_one_axis_do_not_hide_those_of_another():
    """A hundred in the first seconds of x, ten on y: the same rows are not theirs."""
    gyro, accel = white("spikes of two axes")
    gyro[10:1000:10, 0] += 1.0
    at = np.arange(2_500, 27_500, 2_500)
    gyro[at, 1] += 0.05
    analysis = analyze(record_of(gyro, accel), method="read-off")
    assert [(f.code, f.channel, f.left_out) for f in analysis.findings] == [
        ("spikes", "gyro_x", 99),
        ("spikes", "gyro_y", 10),
    ]


def zeros(name, count=40):
    gyro, accel = white(name)
    rng = np.random.default_rng(seed_of(f"{name}, where"))
    rows = rng.choice(len(gyro) - 2, count, replace=False)
    gyro[rows] = 0.0
    accel[rows] = 0.0
    return record_of(gyro, accel), np.sort(rows)


def test_scattered_zeros_are_one_kind_of_fault():
    """Lost rows and nothing else: no end of the range, no spikes, no common noise."""
    record, rows = zeros("zeros")
    found = check(record)
    assert {f.code for f in found} == {"dropout"}
    assert [f.channels for f in found] == [stream.channels for stream in record.streams]
    assert [f.details.samples for f in found] == [len(rows)] * 2
    for stream in record.streams:
        ((_, mask),) = dropouts(stream)
        for k in range(3):
            assert np.flatnonzero(mask[:, k]).tolist() == rows.tolist()
    analysis = analyze(record)
    assert [(f.code, f.left_out) for f in analysis.findings] == [("dropout", len(rows))] * 2


@pytest.mark.parametrize("bias", [5.0, 7.0, 10.0])
def test_zeros_beyond_the_tail_of_one_channel_are_no_end_of_its_range(bias):
    """One of a hundred rows lost of a gyro with a bias."""
    rng = np.random.default_rng(seed_of(f"zeros at {bias}"))
    x = rng.normal(bias, 1.0, 60_000)
    lost = rng.random(len(x)) < 0.01
    x[lost] = 0.0
    (finding,) = analyze(Record.from_arrays(rate=RATE, gyro_x=x * 1e-4), method="read-off").findings
    assert (finding.code, finding.left_out) == ("dropout", lost.sum())


@pytest.mark.parametrize("bias", [1.0, 2.5, 3.5])
@pytest.mark.parametrize("step", [0.0, 0.25])
def test_a_range_that_ends_at_zero_loses_nothing(bias, step):
    """Noise that is clipped at 0 leads there."""
    x = np.random.default_rng(seed_of(f"ends at zero {bias} {step}")).normal(bias, 1.0, 60_000)
    x = np.maximum(np.round(x / step) * step if step else x, 0.0)
    assert np.count_nonzero(x == 0) >= 3
    found = check(Record.from_arrays(rate=RATE, gyro_x=x * 1e-4))
    assert "dropout" not in {f.code for f in found}


def test_zeros_of_a_coarse_gyro_are_its_own():
    """Steps of three standard deviations about 0: most rows are zero, now and then, and always were."""
    gyro, accel = white("coarse")
    coarse = np.round(gyro / 6e-4) * 6e-4
    assert (coarse == 0).all(axis=1).mean() > 0.3
    found = check(Record.from_arrays(rate=RATE, gyro=coarse, accel=accel))
    assert "dropout" not in {f.code for f in found}


@pytest.mark.parametrize("steps", [0.5, 2.0, 10.0])
def test_common_noise_in_steps_makes_no_dropouts(steps):
    """Axes that share most of their noise are at 0 together far more often than independent ones."""
    rng = np.random.default_rng(seed_of(f"common {steps}"))
    for _ in range(8):
        common = rng.standard_normal(20_000)
        gyro = np.round(steps * (0.7 * common[:, None] + 0.7 * rng.standard_normal((20_000, 3))))
        found = check(Record.from_arrays(rate=RATE, unit={"gyro": "deg/s"}, gyro=gyro * 0.01))
        assert "dropout" not in {f.code for f in found}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    gyro, accel = knocked("log with a knock")
    table = np.column_stack([np.arange(len(gyro)) / RATE, gyro, accel])
    names = ["time [s]", *(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"accel_{a} [m/s^2]" for a in "xyz")]
    path = tmp_path_factory.mktemp("log") / "log.csv"
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.9g")
    return path


def test_the_command_line(log, capsys):
    assert main(["inspect", str(log), "--leave-out", "0s:1s"]) == 0
    assert "warning" not in (out := capsys.readouterr().out)
    assert "100 of 30000 samples" in out
    assert "shock at 150 s for 1 s; left out on all axes" in out
    options = ["--leave-out", "5s:6s", "--leave-out", "0:1s", "--window", "0:250s", "--method", "read-off", "-v"]
    assert main(["analyze", str(log), *options]) == 0
    captured = capsys.readouterr()
    assert "warning" not in captured.err
    assert "200 of 30000 samples" in captured.err
    assert main(["analyze", str(log), "--keep", "shocks,spikes", "--method", "read-off"]) == 0
    assert "! gyro: shock at 150 s for 1 s" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--window", "0:10"], "--window '0:10': '10' is not a time with a unit"),
        (["--window", "900s:"], "--window '900s:'"),
        (["--leave-out", "5:7s"], "--leave-out '5:7s': '5' is not a time"),
        (["--keep", "spike"], "--keep 'spike' must be all or some of start, dropouts"),
        (["--leave-out", "900s:901s"], "--leave-out '900s:901s' begins at 900 s; the record is 300 s long"),
    ],
)
def test_errors_name_the_option_as_it_is_typed(log, capsys, arguments, words):
    assert main(["analyze", str(log), *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "`" not in said


def test_in_python_inspect_takes_it_too(log):
    codes = [(f.code, bool(f.left_out)) for f in inspect(log, leave_out="0s:1s").checks]
    assert codes == [("left_out", False), ("not_static", True), ("not_static", True)]
    assert {f.severity for f in inspect(log, keep="all").checks if f.code == "not_static"} == {"warning"}
