"""Findings of every kind are the same behind JSON; those of another version keep their words."""

import json
from dataclasses import replace

import pytest
from test_words import SUBJECTS, examples

from sigmatau.decoding import WrongValueError, decode
from sigmatau.findings.decoding import FindingForm, decode_finding
from sigmatau.findings.finding import Finding, Stated


def read(content):
    return decode_finding(decode(FindingForm, json.loads(json.dumps(content))))


@pytest.mark.parametrize("subject", SUBJECTS)
def test_every_example_is_read_back(subject):
    for one in examples(subject):
        every = replace(one, spans=((1.0, 2.0),), more_spans=3, factors=(("random_walk", 1.5),), topic="/imu")
        back = read(every.to_dict())
        assert type(back.details) is type(one.details)
        assert back.to_dict() == every.to_dict()
        if json.dumps(one.to_dict()).count("null") == 0:
            assert replace(back, spans=one.spans, more_spans=0, factors=one.factors, topic=one.topic) == one


def test_what_this_version_does_not_know_keeps_its_words():
    (spikes, *_) = (one for one in examples("disturbances") if one.code == "spikes")
    for changed in ({"code": "wet_sensor"}, {"details": {"count": "three"}}, {"details": {}}):
        content = spikes.to_dict() | changed | {"message": "water in the sensor", "action": "Dry it"}
        back = read(content)
        assert isinstance(back.details, Stated)
        assert (back.code, back.message, back.action) == (content["code"], "water in the sensor", "Dry it")
        assert back.to_dict() == content
        assert hash(back) == hash(read(content))


def test_schema_1_names_one_channel():
    assert read({"code": "spikes", "channel": "gyro_x"}).channels == ("gyro_x",)


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        ({"severity": "fatal"}, "severity: 'fatal' is not info or warning or error"),
        ({"channels": "gyro_x"}, "channels: 'gyro_x' is not a list"),
        ({"spans_s": [[0.0]]}, r"spans_s\[0\]: \[0.0\] is not a list of 2"),
        ({"factors": {"random_walk": None}}, "factors.random_walk: None is not a number"),
        ({"details": 3}, "details: 3 is not an object"),
    ],
)
def test_a_damaged_finding_names_its_place(wrong, place):
    with pytest.raises(WrongValueError, match=place):
        read({"code": "spikes", **wrong})


def test_details_of_every_kind_are_hashable():
    for subject in SUBJECTS:
        assert all(isinstance(hash(read(one.to_dict())), int) for one in examples(subject) if isinstance(one, Finding))
