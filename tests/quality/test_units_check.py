"""Units by gravity, by noise and by the steps that sensors are known for."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, allan, analyze, check, read
from sigmatau.hints import Hint
from sigmatau.noise.terms import TERMS
from sigmatau.quality.samples.units import gravity, implausible_unit

G = 9.80665
# Up, tilted, and with the biases of a cheap sensor.
ATTITUDES = [(0.0, 0.0, 1.0), (0.6, 0.0, -0.8), (0.5, 0.5, 0.70710678)]


def triad(name, mean, noise=0.01, n=5000):
    return np.random.default_rng(seed_of(name)).normal(size=(n, 3)) * noise + np.asarray(mean)


@pytest.mark.parametrize("attitude", ATTITUDES)
@pytest.mark.parametrize(
    ("truth", "stated", "factor"),
    [
        ("g", "m/s^2", 1 / G),
        ("m/s^2", "g", G),
        ("mg", "m/s^2", 1000 / G),
        ("mg", "g", 1000),
        ("ft/s^2", "m/s^2", 1 / 0.3048),
    ],
)
def test_gravity_tells_the_unit(truth, stated, factor, attitude):
    """And the factor is that by which the Allan deviation is wrong."""
    numbers = triad(f"gravity {truth}", attitude) * {"g": 1, "m/s^2": G, "mg": 1000, "ft/s^2": G / 0.3048}[truth]
    right = Record.from_arrays(rate=100, unit={"accel": truth}, accel=numbers)
    wrong = Record.from_arrays(rate=100, unit={"accel": stated}, accel=numbers)
    assert implausible_unit(right.streams[0]) == gravity(right.streams[0]) == []
    (finding,) = implausible_unit(wrong.streams[0])
    assert (finding.details.stated, finding.details.likely) == (stated, truth)
    assert finding.channels == wrong.streams[0].channels
    assert finding.severity == "warning"
    assert gravity(wrong.streams[0]) == []
    changes = dict(finding.factors)
    assert set(changes) == set(TERMS)
    assert set(changes.values()) == {changes["random_walk"]}
    measured = allan(wrong, taus=[0.1])["accel_x"].adev[0] / allan(right, taus=[0.1])["accel_x"].adev[0]
    assert changes["random_walk"] == pytest.approx(factor, rel=1e-9)
    assert float(measured) == pytest.approx(factor, rel=1e-9)


def test_remedies_are_options_there_are():
    """cm/s² has no unit of its own here."""
    (finding,) = implausible_unit(Record.from_arrays(rate=100, accel=triad("cm", (0, 0, 980.0))).streams[0])
    assert finding.details.correction == Hint("unit", "accel", "cm/s^2")
    assert implausible_unit(Record.from_arrays(rate=100, accel=0.01 * triad("cm", (0, 0, 980.0))).streams[0]) == []


def test_bias_is_information_and_absurd_levels_are_not():
    (finding,) = gravity(Record.from_arrays(rate=100, accel=triad("bias", (0, 0, 10.2))).streams[0])
    assert (finding.code, finding.severity, finding.details.cause) == ("gravity", "info", "bias_or_scale")
    (finding,) = gravity(Record.from_arrays(rate=100, accel=triad("none", (0, 0, 0.02))).streams[0])
    assert finding.severity == "info"
    assert finding.details.cause == "removed"
    (finding,) = gravity(Record.from_arrays(rate=100, accel=triad("absurd", (0, 0, 4.0))).streams[0])
    assert finding.severity == "warning"
    assert dict(finding.factors) == pytest.approx(dict.fromkeys(TERMS, 4.0 / 9.80665), rel=1e-3)
    assert gravity(Record.from_arrays(rate=100, accel_x=np.ones(100) * 4).streams[0]) == []  # one axis may lie


def test_raw_counts_named_g_are_not_to_be_trusted():
    """16384 counts are 1 g: no mistaken unit explains them, and all coefficients are wrong by their number."""
    counts = np.random.default_rng(1).normal((0, 0, 16384.0), 16.0, (6000, 3))
    analysis = analyze(Record.from_arrays(rate=100, accel=counts, unit={"accel": "g"}))
    assert [one.code for one in analysis.findings] == ["gravity"]
    assert set(analysis.columns()["trust"]) == {"poor"}


@pytest.mark.parametrize("sensitivity", [131.0, 65.5, 16.4, 16.384, 1000 / 8.75])
@pytest.mark.parametrize(("truth", "stated"), [("deg/s", "rad/s"), ("rad/s", "deg/s")])
def test_a_known_step_tells_the_unit(sensitivity, truth, stated):
    numbers = np.round(triad("counts", 3.0, 12.0)) / sensitivity
    if truth == "rad/s":
        numbers = np.deg2rad(numbers)
    assert implausible_unit(Record.from_arrays(rate=100, unit={"gyro": truth}, gyro=numbers).streams[0]) == []
    (finding,) = implausible_unit(Record.from_arrays(rate=100, unit={"gyro": stated}, gyro=numbers).streams[0])
    assert (finding.details.evidence, finding.details.likely, finding.details.stated) == ("step", truth, stated)


@pytest.mark.parametrize("sigma", [0.01, 0.0125, 0.02, 0.04])
def test_rounding_says_nothing_of_the_unit(sigma):
    """Steps of 0.1 deg/s that hide the noise: so little that it seemed that of an optical gyro, read in the wrong unit."""
    x = np.round(triad(f"coarse {sigma}", 0.3, sigma, 60_000), 1)
    for unit in ("deg/s", "rad/s"):
        assert implausible_unit(Record.from_arrays(rate=100, unit={"gyro": unit}, gyro=x).streams[0]) == []


@pytest.mark.parametrize("decimals", [1, 2, 3, 4, 5, 6])
def test_decimals_are_no_known_step(decimals):
    x = np.round(triad(f"decimals {decimals}", 0.0, 0.3), decimals)
    assert implausible_unit(Record.from_arrays(rate=100, unit={"gyro": "deg/s"}, gyro=x).streams[0]) == []


def test_a_step_one_percent_off_is_not_known():
    x = np.round(triad("one percent", 3.0, 12.0)) / 131 * 1.01
    assert implausible_unit(Record.from_arrays(rate=100, unit={"gyro": "deg/s"}, gyro=x).streams[0]) == []


@pytest.mark.parametrize("kind", ["rate", "increments"])
def test_a_rate_that_no_sensor_has_says_nothing_of_the_unit(kind):
    """Microseconds taken for seconds: noise densities are a thousand times too large, and no unit is to blame."""
    gyro, accel = triad(f"wrong rate {kind}", (0, 0, 0), 3e-3), triad(f"wrong rate too {kind}", (0, 0, G), 0.02)
    for rate in (1e-4, 1e8):
        record = Record.from_arrays(rate=rate, gyro=gyro, accel=accel, input=kind)
        assert [f for s in record.streams for f in (*implausible_unit(s), *gravity(s))] == []
    in_g = Record.from_arrays(rate=1e-4, accel=accel / G).streams[0]
    assert implausible_unit(in_g)[0].details.correction == Hint(
        "unit", "accel", "g"
    )  # a mean is what it is at any rate


@pytest.mark.parametrize("stated", [True, False])
def test_a_unit_that_the_file_states_outranks_a_guess(tmp_path, stated):
    """Noise of 19 times the noisiest gyros: the unit is doubted only if the user gave it."""
    rng = np.random.default_rng(seed_of("unit by the file"))
    log = tmp_path / "log.csv"
    header = "gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]" if stated else "gyro_x,gyro_y,gyro_z"
    np.savetxt(log, 3.3 * rng.standard_normal((6000, 3)), delimiter=",", header=header, comments="", fmt="%.9g")
    record = read(log, rate=100, unit={} if stated else {"gyro": "rad/s"})
    (finding,) = (f for f in check(record) if f.code == "implausible_unit")
    assert finding.details.by_file == stated
    assert finding.details.likely == ("" if stated else "deg/s")
    assert ("the file states rad/s" in finding.message) == stated
    assert bool(finding.factors) != stated


def test_identical_axes_are_not_called_correlated():
    rates = 1e-3 * np.random.default_rng(seed_of("read twice")).standard_normal((20_000, 3))
    rates[:, 1] = rates[:, 0]
    findings = check(Record.from_arrays(rate=100, gyro=rates))
    (finding,) = (f for f in findings if f.code in ("identical_axes", "correlated_axes"))
    assert (finding.code, finding.severity, finding.channels) == ("identical_axes", "warning", ("gyro_x", "gyro_y"))
    rates[7, 1] += 1e-9
    assert "identical_axes" not in {f.code for f in check(Record.from_arrays(rate=100, gyro=rates))}


@pytest.mark.parametrize(("rate", "codes"), [(0.0, []), (8.0, []), (12.0, ["mean_rate"]), (19.5, ["mean_rate"])])
def test_a_steady_rotation_is_told(rate, codes):
    """Of an axis between those of the gyro; 8 deg/s may be an offset."""
    rng = np.random.default_rng(seed_of(f"turning {rate}"))
    turning = np.radians(rate) * np.array([2.0, -1.0, 2.0]) / 3
    record = Record.from_arrays(rate=100, gyro=turning + 1e-3 * rng.standard_normal((6000, 3)))
    found = [one for one in check(record) if one.code == "mean_rate"]
    assert [one.code for one in found] == codes
    assert all(one.severity == "warning" and len(one.channels) == 3 for one in found)
    assert all(one.size == pytest.approx(np.radians(rate), rel=1e-3) for one in found)
