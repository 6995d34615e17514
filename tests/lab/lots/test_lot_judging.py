"""`judge_lot`: states, reasons and the exit code, from results in memory."""

import json
import math
import re

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from lot_logs import NAMES, RATE, SPEC, rates
from sigmatau.lab.lots.lot_findings import difference
from sigmatau.lab.lots.lot_remark import STATES


def analysed(x, names=NAMES, rate=RATE):
    units = {"gyro": "rad/s", "accel": "m/s^2"}
    parts = {s: x[:, [names.index(f"{s}_{a}") for a in "xyz"]] for s in units}
    return json.loads(json.dumps(st.analyze(st.Record.from_arrays(rate=rate, unit=units, **parts)).to_dict()))


@pytest.fixture(scope="module")
def units():
    return {f"u{k}": analysed(rates(k, kind="judged")) for k in (1, 2, 3, 4)}


@pytest.fixture(scope="module")
def bad():
    return analysed(6 * (rates(7, kind="judged") - [0, 0, 0, 0, 0, 9.80665]) + [0, 0, 0, 0, 0, 9.80665])


@pytest.fixture
def sheet(tmp_path):
    def write(text=SPEC):
        path = tmp_path / "spec.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def one_sheet(body):
    return f'name = "S"\nmaker = "M"\nsource = "here"\n{body}'


def test_all_pass(units, sheet):
    lot = st.judge_lot(units, sheet(), expect=4)
    assert [one.state for one in lot.units] == ["passed"] * 4
    assert lot.exit_code == 0
    assert repr(lot).startswith("4 units against Unit 7: 4 passed\n")


def test_lines_that_were_read_off_are_not_judged(units, sheet):
    """Their δ by eq. (26) is not a standard error, and they have no interval."""
    x = rates(1, kind="judged")
    record = st.Record.from_arrays(rate=RATE, **{name: x[:, k] for k, name in enumerate(NAMES)})
    lot = st.judge_lot({"lines": st.analyze(record, method="read-off"), **units}, sheet())
    assert lot["lines"].state == "unreadable"
    assert lot.counts["passed"] == 4
    assert "only read off; a model needs a fit" in repr(lot)
    assert lot.exit_code == 4
    alone = st.judge_lot({"lines": st.analyze(record, method="read-off")})
    assert {row for row in alone.columns()["coefficient"] if row and not row.startswith("means")} == set()


def test_every_unit_is_exactly_one(units, bad, sheet):
    given = units | {"bad": bad, "torn": st.DataError("torn.csv: is empty")}
    lot = st.judge_lot(given, sheet(), expect=8)
    assert lot.counts == {"failed": 1, "not_judged": 0, "unreadable": 1, "missing": 2, "passed": 4}
    assert sum(lot.counts.values()) == len(lot.units) == 8
    assert {one.state for one in lot.units} <= set(STATES)
    assert lot["bad"].state == "failed"
    assert lot["bad"].reasons[0].code == "above_maximum"
    assert lot["bad"].reasons[0].details.ratio == pytest.approx(6 * 0.103 / 0.16, rel=0.2)
    assert lot.exit_code == 3


def test_a_failed_unit_precedes_one_that_is_not_judged(units, bad, sheet):
    assert st.judge_lot({"bad": bad}, sheet()).exit_code == 3
    assert st.judge_lot(units, sheet(), expect=5).exit_code == 4
    assert st.judge_lot(units, sheet(), expect=3).exit_code == 4
    assert "1 more than the 3 expected" in repr(st.judge_lot(units, sheet(), expect=3))


def test_no_sheet_of_the_library_passes_whom_it_cannot_judge(units):
    """A good unit beside each sheet: passed only where each number of the sheet has a maximum."""
    for name, sheet in st.list_datasheets().items():
        lot = st.judge_lot({"u": units["u1"]}, sheet)
        judgeable = bool(sheet.claims) and all(claim.maximum is not None for claim in sheet.claims)
        assert lot.units[0].state != "passed" or judgeable, name
        if not judgeable:
            assert lot.exit_code in (3, 4), name
            assert lot.units[0].reason, name


def test_typical_values_need_a_factor(units, sheet):
    text = one_sheet('[gyro]\nrandom_walk = { typical = "0.1 deg/sqrt(h)" }\n')
    lot = st.judge_lot(units, sheet(text))
    assert lot.exit_code == 4
    (remark,) = lot["u1"].reasons
    assert (remark.code, remark.details.what) == ("no_maximum", "gyro angle random walk")
    assert "`factor=1.5`" in lot["u1"].reason
    assert st.judge_lot(units, sheet(text), factor=1.5).exit_code == 0
    assert st.judge_lot(units, sheet(text), factor=1.0).exit_code in (3, 4)


def test_one_sigma_is_judged_like_a_typical_value(units, sheet):
    text = one_sheet('[gyro]\nrandom_walk = { one_sigma = "0.1 deg/sqrt(h)" }\n')
    assert st.judge_lot(units, sheet(text)).exit_code == 4
    assert st.judge_lot(units, sheet(text), factor=3).exit_code == 0
    assert "1 σ 0.1" in repr(st.compare_with(st.Analysis.from_dict(units["u1"]), sheet(text)))


def test_bias_stability_is_the_std_of_means(units, sheet):
    """10 s means of N = 0.1 deg/√h: 0.1 · 60 / √10 = 1.9 deg/h, and 0.6 deg/h of 100 s means, which are six."""
    maximum = '[gyro]\nbias_stability = {{ maximum = "{} deg/h", average = "{} s" }}\n'
    white = 0.103 * 60 / math.sqrt(10)
    assert st.judge_lot(units, sheet(one_sheet(maximum.format(1.5 * white, 10)))).exit_code == 0
    assert st.judge_lot(units, sheet(one_sheet(maximum.format(0.6 * white, 10)))).exit_code == 3
    lot = st.judge_lot(units, sheet(one_sheet(maximum.format(5, 100))))
    assert lot["u1"].state == "not_judged"
    assert lot["u1"].reasons[0].code == "not_measured"


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('bias_stability = { maximum = "1 deg/h" }', 'needs average = "10 s"'),
        ('bias_stability = { maximum = "1 deg/h", average = "7 s" }', "average = '7 s'"),
        ('bias_stability = { average = "10 s" }', "neither typical nor maximum"),
        ('random_walk = { typical = "1 deg/sqrt(h)", one_sigma = "1 deg/sqrt(h)" }', "typical and one_sigma"),
        ('random_walk = { maximum = "1 deg/sqrt(h)", average = "10 s" }', "unknown key 'average'"),
        (
            'bias_stability = [{ maximum = "1 deg/h", average = "10 s" }, { maximum = "2 deg/h", average = "10 s" }]',
            "the same average",
        ),
    ],
)
def test_keys_of_a_sheet_that_are_wrong(body, words, sheet):
    with pytest.raises(st.DataError, match=words):
        st.datasheet(sheet(one_sheet(f"[gyro]\n{body}\n")))


def test_undecided(units, sheet):
    """A maximum at the measured value: the interval contains it."""
    walk = (
        st.compare_with(st.Analysis.from_dict(units["u1"]), st.datasheet(sheet())).judged[0].readings[0].measured.value
    )
    text = one_sheet(f'[gyro_x]\nrandom_walk = {{ maximum = "{walk!r} rad/sqrt(s)" }}\n')
    alone = {"u1": units["u1"]}
    for choice, code in (("not-judged", 4), ("pass", 0), ("fail", 3)):
        lot = st.judge_lot(alone, sheet(text), undecided=choice)
        assert lot.exit_code == code, choice
        assert any(remark.code == "undecided" for remark in lot.units[0].remarks)


def test_below_the_maximum_in_every_convention(units, sheet):
    """A density of an unknown convention, of which one is above the typical value and both are below the maximum."""
    walk = (
        st.compare_with(st.Analysis.from_dict(units["u1"]), st.datasheet(sheet())).judged[0].readings[0].measured.value
    )
    typical, maximum = f"{1.2 * walk!r} rad/s/sqrt(Hz)", f"{3 * walk!r} rad/s/sqrt(Hz)"
    claim = f'noise_density = {{ typical = "{typical}", maximum = "{maximum}", sided = "unknown" }}'
    lot = st.judge_lot({"u1": units["u1"]}, sheet(one_sheet(f"[gyro_x]\n{claim}\n")))
    assert lot.units[0].verdict.judged[0].status == "undecided"  # beside the typical value
    assert lot.units[0].state == "passed"
    # Between the conventions the maximum decides, and does not.
    maximum = f"{1.2 * walk!r} rad/s/sqrt(Hz)"
    claim = f'noise_density = {{ maximum = "{maximum}", sided = "unknown" }}'
    lot = st.judge_lot({"u1": units["u1"]}, sheet(one_sheet(f"[gyro_x]\n{claim}\n")))
    assert lot.units[0].state == "not_judged"
    assert "`sided=" in lot.units[0].reason


def at_the_maximum(result, limit, rng, channels):
    """The result with random walks that are exactly at a limit in truth, with their errors; the others far below."""
    found = json.loads(json.dumps(result))
    for name, channel in found["channels"].items():
        value = limit * (math.exp(0.05 * rng.standard_normal()) if name in channels else 0.5)
        term = channel["fit"]["terms"]["random_walk"]
        term |= {"value": value, "low": value * math.exp(-1.96 * 0.05), "high": value * math.exp(1.96 * 0.05)}
        channel["fit"]["model"]["random_walk"] = value
    return found


def test_a_value_exactly_at_its_maximum(units, sheet):
    """It fails and passes in 5 % of 80 records each at most, with ± 3 standard errors of the count."""
    rng = np.random.default_rng(seed_of("a value exactly at its maximum"))
    limit = 0.4 * math.pi / 180 / 60
    path = sheet(one_sheet('[gyro]\nrandom_walk = { maximum = "0.4 deg/sqrt(h)" }\n'))
    states = [
        st.judge_lot({"u": at_the_maximum(units["u1"], limit, rng, {"gyro_x"})}, path).units[0].state for _ in range(80)
    ]
    most = 80 * 0.05 + 3 * math.sqrt(80 * 0.05 * 0.95)
    assert 0 < states.count("failed") <= most
    assert 0 < states.count("passed") <= most


def test_an_implausible_value_is_said(units, sheet):
    """57.3 times below the typical value of the sheet, which has a maximum that it meets."""
    low = 0.103 * 57.3
    body = f'[gyro]\nrandom_walk = {{ typical = "{low} deg/sqrt(h)", maximum = "{2 * low} deg/sqrt(h)" }}\n'
    lot = st.judge_lot({"u1": units["u1"]}, sheet(one_sheet(body)))
    assert lot.units[0].state == "not_judged"
    (remark,) = lot.units[0].reasons
    assert remark.code == "implausible_value"
    assert 1 / remark.details.ratio == pytest.approx(57.3, rel=0.15)  # units differ by 4 %
    assert re.search(r"is 1/\d\d of the typical value", lot.units[0].reason)
    assert st.judge_lot({"u1": units["u1"]}, sheet(one_sheet(body)), accept=["implausible_value"]).exit_code == 0


def test_without_a_specification(units, bad):
    lot = st.judge_lot(units)
    assert {one.state for one in lot.units} == {"not_judged"}
    assert lot.exit_code == 4
    assert '4 units: nothing found. Give `spec="SPEC.toml"` to judge them.' in repr(lot)
    lot = st.judge_lot(units | {"bad": bad})
    assert lot.exit_code == 4
    assert "4 units: nothing found." in repr(lot)
    assert lot["bad"].reasons[0].code == "other_scale"
    assert lot["bad"].reasons[0].details.ratio == pytest.approx(6, rel=0.15)


def test_the_same_data_twice(units, sheet):
    lot = st.judge_lot({**units, "copy": units["u2"]}, sheet())
    assert [one.name for one in lot.of("not_judged")] == ["u2", "copy"]
    assert lot["copy"].reasons[0].code == "same_data"
    assert lot["copy"].reason == "the data are those of u2; log this unit again"


def test_other_axes_and_rates(units, sheet):
    fewer = json.loads(json.dumps(units["u1"]))
    for name in ("accel_x", "accel_y", "accel_z"):
        del fewer["channels"][name]
    faster = analysed(rates(9, kind="judged"), rate=2 * RATE)
    lot = st.judge_lot({**units, "fewer": fewer, "faster": faster}, sheet())
    assert {remark.code for remark in lot["fewer"].reasons} >= {"not_measured", "other_axes"}
    codes = {remark.code for remark in lot["faster"].reasons}
    assert "other_condition" in codes
    assert lot.exit_code == 4


def test_a_unit_that_moved(units, sheet):
    moving = json.loads(json.dumps(units["u1"]))
    moving["rest"]["verdict"] = "not_at_rest"
    for channel in moving["channels"].values():
        del channel["fit"]
        del channel["mean_stability"]
    others = {name: one for name, one in units.items() if name != "u1"}  # whose data it has
    lot = st.judge_lot({**others, "moving": moving}, sheet())
    assert lot["moving"].state == "not_judged"
    assert lot["moving"].reasons[0].code == "not_at_rest"


def test_warnings_keep_a_unit_from_passing(units, sheet):
    content = json.loads(json.dumps(units["u1"]))
    finding = {
        "code": "spikes",
        "severity": "info",
        "channels": ["gyro_x"],
        "message": "3 spikes",
        "action": "",
        "details": {},
    }
    content["findings"].append(finding)
    given = {**units, "u1": content}
    lot = st.judge_lot(given, sheet())
    assert (lot["u1"].state, lot["u1"].reason) == ("not_judged", "gyro x: 3 spikes")
    assert st.judge_lot(given, sheet(), fail_on="warning").exit_code == 3
    assert st.judge_lot(given, sheet(), accept=["spikes"]).exit_code == 0


def test_expected_names(units, sheet):
    lot = st.judge_lot(
        {f"{name}.csv": one for name, one in units.items()}, sheet(), expect=["u1", "u2.csv", "u3", "u9"]
    )
    assert [one.name for one in lot.of("missing")] == ["u9"]
    assert lot["u4.csv"].reasons[0].code == "not_expected"
    assert lot.exit_code == 4


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"expect": 0}, "at least 1"),
        ({"expect": True}, "at least 1"),
        ({"expect": ["a", "a"]}, "names 'a' twice"),
        ({"undecided": "maybe"}, "`undecided` must be one of"),
        ({"fail_on": "info"}, "`fail_on` must be warning"),
        ({"accept": ["nonesuch"]}, "unknown code 'nonesuch'"),
        ({"accept": "spikes"}, "must be a list"),
        ({"level": 1.5}, "`level` must be"),
        ({"factor": 0.1}, "`factor` must be"),
    ],
)
def test_options_that_are_wrong(options, words, units, sheet):
    with pytest.raises(st.OptionError, match=words):
        st.judge_lot(units, sheet(), **options)


def test_no_units():
    with pytest.raises(st.OptionError, match="no units"):
        st.judge_lot({})
    assert st.judge_lot({}, expect=3).counts["missing"] == 3


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "1", True])
def test_results_that_are_damaged(value, units, sheet):
    content = json.loads(json.dumps(units["u1"]))
    content["channels"]["gyro_x"]["fit"]["terms"]["random_walk"]["value"] = value
    lot = st.judge_lot({**units, "u1": content, "none": {}, "list": {"channels": [1]}}, sheet())
    assert lot["u1"].state in ("unreadable", "not_judged")
    assert lot["none"].state == lot["list"].state == "unreadable"
    assert lot["u2"].state == "passed"
    assert lot.exit_code == 4
    json.dumps(lot.to_dict(), allow_nan=False)


def test_forms_of_the_result(units, bad, sheet):
    lot = st.judge_lot({**units, "bad": bad}, sheet(), expect=6)
    content = json.loads(json.dumps(lot.to_dict(), allow_nan=False))
    assert content["counts"] == lot.counts
    assert [one["name"] for one in content["units"]] == [*units, "bad", "(missing 1)"]
    columns = lot.columns()
    assert len({len(column) for column in columns.values()}) == 1
    assert set(columns["unit"]) == {*units, "bad", "(missing 1)"}
    figure = lot.plot("gyro_x", "accel_z")
    assert [place.get_title() for place in figure.axes if place.get_visible()] == ["gyro_x", "accel_z"]
    with pytest.raises(KeyError, match="no channel 'mag'"):
        lot.plot("mag")
    with pytest.raises(KeyError, match="no unit 'x'"):
        lot["x"]


def test_differences_are_told_in_per_cent_or_as_a_factor():
    assert [difference(x) for x in (1.0, 1.5, 0.9, 3.2, 0.1)] == [
        "0 % above", "50 % above", "10 % below", "3.2 times", "1/10 of",
    ]  # fmt: skip


class TestChangedResults:
    """A result that was changed by hand is a unit that failed to read, and no error of the lot."""

    @pytest.mark.parametrize(
        "damage",
        [
            {"findings": 5},
            {"findings": [7]},
            {"findings": [{"code": "spikes", "left_out": "many"}]},
            {"findings": [{"code": "spikes", "left_out": [1]}]},
            {"findings": [{"code": "spikes", "channels": 7}]},
            {"error": "boom"},
        ],
    )
    def test_its_findings_or_error(self, units, damage, sheet):
        lot = st.judge_lot({**units, "changed": units["u1"] | damage}, sheet())
        assert lot["changed"].state == "unreadable"
        assert lot.counts["passed"] == 4
