"""The words of the findings of a lot."""

import pytest

from sigmatau.hints import as_options, speaking
from sigmatau.lab.lots import lot_findings as kinds
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
    "no maximum in the specification; state one, or give --factor 1.5: gyro noise": kinds.NoMaximum(what="gyro noise"),
    "gyro noise: not in the result": kinds.NotMeasured(what="gyro noise"),
    "in the specification: not in the result": kinds.NotMeasured(),
    "no model fits, so that the errors are unknown": kinds.NoModel(),
    "no specification; give --spec SPEC.toml": kinds.NoSpecification(),
    "truncated? The record has 30 min, the lot 1 h": kinds.ShortRecord(ratio=0.5, length=1800.0),
    "sampled at 50 Hz, the lot at 100 Hz": kinds.OtherRate(rate=50.0, rate_of_lot=100.0),
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
