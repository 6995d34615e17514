"""The result at a glance: its columns, its sides, and how far a channel is trusted."""

from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze, fit_channel
from sigmatau.digits import round_to_error
from sigmatau.findings.finding import Details, Finding, Findings
from sigmatau.findings.rates import RateMismatch, RateNotNominal
from sigmatau.findings.wording import causes
from sigmatau.fitting.noise_fit import Fits
from sigmatau.fitting.overview import COLUMNS, main_coefficients, overview, trust
from sigmatau.units import to_si


@pytest.fixture(scope="module")
def analysis():
    y = np.random.default_rng(seed_of("overview")).standard_normal((20_000, 6)) * 1e-3
    return analyze(Record.from_arrays(rate=100, gyro=y[:, :3], accel=y[:, 3:] + [0, 0, 9.81]))


def test_a_row_an_axis_in_80_columns(analysis):
    lines = overview(analysis.fits).splitlines()
    assert max(map(len, lines)) <= 80
    names = ["95", "[3.3", *(f"gyro_{a}" for a in "xyz"), "[3.3", *(f"accel_{a}" for a in "xyz")]
    assert [line.split()[0] for line in lines] == names
    assert lines[1].split() == ["[3.3", "min]", "deg/√h", "deg/h", "deg/h/√h"]
    assert lines[5].split() == ["[3.3", "min]", "m/s/√h", "µg", "m/s/h^{3/2}"]


def test_the_interval_is_that_of_the_fit(analysis):
    """1e-3 rad/s at 100 Hz is 1e-4 rad/√s, 0.344 deg/√h."""
    for channel, fitted in analysis.fits.items():
        walk = fitted["random_walk"]
        cells = next(line for line in overview(analysis.fits).splitlines() if line.startswith(channel)).split()
        unit = "deg/sqrt(h)" if channel.startswith("gyro") else "m/s/sqrt(h)"
        value, low, high = (getattr(walk, name) / walk.value * walk.to(unit) for name in ("value", "low", "high"))
        last = 10.0 ** -len(cells[1].partition(".")[2])
        assert float(cells[1]) == pytest.approx(value, abs=last)
        if cells[2] == "±":
            assert float(cells[3]) == pytest.approx(max(value - low, high - value), abs=last)
        else:
            assert float(cells[2].strip("[,")) == pytest.approx(low, abs=last)
            assert float(cells[3].strip("]")) == pytest.approx(high, abs=last)


def test_it_fits_a_narrow_terminal(analysis):
    """Each interval is below its value, and ± is beside a value only if its interval is symmetric."""
    lines = overview(analysis.fits, width=64).splitlines()
    assert max(map(len, lines)) <= 64
    assert lines[0].split() == ["95", "%", "random", "walk", "bias", "instab.", "rate", "walk", "trust"]
    for channel, fitted in analysis.fits.items():
        walk = fitted["random_walk"]
        value, interval, _ = fitted.texts("random_walk")[0]
        at = next(k for k, line in enumerate(lines) if line.startswith(channel))
        assert lines[at].split()[1] == value
        sides = sorted((walk.value - walk.low, walk.high - walk.value))
        if sides[1] > 1.1 * sides[0]:
            assert lines[at + 1].strip() == interval
        else:
            assert lines[at + 1].strip().startswith("± ")


def test_the_record_in_a_line(analysis):
    assert analysis.headline() == "6 axes at 100 Hz (given), 3.3 min, at rest"
    assert analysis.overview().splitlines()[0] == analysis.headline()
    y = np.random.default_rng(1).standard_normal((3000, 3)) * 1e-3 + np.sin(np.arange(3000) / 30)[:, None]
    moving = Record.from_arrays(rate=100, gyro=y)
    assert analyze(moving).headline().endswith("30 s, not at rest")
    assert analyze(moving).overview() == analyze(moving).headline()
    assert analyze(moving, at_rest=True).headline().endswith("30 s, taken as at rest")


@pytest.mark.parametrize(
    ("change", "severity", "channels", "factors", "said"),
    [
        ({}, "info", ("gyro_x",), (), "good"),
        ({}, "warning", ("gyro_y",), (), "good"),
        ({}, "warning", ("gyro_x", "gyro_y"), (), "partial"),
        ({}, "warning", (), (), "partial"),
        ({}, "warning", ("gyro_x",), (("random_walk", 1.4),), "partial"),
        ({}, "warning", ("gyro_x",), (("random_walk", 1.6),), "poor"),
        ({}, "warning", ("gyro_x",), (("rate_random_walk", 0.5),), "poor"),
        ({"verdict": "widened"}, "info", (), (), "partial"),
        ({"verdict": "widened", "p_value": 2e-6}, "info", (), (), "partial"),
        ({"verdict": "widened", "p_value": 5e-7}, "info", (), (), "poor"),
        ({"verdict": "descriptive"}, "info", (), (), "poor"),
    ],
)
def test_trust(analysis, change, severity, channels, factors, said):
    finding = Finding(details=Details(), severity=severity, channels=channels, factors=factors)
    fitted = replace(analysis.fits["gyro_x"], trust=None, **change)  # a trust that is stated stays
    assert trust(fitted, [finding], "gyro_x") == said
    again = replace(analysis, fits=Fits({"gyro_x": fitted}), findings=Findings([finding]))
    assert again["gyro_x"].trust == again.fits["gyro_x"].trust == said


def test_a_fit_alone_has_no_trust(analysis):
    """Its record was not checked."""
    y = np.random.default_rng(seed_of("trust of a fit")).standard_normal(2000)
    assert fit_channel(Record.from_arrays(rate=100, gyro_x=y), "gyro_x").trust is None
    assert {one["trust"] for one in analysis.to_dict()["channels"].values()} == {
        f.trust for f in analysis.fits.values()
    }


@pytest.mark.parametrize(("share", "blocks"), [(0.01, True), (0.2, False)])
def test_missing_samples_leave_trust_where_intervals_cover(share, blocks):
    """One warning, of missing samples; the 6 random walks are covered, at 95 % each all but 2 in 99.8 % of cases."""
    rng = np.random.default_rng(seed_of(f"trust, missing {share} {blocks}"))
    covered = 0
    for _ in range(2):
        y = rng.standard_normal((20_000, 3)) * 1e-3
        if blocks:
            for start in rng.integers(0, len(y) - 500, max(round(share * len(y) / 500), 1)):
                y[start : start + 500] = np.nan
        else:
            y[rng.random(len(y)) < share] = np.nan
        analysis = analyze(Record.from_arrays(rate=100, gyro=y))
        assert [one.code for one in analysis.findings if one.severity != "info"] == ["missing_values"]
        assert {trust(fitted, analysis.findings, name) for name, fitted in analysis.fits.items()} == {"good"}
        covered += sum(
            fitted["random_walk"].low <= 1e-4 <= fitted["random_walk"].high for fitted in analysis.fits.values()
        )
    assert covered >= 4
    lost = Finding(details=analysis.findings[0].details, severity="warning", channels=("gyro_x",), size=0.6 * len(y))
    assert trust(analysis.fits["gyro_x"], [lost], "gyro_x") == "partial"


def test_causes_are_one_line_a_kind_worst_first():
    def of(details, severity, channel, size):
        return Finding(details=details, severity=severity, channels=(channel,), size=size)

    rate = RateNotNominal(rate=99.0, nominal=100.0)
    findings = [
        of(rate, "warning", "gyro_x", 1.0),
        of(rate, "warning", "gyro_y", -3.0),
        of(rate, "info", "gyro_z", 9.0),
        of(RateMismatch(used=99.0, other=100.0), "error", "gyro_z", None),
    ]
    first, second, last = causes(findings, rest="--verbose")
    assert first.startswith("!! gyro z: ")
    assert second.startswith("! gyro y: ")
    assert second.endswith(" (also gyro x)")
    assert last == "· 1 more: rate not nominal; see --verbose"
    assert causes(findings[2:3], rest="--verbose") == ["· 1 more: rate not nominal; see --verbose"]
    assert causes(findings, max_kinds=1, rest="--verbose")[1:] == ["· 3 more: rate not nominal; see --verbose"]
    assert causes([], rest="--verbose") == []


def test_warnings_of_one_kind_are_apart_from_what_is_only_told():
    warning = Finding(
        details=RateNotNominal(rate=99.0, nominal=100.0), severity="warning", channels=("accel_y",), size=1.0
    )
    told = replace(warning, severity="info", channels=("gyro_x",), size=9.0, left_out=3)
    first, second = causes([warning, told], rest="--verbose")
    assert first.startswith("! accel y: ")
    assert second.startswith("· gyro x: ")


def test_every_axis_with_a_warning_is_named():
    """Of more kinds than there are lines, one that alone names an axis, in place of the last whose axes have others."""
    rate, other = RateNotNominal(rate=99.0, nominal=100.0), RateMismatch(used=99.0, other=100.0)
    third = RateMismatch(used=98.0, other=100.0)
    findings = [
        Finding(details=rate, severity="warning", channels=("gyro_x",)),
        Finding(details=other, severity="error", channels=("gyro_x",)),
        Finding(details=other, severity="warning", channels=("gyro_y",)),
    ]
    assert [line.split(":")[0] for line in causes(findings, max_kinds=2, rest="--verbose")] == [
        "!! gyro x",
        "! gyro y",
        "· 1 more",
    ]
    findings[2] = Finding(details=third, severity="warning", channels=("gyro_x",))
    assert [line.split(":")[0] for line in causes(findings, max_kinds=2, rest="--verbose")] == [
        "!! gyro x",
        "! gyro x",
        "· 1 more",
    ]


def test_the_overview_is_typed(analysis):
    """Each kind of coefficient, with the texts of the digits' rule, in the unit of the sensor."""
    seen = main_coefficients(analysis.fits, analysis.findings, terms=(*COLUMNS, "quantization"))
    assert (seen.level, [len(sensor.axes) for sensor in seen.sensors]) == (0.95, [3, 3])
    assert seen.grades == {fitted.trust for fitted in analysis.fits.values()}
    gyro = seen.sensors[0]
    assert (gyro.length, gyro.runs, gyro.units[0]) == ("3.3 min", 0, "deg/√h")
    for axis in gyro.axes:
        fitted = analysis.fits[axis.channel]
        walk = fitted["random_walk"]
        rounded = round_to_error(walk.value, walk.low, walk.high, size=to_si(1.0, "deg/sqrt(h)"))
        first = axis.coefficients[0]
        assert (first.kind, first.value, first.interval) == ("value", rounded.value, rounded.error_text)
        for term, each in zip(seen.terms, axis.coefficients, strict=True):
            is_limit = term in fitted and fitted[term].value is None
            assert (each.kind == "limit", each.value.startswith("below ")) == (is_limit, is_limit)
            assert bool(each.interval) == (each.kind == "value")


def test_a_fit_without_intervals_has_unknown_coefficients(analysis):
    fitted = replace(analysis.fits["gyro_x"], verdict="descriptive", trust=None)
    (sensor,) = main_coefficients({"gyro_x": fitted}).sensors
    assert {each.kind for each in sensor.axes[0].coefficients} == {"unknown"}
    assert sensor.axes[0].trust == "poor"
