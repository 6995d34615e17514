"""All findings together, as a user meets them: by `analyze`, `inspect` and the command line."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from studies import false_alarms

from known import seed_of
from sigmatau import NoiseModel, OptionError, Record, analyze, check, fit, inspect, read, simulate
from sigmatau.cli import main
from sigmatau.estimators.allan import allan
from sigmatau.hints import Hint

N = 0.005
RATE = 100.0


def told(findings, code):
    return [finding for finding in findings if finding.code == code]


def sensor(case, terms, *, n=2**16, rate=RATE):
    """One channel of simulated noise."""
    model = NoiseModel(channels={"gyro_x": terms})
    return simulate(model, duration=n / rate, rate=rate, rng=seed_of(case)).streams[0].column("gyro_x").copy()


class TestCleanRecords:
    def test_few_clean_records_have_a_warning(self):
        """The fast version of studies/false_alarms.py, which holds 300 records; 5 % are allowed."""
        warned = total = 0
        for k, grade in enumerate(false_alarms.GRADES):
            length = "20 min at 50 Hz"
            record = false_alarms.record(seed_of(f"clean {grade} {length} {k}"), grade, length, gravity=k % 2 == 0)
            warned += any(f.severity != "info" for f in analyze(record, threads=1).findings)
            total += 1
        assert warned / total <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / total)

    @pytest.mark.parametrize("n", [4, 5, 17, 63, 64, 65, 200, 1000])
    def test_short_records(self, n):
        """Whatever is said of them, nothing crashes and nothing is wrong with white noise."""
        x = np.random.default_rng(seed_of(f"short {n}")).standard_normal((n, 3)) * 1e-3
        found = check(Record.from_arrays(rate=100.0, gyro=x, accel=x))
        assert not [finding for finding in found if finding.severity == "error"]
        analyze(Record.from_arrays(rate=100.0, gyro=x))


class TestField:
    """What each set is known for, from `analyze` and `inspect` alone."""

    def test_hfi(self, field_data):
        log = field_data / "hfi" / "imu_data.txt.gz"
        how = {
            "channels": {"time": 1, "gyro": "2:4", "accel": "5:7"},
            "unit": {"time": "s", "gyro": "rad/s", "accel": "m/s^2"},
        }
        found = analyze(read(log, **how)).findings
        (rate,) = told(found, "rate_not_nominal")
        assert rate.details.rate == pytest.approx(9.86, abs=0.005)
        (unit,) = told(found, "implausible_unit")
        assert unit.details.correction == Hint("unit", "accel", "g")
        # With a rate typed by hand, 10 or 100 as its configuration files have it.
        (mismatch,) = told(analyze(read(log, rate=10, **how), method="read-off").findings, "rate_mismatch")
        assert dict(mismatch.factors)["random_walk"] == pytest.approx(math.sqrt(9.8626 / 10), rel=1e-3)
        with pytest.raises(OptionError, match=r"give 9\.862.* Hz, which contradicts `rate=100`"):
            read(log, rate=100, **how)

    def test_mpu6050(self, field_data):
        found = inspect(field_data / "mpu6050_10min.npz", unit={"time": "s"})
        assert found.record.streams[0].grid.rate == pytest.approx(99.3, abs=0.05)
        (bursts,) = told(found.findings, "host_stamps")
        assert bursts.severity == "warning"
        assert bursts.size == pytest.approx(0.75, abs=0.005)
        assert bursts.details.median_rate == pytest.approx(491, abs=0.5)


class TestTraps:
    """Rows of the survey of tools in use, through the whole tool: a fault is planted, the finding seen, its effect right."""

    def test_a_rate_typed_by_hand(self, tmp_path):
        """114 Hz said of 125 Hz: N is √1.1 … and so on, each as stated."""
        true, given = 125.0, 114.0
        x = sensor("typed rate", {"random_walk": N}, rate=true)
        log = tmp_path / "log.csv"
        t = np.arange(len(x)) / true
        np.savetxt(
            log, np.column_stack([t, x]), delimiter=",", header="time [s],gyro_x [rad/s]", comments="", fmt="%.9g"
        )
        analysis = analyze(read(log, rate=given))
        (finding,) = told(analysis.findings, "rate_mismatch")
        fitted = analysis.fits["gyro_x"]["random_walk"]
        stated = dict(finding.factors)["random_walk"]
        assert stated == pytest.approx(math.sqrt(true / given), rel=1e-3)
        assert fitted.value == pytest.approx(stated * N, abs=3 * (fitted.high - fitted.low) / 3.92)

    def test_duplicated_samples_with_stamps_of_their_own(self, tmp_path):
        """Each message twice in the log, under the same stamp: the copies go, and the random walk is the sensor's."""
        x = sensor("copies", {"random_walk": N})
        t = np.round(np.arange(len(x)) / RATE, 6)
        rows = np.repeat(np.column_stack([t, x]), 2, axis=0)
        log = tmp_path / "log.csv"
        np.savetxt(log, rows, delimiter=",", header="time [s],gyro_x [rad/s]", comments="", fmt="%.9g")
        analysis = analyze(read(log))
        assert told(analysis.findings, "bad_stamps")
        assert analysis.curves["gyro_x"].n == len(x)
        fitted = analysis.fits["gyro_x"]["random_walk"]
        assert fitted.value == pytest.approx(N, abs=3 * (fitted.high - fitted.low) / 3.92)

    def test_an_internal_low_pass(self):
        """30 Hz at 200 Hz: the random walk read at one sample is 0.52 of the sensor's own; that of the fit is not."""
        rate, corner = 200.0, 30.0
        decay = math.exp(-2 * math.pi * corner / rate)
        x = lfilter([1 - decay], [1, -decay], sensor("low-pass", {"random_walk": N}, rate=rate, n=2**17))
        analysis = analyze(Record.from_arrays(rate=rate, gyro_x=x))
        (finding,) = told(analysis.findings, "low_pass_filter")
        assert finding.severity == "info"
        assert analysis.curves["gyro_x"].adev[0] / (N * math.sqrt(rate)) == pytest.approx(0.52, abs=0.02)
        fitted = analysis.fits["gyro_x"]["random_walk"]
        assert fitted.low < N < fitted.high
        assert fitted.value == pytest.approx(N, rel=0.02)

    def test_decimation_without_averaging_is_told_where_the_bandwidth_is_stated(self):
        """400 Hz to 100 Hz: N × 2. The samples alone cannot show it; the sensor's bandwidth, 400 Hz being white, does."""
        x = sensor("decimated", {"random_walk": N}, rate=400.0, n=2**18)[::4]
        record = Record.from_arrays(rate=100.0, gyro_x=x)
        assert not told(check(record), "aliasing")
        (finding,) = told(check(record, bandwidth={"gyro": (200.0, None)}), "aliasing")
        assert finding.severity == "warning"
        fitted = fit(allan(record)["gyro_x"])["random_walk"]
        assert fitted.value / N == pytest.approx(2.0, rel=0.02)
        assert 1.5 < dict(finding.factors)["random_walk"] < 2.6

    def test_bias_instability_and_walk_that_are_not_there(self):
        """The valley that N and K make is no B; K is not read where nothing rises."""
        analysis = analyze(Record.from_arrays(rate=RATE, gyro_x=sensor("white only", {"random_walk": N})))
        for term in ("bias_instability", "rate_random_walk"):
            assert analysis.fits["gyro_x"][term].observed is False
        assert "rate_random_walk" not in analysis.read_off["gyro_x"]


class TestOptions:
    def test_command_line(self, tmp_path, capsys):
        x = sensor("command line", {"random_walk": N}, n=40_000)
        log = tmp_path / "log.csv"
        np.savetxt(log, x, header="gyro_x [rad/s]", comments="", fmt="%.9g")
        figure, result = tmp_path / "map.png", tmp_path / "r.json"
        options = ["--rate", "100", "--window", "20s:380s", "--bandwidth", "gyro=30Hz"]
        code = main(["analyze", str(log), *options, "--stability", str(figure), "--json", str(result)])
        err = capsys.readouterr().err
        assert code == 0
        assert figure.stat().st_size > 5_000
        assert "30 Hz" in err
        content = json.loads(result.read_text())
        channel = content["channels"]["gyro_x"]
        assert channel["samples"] == 36_000
        assert len(channel["stability"]["adev"]) == len(channel["stability"]["time_s"]) > 5
        assert any(finding["code"] == "aliasing" and finding["factors"] for finding in content["findings"])
        assert main(["inspect", str(log), "--rate", "100", "--bandwidth", "gyro=30Hz/1"]) == 0
        out = capsys.readouterr().out
        assert "warning: gyro_x: sampled at 100 Hz, 3.3 times the stated bandwidth of 30 Hz" in out
        assert "random walk 13 % too large" in out

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["--bandwidth", "gyro=0Hz"], "30Hz/2"),
            (["--bandwidth", "gyro=fast"], "30Hz/2"),
            (["--bandwidth", "mag=3Hz"], "mag"),
            (["--bandwidth", "gyro=30Hz/99"], "30Hz/2"),
            (["--window", "9h:10h"], "window"),
            (["--window", "most-stable"], "window"),
            (["--window", "calm=2h"], "window"),
        ],
    )
    def test_wrong_options(self, tmp_path, capsys, options, words):
        log = tmp_path / "log.csv"
        np.savetxt(log, sensor("wrong", {"random_walk": N}, n=1000), header="gyro_x [rad/s]", comments="")
        assert main(["analyze", str(log), "--rate", "100", *options]) == 2
        assert words in capsys.readouterr().err

    def test_wrong_arguments(self):
        record = Record.from_arrays(rate=1.0, gyro_x=np.arange(100.0) % 7)
        with pytest.raises(OptionError, match="keep"):
            analyze(record, keep="cut")
        with pytest.raises(OptionError, match="stability"):
            analyze(record).plot_stability()


class TestAwkward:
    """Records that reviewers found to crash or mislead."""

    def test_every_second_sample_missing(self):
        for k in range(2):
            x = sensor(f"alternating {k}", {"random_walk": N, "bias_instability": 5e-5}, n=20_000)
            x[::2] = np.nan
            analyze(Record.from_arrays(rate=RATE, gyro_x=x))

    @pytest.mark.parametrize("pattern", [[0.0, 1.0], [0.0, 1.0, 0.0, -1.0]])
    def test_signals_that_repeat_themselves(self, pattern):
        analyze(Record.from_arrays(rate=RATE, foo=np.tile(pattern, 5000)))
        analyze(Record.from_arrays(rate=RATE, gyro_x=np.tile(pattern, 5000)))

    @pytest.mark.parametrize("at", [20, 500, 30_000])
    def test_a_spike_is_no_tilt(self, at):
        x = sensor(f"one spike {at}", {"random_walk": N / 50, "bias_instability": 5e-5}, n=60_000)
        x[at] += 3.0
        found = check(Record.from_arrays(rate=RATE, gyro_x=x))
        assert told(found, "spikes")
        assert not told(found, "not_static")

    def test_bandwidths_of_channels(self):
        x = np.stack([sensor(f"of channels {k}", {"random_walk": N}, n=20_000) for k in range(3)], axis=1)
        record = Record.from_arrays(rate=RATE, gyro=x)
        stated = told(check(record, bandwidth={"gyro_x": (30.0, 1), "gyro_y": (1000.0, 1)}), "aliasing")
        factors = {finding.channel: dict(finding.factors)["random_walk"] for finding in stated}
        assert factors == {"gyro_x": pytest.approx(1.131, abs=1e-3), "gyro_y": pytest.approx(5.605, abs=1e-3)}

    def test_a_map_of_a_short_log_is_left_out(self, tmp_path, capsys):
        log = tmp_path / "log.csv"
        np.savetxt(log, sensor("short map", {"random_walk": N}, n=100), header="gyro_x [rad/s]", comments="")
        assert (
            main(["analyze", str(log), "-v", "--rate", "100", "--at-rest", "--stability", str(tmp_path / "s.png")]) == 0
        )
        assert "no stability map" in capsys.readouterr().err
        assert not (tmp_path / "s.png").exists()


BOUNDED = """
import sys
from pathlib import Path
from sigmatau import analyze, read

def status(name):
    return next(int(line.split()[1]) for line in Path("/proc/self/status").read_text().splitlines() if line[:5] == name)

options = {"rate": 100, "channels": {"gyro_x": 1}, "unit": {"gyro": "rad/s"}, "input": "rate"}
analyze(read(sys.argv[2], **options), long="strided", threads=1)  # what is imported counts before
Path("/proc/self/clear_refs").write_text("5")
before = status("VmHWM")
analysis = analyze(read(sys.argv[1], **options), long="strided", threads=1)
print(status("VmHWM") - before, *(f.code for f in analysis.findings))
"""


@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="the system does not tell the peak of memory")
def test_a_record_longer_than_memory_is_checked_in_part(tmp_path):
    """In bounded memory the checks look at the beginning, and say so: 8 million values take less than twice their column."""
    rng = np.random.default_rng(seed_of("longer than memory"))
    np.save(tmp_path / "long.npy", np.tile(rng.standard_normal((1 << 20, 1)) * 1e-3, (8, 1)))
    np.save(tmp_path / "short.npy", rng.standard_normal((1 << 20, 1)) * 1e-3)
    command = [sys.executable, "-c", BOUNDED, str(tmp_path / "long.npy"), str(tmp_path / "short.npy")]
    grown, *codes = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert int(grown) * 1024 < 8 * (1 << 23) + 8 * (1 << 23)  # a column, and the pages of the file that are mapped
    assert {"strided", "checked_in_part"} <= set(codes)
