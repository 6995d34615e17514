"""Rest of short records: too short to tell, or motion whatever the length; short forms of studies/rest_windows.py."""

import json
from collections import Counter
from importlib import resources

import jsonschema
import numpy as np
import pytest
from studies.motions import held, moving
from studies.rest_windows import CLASSES, MOTIONS, clean, judge_real, judge_windows, verdict

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import DataError
from sigmatau.findings.rest import TooShortToTell
from sigmatau.quality.selection.rest import shortest_length

AT_REST = ("at_rest", "partly_at_rest")


def still(seconds, *, rate=100.0, name="still", **parts):
    """White noise of a consumer MEMS with gravity; `parts` are added to its sensors."""
    rng = np.random.default_rng(seed_of(name))
    n = round(seconds * rate)
    gyro = np.radians(0.05) * rng.standard_normal((n, 3)) + parts.get("gyro", 0.0)
    accel = 0.02 * rng.standard_normal((n, 3)) + np.array([0.0, 0.0, 9.8]) + parts.get("accel", 0.0)
    return st.Record.from_arrays(rate=rate, gyro=gyro, accel=accel)


@pytest.mark.parametrize("kind", MOTIONS)
def test_windows_of_moving_records(kind):
    """Windows of 3 to 20 s in which a gyro swings by 6 deg/s: none is at rest."""
    counts = sum((Counter(one) for one in judge_windows(seed_of(f"windows {kind}"), kind, 1).values()), Counter())
    assert not [one for one in AT_REST if counts[one]]
    if kind != "ship":  # which seldom swings as fast
        assert counts["not_at_rest"] > 3


def test_windows_of_real_records(field_data):
    """Each twelfth window of the study."""
    counts = {name: sum(by_length.values(), Counter()) for name, by_length in judge_real(field_data, stride=12).items()}
    if not counts:
        pytest.skip("no moving records")
    assert {name: count for name, count in counts.items() if count["at_rest"] or count["partly_at_rest"]} == {}
    assert sum(count["not_at_rest"] for count in counts.values()) > 17


@pytest.mark.parametrize("grade", CLASSES)
def test_clean_records(grade):
    """At most 0.5 % of 2016 are refused in the study; none of two here."""
    rng = np.random.default_rng(seed_of(f"clean {grade}"))
    assert {verdict(clean(int(rng.integers(1 << 62)), grade)).verdict for _ in range(2)} == {"at_rest"}


@pytest.mark.parametrize(
    ("quantities", "rate", "shortest"),
    [
        (["angular_rate", "acceleration"], 100.0, 10.0),
        (["angular_rate"], 1000.0, 10.0),
        (["acceleration"], 100.0, 20.0),
        (["angular_rate"], 1.0, 150.0),
        (["acceleration"], 0.1, 1500.0),
        (["temperature"], 1.0, 0.0),
    ],
)
def test_the_shortest_record(quantities, rate, shortest):
    assert shortest_length(quantities, 1 / rate) == pytest.approx(shortest)


@pytest.mark.parametrize(
    ("seconds", "expected"), [(2, "too_short_to_tell"), (9.8, "too_short_to_tell"), (9.95, "at_rest")]
)
def test_a_record_at_rest_by_its_length(seconds, expected):
    assert verdict(still(seconds)).verdict == expected


def test_missing_samples_do_not_count():
    y = np.array(still(12).streams[0].column("gyro_x"))
    y[200:600] = np.nan
    found = verdict(st.Record.from_arrays(rate=100, gyro_x=y))
    assert found.verdict == "too_short_to_tell"
    assert (found.duration, found.shortest) == (pytest.approx(8.0), 10.0)


def test_other_quantities_are_not_judged():
    x = np.random.default_rng(seed_of("other")).standard_normal(300)
    record = st.Record.from_arrays(rate=100, unit={"pressure": "Pa"}, pressure=x)
    assert verdict(record).verdict == "at_rest"


class TestTooShort:
    def test_in_python(self):
        found = st.analyze(still(4))
        assert (found.rest.verdict, found.rest.shortest) == ("too_short_to_tell", 10.0)
        assert not found.fits
        assert not found.read_off
        (finding,) = [one for one in found.findings if isinstance(one.details, TooShortToTell)]
        assert (finding.severity, finding.details.duration) == ("error", 4.0)
        assert "too short to tell rest from motion: no coefficients" in found.summary()
        for use in (lambda: found.model, lambda: st.compare_with(found, "icm42688p")):
            with pytest.raises(DataError, match="too short to tell"):
                use()

    def test_by_the_command_line(self, tmp_path, capsys):
        log, result, export = tmp_path / "short.csv", tmp_path / "short.json", tmp_path / "imu.yaml"
        st.write(still(4), log)
        options = ["--rate", "100", "--unit", "gyro=rad/s,accel=m/s^2"]
        assert main(["analyze", str(log), *options, "--json", str(result), "--export", f"kalibr={export}"]) == 5
        told = capsys.readouterr()
        assert "too short to tell rest from motion: 4 s, 10 s needed; no coefficients are given" in " ".join(
            told.err.split()
        )
        assert "nothing to export: too short to tell" in " ".join(told.err.split())
        content = json.loads(result.read_text())
        schema = json.loads(resources.files("sigmatau").joinpath("schema/result-2.schema.json").read_text())
        jsonschema.validate(content, schema)
        assert content["rest"] == {"verdict": "too_short_to_tell", "still_s": [], "motion": None, "shortest_s": 10.0}
        assert main(["export", str(result), "--to", "kalibr"]) == 1
        assert "too short to tell" in capsys.readouterr().err
        assert main(["analyze", str(log), *options, "--at-rest", "--export", f"kalibr={export}", "-v"]) == 0
        told = capsys.readouterr()
        assert "analysed as at rest, as requested" in " ".join(told.err.split())
        assert export.exists()
        assert main(["inspect", str(log), *options]) == 0
        assert "too short to tell" in "".join(capsys.readouterr())

    def test_by_watch(self, tmp_path, capsys):
        log = tmp_path / "short.csv"
        st.write(still(4), log)
        options = ["--rate", "100", "--unit", "gyro=rad/s,accel=m/s^2", "--idle", "1ms"]
        assert main(["watch", str(log), *options]) == 5
        assert "too short to tell rest from motion: 4 s, 10 s needed" in capsys.readouterr().err
        assert main(["watch", str(log), *options, "--at-rest"]) == 0


@pytest.mark.parametrize("sensors", ["both", "gyro"])
def test_a_phone_held_still(sensors):
    """Its tremor has the random walk of a bad gyro, 7 to 16 deg/√h, and is white beside its peak."""
    for k in range(3):
        found = verdict(held(seed_of(f"held {sensors} {k}"), seconds=30, sensors=sensors))
        assert found.verdict == "not_at_rest"


@pytest.mark.parametrize("corner", [None, 20.0])
def test_a_wrong_unit_is_not_motion(corner):
    """Gyros in deg/s read as rad/s are as loud as a hand; their noise is white, or that of a low-pass filter."""
    rng = np.random.default_rng(seed_of(f"wrong unit {corner}"))
    y = 0.2 * rng.standard_normal((100 * 600, 3))
    if corner is not None:
        f = np.fft.rfftfreq(len(y), 0.01)[:, None]
        y = np.fft.irfft(np.fft.rfft(y, axis=0) / np.sqrt(1 + (f / corner) ** 4), len(y), axis=0)
    record = st.Record.from_arrays(rate=100, gyro=y)
    assert verdict(record).verdict == "at_rest"
    assert "implausible_unit" in {finding.code for finding in st.check(record)}


@pytest.mark.parametrize("unit", [1.0, 9.80665])
def test_a_slow_tilt_is_motion(unit):
    """Accelerometers alone that turn by 10 deg a minute, in m/s² and in g read as m/s²."""
    n = 100 * 120
    angle = np.radians(10 / 60) * np.arange(n) / 100
    turned = 9.8 * np.column_stack([np.sin(angle), 0 * angle, np.cos(angle) - 1])
    accel = still(120, accel=turned).streams[1]
    columns = {c: accel.column(c) / unit for c in accel.channels}
    found = verdict(st.Record.from_arrays(rate=100, **columns))
    assert (found.verdict, found.motion.kind) == ("not_at_rest", "tilts")
    assert found.motion.size == pytest.approx(np.radians(10), rel=0.2)


def test_accelerometers_without_gravity_do_not_tilt():
    rng = np.random.default_rng(seed_of("linear acceleration"))
    assert verdict(st.Record.from_arrays(rate=100, accel=0.02 * rng.standard_normal((6000, 3)))).verdict == "at_rest"


@pytest.mark.parametrize("rate", [0.5, 0.1, 0.02])
def test_slow_rates(rate):
    """Averaged logs: white noise and drift are at rest; motion is not, whatever the unit of time."""
    rng = np.random.default_rng(seed_of(f"slow {rate}"))
    n = 2000
    drift = np.cumsum(rng.standard_normal((n, 3)), axis=0)
    assert verdict(st.Record.from_arrays(rate=rate, gyro=np.radians(1e-3) * drift)).verdict == "at_rest"
    away = moving(seed_of(f"slow moving {rate}"), "car", rate=40, minutes=1)
    columns = {c: away.stream_of(c).column(c) for c in away.channels}
    assert verdict(st.Record.from_arrays(rate=rate, **columns)).verdict == "not_at_rest"


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns", "min", "h"])
def test_a_drive_in_any_unit_of_time(field_data, unit, capsys):
    log = field_data / "cases" / "car_drive.csv"
    if not log.exists():
        pytest.skip(f"{log} is absent")
    code = main(["analyze", str(log), "--unit", f"time={unit},gyro=rad/s,accel=m/s^2"])
    assert code in (1, 2, 5), capsys.readouterr()


def test_a_phone_turned_by_hand(field_data, capsys):
    log = field_data / "cases" / "moving_phone_5s_xyz.csv"
    if not log.exists():
        pytest.skip(f"{log} is absent")
    assert main(["analyze", str(log), "--channels", "time=1,gyro=2:4"]) == 5
    assert "not at rest" in capsys.readouterr().err
