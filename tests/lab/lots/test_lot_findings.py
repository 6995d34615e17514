"""The words of the findings of a lot."""

import pytest

from sigmatau.hints import as_options, speaking
from sigmatau.lab.lots import lot_findings as kinds
from sigmatau.lab.lots.axis_changes import AxisChange
from sigmatau.lab.lots.lot_remark import remark

VALUE = {"what": "angle random walk", "unit": "deg/√h", "factor": 0.5}
WORDS = {
    "angle random walk 3 deg/√h is 50 % above the maximum 2 deg/√h": kinds.AboveMaximum(
        value=1.5, limit=1.0, ratio=1.5, **VALUE
    ),
    "angle random walk is above the maximum 2 deg/√h": kinds.AboveMaximum(limit=1.0, **VALUE),
    "angle random walk 1.8 deg/√h: the interval contains the maximum 2 deg/√h; record longer": kinds.Undecided(
        value=0.9, limit=1.0, **VALUE
    ),
    "angle random walk is not observed: the interval contains the maximum 2 deg/√h; record longer": kinds.Undecided(
        limit=1.0, **VALUE
    ),
    "angle random walk: the datasheet does not state the convention; give --sided one or two": kinds.Undecided(
        convention="sided", **VALUE
    ),
    "implausible: angle random walk is 57 times the typical value of the specification; check unit and sensor": (
        kinds.ImplausibleValue(what="angle random walk", ratio=57.3, stated="typical")
    ),
    "outlier: angle random walk 3 deg/√h is 1/57 of the lot's median": kinds.Outlier(
        value=1.5, ratio=1 / 57.3, **VALUE
    ),
    "all curves are 6 times the lot's median": kinds.OtherScale(ratio=6.0),
    "wrong unit, deg/s read as rad/s? All curves are 57 times the lot's median": kinds.OtherScale(
        ratio=57.3, likely=("deg/s", "rad/s")
    ),
    "wrong scale: gravity is 25 % above the lot's median, the noise 22 % above it": kinds.OtherScale(
        ratio=1.22, gravity=1.25
    ),
    "scale or bias? Gravity is 3 % above the lot's median": kinds.OtherScale(ratio=1.0, gravity=1.03),
    "axes y and z exchanged, or mounted on its side, 90° about x: gravity is along +y, in the lot along +z": (
        kinds.Orientation(
            changes=(
                AxisChange(sources=(0, 2, 1), signs=(1, 1, 1)),
                AxisChange(sources=(0, 2, 1), signs=(1, 1, -1)),
            ),
            vertical=2,
            along="+y",
            along_lot="+z",
        )
    ),
    "turned by 180° about z: the means are those of other axes of the lot": kinds.Orientation(
        changes=(AxisChange(sources=(0, 1, 2), signs=(-1, -1, 1)),)
    ),
    "outlier: rate random walk 30 deg/h/√h; the Allan deviation at 61.4 s is 3.6 times the lot's median": kinds.SlowNoise(
        tau=61.44, ratio=3.6, what="rate random walk", value=15.0, unit="deg/h/√h", factor=0.5
    ),
    "slow noise: Allan deviation at 100 s is 3.6 times the lot's median": kinds.SlowNoise(tau=100.0, ratio=3.6),
    "outlier: mean 30.0 deg/h; the lot has 2.0 ± 1.0 deg/h": kinds.OtherMean(
        value=15.0, median=1.0, spread=0.5, unit="deg/h", factor=0.5
    ),
    "no maximum in the specification; state one, or give --factor 1.5: gyro noise": kinds.NoMaximum(what="gyro noise"),
    "gyro noise: not in the result": kinds.NotMeasured(what="gyro noise"),
    "in the specification: not in the result": kinds.NotMeasured(),
    "no model fits, so that the errors are unknown": kinds.NoModel(),
    "no specification; give --spec SPEC.toml": kinds.NoSpecification(),
    "truncated? The record has 30 min, the lot 1 h": kinds.ShortRecord(ratio=0.5, length=1800.0),
    "sampled at 50 Hz, the lot at 100 Hz; not compared with it": kinds.OtherCondition(
        factor="rate", value="at 50 Hz", value_of_lot="at 100 Hz"
    ),
    "the lot has units 4 at 50 Hz, 4 at 100 Hz, none compared with another; judge each group as a lot": kinds.MixedLot(
        factor="rate", groups=(("at 50 Hz", 4), ("at 100 Hz", 4))
    ),
    "the lot has 2 orientations: 6 with gravity along +z, 6 with gravity along −z; mount all alike": kinds.MixedLot(
        factor="orientation", groups=(("with gravity along +z", 6), ("with gravity along −z", 6))
    ),
    "channels differ from the lot: no gyro_z; also gyro_q": kinds.OtherAxes(lacking=("gyro_z",), extra=("gyro_q",)),
    "the data are those of u2; log this unit again": kinds.SameData(unit="u2"),
    "not on the list of expected units": kinds.NotExpected(),
    "not JSON": kinds.Unreadable(reason="not JSON"),
    "expected, but there is no file": kinds.Missing(),
}


@pytest.mark.parametrize("words", WORDS)
def test_words(words):
    told = remark(WORDS[words], "data", ("gyro_x", "gyro_y"))
    assert told.to_dict()["message"] == f"gyro x, y: {words}"
    with speaking(as_options):
        assert told.text == f"gyro x, y: {words}"


def test_each_kind_has_an_example():
    assert {type(one).code for one in WORDS.values()} == kinds.CODES


def test_json_has_the_numbers():
    content = remark(kinds.AboveMaximum(value=1.5, limit=1.0, ratio=1.5, **VALUE), "limit", ("gyro_x",)).to_dict()
    assert {key: content[key] for key in content if key != "message"} == {
        "code": "above_maximum",
        "kind": "limit",
        "channels": ["gyro_x"],
        "what": "angle random walk",
        "value": 1.5,
        "limit": 1.0,
        "ratio": 1.5,
    }
