"""What counts as a proposal of a message: options as they stand, not examples of units, placeholders or alternatives."""

import pytest

from run import find_suggestion, merge_options, vary_answers


@pytest.mark.parametrize(
    ("message", "options"),
    [
        ("name them, e.g. by --channels gyro=2:4,accel=5:7", ("--channels", "gyro=2:4,accel=5:7")),
        ("has no unit of time; give --unit time=ms", ("--unit", "time=ms")),
        ("give --topic imu0 --rate 100.", ("--topic", "imu0", "--rate", "100")),
        ("column I has 0, 1: give --topic imu0 or --topic imu1", ("--topic", "imu0")),
        ("give e.g. --unit gyro=deg/s,accel=g --rate HZ", ()),
        ("give e.g. --unit gyro=deg/s,accel=g --unit time=s (or ms, us, ns)", ()),
        ("give --unit time=s (or ms, us, ns)", ()),
        ("name them: --channels time=N,gyro=N:N,accel=N:N", ()),
        ("whole numbers may be counts: then add --scale gyro=FACTOR --scale accel=FACTOR", ()),
        ("give --rate HZ, or name the column with --channels time=…", ()),
        ("choose one, e.g. --channels accel_x=4, and name all other channels to read", ()),
    ],
)
def test_proposals(message, options):
    assert find_suggestion(message) == options


def test_options_given_again_replace_the_earlier_ones_except_units():
    options = ("--channels", "time=2", "--unit", "gyro=deg/s")
    merged = merge_options(options, ("--channels", "time=1", "--unit", "time=s"))
    assert merged == ("--unit", "gyro=deg/s", "--channels", "time=1", "--unit", "time=s")


def test_answers_are_tried_without_units_that_the_file_has():
    answers = (("--channels", "time=1", "--unit", "gyro=deg/s,time=s"),)
    assert vary_answers(answers, ("--channels", "time=2")) == [
        ("--unit", "gyro=deg/s,time=s"),
        ("--unit", "gyro=deg/s"),
    ]
