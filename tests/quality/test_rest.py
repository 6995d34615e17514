"""Whether a record is at rest: short forms of studies/rest.py, the parts that are analysed, and real records."""

import json

import numpy as np
import pytest
from studies import false_alarms
from studies.motions import KINDS, handled, moving
from studies.real_records import RECORDS as AT_REST
from studies.rest import DISTURBED, at_rest, verdict
from studies.runner import seed_of

import sigmatau as st
from sigmatau.cli import main
from sigmatau.errors import DataError
from sigmatau.findings.rest import AssumedAtRest, NotAtRest, PartlyAtRest
from sigmatau.quality.selection.window import choose


def of(analysis, kind):
    (found,) = [finding for finding in analysis.findings if isinstance(finding.details, kind)]
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_moving_records(kind):
    """Of 204 in the study none is at rest; one of each kind here."""
    assert verdict(moving(seed_of(f"moving {kind} 0"), kind)).verdict == "not_at_rest"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sensors", ["gyro", "accel"])
def test_moving_records_of_one_sensor(kind, sensors):
    assert verdict(moving(seed_of(f"moving {kind} {sensors}"), kind, sensors=sensors)).verdict == "not_at_rest"


@pytest.mark.parametrize("kind", [*false_alarms.GRADES, *DISTURBED])
def test_records_at_rest(kind):
    found = verdict(at_rest(seed_of(f"at rest {kind}"), kind, "20 min at 50 Hz"))
    assert (found.verdict, found.motion) == ("at_rest", None)
    assert found.still == ((0.0, 1200.0),)


@pytest.fixture(scope="module")
def walk():
    return moving(seed_of("not at rest"), "walk")


@pytest.fixture(scope="module")
def analysis(walk):
    return st.analyze(walk)


class TestNotAtRest:
    def test_there_are_curves_and_no_coefficients(self, analysis):
        assert analysis.rest.verdict == "not_at_rest"
        assert set(analysis.curves) == {f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"}
        assert not analysis.fits
        assert not analysis.read_off
        assert "not at rest: no coefficients" in analysis.summary()
        assert of(analysis, NotAtRest).severity == "error"
        assert analysis.plot() is not None

    def test_there_is_nothing_to_use(self, analysis):
        for use in (
            lambda: analysis.model,
            lambda: analysis.export(to="kalibr"),
            lambda: st.compare_with(analysis, "icm42688p"),
            lambda: st.compare_with(st.Analysis.from_json(analysis.to_json()), "icm42688p"),
        ):
            with pytest.raises(DataError, match="not at rest"):
                use()

    def test_motion_can_be_analysed_as_noise(self, walk):
        found = st.analyze(walk, at_rest=True, method="read-off")
        assert found.read_off
        assert found.rest.verdict == "not_at_rest"
        assert of(found, AssumedAtRest).severity == "info"

    def test_by_the_command_line(self, walk, tmp_path, capsys):
        log, result, export = tmp_path / "walk.csv", tmp_path / "walk.json", tmp_path / "imu.yaml"
        st.write(walk, log)
        options = ["--rate", str(walk.streams[0].grid.rate), "--unit", "gyro=rad/s,accel=m/s^2"]
        assert main(["analyze", str(log), *options, "--json", str(result), "--export", f"kalibr={export}"]) == 5
        told = capsys.readouterr().err
        assert "not at rest" in told
        assert "nothing to export" in told
        assert not export.exists()
        content = json.loads(result.read_text())
        assert content["rest"]["verdict"] == "not_at_rest"
        assert all("fit" not in channel and not channel["read_off"] for channel in content["channels"].values())
        for command in (
            ["export", str(result), "--to", "kalibr"],
            ["compare", str(result)],
            ["predict", str(result), "--after", "60s"],
            ["plan", str(result), "--term", "bias_instability"],
        ):
            assert main(command) == 1
            assert "not at rest" in capsys.readouterr().err
        assert main(["analyze", str(log), str(tmp_path / "walk.csv"), *options]) == 2
        second = tmp_path / "second.csv"
        second.write_bytes(log.read_bytes())
        assert main(["analyze", str(log), str(second), *options, "-q"]) == 5
        assert capsys.readouterr().out.count("not at rest") == 12


def test_ten_seconds_of_handling_are_left_out():
    """The gyros keep the rest of the record; the accelerometers too if the position is the same."""
    record, (start, stop) = handled(seed_of("handled"), "MEMS", minutes=20)
    found = st.analyze(record, method="read-off")
    assert found.rest.verdict == "partly_at_rest"
    details = of(found, PartlyAtRest).details
    ((begins, ends),) = details.moved
    assert start - 4 <= begins <= start + 2
    assert stop - 2 <= ends <= stop + 4
    gyro = next(one for one in details.kept if one.stream == "gyro")
    assert gyro.share > 0.98
    assert gyro.left_out == pytest.approx(ends - begins, abs=0.1)


def test_a_record_that_is_picked_up_at_its_end_is_cut():
    record = at_rest(seed_of("picked up"), "consumer MEMS", "20 min at 50 Hz")
    away = moving(seed_of("taken away"), "walk")
    n = 300 * 50
    taken = {}
    for name in record.channels:
        x = away.stream_of(name).column(name)
        taken[name] = np.concatenate([record.stream_of(name).column(name), np.resize(x[:: round(len(x) / n) or 1], n)])
    found = st.analyze(st.Record.from_arrays(rate=50, **taken), method="read-off")
    assert found.rest.verdict == "partly_at_rest"
    ((begins, ends),) = found.rest.still
    assert begins == 0
    assert 1190 <= ends <= 1201
    assert {curve.n for curve in found.curves.values()} == {round(ends * 50)}
    assert of(found, PartlyAtRest).severity == "warning"


def test_another_position_is_not_joined():
    """The level of the accelerometers changes by 1 degree: theirs is the longest stretch, the gyros keep both."""
    base = at_rest(seed_of("turned"), "consumer MEMS", "20 min at 50 Hz")
    columns = {name: base.stream_of(name).column(name).copy() for name in base.channels}
    some = slice(20_000, 20_500)
    rng = np.random.default_rng(seed_of("turned by hand"))
    for name, x in columns.items():
        x[some] += np.cumsum(rng.standard_normal(500)) * (0.02 if name.startswith("gyro") else 0.1)
    columns["accel_x"][20_500:] += 9.8 * np.sin(np.radians(1))
    found = st.analyze(st.Record.from_arrays(rate=50, **columns), method="read-off")
    kept = {one.stream: one for one in of(found, PartlyAtRest).details.kept}
    assert kept["gyro"].share > 0.98
    assert kept["accel"].start >= 409
    assert kept["accel"].stop == 1200
    assert kept["accel"].left_out == 0


@pytest.mark.parametrize("length", [1, 3, 9, 10, 11, 21, 45, 100, 500])
def test_white_noise_is_not_motion_however_much_it_is(length):
    rng = np.random.default_rng(seed_of(f"white {length}"))
    for _ in range(8):
        y = rng.standard_normal((50 * length, 6))
        expected = "at_rest" if length >= 10 else "too_short_to_tell"
        assert verdict(st.Record.from_arrays(rate=50, gyro=y[:, :3], accel=9.8 * y[:, 3:])).verdict == expected


def test_knocks_are_not_motion():
    """A knock of a second, and spikes in 1 % of the samples."""
    base = at_rest(seed_of("knocked"), "consumer MEMS", "20 min at 50 Hz")
    rng = np.random.default_rng(seed_of("knocks"))
    columns = {}
    for name in base.channels:
        x = base.stream_of(name).column(name).copy()
        x[30_000:30_050] += (0.1 if name.startswith("gyro") else 3.0) * rng.standard_normal(50)
        at = rng.random(len(x)) < 0.01
        x[at] += 50 * np.std(np.diff(x[:1000])) * rng.standard_normal(at.sum())
        columns[name] = x
    assert verdict(st.Record.from_arrays(rate=50, **columns)).verdict == "at_rest"


def test_a_constant_rotation_is_motion():
    base = at_rest(seed_of("rotates"), "consumer MEMS", "20 min at 50 Hz")
    columns = {name: base.stream_of(name).column(name) for name in base.channels if name.startswith("gyro")}
    columns["gyro_z"] = columns["gyro_z"] + np.radians(30)
    found = verdict(st.Record.from_arrays(rate=50, **columns))
    assert (found.verdict, found.motion.kind) == ("not_at_rest", "turns")
    assert found.motion.size == pytest.approx(np.radians(30), rel=0.01)


RECORDS = {
    "dataflash_171.bin": {"topic": "IMU"},
    "moving_1khz.csv.gz": {
        "channels": {"time": 2, "accel": "3:5", "gyro": "6:8"},
        "unit": {"time": "s", "gyro": "rad/s", "accel": "g"},
    },
    "many_positions.log": {
        "rate": 100,
        "channels": {"accel": "1:3", "gyro": "4:6"},
        "unit": {"accel": "m/s^2", "gyro": "rad/s"},
    },
}


@pytest.mark.parametrize("name", RECORDS)
def test_real_records_that_move(field_data, name):
    """In flight, in someone's hands, and turned by hand every 3 to 8 s: no coefficients."""
    found = st.analyze(st.read(field_data / "field" / name, **RECORDS[name]))
    assert found.rest.verdict == "not_at_rest"
    assert not found.fits
    assert not found.read_off
    if name == "dataflash_171.bin":
        ((start, stop),) = found.rest.still  # on the ground, before take-off
        assert 15 < start < 20
        assert 65 < stop < 72
    else:
        assert not found.rest.still


@pytest.mark.parametrize("name", AT_REST)
def test_real_records_at_rest(field_data, name):
    """Whatever disturbs them: bumps and people near the VN-100, lines, a first row of zeros, coarse steps."""
    assert verdict(st.read(field_data / name, **AT_REST[name])).verdict == "at_rest"


def sound(fitted):
    for term in fitted.terms.values():
        if term.observed:
            assert term.low < term.value < term.high
            assert term.low * term.high > 0


@pytest.mark.parametrize(("name", "channel"), [("dataflash_171.bin", "gyro_y"), ("many_positions.log", "accel_z")])
def test_observed_terms_have_sound_intervals(field_data, name, channel):
    """Motion analysed as noise; random walks with an interval from 0 on, and with the estimate at its end, before."""
    record = st.read(field_data / "field" / name, **RECORDS[name])
    record = st.Record(streams=(record.stream_of(channel).only(channel),))
    sound(st.analyze(record, at_rest=True).fits[channel])


@pytest.mark.parametrize("kind", ["car", "hand"])
def test_observed_terms_of_least_squares_have_sound_intervals(kind):
    """Terms at 0 were called observed."""
    record = choose(moving(seed_of(f"odd {kind}0"), kind), ":60s")[0]
    for fitted in st.analyze(record, at_rest=True, method="gls").fits.values():
        sound(fitted)
