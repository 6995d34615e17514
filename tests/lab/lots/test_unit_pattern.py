"""Expressions for the unit in a path: those that may run for hours are refused, those that people write are not."""

import time

import pytest

from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.unit_pattern import check_unit_pattern, unit_in_path

REFUSED = [
    "(a+)+$",
    "(a*)*b",
    "((a+)b?)*$",
    "(?:[^/]+)*(SN)$",
    "(a|a)*$",
    "(a|aa)+$",
    "([a-z]+){2,}x",
    "(a{1,5}){30}x",
    "(x+x+)+y",
    "(?P<unit>\\w+)+-",
    "a*a*a*a*a*(b)",
]
ACCEPTED = [
    ("(SN[0-9]+)", "SN7"),
    (r"(SN\d+)", "SN7"),
    ("unit(?:-| )?([0-9A-Z]+)", "42"),
    (r".*/(\w+)_\d+-\d+", "SN7"),
    ("(?P<unit>SN[0-9]{1,4})", "SN7"),
    (r"([^/]+)\.csv$", "SN7_2026-05-04 unit42"),
    ("(SN|sn)", "SN"),
    (r"\((x)\)+|(?:a\+)+|(SN7)", ""),
]


@pytest.mark.parametrize("text", REFUSED)
def test_refused(text):
    with pytest.raises(OptionError, match=r"repeats a repetition|repetitions"):
        check_unit_pattern(text)


@pytest.mark.parametrize(("text", "unit"), ACCEPTED)
def test_accepted(text, unit):
    check_unit_pattern(text)
    assert unit_in_path(text, "/lab/day 1/SN7_2026-05-04 unit42.csv") == unit


@pytest.mark.parametrize("text", ["folder", "log-folder", None])
def test_words(text):
    check_unit_pattern(text)


def test_a_word_of_other_commands_is_an_expression_without_a_group():
    with pytest.raises(OptionError, match="with a group"):
        check_unit_pattern("log-folder", words=("folder",))


@pytest.mark.parametrize("text", ["(a", "[", "(?P<1>a)", "(a)" + "(" * 1000])
def test_invalid(text):
    with pytest.raises(OptionError, match="must be folder, log-folder or a regular expression"):
        check_unit_pattern(text)


def test_a_long_path_is_refused_at_once():
    begun = time.process_time()
    with pytest.raises(DataError, match="1000 characters"):
        unit_in_path("(.*)(.*)(.*)(x)$", "a" * 100_000)
    assert time.process_time() - begun < 1
