"""Errors: their fields, their words in Python and on the command line, and that they cross processes."""

import pickle

import numpy as np
import pytest

import sigmatau as st
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError, StampError
from sigmatau.hints import Hint


def test_an_option_is_named_as_it_is_given():
    error = OptionError("{option} must be positive, not -1", option="tau_min")
    assert str(error) == "`tau_min` must be positive, not -1"
    assert error.for_command_line() == "--tau-min must be positive, not -1"
    assert str(OptionError("{nothing} of {'gyro': 1}")) == "{nothing} of {'gyro': 1}"


@pytest.mark.parametrize(
    ("name", "value", "key", "python", "typed"),
    [
        ("walk", None, None, "`walk`", "--rate-random-walk"),
        ("axes", "worst", None, '`axes="worst"`', "--axes worst"),
        ("horizon", 10, None, "`horizon=10`", "--horizon 10s"),
        ("walk", "horizon", "gyro", '`walk={"gyro": "horizon"}`', "--rate-random-walk gyro=horizon"),
        ("walk", "1e-6 m/s", "gyro", '`walk={"gyro": "1e-6 m/s"}`', '--rate-random-walk "gyro=1e-6 m/s"'),
    ],
)
def test_other_arguments(name, value, key, python, typed):
    error = OptionError(f"give {Hint(name, key, value)}, not {{option}}", option="name")
    assert str(error) == f"give {python}, not `name`"
    assert error.for_command_line() == f"give {typed}, not --name"


@pytest.mark.parametrize(
    ("error", "words", "reason"),
    [
        (DataError("is empty"), "logs: a.csv: is empty", "is empty"),
        (DataError("time ends", place="line 5"), "logs: a.csv, line 5: time ends", "line 5: time ends"),
        (DataError("ends", place="line 5").at("b.csv"), "logs: a.csv, b.csv, line 5: ends", "b.csv, line 5: ends"),
        (OptionError("{option} is wrong", option="rate"), "logs: a.csv: `rate` is wrong", "`rate` is wrong"),
    ],
)
def test_what_an_error_is_about(error, words, reason):
    assert str(error.about("a.csv").about("logs")) == words
    assert error.reason == reason


def test_another_option_is_named():
    error = OptionError("{option} must be positive, not -1", option="span").named("read_off_at", "gyro.random_walk")
    assert str(error) == "`read_off_at` gyro.random_walk must be positive, not -1"
    assert error.option == "read_off_at"


@pytest.mark.parametrize(
    "error",
    [
        OptionError("{option} is wrong", option="unit").about("a.csv").at("line 5").named("unit", "of gyro"),
        DataError("is empty"),
        StampError("have two values only"),
        RecordTooShortError("has 3 rows", need=4, got=3),
        NonFiniteError("is infinite", channel="gyro_x", index=7),
    ],
)
def test_errors_cross_processes(error):
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), vars(back)) == (type(error), str(error), vars(error))


@pytest.mark.parametrize(
    "call",
    [
        st.psd,
        st.check,
        lambda x: st.deviation(x, kind="hadamard"),
        lambda x: st.dynamic_allan(x, "gyro_x"),
        lambda x: st.cross_spectrum(x, "gyro_x", "gyro_y"),
        lambda x: st.fit_channel(x, "gyro_x"),
    ],
)
def test_an_array_in_place_of_a_record(call):
    with pytest.raises(TypeError, match=r"must be a Record.*not a ndarray.*Record.from_arrays\(rate=100, gyro_x=x\)"):
        call(np.zeros(100))
