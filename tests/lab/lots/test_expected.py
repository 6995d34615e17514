"""Expected units: by number, by name, and by a serial number inside a name."""

import pytest

from sigmatau.errors import OptionError
from sigmatau.lab.lots.expected import match_expected

DATED = ["SN1_2026-05-04.csv", "SN12_2026-05-04.csv", "SN3.csv.gz"]


def test_serial_numbers_inside_dated_names():
    matched = match_expected(DATED, ["SN1", "SN12", "SN3", "SN4"])
    assert matched.absent == ("SN4",)
    assert matched.listed == set(DATED)
    assert matched.inside


def test_names_of_files_need_no_search():
    matched = match_expected(DATED, ["SN3", "SN12_2026-05-04"])
    assert (matched.absent, matched.inside) == ((), False)
    assert matched.listed == {"SN3.csv.gz", "SN12_2026-05-04.csv"}


def test_a_word_in_two_names_matches_neither():
    matched = match_expected(["SN1_a.csv", "SN1_b.csv"], ["SN1"])
    assert matched.absent == ("SN1",)
    assert matched.listed == frozenset()


def test_a_day_is_not_a_serial_number():
    names = ["12_2026-05-07.csv", "13_2026-05-08.csv"]
    for expect in (["07", "12", "13"], ["12", "13", "07"]):
        assert match_expected(names, expect).absent == ("07",)


def test_a_longer_name_is_matched_first():
    for expect in (["SN7", "SN7-2", "SN8"], ["SN7-2", "SN8", "SN7"]):
        assert match_expected(["SN7-2_x", "SN8_x"], expect).absent == ("SN7",)


def test_numbers():
    assert match_expected(DATED, 5).absent == ("(missing 1)", "(missing 2)")
    assert match_expected(DATED, 2).surplus == 1
    assert match_expected(DATED, None).listed == set(DATED)


@pytest.mark.parametrize("expect", [0, True, 10**11, "SN1", ["SN1", ""], ["SN1", "SN1"]])
def test_errors(expect):
    with pytest.raises(OptionError):
        match_expected(DATED, expect)
