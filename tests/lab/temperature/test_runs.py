"""Runs at several temperatures: polynomial of a unit, and the matrix of several units."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import (
    Imperfections,
    NoiseModel,
    TemperatureRun,
    analyze,
    calibrate_over_runs,
    simulate,
    temperature_matrix,
    temperature_report,
)
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.temperature.over_runs import fit_runs


def result_at(name, bias, walk=1e-4):
    model = NoiseModel(channels={f"gyro_{axis}": {"random_walk": walk} for axis in "xyz"})
    level = Imperfections(level={f"gyro_{axis}": bias for axis in "xyz"})
    return analyze(simulate(model, duration=120, rate=10, rng=seed_of(name), imperfections=level))


@pytest.fixture(scope="module")
def runs():
    temperatures = (-40.0, -10.0, 20.0, 50.0, 80.0)
    return [
        TemperatureRun(name=f"run {t:g}", temperature=t, result=result_at(f"run {t}", 1e-3 + 2e-5 * t))
        for t in temperatures
    ]


def test_polynomial_of_runs(runs):
    result = calibrate_over_runs(runs[::-1], degree=1, unit_name="SN7")
    polynomial = result["gyro_x"].polynomial
    assert polynomial.coefficients[1] == pytest.approx(2e-5, abs=polynomial.errors[1])
    assert polynomial.coefficients[0] == pytest.approx(1e-3 + 2e-5 * 25, abs=polynomial.errors[0])
    assert [window.temperature for window in result["gyro_x"].windows] == [-40, -10, 20, 50, 80]
    assert result["gyro_x"].run_spread > 0
    text = repr(result)
    assert "5 runs" in text
    assert "run -40" in text
    assert "direction of the runs" in text
    assert result.plot().axes[0].get_title() == "gyro_x"


def test_students_t_of_few_runs():
    """Coverage of the slope of 5 runs with a turn-on bias: 95 % within 3 standard errors of 600 sets."""
    rng = np.random.default_rng(seed_of("runs at temperatures"))
    t, hits, sets = np.linspace(-40, 85, 5), 0, 600
    for _ in range(sets):
        polynomial, spread = fit_runs(
            t, 1e-5 * t + 1e-4 * rng.normal(size=5), degree=1, reference=25.0, level=0.95, unit="rad/s"
        )
        assert spread > 0
        hits += abs(polynomial.coefficients[1] - 1e-5) <= polynomial.errors[1]
    assert hits / sets == pytest.approx(0.95, abs=3 * np.sqrt(0.95 * 0.05 / sets))


def test_refusals(runs):
    with pytest.raises(DataError, match="Add runs"):
        calibrate_over_runs(runs[:3], degree=2)
    with pytest.raises(DataError, match="5 K apart"):
        calibrate_over_runs([TemperatureRun(name=f"{k}", temperature=20 + k, result=runs[0].result) for k in range(4)])
    with pytest.raises(OptionError, match="outside"):
        calibrate_over_runs(runs, reference=100.0)
    with pytest.raises(OptionError, match="1 to 5"):
        calibrate_over_runs(runs, degree=9)
    with pytest.raises(OptionError, match=r"0\.5"):
        calibrate_over_runs(runs, level=0.3)
    with pytest.raises(DataError, match="no run"):
        calibrate_over_runs([])


def test_matrix_of_units(tmp_path):
    results = [
        (f"SN{k}", t, result_at(f"matrix {k} {t}", 1e-4, walk=1e-4 * (1 + k / 20) * factor))
        for k in (2, 10, 1)
        for t, factor in ((-40.0, 0.5), (25.0, 1.0), (84.0, 2.0), (86.0, 2.0))
    ]
    matrix = temperature_matrix(results)
    assert matrix.units == ("SN1", "SN2", "SN10")
    assert matrix.temperatures == (-40.0, 25.0, 85.0)
    walk, *_ = matrix.tables()
    assert walk.title == "gyro random walk"
    assert (walk.values[:, 0] < walk.values[:, 1]).all()
    assert (walk.values[:, 1] < walk.values[:, 2]).all()
    rows = matrix.columns()
    assert set(rows["temperature_degc"]) == {-40.0, 25.0, 85.0}
    assert "SN10" in repr(matrix)
    assert len(matrix.plot().axes) == len(list(matrix.tables()))
    temperature_report(matrix, tmp_path / "matrix.html")
    page = (tmp_path / "matrix.html").read_text()
    assert "3 units at -40, 25, 85 °C" in page
    assert page.count("<svg") == len(list(matrix.tables()))
    pytest.importorskip("typst", reason="a PDF needs typst")
    temperature_report(matrix, tmp_path / "matrix.pdf")
    assert (tmp_path / "matrix.pdf").read_bytes().startswith(b"%PDF")


def test_no_result():
    with pytest.raises(DataError, match="no result"):
        temperature_matrix([])
