"""Calibration from one log: windows, polynomial, hysteresis, compensation, and what is refused."""

import json
import re

import numpy as np
import pytest

from known import seed_of
from reporting.pdf_text import pages_of
from sigmatau import Record, calibrate_temperature, temperature_report
from sigmatau.errors import DataError, NotAtRestError, OptionError
from sigmatau.reporting import pdf
from temperature_logs import AXES, DEG_H, log, noise, ramp, steps

MEAN = (50.0, 5.0, 0.02, -4e-4)


@pytest.fixture(scope="module")
def cycle():
    record = log("cycle", ramp(27_000), rate=5.0, mean=MEAN, loop=40.0, bias_instability="3 deg/h")
    return calibrate_temperature(record, degree=3)


def test_polynomial_is_found_within_its_interval(cycle):
    polynomial = cycle["gyro_x"].polynomial
    assert (polynomial.reference, polynomial.degree) == (25.0, 3)
    # four standard errors: the seed is fixed, and the constant has the mean of the noise in it
    bias = polynomial.coefficients[1:] / DEG_H - MEAN[1:]
    assert (np.abs(bias) <= 2 * polynomial.errors[1:] / DEG_H).all()
    assert polynomial.coefficients[0] / DEG_H == pytest.approx(50, abs=5)
    assert (polynomial.low, polynomial.high) == pytest.approx((-40, 85), abs=0.1)


def test_hysteresis_is_that_of_the_loop(cycle):
    loop = cycle["gyro_x"].hysteresis
    assert loop.temperature[2] == pytest.approx(22.5, abs=1.5)  # blocks of 0.5 K
    assert loop.low[2] < 40 * DEG_H < loop.high[2]
    assert loop.low[2] > 0
    assert loop.mean_low < 40 * 2 / 3 * DEG_H < loop.mean_high


def test_windows_of_a_ramp_have_mean_and_noise(cycle):
    windows = cycle["gyro_x"].windows
    assert [w.branch for w in windows] == ["rising"] * 5 + ["falling"] * 5
    assert not any(w.held for w in windows)
    rising = [w.temperature for w in windows[:5]]
    assert rising == sorted(rising)
    for window in windows:
        walk = window.terms["random_walk"]
        assert walk.value == pytest.approx(0.3 * np.pi / 180 / 60, rel=0.1)
        assert window.low < window.mean < window.high
    assert cycle["gyro_x"].overall["random_walk"].value == pytest.approx(0.3 * np.pi / 180 / 60, rel=0.03)


def test_compensation_takes_the_drift_away(cycle):
    raw, compensated = cycle["gyro_x"].raw, cycle["gyro_x"].compensated
    assert raw.tau == pytest.approx(compensated.tau)
    k = int(np.argmax(raw.adev[20:])) + 20
    assert compensated.adev[k] < raw.adev[k] / 5
    assert compensated.adev[0] == pytest.approx(raw.adev[0], rel=1e-3)


def test_soaks_are_found_and_held(cycle):
    record = log("soaks", steps(21_600), rate=2.0, mean=MEAN)
    result = calibrate_temperature(record)["gyro_x"]
    assert all(window.held for window in result.windows)
    assert [round(window.temperature) for window in result.windows] == [-40, 0, 40, 85, 40, 0, -40]
    # The last soak of a direction belongs to it.
    assert [window.branch for window in result.windows] == ["rising"] * 4 + ["falling"] * 3
    for window in result.windows:
        truth = np.polynomial.polynomial.polyval(window.temperature - 25, MEAN) * DEG_H
        assert abs(window.mean - truth) < 3 * (window.high - window.mean)
    assert result.hysteresis is not None


def test_with_one_direction_the_hysteresis_is_not_observable():
    record = log("one way", np.linspace(-20, 60, 14_400), rate=2.0)
    result = calibrate_temperature(record)
    assert result["gyro_x"].hysteresis is None
    assert any("hysteresis is not observable" in remark for remark in result.remarks)


def test_several_sensors_and_units(tmp_path):
    record = log("six axes", ramp(7_200), rate=1.0, channels=AXES)
    result = calibrate_temperature(record, channels=["accel_z", "gyro"], degree=3, level=0.9)
    assert list(result) == ["accel_z", "gyro_x", "gyro_y", "gyro_z"]
    accel = result["accel_z"].polynomial
    assert accel.unit == "m/s^2"
    assert accel.coefficients[0] == pytest.approx(9.80665 + 50e-5, abs=5e-4)
    assert accel.coefficients[1] == pytest.approx(5e-5, abs=2 * accel.errors[1])
    assert json.dumps(result.to_dict(), allow_nan=False)
    rows = result.columns()
    assert len({len(column) for column in rows.values()}) == 1
    assert {"mean", "random_walk"} <= set(rows["term"])
    temperature_report(result, tmp_path / "page.html", command="<script>")
    page = (tmp_path / "page.html").read_text()
    assert "accel_x, accel_y is missing" in page
    assert '<script>"' not in page
    assert page.count("<svg") == 8


def test_disturbances_are_left_out_of_means_and_noise():
    temperature = ramp(18_000)
    clean = noise("spiky", 18_000, 5.0)["gyro_x"]
    spiky = clean.copy()
    places = np.random.default_rng(seed_of("spikes of a ramp")).integers(0, 18_000, 40)
    spiky[places] += 1.0
    results = [
        calibrate_temperature(Record.from_arrays(rate=5, temperature=temperature, gyro_x=x), degree=1)["gyro_x"]
        for x in (clean, spiky)
    ]
    first, second = (result.polynomial for result in results)
    assert np.abs(second.coefficients - first.coefficients).max() < 0.3 * first.errors[0]


def test_a_thermometer_in_steps_and_of_another_rate_serves():
    temperature = ramp(14_400)
    record = log("coarse", temperature, rate=2.0, mean=MEAN)
    coarse = np.round(ramp(720) * 2) / 2
    slow = Record.from_arrays(rate=0.1, unit={"temperature": "degC"}, temperature=coarse).streams[0]
    mixed = Record(streams=(record.stream_of("gyro_x"), slow))
    fine = calibrate_temperature(record, degree=3)["gyro_x"].polynomial
    steps_ = calibrate_temperature(mixed, degree=3)["gyro_x"].polynomial
    assert steps_.coefficients[1] == pytest.approx(fine.coefficients[1], rel=0.03)


def refused(record, words, error=DataError, **options):
    with pytest.raises(error, match=words) as caught:
        calibrate_temperature(record, **options)
    return caught.value


def test_refusals():
    moving = noise("refused", 6_000, 5.0)["gyro_x"]
    refused(Record.from_arrays(rate=5, gyro_x=moving), "no temperature column")
    still = Record.from_arrays(rate=5, gyro_x=moving, temperature=25 + 0.5 * np.sin(np.arange(6_000) / 900))
    refused(still, "varies by 1 K")
    refused(Record.from_arrays(rate=5, gyro_x=moving[:50], temperature=ramp(50)), "60")
    shaken = moving.copy()
    shaken[1000:5000] += 0.5 * np.sin(np.arange(4000) / 9)
    refused(Record.from_arrays(rate=5, gyro_x=shaken, temperature=ramp(6_000)), "at rest", NotAtRestError)
    good = log("refusals", ramp(6_000))
    refused(good, "1 to 5", OptionError, degree=6)
    refused(good, "1 to 5", OptionError, degree=True)
    refused(good, "outside the observed", OptionError, reference=90.0)
    refused(good, "gyro_y", OptionError, channels=["gyro_y"])
    refused(good, "0.5 to 0.999", OptionError, level=1.0)


def test_a_polynomial_is_not_extrapolated(cycle):
    polynomial = cycle["gyro_x"].polynomial
    with pytest.raises(OptionError, match="not extrapolated"):
        polynomial.values([25, 90])
    curve = polynomial.values([-40, 25, 85])
    assert curve.low[0] < curve.value[0] < curve.high[0]


def test_another_reference_is_the_same_polynomial(cycle):
    polynomial = cycle["gyro_x"].polynomial
    moved = polynomial.about(-10.0)
    t = np.linspace(-40, 85, 7)
    for name in ("value", "low", "high"):
        assert getattr(moved.values(t), name) == pytest.approx(getattr(polynomial.values(t), name), rel=1e-9, abs=1e-12)
    assert moved.about(25.0).covariance == pytest.approx(polynomial.covariance, rel=1e-6)


def test_printed(cycle):
    text = repr(cycle)
    assert "-40 to 85 °C, rising and falling, ramp" in text
    assert "hysteresis (falling - rising)" in text
    assert "cubic" in repr(cycle["gyro_x"].polynomial)
    assert cycle.plot().axes[0].get_ylabel() == "mean [deg/h]"
    with pytest.raises(OptionError, match="accel_x"):
        cycle.plot("accel_x")
    with pytest.raises(KeyError, match="gyro_x"):
        cycle["accel_x"]


def test_coverage_small():
    """N(T), mean(T), slope and hysteresis in 15 logs: 95 % less 3 standard errors. The study has 1000 logs."""
    hits = {"slope": 0, "mean": 0, "hysteresis": 0, "walk": 0}
    sets, walks, temperature = 15, 0, ramp(14_400)
    for k in range(sets):
        record = log(f"covered {k}", temperature, rate=2.0, mean=(50.0, 5.0), loop=20.0, bias_instability="5 deg/h")
        result = calibrate_temperature(record, degree=1)["gyro_x"]
        polynomial = result.polynomial
        level = float(noise(f"covered {k}", 14_400, 2.0, bias_instability="5 deg/h")["gyro_x"].mean())
        hits["slope"] += abs(polynomial.coefficients[1] - 5 * DEG_H) <= polynomial.errors[1]
        hits["mean"] += abs(polynomial.coefficients[0] - 50 * DEG_H - level) <= polynomial.errors[0]
        hits["hysteresis"] += result.hysteresis.low[2] <= 20 * DEG_H <= result.hysteresis.high[2]
        for window in result.windows:
            walk = window.terms.get("random_walk")
            if walk is not None and walk.value is not None:
                walks += 1
                hits["walk"] += walk.low <= 0.3 * np.pi / 180 / 60 <= walk.high
    for name, count in hits.items():
        total = walks if name == "walk" else sets
        assert count / total >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / total), name
    assert walks > sets


def test_the_page_has_the_parameters_of_autopilots(tmp_path):
    record = log("page", ramp(7_200), rate=1.0, channels=AXES[:3])
    temperature_report(calibrate_temperature(record, degree=1), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "TC_G0_X3_0" in page
    assert "INS_TCAL1_GYR1_X" in page
    with pytest.raises(OptionError, match=r"html or \.pdf"):
        temperature_report(calibrate_temperature(record, degree=1), tmp_path / "page.png")


def test_the_page_on_paper(tmp_path, monkeypatch):
    """All texts of the page; a hostile name is text."""
    pytest.importorskip("typst", reason="a PDF needs typst")

    def typeset(template, values, **options):
        return pdf.typeset(template, values, **options, pretty=True)  # with text to read

    monkeypatch.setattr("sigmatau.lab.pages.temperature_pdf.typeset", typeset)
    result = calibrate_temperature(log("page", ramp(7_200), rate=1.0, channels=AXES[:3]), degree=1)
    temperature_report(result, tmp_path / "page.pdf", command='#image("x")')
    text = re.sub(r"[\s\u200b]", "", "".join(pages_of((tmp_path / "page.pdf").read_bytes())))
    for word in ("gyro_x", "Meandeg", "TC_G0_X3_0", "INS_TCAL1_GYR1_X", "Command#image("):
        assert word in text.replace("[", "").replace("]", ""), word
    assert text.count("Hysteresis") == 3
